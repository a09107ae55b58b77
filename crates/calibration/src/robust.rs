//! Robust estimation: what a residual counts for, and the scale of residuals of which some are
//! outliers.

use nalgebra::Matrix3;

/// How fast a residual stops counting. `s` is its length in standard deviations, over six
/// components (three of a position, three of a rotation).
///
/// References: Huber, *Robust Statistics*, 1981; Hampel et al., *Robust Statistics*, 1986.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Loss {
    /// Quadratic, then linear: convex, so that there is one answer.
    #[default]
    Huber,
    /// `c²/2 ln(1 + (s/c)²)`: far residuals count less and less.
    Cauchy,
    /// Tukey's biweight: beyond `c` a residual counts for nothing.
    Tukey,
}

/// Where Huber's loss becomes linear: the 90 % quantile of the length of six standard normal
/// components. The 95 % efficiency of the others would put it at 1.869, and more than half of all
/// good residuals beyond it.
const HUBER: f64 = 3.263;

/// For 95 % of the efficiency of least squares on six normal components, by numerical integration.
const CAUCHY: f64 = 2.862;
const TUKEY: f64 = 6.356;

/// Median length of three standard normal components: the root of that of χ² with three.
const MEDIAN_LENGTH_OF_3: f64 = 1.538_172_254_455_055_2;

impl Loss {
    /// ρ(s), equal to `s²/2` near zero.
    pub fn cost(self, s: f64) -> f64 {
        match self {
            Self::Huber if s <= HUBER => 0.5 * s * s,
            Self::Huber => HUBER * (s - 0.5 * HUBER),
            Self::Cauchy => 0.5 * CAUCHY * CAUCHY * (s / CAUCHY).powi(2).ln_1p(),
            Self::Tukey => {
                let inside = (1.0 - (s / TUKEY).powi(2)).max(0.0);
                TUKEY * TUKEY / 6.0 * (1.0 - inside.powi(3))
            }
        }
    }

    /// ρ'(s) / s: the weight of the residual in least squares.
    pub fn weight(self, s: f64) -> f64 {
        match self {
            Self::Huber if s <= HUBER => 1.0,
            Self::Huber => HUBER / s,
            Self::Cauchy => 1.0 / (1.0 + (s / CAUCHY).powi(2)),
            Self::Tukey => (1.0 - (s / TUKEY).powi(2)).max(0.0).powi(2),
        }
    }

    /// ρ''(s).
    pub fn curvature(self, s: f64) -> f64 {
        match self {
            Self::Huber => f64::from(u8::from(s <= HUBER)),
            Self::Cauchy => {
                let square = (s / CAUCHY).powi(2);
                (1.0 - square) / (1.0 + square).powi(2)
            }
            Self::Tukey if s < TUKEY => {
                let square = (s / TUKEY).powi(2);
                (1.0 - square) * (1.0 - 5.0 * square)
            }
            Self::Tukey => 0.0,
        }
    }
}

/// The middle value, the lower of two; `None` without values. Reorders them.
pub fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len().checked_sub(1)? / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

/// Standard deviation along the direction in which it is largest, from a covariance.
///
/// ```
/// use nalgebra::{Matrix3, Vector3};
/// let covariance = Matrix3::from_diagonal(&Vector3::new(1.0, 9.0, 4.0));
/// assert_eq!(trackwright_calibration::robust::largest_std_dev(&covariance), 3.0);
/// ```
pub fn largest_std_dev(covariance: &Matrix3<f64>) -> f64 {
    covariance.symmetric_eigenvalues().max().max(0.0).sqrt()
}

/// Standard deviation of a component of residuals of three, from their lengths: from their median,
/// which outliers hardly move. Zero without any. Reorders them.
pub fn scale_of_lengths(lengths: &mut [f64]) -> f64 {
    median(lengths).unwrap_or(0.0) / MEDIAN_LENGTH_OF_3
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Loss; 3] = [Loss::Huber, Loss::Cauchy, Loss::Tukey];

    #[test]
    fn weight_and_curvature_are_the_slopes_of_the_cost() {
        let h = 1e-5;
        for loss in ALL {
            for s in [0.1, 1.0, 2.5, 3.2, 3.3, 5.0, 6.3, 6.4, 20.0] {
                let slope = (loss.cost(s + h) - loss.cost(s - h)) / (2.0 * h);
                assert!((slope - loss.weight(s) * s).abs() < 1e-8, "{loss:?} {s}");
                let psi = |s: f64| loss.weight(s) * s;
                let slope = (psi(s + h) - psi(s - h)) / (2.0 * h);
                assert!((slope - loss.curvature(s)).abs() < 1e-6, "{loss:?} {s}");
            }
            assert_eq!((loss.cost(0.0), loss.weight(0.0)), (0.0, 1.0));
        }
    }

    #[test]
    fn a_median_resists_half_of_the_values() {
        assert_eq!(median(&mut []), None);
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [1.0, 2.0, 3.0, 1e9, f64::NAN]), Some(3.0));
    }
}
