//! Harmonic models of a generator on the rows held out: which degree, and which ridge.

use super::judge::{Judge, rest};
use super::kinds::{KindError, KindScored};
use crate::room_model::{
    GeneratorChoice, HarmonicOrder, HarmonicTable, RoomModel, RoomModelError, predicted,
};
use rayon::prelude::*;
use std::collections::HashMap;
use trackwright_field::harmonic::learn::degree_for;
use trackwright_field::harmonic::{DEFAULT_RIDGE, HarmonicFitSettings, LearnedGenerator, Loss};
use trackwright_field::samples::MapKind;
use trackwright_field::selection::folds::Folds;
use trackwright_field::selection::other::{OtherScored, score};
use trackwright_field::selection::scoring::{HeldOutScores, Residual};
use trackwright_field::selection::{HoldOuts, SelectError, TOLERANCE};
use trackwright_task::Task;

/// Degrees in a row that leave no less, after which none beyond is tried.
const WORSE_DEGREES: usize = 2;

/// Ridges, the largest first; every second one is tried, and then those beside the best. Rows along a path do not
/// determine the fields at other axes: on six paths of `tests/rooms/others.rs`, at degree 6, a ridge of 1e-6
/// leaves 30 to 120 times what 1e-2 or 1e-1 does of rows held out. In a box it leaves 1.0 to 1.2 times as much.
const RIDGES: [f64; 7] = [1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-5, DEFAULT_RIDGE];

/// A generator is tried no further where it leaves so many times what another kind does of the first rows held
/// out; a known one much sooner, as the tracker's own leaves far less.
const BEHIND: f64 = 2.0;
const BEHIND_OF_KNOWN: f64 = 0.9;

/// Settings that are judged where nothing ends early, for progress only.
const USUAL_SETTINGS: usize = 11;

/// The degree and the ridge that leave least by the deciding hold-out; a learned generator is learned in every fold
/// anew.
pub(super) fn judged(
    judge: &Judge<'_>,
    (generator, degrees, loss): (&GeneratorChoice, &[usize], Loss),
    before: &[KindScored],
    task: &Task,
) -> Result<KindScored, KindError> {
    if judge.tried.map != MapKind::Distortion {
        return Err(RoomModelError::CorrectionMap.into());
    }
    let mut degrees = degrees.to_vec();
    degrees.sort_unstable();
    let (Some(&least), Some(&most)) = (degrees.first(), degrees.last()) else {
        return Err(SelectError::NothingToTry("degrees").into());
    };
    let table = HarmonicTable::new(judge.samples, generator, most, &task.subtask(0.0, 0.5))?;
    let mut folds = FoldTables { judge, all: &table, most, of: HashMap::new(), task };
    let determined = degree_for(judge.samples.samples.len());
    let first = degrees.iter().rev().copied().find(|&d| d <= determined).unwrap_or(least);
    folds.refuse_behind_in_one_fold((first, loss), before)?;
    let mut search = Search { folds, best: None, loss, judged: 0 };
    search.ridges_of(first)?;
    search.degrees_around(first, &degrees)?;
    search.ridges_beside_best()?;
    let (settings, scores) = search.best.ok_or(SelectError::NothingToTry("degrees"))?;
    let model = RoomModel::Harmonic(HarmonicOrder {
        generator: match &table.learned {
            None => generator.clone(),
            learned => GeneratorChoice::Learned(learned.clone()),
        },
        degree: Some(settings.degree),
        ridge: Some(settings.ridge),
        loss,
    });
    Ok(KindScored { model, candidate: None, scores })
}

/// Every second ridge.
fn first_ridges() -> impl ExactSizeIterator<Item = f64> {
    RIDGES.into_iter().step_by(2)
}

/// The settings that leave least so far.
struct Search<'a> {
    folds: FoldTables<'a>,
    best: Option<(HarmonicFitSettings, OtherScored)>,
    loss: Loss,
    judged: usize,
}

impl Search<'_> {
    fn ridges_of(&mut self, degree: usize) -> Result<(), KindError> {
        first_ridges().try_for_each(|ridge| self.is_better(degree, ridge).map(drop))
    }

    /// Degrees below the first, or else above it, as long as they leave less; of a sorted list.
    fn degrees_around(&mut self, first: usize, degrees: &[usize]) -> Result<(), KindError> {
        let Some((HarmonicFitSettings { ridge, .. }, _)) = self.best else {
            return Ok(());
        };
        let lower = degrees.iter().rev().filter(|degree| **degree < first);
        let higher = degrees.iter().filter(|degree| **degree > first);
        let sides: [Vec<usize>; 2] = [lower.copied().collect(), higher.copied().collect()];
        for side in sides {
            if self.best.as_ref().is_some_and(|(best, _)| best.degree < first) {
                break;
            }
            let mut worse = 0;
            for degree in side {
                worse = if self.is_better(degree, ridge)? { 0 } else { worse + 1 };
                if worse == WORSE_DEGREES {
                    break;
                }
            }
        }
        Ok(())
    }

    fn ridges_beside_best(&mut self) -> Result<(), KindError> {
        let Some((HarmonicFitSettings { degree, ridge, .. }, _)) = self.best else {
            return Ok(());
        };
        for pair in RIDGES.windows(2).filter(|pair| pair.contains(&ridge)) {
            for &other in pair.iter().filter(|other| **other != ridge) {
                self.is_better(degree, other)?;
            }
        }
        Ok(())
    }

    /// Whether other settings leave less; not those of which the rows do not determine the coefficients.
    fn is_better(&mut self, degree: usize, ridge: f64) -> Result<bool, KindError> {
        let settings = HarmonicFitSettings { degree, ridge, loss: self.loss };
        let scores = match self.folds.score(&settings) {
            Err(error) if !error.is_cancelled() && self.best.is_some() => return Ok(false),
            scores => scores?,
        };
        self.judged += 1;
        let of = 2 * USUAL_SETTINGS.max(self.judged);
        self.folds.task.step(USUAL_SETTINGS + self.judged, of).map_err(SelectError::from)?;
        let rms = |scores: &OtherScored| scores.deciding().overall.position_rms_mm;
        let least = self.best.as_ref().map_or(f64::INFINITY, |(_, best)| rms(best));
        let is_better = rms(&scores) < (1.0 - TOLERANCE) * least;
        if is_better {
            self.best = Some((settings, scores));
        }
        Ok(is_better)
    }
}

/// Rows made ready for the harmonic models of each fold: the same where the generator is known; learned
/// again without the fold, from the generator of all rows, where it is not.
struct FoldTables<'a> {
    judge: &'a Judge<'a>,
    all: &'a HarmonicTable,
    most: usize,
    /// Those that were learned, by the rows of their fold.
    of: HashMap<Vec<usize>, HarmonicTable>,
    task: &'a Task,
}

impl FoldTables<'_> {
    fn score(&mut self, settings: &HarmonicFitSettings) -> Result<OtherScored, KindError> {
        let judge = self.judge;
        score(judge.samples, &judge.hold_outs(), judge.tried, |folds| {
            self.residuals(folds, settings)
        })
    }

    /// Judges the first fold of the deciding hold-out alone, which shows a generator that is another one's. With a
    /// strong ridge that may leave little too, so that a known one is judged with the default.
    fn refuse_behind_in_one_fold(
        &mut self,
        (degree, loss): (usize, Loss),
        before: &[KindScored],
    ) -> Result<(), KindError> {
        let judge = self.judge;
        let Some(other) = before.first().filter(|_| judge.tried.only_contenders) else {
            return Ok(());
        };
        let deciding = HoldOuts { only_deciding: true, ..judge.hold_outs() };
        let deciding = HoldOuts { deciding: Some(other.scores.decided_by), ..deciding };
        let (times, ridges) = match self.all.learned {
            None => (BEHIND_OF_KNOWN, vec![DEFAULT_RIDGE]),
            Some(_) => (BEHIND, first_ridges().collect()),
        };
        let mut refused = Ok(());
        for ridge in ridges {
            let settings = HarmonicFitSettings { degree, ridge, loss };
            let scores = score(judge.samples, &deciding, judge.tried, |folds| {
                self.residuals(&Folds { rows: vec![folds.rows[0].clone()] }, &settings)
            })?;
            let (_, scores) = &scores.hold_outs[0];
            let one = HeldOutScores::of_sums(vec![scores.by_fold[0]], judge.samples.has_rotations);
            refused = judge.refuse_behind(times, &one, before);
            if refused.is_ok() {
                break;
            }
        }
        refused
    }

    fn residuals(
        &mut self,
        folds: &Folds,
        settings: &HarmonicFitSettings,
    ) -> Result<Vec<Option<Residual>>, KindError> {
        self.make(folds)?;
        let (judge, task) = (self.judge, self.task);
        judge.each_fold(folds, |out, rest| {
            let table = self.of.get(out).unwrap_or(self.all);
            let fitted = table.fit(Some(rest), settings, &quiet(task));
            let model = fitted.map_err(RoomModelError::from)?.model;
            Ok(out.iter().map(|&row| predicted(&model, &judge.samples.samples[row])).collect())
        })
    }

    /// Learns without each fold, where the generator is learned.
    fn make(&mut self, folds: &Folds) -> Result<(), RoomModelError> {
        let Some(learned) = &self.all.learned else {
            return Ok(());
        };
        let missing = folds.rows.iter().filter(|out| !self.of.contains_key(*out));
        let learned: Result<Vec<_>, RoomModelError> = missing
            .par_bridge()
            .map(|out| Ok((out.clone(), self.learned_without(out, learned)?)))
            .collect();
        self.of.extend(learned?);
        Ok(())
    }

    fn learned_without(
        &self,
        out: &[usize],
        learned: &LearnedGenerator,
    ) -> Result<HarmonicTable, RoomModelError> {
        let samples = self.judge.samples;
        let from = rest(out, samples.samples.len());
        let quiet = quiet(self.task);
        HarmonicTable::learned_again(samples, &from, learned, self.most, &quiet)
    }
}

fn quiet(task: &Task) -> Task {
    Task::cancelled_by(task.cancel.clone())
}
