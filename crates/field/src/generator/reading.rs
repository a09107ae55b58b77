//! What sensor coils measure in a disturbed field, and the pose that a tracker computes from it.
//!
//! A coil at `p` with axis `n` measures `s_i = n·(B_i(p) + δB_i(p))`. The tracker knows only `B` and
//! reports the pose whose signals in the empty room are nearest, by Gauss–Newton from the true
//! pose. Unknowns are a position in mm and rotations in mm at a lever of [`LEVER_MM`].

use super::coils::{Generator, MAX_COILS};
use crate::samples::PoseError;
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::{axis_rotation, exp_vector, perpendicular};

/// Turns rotations into lengths.
pub const LEVER_MM: f64 = 100.0;

/// A longer Gauss–Newton step is shortened to this.
pub(super) const MAX_STEP_MM: f64 = 30.0;

/// A step this short is the last one. Steps shrink at least tenfold where the pose is well
/// determined, so that what is left is far below the 1e-6 mm of the worked cases; round-off is
/// 1e-11 mm at 500 mm from the generator.
pub(super) const CONVERGED_MM: f64 = 1e-8;

/// Full steps converge in 4 to 8; a start that is 300 mm off needs 10 more.
const MAX_STEPS: usize = 50;

/// Square of the part of a column of the Jacobian that has to be independent of the columns before
/// it. Round-off of the normal matrix is 1e-15; a part of 1e-6 of a signal is below any noise.
pub(super) const MIN_INDEPENDENT_SQUARE: f64 = 1e-12;

/// Why signals determine no pose.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ReadingError {
    /// `column` counts x, y, z, then rotations.
    #[error(
        "the signals do not determine the pose: unknown {column} of {unknowns} depends on those before it"
    )]
    RankLoss { column: usize, unknowns: usize },
    #[error("the pose did not converge: the step is still {step_mm:.3e} mm after {steps} steps")]
    NoConvergence { steps: usize, step_mm: f64 },
    #[error("the field is not finite")]
    NotFinite,
}

/// Position and axis that a tracker reports of a sensor with one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisReading {
    pub position_mm: Point3<f64>,
    pub axis: Unit<Vector3<f64>>,
    /// Gauss–Newton steps taken.
    pub steps: usize,
}

/// Pose that a tracker reports of a sensor with three axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseReading {
    pub tracker_from_sensor: Pose,
    /// Gauss–Newton steps taken.
    pub steps: usize,
}

/// What turns of a sensor: its axes, and the rotations that its signals determine.
pub trait Orientation<const AXES: usize, const ROTATIONS: usize>: Copy {
    /// Unit vectors that the coils measure along.
    fn axes(&self) -> [Vector3<f64>; AXES];
    /// Axes of the rotations that are unknowns, unit and perpendicular.
    fn rotation_axes(&self) -> [Vector3<f64>; ROTATIONS];
    /// After a rotation vector in radians.
    fn rotated(&self, vector_rad: &Vector3<f64>) -> Self;
}

impl Orientation<1, 2> for Unit<Vector3<f64>> {
    #[inline]
    fn axes(&self) -> [Vector3<f64>; 1] {
        [self.into_inner()]
    }

    #[inline]
    fn rotation_axes(&self) -> [Vector3<f64>; 2] {
        let tangent = perpendicular(self).into_inner();
        [tangent, self.cross(&tangent)]
    }

    #[inline]
    fn rotated(&self, vector_rad: &Vector3<f64>) -> Self {
        Unit::new_normalize(exp_vector(vector_rad) * self.into_inner())
    }
}

impl Orientation<3, 3> for UnitQuaternion<f64> {
    #[inline]
    fn axes(&self) -> [Vector3<f64>; 3] {
        [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| self * axis)
    }

    #[inline]
    fn rotation_axes(&self) -> [Vector3<f64>; 3] {
        [Vector3::x(), Vector3::y(), Vector3::z()]
    }

    #[inline]
    fn rotated(&self, vector_rad: &Vector3<f64>) -> Self {
        UnitQuaternion::new_normalize((exp_vector(vector_rad) * self).into_inner())
    }
}

/// What the tracker reports of a sensor with one axis where each coil's field is disturbed by
/// `disturbance`, its vectors at the true position.
///
/// ```
/// use nalgebra::{Point3, Vector3};
/// use trackwright_field::generator::{Generator, reading::read_axis};
///
/// let generator = Generator::planar_nine();
/// let (at, axis) = (Point3::new(20.0, -30.0, -200.0), Vector3::x_axis());
/// let empty_room = vec![Vector3::zeros(); generator.coils.len()];
/// let reading = read_axis(&generator, &at, &axis, &empty_room)?;
/// assert_eq!(reading.position_mm, at);
/// # Ok::<(), trackwright_field::generator::reading::ReadingError>(())
/// ```
///
/// # Errors
/// See [`ReadingError`]; never a pose that is not the answer.
///
/// # Panics
/// If `disturbance` has another length than the coils, or there are more than [`MAX_COILS`].
pub fn read_axis(
    generator: &Generator,
    position: &Point3<f64>,
    axis: &Unit<Vector3<f64>>,
    disturbance: &[Vector3<f64>],
) -> Result<AxisReading, ReadingError> {
    let (position_mm, axis, steps) = nearest::<1, 2, 5, _>(generator, position, axis, disturbance)?;
    Ok(AxisReading { position_mm, axis, steps })
}

/// What the tracker reports of a sensor with three axes; as [`read_axis`].
///
/// # Errors
/// See [`ReadingError`]; never a pose that is not the answer.
///
/// # Panics
/// If `disturbance` has another length than the coils, or there are more than [`MAX_COILS`].
pub fn read_pose(
    generator: &Generator,
    tracker_from_sensor: &Pose,
    disturbance: &[Vector3<f64>],
) -> Result<PoseReading, ReadingError> {
    let position = tracker_from_sensor.translation.vector.into();
    let (position_mm, rotation, steps) =
        nearest::<3, 3, 6, _>(generator, &position, &tracker_from_sensor.rotation, disturbance)?;
    Ok(PoseReading { tracker_from_sensor: pose_from_parts(position_mm.coords, rotation), steps })
}

/// Error of a reading of a sensor with one axis, measurement error (1) of a 5-DOF sensor.
pub fn axis_error(
    generator: &Generator,
    position: &Point3<f64>,
    axis: &Unit<Vector3<f64>>,
    disturbance: &[Vector3<f64>],
) -> Result<PoseError, ReadingError> {
    let reading = read_axis(generator, position, axis, disturbance)?;
    Ok(PoseError {
        position_mm: reading.position_mm - position,
        rotation_rad: axis_rotation(axis, &reading.axis).vector_rad,
    })
}

/// Calls `each` with coil, axis, signal in the empty room, and its derivatives with respect to the
/// unknowns: position, then rotations at the lever.
#[inline]
pub(crate) fn for_rows<const AXES: usize, const ROTATIONS: usize, const UNKNOWNS: usize, O>(
    generator: &Generator,
    position: &Point3<f64>,
    orientation: &O,
    mut each: impl FnMut(usize, usize, f64, &[f64; UNKNOWNS]),
) where
    O: Orientation<AXES, ROTATIONS>,
{
    const { assert!(UNKNOWNS == 3 + ROTATIONS) };
    let axes = orientation.axes();
    let rotation_axes = orientation.rotation_axes();
    let moves = axes.map(|n| rotation_axes.map(|turn| turn.cross(&n) / LEVER_MM));
    for (index, coil) in generator.coils.iter().enumerate() {
        let mut one = |axis: usize, field: &Vector3<f64>, slope: &Vector3<f64>| {
            let mut row = [0.0; UNKNOWNS];
            row[..3].copy_from_slice(slope.as_slice());
            for (entry, moved) in row[3..].iter_mut().zip(&moves[axis]) {
                *entry = moved.dot(field);
            }
            each(index, axis, axes[axis].dot(field), &row);
        };
        if AXES == 1 {
            let (field, slope) = coil.field_and_signal_gradient(position, &axes[0]);
            one(0, &field, &slope);
        } else {
            let (field, gradient) = coil.field_and_gradient(position);
            for (axis, n) in axes.iter().enumerate() {
                one(axis, &field, &gradient.tr_mul(n));
            }
        }
    }
}

fn rotation_vector<const AXES: usize, const ROTATIONS: usize, O>(
    orientation: &O,
    lengths_mm: &[f64],
) -> Vector3<f64>
where
    O: Orientation<AXES, ROTATIONS>,
{
    let rotation_axes = orientation.rotation_axes();
    let parts = rotation_axes.iter().zip(lengths_mm);
    parts.map(|(turn, length)| turn * (length / LEVER_MM)).sum()
}

/// The pose whose signals are nearest to those of the disturbed field at the true pose.
fn nearest<const AXES: usize, const ROTATIONS: usize, const UNKNOWNS: usize, O>(
    generator: &Generator,
    position: &Point3<f64>,
    orientation: &O,
    disturbance: &[Vector3<f64>],
) -> Result<(Point3<f64>, O, usize), ReadingError>
where
    O: Orientation<AXES, ROTATIONS>,
{
    let coils = generator.coils.len();
    assert_eq!(disturbance.len(), coils, "one disturbance a coil");
    assert!(coils <= MAX_COILS, "no more than {MAX_COILS} coils");
    let axes = orientation.axes();
    let mut measured = [[0.0; AXES]; MAX_COILS];
    let (mut position, mut orientation) = (*position, *orientation);
    let mut step_mm = f64::INFINITY;
    for steps in 1..=MAX_STEPS {
        let mut normal = Normal::<UNKNOWNS>::default();
        for_rows(generator, &position, &orientation, |coil, axis, s, row| {
            let residual = if steps == 1 {
                let disturbed = axes[axis].dot(&disturbance[coil]);
                measured[coil][axis] = s + disturbed;
                disturbed
            } else {
                measured[coil][axis] - s
            };
            normal.add(row, residual);
        });
        let mut step = normal.solve()?;
        step_mm = step.iter().map(|v| v * v).sum::<f64>().sqrt();
        if step_mm > MAX_STEP_MM {
            step = step.map(|v| v * (MAX_STEP_MM / step_mm));
        }
        position += Vector3::new(step[0], step[1], step[2]);
        let turn = rotation_vector::<AXES, ROTATIONS, O>(&orientation, &step[3..]);
        orientation = orientation.rotated(&turn);
        if step_mm <= CONVERGED_MM {
            return Ok((position, orientation, steps));
        }
    }
    Err(ReadingError::NoConvergence { steps: MAX_STEPS, step_mm })
}

/// Normal equations of one step. Squaring the Jacobian's condition (10 to 100 here) costs digits of
/// the step, not of the answer, which is where the step vanishes.
struct Normal<const N: usize> {
    /// The lower triangle, row by row.
    matrix: [[f64; N]; N],
    right: [f64; N],
}

impl<const N: usize> Default for Normal<N> {
    #[inline]
    fn default() -> Self {
        Self { matrix: [[0.0; N]; N], right: [0.0; N] }
    }
}

impl<const N: usize> Normal<N> {
    #[inline]
    fn add(&mut self, row: &[f64; N], residual: f64) {
        for i in 0..N {
            for j in 0..=i {
                self.matrix[i][j] += row[i] * row[j];
            }
            self.right[i] += row[i] * residual;
        }
    }

    /// By Cholesky.
    #[inline]
    #[expect(
        clippy::needless_range_loop,
        reason = "rows and columns of a triangle are clearest by their indices"
    )]
    fn solve(mut self) -> Result<[f64; N], ReadingError> {
        let (m, x) = (&mut self.matrix, &mut self.right);
        for j in 0..N {
            let whole = m[j][j];
            let mut left = whole;
            for k in 0..j {
                left -= m[j][k] * m[j][k];
            }
            if !(whole.is_finite() && x[j].is_finite()) {
                return Err(ReadingError::NotFinite);
            }
            if left.is_nan() || left <= MIN_INDEPENDENT_SQUARE * whole {
                return Err(ReadingError::RankLoss { column: j, unknowns: N });
            }
            let root = left.sqrt();
            let inverse = 1.0 / root;
            m[j][j] = inverse;
            for i in j + 1..N {
                let mut sum = m[i][j];
                for k in 0..j {
                    sum -= m[i][k] * m[j][k];
                }
                m[i][j] = sum * inverse;
            }
            let mut sum = x[j];
            for k in 0..j {
                sum -= m[j][k] * x[k];
            }
            x[j] = sum * inverse;
        }
        for j in (0..N).rev() {
            let mut sum = x[j];
            for i in j + 1..N {
                sum -= m[i][j] * x[i];
            }
            x[j] = sum * m[j][j];
        }
        Ok(self.right)
    }
}

#[cfg(test)]
mod tests {
    use super::super::coils::Coil;
    use super::*;
    use trackwright_geometry::rotation::rotation_angle_rad;

    fn generators() -> [Generator; 2] {
        [Generator::planar_nine(), Generator::anser()]
    }

    fn poses() -> Vec<Pose> {
        [[20.0, -30.0, -90.0], [-150.0, 120.0, -260.0], [80.0, 10.0, -480.0]]
            .iter()
            .zip([[0.3, -0.2, 0.9], [1.9, 0.4, -0.3], [-0.6, 2.1, 0.2]])
            .map(|(&position, turn)| pose_from_parts(position.into(), exp_vector(&turn.into())))
            .collect()
    }

    fn axis_of(pose: &Pose) -> Unit<Vector3<f64>> {
        pose.rotation * Vector3::z_axis()
    }

    #[test]
    fn an_undisturbed_reading_is_exact() {
        for generator in generators() {
            let none = vec![Vector3::zeros(); generator.coils.len()];
            for pose in poses() {
                let position = pose.translation.vector.into();
                let reading = read_axis(&generator, &position, &axis_of(&pose), &none).unwrap();
                assert_eq!(reading.position_mm, position);
                assert!((reading.axis.as_ref() - axis_of(&pose).as_ref()).norm() < 1e-15);
                assert_eq!(reading.steps, 1);
                let reading = read_pose(&generator, &pose, &none).unwrap();
                assert_eq!(reading.tracker_from_sensor.translation.vector, pose.translation.vector);
                let turn = reading.tracker_from_sensor.rotation * pose.rotation.inverse();
                assert!(rotation_angle_rad(&turn) < 1e-15);
            }
        }
    }

    /// The field of another pose as a disturbance: the tracker has to find that pose.
    #[test]
    fn signals_of_another_pose_give_that_pose() {
        for generator in generators() {
            let mut fields = [(); 2].map(|()| vec![Vector3::zeros(); generator.coils.len()]);
            for pose in poses() {
                let turn = exp_vector(&Vector3::new(0.2, -0.1, 0.15));
                let other = pose_from_parts(
                    pose.translation.vector + Vector3::new(9.0, -14.0, 7.0),
                    turn * pose.rotation,
                );
                let [here, there] = &mut fields;
                generator.field(&pose.translation.vector.into(), here);
                generator.field(&other.translation.vector.into(), there);
                // The other pose's signals, put along the axes of this one.
                let back = pose.rotation * other.rotation.inverse();
                let disturbance: Vec<_> = here
                    .iter()
                    .zip(there.iter())
                    .map(|(here, there)| back * there - here)
                    .collect();
                let reading = read_pose(&generator, &pose, &disturbance).unwrap();
                let found = reading.tracker_from_sensor;
                assert!((found.translation.vector - other.translation.vector).norm() < 1e-7);
                let error = rotation_angle_rad(&(found.rotation * other.rotation.inverse()));
                assert!(error < 1e-9);
                let position = pose.translation.vector.into();
                let reading =
                    read_axis(&generator, &position, &axis_of(&pose), &disturbance).unwrap();
                assert!((reading.position_mm.coords - other.translation.vector).norm() < 1e-7);
                assert!((reading.axis.as_ref() - axis_of(&other).as_ref()).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn the_signals_jacobian_is_its_difference() {
        let h = 1e-3;
        let generator = Generator::anser();
        let signals = |p: &Point3<f64>, q: &UnitQuaternion<f64>| {
            let mut all = Vec::new();
            for_rows::<3, 3, 6, _>(&generator, p, q, |_, _, s, _| all.push(s));
            all
        };
        for pose in poses() {
            let (p, q) = (Point3::from(pose.translation.vector), pose.rotation);
            let mut rows = Vec::new();
            for_rows::<3, 3, 6, _>(&generator, &p, &q, |_, _, _, row| rows.push(*row));
            for column in 0..6 {
                let moved = |h: f64| {
                    let mut step = [0.0; 6];
                    step[column] = h;
                    let turn = Vector3::from_column_slice(&step[3..]) / LEVER_MM;
                    let place = p + Vector3::from_column_slice(&step[..3]);
                    signals(&place, &q.rotated(&turn))
                };
                let (plus, minus) = (moved(h), moved(-h));
                let largest = rows.iter().fold(0.0_f64, |m, row| m.max(row[column].abs()));
                for (row, (plus, minus)) in rows.iter().zip(plus.iter().zip(&minus)) {
                    let slope = (plus - minus) / (2.0 * h);
                    assert!((slope - row[column]).abs() < 1e-7 * largest);
                }
            }
        }
    }

    #[test]
    fn coils_that_determine_no_pose_are_refused() {
        let mut generator = Generator::planar_nine();
        let (p, n) = (Point3::new(10.0, 20.0, -200.0), Vector3::x_axis());
        let none = [Vector3::zeros(); 9];
        generator.coils.truncate(4);
        assert_eq!(
            read_axis(&generator, &p, &n, &none[..4]),
            Err(ReadingError::RankLoss { column: 4, unknowns: 5 })
        );
        generator.coils = vec![Generator::planar_nine().coils[0]; 9];
        let error = read_axis(&generator, &p, &n, &none).unwrap_err();
        assert!(matches!(error, ReadingError::RankLoss { column: 1, .. }));
        let Coil::Dipole { at_mm, .. } = generator.coils[0] else { panic!("a dipole") };
        assert_eq!(
            read_axis(&Generator::planar_nine(), &at_mm, &n, &none),
            Err(ReadingError::NotFinite)
        );
        let mut strange = none;
        strange[2].y = f64::NAN;
        assert_eq!(
            read_axis(&Generator::planar_nine(), &p, &n, &strange),
            Err(ReadingError::NotFinite)
        );
    }

    #[test]
    fn a_disturbance_beyond_reason_is_no_pose() {
        let generator = Generator::planar_nine();
        let (p, n) = (Point3::new(10.0, 20.0, -200.0), Vector3::x_axis());
        let huge: Vec<_> = (0..9)
            .map(|i| Vector3::new(f64::from(i) - 4.0, 1.0, (f64::from(i) * 2.3).sin()) * 1e3)
            .collect();
        assert!(read_axis(&generator, &p, &n, &huge).is_err());
    }
}
