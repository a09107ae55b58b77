//! What the bodies leave of measurements held out, beside what other models leave of the same ones.

use super::identification::{Identification, IdentifySettings};
use super::multipoles::MultipoleField;
use super::solve::Bodies;
use super::sources::{SourceModel, dipole_fields, room};
use crate::room::MetalRoom;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use trackwright_field::generator::Generator;
use trackwright_field::generator::reading::{axis_error, read_pose};
use trackwright_field::harmonic::{HarmonicFitError, HarmonicFitSettings, HarmonicRows};
use trackwright_field::samples::{
    MapKind, Measurement, MeasurementContent, MeasurementSet, PoseError, SampleSet,
};
use trackwright_field::selection::folds::Folds;
use trackwright_field::selection::other::score;
use trackwright_field::selection::scoring::{HeldOutScores, Residual};
use trackwright_field::selection::{Candidate, HoldOuts, SelectError, SelectSettings, select};
use trackwright_geometry::rotation::log_quaternion;
use trackwright_task::{Cancelled, Task};

/// Degrees of harmonics that are tried.
const DEGREES: std::ops::RangeInclusive<usize> = 1..=6;

/// Orders and ridges of polynomials that are tried; every set of orientations is.
const ORDERS: [usize; 5] = [0, 1, 2, 3, 4];
const RIDGES: [f64; 4] = [0.0, 1e-3, 1e-2, 1e-1];

/// A model of the disturbance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ComparedModel {
    /// The errors as they are.
    None,
    Bodies,
    /// Of the degree that leaves least.
    Harmonic {
        degree: usize,
    },
    /// Polynomials a basis orientation, of those that selection would choose.
    PerDirection(Candidate),
}

/// A model and what it leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    pub model: ComparedModel,
    pub scores: HeldOutScores,
}

/// Why there is no comparison.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    #[error(transparent)]
    Select(#[from] SelectError),
    #[error(transparent)]
    Harmonic(#[from] HarmonicFitError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Held-out errors in the folds that the bodies were found in, the errors as they are first.
///
/// `set`, `generator` and `settings` are those of the identification.
///
/// # Errors
/// See [`CompareError`].
///
/// # Panics
/// If the identification is of other folds.
pub fn compare(
    task: &Task,
    generator: &Generator,
    set: &MeasurementSet,
    settings: &IdentifySettings,
    found: &Identification,
) -> Result<Vec<Compared>, CompareError> {
    assert_eq!(found.without.len(), settings.folds, "the folds of the identification");
    let samples = set.samples(MapKind::Distortion);
    let tried = SelectSettings {
        orders: ORDERS.to_vec(),
        ridges: RIDGES.to_vec(),
        folds: settings.folds,
        seed: settings.seed,
        ..SelectSettings::for_samples(&samples)
    };
    let judge = Judge { generator, set, samples: &samples, tried: &tried };
    let mut all = vec![
        judge.scored(ComparedModel::None, |_, _| Ok(None))?,
        judge.scored(ComparedModel::Bodies, |fold, m| {
            Ok(judge.of_bodies(&found.without[fold], m))
        })?,
    ];
    all.push(judge.harmonic(&task.subtask(0.0, 0.4))?);
    let selection = select(&samples, None, &tried, &task.subtask(0.4, 1.0))?;
    let best = selection.best();
    all.push(Compared {
        model: ComparedModel::PerDirection(best.candidate),
        scores: best.deciding.clone(),
    });
    Ok(all)
}

struct Judge<'a> {
    generator: &'a Generator,
    set: &'a MeasurementSet,
    samples: &'a SampleSet,
    tried: &'a SelectSettings,
}

impl Judge<'_> {
    /// Scores of what `predict` gives for the measurements of a fold, none where they are not disturbed.
    fn scored(
        &self,
        model: ComparedModel,
        mut predict: impl FnMut(usize, &[usize]) -> Result<Option<Vec<PoseError>>, CompareError>,
    ) -> Result<Compared, CompareError> {
        let scores = score(self.samples, &HoldOuts::default(), self.tried, |folds: &Folds| {
            let mut residuals: Vec<Option<Residual>> = vec![None; self.samples.samples.len()];
            for (fold, out) in folds.rows.iter().enumerate() {
                let predicted = predict(fold, out)?;
                for (k, &row) in out.iter().enumerate() {
                    let measured = self.samples.samples[row].error.values();
                    let given = predicted.as_ref().map_or([0.0; 6], |all| all[k].values());
                    residuals[row] = Some(std::array::from_fn(|c| measured[c] - given[c]));
                }
            }
            Ok::<_, CompareError>(residuals)
        })?;
        let (_, scores) = scores.hold_outs.into_iter().next().ok_or(SelectError::NoSamples)?;
        Ok(Compared { model, scores })
    }

    fn of_bodies(&self, bodies: &Bodies, out: &[usize]) -> Option<Vec<PoseError>> {
        let sources = &bodies.sources;
        let multipoles: Vec<_> = bodies
            .extended
            .iter()
            .map(|body| MultipoleField::new(self.generator, &body.center_mm, &body.entries))
            .collect();
        let rooms = match bodies.model {
            SourceModel::Spheres => {
                let rooms = sources.iter().map(|source| room(self.generator, source));
                rooms.collect::<Option<Vec<_>>>()?
            }
            SourceModel::Dipoles | SourceModel::Multipoles => Vec::new(),
        };
        Some(self.errors(out, |p, fields| {
            if !multipoles.is_empty() {
                fields.fill(Vector3::zeros());
                multipoles.iter().for_each(|body| body.add(p, fields));
                return;
            }
            let mut of_room = vec![Vector3::zeros(); fields.len()];
            fields.fill(Vector3::zeros());
            let mut add = |room: &MetalRoom| {
                let is_outside = room.disturbance(p, &mut of_room).is_ok();
                fields.iter_mut().zip(&of_room).for_each(|(sum, field)| *sum += field);
                is_outside
            };
            // In a sphere that the other folds leave room for, dipoles stand for it.
            if rooms.is_empty() || !rooms.iter().all(&mut add) {
                dipole_fields(self.generator, sources, p, fields);
            }
        }))
    }

    /// Errors in disturbed fields; none where the signals determine no pose.
    fn errors(
        &self,
        out: &[usize],
        disturb: impl Fn(&Point3<f64>, &mut [Vector3<f64>]) + Sync,
    ) -> Vec<PoseError> {
        let of_row = |&row: &usize| {
            let Measurement { tracker_from_ideal: ideal, .. } = &self.set.measurements[row];
            let p = ideal.translation.vector.into();
            let mut fields = vec![Vector3::zeros(); self.generator.coils.len()];
            disturb(&p, &mut fields);
            if self.set.content == MeasurementContent::SixDof {
                let read = read_pose(self.generator, ideal, &fields);
                read.ok().map(|read| {
                    let pose = read.tracker_from_sensor;
                    PoseError {
                        position_mm: pose.translation.vector - ideal.translation.vector,
                        rotation_rad: log_quaternion(&(pose.rotation * ideal.rotation.inverse())),
                    }
                })
            } else {
                let axis = ideal.rotation * Vector3::z_axis();
                axis_error(self.generator, &p, &axis, &fields).ok()
            }
        };
        out.par_iter().map(|row| of_row(row).unwrap_or_default()).collect()
    }

    fn harmonic(&self, task: &Task) -> Result<Compared, CompareError> {
        let quiet = Task::cancelled_by(task.cancel.clone());
        let rows = HarmonicRows::new(&quiet, self.generator, self.set, *DEGREES.end())?;
        let mut best: Option<Compared> = None;
        for degree in DEGREES {
            task.step(degree - 1, *DEGREES.end())?;
            let compared = self.scored(ComparedModel::Harmonic { degree }, |_, out| {
                let rest: Vec<usize> = (0..self.set.measurements.len())
                    .filter(|row| out.binary_search(row).is_err())
                    .collect();
                let settings = HarmonicFitSettings::new(degree);
                let fitted = rows.fit(&quiet, Some(&rest), &settings)?;
                Ok(Some(self.errors(out, |p, fields| fitted.model.disturbance(p, fields))))
            })?;
            let rms = |c: &Compared| c.scores.overall.position_rms_mm;
            if best.as_ref().is_none_or(|best| rms(&compared) < rms(best)) {
                best = Some(compared);
            }
        }
        Ok(best.ok_or(SelectError::NothingToTry("degrees"))?)
    }
}
