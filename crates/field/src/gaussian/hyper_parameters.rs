//! Length scales, parts of the variance and nugget that make the measurements likely.

use super::kernel::{Kernel, KernelScale};
use super::row::Row;
use faer::Mat;
use faer::linalg::solvers::Solve;
use trackwright_task::{Cancelled, Task};

/// Lengths and axis scales of the second scale over those of the first. What one scale calls noise
/// is mostly field at a shorter length; 500 rows have too few close pairs to find the ratio, so it
/// is fixed (found over rooms of independent trackers: a third and 0.4).
const SECOND_LENGTH: f64 = 0.33;
const SECOND_SINE: f64 = 0.4;

/// The prior on the logarithms: mean and standard deviation. Broad: it decides where there are few
/// rows. The length is a part of the box's diagonal.
const PRIOR_LENGTH_PART: f64 = 0.2;
const PRIOR_STD: [f64; 5] = [0.7, 0.5, 1.0, 2.5, 0.5];
const PRIOR_SINE: f64 = 0.5;
const PRIOR_SECOND: f64 = 0.25;
const PRIOR_NUGGET: f64 = 1e-3;

/// Standard deviation on the logarithmic scale of the process's variance above the rows' mean square. Rows
/// along a path are so near each other that their likelihood is about the path alone: it is largest for
/// lengths and variances with which the field away from it may be anything. Small, so that it is a bound.
const VARIANCE_STD: f64 = 0.1;

/// Most of the variance that the second scale may have, over that of the first.
const MOST_SECOND: f64 = 0.5;

/// Least nugget: below it duplicated rows make the matrix singular.
const LEAST_NUGGET: f64 = 1e-6;
const MOST_NUGGET: f64 = 10.0;

/// First steps of the search, in the logarithms, and where it ends.
const FIRST_STEP: f64 = 0.4;
const LAST_STEP: f64 = 0.03;

/// Logarithms of length, axis scale, second scale's variance, nugget and second axis's scale.
pub(super) type HyperParameters = [f64; 5];

/// Which axes of the sensors were measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MeasuredAxes {
    None,
    One,
    /// Of 6-DOF sensors.
    Two,
}

/// Where the search begins: the prior's means.
pub(super) fn start(diagonal_mm: f64) -> HyperParameters {
    [
        (PRIOR_LENGTH_PART * diagonal_mm).max(1.0).ln(),
        PRIOR_SINE.ln(),
        PRIOR_SECOND.ln(),
        PRIOR_NUGGET.ln(),
        PRIOR_SINE.ln(),
    ]
}

/// The kernel of some hyper-parameters; without axes only the position counts.
pub(super) fn kernel(values: &HyperParameters, axes: MeasuredAxes) -> Kernel {
    let [length, sine, second, nugget, x_sine] = values.map(f64::exp);
    let sine = if axes == MeasuredAxes::None { f64::INFINITY } else { sine };
    let x_sine = if axes == MeasuredAxes::Two { x_sine } else { f64::INFINITY };
    Kernel {
        scales: [
            KernelScale { length_mm: length, axis_sine: sine, x_axis_sine: x_sine, variance: 1.0 },
            KernelScale {
                length_mm: SECOND_LENGTH * length,
                axis_sine: SECOND_SINE * sine,
                x_axis_sine: SECOND_SINE * x_sine,
                variance: second.min(MOST_SECOND),
            },
        ],
        nugget: nugget.clamp(LEAST_NUGGET, MOST_NUGGET),
    }
}

/// Maximises the posterior of the hyper-parameters by a coordinate search: steps that succeed grow,
/// others are halved. The likelihood is that of all components, with the variances of positions
/// and of rotations profiled out.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn tune(
    from: HyperParameters,
    prior: &HyperParameters,
    rows: &[Row],
    axes: MeasuredAxes,
    passes: usize,
    task: &Task,
) -> Result<HyperParameters, Cancelled> {
    let objective = |values: &HyperParameters| {
        let distance: f64 = (0..5).map(|k| ((values[k] - prior[k]) / PRIOR_STD[k]).powi(2)).sum();
        log_likelihood(&kernel(values, axes), rows, axes) - 0.5 * distance
    };
    let (mut best, mut at) = (objective(&from), from);
    let mut steps = [FIRST_STEP; 5];
    for pass in 0..passes {
        task.step(pass, passes)?;
        for k in 0..5 {
            let is_unused = match k {
                1 => axes == MeasuredAxes::None,
                4 => axes != MeasuredAxes::Two,
                _ => false,
            };
            if is_unused {
                steps[k] = 0.0;
                continue;
            }
            let mut has_moved = false;
            for sign in [1.0, -1.0] {
                let mut tried = at;
                tried[k] += sign * steps[k];
                let value = objective(&tried);
                if value > best {
                    (best, at, has_moved) = (value, tried, true);
                    break;
                }
            }
            steps[k] *= if has_moved { 1.3 } else { 0.5 };
            if task.cancel.is_cancelled() {
                return Err(Cancelled);
            }
        }
        if steps.iter().all(|step| *step < LAST_STEP) {
            break;
        }
    }
    Ok(at)
}

/// Log marginal likelihood, up to a constant; negative infinity where the matrix is not positive
/// definite.
fn log_likelihood(kernel: &Kernel, rows: &[Row], axes: MeasuredAxes) -> f64 {
    let Ok(factor) = kernel.of_rows(rows).llt(faer::Side::Lower) else {
        return f64::NEG_INFINITY;
    };
    let n = rows.len();
    let lower = factor.L();
    let log_determinant: f64 = (0..n).map(|i| 2.0 * lower[(i, i)].ln()).sum();
    let errors = errors_of(rows);
    let solved = factor.solve(&errors);
    let square = |columns: std::ops::Range<usize>| -> f64 {
        columns.flat_map(|j| (0..n).map(move |i| (i, j))).map(|at| errors[at] * solved[at]).sum()
    };
    let part = |columns: std::ops::Range<usize>, dof: f64| {
        let measured: f64 = columns.clone().map(|j| errors.col(j).squared_norm_l2()).sum();
        let variance = (square(columns) / (dof * n as f64)).max(f64::MIN_POSITIVE);
        let beyond = (kernel.variance() * variance * dof * n as f64 / measured).ln().max(0.0);
        dof * (log_determinant + n as f64 * variance.ln()) + (beyond / VARIANCE_STD).powi(2)
    };
    let positions = part(0..3, 3.0);
    // The component along the axis of a 5-DOF sensor is zero: two are informative.
    let rotations = if axes == MeasuredAxes::None { 0.0 } else { part(3..6, 2.0) };
    -0.5 * (positions + rotations)
}

/// The rows' errors, a row each.
pub(super) fn errors_of(rows: &[Row]) -> Mat<f64> {
    Mat::from_fn(rows.len(), 6, |i, j| rows[i].error[j])
}
