//! How far jitter scatters the tip, by formula, by Monte Carlo, or both.

use super::{
    FirstOrderCheck, MonteCarlo, MotionUncertainty, TipUncertainty, UncertaintyError,
    check_first_order, first_order, monte_carlo, over_motion,
};
use crate::scenario::{Mode, Scenario};
use trackwright_field::environment::{Jitter, OrientationWeight};
use trackwright_task::Task;

/// Samples by default: 0.2 % of standard error, in a fraction of a second.
pub const DEFAULT_SAMPLES: usize = 100_000;

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

/// What was found.
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
}
