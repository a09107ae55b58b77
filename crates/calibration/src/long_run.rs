//! Covariance of a sum of readings that are not independent of their neighbours.
//!
//! An estimate by least squares is off by `H⁻¹ Σ gᵢ`, with `gᵢ` what a reading's error adds to the
//! gradient (its score) and `H` the curvature. For independent errors the covariance of the sum is
//! that of the scores by themselves. Readings of a recording are not independent: a hand moves slowly
//! through a smooth field, and trackers filter. Then the covariance of the sum is `n` times the
//! scores' spectrum at frequency zero.
//!
//! Here the spectrum is the mean over the lowest `B` cosines (Müller, *Econometrica* 75, 2007; with
//! the number of cosines of Lazarus, Lewis, Stock & Watson, *J. Business & Economic Statistics* 36,
//! 2018), so that an estimate over its standard error is Student's with `B` degrees of freedom
//! whatever the dependence. No more cosines are taken than a third of the independent readings that
//! [`Dependence`] finds: beyond them an autocorrelated series has less power than at zero.

use super::dependence::Dependence;
use nalgebra::{DMatrix, SymmetricEigen};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// `B = 0.4 n^(2/3)` minimises the loss that Lazarus et al. derive for tests of 5 %.
const COSINES: f64 = 0.4;

/// Cosines, at least: Student's quantile is then 2.8, with fewer it grows fast.
const MIN_COSINES: f64 = 4.0;

/// Cosines, at most: Student's quantile is then within 1 % of the normal one.
const MAX_COSINES: f64 = 200.0;

/// Independent readings a cosine. Of an AR(1) series the mean power up to there is 8 % below that at
/// zero (2: 15 %, and 95 % intervals held for 92 %); with 4, drifts as fast as a pivoted tool's swing
/// are left out (intervals held for 93 %).
const READINGS_A_COSINE: f64 = 3.0;

/// Sums of neighbours that are looked at, of longer series.
const MOST_UNITS: usize = 20_000;

/// Variance, relative to the largest, at or below which a direction has none.
const NOTHING: f64 = 1e-12;

/// The covariance of a sum, and what it was found from.
#[derive(Clone, Debug, PartialEq)]
pub struct LongRun {
    /// Of the sum; its mean variance is never below that of independent readings.
    pub covariance: DMatrix<f64>,
    pub effective_size: EffectiveSize,
}

/// The effective size of a series whose values are not independent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectiveSize {
    /// How many independent readings, at most as many as there are.
    pub effective: f64,
    /// Degrees of freedom; `None` where the series is too short, and its covariance a lower bound.
    pub freedom: Option<usize>,
}

impl EffectiveSize {
    /// Half the 95 % interval over the standard error: Student's quantile.
    pub fn student_975(&self) -> Option<f64> {
        let student = StudentsT::new(0.0, 1.0, self.freedom? as f64).ok()?;
        Some(student.inverse_cdf(0.975))
    }
}

/// Of scores in the order in which they were recorded, a column a reading; `independent` is what the
/// covariance of their sum would be for independent readings, symmetric.
pub fn long_run(scores: &DMatrix<f64>, independent: &DMatrix<f64>) -> LongRun {
    long_run_along(scores, independent, independent)
}

/// The same along the axes, and in the units, of another symmetric matrix: for an `independent` that
/// was found from the scores themselves, which along axes of its own hides their dependence.
pub fn long_run_along(
    scores: &DMatrix<f64>,
    independent: &DMatrix<f64>,
    metric: &DMatrix<f64>,
) -> LongRun {
    let count = scores.ncols();
    let as_independent = || LongRun {
        covariance: independent.clone(),
        effective_size: EffectiveSize { effective: count as f64, freedom: None },
    };
    let Some(axes) = Axes::of(metric) else {
        return as_independent();
    };
    // In these units independent readings have some variance of one, and `n` of them `n`.
    let n = count as f64;
    let white = &axes.whitened * scores * n.sqrt();
    let each = count.div_ceil(MOST_UNITS).max(1);
    let units = sums(&white, each);
    let [of_one, of_unit] = [&white, &units].map(|series| series.norm_squared() / n);
    if !(of_one > 0.0 && of_one.is_finite()) {
        return as_independent();
    }
    let inflation = Dependence::of_columns(&units).inflation * (of_unit / of_one).max(1.0);
    let Some(cosines) = cosines(units.ncols(), n / inflation) else {
        return LongRun {
            covariance: independent * inflation,
            effective_size: EffectiveSize { effective: n / inflation, freedom: None },
        };
    };
    let target = &axes.whitened * independent * axes.whitened.transpose();
    let found = spectrum(&units, cosines, n, &target);
    let at_least = (target.trace() / found.trace()).max(1.0);
    LongRun {
        effective_size: EffectiveSize {
            effective: n / (found.trace() / of_one).max(1.0),
            freedom: Some(cosines),
        },
        covariance: axes.unwhitened(&(found * at_least)),
    }
}

/// How many cosines a series bears; `None` where it bears too few.
fn cosines(units: usize, effective: f64) -> Option<usize> {
    let wanted = (COSINES * (units as f64).powf(2.0 / 3.0)).clamp(MIN_COSINES, MAX_COSINES);
    let borne = (effective / READINGS_A_COSINE).min(wanted).floor();
    (borne >= MIN_COSINES).then_some(borne as usize)
}

/// The axes along which a covariance, scaled to a unit diagonal, is diagonal.
struct Axes {
    whitened: DMatrix<f64>,
    back: DMatrix<f64>,
}

impl Axes {
    /// `None` where nothing has any variance, or something is not finite.
    fn of(covariance: &DMatrix<f64>) -> Option<Self> {
        if covariance.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let roots = covariance.diagonal().map(|v| v.max(0.0).sqrt());
        let divided = DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
            match roots[i] * roots[j] {
                0.0 => 0.0,
                both => covariance[(i, j)] / both,
            }
        });
        let eigen = SymmetricEigen::new(divided);
        let largest = eigen.eigenvalues.max();
        let kept: Vec<usize> = (0..roots.len())
            .filter(|&k| eigen.eigenvalues[k] > NOTHING * largest.max(0.0))
            .collect();
        if kept.is_empty() {
            return None;
        }
        let axis = |k: usize, i: usize| eigen.eigenvectors[(i, kept[k])];
        let root = |k: usize| eigen.eigenvalues[kept[k]].sqrt();
        let size = (kept.len(), roots.len());
        Some(Self {
            whitened: DMatrix::from_fn(size.0, size.1, |k, i| match roots[i] {
                0.0 => 0.0,
                scale => axis(k, i) / root(k) / scale,
            }),
            back: DMatrix::from_fn(size.1, size.0, |i, k| axis(k, i) * root(k) * roots[i]),
        })
    }

    fn unwhitened(&self, covariance: &DMatrix<f64>) -> DMatrix<f64> {
        &self.back * covariance * self.back.transpose()
    }
}

/// Of so many neighbours each.
fn sums(series: &DMatrix<f64>, each: usize) -> DMatrix<f64> {
    let count = series.ncols().div_ceil(each);
    let parts = (0..count).map(|k| {
        let first = k * each;
        let columns = series.columns(first, each.min(series.ncols() - first));
        columns.column_sum()
    });
    DMatrix::from_columns(&parts.collect::<Vec<_>>())
}

/// Mean outer product of the lowest cosines' coefficients, over `n`, shrunk towards a multiple of the
/// target by what chance alone makes of that (Ledoit & Wolf, *J. Multivariate Analysis* 88, 2004).
fn spectrum(units: &DMatrix<f64>, cosines: usize, n: f64, target: &DMatrix<f64>) -> DMatrix<f64> {
    let (rows, count) = units.shape();
    let mut coefficients = DMatrix::zeros(rows, cosines);
    for (k, unit) in units.column_iter().enumerate() {
        let step = (std::f64::consts::PI * (k as f64 + 0.5) / count as f64).cos();
        // cos (j + 1)θ = 2 cos θ cos jθ − cos (j − 1)θ, stable for some hundred steps.
        let (mut before, mut now) = (1.0, step);
        for mut coefficient in coefficients.column_iter_mut() {
            coefficient.axpy(now, &unit, 1.0);
            (before, now) = (now, 2.0 * step * now - before);
        }
    }
    let freedom = cosines as f64;
    let found = &coefficients * coefficients.transpose() * (2.0 / (n * freedom));
    let trace = found.trace();
    let even = target * (trace / target.trace());
    let uneven = (&found - &even).norm_squared();
    // Of a Wishart matrix with that expectation, its trace being that of the target.
    let squares = even.norm_squared();
    let by_chance = (squares + trace * trace - 2.0 * squares / rows as f64) / freedom;
    let part = match uneven > 0.0 {
        true => (by_chance / uneven).min(1.0),
        false => 1.0,
    };
    found * (1.0 - part) + even * part
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;
    use trackwright_field::random_models::Seeded;

    /// Half widths over errors of sums of `count` readings with an autocorrelation, whose variances
    /// are one, four and nine: the part of the errors within, and mean variance over the true one.
    fn coverage(count: usize, autocorrelation: f64, runs: usize) -> (f64, f64) {
        let mut noise = Seeded::new(21);
        let true_variance = count as f64 * (1.0 + autocorrelation) / (1.0 - autocorrelation);
        let independent = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 4.0, 9.0]));
        let independent = independent * count as f64;
        let (mut within, mut variance) = (0.0, 0.0);
        for _ in 0..runs {
            let series = noise.autocorrelated(count, autocorrelation);
            let scale = |row: usize| (row + 1) as f64;
            let scores = DMatrix::from_fn(3, count, |row, k| series[k][row] * scale(row));
            let sum = scores.column_sum();
            // What a fit leaves of it.
            let mut left = scores.clone();
            for mut column in left.column_iter_mut() {
                column -= &sum / count as f64;
            }
            let found = long_run(&left, &independent);
            let student = found.effective_size.student_975().unwrap();
            for k in 0..3 {
                let std_error = found.covariance[(k, k)].sqrt();
                within += f64::from(u8::from(sum[k].abs() < student * std_error));
                variance += found.covariance[(k, k)] / scale(k).powi(2) / true_variance;
            }
        }
        let all = 3.0 * runs as f64;
        (within / all, variance / all)
    }

    #[test]
    fn intervals_cover_95_percent_of_autocorrelated_sums() {
        for autocorrelation in [0.0, 0.5, 0.9] {
            let (within, variance) = coverage(1000, autocorrelation, 400);
            // A part of 1,200 of 0.95 has a standard deviation of 0.0063; four of them. With 0.9 the
            // spectrum up to 17 cosines is some 8 % below that at zero.
            assert!((within - 0.95).abs() < 0.025, "{autocorrelation}: {within}");
            assert!((0.85..1.1).contains(&variance), "{autocorrelation}: {variance}");
        }
    }

    #[test]
    fn few_independent_readings_have_no_interval() {
        let mut noise = Seeded::new(3);
        let series = noise.autocorrelated(60, 0.9995);
        let slow = DMatrix::from_fn(1, 60, |_, k| series[k][0]);
        let independent = DMatrix::from_element(1, 1, slow.norm_squared());
        let found = long_run(&slow, &independent);
        assert_eq!(found.effective_size.student_975(), None);
        assert!(found.effective_size.effective < 8.0, "{:?}", found.effective_size);
        assert!(found.covariance[(0, 0)] > 5.0 * independent[(0, 0)]);
        // Neither have eleven, whatever they are.
        let white = noise.autocorrelated(11, 0.0);
        let white = DMatrix::from_fn(1, 11, |_, k| white[k][0]);
        let found = long_run(&white, &DMatrix::from_element(1, 1, 11.0));
        assert_eq!(found.effective_size.freedom, None);
    }

    #[test]
    fn directions_without_variance_and_bad_numbers_stay() {
        let scores =
            DMatrix::from_fn(2, 100, |row, k| if row == 0 { (k as f64).sin() } else { 0.0 });
        let mut independent = DMatrix::zeros(2, 2);
        independent[(0, 0)] = 50.0;
        let found = long_run(&scores, &independent).covariance;
        assert!(found[(0, 0)] >= 50.0 && found[(1, 1)] == 0.0 && found[(0, 1)] == 0.0);
        let zeros = DMatrix::zeros(2, 2);
        assert_eq!(long_run(&scores, &zeros).covariance, zeros);
        let nan = DMatrix::from_element(2, 2, f64::NAN);
        assert!(long_run(&scores, &nan).covariance.iter().all(|v| v.is_nan()));
    }

    #[test]
    fn units_and_order_of_time_do_not_matter() {
        let mut noise = Seeded::new(8);
        let series = noise.autocorrelated(300, 0.7);
        let scores = DMatrix::from_fn(3, 300, |row, k| series[k][row]);
        let independent = DMatrix::identity(3, 3) * 300.0;
        let found = long_run(&scores, &independent);
        let scale = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 1e-4, 1e3]));
        let scaled = long_run(&(&scale * &scores), &(&scale * &independent * &scale));
        let expected = &scale * &found.covariance * &scale;
        let off = (&scaled.covariance - &expected).component_div(&expected).amax();
        assert!(off < 1e-9, "{off}");
        let reversed = DMatrix::from_fn(3, 300, |row, k| scores[(row, 299 - k)]);
        let off = (long_run(&reversed, &independent).covariance - &found.covariance).amax();
        assert!(off < 1e-9 * found.covariance.amax(), "{off}");
    }
}
