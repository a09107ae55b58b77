//! The field generator of a tracker: coils whose fields in the empty room are known.

use super::dipole::Dipole;
use super::square_loop::SquareLoop;
use nalgebra::{Matrix3, Point3, Unit, Vector3};
use trackwright_geometry::limits::{length_above_zero_problem, position_problem, short};

/// Fewest coils that can determine the five unknowns of a sensor with one axis.
pub const MIN_COILS: usize = 5;

/// Most coils. Readings keep their signals on the stack; published generators have 3 to 16 coils.
pub const MAX_COILS: usize = 32;

/// Coils in the tracker frame; strengths relative to each other, a common factor cancels.
#[derive(Clone, Debug, PartialEq)]
pub struct Generator {
    pub name: String,
    pub coils: Vec<Coil>,
}

/// One transmitting coil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coil {
    /// `B(p) = (3 r̂ (m·r̂) − m) / |r|³`, `r = p − at`, in mm⁻³ for a unit moment.
    Dipole { at_mm: Point3<f64>, moment: Vector3<f64> },
    /// Four straight segments, one pair of them along [`trackwright_geometry::rotation::perpendicular`]
    /// of the normal; far away the unit dipole along the normal.
    SquareLoop { center_mm: Point3<f64>, normal: Unit<Vector3<f64>>, side_mm: f64 },
}

/// Why coils are no generator.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeneratorError {
    #[error("{0} coils, expected {MIN_COILS} to {MAX_COILS}")]
    Coils(usize),
    /// Its index, the name of the value, what it is, and what was expected.
    #[error("coils[{coil}]: {field} is {found}, expected {expected}")]
    Coil { coil: usize, field: &'static str, found: String, expected: &'static str },
}

/// Names of the built-in generators, for [`Generator::built_in`].
pub const BUILT_IN: [&str; 2] = ["planar-nine", "anser"];

/// 35° above the plane, at azimuths of 0°, 80°, 160° and so on; the digits are those of the worked
/// cases.
const PLANAR_NINE_MOMENTS: [[f64; 3]; 9] = [
    [0.8191915683009983, 0.0, 0.5735199860724567],
    [0.1422511229955831, 0.8067462076650528, 0.5735199860724567],
    [-0.7697882717424834, 0.2801800176014869, 0.5735199860724567],
    [-0.4095957841504995, -0.7094407087146793, 0.5735199860724567],
    [0.6275371487469003, -0.5265661900635663, 0.5735199860724567],
    [0.6275371487469006, 0.526566190063566, 0.5735199860724567],
    [-0.4095957841504985, 0.70944070871468, 0.5735199860724567],
    [-0.7697882717424838, -0.28018001760148614, 0.5735199860724567],
    [0.14225112299558254, -0.8067462076650529, 0.5735199860724567],
];

/// Centres of Anser's loops in the plane z = 0, in mm.
const ANSER_CENTERS_MM: [[f64; 2]; 8] = [
    [-93.543, 93.543],
    [0.0, 68.55],
    [93.543, 93.543],
    [-68.55, 0.0],
    [68.55, 0.0],
    [-93.543, -93.543],
    [0.0, -68.55],
    [93.543, -93.543],
];

const ANSER_SIDE_MM: f64 = 70.0;

impl Generator {
    /// Nine dipoles on a square grid of 120 mm in the plane z = 0, the generator of the worked
    /// cases.
    pub fn planar_nine() -> Self {
        let at = |k: usize| 120.0 * (k as f64 - 1.0);
        let coils = PLANAR_NINE_MOMENTS.iter().enumerate();
        Self {
            name: "planar-nine".to_owned(),
            coils: coils
                .map(|(i, &moment)| Coil::Dipole {
                    at_mm: Point3::new(at(i / 3), at(i % 3), 0.0),
                    moment: moment.into(),
                })
                .collect(),
        }
    }

    /// The eight square loops of the open Anser EMT (Jaeger et al., Int. J. Computer Assisted
    /// Radiology and Surgery 12, 2017).
    pub fn anser() -> Self {
        let coils = ANSER_CENTERS_MM.iter();
        Self {
            name: "anser".to_owned(),
            coils: coils
                .map(|&[x, y]| Coil::SquareLoop {
                    center_mm: Point3::new(x, y, 0.0),
                    normal: Vector3::z_axis(),
                    side_mm: ANSER_SIDE_MM,
                })
                .collect(),
        }
    }

    /// A built-in generator by its name; `None` where none has it.
    pub fn built_in(name: &str) -> Option<Self> {
        match name {
            "planar-nine" => Some(Self::planar_nine()),
            "anser" => Some(Self::anser()),
            _ => None,
        }
    }

    /// The first reason why these coils are no generator.
    pub fn problem(&self) -> Option<GeneratorError> {
        let count = self.coils.len();
        if !(MIN_COILS..=MAX_COILS).contains(&count) {
            return Some(GeneratorError::Coils(count));
        }
        self.coils.iter().enumerate().find_map(|(index, coil)| {
            let (field, found, expected) = coil.problem()?;
            Some(GeneratorError::Coil { coil: index, field, found, expected })
        })
    }

    /// The field of every coil at a point.
    pub fn own_fields(&self, p: &Point3<f64>) -> Vec<Vector3<f64>> {
        let mut fields = vec![Vector3::zeros(); self.coils.len()];
        self.field(p, &mut fields);
        fields
    }

    /// Fields of all coils at a point of the tracker frame, in mm⁻³.
    ///
    /// # Panics
    /// If `out` has another length than the coils.
    pub fn field(&self, p: &Point3<f64>, out: &mut [Vector3<f64>]) {
        assert_eq!(out.len(), self.coils.len(), "one field a coil");
        for (coil, out) in self.coils.iter().zip(out) {
            *out = coil.field(p);
        }
    }

    /// Fields of all coils and their gradients, `gradient[(i, j)] = ∂B_i/∂p_j` in mm⁻⁴.
    ///
    /// # Panics
    /// If `out` has another length than the coils.
    pub fn field_and_gradient(&self, p: &Point3<f64>, out: &mut [(Vector3<f64>, Matrix3<f64>)]) {
        assert_eq!(out.len(), self.coils.len(), "one field a coil");
        for (coil, out) in self.coils.iter().zip(out) {
            *out = coil.field_and_gradient(p);
        }
    }
}

impl Coil {
    /// Field at a point of the tracker frame. Not finite at a dipole and on a loop's wire.
    #[inline]
    pub fn field(&self, p: &Point3<f64>) -> Vector3<f64> {
        match self {
            Self::Dipole { at_mm, moment } => Dipole::new(at_mm, moment).field(p),
            Self::SquareLoop { .. } => self.field_and_gradient(p).0,
        }
    }

    /// Field and its gradient `∂B_i/∂p_j`, which is symmetric and has no trace off the wires.
    #[inline]
    pub fn field_and_gradient(&self, p: &Point3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
        match self {
            Self::Dipole { at_mm, moment } => Dipole::new(at_mm, moment).field_and_gradient(p),
            Self::SquareLoop { center_mm, normal, side_mm } => {
                SquareLoop::new(center_mm, normal, *side_mm).field_and_gradient(p)
            }
        }
    }

    /// Corners of a loop, in order; `None` of a dipole.
    pub fn corners_mm(&self) -> Option<[Point3<f64>; 4]> {
        match self {
            Self::Dipole { .. } => None,
            Self::SquareLoop { center_mm, normal, side_mm } => {
                Some(SquareLoop::new(center_mm, normal, *side_mm).corners_mm)
            }
        }
    }

    /// Field and the gradient of what a coil with axis `n` measures of it.
    #[inline]
    pub fn field_and_signal_gradient(
        &self,
        p: &Point3<f64>,
        n: &Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        match self {
            Self::Dipole { at_mm, moment } => {
                Dipole::new(at_mm, moment).field_and_signal_gradient(p, n)
            }
            Self::SquareLoop { .. } => {
                let (field, gradient) = self.field_and_gradient(p);
                (field, gradient.tr_mul(n))
            }
        }
    }

    /// The first value that cannot be: its name, what it is, and what was expected.
    pub fn problem(&self) -> Option<(&'static str, String, &'static str)> {
        let point = |name, p: &Point3<f64>| {
            position_problem(&p.coords).map(|expected| (name, list(&p.coords), expected))
        };
        match self {
            Self::Dipole { at_mm, moment } => point("position", at_mm).or_else(|| {
                let norm = moment.norm();
                let is_fine = norm.is_finite() && norm > MIN_MOMENT;
                let expected = "a finite vector above zero";
                (!is_fine).then(|| ("moment", list(moment), expected))
            }),
            Self::SquareLoop { center_mm, normal, side_mm } => point("center", center_mm)
                .or_else(|| {
                    let is_unit = (normal.norm() - 1.0).abs() < 1e-6;
                    (!is_unit).then(|| ("normal", list(normal), "a direction"))
                })
                .or_else(|| {
                    length_above_zero_problem(*side_mm)
                        .map(|expected| ("side", short(*side_mm), expected))
                }),
        }
    }
}

/// Weakest dipole. Signals are weighted alike, so one this much weaker than the others has none
/// left in round-off, and one that small by itself underflows in squares.
const MIN_MOMENT: f64 = 1e-100;

fn list(v: &Vector3<f64>) -> String {
    format!("({}, {}, {})", short(v.x), short(v.y), short(v.z))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use serde_json::Value;

    /// The worked cases of the fields.
    pub(crate) fn physics() -> Value {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/golden/physics.json");
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
    }

    pub(crate) fn numbers(value: &Value) -> Vec<f64> {
        let all = value.as_array().unwrap();
        all.iter().map(|v| v.as_f64().unwrap()).collect()
    }

    pub(crate) fn vector(value: &Value) -> Vector3<f64> {
        Vector3::from_column_slice(&numbers(value))
    }

    pub(crate) fn point(value: &Value) -> Point3<f64> {
        vector(value).into()
    }

    fn generators() -> [Generator; 2] {
        [Generator::planar_nine(), Generator::anser()]
    }

    fn places() -> [Point3<f64>; 3] {
        [
            Point3::new(31.0, -52.0, -71.0),
            Point3::new(-180.0, 95.0, -240.0),
            Point3::new(12.0, 7.0, -520.0),
        ]
    }

    #[test]
    fn the_built_in_dipoles_are_the_worked_ones() {
        let golden = physics();
        let dipoles = golden["generator"]["dipoles"].as_array().unwrap();
        let built_in = Generator::planar_nine();
        assert_eq!(dipoles.len(), built_in.coils.len());
        for (coil, worked) in built_in.coils.iter().zip(dipoles) {
            let expected =
                Coil::Dipole { at_mm: point(&worked["at_mm"]), moment: vector(&worked["moment"]) };
            assert_eq!(*coil, expected);
        }
    }

    #[test]
    fn fields_are_the_worked_ones() {
        let generator = Generator::planar_nine();
        for case in physics()["field"].as_array().unwrap() {
            let mut field = vec![Vector3::zeros(); 9];
            generator.field(&point(&case["at_mm"]), &mut field);
            for (found, worked) in field.iter().zip(case["field"].as_array().unwrap()) {
                let worked = vector(worked);
                assert!((found - worked).norm() <= 1e-13 * worked.norm());
            }
        }
    }

    #[test]
    fn gradients_are_the_differences_of_fields() {
        let h = 1e-2;
        for generator in generators() {
            for p in places() {
                let mut both = vec![(Vector3::zeros(), Matrix3::zeros()); generator.coils.len()];
                generator.field_and_gradient(&p, &mut both);
                for (coil, (field, gradient)) in generator.coils.iter().zip(both) {
                    assert!((field - coil.field(&p)).norm() <= 1e-14 * field.norm());
                    for j in 0..3 {
                        let mut step = Vector3::zeros();
                        step[j] = h;
                        let slope = (coil.field(&(p + step)) - coil.field(&(p - step))) / (2.0 * h);
                        // Third derivatives are 60/r² of the first, times h²/6, at 70 mm.
                        let error = (slope - gradient.column(j)).norm();
                        assert!(error < 1e-6 * gradient.norm(), "{coil:?} {p} {error}");
                    }
                }
            }
        }
    }

    #[test]
    fn fields_have_no_sources_and_no_curl() {
        for generator in generators() {
            for p in places() {
                for coil in &generator.coils {
                    let (_, gradient) = coil.field_and_gradient(&p);
                    let scale = gradient.norm();
                    assert!(gradient.trace().abs() < 1e-11 * scale);
                    assert!((gradient - gradient.transpose()).norm() < 1e-11 * scale);
                }
            }
        }
    }

    #[test]
    fn a_loop_is_a_unit_dipole_far_away() {
        let normal = Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8));
        let center_mm = Point3::new(10.0, -20.0, 5.0);
        let square = Coil::SquareLoop { center_mm, normal, side_mm: 70.0 };
        let dipole = Coil::Dipole { at_mm: center_mm, moment: normal.into_inner() };
        let direction = Vector3::new(0.6, 0.64, -0.48);
        for (distance, tolerance) in [(700.0, 2e-2), (7_000.0, 2e-4), (70_000.0, 2e-6)] {
            let p = center_mm + direction * distance;
            let (field, gradient) = square.field_and_gradient(&p);
            let (far, far_gradient) = dipole.field_and_gradient(&p);
            // A square has no quadrupole: the next order falls with the square of side/distance.
            assert!((field - far).norm() < tolerance * far.norm());
            assert!((gradient - far_gradient).norm() < 2.0 * tolerance * far_gradient.norm());
        }
    }

    #[test]
    fn the_field_in_a_loops_middle_is_biot_savarts() {
        let square = Coil::SquareLoop {
            center_mm: Point3::origin(),
            normal: Vector3::z_axis(),
            side_mm: 2.0,
        };
        // 8 √2 I / side in units of µ0 I / 4π, over the loop's area.
        let expected = 8.0 * 2.0_f64.sqrt() / 2.0 / 4.0;
        let field = square.field(&Point3::origin());
        assert!((field - Vector3::z() * expected).norm() < 1e-14);
    }

    #[test]
    fn coils_that_cannot_be_are_refused() {
        assert_eq!(Generator::planar_nine().problem(), None);
        assert_eq!(Generator::anser().problem(), None);
        let mut generator = Generator::planar_nine();
        let mut error = |coil: Coil| {
            generator.coils[3] = coil;
            generator.problem().unwrap().to_string()
        };
        let dipole = |at: [f64; 3], moment: [f64; 3]| Coil::Dipole {
            at_mm: at.into(),
            moment: moment.into(),
        };
        let square = |normal: [f64; 3], side_mm| Coil::SquareLoop {
            center_mm: Point3::origin(),
            normal: Unit::new_unchecked(normal.into()),
            side_mm,
        };
        let up = [0.0, 0.0, 1.0];
        for (coil, message) in [
            (
                dipole([f64::NAN, 0.0, 1.0], up),
                "coils[3]: position is (NaN, 0, 1), expected finite numbers",
            ),
            (
                dipole([0.0; 3], [0.0; 3]),
                "coils[3]: moment is (0, 0, 0), expected a finite vector above zero",
            ),
            (
                dipole([0.0; 3], [f64::INFINITY, 0.0, 0.0]),
                "coils[3]: moment is (inf, 0, 0), expected a finite vector above zero",
            ),
            (square([0.0; 3], 1.0), "coils[3]: normal is (0, 0, 0), expected a direction"),
            (square(up, 0.0), "coils[3]: side is 0, expected a length above zero"),
            (square(up, f64::NAN), "coils[3]: side is NaN, expected a length above zero"),
        ] {
            assert_eq!(error(coil), message);
        }
        for count in [0, 4, MAX_COILS + 1] {
            generator.coils = vec![dipole([0.0; 3], up); count];
            assert_eq!(generator.problem(), Some(GeneratorError::Coils(count)));
        }
    }

    #[test]
    fn built_in_generators_are_found_by_name() {
        for name in BUILT_IN {
            assert_eq!(Generator::built_in(name).unwrap().name, name);
        }
        assert_eq!(Generator::built_in("Anser"), None);
    }
}
