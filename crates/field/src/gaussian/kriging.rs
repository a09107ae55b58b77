//! The mean of a process given all of its rows, as a model of a room's field (kriging).
//!
//! The kernel's part in the axis is cut to harmonics of low degree, so that the mean is one of them
//! too and its compiled form is exact in the axis. What is cut off counts as noise of each row.

use super::amplitude::Amplitude;
use super::field::GaussianField;
use super::fit::{GaussianError, scaled};
use super::hyper_parameters::errors_of;
use super::kernel::{Kernel, lower_from, matern};
use super::row::ErrorValues;
use crate::compiled::CompiledField;
use crate::compiled::even_harmonics::{self, MAX_FUNCTIONS, functions};
use crate::computed::PoseErrors;
use crate::evaluation::Coefficient;
use crate::field_point::FieldPoint;
use faer::Mat;
use faer::linalg::solvers::Solve;
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::rotation::perpendicular;
use trackwright_task::{Cancelled, Task};

/// Highest degree of the mean in the axis: on the cube's table degrees 4, 6, 8 and 10 left 1.008, 0.876,
/// 0.849 and 0.843 mm of the held-out rows.
pub const AXIS_DEGREE: usize = 6;

/// Rolls that the mean over all of them is that of: an even polynomial of degree 6 in the second axis has no
/// frequency above 6 in the roll, and these are exact below 8.
const ROLLS: usize = 4;

/// Even degrees up to [`AXIS_DEGREE`].
const DEGREES: usize = AXIS_DEGREE / 2 + 1;

/// Length of a cell of the compiled form over the kernel's shortest length.
const CELL_PART: f64 = 0.5;

/// Steps of the integrals over the axis kernel, which is smooth.
const STEPS: usize = 400;

/// The mean of a process without trend.
#[derive(Clone, Debug, PartialEq)]
pub struct Kriging {
    process: Arc<GaussianField>,
    /// `K⁻¹ y` of each row, of unit amplitude.
    weights: Vec<ErrorValues>,
    /// Of the process's kernel.
    series: Series,
}

impl Kriging {
    /// Solves for the weights of all rows.
    ///
    /// # Errors
    /// [`GaussianError::NotPositiveDefinite`], [`GaussianError::Cancelled`].
    pub fn new(process: Arc<GaussianField>, task: &Task) -> Result<Self, GaussianError> {
        let rows = scaled(&process.rows, &process.amplitude);
        let series = Series::of(&process.kernel);
        let factor = series.factored(&process, task)?;
        let solved = factor.solve(&errors_of(&rows));
        let weights = (0..rows.len()).map(|i| std::array::from_fn(|c| solved[(i, c)])).collect();
        Ok(Self { process, weights, series })
    }

    /// A mean whose weights are known; `None` where there are not as many as rows.
    pub fn of_weights(process: Arc<GaussianField>, weights: Vec<ErrorValues>) -> Option<Self> {
        let series = Series::of(&process.kernel);
        (weights.len() == process.rows.len()).then_some(Self { process, weights, series })
    }

    /// The process that this is the mean of.
    pub fn process(&self) -> &Arc<GaussianField> {
        &self.process
    }

    /// `K⁻¹ y` of each row, of unit amplitude.
    pub fn weights(&self) -> &[ErrorValues] {
        &self.weights
    }

    /// Whether it depends on the roll of a sensor, as it does where the rows are of 6-DOF sensors.
    pub fn depends_on_roll(&self) -> bool {
        self.series.x_parts.is_some()
    }

    /// The mean at a pose, summed over all rows.
    pub fn evaluate(&self, at: &FieldPoint) -> ErrorValues {
        let mut sum = [0.0; 6];
        for (row, weights) in self.process.rows.iter().zip(&self.weights) {
            let covariance = self.series.covariance(&row.point, at);
            for (sum, weight) in sum.iter_mut().zip(weights) {
                *sum += covariance * weight;
            }
        }
        let amplitude = self.process.amplitude.at(&at.position_mm);
        sum.map(|e| e * amplitude)
    }

    /// The compiled form over a box, of a mean that does not depend on the roll.
    pub fn compiled(&self, bounds: &Bounds) -> CompiledField {
        let nodes = NodeSums::new(self);
        let shortest_mm = self.series.lengths_mm.into_iter().fold(f64::INFINITY, f64::min);
        let cell_mm = CELL_PART * shortest_mm;
        CompiledField::new(*bounds, cell_mm, self.axis_degree(), |places| nodes.at(places))
    }

    fn axis_degree(&self) -> usize {
        if self.process.has_rotations { AXIS_DEGREE } else { 0 }
    }

    /// What the rows outside of each fold predict at the fold's rows, the hyper-parameters kept.
    /// Folds are indices of rows; the result has a value for each row of each fold, in their order.
    pub fn left_out(
        process: &GaussianField,
        folds: &[Vec<usize>],
        task: &Task,
    ) -> Result<Vec<Vec<ErrorValues>>, GaussianError> {
        let rows = scaled(&process.rows, &process.amplitude);
        let factor = Series::of(&process.kernel).factored(process, task)?;
        let count = rows.len();
        let inverse = factor.solve(&Mat::<f64>::identity(count, count));
        let solved = &inverse * errors_of(&rows);
        let fold = |fold: &Vec<usize>| -> Result<Vec<ErrorValues>, GaussianError> {
            if task.cancel.is_cancelled() {
                return Err(Cancelled.into());
            }
            // What is left where a block is left out: (K⁻¹)_FF⁻¹ (K⁻¹ y)_F.
            let own = Mat::from_fn(fold.len(), fold.len(), |i, j| inverse[(fold[i], fold[j])]);
            let right = Mat::from_fn(fold.len(), 6, |i, c| solved[(fold[i], c)]);
            let left = own
                .llt(faer::Side::Lower)
                .map_err(|_| GaussianError::NotPositiveDefinite { rows: count })?
                .solve(&right);
            let each = fold.iter().enumerate().map(|(i, &row)| {
                let by = process.amplitude.at(&rows[row].point.position_mm);
                std::array::from_fn(|c| process.rows[row].error[c] - left[(i, c)] * by)
            });
            Ok(each.collect())
        };
        folds.iter().map(fold).collect()
    }
}

impl PoseErrors for Kriging {
    /// The mean over the roll, where it depends on that.
    fn axis_errors(
        &self,
        positions_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
        out: &mut [Option<Coefficient>],
    ) {
        let rolls = if self.depends_on_roll() { ROLLS } else { 1 };
        let rolled = |(position_mm, axis): (&Point3<f64>, &Unit<Vector3<f64>>)| {
            let across = perpendicular(axis);
            let turned = |roll: usize| FieldPoint {
                x_axis: Some(
                    UnitQuaternion::from_axis_angle(axis, PI * roll as f64 / ROLLS as f64) * across,
                ),
                ..FieldPoint::new(*position_mm, *axis)
            };
            (0..rolls).map(turned).collect::<Vec<_>>()
        };
        let points: Vec<_> = positions_mm.iter().zip(axes).flat_map(rolled).collect();
        let values: Vec<ErrorValues> = points.iter().map(|at| self.evaluate(at)).collect();
        for (out, values) in out.iter_mut().zip(values.chunks_exact(rolls)) {
            let mean = |c: usize| values.iter().map(|v| v[c]).sum::<f64>() / rolls as f64;
            *out = Some(std::array::from_fn(mean));
        }
    }
}

/// A kernel whose axis part is a sum of Legendre polynomials of even degree.
#[derive(Clone, Debug, PartialEq)]
struct Series {
    lengths_mm: [f64; 2],
    /// Variance of each scale.
    variances: [f64; 2],
    /// Parts of the axis kernel of each scale, by degree.
    parts: [[f64; DEGREES]; 2],
    /// Those of the second axis; `None` where it does not matter.
    x_parts: Option<[[f64; DEGREES]; 2]>,
    nugget: f64,
}

impl Series {
    fn of(kernel: &Kernel) -> Self {
        Self {
            lengths_mm: kernel.scales.map(|scale| scale.length_mm),
            variances: kernel.scales.map(|scale| scale.variance),
            parts: kernel.scales.map(|scale| axis_parts(scale.axis_sine)),
            x_parts: (kernel.scales.iter().any(|scale| scale.x_axis_sine.is_finite()))
                .then(|| kernel.scales.map(|scale| axis_parts(scale.x_axis_sine))),
            nugget: kernel.nugget,
        }
    }

    /// Between a row and another sensor.
    fn covariance(&self, row: &FieldPoint, other: &FieldPoint) -> f64 {
        let distance_mm = (row.position_mm - other.position_mm).norm();
        let [axis, x_axis] = row.cosines(other);
        let sum = |parts: &[f64; DEGREES], legendre: &[f64; DEGREES]| -> f64 {
            parts.iter().zip(legendre).map(|(part, p)| part * p).sum()
        };
        let legendre = even_legendre(axis);
        let of_x_axis = self.x_parts.as_ref().map(|parts| (parts, even_legendre(x_axis)));
        let scale = |k: usize| {
            let by_x_axis = of_x_axis.as_ref().map_or(1.0, |(parts, p)| sum(&parts[k], p));
            let by_axes = sum(&self.parts[k], &legendre) * by_x_axis;
            self.variances[k] * matern(distance_mm / self.lengths_mm[k], 0.0) * by_axes
        };
        scale(0) + scale(1)
    }

    /// Variance that is cut off at a row.
    fn lost(&self, row: &FieldPoint) -> f64 {
        let all: f64 = self.variances.iter().sum();
        (all - self.covariance(row, row)).max(0.0)
    }

    /// Factors the covariance of a process's rows with their noise.
    fn factored(
        &self,
        process: &GaussianField,
        task: &Task,
    ) -> Result<faer::linalg::solvers::Llt<f64>, GaussianError> {
        let rows = &process.rows;
        let mut matrix = lower_from(rows.len(), |j| {
            let below = rows[j..].iter();
            below.map(|row| self.covariance(&row.point, &rows[j].point)).collect()
        });
        if task.cancel.is_cancelled() {
            return Err(Cancelled.into());
        }
        for (i, row) in rows.iter().enumerate() {
            matrix[(i, i)] += self.nugget * row.noise_factor + self.lost(&row.point);
        }
        matrix
            .llt(faer::Side::Lower)
            .map_err(|_| GaussianError::NotPositiveDefinite { rows: rows.len() })
    }
}

/// Coefficients of `exp(−sin² / 2σ²)` in Legendre polynomials of even degree: all of them positive.
fn axis_parts(sine: f64) -> [f64; DEGREES] {
    let mut parts = [0.0; DEGREES];
    if !sine.is_finite() {
        parts[0] = 1.0;
        return parts;
    }
    // Simpson's rule over half of an even integrand.
    for step in 0..=STEPS {
        let cosine = step as f64 / STEPS as f64;
        let weight = match step {
            0 | STEPS => 1.0,
            _ if step % 2 == 1 => 4.0,
            _ => 2.0,
        } / (3.0 * STEPS as f64);
        let value = weight * (-0.5 * (1.0 - cosine * cosine) / (sine * sine)).exp();
        for (half, (part, p)) in parts.iter_mut().zip(even_legendre(cosine)).enumerate() {
            *part += (4 * half + 1) as f64 * value * p;
        }
    }
    parts
}

/// `P_0, P_2, P_4, …` at a cosine.
fn even_legendre(x: f64) -> [f64; DEGREES] {
    let mut even = [1.0; DEGREES];
    let (mut before, mut p) = (1.0, x);
    for l in 2..=AXIS_DEGREE {
        let lf = l as f64;
        let next = ((2.0 * lf - 1.0) * x * p - (lf - 1.0) * before) / lf;
        (before, p) = (p, next);
        if l % 2 == 0 {
            even[l / 2] = p;
        }
    }
    even
}

/// Coefficients of the mean's harmonics at places: a product of the Matérn kernels with what the rows
/// give to each harmonic.
struct NodeSums<'a> {
    points_mm: Vec<Point3<f64>>,
    amplitude: &'a Amplitude,
    lengths_mm: [f64; 2],
    /// Rows by functions of six components, one matrix a scale.
    shares: [Mat<f64>; 2],
    functions: usize,
}

impl<'a> NodeSums<'a> {
    fn new(kriging: &'a Kriging) -> Self {
        let series = &kriging.series;
        let degree = kriging.axis_degree();
        let count = functions(degree);
        let rows = &kriging.process.rows;
        let by_axis: Vec<[f64; MAX_FUNCTIONS]> = rows
            .iter()
            .map(|row| {
                let mut values = [0.0; MAX_FUNCTIONS];
                even_harmonics::values(degree, &row.point.axis, &mut values);
                values
            })
            .collect();
        // P_l(n · n') = 4π / (2l + 1) Σ Y(n) Y(n').
        let part = |scale: usize, function: usize| {
            let half = (0..DEGREES).find(|half| function < functions(2 * half)).unwrap_or(0);
            series.variances[scale] * series.parts[scale][half] * 4.0 * PI / (4 * half + 1) as f64
        };
        let shares = [0, 1].map(|scale| {
            Mat::from_fn(rows.len(), 6 * count, |i, column| {
                let (function, c) = (column / 6, column % 6);
                part(scale, function) * by_axis[i][function] * kriging.weights[i][c]
            })
        });
        Self {
            points_mm: rows.iter().map(|row| row.point.position_mm).collect(),
            amplitude: &kriging.process.amplitude,
            lengths_mm: series.lengths_mm,
            shares,
            functions: count,
        }
    }

    fn at(&self, places: &[Point3<f64>]) -> Vec<Vec<Coefficient>> {
        let mut sums = Mat::<f64>::zeros(places.len(), 6 * self.functions);
        for (length_mm, shares) in self.lengths_mm.iter().zip(&self.shares) {
            let near = Mat::from_fn(places.len(), self.points_mm.len(), |i, j| {
                matern((places[i] - self.points_mm[j]).norm() / length_mm, 0.0)
            });
            faer::linalg::matmul::matmul(
                sums.as_mut(),
                faer::Accum::Add,
                near.as_ref(),
                shares.as_ref(),
                1.0,
                // Nodes are shared among the cores already.
                faer::Par::Seq,
            );
        }
        let place = |(i, place): (usize, &Point3<f64>)| -> Vec<Coefficient> {
            let by = self.amplitude.at(place);
            (0..self.functions)
                .map(|f| std::array::from_fn(|c| sums[(i, 6 * f + c)] * by))
                .collect()
        };
        places.iter().enumerate().map(place).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_an_axis_kernel_add_to_it() {
        for sine in [0.5, 0.8, 2.0] {
            let parts = axis_parts(sine);
            assert!(parts.iter().all(|part| *part > 0.0));
            for i in 0..=20 {
                let cosine = f64::from(i) / 20.0;
                let exact = (-0.5 * (1.0 - cosine * cosine) / (sine * sine)).exp();
                let each = parts.iter().zip(even_legendre(cosine));
                let sum: f64 = each.map(|(part, p)| part * p).sum();
                // At a sine of 0.5 degrees above 6 are 1 % of the variance.
                assert!((sum - exact).abs() < 0.02, "{sine} {cosine}: {sum} {exact}");
            }
        }
    }
}
