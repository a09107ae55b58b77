//! Fits the process: kernel, amplitude, outliers and the covariance of the components.

use super::amplitude::Amplitude;
use super::field::{GaussianField, Trend};
use super::hyper_parameters::{self, HyperParameters, MeasuredAxes, errors_of};
use super::kernel::Kernel;
use super::row::{ErrorValues, Row};
use crate::field_point::FieldPoint;
use crate::samples::{PoseError, SampleSet};
use faer::Mat;
use faer::linalg::solvers::Solve;
use nalgebra::{Matrix6, Unit, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use trackwright_geometry::bounds::Bounds;
use trackwright_task::{Cancelled, Task};

/// Rows that are kept. More of them are thinned by chance (with a fixed seed).
pub const MAX_ROWS: usize = 4_000;

/// Rows that amplitude and components are fitted to.
const CALIBRATION_ROWS: usize = 1_000;

/// Rows that the hyper-parameters are searched on.
pub const TUNING_ROWS: usize = 500;

/// Kernel and amplitude are found in turn.
const ROUNDS: usize = 4;
const FIRST_PASSES: usize = 12;
const LATER_PASSES: usize = 6;

/// A row whose squared leave-one-out residuals are more than this many times the median is an outlier.
/// Beside metal they reach half of that without any (rooms of an independent tracker).
const OUTLIER_RATIO: f64 = 60.0;

/// Noise of an outlier over that of others: it counts for nothing.
const OUTLIER_NOISE: f64 = 1e6;

/// Nugget is multiplied by this until the matrix is positive definite, at most so often.
const NUGGET_GROWTH: f64 = 10.0;
const MOST_GROWTHS: usize = 8;

/// Squared residuals count as no more than this many times their expectation in the variance: a few
/// rows beside metal must not make the field uncertain everywhere.
const MOST_RATIO: f64 = 8.0;

const SEED: u64 = 11;

/// Rows are kept to a nanometre, and to 1e-9 of an axis or a radian.
const PARTS_OF_MM: f64 = 1e6;
const PARTS_OF_ONE: f64 = 1e9;

/// Why there is no process.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GaussianError {
    #[error("found {0} measurements, expected at least {MIN_ROWS}")]
    TooFewRows(usize),
    #[error("sample {0} (counted from 0) has a number that is not finite, or an axis of no length")]
    NotFinite(usize),
    #[error("the covariance of {rows} measurements is not positive definite")]
    NotPositiveDefinite { rows: usize },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Fewest rows that determine a variance.
pub const MIN_ROWS: usize = 4;

impl GaussianField {
    /// Fits the process to samples less what a trend gives at each of them (nothing where `None`).
    /// The result does not depend on the number of threads.
    pub fn fit(
        set: &SampleSet,
        trend: Option<&[PoseError]>,
        task: &Task,
    ) -> Result<Self, GaussianError> {
        let samples = &set.samples;
        if samples.len() < MIN_ROWS {
            return Err(GaussianError::TooFewRows(samples.len()));
        }
        if let Some(i) = samples.iter().position(|s| !s.is_usable()) {
            return Err(GaussianError::NotFinite(i));
        }
        let bounds = Bounds::around(samples.iter().map(|s| s.position_mm))
            .ok_or(GaussianError::TooFewRows(0))?;
        let mut rows = rows(set, trend);
        let mut fitting = Fitting::new(&rows, &bounds, set.has_rotations);
        for round in 0..ROUNDS {
            let task =
                task.subtask(round as f64 / ROUNDS as f64, (round + 1) as f64 / ROUNDS as f64);
            fitting.improve(round, &task)?;
        }
        let (component_covariance, left_out_rms_mm) = fitting.components()?;
        fitting.flag_outliers(&mut rows, task)?;
        Ok(Self {
            trend: match trend {
                Some(_) => Trend::Model,
                None => Trend::None,
            },
            kernel: fitting.kernel,
            amplitude: fitting.amplitude,
            component_covariance,
            rows,
            has_rotations: set.has_rotations,
            measured_rows: samples.len(),
            left_out_rms_mm,
            sensor_variance: None,
            refits: Vec::new(),
            registration: None,
        })
    }

    /// The process conditioned on the same rows less another trend.
    #[must_use]
    pub fn with_trend(mut self, set: &SampleSet, trend: &[PoseError]) -> Self {
        for (row, other) in self.rows.iter_mut().zip(rows(set, Some(trend))) {
            row.error = other.error;
        }
        self
    }
}

/// Which of so many measurements are kept, in order.
pub fn kept_rows(measurements: usize) -> Vec<usize> {
    chosen_rows(measurements, MAX_ROWS)
}

/// The rows that are kept, rounded to what a table can mean, so that a file of them is small.
fn rows(set: &SampleSet, trend: Option<&[PoseError]>) -> Vec<Row> {
    let rounded = |value: f64, parts: f64| (value * parts).round() / parts;
    let rounded_axis =
        |axis: &Unit<Vector3<f64>>| Unit::new_unchecked(axis.map(|x| rounded(x, PARTS_OF_ONE)));
    let row = |i: usize| {
        let sample = &set.samples[i];
        let mut error = sample.error.values();
        if let Some(trend) = trend.and_then(|t| t.get(i)) {
            for (e, t) in error.iter_mut().zip(trend.values()) {
                *e -= t;
            }
        }
        for (c, e) in error.iter_mut().enumerate() {
            *e = rounded(*e, if c < 3 { PARTS_OF_MM } else { PARTS_OF_ONE });
        }
        Row {
            point: FieldPoint {
                position_mm: sample.position_mm.map(|x| rounded(x, PARTS_OF_MM)),
                axis: rounded_axis(&sample.axis),
                x_axis: sample.x_axis.as_ref().map(rounded_axis),
            },
            error,
            noise_factor: 1.0,
        }
    };
    kept_rows(set.samples.len()).into_iter().map(row).collect()
}

/// At most `most` of `count` indices, in order: all, or some by chance.
pub fn chosen_rows(count: usize, most: usize) -> Vec<usize> {
    let mut indices: Vec<usize> = (0..count).collect();
    if count > most {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        for i in 0..most {
            let j = i + (random.next_u64() % (count - i) as u64) as usize;
            indices.swap(i, j);
        }
        indices.truncate(most);
        indices.sort_unstable();
    }
    indices
}

/// The state of a fit: rows for calibration as measured, and what is found so far.
struct Fitting {
    rows: Vec<Row>,
    axes: MeasuredAxes,
    prior: HyperParameters,
    hyper_parameters: HyperParameters,
    kernel: Kernel,
    amplitude: Amplitude,
}

/// What rows predict of each other: the factor's solution, and the diagonal of the inverse.
struct LeftOut {
    /// `K⁻¹ y`.
    solved: Mat<f64>,
    /// Leave-one-out variance of each row (Rasmussen & Williams 2006, equation 5.12).
    variance: Vec<f64>,
}

impl Fitting {
    fn new(rows: &[Row], bounds: &Bounds, has_rotations: bool) -> Self {
        // The rows are in the table's order, which may be that of a sweep through the volume.
        let mut order = chosen_rows(rows.len(), CALIBRATION_ROWS);
        let mut random = ChaCha8Rng::seed_from_u64(SEED + 1);
        for i in (1..order.len()).rev() {
            order.swap(i, (random.next_u64() % (i as u64 + 1)) as usize);
        }
        let prior = hyper_parameters::start(bounds.diagonal_mm());
        let axes = match rows.iter().all(|row| row.point.x_axis.is_some()) {
            true => MeasuredAxes::Two,
            false if has_rotations => MeasuredAxes::One,
            false => MeasuredAxes::None,
        };
        Self {
            axes,
            rows: order.into_iter().map(|i| rows[i]).collect(),
            prior,
            hyper_parameters: prior,
            kernel: hyper_parameters::kernel(&prior, axes),
            amplitude: Amplitude::flat(bounds),
        }
    }

    /// One round: hyper-parameters at the amplitude so far, then the amplitude.
    fn improve(&mut self, round: usize, task: &Task) -> Result<(), GaussianError> {
        let scaled = scaled(&self.rows, &self.amplitude);
        let few = &scaled[..scaled.len().min(TUNING_ROWS)];
        let passes = if round == 0 { FIRST_PASSES } else { LATER_PASSES };
        self.hyper_parameters = hyper_parameters::tune(
            self.hyper_parameters,
            &self.prior,
            few,
            self.axes,
            passes,
            task,
        )?;
        self.kernel = hyper_parameters::kernel(&self.hyper_parameters, self.axes);
        let left_out = left_out(&mut self.kernel, &scaled)?;
        let covariance = covariance(&scaled, &left_out.solved, self.axes);
        let ratios = ratios(&left_out, &covariance, self.dof());
        for (row, is_outlier) in self.rows.iter_mut().zip(outliers(&left_out)) {
            if is_outlier {
                row.noise_factor = OUTLIER_NOISE;
            }
        }
        if round + 1 < ROUNDS {
            let good: Vec<_> = self
                .rows
                .iter()
                .zip(&ratios)
                .filter(|(row, _)| row.noise_factor < OUTLIER_NOISE)
                .map(|(row, ratio)| (row.point.position_mm, *ratio))
                .collect();
            self.amplitude = self.amplitude.updated(&good, self.dof());
        }
        Ok(())
    }

    /// Components of a row that carry information.
    fn dof(&self) -> f64 {
        if self.axes == MeasuredAxes::None { 3.0 } else { 5.0 }
    }

    /// The covariance of the components of unit amplitude, made right by the residuals of rows that
    /// were left out, and the RMS of those residuals' positions in mm.
    fn components(&mut self) -> Result<([ErrorValues; 6], f64), GaussianError> {
        let scaled = scaled(&self.rows, &self.amplitude);
        let left_out = left_out(&mut self.kernel, &scaled)?;
        let covariance = covariance(&scaled, &left_out.solved, self.axes);
        let good: Vec<usize> =
            (0..scaled.len()).filter(|i| scaled[*i].noise_factor < OUTLIER_NOISE).collect();
        let found = |components: std::ops::Range<usize>, dof: f64| -> f64 {
            let each = good.iter().map(|&i| {
                let ratio: f64 =
                    components.clone().map(|c| squared_ratio(&left_out, &covariance, i, c)).sum();
                (ratio / dof).min(MOST_RATIO)
            });
            (each.sum::<f64>() / good.len().max(1) as f64).sqrt()
        };
        let position = found(0..3, 3.0);
        let rotation = match self.axes {
            MeasuredAxes::None => 1.0,
            MeasuredAxes::One | MeasuredAxes::Two => found(3..6, 2.0),
        };
        let factor = |c: usize| if c < 3 { position } else { rotation };
        let squared_mm2 = |i: usize| -> f64 {
            let by = self.amplitude.at(&self.rows[i].point.position_mm);
            let residual = |c: usize| left_out.solved[(i, c)] * left_out.variance[i] * by;
            (0..3).map(|c| residual(c).powi(2)).sum()
        };
        let sum_mm2: f64 = good.iter().map(|&i| squared_mm2(i)).sum();
        let covariance = std::array::from_fn(|a| {
            std::array::from_fn(|b| covariance[(a, b)] * factor(a) * factor(b))
        });
        Ok((covariance, (sum_mm2 / good.len().max(1) as f64).sqrt()))
    }

    /// Marks outliers among all rows, part by part.
    fn flag_outliers(&mut self, rows: &mut [Row], task: &Task) -> Result<(), GaussianError> {
        let parts = rows.len().div_ceil(CALIBRATION_ROWS);
        for part in 0..parts {
            if task.cancel.is_cancelled() {
                return Err(Cancelled.into());
            }
            let own: Vec<usize> = (part..rows.len()).step_by(parts).collect();
            let some: Vec<Row> = own.iter().map(|&i| rows[i]).collect();
            let left_out = left_out(&mut self.kernel, &scaled(&some, &self.amplitude))?;
            for (&i, is_outlier) in own.iter().zip(outliers(&left_out)) {
                if is_outlier {
                    rows[i].noise_factor = OUTLIER_NOISE;
                }
            }
        }
        Ok(())
    }
}

/// Rows with their errors over the amplitude.
pub(super) fn scaled(rows: &[Row], amplitude: &Amplitude) -> Vec<Row> {
    let each = rows.iter().map(|row| {
        let by = 1.0 / amplitude.at(&row.point.position_mm);
        Row { error: row.error.map(|e| e * by), ..*row }
    });
    each.collect()
}

/// Factors the rows' covariance; where it is not positive definite the nugget grows.
pub(super) fn factored(
    kernel: &mut Kernel,
    rows: &[Row],
) -> Result<faer::linalg::solvers::Llt<f64>, GaussianError> {
    for _ in 0..MOST_GROWTHS {
        if let Ok(factor) = kernel.of_rows(rows).llt(faer::Side::Lower) {
            return Ok(factor);
        }
        kernel.nugget *= NUGGET_GROWTH;
    }
    Err(GaussianError::NotPositiveDefinite { rows: rows.len() })
}

fn left_out(kernel: &mut Kernel, rows: &[Row]) -> Result<LeftOut, GaussianError> {
    let factor = factored(kernel, rows)?;
    let n = rows.len();
    // K⁻¹ = L⁻ᵀ L⁻¹: its diagonal has the squares of the columns of L⁻¹.
    let mut inverse = Mat::<f64>::zeros(n, n);
    faer::linalg::triangular_inverse::invert_lower_triangular(
        inverse.as_mut(),
        factor.L(),
        faer::get_global_parallelism(),
    );
    let square = |i: usize| -> f64 { (i..n).map(|k| inverse[(k, i)].powi(2)).sum() };
    Ok(LeftOut {
        solved: factor.solve(&errors_of(rows)),
        variance: (0..n).map(|i| 1.0 / square(i)).collect(),
    })
}

/// `Yᵀ K⁻¹ Y / N`. A 5-DOF row has two of three components of its rotation, so that the mean of
/// their squares is two thirds of what it is where all are measured. Those of 6-DOF sensors count likewise:
/// with three, 95 % bounds of angles hold 89 % for a sensor left out of a real table, with two 94 %.
fn covariance(rows: &[Row], solved: &Mat<f64>, axes: MeasuredAxes) -> Matrix6<f64> {
    let n = rows.len() as f64;
    Matrix6::from_fn(|a, b| {
        let sum: f64 = rows
            .iter()
            .enumerate()
            .map(|(i, row)| 0.5 * (row.error[a] * solved[(i, b)] + row.error[b] * solved[(i, a)]))
            .sum();
        let rotations = i32::from(a >= 3) + i32::from(b >= 3);
        match axes {
            MeasuredAxes::None if rotations > 0 => 0.0,
            MeasuredAxes::None => sum / n,
            MeasuredAxes::One | MeasuredAxes::Two => sum / n * 1.5_f64.sqrt().powi(rotations),
        }
    })
}

/// Squared leave-one-out residual of a component over its expectation.
fn squared_ratio(left_out: &LeftOut, covariance: &Matrix6<f64>, row: usize, c: usize) -> f64 {
    let variance = left_out.variance[row];
    let residual = left_out.solved[(row, c)] * variance;
    let expected = covariance[(c, c)] * variance;
    if expected > 0.0 { residual * residual / expected } else { 0.0 }
}

/// Rows whose residuals are far beyond those of most. Each component is held against the median of
/// its own squares, which outliers do not move.
fn outliers(left_out: &LeftOut) -> Vec<bool> {
    let rows = left_out.variance.len();
    let square = |row: usize, c: usize| {
        let residual = left_out.solved[(row, c)];
        residual * residual * left_out.variance[row]
    };
    let scales: Vec<f64> =
        (0..6).map(|c| median(&(0..rows).map(|row| square(row, c)).collect::<Vec<_>>())).collect();
    let ratio = |row: usize| -> f64 {
        let measured = (0..6).filter(|c| scales[*c] > 0.0);
        measured.map(|c| square(row, c) / scales[c]).sum()
    };
    let ratios: Vec<f64> = (0..rows).map(ratio).collect();
    let most = OUTLIER_RATIO * median(&ratios);
    ratios.into_iter().map(|r| r > most && most > 0.0).collect()
}

/// Mean squared leave-one-out residual of each row over its expectation.
fn ratios(left_out: &LeftOut, covariance: &Matrix6<f64>, dof: f64) -> Vec<f64> {
    (0..left_out.variance.len())
        .map(|row| {
            let each = (0..6).map(|c| squared_ratio(left_out, covariance, row, c));
            each.sum::<f64>() / dof
        })
        .collect()
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
