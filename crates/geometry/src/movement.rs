//! Rigid movements by an amount: along a direction or about an axis, and their steps.

use super::pose::{Pose, pose_from_parts};
use super::rotation::exp_vector;
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};

/// Amounts are rounded to these on demand.
pub const STEP_MM: f64 = 1.0;
pub const STEP_DEG: f64 = 5.0;

/// How a thing is moved in some frame, from where it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Movement {
    Slide { direction: Unit<Vector3<f64>>, by_mm: f64 },
    Turn { axis: Unit<Vector3<f64>>, pivot_mm: Point3<f64>, by_rad: f64 },
}

impl Movement {
    /// Along an axis of a frame: 0 is x.
    pub fn along_axis_of(frame: &Pose, axis: usize, by_mm: f64) -> Self {
        Self::Slide { direction: frame.rotation * unit(axis), by_mm }
    }

    /// About an axis of a frame, through its origin.
    pub fn about_axis_of(frame: &Pose, axis: usize, by_rad: f64) -> Self {
        let pivot_mm = Point3::from(frame.translation.vector);
        Self::Turn { axis: frame.rotation * unit(axis), pivot_mm, by_rad }
    }

    /// By a whole number of steps.
    pub fn snapped(self) -> Self {
        match self {
            Self::Slide { direction, by_mm } => {
                Self::Slide { direction, by_mm: (by_mm / STEP_MM).round() * STEP_MM }
            }
            Self::Turn { axis, pivot_mm, by_rad } => Self::Turn {
                axis,
                pivot_mm,
                by_rad: ((by_rad.to_degrees() / STEP_DEG).round() * STEP_DEG).to_radians(),
            },
        }
    }

    /// The same movement in another frame.
    pub fn transformed_by(&self, target_from_source: &Pose) -> Self {
        match *self {
            Self::Slide { direction, by_mm } => {
                Self::Slide { direction: target_from_source.rotation * direction, by_mm }
            }
            Self::Turn { axis, pivot_mm, by_rad } => Self::Turn {
                axis: target_from_source.rotation * axis,
                pivot_mm: target_from_source * pivot_mm,
                by_rad,
            },
        }
    }

    /// What turns with it; nothing where it slides.
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        match self {
            Self::Slide { .. } => UnitQuaternion::identity(),
            Self::Turn { axis, by_rad, .. } => exp_vector(&(axis.into_inner() * *by_rad)),
        }
    }

    /// The pose of what is moved: what does not change is kept to the bit.
    pub fn moved(&self, pose: &Pose) -> Pose {
        let from = pose.translation.vector;
        match *self {
            Self::Slide { direction, by_mm } => {
                pose_from_parts(from + direction.into_inner() * by_mm, pose.rotation)
            }
            Self::Turn { by_rad: 0.0, .. } => *pose,
            Self::Turn { pivot_mm, .. } => {
                let turn = self.rotation();
                let arm = from - pivot_mm.coords;
                // A pivot at the pose's own origin has no arm, and the origin then stays.
                pose_from_parts(
                    from + (turn * arm - arm),
                    UnitQuaternion::new_normalize((turn * pose.rotation).into_inner()),
                )
            }
        }
    }
}

fn unit(axis: usize) -> Unit<Vector3<f64>> {
    [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()][axis]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(by_rad: f64) -> Movement {
        Movement::Turn {
            axis: Unit::new_normalize(Vector3::new(0.3, -0.8, 0.52)),
            pivot_mm: Point3::new(7.0, -3.0, 120.0),
            by_rad,
        }
    }

    fn amount(movement: Movement) -> f64 {
        match movement {
            Movement::Slide { by_mm, .. } => by_mm,
            Movement::Turn { by_rad, .. } => by_rad,
        }
    }

    #[test]
    fn snapped_amounts_are_exact_multiples() {
        for count in -72..=72 {
            let near = f64::from(count) * 5.0 + 2.3;
            let snapped = amount(turn(near.to_radians()).snapped());
            assert_eq!(snapped, (f64::from(count) * 5.0).to_radians());
            let slide =
                Movement::Slide { direction: Vector3::x_axis(), by_mm: f64::from(count) - 0.4 };
            assert_eq!(amount(slide.snapped()), f64::from(count));
        }
    }

    #[test]
    fn turning_leaves_the_pivot_in_place() {
        let pose = pose_from_parts(
            Vector3::new(40.0, 1.5, -300.0),
            UnitQuaternion::from_euler_angles(0.3, 1.1, -2.0),
        );
        let pivot = Point3::new(7.0, -3.0, 120.0);
        let in_body = pose.inverse() * pivot;
        for by_rad in [-3.0, -0.02, 1e-7, 0.7, 3.1] {
            let moved = turn(by_rad).moved(&pose);
            assert!((moved * in_body - pivot).norm() < 1e-12 * 500.0);
            let back = turn(-by_rad).moved(&moved);
            assert!((back.translation.vector - pose.translation.vector).norm() < 1e-10);
            assert!(back.rotation.angle_to(&pose.rotation) < 1e-7);
        }
        assert_eq!(turn(0.0).moved(&pose), pose);
    }

    #[test]
    fn movements_agree_in_every_frame() {
        let outer_from_inner = pose_from_parts(
            Vector3::new(-4.0, 55.0, 8.0),
            UnitQuaternion::from_euler_angles(-1.0, 0.4, 0.2),
        );
        let pose = Pose::translation(1.0, 2.0, 3.0);
        for movement in [turn(0.9), Movement::Slide { direction: Vector3::y_axis(), by_mm: -12.5 }]
        {
            let inside = outer_from_inner * movement.moved(&pose);
            let outside =
                movement.transformed_by(&outer_from_inner).moved(&(outer_from_inner * pose));
            let apart = (inside.translation.vector - outside.translation.vector).norm();
            assert!(apart < 1e-12 * 200.0, "{apart}");
            assert!(inside.rotation.angle_to(&outside.rotation) < 1e-7);
        }
    }
}
