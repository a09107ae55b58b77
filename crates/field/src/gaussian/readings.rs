//! The error of a room's model at single readings, misfit included.

use super::field::{GaussianField, Trend};
use super::fit::GaussianError;
use super::neighborhoods::Neighborhoods;
use super::posterior::{DrawnErrors, log_amplitude_std};
use super::row::ErrorValues;
use crate::field_point::FieldPoint;
use crate::samples::PoseError;
use nalgebra::{Matrix6, Point3, Vector3, Vector6};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

/// Poses that are solved for at once.
const BLOCK: usize = 256;

/// Draws by which the 95 % point of a distance is found: it is then known to 1 % of the probability.
const DRAWS: usize = 512;

const SEED: u64 = 21;

/// The expected distance of a tracker's reading at a pose from the model's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingError {
    /// Distance of the positions, mm.
    pub position_mm: ReadingDistance,
    /// Angle between the orientations, rad; `None` where orientations were not measured.
    pub angle_rad: Option<ReadingDistance>,
}

/// A distance that is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingDistance {
    pub rms: f64,
    /// 95 % of such distances are at most this.
    pub within_95: f64,
}

/// The same without its distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingRms {
    pub position_mm: f64,
    /// rad; `None` where orientations were not measured.
    pub angle_rad: Option<f64>,
}

/// A process made ready for readings at many poses.
pub struct Readings<'a> {
    field: &'a GaussianField,
    neighborhoods: Neighborhoods<'a>,
    components: Matrix6<f64>,
}

/// What the error of a reading is made of.
struct Parts {
    /// Mean of the process less the model's errors.
    bias: Vector6<f64>,
    /// Standard deviation of the process, and of the logarithm of a draw's amplitude.
    std: f64,
    log_std: f64,
    /// Of each refit of the model, and of the registration.
    of_model: Vec<Vector6<f64>>,
}

/// Deviations for a unit standard deviation of the process, the normal number of their amplitude, what a sensor is
/// off by itself, and the factor of each deviation of the model.
struct ReadingDraw {
    unit: Vector6<f64>,
    amplitude: f64,
    own: Vector6<f64>,
    of_model: Vec<f64>,
}

impl<'a> Readings<'a> {
    pub fn new(field: &'a GaussianField) -> Self {
        let components = field.components();
        Self { field, neighborhoods: Neighborhoods::new(field), components }
    }

    /// The expected error of `model_errors`, the errors of the room's model at the points. The noise of
    /// readings is not in it.
    ///
    /// # Errors
    /// [`GaussianError::NotPositiveDefinite`].
    pub fn errors(
        &self,
        at: &[FieldPoint],
        model_errors: &[PoseError],
    ) -> Result<Vec<ReadingError>, GaussianError> {
        let draws = self.field.reading_draws(&self.components);
        self.each(at, model_errors, |parts| self.distribution(parts, &draws))
    }

    /// The same without its distribution, which takes longer.
    ///
    /// # Errors
    /// [`GaussianError::NotPositiveDefinite`].
    pub fn rms(
        &self,
        at: &[FieldPoint],
        model_errors: &[PoseError],
    ) -> Result<Vec<ReadingRms>, GaussianError> {
        self.each(at, model_errors, |parts| ReadingRms {
            position_mm: self.rms_of(parts, 0),
            angle_rad: self.field.has_rotations.then(|| self.rms_of(parts, 3)),
        })
    }

    /// RMS length of what the noise of a row is in the position, mm, and in the rotation, rad, at a
    /// place.
    pub fn noise_at(&self, position_mm: &Point3<f64>) -> ReadingRms {
        let std = self.field.amplitude.at(position_mm) * self.field.kernel.nugget.sqrt();
        let length = |from: usize| std * self.components.fixed_rows::<3>(from).norm();
        ReadingRms {
            position_mm: length(0),
            angle_rad: self.field.has_rotations.then(|| length(3)),
        }
    }

    fn each<T: Clone + Send>(
        &self,
        at: &[FieldPoint],
        model_errors: &[PoseError],
        of: impl Fn(&Parts) -> T + Sync,
    ) -> Result<Vec<T>, GaussianError> {
        let field = self.field;
        let mut found = vec![None; at.len()];
        for (part, indices) in self.neighborhoods.grouped(at) {
            let given = self.neighborhoods.part(part)?;
            let most = given.kernel.variance();
            for indices in indices.chunks(BLOCK) {
                let points: Vec<FieldPoint> = indices.iter().map(|&i| at[i]).collect();
                let (mean, explained) = given.at(&points);
                let deviations = field.model_deviations(&points);
                let each = points.par_iter().enumerate().map(|(i, point)| {
                    let explained: f64 = explained.col(i).iter().map(|v| v * v).sum();
                    let unit_variance = (most - explained).max(0.0);
                    let amplitude = field.amplitude.at(&point.position_mm);
                    let own = std::array::from_fn(|c| mean[(i, c)] * amplitude);
                    of(&Parts {
                        bias: less_model(own, field.trend, &model_errors[indices[i]]),
                        std: amplitude * unit_variance.sqrt(),
                        log_std: log_amplitude_std(unit_variance / most, field.rows.len()),
                        of_model: deviations.iter().map(|of| Vector6::from(of[i])).collect(),
                    })
                });
                let each: Vec<T> = each.collect();
                for (&i, value) in indices.iter().zip(each) {
                    found[i] = Some(value);
                }
            }
        }
        // Every point is in one part.
        Ok(found.into_iter().flatten().collect())
    }

    fn distribution(&self, parts: &Parts, draws: &[ReadingDraw]) -> ReadingError {
        let off: Vec<Vector6<f64>> = draws
            .iter()
            .map(|draw| {
                let each = parts.of_model.iter().zip(&draw.of_model);
                let of_model: Vector6<f64> = each.map(|(of, factor)| of * *factor).sum();
                // E(exp(2 l)) = 1, as in the draws of a posterior.
                let by = (parts.log_std * draw.amplitude - parts.log_std * parts.log_std).exp();
                parts.bias + draw.unit * (parts.std * by) + draw.own + of_model
            })
            .collect();
        let distance = |from: usize| {
            let mut distances: Vec<f64> = off.iter().map(|off| three(off, from).norm()).collect();
            let place = (0.95 * draws.len() as f64) as usize;
            let (_, within_95, _) = distances.select_nth_unstable_by(place, f64::total_cmp);
            ReadingDistance { rms: self.rms_of(parts, from), within_95: *within_95 }
        };
        ReadingError {
            position_mm: distance(0),
            angle_rad: self.field.has_rotations.then(|| distance(3)),
        }
    }

    /// Of the three components from one on.
    fn rms_of(&self, parts: &Parts, from: usize) -> f64 {
        let of_process = self.components.fixed_rows::<3>(from).norm_squared() * parts.std.powi(2);
        let of_model: f64 = parts.of_model.iter().map(|of| three(of, from).norm_squared()).sum();
        let of_sensor = three(&self.field.sensor_std(), from).norm_squared();
        let bias = three(&parts.bias, from).norm_squared();
        (bias + of_process + of_sensor + of_model).sqrt()
    }
}

fn three(values: &Vector6<f64>, from: usize) -> Vector3<f64> {
    Vector3::from(values.fixed_rows::<3>(from))
}

impl GaussianField {
    fn reading_draws(&self, components: &Matrix6<f64>) -> Vec<ReadingDraw> {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let each = (0..DRAWS).map(|_| {
            let amplitude = normal();
            let unit = Vector6::from_fn(|_, _| normal());
            let own = Vector6::from_fn(|_, _| normal());
            ReadingDraw {
                unit: components * unit,
                amplitude,
                own: own.component_mul(&self.sensor_std()),
                of_model: (0..self.deviation_count()).map(|_| normal()).collect(),
            }
        });
        each.collect()
    }

    /// Standard deviation of what another sensor is off by itself.
    fn sensor_std(&self) -> Vector6<f64> {
        Vector6::from(self.sensor_variance.unwrap_or_default()).map(f64::sqrt)
    }

    /// What the sensors of a body are off by themselves, in each draw: the same for sensors of the same
    /// place in two bodies of one `body`; none where the room does not state how sensors differ.
    pub fn sensor_errors(
        &self,
        sensors: usize,
        body: u64,
        draws: usize,
        seed: u64,
    ) -> Vec<DrawnErrors> {
        if self.sensor_variance.is_none() {
            return vec![vec![[0.0; 6]; sensors]; draws];
        }
        let std = self.sensor_std();
        let draw = |draw: usize| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(2 * draw as u64 + body);
            let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
            (0..sensors).map(|_| std::array::from_fn(|c| std[c] * normal())).collect()
        };
        (0..draws).map(draw).collect()
    }
}

/// The mean of the errors less those of the room's model.
fn less_model(mean: ErrorValues, trend: Trend, model: &PoseError) -> Vector6<f64> {
    let mean = Vector6::from(mean);
    match trend {
        Trend::None => mean - Vector6::from(model.values()),
        Trend::Model => mean,
    }
}
