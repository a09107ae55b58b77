//! Tool in CRF (14): the relative pose, its tip error, and what of it no free rotation can change.

use super::frame_fit::Determination;
use nalgebra::{Point3, Unit, Vector3};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::{log_quaternion, rotation_angle_rad};

/// How far the tracked tool is from the true one, in CRF axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeError {
    /// `F̂·tip − F·tip`, mm.
    pub tip_error_in_crf_mm: Vector3<f64>,
    /// Angle of `R̂ Rᵀ`.
    pub angle_rad: f64,
}

/// The error of `crf_from_tool_simulated` at the tool's tip.
///
/// ```
/// use nalgebra::Point3;
/// use trackwright_geometry::pose::Pose;
/// use trackwright_simulation::tool_in_crf::relative_error;
/// let (truth, found) = (Pose::identity(), Pose::translation(0.3, 0.0, 0.4));
/// let error = relative_error(&truth, &found, &Point3::new(0.0, 0.0, 100.0));
/// assert!((error.tip_error_in_crf_mm.norm() - 0.5).abs() < 1e-12 && error.angle_rad == 0.0);
/// ```
pub fn relative_error(
    crf_from_tool: &Pose,
    crf_from_tool_simulated: &Pose,
    tip_in_tool: &Point3<f64>,
) -> RelativeError {
    RelativeError {
        tip_error_in_crf_mm: crf_from_tool_simulated * tip_in_tool - crf_from_tool * tip_in_tool,
        angle_rad: rotation_angle_rad(
            &(crf_from_tool_simulated.rotation * crf_from_tool.rotation.inverse()),
        ),
    }
}

/// The error of a tracked tool as vectors, in CRF axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorVectors {
    pub tip_mm: Vector3<f64>,
    /// Rotation vector of `R̂ Rᵀ`.
    pub rotation_rad: Vector3<f64>,
}

impl ErrorVectors {
    /// The error of `crf_from_tool_simulated` at the tool's tip.
    pub fn of(
        crf_from_tool: &Pose,
        crf_from_tool_simulated: &Pose,
        tip_in_tool: &Point3<f64>,
    ) -> Self {
        let turn = crf_from_tool_simulated.rotation * crf_from_tool.rotation.inverse();
        let error = relative_error(crf_from_tool, crf_from_tool_simulated, tip_in_tool);
        Self { tip_mm: error.tip_error_in_crf_mm, rotation_rad: log_quaternion(&turn) }
    }

    /// Tip error in mm and angle error in degrees.
    pub fn sizes(&self) -> [f64; 2] {
        [self.tip_mm.norm(), self.rotation_rad.norm().to_degrees()]
    }
}

/// The places where a free rotation may carry the tip, in any one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeMotion {
    /// The sensors' centroid.
    pub center: Point3<f64>,
    /// The axis that is free; `None` where every rotation is.
    pub axis: Option<Unit<Vector3<f64>>>,
}

impl FreeMotion {
    /// What a body's sensors leave free, in the body's frame; `None` where nothing is.
    pub fn in_body(determination: &Determination, centroid_in_body: Point3<f64>) -> Option<Self> {
        let axis = match determination {
            Determination::Full | Determination::Poor { .. } => return None,
            Determination::FreeAxis { axis_in_body } => Some(*axis_in_body),
            Determination::FreeRotation => None,
        };
        Some(Self { center: centroid_in_body, axis })
    }

    pub fn transformed_by(&self, target_from_source: &Pose) -> Self {
        Self {
            center: target_from_source * self.center,
            axis: self.axis.map(|a| target_from_source.rotation * a),
        }
    }

    /// How far the tip is from what the free rotations are about, in mm: a wrong guess of the rotation
    /// carries it up to twice as far.
    pub fn reach_mm(&self, tip: &Point3<f64>) -> f64 {
        let from_center = tip - self.center;
        match self.axis {
            None => from_center.norm(),
            Some(axis) => axis.cross(&from_center).norm(),
        }
    }

    /// The part of the tip error that no free rotation can change, in mm: the error along the
    /// axis, and the change of the tip's distance from it. This is the distance of the true tip
    /// from the circle (or sphere) on which the simulated one may lie.
    pub fn determined_error_mm(&self, tip: &Point3<f64>, tip_simulated: &Point3<f64>) -> f64 {
        let (truth, simulated) = (tip - self.center, tip_simulated - self.center);
        match self.axis {
            None => (simulated.norm() - truth.norm()).abs(),
            Some(axis) => {
                let along = axis.dot(&(simulated - truth));
                // The cross product keeps small distances from the axis accurate.
                let radius = axis.cross(&simulated).norm() - axis.cross(&truth).norm();
                along.hypot(radius)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion};

    #[test]
    fn rotation_about_the_free_axis_is_not_an_error() {
        let free = FreeMotion {
            center: Point3::new(1.0, 2.0, 3.0),
            axis: Some(Unit::new_normalize(Vector3::new(1.0, 1.0, 0.2))),
        };
        let tip = Point3::new(10.0, -4.0, 7.0);
        let turn = UnitQuaternion::from_axis_angle(&free.axis.unwrap(), 0.8);
        let turned = free.center + turn * (tip - free.center);
        assert!((turned - tip).norm() > 1.0);
        assert!(free.determined_error_mm(&tip, &turned) < 1e-14);
    }

    #[test]
    fn half_a_turn_carries_the_tip_twice_its_reach() {
        let axis = Unit::new_normalize(Vector3::new(1.0, 1.0, 0.2));
        let center = Point3::new(1.0, 2.0, 3.0);
        let tip = Point3::new(10.0, -4.0, 7.0);
        let half = UnitQuaternion::from_axis_angle(&axis, std::f64::consts::PI);
        let axis = Some(axis);
        let turned = center + half * (tip - center);
        let reach_mm = FreeMotion { center, axis }.reach_mm(&tip);
        assert!(((turned - tip).norm() - 2.0 * reach_mm).abs() < 1e-12);
        let around = FreeMotion { center, axis: None };
        assert!((around.reach_mm(&tip) - (tip - center).norm()).abs() < 1e-12);
    }

    #[test]
    fn a_shift_along_the_axis_is_all_determined() {
        let axis = Unit::new_normalize(Vector3::new(1.0, 1.0, 0.2));
        let free = FreeMotion { center: Point3::origin(), axis: Some(axis) };
        let tip = Point3::new(10.0, -4.0, 7.0);
        let shifted = tip + axis.into_inner() * 0.3;
        assert!((free.determined_error_mm(&tip, &shifted) - 0.3).abs() < 1e-14);
    }

    #[test]
    fn tip_error_is_in_crf_axes_and_grows_with_the_lever() {
        let tilt = Pose::from_parts(
            Translation3::identity(),
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 1e-3),
        );
        let e = relative_error(&Pose::identity(), &tilt, &Point3::new(0.0, 0.0, 100.0));
        assert!((e.angle_rad - 1e-3).abs() < 1e-15);
        assert!((e.tip_error_in_crf_mm.norm() - 0.1).abs() < 1e-7);
        assert!(e.tip_error_in_crf_mm.y < 0.0);
    }
}
