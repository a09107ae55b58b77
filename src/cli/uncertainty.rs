//! `simulate --uncertainty`: how far jitter scatters the tip, by formula, by Monte Carlo, or both.

use super::jitter::JitterArgs;
use super::prelude::*;
use clap::ValueEnum;
use nalgebra::Matrix3;
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_report::uncertainty::{
    DEFAULT_SAMPLES, Sampling, UncertaintyMethods, UncertaintyReport,
};
use trackwright_simulation::Metric;
use trackwright_simulation::uncertainty::{
    Estimate, FirstOrderCheck, MAX_SAMPLES, MIN_SAMPLES, MonteCarlo, MotionUncertainty,
    TipUncertainty, UncertaintyError,
};
use trackwright_simulation::{Mode, RoomFieldFigures, Scenario};
use trackwright_task::Task;

/// Degrees a radian.
const DEG: f64 = 180.0 / std::f64::consts::PI;

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

/// For a person, below `simulate`'s figures, which are those without jitter.
pub fn as_text(report: &UncertaintyReport, figures: &RoomFieldFigures) -> String {
    let mut lines = vec![
        String::new(),
        format!(
            "jitter {:.4} mm and {:.4} ° an axis{}, from the {}",
            report.jitter.position_mm,
            report.jitter.angle_rad * DEG,
            report.jitter.growth.map_or_else(String::new, |g| format!(
                ", growing beyond {} mm with the distance to the powers {} and {}",
                g.distance_mm, g.position_exponent, g.angle_exponent
            )),
            report.jitter_source
        ),
        format!(
            "orientation weight {:.4} mm, {}",
            report.weight.value_mm,
            report.weight.source.label()
        ),
    ];
    lines.extend(table(report));
    if let Some((tip, check)) = &report.first_order {
        lines.extend(verdicts(tip, check.as_ref()));
    }
    if let Some(over) = &report.motion {
        let total_rms_mm = over.total_rms_mm(figures.position_mm.rms());
        lines.push(motion_rows(over, total_rms_mm));
        if over.free_axis.is_some() {
            lines.push(
                "a rotation is not determined; the scatter is that with the true one".to_owned(),
            );
        }
    }
    lines.join("\n")
}

/// First order and Monte Carlo side by side, whichever there is.
fn table(report: &UncertaintyReport) -> Option<String> {
    let tip = report.first_order.as_ref().map(|(tip, _)| tip);
    let sampled = report.monte_carlo.as_ref();
    if tip.is_none() && sampled.is_none() {
        return None;
    }
    let head = |is_there: bool, name: &str| if is_there { name } else { "" }.to_owned();
    let (formula, samples) =
        (head(tip.is_some(), "first order"), head(sampled.is_some(), "Monte Carlo"));
    let mut rows = vec![[String::new(), formula, samples, String::new()]];
    let mut row = |label: String, formula: Option<f64>, found: Option<(f64, f64)>, unit: &str| {
        let formula = formula.map_or_else(String::new, |v| format!("{v:.4}"));
        let found = found.map_or_else(String::new, |(v, e)| format!("{v:.4} ± {e:.4}"));
        rows.push([label, formula, found, unit.to_owned()]);
    };
    let of = |estimate: fn(&MonteCarlo) -> Estimate| {
        sampled.map(estimate).map(|found| (found.value, found.std_error))
    };
    // Of normal values; the distribution of the tip is close enough to one for this.
    let of_spread = |value: f64, m: &MonteCarlo| (value, value / (2.0 * m.samples as f64).sqrt());
    row("tip scatter RMS".into(), tip.map(|t| t.rms_mm), of(|m| m.rms_mm), "mm");
    let std = |covariance: &Matrix3<f64>, k| f64::max(covariance[(k, k)], 0.0).sqrt();
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let found = sampled.map(|m| of_spread(std(&m.covariance_mm2, k), m));
        let formula = tip.map(|t| std(&t.covariance_mm2, k));
        row(format!("tip scatter {axis}"), formula, found, "mm");
    }
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let found = sampled.map(|m| (m.mean_error_mm[k], m.mean_std_error_mm[k]));
        row(format!("tip shift {axis}"), tip.map(|t| t.bias_mm[k]), found, "mm");
    }
    let total = tip.map(|t| t.total_rms_mm);
    let label = format!("{}, shift and scatter", Metric::TIP_RMS.label());
    row(label, total, of(|m| m.total_rms_mm), "mm");
    if sampled.is_some() {
        row(Metric::TIP_MEDIAN.label().into(), None, of(|m| m.median_mm), "mm");
        row(Metric::TIP_P95.label().into(), None, of(|m| m.p95_mm), "mm");
    }
    let found = sampled.map(|m| of_spread(m.rotation_rms_rad * DEG, m));
    row("rotation scatter RMS".into(), tip.map(|t| t.rotation_rms_rad * DEG), found, "°");
    Some(side_by_side(&rows))
}

/// Rows of label, two values and unit, aligned.
fn side_by_side(rows: &[[String; 4]]) -> String {
    let width = |k: usize| rows.iter().map(|r| r[k].chars().count()).max().unwrap_or(0);
    let (label, a, b) = (width(0), width(1), width(2));
    let gap = if a > 0 && b > 0 { "  " } else { "" };
    rows.iter()
        .map(|[l, v, s, u]| format!("{l:<label$}  {v:>a$}{gap}{s:>b$} {u}").trim_end().to_owned())
        .collect::<Vec<_>>()
        .join("\n")
}

/// Whether the first order holds, the ellipsoid, and what is not determined.
fn verdicts(tip: &TipUncertainty, check: Option<&FirstOrderCheck>) -> Vec<String> {
    let [a, b, c] = tip.ellipsoid.lengths_mm();
    let mut lines = vec![format!(
        "95 % of the scatter lies in an ellipsoid with semi-axes {a:.4}, {b:.4} and {c:.4} mm"
    )];
    lines.push(match check {
        None => "first order: not checked, there are too many sensors; request monte-carlo too"
            .to_owned(),
        Some(check) if check.holds => format!(
            "first order holds for the scatter: the next order differs by {:.3} %",
            100.0 * check.relative_difference
        ),
        Some(check) => format!(
            "first order does not hold for the scatter: the next order gives {:.4} mm, {:.1} % \
             away; trust monte-carlo",
            check.next_order_rms_mm,
            100.0 * check.relative_difference
        ),
    });
    let bias = &tip.bias_check;
    let simulated_mm = bias.simulated_mm.norm();
    lines.push(format!(
        "first order {} for the shift: {:.4} mm from the simulated one of {simulated_mm:.4} mm",
        if bias.holds { "holds" } else { "does not hold" },
        bias.difference_mm,
    ));
    if let Some(part) = &tip.determined {
        lines.push(format!(
            "the {}'s rotation is not determined; what it cannot change of the tip scatters by \
             {:.4} mm RMS and is shifted by {:.4} mm",
            part.free_axis.body,
            part.rms_mm,
            part.bias_mm.norm()
        ));
    }
    lines
}

fn motion_rows(over: &MotionUncertainty, total_rms_mm: f64) -> String {
    output::aligned(&[
        number("tip scatter RMS, first order", over.rms_mm.rms(), 4, "mm"),
        number("tip scatter mean", over.rms_mm.mean(), 4, "mm"),
        number("tip scatter max", over.rms_mm.max(), 4, "mm"),
        number("rotation scatter RMS, first order", over.rotation_rms_deg.rms(), 4, "°"),
        number(format!("{}, shift and scatter", Metric::TIP_RMS.label()), total_rms_mm, 4, "mm"),
    ])
}
