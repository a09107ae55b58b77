//! The study: how few poses still determine the tip error RMS of a range of motion.

use super::{Bench, Row, Settings, Stop, What};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardUniform};
use sobol::Sobol;
use sobol::params::JoeKuoD6;
use trackwright_result::with_separators;
use trackwright_simulation::motion::MotionGrid;
use trackwright_simulation::{AxisRange, InputTrial, Mode, Motion, Scenario, StudyError};
use trackwright_task::CancelToken;

/// The figure that `simulate` prints: over the poses of the design's grid.
const GRID: &str = "the design's grid of poses";
/// The same figure over everything that the range of motion allows, each pose as likely.
const RANGE: &str = "the whole range of motion";

/// Poses of a Sobol sequence: powers of two, at which it is even.
const SOBOL_COUNTS: [usize; 8] = [16, 32, 64, 128, 256, 512, 1024, 2048];

/// Shifts of a sequence that its error is taken over: one alone is right or wrong by luck.
const SHIFTS: usize = 16;

/// Sequences that the reference of the range is the mean of.
const REFERENCE_SEQUENCES: usize = 8;

/// A grid that is larger is not run several times over.
const MAX_GRID: usize = 300_000;

/// Grids and sequences of fewer poses.
pub fn measure(bench: &mut Bench) -> Result<(), Stop> {
    let (scenario, settings, cancel) = (bench.scenario, bench.settings, &bench.task.cancel);
    bench.family.charted = GRID.to_owned();
    let motion = scenario.motion.ok_or_else(|| bench.stop("the design has no range of motion"))?;
    bench.need_field("every tip error is zero")?;
    let sampling = Sampling::new(scenario, motion).map_err(|why| bench.stop(why))?;
    let choices = sampling.choices();
    bench.steps = 2 * choices.len() + 2;
    bench.next()?;
    let (of_grid, of_range) =
        references(&sampling, settings, cancel).map_err(|error| bench.stop(error))?;
    bench.family.about = format!(
        "Tip error RMS of the design's study, on all threads; size is the number of poses. Over \
         the design's grid of poses the reference is the full grid, which is what `simulate` \
         prints. Over the whole range of motion, each pose as likely, it is {} other poses, whose \
         standard error is {:.1e} mm. The grid counts the ends of the range as much as its middle, \
         so the two figures differ. The error of a Sobol sequence is the root mean square over \
         {SHIFTS} shifts of it.",
        with_separators(settings.motion_reference),
        of_range.std_error_mm
    );
    bench.next()?;
    let problems =
        [(GRID, of_grid, "of the grid"), (RANGE, of_range.rms_mm, "of the range")].into_iter();
    for ((problem, reference, of), choice) in
        problems.flat_map(|problem| choices.iter().map(move |choice| (problem, *choice)))
    {
        let all_poses = sampling.poses(choice, problem == GRID, settings.seed);
        let (seconds, first) = settings.timing.measure(|| all_poses[0].rms(cancel));
        let others = all_poses[1..].iter().map(|poses| poses.rms(cancel));
        let found: Result<Vec<f64>, StudyError> = [first].into_iter().chain(others).collect();
        bench.next()?;
        // A few poses may all be rejected; then there is no figure to compare.
        let Ok(found) = found else { continue };
        let squares = found.iter().map(|found| (found - reference).powi(2));
        let mean_square = squares.sum::<f64>() / found.len() as f64;
        let is_default = problem == GRID && choice == Choice::Grid { stride: 1 };
        let (method, series) = choice.words();
        let row = Row::new(What::Motion, bench.room(), problem, &method);
        let row = row.measured(all_poses[0].count, seconds, mean_square.sqrt());
        let row = row.default_if(is_default).step_of(&format!("{series}, RMS {of}"));
        bench.family.rows.push(row);
    }
    Ok(())
}

/// Tip error RMS over the whole range, and how well it is known.
struct OfRange {
    rms_mm: f64,
    std_error_mm: f64,
}

/// What the errors are differences from: over the grid, over the range.
///
/// The range's is that of several long Sobol sequences, whose spread shows how far it may be off; a
/// grid of cell middles, of as many poses in six dimensions, is 1e-3 mm off in the built-in design.
fn references(
    sampling: &Sampling,
    settings: &Settings,
    cancel: &CancelToken,
) -> Result<(f64, OfRange), StudyError> {
    let of_grid = sampling.grid(1).rms(cancel)?;
    let count = settings.motion_reference / REFERENCE_SEQUENCES;
    let mut rng = ChaCha8Rng::seed_from_u64(settings.seed + 1);
    let squares = (0..REFERENCE_SEQUENCES)
        .map(|_| {
            let found = sampling.sobol(count, false, &mut rng).rms(cancel)?;
            Ok(found * found)
        })
        .collect::<Result<Vec<f64>, StudyError>>()?;
    let n = squares.len() as f64;
    let mean = squares.iter().sum::<f64>() / n;
    let variance = squares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let rms_mm = mean.sqrt();
    Ok((
        of_grid,
        OfRange {
            rms_mm,
            // Of a square, halved by the root's slope.
            std_error_mm: (variance / n).sqrt() / (2.0 * rms_mm).max(f64::MIN_POSITIVE),
        },
    ))
}

/// Poses to visit.
struct Poses {
    scenario: Scenario,
    mode: Mode,
    count: usize,
}

impl Poses {
    /// Tip error RMS over them.
    fn rms(&self, cancel: &CancelToken) -> Result<f64, StudyError> {
        let outcome = trackwright_simulation::run(&self.scenario, &self.mode, cancel, None);
        outcome.map(|o| o.room_field.position_mm.rms())
    }
}

/// One way to choose poses.
#[derive(Clone, Copy, PartialEq)]
enum Choice {
    /// The design's grid with steps so many times as long.
    Grid { stride: usize },
    /// So many poses of a Sobol sequence.
    Sobol { count: usize },
}

impl Choice {
    /// The method's name, and its series'.
    fn words(self) -> (String, &'static str) {
        match self {
            Self::Grid { stride: 1 } => ("full grid".to_owned(), "grids"),
            Self::Grid { stride } => (format!("grid with steps {stride} times as long"), "grids"),
            Self::Sobol { count } => (format!("Sobol, {count} poses"), "Sobol sequence"),
        }
    }
}

/// A range of motion that can be sampled.
struct Sampling<'a> {
    scenario: &'a Scenario,
    grid: MotionGrid,
}

impl<'a> Sampling<'a> {
    /// # Errors
    /// Why there is nothing to sample.
    fn new(scenario: &'a Scenario, motion: Motion) -> Result<Self, String> {
        let tip_in_tool = scenario.tool.judged_tip_in_body();
        let grid = motion.grid(&scenario.crf_from_tool, &tip_in_tool);
        let grid = grid.map_err(|e| e.to_string())?;
        match grid.trials() {
            0 | 1 => return Err("the design's range of motion is a single pose".to_owned()),
            trials if trials > MAX_GRID => {
                return Err(format!(
                    "the design's range of motion has {trials} poses, more than {MAX_GRID} that \
                     would be run several times over"
                ));
            }
            _ => {}
        }
        Ok(Self { scenario, grid })
    }

    fn choices(&self) -> Vec<Choice> {
        let trials = self.grid.trials();
        let grids = [1, 2, 4].map(|stride| Choice::Grid { stride });
        let counts = SOBOL_COUNTS.into_iter().filter(|&count| count < trials);
        grids.into_iter().chain(counts.map(|count| Choice::Sobol { count })).collect()
    }

    /// The poses of a choice: one set, or one a shift of a sequence.
    fn poses(&self, choice: Choice, of_grid: bool, seed: u64) -> Vec<Poses> {
        match choice {
            Choice::Grid { stride } => vec![self.grid(stride)],
            Choice::Sobol { count } => {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                (0..SHIFTS).map(|_| self.sobol(count, of_grid, &mut rng)).collect()
            }
        }
    }

    /// The design's grid with longer steps.
    fn grid(&self, stride: usize) -> Poses {
        let axes = self.grid.motion().axes();
        let [x, y, z, rx, ry, rz] = std::array::from_fn(|k| {
            axes[k].1.map(|range| AxisRange { step: range.step * stride as f64, ..range })
        });
        let motion = Motion { x, y, z, rx, ry, rz, ..*self.grid.motion() };
        let count = motion.trials().unwrap_or(0);
        let scenario = Scenario { motion: Some(motion), ..self.scenario.clone() };
        Poses { scenario, mode: Mode::Motion, count }
    }

    /// Poses of a Sobol sequence, of the grid or of anywhere in the range. A random mask shifts it bit
    /// by bit, which leaves it as even as it is.
    fn sobol(&self, count: usize, of_grid: bool, rng: &mut ChaCha8Rng) -> Poses {
        let mask: [u32; 6] = std::array::from_fn(|_| StandardUniform.sample(rng));
        let axes = self.grid.motion().axes();
        let counts = self.grid.counts();
        let params = JoeKuoD6::minimal();
        let trials = Sobol::<u32>::new(6, &params).take(count).map(|point| {
            let values = std::array::from_fn(|k| {
                let Some(range) = axes[k].1 else { return 0.0 };
                let cells = counts[k];
                let part = (f64::from(point[k] ^ mask[k]) + 0.5) / 2.0_f64.powi(32);
                if cells < 2 {
                    range.min
                } else if of_grid {
                    range.min + ((part * cells as f64) as usize).min(cells - 1) as f64 * range.step
                } else {
                    range.min + part * (range.max - range.min)
                }
            });
            InputTrial::at(self.grid.moved(values))
        });
        let mode = Mode::Input(trials.collect());
        Poses { scenario: self.scenario.clone(), mode, count }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::{Family, testing};
    use trackwright_simulation::{Statistics, Summary};

    fn rows(scenario: &Scenario) -> Family {
        let settings = Settings { motion_reference: 20_000, ..Settings::default() };
        testing::family(What::Motion, scenario, settings)
    }

    #[test]
    fn the_full_grid_is_what_simulate_prints() {
        let family = rows(&testing::built_in());
        let full = family.rows.iter().find(|r| r.is_default).unwrap();
        assert_eq!((full.size, full.error), (3375, 0.0));
    }

    /// Independent draws would miss the RMS by `σ(d²) / (2 RMS √n)`; a sequence that fills the
    /// range evenly misses it by less. Over 16 shifts an error is known to some 18 %.
    #[test]
    fn a_sobol_sequence_is_closer_than_chance() {
        let scenario = testing::built_in();
        let mut squares = Vec::new();
        let mut keep = |t: &trackwright_simulation::Trial| squares.push(t.tip_error_mm.powi(2));
        let cancel = CancelToken::default();
        trackwright_simulation::run(&scenario, &Mode::Motion, &cancel, Some(&mut keep)).unwrap();
        let of_squares = Statistics::of(&mut squares).unwrap();
        let family = rows(&scenario);
        let sequences = family.rows.iter().filter(|r| r.method.starts_with("Sobol"));
        for row in sequences.filter(|r| r.size >= 64) {
            let by_chance = of_squares.get(Summary::Std)
                / (2.0 * of_squares.mean().sqrt() * (row.size as f64).sqrt());
            assert!(row.error < by_chance, "{row:?} {by_chance}");
        }
    }

    /// Along one axis a grid of 4,000 cell middles is as good as exact.
    #[test]
    fn the_range_is_known_as_well_as_is_stated() {
        let along_x = |min, step| {
            let x = Some(AxisRange { min, max: 20.0, step });
            let motion = Motion { x, ..Motion::default() };
            Scenario { motion: Some(motion), ..testing::built_in() }
        };
        let scenario = along_x(-20.0, 5.0);
        let sampling = Sampling::new(&scenario, scenario.motion.unwrap()).unwrap();
        let cancel = CancelToken::default();
        let (_, of_range) = references(&sampling, &Settings::quick(), &cancel).unwrap();
        let middles = along_x(-20.0 + 0.005, 0.01);
        let exact = trackwright_simulation::run(&middles, &Mode::Motion, &cancel, None).unwrap();
        assert_eq!(exact.room_field.trials, 4000);
        let off = (of_range.rms_mm - exact.room_field.position_mm.rms()).abs();
        assert!(of_range.std_error_mm > 0.0 && of_range.std_error_mm < 1e-3);
        // The standard error is itself known from eight sequences only.
        assert!(off < 5.0 * of_range.std_error_mm, "{off:e} {:e}", of_range.std_error_mm);
    }

    #[test]
    fn a_design_without_motion_is_left_out() {
        let mut scenario = testing::built_in();
        scenario.motion = None;
        let family = rows(&scenario);
        assert!(family.rows.is_empty());
        assert_eq!(family.left_out.as_deref(), Some("the design has no range of motion"));
    }
}
