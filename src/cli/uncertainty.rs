//! `simulate --uncertainty`: how far jitter scatters the tip, by formula, by Monte Carlo, or both.

use super::jitter::JitterArgs;
use super::prelude::*;
use clap::ValueEnum;
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_simulation::uncertainty::{
    DEFAULT_SAMPLES, MAX_SAMPLES, MIN_SAMPLES, Sampling, UncertaintyError, UncertaintyMethods,
    UncertaintyReport,
};
use trackwright_simulation::{Mode, Scenario};
use trackwright_task::Task;

#[derive(Debug, Args)]
pub struct UncertaintyArgs {
    /// Also report how far the tracker's jitter scatters the tip; both methods with
    /// `first-order,monte-carlo`. Over a range of motion, only first-order
    #[arg(long, value_enum, value_delimiter = ',', value_name = "METHOD")]
    uncertainty: Vec<MethodArg>,

    /// Samples of the Monte Carlo [default: 100000]
    #[arg(long, value_name = "N", requires = "uncertainty")]
    samples: Option<usize>,

    /// Seed of the Monte Carlo: the same seed gives the same figures on any machine [default: 0]
    #[arg(long, value_name = "S", requires = "uncertainty")]
    seed: Option<u64>,

    #[command(flatten)]
    jitter: JitterArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodArg {
    /// The formula of error propagation, and whether it holds
    FirstOrder,
    /// Noise on every reading and the real frame fit, sample by sample
    MonteCarlo,
}

impl UncertaintyArgs {
    /// Whether anything of it is requested.
    pub fn is_requested(&self) -> bool {
        !self.uncertainty.is_empty() || self.jitter.jitter().is_some()
    }

    /// The environment, with the jitter of the command line where that states one.
    ///
    /// # Errors
    /// A jitter without anything to use it.
    pub fn environment(&self, environment: &Arc<Environment>) -> anyhow::Result<Arc<Environment>> {
        match self.jitter.jitter() {
            None => Ok(Arc::clone(environment)),
            Some(_) if self.uncertainty.is_empty() => {
                bail!("--jitter-position-mm needs --uncertainty")
            }
            Some(jitter) => {
                Ok(Arc::new(Environment { jitter: Some(jitter), ..(**environment).clone() }))
            }
        }
    }

    /// Refuses what cannot be done before anything is computed.
    ///
    /// # Errors
    /// A mode or a number of samples that the methods cannot do; no jitter.
    pub fn check(&self, scenario: &Scenario, mode: &Mode) -> anyhow::Result<()> {
        if self.uncertainty.is_empty() {
            return Ok(());
        }
        let has_monte_carlo = self.uncertainty.contains(&MethodArg::MonteCarlo);
        match mode {
            Mode::Input(_) => bail!("--uncertainty needs --mode single or --mode motion"),
            Mode::Motion if has_monte_carlo => bail!(
                "--uncertainty monte-carlo needs --mode single; over a range of motion there is \
                 --uncertainty first-order"
            ),
            Mode::Motion | Mode::Single => {}
        }
        for (name, is_given) in
            [("--samples", self.samples.is_some()), ("--seed", self.seed.is_some())]
        {
            if is_given && !has_monte_carlo {
                bail!("{name} needs --uncertainty monte-carlo");
            }
        }
        if let Some(found) = self.samples.filter(|n| !(MIN_SAMPLES..=MAX_SAMPLES).contains(n)) {
            bail!("--samples: {}", UncertaintyError::Samples { found });
        }
        if scenario.environment.jitter.is_none() {
            bail!(
                "{}; state it with --jitter-position-mm MM --jitter-angle-deg DEG, here or when \
                 `trackwright fit` writes the environment",
                UncertaintyError::NoJitter { environment: scenario.environment.name.clone() }
            );
        }
        Ok(())
    }

    /// The uncertainty, where it is requested.
    ///
    /// # Errors
    /// See [`UncertaintyError`].
    pub fn report(
        &self,
        scenario: &Scenario,
        design_weight_mm: Option<f64>,
        mode: &Mode,
    ) -> anyhow::Result<Option<UncertaintyReport>> {
        if self.uncertainty.is_empty() {
            return Ok(None);
        }
        let source = match self.jitter.jitter() {
            Some(_) => "command line",
            None => "environment",
        };
        let has = |method| self.uncertainty.contains(&method);
        let methods = UncertaintyMethods {
            first_order: has(MethodArg::FirstOrder),
            monte_carlo: has(MethodArg::MonteCarlo).then(|| Sampling {
                samples: self.samples.unwrap_or(DEFAULT_SAMPLES),
                seed: self.seed.unwrap_or_default(),
            }),
        };
        let shown = methods.monte_carlo.map(|_| Shown::new("sampling"));
        let task = shown.as_ref().map_or_else(Task::default, |shown| shown.task.clone());
        let of = (scenario, mode);
        Ok(Some(UncertaintyReport::of(of, source, design_weight_mm, &methods, &task)?))
    }
}
