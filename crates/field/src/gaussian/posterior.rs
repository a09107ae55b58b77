//! The field at some sensor poses given the measurements: its mean, and draws around it.

use super::amplitude::Amplitude;
use super::column_blocks::{less_gram, lower_times, solve_lower};
use super::field::GaussianField;
use super::fit::{GaussianError, factored, scaled};
use super::hyper_parameters::errors_of;
use super::kernel::{Kernel, KernelScale, lower_from};
use super::kernel_columns::{PointColumns, exponentials};
use super::row::{ErrorValues, Row};
use crate::field_point::FieldPoint;
use faer::Mat;
use faer::linalg::solvers::{Llt, Solve};
use nalgebra::Matrix6;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

/// Rows that a query is conditioned on, as many as it has poses within these: those with the largest
/// covariance to any of its poses. In rooms of 2,000 rows those beyond 700 change a mean by less than a
/// hundredth of its standard deviation.
const NEAREST_ROWS: usize = 400;
const MOST_NEAREST_ROWS: usize = 700;

/// Poses of the query by which rows are chosen.
const JUDGING_POINTS: usize = 24;

/// Standard deviations of the logarithm of a draw's amplitude: what varies from place to place over
/// `AMPLITUDE_LENGTH_MM` whatever the axis, and what varies with the axis as well. By the kurtosis of
/// leave-one-out residuals and the dependence of their squares over distance, in rooms of an
/// independent tracker.
const PLACE_LOG_STD: f64 = 0.2;
const AXIS_LOG_STD: f64 = 0.39;
const AMPLITUDE_LENGTH_MM: f64 = 80.0;
const AMPLITUDE_SINE: f64 = 0.4;

/// The same for all points at once where nothing was measured near: a table determines an amplitude where its
/// rows are, in place and in axis. By ten rooms of `tests/rooms/others.rs`, six of them paths: without it 20 %
/// of the intervals hold in two of those, with twice as much intervals within a cone are 1.5 to 1.7 times as wide.
const UNKNOWN_LOG_STD: f64 = 0.35;

/// A variance from n values is uncertain by a part of sqrt(2 / n), its root by half of that.
const VARIANCE_LOG_STD: f64 = 0.707;

/// Added to a unit covariance's diagonal before it is factored.
const ROUND_OFF: f64 = 1e-9;

/// Errors at each point of one drawn field.
pub type DrawnErrors = Vec<ErrorValues>;

/// The field at some sensor poses, less the trend.
#[derive(Clone, Debug)]
pub struct Posterior {
    /// mm and rad.
    pub mean: Vec<ErrorValues>,
    /// Variance of the process of unit amplitude at each point, from 0 (measured there) to the
    /// kernel's variance (nothing measured near).
    pub unit_variance: Vec<f64>,
    /// Rows that it is conditioned on.
    pub rows: usize,
    /// Lower Cholesky factor of the unit covariance among the points.
    factor: Mat<f64>,
    amplitude: Vec<f64>,
    /// Lower Cholesky factor of the components' covariance.
    components: Matrix6<f64>,
    /// Lower Cholesky factor of the covariance of the logarithm of a draw's amplitude.
    log_amplitude: Mat<f64>,
    /// Standard deviation of the logarithm of the amplitude of all points at once, at each.
    common_log_std: Vec<f64>,
    /// Of each refit of the room's model.
    model_deviations: Vec<DrawnErrors>,
}

/// A process given rows: their covariance factored once, then evaluated at any poses.
///
/// Of unit amplitude; the rows are divided by theirs.
pub(super) struct Conditioned {
    pub kernel: Kernel,
    points: Vec<FieldPoint>,
    factor: Llt<f64>,
    weights: Mat<f64>,
}

impl Conditioned {
    /// # Errors
    /// [`GaussianError::NotPositiveDefinite`].
    pub fn new(
        mut kernel: Kernel,
        rows: &[Row],
        amplitude: &Amplitude,
    ) -> Result<Self, GaussianError> {
        let rows = scaled(rows, amplitude);
        let factor = factored(&mut kernel, &rows)?;
        Ok(Self {
            kernel,
            weights: factor.solve(&errors_of(&rows)),
            factor,
            points: rows.iter().map(|row| row.point).collect(),
        })
    }

    pub fn rows(&self) -> usize {
        self.points.len()
    }

    /// Variance at each pose that the rows leave, from 0 to the kernel's.
    fn variances(&self, at: &[FieldPoint]) -> Vec<f64> {
        let (_, explained) = self.at(at);
        let left = |i| (self.kernel.variance() - explained.col(i).squared_norm_l2()).max(0.0);
        (0..at.len()).map(left).collect()
    }

    /// The mean, a row a pose, and `V = L⁻¹ K(rows, at)`: `V' V` is the covariance that the rows explain.
    pub fn at(&self, at: &[FieldPoint]) -> (Mat<f64>, Mat<f64>) {
        let across = self.kernel.matrix(&self.points, at);
        let mean = across.transpose() * &self.weights;
        let mut explained = across;
        solve_lower(self.factor.L(), explained.as_mut());
        (mean, explained)
    }
}

impl GaussianField {
    /// The field at some poses, given the rows nearest to them.
    ///
    /// # Errors
    /// [`GaussianError::NotPositiveDefinite`].
    pub fn posterior(&self, at: &[FieldPoint]) -> Result<Posterior, GaussianError> {
        let given = Conditioned::new(self.kernel, &self.nearest(at), &self.amplitude)?;
        let (mean, explained) = given.at(at);
        let amplitude: Vec<f64> = at.iter().map(|p| self.amplitude.at(&p.position_mm)).collect();
        let mut unit = given.kernel.lower_triangle(at);
        less_gram(unit.as_mut(), explained.as_ref());
        let unit_variance: Vec<f64> = (0..at.len()).map(|i| unit[(i, i)].max(0.0)).collect();
        let (factor, log_amplitude) = rayon::join(
            || lower(unit, given.kernel.variance()),
            || {
                lower(
                    log_amplitude_covariance(at, self.has_rotations),
                    PLACE_LOG_STD.powi(2) + AXIS_LOG_STD.powi(2),
                )
            },
        );
        Ok(Posterior {
            mean: (0..at.len())
                .map(|i| std::array::from_fn(|c| mean[(i, c)] * amplitude[i]))
                .collect(),
            common_log_std: unit_variance
                .iter()
                .map(|left| common_log_std(left / given.kernel.variance(), self.rows.len()))
                .collect(),
            unit_variance,
            rows: given.rows(),
            factor: factor?,
            amplitude,
            components: self.components(),
            log_amplitude: log_amplitude?,
            model_deviations: self.model_deviations(at),
        })
    }

    /// [`Posterior::unit_variance`] alone: linear in the poses.
    ///
    /// # Errors
    /// [`GaussianError::NotPositiveDefinite`].
    pub fn unit_variances(&self, at: &[FieldPoint]) -> Result<Vec<f64>, GaussianError> {
        let given = Conditioned::new(self.kernel, &self.nearest(at), &self.amplitude)?;
        Ok(given.variances(at))
    }

    /// The rows that are most informative at some poses, in the table's order.
    fn nearest(&self, at: &[FieldPoint]) -> Vec<Row> {
        let nearest = at.len().clamp(NEAREST_ROWS, MOST_NEAREST_ROWS);
        if self.rows.len() <= nearest || at.is_empty() {
            return self.rows.clone();
        }
        let step = at.len().div_ceil(JUDGING_POINTS);
        let judges: Vec<_> = at.iter().step_by(step).copied().collect();
        let points: Vec<_> = self.rows.iter().map(|row| row.point).collect();
        let across = self.kernel.matrix(&points, &judges);
        let score = |i: usize| (0..judges.len()).map(|j| across[(i, j)]).fold(0.0, f64::max);
        let scores: Vec<f64> = (0..points.len()).map(score).collect();
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.select_nth_unstable_by(nearest, |a, b| {
            scores[*b].total_cmp(&scores[*a]).then(a.cmp(b))
        });
        order.truncate(nearest);
        order.sort_unstable();
        order.into_iter().map(|i| self.rows[i]).collect()
    }

    /// Lower Cholesky factor of the components' covariance, zero for what was not measured.
    pub(super) fn components(&self) -> Matrix6<f64> {
        let covariance = Matrix6::from_fn(|a, b| self.component_covariance[a][b]);
        let scale = covariance.diagonal().map(|v| v.max(0.0).sqrt());
        // In units of each component: radians are a thousandth of millimetres.
        let unit = Matrix6::from_fn(|a, b| {
            let by = scale[a] * scale[b];
            match (a == b, by > 0.0) {
                (true, _) => 1.0 + ROUND_OFF,
                (false, true) => covariance[(a, b)] / by,
                (false, false) => 0.0,
            }
        });
        let factor = unit.cholesky().map_or_else(Matrix6::identity, |factor| factor.l());
        Matrix6::from_diagonal(&scale) * factor
    }
}

impl Posterior {
    /// Drawn fields at the points, the trend not added. The same seed gives the same draws. They come in
    /// pairs that lie on opposite sides of the mean, so that what depends on the field to first order has
    /// its mean without noise (antithetic variates; Hammersley and Morton 1956).
    pub fn draws(&self, count: usize, seed: u64) -> Vec<DrawnErrors> {
        let points = self.mean.len();
        let pairs = count.div_ceil(2);
        // Of each pair a normal number for all points, seven for each, and one for each refit.
        let refits = self.model_deviations.len();
        let normals = |pair: usize| -> Vec<f64> {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(pair as u64);
            (0..=7 * points + refits).map(|_| StandardNormal.sample(&mut random)).collect()
        };
        let normals: Vec<Vec<f64>> = (0..pairs).into_par_iter().map(normals).collect();
        let logs = Mat::from_fn(points, pairs, |i, pair| normals[pair][1 + i]);
        let units =
            Mat::from_fn(points, 6 * pairs, |i, k| normals[k / 6][1 + (1 + k % 6) * points + i]);
        let logs = lower_times(self.log_amplitude.as_ref(), logs.as_ref());
        let units = lower_times(self.factor.as_ref(), units.as_ref());
        // E(exp(2 l)) = 1: a draw's variance is right on the average.
        let less = PLACE_LOG_STD.powi(2) + AXIS_LOG_STD.powi(2);
        let of_pair = |pair: usize| -> [DrawnErrors; 2] {
            let common = |i: usize| {
                let std = self.common_log_std[i];
                std * normals[pair][0] - std * std - less
            };
            let mut by: Vec<f64> = (0..points).map(|i| logs[(i, pair)] + common(i)).collect();
            exponentials(&mut by);
            let each = by.iter().zip(&self.amplitude).enumerate().map(|(i, (by, amplitude))| {
                let unit = nalgebra::Vector6::from_fn(|c, _| units[(i, 6 * pair + c)]);
                let of_model = self.model_deviations.iter().zip(&normals[pair][1 + 7 * points..]);
                of_model.fold(self.components * unit * (by * amplitude), |sum, (of, factor)| {
                    sum + nalgebra::Vector6::from(of[i]) * *factor
                })
            });
            let deviations: Vec<_> = each.collect();
            [1.0, -1.0].map(|side| {
                let each = self.mean.iter().zip(&deviations);
                each.map(|(mean, of)| std::array::from_fn(|c| mean[c] + side * of[c])).collect()
            })
        };
        let mut draws: Vec<DrawnErrors> =
            (0..pairs).into_par_iter().flat_map_iter(of_pair).collect();
        draws.truncate(count);
        draws
    }
}

/// Standard deviation of the logarithm of the amplitude of all points at once, at one of which the rows leave
/// this part of the variance.
fn common_log_std(part_left: f64, rows: usize) -> f64 {
    (VARIANCE_LOG_STD / (rows as f64).sqrt()).hypot(UNKNOWN_LOG_STD * part_left)
}

/// Standard deviation of the logarithm of a draw's amplitude at one point, where the rows leave this part of the
/// variance.
pub(super) fn log_amplitude_std(part_left: f64, rows: usize) -> f64 {
    let common = common_log_std(part_left, rows);
    (PLACE_LOG_STD.powi(2) + AXIS_LOG_STD.powi(2) + common.powi(2)).sqrt()
}

/// Covariance of the logarithm of a draw's amplitude among points, the lower triangle.
fn log_amplitude_covariance(at: &[FieldPoint], has_axes: bool) -> Mat<f64> {
    let length_mm = AMPLITUDE_LENGTH_MM;
    let place = KernelScale {
        length_mm,
        axis_sine: f64::INFINITY,
        x_axis_sine: f64::INFINITY,
        variance: PLACE_LOG_STD.powi(2),
    };
    let axis = KernelScale {
        length_mm,
        axis_sine: if has_axes { AMPLITUDE_SINE } else { f64::INFINITY },
        x_axis_sine: f64::INFINITY,
        variance: AXIS_LOG_STD.powi(2),
    };
    let columns = PointColumns::of(at);
    lower_from(at.len(), |j| columns.gaussian(&[place, axis], j, &at[j]))
}

/// Lower Cholesky factor of a covariance, of which the lower triangle is read, that round-off may have made
/// indefinite.
fn lower(mut covariance: Mat<f64>, scale: f64) -> Result<Mat<f64>, GaussianError> {
    let n = covariance.nrows();
    let mut added = ROUND_OFF * scale;
    for _ in 0..6 {
        for i in 0..n {
            covariance[(i, i)] += added;
        }
        if let Ok(factor) = covariance.llt(faer::Side::Lower) {
            return Ok(factor.L().to_owned());
        }
        added *= 10.0;
    }
    Err(GaussianError::NotPositiveDefinite { rows: n })
}
