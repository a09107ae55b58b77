//! Which kind of model a room's measurements are fitted with: each is judged on the same rows held out.

use super::room_choice::{Chosen, GroupRowsError, RowLabels, choose_by};
use super::room_model::{
    GeneratorChoice, HarmonicOrder, HarmonicTable, RoomModel, RoomModelError, predicted,
};
use trackwright_field::computed::ModelKind;
use trackwright_field::fit::FitSettings;
use trackwright_field::gaussian::{GaussianField, Kriging, kept_rows};
use trackwright_field::harmonic::Loss;
use trackwright_field::samples::{MapKind, SampleSet};
use trackwright_field::selection::folds::Folds;
use trackwright_field::selection::other::{OtherScored, score};
use trackwright_field::selection::scoring::{HeldOutScores, Residual};
use trackwright_field::selection::{
    Candidate, HoldOutBy, HoldOuts, SelectError, SelectSettings, select_by,
};
use trackwright_task::Task;

/// A kind of model to try.
#[derive(Clone, Debug, PartialEq)]
pub enum TriedKind {
    /// The best of the polynomials that are tried.
    Bernstein,
    /// The same with an axis and the one turned round having the same error.
    Symmetric,
    Kriging,
    Harmonic {
        generator: GeneratorChoice,
        /// Every one of these that the rows determine.
        degrees: Vec<usize>,
        loss: Loss,
    },
}

/// The name of polynomials that are the same with the axis reversed.
const SYMMETRIC: &str = "symmetric";

/// The best model of a kind, and how it did on rows held out.
#[derive(Clone, Debug, PartialEq)]
pub struct KindScored {
    pub model: RoomModel,
    /// What fits it, of polynomials.
    pub candidate: Option<Candidate>,
    pub scores: OtherScored,
}

impl KindScored {
    /// As the command line names the kind.
    pub fn name(&self) -> &'static str {
        match &self.model {
            RoomModel::Bernstein { is_symmetric: true } => SYMMETRIC,
            other => other.kind().name(),
        }
    }

    /// The same, with the generator where there may be several.
    pub fn label(&self) -> String {
        match &self.model {
            RoomModel::Harmonic(order) => format!("harmonic, {}", order.generator.name()),
            _ => self.name().to_owned(),
        }
    }

    /// The scores that decide.
    pub fn deciding(&self) -> &HeldOutScores {
        // Every hold-out that can decide was made.
        self.scores.held_out_by(self.scores.decided_by).unwrap_or(&self.scores.hold_outs[0].1)
    }

    /// The settings of the fit.
    pub fn settings(&self, tried: &SelectSettings) -> FitSettings {
        match &self.candidate {
            Some(candidate) => tried.fit_settings(candidate),
            None => FitSettings::without_polynomials(tried.map),
        }
    }
}

/// Kinds in the order of what they leave of rows held out, and the chosen one's place.
#[derive(Clone, Debug, PartialEq)]
pub struct KindChoice {
    pub kinds: Vec<KindScored>,
    pub best: usize,
    /// Kinds that could not be judged, and why.
    pub left_out: Vec<(&'static str, String)>,
}

#[derive(Debug, thiserror::Error)]
pub enum KindError {
    #[error(transparent)]
    Select(#[from] SelectError),
    #[error(transparent)]
    Model(#[from] RoomModelError),
    #[error(transparent)]
    Groups(#[from] GroupRowsError),
}

impl KindError {
    fn is_cancelled(&self) -> bool {
        match self {
            Self::Select(error) => matches!(error, SelectError::Cancelled(_)),
            Self::Model(error) => error.is_cancelled(),
            Self::Groups(_) => false,
        }
    }
}

/// Tries the kinds on the same rows held out, polynomials always; a kind that cannot be judged is
/// left out with its reason.
pub fn choose_kind(
    samples: &SampleSet,
    labels: RowLabels,
    tried: &SelectSettings,
    kinds: &[TriedKind],
    task: &Task,
) -> Result<(Chosen, KindChoice), KindError> {
    let subtask = |i: usize| {
        let parts = kinds.len() as f64 + 1.0;
        task.subtask(i as f64 / parts, (i + 1) as f64 / parts)
    };
    let chosen = choose_by(samples, labels.clone(), tried.clone(), &subtask(0))?;
    let judge = Judge { samples, labels: &labels, tried };
    let (mut scored, mut left_out) = (Vec::new(), Vec::new());
    for (i, kind) in kinds.iter().enumerate() {
        match judge.judged(kind, &chosen, &subtask(i + 1)) {
            Ok(kind) => scored.push(kind),
            Err(error) if error.is_cancelled() => return Err(error),
            Err(error) => left_out.push((kind.name(), error.to_string())),
        }
    }
    scored.sort_by(|a, b| {
        let rms = |k: &KindScored| k.deciding().overall.position_rms_mm;
        rms(a).total_cmp(&rms(b))
    });
    let best = best_of(&scored).ok_or(SelectError::NothingToTry("kinds of models"))?;
    let choice = KindChoice { kinds: scored, best, left_out };
    Ok((chosen, choice))
}

/// The kind with the least position error; of those within the folds' noise, the least angle error.
fn best_of(kinds: &[KindScored]) -> Option<usize> {
    let least = kinds.first()?.deciding();
    let angle = |k: &KindScored| k.deciding().overall.angle_rms_rad.unwrap_or(0.0);
    let is_as_good = |k: &KindScored| {
        let difference = k.deciding().position_difference(least);
        difference.mean <= difference.std_error
    };
    (0..kinds.len())
        .filter(|&i| i == 0 || is_as_good(&kinds[i]))
        .min_by(|&a, &b| angle(&kinds[a]).total_cmp(&angle(&kinds[b])))
}

impl TriedKind {
    /// As the command line names it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Bernstein => ModelKind::Bernstein.name(),
            Self::Symmetric => SYMMETRIC,
            Self::Kriging => ModelKind::Kriging.name(),
            Self::Harmonic { .. } => ModelKind::Harmonic.name(),
        }
    }
}

/// What every kind is judged on.
struct Judge<'a> {
    samples: &'a SampleSet,
    labels: &'a RowLabels,
    tried: &'a SelectSettings,
}

impl Judge<'_> {
    fn hold_outs(&self) -> HoldOuts<'_> {
        self.labels.hold_outs()
    }

    fn judged(
        &self,
        kind: &TriedKind,
        chosen: &Chosen,
        task: &Task,
    ) -> Result<KindScored, KindError> {
        match kind {
            TriedKind::Bernstein => {
                let best = chosen.selection.best();
                let scores = self.polynomials(&best.candidate, false, task)?;
                Ok(KindScored { model: RoomModel::PAPER, candidate: Some(best.candidate), scores })
            }
            TriedKind::Symmetric => self.symmetric(chosen.selection.decided_by, task),
            TriedKind::Kriging => self.kriging(task),
            TriedKind::Harmonic { generator, degrees, loss } => {
                self.harmonic(generator, degrees, *loss, task)
            }
        }
    }

    /// One model of polynomials in every hold-out.
    fn polynomials(
        &self,
        candidate: &Candidate,
        is_symmetric: bool,
        task: &Task,
    ) -> Result<OtherScored, KindError> {
        let settings = self.tried.fit_settings(candidate);
        let bounds = trackwright_geometry::bounds::Bounds::around(
            self.samples.samples.iter().map(|s| s.position_mm),
        );
        score(self.samples, &self.hold_outs(), self.tried, |folds| {
            let refit =
                super::room_process::Refit::Polynomials { settings: &settings, is_symmetric };
            self.each_fold(folds, |out, rest| {
                let bounds = bounds.ok_or(SelectError::NoSamples)?;
                let errors = refit
                    .at(self.samples, out, rest, &bounds, task)
                    .map_err(RoomModelError::from)?;
                // A fold that cannot be fitted leaves the errors as they are.
                Ok(errors.unwrap_or_else(|| vec![Default::default(); out.len()]))
            })
        })
    }

    /// The best polynomials of samples and their turned twins, which are held out together.
    fn symmetric(&self, deciding: HoldOutBy, task: &Task) -> Result<KindScored, KindError> {
        let rows = self.samples.samples.len();
        let labels: Vec<usize> = match deciding {
            HoldOutBy::Rows => (0..rows).collect(),
            HoldOutBy::Groups => self.labels.groups().unwrap_or_default().to_vec(),
            HoldOutBy::Sensors => self.labels.sensors.clone().unwrap_or_default(),
        };
        let twins = [labels.as_slice(), labels.as_slice()].concat();
        let hold_outs =
            HoldOuts { groups: Some(&twins), has_few_groups: true, ..HoldOuts::default() };
        let turned = self.samples.with_turned_axes();
        let selection = select_by(&turned, &hold_outs, self.tried, &task.subtask(0.0, 0.8))?;
        let candidate = selection.best().candidate;
        Ok(KindScored {
            model: RoomModel::Bernstein { is_symmetric: true },
            scores: self.polynomials(&candidate, true, &task.subtask(0.8, 1.0))?,
            candidate: Some(candidate),
        })
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

    /// The best degree by the deciding hold-out; a learned generator is learned in every fold anew.
    fn harmonic(
        &self,
        generator: &GeneratorChoice,
        degrees: &[usize],
        loss: Loss,
        task: &Task,
    ) -> Result<KindScored, KindError> {
        if self.tried.map != MapKind::Distortion {
            return Err(RoomModelError::CorrectionMap.into());
        }
        let most = degrees.iter().copied().max().unwrap_or(1);
        let table = match generator {
            GeneratorChoice::Known(_) => {
                Some(HarmonicTable::new(self.samples, generator, most, &quiet(task))?)
            }
            GeneratorChoice::Learned => None,
        };
        let mut learned = LearnedTables::default();
        let mut best: Option<KindScored> = None;
        for &degree in degrees {
            let scores = score(self.samples, &self.hold_outs(), self.tried, |folds| {
                self.each_fold(folds, |out, rest| {
                    let table = match &table {
                        Some(table) => table,
                        None => learned.of(self.samples, rest, most, task)?,
                    };
                    let fitted = table
                        .fit(Some(rest), degree, loss, &quiet(task))
                        .map_err(RoomModelError::from)?;
                    let each = out.iter().map(|&row| &self.samples.samples[row]);
                    Ok(each.map(|s| predicted(&fitted.model, s)).collect())
                })
            })?;
            let scored = KindScored {
                model: RoomModel::Harmonic(HarmonicOrder {
                    generator: generator.clone(),
                    degree: Some(degree),
                    loss,
                }),
                candidate: None,
                scores,
            };
            let rms = |k: &KindScored| k.deciding().overall.position_rms_mm;
            if best.as_ref().is_none_or(|best| rms(&scored) < rms(best)) {
                best = Some(scored);
            }
        }
        best.ok_or_else(|| SelectError::NothingToTry("degrees").into())
    }

    /// Residuals of every row by a model of the other folds; `predict` gives what that predicts at
    /// the rows of a fold.
    fn each_fold(
        &self,
        folds: &Folds,
        mut predict: impl FnMut(
            &[usize],
            &[usize],
        )
            -> Result<Vec<trackwright_field::samples::PoseError>, KindError>,
    ) -> Result<Vec<Option<Residual>>, KindError> {
        let rows = self.samples.samples.len();
        let mut residuals = vec![None; rows];
        for out in &folds.rows {
            let rest: Vec<usize> =
                (0..rows).filter(|row| out.binary_search(row).is_err()).collect();
            for (&row, given) in out.iter().zip(predict(out, &rest)?) {
                let (measured, given) = (self.samples.samples[row].error.values(), given.values());
                residuals[row] = Some(std::array::from_fn(|k| measured[k] - given[k]));
            }
        }
        Ok(residuals)
    }
}

/// Generators learned from the rows of all folds but one, each of them once.
#[derive(Default)]
struct LearnedTables(Vec<(Vec<usize>, HarmonicTable)>);

impl LearnedTables {
    fn of(
        &mut self,
        samples: &SampleSet,
        rest: &[usize],
        max_degree: usize,
        task: &Task,
    ) -> Result<&HarmonicTable, RoomModelError> {
        let known = self.0.iter().position(|(rows, _)| rows == rest);
        let place = match known {
            Some(place) => place,
            None => {
                let table = HarmonicTable::learned(samples, rest, max_degree, &quiet(task))?;
                self.0.push((rest.to_vec(), table));
                self.0.len() - 1
            }
        };
        Ok(&self.0[place].1)
    }
}

fn quiet(task: &Task) -> Task {
    Task::cancelled_by(task.cancel.clone())
}
