//! Models that no table of orders lists, judged in the same folds as those that one does.

use super::folds::Folds;
use super::hold_outs::{AllFolds, HoldOutBy, HoldOuts};
use super::scoring::{FoldSums, HeldOutScores, Residual};
use super::settings::{SelectError, SelectSettings};
use crate::samples::SampleSet;

/// How a model did in each hold-out.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherScored {
    /// Rows first.
    pub hold_outs: Vec<(HoldOutBy, HeldOutScores)>,
    pub decided_by: HoldOutBy,
}

impl OtherScored {
    /// The scores of a hold-out, where rows were held out so.
    pub fn held_out_by(&self, by: HoldOutBy) -> Option<&HeldOutScores> {
        let found = self.hold_outs.iter().find(|(own, _)| *own == by);
        found.map(|(_, scores)| scores)
    }

    /// The scores that decide.
    pub fn deciding(&self) -> &HeldOutScores {
        // Every hold-out that can decide was made.
        self.held_out_by(self.decided_by).unwrap_or(&self.hold_outs[0].1)
    }
}

/// Judges a model in every hold-out that is known. `residuals` gives what is left of each row when its
/// fold is held out, in the order of the rows; nothing for a row that the model does not look at.
///
/// # Errors
/// Those of the folds ([`super::select_by`]), and of `residuals`.
pub fn score<E: From<SelectError>>(
    set: &SampleSet,
    hold_outs: &HoldOuts,
    settings: &SelectSettings,
    mut residuals: impl FnMut(&Folds) -> Result<Vec<Option<Residual>>, E>,
) -> Result<OtherScored, E> {
    let all = AllFolds::new(hold_outs, set.samples.len(), settings)?;
    let labelled = [(HoldOutBy::Groups, all.groups), (HoldOutBy::Sensors, all.sensors)];
    let labelled = labelled.into_iter().filter_map(|(by, folds)| Some((by, folds?.0)));
    let rows = all.rows.map(|folds| (HoldOutBy::Rows, folds));
    let mut scored = Vec::new();
    for (by, folds) in rows.into_iter().chain(labelled) {
        let residuals = residuals(&folds)?;
        let of_row = |&row: &usize| residuals[row].as_ref().map(FoldSums::of);
        let by_fold = folds.rows.iter().map(|rows| rows.iter().filter_map(of_row).sum());
        let scores = HeldOutScores::of_sums(by_fold.collect(), set.has_rotations);
        scored.push((by, scores));
    }
    Ok(OtherScored { hold_outs: scored, decided_by: all.deciding })
}
