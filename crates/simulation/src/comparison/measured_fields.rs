//! A design, and the baseline beside it, in fields drawn from what the room's measurements leave
//! possible: at the sensors of both at once, so that what the two share cancels.

use super::sampled::{Drawn, DrawnAt, DrawnFrom, Errors};
use crate::expected::DrawnTrials;
use crate::metric::MetricValues;
use crate::scenario::Scenario;
use crate::trial::Simulator;
use rayon::prelude::*;
use trackwright_field::Environment;

/// Sensor poses of each of the two at which a field is drawn.
const MOST_POINTS: usize = 450;

/// Figures of a design, and of the baseline in the same fields.
pub(super) struct MeasuredFields {
    pub own: Drawn,
    pub baseline: Option<Drawn>,
}

impl MeasuredFields {
    /// `None` where no pose is left, a body has markers, or the process has no answer.
    pub fn draw(
        environment: &Environment,
        own: (&Scenario, &DrawnAt),
        baseline: Option<(&Scenario, &DrawnAt)>,
        draws: usize,
        seed: u64,
    ) -> Option<Self> {
        let thinned = |(scenario, at): (&Scenario, &DrawnAt)| {
            at.thinned(MOST_POINTS / scenario.tool.sensors.len().max(1))
        };
        let own_at = thinned(own);
        let own_simulator = Simulator::new(own.0);
        let own_trials = DrawnTrials::new(&own_simulator, environment, own_at.trials().to_vec())?;
        let baseline_at = baseline.map(thinned);
        let baseline_simulator = baseline.map(|(scenario, _)| Simulator::new(scenario));
        let baseline_trials = match (&baseline_simulator, &baseline_at) {
            (Some(simulator), Some(at)) => {
                Some(DrawnTrials::new(simulator, environment, at.trials().to_vec())?)
            }
            _ => None,
        };
        let mut points = own_trials.points().to_vec();
        points.extend(baseline_trials.iter().flat_map(|t| t.points()));
        let posterior = match &environment.process {
            Some(process) => Some(process.posterior(&points).ok()?),
            None => None,
        };
        let fields = posterior.as_ref().map(|posterior| posterior.draws(draws, seed));
        let split = own_trials.points().len();
        let drawn = |at: &DrawnAt, trials: &DrawnTrials, part: std::ops::Range<usize>| {
            let fields = fields.as_ref();
            let own = fields.map(|all| all.iter().map(|f| f[part.clone()].to_vec()).collect());
            let fields = trials.fields_of(own, draws, 0);
            let figures = |draw: usize| -> Option<MetricValues> {
                let errors = trials.errors(&fields.errors(trials, draw));
                let errors: Vec<Errors> = errors.into_iter().map(Some).collect();
                at.figures_of(&errors)
            };
            let draws: Option<Vec<_>> = (0..draws).into_par_iter().map(figures).collect();
            let own_field: Vec<Errors> =
                trials.model_trial_errors().into_iter().map(Some).collect();
            Some(Drawn {
                nominal: at.figures_of(&own_field)?,
                draws: draws?,
                from: DrawnFrom::Measurements,
            })
        };
        Some(Self {
            own: drawn(&own_at, &own_trials, 0..split)?,
            baseline: match (&baseline_at, &baseline_trials) {
                (Some(at), Some(trials)) => Some(drawn(at, trials, split..points.len())?),
                _ => None,
            },
        })
    }
}
