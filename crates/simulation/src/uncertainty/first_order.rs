//! First-order uncertainty of the tip at the design's pose (`docs/methods/uncertainty.md`).

use super::check::TOLERANCE;
use super::ellipsoid::Ellipsoid;
use super::error::UncertaintyError;
use super::still::{FreeBody, Still};
use crate::figures::FreeAxis;
use crate::frame_fit::Determination;
use crate::linear_fit::{LinearFit, MotionCovariance, SensorCovariance, SmallMotion};
use crate::scenario::Scenario;
use crate::trial::BodyDetail;
use crate::work::Work;
use nalgebra::{Matrix3, Point3, UnitQuaternion, Vector3};
use trackwright_field::environment::LocalJitter;
use trackwright_field::samples::PoseError;

/// How the tip scatters and how far it is shifted, to first order; CRF axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipUncertainty {
    /// The true tip.
    pub tip_in_crf: Point3<f64>,
    /// Of the jitter alone. Where a rotation is free the true one is taken, as studies do.
    pub covariance_mm2: Matrix3<f64>,
    /// Of the jitter alone: `√ trace`.
    pub rms_mm: f64,
    /// What the distortion shifts the tip by.
    pub bias_mm: Vector3<f64>,
    /// Of jitter and bias together.
    pub total_rms_mm: f64,
    /// Of the rotation vector, jitter alone.
    pub rotation_covariance_rad2: Matrix3<f64>,
    pub rotation_rms_rad: f64,
    pub rotation_bias_rad: Vector3<f64>,
    /// Between the tip (rows) and the rotation vector (columns).
    pub cross_covariance_mm_rad: Matrix3<f64>,
    /// Holds 95 % of where the jitter puts the tip; about the tip as it is simulated without
    /// jitter.
    pub ellipsoid: Ellipsoid,
    /// The bias against the simulation that needs no first order.
    pub bias_check: BiasCheck,
    /// Where a rotation is not determined: what it cannot change.
    pub determined: Option<DeterminedPart>,
    /// A rotation is so weakly determined that noise decides it.
    pub is_poorly_determined: bool,
    pub work: Work,
}

/// The first-order bias against the simulated tip error without jitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BiasCheck {
    pub simulated_mm: Vector3<f64>,
    /// Of the two vectors' difference.
    pub difference_mm: f64,
    /// Whether they differ by no more than 2 % of the simulated one.
    pub holds: bool,
}

/// The part of the tip's uncertainty that a rotation which is not determined cannot change: along
/// the free axis and towards it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeterminedPart {
    pub free_axis: FreeAxis,
    pub covariance_mm2: Matrix3<f64>,
    pub rms_mm: f64,
    pub bias_mm: Vector3<f64>,
    pub total_rms_mm: f64,
}

/// First-order covariance and bias of the tip at the design's pose, relative to the CRF where
/// there is one.
///
/// # Errors
/// See [`UncertaintyError`].
pub fn first_order(scenario: &Scenario) -> Result<TipUncertainty, UncertaintyError> {
    let still = Still::new(scenario)?;
    let weight_mm = scenario.orientation_weight_mm;
    let tip_in_crf = still.tip_in_crf();
    let tool = LinearFit::new(&scenario.tool, weight_mm);
    let tool_in_crf =
        InCrf::new(&tool, &still.pose.tool, &still.tool_jitter, &scenario.crf_from_tool.rotation);
    let tool_lever_mm =
        scenario.crf_from_tool.rotation * tool.lever_mm(&scenario.tool.judged_tip_in_body());
    let mut sum = tool_in_crf.at(&tool_lever_mm);
    let mut crf_linear = None;
    if let (Some(crf), Some(detail)) = (&scenario.crf, &still.pose.crf) {
        let linear = LinearFit::new(&crf.body, weight_mm);
        let own = InCrf::new(&linear, detail, &still.crf_jitter, &UnitQuaternion::identity());
        sum.subtract(&own.at(&linear.lever_mm(&tip_in_crf)));
        crf_linear = Some(linear);
    }
    let free = free_body(&tool, crf_linear.as_ref());
    let rms_mm = rms(&sum.covariance_mm2);
    let simulated_mm = still.pose.trial.tip_error_in_crf_mm;
    let difference_mm = (sum.bias_mm - simulated_mm).norm();
    Ok(TipUncertainty {
        tip_in_crf,
        covariance_mm2: sum.covariance_mm2,
        rms_mm,
        bias_mm: sum.bias_mm,
        total_rms_mm: rms_mm.hypot(sum.bias_mm.norm()),
        rotation_covariance_rad2: sum.rotation_covariance_rad2,
        rotation_rms_rad: rms(&sum.rotation_covariance_rad2),
        rotation_bias_rad: sum.rotation_bias_rad,
        cross_covariance_mm_rad: sum.cross_covariance_mm_rad,
        ellipsoid: Ellipsoid::of_95_percent(tip_in_crf + simulated_mm, &sum.covariance_mm2),
        bias_check: BiasCheck {
            simulated_mm,
            difference_mm,
            holds: difference_mm
                <= TOLERANCE * simulated_mm.norm() + round_off_mm(scenario, &tip_in_crf),
        },
        determined: free.map(|free| determined_part(&free, scenario, &tip_in_crf, &sum)),
        is_poorly_determined: is_poor(&tool) || crf_linear.as_ref().is_some_and(is_poor),
        work: still.pose.work,
    })
}

/// What one body does to the tip, or the difference of two; CRF axes.
#[derive(Clone, Copy, Debug)]
struct AtTip {
    covariance_mm2: Matrix3<f64>,
    cross_covariance_mm_rad: Matrix3<f64>,
    rotation_covariance_rad2: Matrix3<f64>,
    bias_mm: Vector3<f64>,
    rotation_bias_rad: Vector3<f64>,
}

impl AtTip {
    /// Takes off an independent motion of what the tip is seen from.
    fn subtract(&mut self, crf: &Self) {
        self.covariance_mm2 += crf.covariance_mm2;
        self.cross_covariance_mm_rad += crf.cross_covariance_mm_rad;
        self.rotation_covariance_rad2 += crf.rotation_covariance_rad2;
        self.bias_mm -= crf.bias_mm;
        self.rotation_bias_rad -= crf.rotation_bias_rad;
    }
}

/// A body's first-order motion in CRF axes.
struct InCrf {
    covariance: MotionCovariance,
    bias: SmallMotion,
}

impl InCrf {
    fn new(
        linear: &LinearFit,
        detail: &BodyDetail,
        jitter: &[LocalJitter],
        crf_from_body: &UnitQuaternion<f64>,
    ) -> Self {
        let covariances: Vec<_> = jitter
            .iter()
            .map(|j| SensorCovariance::isotropic(j.position_mm, j.angle_rad))
            .collect();
        let body_from_tracker = detail.tracker_from_body.rotation.inverse();
        let errors: Vec<_> = detail
            .sensors
            .iter()
            .map(|s| PoseError {
                position_mm: body_from_tracker * s.error.position_mm,
                rotation_rad: body_from_tracker * s.error.rotation_rad,
            })
            .collect();
        let bias = linear.motion(&errors);
        Self {
            covariance: linear.covariance(&covariances).rotated_by(crf_from_body),
            bias: SmallMotion {
                shift_mm: crf_from_body * bias.shift_mm,
                turn_rad: crf_from_body * bias.turn_rad,
            },
        }
    }

    fn at(&self, lever_mm: &Vector3<f64>) -> AtTip {
        AtTip {
            covariance_mm2: self.covariance.point_mm2(lever_mm),
            cross_covariance_mm_rad: self.covariance.point_turn_mm_rad(lever_mm),
            rotation_covariance_rad2: self.covariance.turn_rad2,
            bias_mm: self.bias.at(lever_mm),
            rotation_bias_rad: self.bias.turn_rad,
        }
    }
}

/// What is free, the tool's before the CRF's, as in studies.
pub(super) fn free_body(tool: &LinearFit, crf: Option<&LinearFit>) -> Option<FreeBody> {
    let of = |body, linear: &LinearFit| {
        linear.free_motion().map(|motion_in_body| FreeBody { body, motion_in_body })
    };
    of("tool", tool).or_else(|| of("crf", crf?))
}

fn determined_part(
    free: &FreeBody,
    scenario: &Scenario,
    tip_in_crf: &Point3<f64>,
    sum: &AtTip,
) -> DeterminedPart {
    let projection = free.in_crf(&scenario.crf_from_tool).determined_projection(tip_in_crf);
    let covariance_mm2 = projection * sum.covariance_mm2 * projection;
    let bias_mm = projection * sum.bias_mm;
    let rms_mm = rms(&covariance_mm2);
    DeterminedPart {
        free_axis: FreeAxis::of(free.body, free.motion_in_body.axis, scenario),
        covariance_mm2,
        rms_mm,
        bias_mm,
        total_rms_mm: rms_mm.hypot(bias_mm.norm()),
    }
}

fn is_poor(linear: &LinearFit) -> bool {
    matches!(linear.determination(), Determination::Poor { .. })
}

fn rms(covariance: &Matrix3<f64>) -> f64 {
    covariance.trace().max(0.0).sqrt()
}

/// Below this a simulated error is round-off of the poses that it is the difference of: some ten
/// operations on coordinates of this size.
fn round_off_mm(scenario: &Scenario, tip_in_crf: &Point3<f64>) -> f64 {
    let crf_mm =
        scenario.crf.as_ref().map_or(0.0, |c| c.tracker_from_crf.translation.vector.norm());
    64.0 * f64::EPSILON * (tip_in_crf.coords.norm() + crf_mm)
}
