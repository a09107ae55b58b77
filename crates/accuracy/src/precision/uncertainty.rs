//! The tip's uncertainty: the first order, the next order, and Monte Carlo of more and more
//! samples, against a larger one of another seed.

use super::{Bench, Stop};
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_field::environment::Jitter;
use trackwright_result::with_separators;
use trackwright_simulation::Scenario;
use trackwright_simulation::uncertainty::{
    UncertaintyError, check_first_order, first_order, monte_carlo,
};

/// Samples of a Monte Carlo, so far as the settings allow.
const COUNTS: [usize; 5] = [100, 1_000, 10_000, 100_000, 1_000_000];

/// Samples that an error is taken over: several Monte Carlos of few samples, one of many.
const SAMPLES_AN_ERROR: usize = 200_000;
const MAX_SEEDS: usize = 16;

/// Where a room states no jitter: that of a 5-DOF coil (`docs/methods/built-tool.md`).
const USUAL_JITTER_MM: f64 = 0.5;
const USUAL_JITTER_DEG: f64 = 0.3;

/// First order, next order and Monte Carlo.
pub fn measure(bench: &mut Bench) -> Result<(), Stop> {
    bench.family.charted = "tip scatter at the design's pose".to_owned();
    let (scenario, jitter) = with_jitter(bench.scenario);
    let std_error_mm = rows(bench, &scenario).map_err(|error| bench.stop(error))?;
    bench.family.about = format!(
        "RMS distance of the tip from its mean under the sensors' jitter, at the design's \
         pose; {jitter}. Monte Carlo runs on all threads, size is the number of its \
         samples, and its error is the root mean square over up to {MAX_SEEDS} seeds. The \
         reference is a Monte Carlo of {} samples with another seed, whose standard error \
         is {std_error_mm:.1e} mm: smaller errors are not resolved.",
        with_separators(bench.settings.monte_carlo_reference)
    );
    Ok(())
}

/// The scenario in a room that states its jitter, and whose it is.
fn with_jitter(scenario: &Scenario) -> (Scenario, String) {
    if scenario.environment.jitter.is_some() {
        return (scenario.clone(), "the jitter is the room's".to_owned());
    }
    let jitter = Jitter::uniform(USUAL_JITTER_MM, USUAL_JITTER_DEG.to_radians());
    let environment =
        Environment { jitter: Some(jitter), ..Environment::clone(&scenario.environment) };
    let scenario = Scenario { environment: Arc::new(environment), ..scenario.clone() };
    let assumption = format!(
        "the room states no jitter, so {USUAL_JITTER_MM} mm and {USUAL_JITTER_DEG}° are taken"
    );
    (scenario, assumption)
}

/// Measures all rows; the reference's standard error.
fn rows(bench: &mut Bench, scenario: &Scenario) -> Result<f64, UncertaintyError> {
    let (settings, task) = (bench.settings, bench.own_task());
    let counts = COUNTS.into_iter().filter(|&c| c <= settings.monte_carlo_samples);
    bench.steps = counts.clone().count() + 3;
    let reference_seed = settings.seed + 1000;
    let reference =
        monte_carlo(scenario, settings.monte_carlo_reference, reference_seed, &task)?.rms_mm;
    bench.next()?;
    let (seconds, first) = settings.timing.measure(|| first_order(scenario));
    let error = (first?.rms_mm - reference.value).abs();
    bench.add(bench.row("first order").measured(1, seconds, error).default_if(true))?;
    let (seconds, next) = settings.timing.measure(|| {
        let first = first_order(scenario)?;
        check_first_order(scenario, &first)
    });
    // None for a body of so many sensors that it would cost more than Monte Carlo.
    if let Some(next) = next? {
        let error = (next.next_order_rms_mm - reference.value).abs();
        let row = bench.row("next order, as a check");
        bench.family.rows.push(row.measured(1, seconds, error));
    }
    bench.next()?;
    for count in counts {
        let seeds = (SAMPLES_AN_ERROR / count).clamp(1, MAX_SEEDS) as u64;
        let estimate = |seed| monte_carlo(scenario, count, seed, &task).map(|m| m.rms_mm.value);
        let (seconds, first) = settings.timing.measure(|| estimate(settings.seed));
        let mut squares = (first? - reference.value).powi(2);
        for k in 1..seeds {
            squares += (estimate(settings.seed + k)? - reference.value).powi(2);
        }
        let error = (squares / seeds as f64).sqrt();
        let row = bench.row(&format!("Monte Carlo, {} samples", with_separators(count)));
        bench.add(row.measured(count, seconds, error).step_of("Monte Carlo"))?;
    }
    Ok(reference.std_error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::{Family, Settings, What, testing};

    fn family() -> (Family, Scenario) {
        let settings = Settings {
            monte_carlo_samples: 10_000,
            monte_carlo_reference: 100_000,
            ..Settings::default()
        };
        let scenario = testing::built_in();
        (testing::family(What::Uncertainty, &scenario, settings), scenario)
    }

    /// A sample RMS of normal scatter misses by at least `RMS / √(6 n)`, all three axes alike,
    /// and at most `RMS / √(2 n)`, all of it along one. Over 16 seeds that is known to 18 %;
    /// three times that on either side is beyond chance.
    #[test]
    fn monte_carlo_error_falls_with_root_of_samples() {
        let (family, scenario) = family();
        let rms = first_order(&with_jitter(&scenario).0).unwrap().rms_mm;
        for count in [100_usize, 1_000, 10_000] {
            let row =
                family.rows.iter().find(|r| r.size == count).unwrap_or_else(|| panic!("{count}"));
            let unit = rms / (count as f64).sqrt();
            let (least, most) = (0.46 * unit / 6.0_f64.sqrt(), 1.54 * unit / 2.0_f64.sqrt());
            // The reference's own error is a third of that of 10,000 samples.
            assert!((least..1.1 * most).contains(&row.error), "{row:?} {unit}");
        }
    }

    #[test]
    fn first_order_is_the_default_within_two_percent() {
        let (family, scenario) = family();
        let rms = first_order(&with_jitter(&scenario).0).unwrap().rms_mm;
        let row = family.rows.iter().find(|r| r.is_default).unwrap();
        assert_eq!(row.method, "first order");
        assert!(row.error < 0.02 * rms, "{row:?}");
        assert!(family.about.contains("states no jitter"), "{}", family.about);
    }
}
