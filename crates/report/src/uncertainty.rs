//! How far jitter scatters the tip, by formula, by Monte Carlo, or both.

use nalgebra::{Matrix3, Vector3};
use serde_json::{Value, json};
use trackwright_field::environment::{Jitter, OrientationWeight};
use trackwright_simulation::uncertainty::{
    DeterminedPart, FirstOrderCheck, MonteCarlo, MotionUncertainty, TipUncertainty,
    UncertaintyError, check_first_order, first_order, monte_carlo, over_motion,
};
use trackwright_simulation::{Mode, RoomFieldFigures, Scenario};
use trackwright_task::Task;

/// Samples by default: 0.2 % of standard error, in a fraction of a second.
pub const DEFAULT_SAMPLES: usize = 100_000;

/// Degrees a radian.
const DEG: f64 = 180.0 / std::f64::consts::PI;

/// How the scatter is found. Over a range of motion it is by the formula, whatever is requested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UncertaintyMethods {
    /// The formula of error propagation, and whether it holds.
    pub first_order: bool,
    /// Noise on every reading and the real frame fit.
    pub monte_carlo: Option<Sampling>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    pub samples: usize,
    pub seed: u64,
}

/// What was found, ready to be printed.
#[derive(Clone, Debug)]
pub struct UncertaintyReport {
    pub jitter: Jitter,
    /// Who stated the jitter.
    pub jitter_source: &'static str,
    pub weight: OrientationWeight,
    pub first_order: Option<(TipUncertainty, Option<FirstOrderCheck>)>,
    pub monte_carlo: Option<MonteCarlo>,
    pub motion: Option<MotionUncertainty>,
}

impl UncertaintyReport {
    /// The scatter at the pose or over the motion of a mode; that of given poses is at the design's own.
    /// `design_weight_mm` is the orientation weight that the design states.
    ///
    /// # Errors
    /// See [`UncertaintyError`].
    pub fn of(
        (scenario, mode): (&Scenario, &Mode),
        jitter_source: &'static str,
        design_weight_mm: Option<f64>,
        methods: &UncertaintyMethods,
        task: &Task,
    ) -> Result<Self, UncertaintyError> {
        let environment = &scenario.environment;
        let jitter = environment
            .jitter
            .ok_or_else(|| UncertaintyError::NoJitter { environment: environment.name.clone() })?;
        let weight = environment.orientation_weight(design_weight_mm);
        let (mut by_formula, mut sampled, mut motion) = (None, None, None);
        if matches!(mode, Mode::Motion) {
            motion = Some(over_motion(scenario, task)?);
        } else {
            if methods.first_order {
                let tip = first_order(scenario)?;
                by_formula = Some((tip, check_first_order(scenario, &tip)?));
            }
            if let Some(Sampling { samples, seed }) = methods.monte_carlo {
                sampled = Some(monte_carlo(scenario, samples, seed, task)?);
            }
        }
        Ok(Self {
            jitter,
            jitter_source,
            weight,
            first_order: by_formula,
            monte_carlo: sampled,
            motion,
        })
    }

    /// For `simulate`'s JSON, under `uncertainty`; `figures` are those without jitter.
    pub fn as_json(&self, figures: &RoomFieldFigures) -> Value {
        let mut value = json!({
            "jitter": {
                "position_mm": self.jitter.position_mm,
                "angle_deg": self.jitter.angle_rad * DEG,
                "growth": self.jitter.growth,
                "source": self.jitter_source,
            },
            "orientation_weight_mm": self.weight.value_mm,
            "orientation_weight_source": self.weight.source.label(),
        });
        if let Some((tip, check)) = &self.first_order {
            value["first_order"] = first_order_json(tip, check.as_ref());
        }
        if let Some(sampled) = &self.monte_carlo {
            value["monte_carlo"] = monte_carlo_json(sampled);
        }
        if let (Some((tip, _)), Some(sampled)) = (&self.first_order, &self.monte_carlo) {
            let difference = tip.rms_mm - sampled.rms_mm.value;
            value["agreement"] = json!({
                "relative_difference": difference / sampled.rms_mm.value,
                "standard_errors": difference / sampled.rms_mm.std_error,
            });
        }
        if let Some(over) = &self.motion {
            value["first_order"] = json!({
                "trials": over.trials,
                "rejected": over.rejected,
                "rms_mm": over.rms_mm,
                "rotation_rms_deg": over.rotation_rms_deg,
                "worst_trial": over.worst_trial,
                "total_rms_mm": over.total_rms_mm(figures.position_mm.rms()),
                "free_axis": over.free_axis,
            });
        }
        value
    }
}

fn vector_json(v: &Vector3<f64>) -> [f64; 3] {
    (*v).into()
}

fn matrix_json(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    m.transpose().into()
}

fn first_order_json(tip: &TipUncertainty, check: Option<&FirstOrderCheck>) -> Value {
    json!({
        "tip_mm": [tip.tip_in_crf.x, tip.tip_in_crf.y, tip.tip_in_crf.z],
        "covariance_mm2": matrix_json(&tip.covariance_mm2),
        "rms_mm": tip.rms_mm,
        "bias_mm": vector_json(&tip.bias_mm),
        "total_rms_mm": tip.total_rms_mm,
        "rotation_covariance_deg2": matrix_json(&(tip.rotation_covariance_rad2 * DEG * DEG)),
        "rotation_rms_deg": tip.rotation_rms_rad * DEG,
        "rotation_bias_deg": vector_json(&(tip.rotation_bias_rad * DEG)),
        "cross_covariance_mm_deg": matrix_json(&(tip.cross_covariance_mm_rad * DEG)),
        "ellipsoid_95": {
            "center_mm": vector_json(&tip.ellipsoid.center_in_crf.coords),
            "semi_axes_mm": tip.ellipsoid.semi_axes_in_crf_mm.map(|a| vector_json(&a)),
            "lengths_mm": tip.ellipsoid.lengths_mm(),
        },
        "check": check.map(|c| json!({
            "next_order_rms_mm": c.next_order_rms_mm,
            "relative_difference": c.relative_difference,
            "holds": c.holds,
        })),
        "bias_check": {
            "simulated_mm": vector_json(&tip.bias_check.simulated_mm),
            "difference_mm": tip.bias_check.difference_mm,
            "holds": tip.bias_check.holds,
        },
        "determined": tip.determined.as_ref().map(determined_json),
        "poorly_determined": tip.is_poorly_determined,
    })
}

fn determined_json(part: &DeterminedPart) -> Value {
    json!({
        "free_axis": part.free_axis,
        "covariance_mm2": matrix_json(&part.covariance_mm2),
        "rms_mm": part.rms_mm,
        "bias_mm": vector_json(&part.bias_mm),
        "total_rms_mm": part.total_rms_mm,
    })
}

fn monte_carlo_json(m: &MonteCarlo) -> Value {
    json!({
        "samples": m.samples,
        "seed": m.seed,
        "mean_error_mm": vector_json(&m.mean_error_mm),
        "mean_std_error_mm": vector_json(&m.mean_std_error_mm),
        "covariance_mm2": matrix_json(&m.covariance_mm2),
        "rms_mm": m.rms_mm.value,
        "rms_std_error_mm": m.rms_mm.std_error,
        "total_rms_mm": m.total_rms_mm.value,
        "total_rms_std_error_mm": m.total_rms_mm.std_error,
        "position_mm": m.tip_error_mm,
        "median_std_error_mm": m.median_mm.std_error,
        "p95_std_error_mm": m.p95_mm.std_error,
        "angle_deg": m.angle_deg,
        "mean_rotation_deg": vector_json(&(m.mean_rotation_rad * DEG)),
        "rotation_covariance_deg2": matrix_json(&(m.rotation_covariance_rad2 * DEG * DEG)),
        "rotation_rms_deg": m.rotation_rms_rad * DEG,
        "position_mm_determined": m.determined_mm,
    })
}
