//! Whether coils fit where they are: in the body that holds them, and beside each other.
//!
//! A coil is a cylinder of its stated size about its sensor's axis. One that lies wholly outside the
//! body or on its surface is mounted on it, which is as good as inside. Where the mesh encloses
//! nothing, nothing is stated about inside and outside; without a stated size nothing at all.
//!
//! The bore of a cannula is inside the body, also where the mesh has it: a point is in a bore where
//! the body has a wall all around the coil's axis, within the coil's length. Its limits: a bore that is
//! open along its side by more than a twenty-fourth of a turn is none, nor is one wider than twice the
//! coil's length; a narrow slot that a coil stands in counts as a bore.

mod near;

use super::axis_words::body_name;
use super::body::{Coil, Sensor};
use nalgebra::{Point3, Unit, Vector3};
use serde::Serialize;
use std::f64::consts::TAU;
use trackwright_geometry::rotation::perpendicular;
use trackwright_geometry::surface::{Ray, Surface};
use trackwright_result::{Section, data};

pub use near::{Nearby, coil_line_near, sticks_out_near};

/// Less is not reported: the facets of a round part stand off it by as much.
const LEAST_MM: f64 = 0.05;

/// Places along a coil and around it where it is held against the body. Half a millimetre along a
/// coil of 9 mm.
const STATIONS: u32 = 18;
const AROUND: u32 = 12;

/// The middle line of a coil that lies on a surface may dip into it: by a part of the coil's radius,
/// as in a groove or on a waist, and by a part of the way that it is inside, so that it runs along the
/// surface and not through a wall.
const MOST_DIP_RADII: f64 = 0.5;
const MOST_DIP_SLOPE: f64 = 0.1;

/// Between two directions in which a bore's wall is looked for.
const ACROSS_RAD: f64 = TAU / trackwright_geometry::surface::BORE_DIRECTIONS as f64;

/// A coil that does not fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoilFinding {
    /// `tool` or `crf`.
    pub body: &'static str,
    /// Its number in the body.
    #[serde(skip)]
    pub index: usize,
    pub sensor: String,
    #[serde(flatten)]
    pub misfit: CoilMisfit,
}

/// How a coil does not fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CoilMisfit {
    /// It is partly in the body, and its farthest point is so far outside.
    SticksOut { by_mm: f64 },
    /// It and another coil of the body are in one place; they would have to be moved apart by this
    /// at the least.
    Overlaps {
        #[serde(skip)]
        index: usize,
        other: String,
        by_mm: f64,
    },
}

impl CoilFinding {
    /// For a list beside the sensor's name.
    pub fn words(&self) -> String {
        match &self.misfit {
            CoilMisfit::SticksOut { by_mm } => format!("sticks out by {by_mm:.1} mm"),
            CoilMisfit::Overlaps { by_mm, .. } => format!("overlaps by {by_mm:.1} mm"),
        }
    }

    /// One sentence without a full stop.
    pub fn statement(&self) -> String {
        let body = body_name(self.body);
        let own = format!("the coil of the {body}'s sensor {}", self.sensor);
        match &self.misfit {
            CoilMisfit::SticksOut { by_mm } => {
                format!("{own} does not fit: it sticks out of the body by {by_mm:.1} mm")
            }
            CoilMisfit::Overlaps { other, by_mm, .. } => {
                format!("{own} overlaps with that of {other} by {by_mm:.1} mm")
            }
        }
    }
}

/// The findings as statements, what two coils have in common once.
pub fn coil_statements(findings: &[CoilFinding]) -> Vec<String> {
    let is_first = |finding: &&CoilFinding| match &finding.misfit {
        CoilMisfit::SticksOut { .. } => true,
        CoilMisfit::Overlaps { index, .. } => finding.index < *index,
    };
    findings.iter().filter(is_first).map(CoilFinding::statement).collect()
}

/// The findings as a result; nothing where there are none.
pub fn coil_section(findings: &[CoilFinding]) -> Section {
    let rows = (!findings.is_empty()).then(|| data("coils", findings));
    Section::of(rows).with_all(coil_statements(findings)).below(0)
}

/// What is wrong with where the coils of a body are, sensor by sensor; `surface` is the body's, where
/// it has a mesh.
pub fn coil_findings(
    body: &'static str,
    sensors: &[Sensor],
    surface: Option<&Surface>,
) -> Vec<CoilFinding> {
    let mut findings = Vec::new();
    for (index, sensor) in sensors.iter().enumerate() {
        let mut push = |misfit| {
            findings.push(CoilFinding { body, index, sensor: sensor.name.clone(), misfit });
        };
        if let Some(by_mm) = surface.and_then(|surface| sticks_out_mm(sensor, surface)) {
            push(CoilMisfit::SticksOut { by_mm });
        }
        for (other_index, other) in sensors.iter().enumerate() {
            let overlap = (index != other_index).then(|| overlap_mm(sensor, other)).flatten();
            if let Some(by_mm) = overlap {
                let other = other.name.clone();
                push(CoilMisfit::Overlaps { index: other_index, other, by_mm });
            }
        }
    }
    findings
}

/// How far a coil that is partly in a body sticks out of it; `None` where it is inside, outside or on
/// the surface, and where the surface encloses nothing.
pub fn sticks_out_mm(sensor: &Sensor, surface: &Surface) -> Option<f64> {
    let cylinder = Cylinder::of(sensor).filter(|cylinder| cylinder.sticks_out(surface))?;
    let out_mm = (0..=STATIONS).map(|k| Station::at(&cylinder, k, surface).out_mm);
    Some(out_mm.fold(0.0, f64::max))
}

/// Whether a sensor's coil fits among the other sensors of its body and, where that has one, in its
/// surface: nothing is then found of it by [`coil_findings`].
pub fn coil_fits<'a>(
    sensor: &Sensor,
    mut others: impl Iterator<Item = &'a Sensor>,
    surface: Option<&Surface>,
) -> bool {
    let sticks_out = |surface| Cylinder::of(sensor).is_some_and(|own| own.sticks_out(surface));
    others.all(|other| overlap_mm(sensor, other).is_none()) && !surface.is_some_and(sticks_out)
}

/// Whether a coil's middle is in the body, and the coil is not one that lies on the surface.
pub(super) fn is_embedded(sensor: &Sensor, surface: &Surface) -> bool {
    let Some(cylinder) = Cylinder::of(sensor).filter(|_| surface.is_closed()) else {
        return false;
    };
    surface.contains(&cylinder.middle_mm) && !cylinder.lies_on(surface)
}

/// Whether nothing of a coil is out of the body. Most coils that are not are known by one end.
pub(super) fn is_within(sensor: &Sensor, surface: &Surface) -> bool {
    let Some(cylinder) = Cylinder::of(sensor) else {
        return true;
    };
    let is_in = |point: &Point3<f64>| {
        surface.contains(point)
            || (surface.closest(point).position_mm - point).norm() <= LEAST_MM
            || cylinder.has_wall_around(point, surface)
    };
    [0, STATIONS].into_iter().chain(1..STATIONS).all(|k| {
        let middle = cylinder.middle_at(k);
        is_in(&middle) && cylinder.ring(&middle).all(|point| is_in(&point))
    })
}

/// How far two coils would have to be moved apart at the least; `None` where they are apart.
///
/// Each is taken for the cylinder with rounded ends that is within it, so that what is reported
/// overlaps, and coils end to end do not.
pub fn overlap_mm(one: &Sensor, other: &Sensor) -> Option<f64> {
    let overlap_mm = -coil_gap_mm(one, other)?;
    (overlap_mm > LEAST_MM).then_some(overlap_mm)
}

/// The least distance between two coils, below zero where they overlap; each is taken for the
/// cylinder with rounded ends that is within it. `None` where one has no stated size.
pub fn coil_gap_mm(one: &Sensor, other: &Sensor) -> Option<f64> {
    let [one, other] = [Cylinder::of(one)?, Cylinder::of(other)?];
    let between_mm = segment_distance(&one.core(), &other.core());
    Some(between_mm - one.core_radius_mm() - other.core_radius_mm())
}

/// Points of a coil's outside, half a millimetre apart along one of 9 mm, and of its middle line; of
/// a sensor whose coil has no stated size, where it is.
pub fn coil_points(sensor: &Sensor) -> Vec<Point3<f64>> {
    let Some(cylinder) = Cylinder::of(sensor) else {
        return vec![sensor.position_in_body];
    };
    let stations = (0..=STATIONS).map(|k| cylinder.middle_at(k));
    stations.flat_map(|middle| cylinder.ring(&middle).chain([middle])).collect()
}

/// A coil in its body.
struct Cylinder {
    middle_mm: Point3<f64>,
    axis: Unit<Vector3<f64>>,
    size: Coil,
}

impl Cylinder {
    /// `None` of a marker, and of a coil whose size is not stated.
    fn of(sensor: &Sensor) -> Option<Self> {
        let axis = sensor.axis_in_body()?;
        Some(Self { middle_mm: sensor.position_in_body, axis, size: sensor.coil? })
    }

    fn radius_mm(&self) -> f64 {
        self.size.diameter_mm / 2.0
    }

    fn start_mm(&self) -> Point3<f64> {
        self.middle_mm - *self.axis * (self.size.length_mm / 2.0)
    }

    /// The points around a point of the middle line.
    fn ring(&self, center: &Point3<f64>) -> impl Iterator<Item = Point3<f64>> + use<> {
        let center = *center;
        let x = perpendicular(&self.axis);
        let y = self.axis.cross(&x);
        let radius_mm = self.radius_mm();
        (0..AROUND).map(move |k| {
            let (sine, cosine) = (f64::from(k) / f64::from(AROUND) * TAU).sin_cos();
            center + (*x * cosine + y * sine) * radius_mm
        })
    }

    /// Whether it is partly in a body and partly out of it, and does not lie on its surface.
    fn sticks_out(&self, surface: &Surface) -> bool {
        if !surface.is_closed() {
            return false;
        }
        let (mut is_in, mut is_out) = (false, false);
        // The ends first: if anything of it is out of the body, they mostly are.
        let partly = [0, STATIONS].into_iter().chain(1..STATIONS).any(|k| {
            let station = Station::at(self, k, surface);
            is_in |= station.inside > 0;
            is_out |= station.out_mm > LEAST_MM;
            is_in && is_out
        });
        partly && (self.is_in_bore(surface) || !self.lies_on(surface))
    }

    /// Its middle line at a station.
    fn middle_at(&self, station: u32) -> Point3<f64> {
        let along_mm = self.size.length_mm * f64::from(station) / f64::from(STATIONS);
        self.start_mm() + *self.axis * along_mm
    }

    /// Whether its middle line is in a bore somewhere.
    fn is_in_bore(&self, surface: &Surface) -> bool {
        (0..=STATIONS).any(|k| self.has_wall_around(&self.middle_at(k), surface))
    }

    /// Whether a point of it is in a bore that runs as it does.
    fn has_wall_around(&self, point: &Point3<f64>, surface: &Surface) -> bool {
        surface.is_bore(point, &self.axis, self.size.length_mm)
    }

    /// Whether it lies on the surface: its middle line is outside, or dips into the body along it,
    /// and where it does the body is on one side of it only.
    fn lies_on(&self, surface: &Surface) -> bool {
        let ray = Ray { origin_mm: self.start_mm(), direction: self.axis };
        let mut dips = surface.inside_along(&ray, self.size.length_mm).into_iter();
        dips.all(|[from, to]| {
            let length_mm = to - from;
            let places = [0.25, 0.5, 0.75].map(|part| from + part * length_mm);
            let depth = places.map(|along| {
                let place = ray.at(along);
                (surface.closest(&place).position_mm - place).norm()
            });
            let depth_mm = depth.into_iter().fold(0.0, f64::max);
            let is_shallow = depth_mm <= MOST_DIP_RADII * self.radius_mm()
                && depth_mm <= MOST_DIP_SLOPE * length_mm;
            // A rod thinner than the coil is in it, not under it.
            is_shallow && self.ring(&ray.at(places[1])).any(|point| surface.contains(&point))
        })
    }

    /// The ends of the middle line of the cylinder with rounded ends that is within it.
    fn core(&self) -> [Point3<f64>; 2] {
        let half = self.size.length_mm / 2.0 - self.core_radius_mm();
        [-half, half].map(|along| self.middle_mm + *self.axis * along)
    }

    fn core_radius_mm(&self) -> f64 {
        self.radius_mm().min(self.size.length_mm / 2.0)
    }
}

/// A cross-section of a coil against the body.
struct Station {
    /// Points of it that are in the body or in a bore of it.
    inside: usize,
    /// How far the farthest one is outside.
    out_mm: f64,
}

impl Station {
    fn at(cylinder: &Cylinder, number: u32, surface: &Surface) -> Self {
        let middle = cylinder.middle_at(number);
        let mut station = Self { inside: 0, out_mm: 0.0 };
        for point in cylinder.ring(&middle).chain([middle]) {
            if surface.contains(&point) || cylinder.has_wall_around(&point, surface) {
                station.inside += 1;
            } else {
                let off_mm = (surface.closest(&point).position_mm - point).norm();
                station.out_mm = station.out_mm.max(off_mm);
            }
        }
        station
    }
}

/// The least distance between two pieces of lines (Ericson, Real-Time Collision Detection, 5.1.9).
fn segment_distance([a, b]: &[Point3<f64>; 2], [c, d]: &[Point3<f64>; 2]) -> f64 {
    let (one, other, between) = (b - a, d - c, a - c);
    let (length2, other2) = (one.norm_squared(), other.norm_squared());
    let (cosine, along, beside) = (one.dot(&other), one.dot(&between), other.dot(&between));
    let determinant = length2 * other2 - cosine * cosine;
    // Pieces without a length, and parallel ones, begin at their start.
    let quotient = |value: f64, by: f64| if by > 0.0 { (value / by).clamp(0.0, 1.0) } else { 0.0 };
    let is_parallel = determinant <= 1e-12 * length2 * other2;
    let first = match is_parallel {
        true => 0.0,
        false => ((cosine * beside - along * other2) / determinant).clamp(0.0, 1.0),
    };
    let second = quotient(cosine * first + beside, other2);
    let first = quotient(cosine * second - along, length2);
    let second = quotient(cosine * first + beside, other2);
    ((a + one * first) - (c + other * second)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::SensorOrientation;
    use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};
    use trackwright_geometry::solid::Solid;

    /// A turned body along z, from outlines of `[radius, z]`: an inner one is a bore.
    fn turned(outlines: &[&[[f64; 2]]]) -> Surface {
        let part = |outline: &&[[f64; 2]]| {
            let Solid { positions_mm, normals, triangles } = Solid::turned(outline);
            MeshPart { positions_mm, normals, triangles, ..MeshPart::default() }
        };
        let parts = outlines.iter().map(part).collect();
        Surface::new(&SurfaceMesh { parts, ..SurfaceMesh::default() }).unwrap()
    }

    /// 2 mm across, 100 mm long.
    fn needle() -> Surface {
        turned(&[&[[0.0, 0.0], [1.0, 0.0], [1.0, 100.0], [0.0, 100.0]]])
    }

    fn sensor(name: &str, position: [f64; 3], axis: [f64; 3]) -> Sensor {
        Sensor {
            name: name.to_owned(),
            position_in_body: position.into(),
            orientation: SensorOrientation::FiveDof(Unit::new_normalize(axis.into())),
            coil: Some(Coil { diameter_mm: 0.8, length_mm: 9.0 }),
        }
    }

    fn along(x: f64, z: f64) -> Sensor {
        sensor("a", [x, 0.0, z], [0.0, 0.0, 1.0])
    }

    #[test]
    fn a_coil_in_a_needle_fits() {
        assert_eq!(sticks_out_mm(&along(0.0, 50.0), &needle()), None);
        assert_eq!(sticks_out_mm(&along(0.5, 50.0), &needle()), None);
    }

    #[test]
    fn a_coil_across_a_needle_sticks_out() {
        let across = sensor("a", [0.0, 0.0, 50.0], [1.0, 0.0, 0.0]);
        let found = sticks_out_mm(&across, &needle()).unwrap();
        // Half of 9 mm less 1 mm, and a little more at the corner.
        assert!((3.5..3.6).contains(&found), "{found}");
        // Glued on at right angles, half of it is in the way.
        let through = sensor("a", [1.0, 0.0, 50.0], [1.0, 0.0, 0.0]);
        assert!(sticks_out_mm(&through, &needle()).unwrap() > 4.4);
    }

    #[test]
    fn a_coil_out_of_the_tip_sticks_out() {
        let found = sticks_out_mm(&along(0.0, -3.0), &needle()).unwrap();
        assert!((found - 7.5).abs() < 0.02, "{found}");
    }

    #[test]
    fn a_coil_mounted_outside_is_no_finding() {
        let on_surface = |x| sticks_out_mm(&along(x, 50.0), &needle());
        assert_eq!(on_surface(5.0), None, "beside it");
        assert_eq!(on_surface(1.4), None, "touching it");
        assert_eq!(on_surface(1.0), None, "its middle on the surface, as a click puts it");
        assert_eq!(on_surface(0.9), None, "in a groove");
        assert!(on_surface(0.7).unwrap() > 0.05, "in the wall, and through it");
        // Crosswise, it touches in one place.
        let crosswise = sensor("a", [1.0, 0.0, 50.0], [0.0, 1.0, 0.0]);
        assert_eq!(sticks_out_mm(&crosswise, &needle()), None);
    }

    #[test]
    fn a_coil_on_a_waist_lies_on_it() {
        let waist = turned(&[&[
            [0.0, 0.0],
            [7.0, 0.0],
            [6.2, 20.0],
            [6.0, 25.0],
            [6.2, 30.0],
            [7.0, 50.0],
            [0.0, 50.0],
        ]]);
        assert_eq!(sticks_out_mm(&along(6.0, 25.0), &waist), None);
    }

    #[test]
    fn a_coil_thicker_than_its_rod_sticks_out() {
        let wire = turned(&[&[[0.0, 0.0], [0.2, 0.0], [0.2, 100.0], [0.0, 100.0]]]);
        let found = sticks_out_mm(&along(0.0, 50.0), &wire).unwrap();
        assert!((found - 0.2).abs() < 0.01, "{found}");
    }

    #[test]
    fn a_coil_across_a_tube_sticks_out() {
        let tube = turned(&[
            &[[0.0, 0.0], [1.0, 0.0], [1.0, 100.0], [0.0, 100.0]],
            // From the upper to the lower end: the inside of the wall.
            &[[0.0, 99.0], [0.8, 99.0], [0.8, 1.0], [0.0, 1.0]],
        ]);
        let across = sensor("a", [0.0, 0.0, 50.0], [1.0, 0.0, 0.0]);
        assert!(sticks_out_mm(&across, &tube).unwrap() > 3.4);
        assert_eq!(sticks_out_mm(&along(0.0, 50.0), &tube), None, "in the bore");
    }

    /// A tube of 2 mm with a bore of 1.2 mm, 100 mm long and open at both ends: one shell.
    fn open_tube() -> Surface {
        turned(&[&[[0.6, 0.0], [1.0, 0.0], [1.0, 100.0], [0.6, 100.0], [0.6, 0.0]]])
    }

    #[test]
    fn a_coil_in_an_open_tube_is_inside() {
        let tube = open_tube();
        assert!(tube.is_closed());
        assert_eq!(sticks_out_mm(&along(0.0, 50.0), &tube), None, "in the bore");
        assert_eq!(sticks_out_mm(&along(0.4, 50.0), &tube), None, "partly in the wall");
        assert_eq!(sticks_out_mm(&along(0.0, 4.6), &tube), None, "just within the mouth");
        assert_eq!(sticks_out_mm(&along(1.4, 50.0), &tube), None, "mounted outside");
    }

    #[test]
    fn a_coil_half_out_of_a_tube_sticks_out() {
        for z in [0.0, 100.0] {
            let found = sticks_out_mm(&along(0.0, z), &open_tube()).unwrap();
            // Half of 9 mm from the mouth, and across to its rim.
            assert!((4.5..4.6).contains(&found), "{found}");
        }
        // Wholly out, it is not in this body.
        assert_eq!(sticks_out_mm(&along(0.0, -10.0), &open_tube()), None);
    }

    #[test]
    fn a_blind_bore_holds_a_coil_up_to_its_mouth() {
        // Bored from z = 0 to 30 of 100 mm.
        let blind = turned(&[&[
            [0.0, 30.0],
            [0.6, 30.0],
            [0.6, 0.0],
            [1.0, 0.0],
            [1.0, 100.0],
            [0.0, 100.0],
        ]]);
        assert!(blind.is_closed());
        for z in [5.0, 20.0, 28.0, 32.0, 60.0] {
            assert_eq!(sticks_out_mm(&along(0.0, z), &blind), None, "{z}");
        }
        let found = sticks_out_mm(&along(0.0, 2.5), &blind).unwrap();
        assert!((2.0..2.2).contains(&found), "{found}");
    }

    #[test]
    fn a_coil_in_a_notch_is_outside() {
        // An L of 10 mm by 3 mm, 40 mm along z.
        let outline = [[0.0, 0.0], [10.0, 0.0], [10.0, 3.0], [3.0, 3.0], [3.0, 10.0], [0.0, 10.0]];
        let mut part = MeshPart::default();
        for z in [0.0, 40.0] {
            part.positions_mm.extend(outline.map(|[x, y]| Point3::new(x, y, z)));
        }
        part.normals = vec![Vector3::z(); 12];
        for i in 0..6 {
            let next = (i + 1) % 6;
            part.triangles.extend([[i, next, next + 6], [i, next + 6, i + 6]]);
        }
        for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
            part.triangles.extend([[a, c, b], [a + 6, b + 6, c + 6]]);
        }
        let mesh = SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() };
        let angle = Surface::new(&mesh).unwrap();
        assert!(angle.is_closed());
        let in_notch = |z| sensor("a", [4.0, 4.0, z], [0.0, 0.0, 1.0]);
        // Mounted there, also where it stands out at the end.
        assert_eq!(sticks_out_mm(&in_notch(20.0), &angle), None);
        assert_eq!(sticks_out_mm(&in_notch(40.0), &angle), None);
        let through = sensor("a", [3.0, 8.0, 20.0], [1.0, 0.0, 0.0]);
        let found = sticks_out_mm(&through, &angle).unwrap();
        assert!((found - 4.5).abs() < 0.1, "{found}");
    }

    #[test]
    fn nothing_is_stated_of_what_is_not_known() {
        let open = turned(&[&[[1.0, 0.0], [1.0, 100.0]]]);
        let across = sensor("a", [0.0, 0.0, 50.0], [1.0, 0.0, 0.0]);
        assert_eq!(sticks_out_mm(&across, &open), None, "encloses nothing");
        let unknown = Sensor { coil: None, ..across.clone() };
        assert_eq!(sticks_out_mm(&unknown, &needle()), None);
        let marker = Sensor { orientation: SensorOrientation::Marker, ..across.clone() };
        assert_eq!(sticks_out_mm(&marker, &needle()), None);
        assert_eq!(overlap_mm(&unknown, &across), None);
    }

    #[test]
    fn coils_in_one_place_overlap_by_their_width() {
        let overlap = |a: &Sensor, b: &Sensor| overlap_mm(a, b).unwrap_or(0.0);
        let a = along(0.0, 50.0);
        assert!((overlap(&a, &a) - 0.8).abs() < 1e-12);
        assert!((overlap(&a, &along(0.3, 50.0)) - 0.5).abs() < 1e-12);
        assert_eq!(overlap(&a, &along(0.8, 50.0)), 0.0, "side by side");
        assert_eq!(overlap(&a, &along(0.0, 59.0)), 0.0, "end to end");
        assert!((overlap(&a, &along(0.0, 58.7)) - 0.3).abs() < 1e-12);
        let crossing = sensor("b", [0.0, 0.5, 47.0], [1.0, 0.0, 0.0]);
        assert!((overlap(&a, &crossing) - 0.3).abs() < 1e-12);
        assert!((overlap(&crossing, &a) - 0.3).abs() < 1e-12);
        let ball = Sensor { coil: Some(Coil { diameter_mm: 2.0, length_mm: 2.0 }), ..a.clone() };
        assert!((overlap(&ball, &a) - 1.4).abs() < 1e-12);
        assert!((overlap(&ball, &ball) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn findings_are_listed_sensor_by_sensor() {
        let sensors =
            [along(0.0, 50.0), sensor("b", [0.0, 0.0, 52.0], [1.0, 0.0, 0.0]), along(0.0, 80.0)];
        let found = coil_findings("crf", &sensors, Some(&needle()));
        let of = |index: usize| found.iter().filter(move |f| f.index == index).count();
        assert_eq!([of(0), of(1), of(2)], [1, 2, 0], "{found:?}");
        assert_eq!(found[0].words(), "overlaps by 0.8 mm");
        assert_eq!(
            coil_statements(&found),
            [
                "the coil of the CRF's sensor a overlaps with that of b by 0.8 mm",
                "the coil of the CRF's sensor b does not fit: it sticks out of the body by 3.5 mm",
            ]
        );
    }
}
