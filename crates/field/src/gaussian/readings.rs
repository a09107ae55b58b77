//! The error of a room's model at single readings, misfit included.

use super::field::{ErrorValues, GaussianField, Trend};
use super::fit::GaussianError;
use super::posterior::{Conditioned, DrawnErrors, log_amplitude_std};
use crate::field_point::FieldPoint;
use crate::samples::PoseError;
use nalgebra::{Matrix6, Vector3, Vector6};
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

/// Deviations for a unit standard deviation of the process, the normal number of their amplitude, what a sensor is
/// off by itself, and the factor of each deviation of the model.
struct ReadingDraw {
    unit: Vector6<f64>,
    amplitude: f64,
    own: Vector6<f64>,
    of_model: Vec<f64>,
}

impl GaussianField {
    /// The expected error of `model_errors`, the errors of the room's model at the points. All
    /// rows are conditioned on; their noise is not in it.
    ///
    /// # Errors
    /// [`GaussianError::NotPositiveDefinite`].
    pub fn reading_errors(
        &self,
        at: &[FieldPoint],
        model_errors: &[PoseError],
    ) -> Result<Vec<ReadingError>, GaussianError> {
        let given = Conditioned::new(self.kernel, &self.rows, &self.amplitude)?;
        let components = self.components();
        let draws = self.reading_draws(&components);
        let mut found = Vec::with_capacity(at.len());
        for (block, model) in at.chunks(BLOCK).zip(model_errors.chunks(BLOCK)) {
            let (mean, explained) = given.at(block);
            let deviations = self.model_deviations(block);
            let each = block.par_iter().enumerate().map(|(i, point)| {
                let explained: f64 = explained.col(i).iter().map(|v| v * v).sum();
                let most = given.kernel.variance();
                let unit_variance = (most - explained).max(0.0);
                let log_std = log_amplitude_std(unit_variance / most, self.rows.len());
                let amplitude = self.amplitude.at(&point.position_mm);
                let own = std::array::from_fn(|c| mean[(i, c)] * amplitude);
                let bias = less_model(own, self.trend, &model[i]);
                let of_model: Vec<_> = deviations.iter().map(|of| Vector6::from(of[i])).collect();
                let std = [amplitude * unit_variance.sqrt(), log_std];
                self.reading_error(&bias, std, &of_model, &components, &draws)
            });
            found.par_extend(each);
        }
        Ok(found)
    }

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

    fn reading_error(
        &self,
        bias: &Vector6<f64>,
        [std, log_std]: [f64; 2],
        of_model: &[Vector6<f64>],
        components: &Matrix6<f64>,
        draws: &[ReadingDraw],
    ) -> ReadingError {
        let off: Vec<Vector6<f64>> = draws
            .iter()
            .map(|draw| {
                let of_model = of_model.iter().zip(&draw.of_model).map(|(of, factor)| of * *factor);
                // E(exp(2 l)) = 1, as in the draws of a posterior.
                let by = (log_std * draw.amplitude - log_std * log_std).exp();
                bias + draw.unit * (std * by) + draw.own + of_model.sum::<Vector6<f64>>()
            })
            .collect();
        let distance = |from: usize| {
            let part = |v: &Vector6<f64>| Vector3::from(v.fixed_rows::<3>(from));
            let variance = components.fixed_rows::<3>(from).norm_squared() * std * std
                + part(&self.sensor_std()).norm_squared()
                + of_model.iter().map(|of| part(of).norm_squared()).sum::<f64>();
            let mut distances: Vec<f64> = off.iter().map(|off| part(off).norm()).collect();
            let place = (0.95 * draws.len() as f64) as usize;
            let (_, within_95, _) = distances.select_nth_unstable_by(place, f64::total_cmp);
            ReadingDistance {
                rms: (part(bias).norm_squared() + variance).sqrt(),
                within_95: *within_95,
            }
        };
        ReadingError {
            position_mm: distance(0),
            angle_rad: self.has_rotations.then(|| distance(3)),
        }
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
