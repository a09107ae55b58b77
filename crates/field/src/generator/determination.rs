//! Whether a generator's signals determine the poses of sensors with one axis throughout a volume.

use super::coils::{Generator, MAX_COILS};
use super::reading::{LEVER_MM, Orientation, for_rows};
use nalgebra::{Matrix5, Point3, SMatrix, Unit, Vector3};
use rayon::prelude::*;
use trackwright_geometry::directions::DirectionSet;
use trackwright_geometry::volume::Volume;

/// Points along each side of the volume's box: its middle, its faces and between, where symmetric
/// generators have what they do not determine.
const POINTS_A_SIDE: usize = 5;

/// Least ratio of a pose's singular values: below it a millimetre one way changes the signals ten million
/// times less than one another way. The built-in generators have 5e-6 at 10 mm from their coils and 1e-3
/// farther away; symmetric ones that leave a motion out have 1e-16.
const LEAST_RATIO: f64 = 1e-7;

/// A pose, and the motion from it that the signals show least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastDetermined {
    pub position_mm: Point3<f64>,
    pub axis: Unit<Vector3<f64>>,
    /// Smallest over largest singular value of the signals' Jacobian, rotations in mm at the lever.
    pub ratio: f64,
    /// The motion with that singular value: a shift in mm, and a rotation vector.
    pub shift_mm: Vector3<f64>,
    pub rotation_rad: Vector3<f64>,
}

/// Why a generator serves no volume.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DeterminationError {
    #[error(
        "the coils do not determine a sensor at ({}) mm along ({}): it may move by ({}) mm and turn by ({}) rad without a change of the signals",
        list(&.0.position_mm.coords), list(&.0.axis), list(&.0.shift_mm), list(&.0.rotation_rad)
    )]
    Undetermined(Box<LeastDetermined>),
    #[error("the field at ({}) mm, in the volume, is not finite", list(&.0.coords))]
    NotFinite(Point3<f64>),
}

impl Generator {
    /// The pose that the signals determine least, of those at points and axes spread over a volume.
    ///
    /// Poses between them may be determined less. With as few coils as unknowns some always are.
    ///
    /// # Errors
    /// [`DeterminationError::NotFinite`].
    pub fn least_determined(&self, volume: &Volume) -> Result<LeastDetermined, DeterminationError> {
        let bounds = volume.bounds();
        let part = |k: usize| k as f64 / (POINTS_A_SIDE - 1) as f64;
        let side = 0..POINTS_A_SIDE;
        let cells = side.clone().flat_map(|x| side.clone().map(move |y| [x, y]));
        let cells = cells.flat_map(|[x, y]| side.clone().map(move |z| [x, y, z]));
        let points: Vec<Point3<f64>> = cells
            .map(|cell| {
                let parts = Vector3::from(cell.map(part));
                bounds.min_mm + bounds.size_mm().component_mul(&parts)
            })
            .filter(|p| volume.contains(p))
            .collect();
        let of_point = |p: &Point3<f64>| {
            // An axis and its opposite have the same signals but for their sign.
            let each = DirectionSet::TwentySix.up_to_sign().map(|n| self.determined_at(p, n));
            each.reduce(|a, b| Ok(less(a?, b?))).unwrap_or(Err(DeterminationError::NotFinite(*p)))
        };
        let none = || Err(DeterminationError::NotFinite(bounds.center_mm()));
        let all: Vec<_> = points.par_iter().map(of_point).collect();
        all.into_iter().reduce(|a, b| Ok(less(a?, b?))).unwrap_or_else(none)
    }

    /// Whether the signals determine all poses at points and axes spread over a volume.
    ///
    /// # Errors
    /// The pose that they determine least, where that is not at all.
    pub fn check_determines(&self, volume: &Volume) -> Result<(), DeterminationError> {
        let least = self.least_determined(volume)?;
        match least.ratio >= LEAST_RATIO {
            true => Ok(()),
            false => Err(DeterminationError::Undetermined(Box::new(least))),
        }
    }

    fn determined_at(
        &self,
        position_mm: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
    ) -> Result<LeastDetermined, DeterminationError> {
        let mut rows = Vec::with_capacity(self.coils.len());
        for_rows::<1, 2, 5, _>(self, position_mm, axis, |_, _, _, row| rows.push(*row));
        let largest = rows.iter().flatten().fold(0.0_f64, |most, v| v.abs().max(most));
        let is_finite = largest > 0.0 && rows.iter().flatten().all(|v| v.is_finite());
        if !is_finite {
            return Err(DeterminationError::NotFinite(*position_mm));
        }
        let mut jacobian = SMatrix::<f64, MAX_COILS, 5>::zeros();
        for (i, row) in rows.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                jacobian[(i, j)] = value / largest;
            }
        }
        let triangle: Matrix5<f64> = jacobian.qr().r();
        let svd = triangle.svd(false, true);
        let (smallest, most) = (svd.singular_values.imin(), svd.singular_values.max());
        let motion = svd.v_t.map(|v_t| v_t.row(smallest).transpose()).unwrap_or_default();
        let [u, v] = axis.rotation_axes();
        Ok(LeastDetermined {
            position_mm: *position_mm,
            axis: *axis,
            ratio: svd.singular_values[smallest] / most,
            shift_mm: Vector3::new(motion[0], motion[1], motion[2]),
            rotation_rad: (u * motion[3] + v * motion[4]) / LEVER_MM,
        })
    }
}

fn less(a: LeastDetermined, b: LeastDetermined) -> LeastDetermined {
    if b.ratio < a.ratio { b } else { a }
}

fn list(v: &Vector3<f64>) -> String {
    let text = |v: f64| format!("{v:.4}").trim_end_matches('0').trim_end_matches('.').to_owned();
    format!("{}, {}, {}", text(v.x), text(v.y), text(v.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generator::Coil;
    use trackwright_geometry::bounds::Bounds;

    fn dipoles(each: impl IntoIterator<Item = ([f64; 3], [f64; 3])>) -> Generator {
        let coil = |(at, moment): ([f64; 3], [f64; 3])| Coil::Dipole {
            at_mm: at.into(),
            moment: moment.into(),
        };
        Generator { name: "test".to_owned(), coils: each.into_iter().map(coil).collect() }
    }

    const UP: [f64; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn built_in_generators_determine_all_poses() {
        for generator in [Generator::planar_nine(), Generator::anser()] {
            for volume in Volume::NAMED {
                // From 5e-6, 10 mm before the coils, to 1e-2.
                let least = generator.least_determined(&volume).unwrap();
                assert!(least.ratio > 4e-6 && least.ratio < 2e-2, "{volume:?} {least:?}");
                assert_eq!(generator.check_determines(&volume), Ok(()));
            }
        }
        // Five coils without a common plane of symmetry, and vertical ones on a square grid.
        let five = Generator {
            coils: Generator::planar_nine().coils[..5].to_vec(),
            ..Generator::planar_nine()
        };
        let at = |k: usize| 120.0 * k as f64 - 120.0;
        let grid = dipoles((0..9).map(|k| ([at(k / 3), at(k % 3), 0.0], UP)));
        for generator in [five, grid] {
            assert_eq!(generator.check_determines(&Volume::AuroraCube), Ok(()));
        }
    }

    #[test]
    fn symmetric_coils_leave_poses_undetermined() {
        let same = Generator {
            coils: vec![Generator::planar_nine().coils[0]; 5],
            ..Generator::planar_nine()
        };
        let row = dipoles((0..9).map(|k| ([30.0 * k as f64 - 120.0, 0.0, 0.0], UP)));
        let along = dipoles((0..9).map(|k| ([30.0 * k as f64 - 120.0, 0.0, 0.0], [1.0, 0.0, 0.0])));
        // In the plane between two of them, one pair has to show two motions.
        let cross = dipoles(
            [[0.0, 0.0], [100.0, 0.0], [-100.0, 0.0], [0.0, 100.0], [0.0, -100.0]]
                .map(|[x, y]| ([x, y, 0.0], UP)),
        );
        // On its axis a ring has two patterns to show two shifts and two turns.
        let ring = dipoles((0..8).map(|k| {
            let (sine, cosine) = (f64::from(k) * std::f64::consts::FRAC_PI_4).sin_cos();
            ([120.0 * cosine, 120.0 * sine, 0.0], UP)
        }));
        for generator in [same, row, along, cross, ring] {
            let found = generator.check_determines(&Volume::AuroraCube);
            let Err(DeterminationError::Undetermined(least)) = found else { panic!("{found:?}") };
            // The signals do not change by the motion that is reported.
            let signals = |p: &Point3<f64>, n: &Vector3<f64>| -> Vec<f64> {
                generator.coils.iter().map(|coil| coil.field(p).dot(n)).collect()
            };
            let (p, n) = (least.position_mm, least.axis);
            let moved = signals(&(p + least.shift_mm), &n.rotated(&least.rotation_rad));
            let there = signals(&p, &n);
            let (change, size) = there
                .iter()
                .zip(&moved)
                .fold((0.0_f64, 0.0_f64), |(c, s), (a, b)| (c.max((a - b).abs()), s.max(a.abs())));
            // A motion of a mm at some hundred changes them by 1e-2, to second order by 1e-4.
            assert!(change < 2e-4 * size, "{least:?} {}", change / size);
        }
    }

    #[test]
    fn undetermined_poses_are_reported_in_words() {
        let at = |k: usize| [30.0 * k as f64 - 120.0, 0.0, 0.0];
        let row = dipoles((0..9).map(|k| (at(k), UP)));
        let text = row.check_determines(&Volume::AuroraCube).unwrap_err().to_string();
        let begin =
            "the coils do not determine a sensor at (-250, -250, -550) mm along (0, 0, 1): ";
        assert!(text.starts_with(begin), "{text}");
        let on_a_coil = Volume::Box(Bounds::from(([-10.0, -10.0, -10.0], [10.0; 3])));
        let error = row.check_determines(&on_a_coil).unwrap_err();
        assert_eq!(error.to_string(), "the field at (0, 0, 0) mm, in the volume, is not finite");
    }
}
