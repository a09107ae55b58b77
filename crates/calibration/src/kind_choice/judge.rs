//! Each kind of model on the same rows held out.

use super::kinds::{KindError, KindScored, TriedKind};
use crate::room_choice::Chosen;
use crate::room_model::{RoomModel, RoomModelError};
use crate::room_process::Refit;
use crate::row_labels::RowLabels;
use rayon::prelude::*;
use trackwright_field::fit::FitSettings;
use trackwright_field::gaussian::{GaussianField, Kriging, kept_rows};
use trackwright_field::samples::{PoseError, SampleSet};
use trackwright_field::selection::folds::Folds;
use trackwright_field::selection::other::score;
use trackwright_field::selection::scoring::{FoldSums, HeldOutScores, Residual};
use trackwright_field::selection::{
    Candidate, HoldOutBy, HoldOuts, SelectError, SelectSettings, select_by,
};
use trackwright_geometry::bounds::Bounds;
use trackwright_task::Task;

/// Symmetric polynomials are not tried where others leave so many times what another kind does: of 108 rooms of
/// `tests/rooms/others.rs` they leave 0.78 to 1.1 times as much as others.
const BEHIND_OF_SYMMETRIC: f64 = 1.35;

/// What every kind is judged on.
pub(super) struct Judge<'a> {
    pub samples: &'a SampleSet,
    pub labels: &'a RowLabels,
    pub tried: &'a SelectSettings,
}

impl Judge<'_> {
    pub(super) fn hold_outs(&self) -> HoldOuts<'_> {
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
                let polynomials = chosen.selection.best();
                self.refuse_behind(BEHIND_OF_SYMMETRIC, &polynomials.deciding, before)?;
                self.symmetric(chosen.selection.decided_by, polynomials.candidate.order, task)
            }
            TriedKind::Kriging => self.kriging(task),
            TriedKind::Harmonic { generator, degrees, loss } => {
                super::harmonic::judged(self, (generator, degrees, *loss), before, task)
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
            self.each_fold(folds, |out, rest| {
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

    /// Refuses what leaves so many times as much as another in position and in angle, in the folds that it was
    /// judged in.
    pub(super) fn refuse_behind(
        &self,
        times: f64,
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
            let by = times * times;
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
    pub(super) fn each_fold(
        &self,
        folds: &Folds,
        predict: impl Fn(&[usize], &[usize]) -> Result<Vec<PoseError>, KindError> + Sync,
    ) -> Result<Vec<Option<Residual>>, KindError> {
        let rows = self.samples.samples.len();
        let of_fold = |out: &Vec<usize>| predict(out, &rest(out, rows));
        let given: Vec<_> = folds.rows.par_iter().map(of_fold).collect::<Result<_, _>>()?;
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
pub(super) fn rest(out: &[usize], rows: usize) -> Vec<usize> {
    (0..rows).filter(|row| out.binary_search(row).is_err()).collect()
}
