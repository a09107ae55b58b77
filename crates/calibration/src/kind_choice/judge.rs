//! Each kind of model on the same rows held out.

use super::{BEHIND, KindError, KindScored, TriedKind};
use crate::room_choice::{Chosen, RowLabels};
use crate::room_model::{
    GeneratorChoice, HarmonicOrder, HarmonicTable, RoomModel, RoomModelError, predicted,
};
use crate::room_process::Refit;
use rayon::prelude::*;
use trackwright_field::fit::FitSettings;
use trackwright_field::gaussian::{GaussianField, Kriging, kept_rows};
use trackwright_field::harmonic::learn::degree_for;
use trackwright_field::harmonic::{HarmonicFitSettings, LearnedGenerator, Loss};
use trackwright_field::samples::{MapKind, PoseError, SampleSet};
use trackwright_field::selection::folds::Folds;
use trackwright_field::selection::other::score;
use trackwright_field::selection::scoring::{FoldSums, HeldOutScores, Residual};
use trackwright_field::selection::{
    Candidate, HoldOutBy, HoldOuts, SelectError, SelectSettings, TOLERANCE, select_by,
};
use trackwright_geometry::bounds::Bounds;
use trackwright_task::Task;

/// Degrees in a row that leave no less, after which no higher one is tried.
const WORSE_DEGREES: usize = 2;

/// What every kind is judged on.
pub(super) struct Judge<'a> {
    pub samples: &'a SampleSet,
    pub labels: &'a RowLabels,
    pub tried: &'a SelectSettings,
}

impl Judge<'_> {
    fn hold_outs(&self) -> HoldOuts<'_> {
        self.labels.hold_outs()
    }

    /// # Errors
    /// Rows that the kind cannot be fitted to, and [`KindError::Behind`] where it leaves far more than
    /// another that was judged before.
    pub fn judged(
        &self,
        kind: &TriedKind,
        chosen: &Chosen,
        before: &[KindScored],
        task: &Task,
    ) -> Result<KindScored, KindError> {
        match kind {
            TriedKind::NoCorrection => {
                let none = FitSettings::without_polynomials(self.tried.map);
                let candidate =
                    Candidate { order: 0, directions: none.directions, ridge: none.ridge };
                self.polynomials(candidate, false, task)
            }
            TriedKind::Bernstein => {
                self.polynomials(chosen.selection.best().candidate, false, task)
            }
            TriedKind::Symmetric => {
                // It has half as many unknowns, and leaves as much less at most.
                let polynomials = chosen.selection.best();
                self.refuse_behind(&polynomials.deciding, before)?;
                self.symmetric(chosen.selection.decided_by, polynomials.candidate.order, task)
            }
            TriedKind::Kriging => self.kriging(task),
            TriedKind::Harmonic { generator, degrees, loss } => {
                self.harmonic(generator, degrees, *loss, before, task)
            }
        }
    }

    /// One model of polynomials in every hold-out.
    fn polynomials(
        &self,
        candidate: Candidate,
        is_symmetric: bool,
        task: &Task,
    ) -> Result<KindScored, KindError> {
        let settings = self.tried.fit_settings(&candidate);
        let bounds = Bounds::around(self.samples.samples.iter().map(|s| s.position_mm));
        let scores = score(self.samples, &self.hold_outs(), self.tried, |folds| {
            let refit = Refit::Polynomials { settings: &settings, is_symmetric };
            self.each_fold(folds, |_, out, rest| {
                let bounds = bounds.ok_or(SelectError::NoSamples)?;
                let errors = refit
                    .at(self.samples, out, rest, &bounds, task)
                    .map_err(RoomModelError::from)?;
                // A fold that cannot be fitted leaves the errors as they are.
                Ok(errors.unwrap_or_else(|| vec![PoseError::default(); out.len()]))
            })
        })?;
        let model = RoomModel::Bernstein { is_symmetric };
        Ok(KindScored { model, candidate: Some(candidate), scores })
    }

    /// The best polynomials of samples and their turned twins, which are held out together; of one order
    /// more than plain ones at most.
    fn symmetric(
        &self,
        deciding: HoldOutBy,
        order: usize,
        task: &Task,
    ) -> Result<KindScored, KindError> {
        let rows = self.samples.samples.len();
        let labels: Vec<usize> = match deciding {
            HoldOutBy::Rows => (0..rows).collect(),
            HoldOutBy::Groups => self.labels.groups().unwrap_or_default().to_vec(),
            HoldOutBy::Sensors => self.labels.sensors.clone().unwrap_or_default(),
        };
        let twins = [labels.as_slice(), labels.as_slice()].concat();
        let hold_outs = HoldOuts {
            groups: Some(&twins),
            has_few_groups: true,
            only_deciding: true,
            ..HoldOuts::default()
        };
        let mut tried = self.tried.clone();
        if tried.only_contenders {
            tried.orders.retain(|&tried| tried <= order + 1);
        }
        let turned = self.samples.with_turned_axes();
        let selection = select_by(&turned, &hold_outs, &tried, &task.subtask(0.0, 0.8))?;
        self.polynomials(selection.best().candidate, true, &task.subtask(0.8, 1.0))
    }

    /// Kernel and amplitude are of all rows; a row's value given the other folds is then exact.
    fn kriging(&self, task: &Task) -> Result<KindScored, KindError> {
        let process = GaussianField::fit(self.samples, None, &task.subtask(0.0, 0.4))
            .map_err(RoomModelError::from)?;
        let kept = kept_rows(self.samples.samples.len());
        let scores = score(self.samples, &self.hold_outs(), self.tried, |folds| {
            let parts: Vec<Vec<usize>> = folds
                .rows
                .iter()
                .map(|rows| {
                    let place = rows.iter().filter_map(|row| kept.binary_search(row).ok());
                    place.collect()
                })
                .collect();
            let given = Kriging::left_out(&process, &parts, task).map_err(RoomModelError::from)?;
            let mut residuals = vec![None; self.samples.samples.len()];
            for (part, values) in parts.iter().zip(given) {
                for (&place, value) in part.iter().zip(values) {
                    let row = &process.rows[place];
                    let left: Residual = std::array::from_fn(|c| row.error[c] - value[c]);
                    residuals[kept[place]] = Some(left);
                }
            }
            Ok::<_, KindError>(residuals)
        })?;
        Ok(KindScored { model: RoomModel::Kriging, candidate: None, scores })
    }

    /// The lowest degree that leaves as little as any by the deciding hold-out; a learned generator is
    /// learned in every fold anew.
    fn harmonic(
        &self,
        generator: &GeneratorChoice,
        degrees: &[usize],
        loss: Loss,
        before: &[KindScored],
        task: &Task,
    ) -> Result<KindScored, KindError> {
        if self.tried.map != MapKind::Distortion {
            return Err(RoomModelError::CorrectionMap.into());
        }
        let mut degrees = degrees.to_vec();
        degrees.sort_unstable();
        let most = degrees.last().copied().unwrap_or(1);
        let table = HarmonicTable::new(self.samples, generator, most, &task.subtask(0.0, 0.5))?;
        let mut tables = FoldTables { samples: self.samples, all: &table, most, of: Vec::new() };
        let of_settings = |settings: HarmonicFitSettings, tables: &mut FoldTables| {
            score(self.samples, &self.hold_outs(), self.tried, |folds| {
                let tables = tables.of(folds, task)?;
                self.each_fold(folds, |fold, out, rest| {
                    tables[fold].predict(self.samples, out, rest, &settings, task)
                })
            })
        };
        // A generator that is another one's is seen in one fold.
        let first = degree_for(self.samples.samples.len()).clamp(degrees[0], most);
        let settings = |degree| HarmonicFitSettings { loss, ..HarmonicFitSettings::new(degree) };
        let of_first = settings(first);
        self.refuse_behind_in_one_fold(&mut tables, &of_first, before, task)?;
        let mut best: Option<KindScored> = None;
        let mut worse = 0;
        for (i, &degree) in degrees.iter().enumerate() {
            let scores = match of_settings(settings(degree), &mut tables) {
                // The rows do not determine so many coefficients.
                Err(error) if best.is_some() && !error.is_cancelled() => break,
                scores => scores?,
            };
            task.step(degrees.len() + i, 2 * degrees.len()).map_err(SelectError::from)?;
            let model = RoomModel::Harmonic(HarmonicOrder {
                generator: match &table.learned {
                    None => generator.clone(),
                    learned => GeneratorChoice::Learned(learned.clone()),
                },
                degree: Some(degree),
                ridge: None,
                loss,
            });
            let scored = KindScored { model, candidate: None, scores };
            let rms = |k: &KindScored| k.deciding().overall.position_rms_mm;
            let is_better = |best: &KindScored| rms(&scored) < (1.0 - TOLERANCE) * rms(best);
            if best.as_ref().is_none_or(is_better) {
                (best, worse) = (Some(scored), 0);
            } else {
                worse += 1;
            }
            if worse == WORSE_DEGREES {
                break;
            }
        }
        best.ok_or_else(|| SelectError::NothingToTry("degrees").into())
    }

    /// Judges the first fold of the deciding hold-out alone.
    fn refuse_behind_in_one_fold(
        &self,
        tables: &mut FoldTables,
        settings: &HarmonicFitSettings,
        before: &[KindScored],
        task: &Task,
    ) -> Result<(), KindError> {
        let Some(known) = before.first().filter(|_| self.tried.only_contenders) else {
            return Ok(());
        };
        let deciding = HoldOuts { only_deciding: true, ..self.hold_outs() };
        let decided_by = known.scores.decided_by;
        let deciding = HoldOuts { deciding: Some(decided_by), ..deciding };
        let scores = score(self.samples, &deciding, self.tried, |folds| {
            let one = Folds { rows: vec![folds.rows[0].clone()] };
            let tables = tables.of(&one, task)?;
            self.each_fold(&one, |_, out, rest| {
                tables[0].predict(self.samples, out, rest, settings, task)
            })
        })?;
        let (_, scores) = &scores.hold_outs[0];
        let one = HeldOutScores::of_sums(vec![scores.by_fold[0]], self.samples.has_rotations);
        self.refuse_behind(&one, before)
    }

    /// Refuses what leaves [`BEHIND`] times as much as another in position and in angle, in the folds that it
    /// was judged in.
    fn refuse_behind(
        &self,
        scores: &HeldOutScores,
        before: &[KindScored],
    ) -> Result<(), KindError> {
        if !self.tried.only_contenders {
            return Ok(());
        }
        let folds = scores.by_fold.len();
        let squares = |scores: &HeldOutScores| -> FoldSums {
            scores.by_fold.iter().take(folds).copied().sum()
        };
        let own = squares(scores);
        for other in before {
            let other_squares = squares(other.deciding());
            let by = BEHIND * BEHIND;
            let is_behind = own.position_mean_square_mm2()
                > by * other_squares.position_mean_square_mm2()
                && own.rotation_mean_square_rad2()
                    >= by * other_squares.rotation_mean_square_rad2();
            if is_behind {
                return Err(KindError::Behind {
                    found_mm: own.position_mean_square_mm2().sqrt(),
                    least_mm: other_squares.position_mean_square_mm2().sqrt(),
                    than: other.label(),
                });
            }
        }
        Ok(())
    }

    /// Residuals of every row of the folds by a model of the other rows; `predict` gives what that
    /// predicts at the rows of a fold. Folds are worked on side by side.
    fn each_fold(
        &self,
        folds: &Folds,
        predict: impl Fn(usize, &[usize], &[usize]) -> Result<Vec<PoseError>, KindError> + Sync,
    ) -> Result<Vec<Option<Residual>>, KindError> {
        let rows = self.samples.samples.len();
        let of_fold = |(fold, out): (usize, &Vec<usize>)| predict(fold, out, &rest(out, rows));
        let given: Vec<_> =
            folds.rows.par_iter().enumerate().map(of_fold).collect::<Result<_, _>>()?;
        let mut residuals = vec![None; rows];
        for (out, given) in folds.rows.iter().zip(given) {
            for (&row, given) in out.iter().zip(given) {
                let (measured, given) = (self.samples.samples[row].error.values(), given.values());
                residuals[row] = Some(std::array::from_fn(|k| measured[k] - given[k]));
            }
        }
        Ok(residuals)
    }
}

/// All rows but these.
fn rest(out: &[usize], rows: usize) -> Vec<usize> {
    (0..rows).filter(|row| out.binary_search(row).is_err()).collect()
}

/// Rows made ready for the harmonic models of each fold: the same where the generator is known; learned
/// again without the fold, from the generator of all rows, where it is not.
struct FoldTables<'a> {
    samples: &'a SampleSet,
    all: &'a HarmonicTable,
    most: usize,
    of: Vec<(Folds, Vec<FoldTable<'a>>)>,
}

enum FoldTable<'a> {
    OfAll(&'a HarmonicTable),
    Own(Box<HarmonicTable>),
}

impl<'a> FoldTables<'a> {
    fn of(&mut self, folds: &Folds, task: &Task) -> Result<&[FoldTable<'a>], RoomModelError> {
        let known = self.of.iter().position(|(made_for, _)| made_for == folds);
        let place = match known {
            Some(place) => place,
            None => {
                let tables = self.made(folds, task)?;
                self.of.push((folds.clone(), tables));
                self.of.len() - 1
            }
        };
        Ok(&self.of[place].1)
    }

    fn made(&self, folds: &Folds, task: &Task) -> Result<Vec<FoldTable<'a>>, RoomModelError> {
        let Some(learned) = &self.all.learned else {
            return Ok(folds.rows.iter().map(|_| FoldTable::OfAll(self.all)).collect());
        };
        let of_fold = |out: &Vec<usize>| self.learned_without(out, learned, task);
        folds.rows.par_iter().map(of_fold).collect()
    }

    fn learned_without(
        &self,
        out: &[usize],
        learned: &LearnedGenerator,
        task: &Task,
    ) -> Result<FoldTable<'a>, RoomModelError> {
        let from = rest(out, self.samples.samples.len());
        let table =
            HarmonicTable::learned_again(self.samples, &from, learned, self.most, &quiet(task))?;
        Ok(FoldTable::Own(Box::new(table)))
    }
}

impl FoldTable<'_> {
    /// What a model of the other rows gives at those of a fold.
    fn predict(
        &self,
        samples: &SampleSet,
        out: &[usize],
        rest: &[usize],
        settings: &HarmonicFitSettings,
        task: &Task,
    ) -> Result<Vec<PoseError>, KindError> {
        let table = match self {
            Self::OfAll(table) => table,
            Self::Own(table) => table.as_ref(),
        };
        let fitted = table.fit(Some(rest), settings, &quiet(task)).map_err(RoomModelError::from)?;
        Ok(out.iter().map(|&row| predicted(&fitted.model, &samples.samples[row])).collect())
    }
}

fn quiet(task: &Task) -> Task {
    Task::cancelled_by(task.cancel.clone())
}
