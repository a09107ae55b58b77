//! Whether the first order holds: the scatter of the real frame fits by a rule that is exact for
//! polynomials of fifth degree, without random numbers.
//!
//! McNamee & Stenger's rule for the normal distribution (Numer. Math. 10, 1967): the centre, `±√3`
//! along each of `n` axes and `(±√3, ±√3)` along each pair, with weights `1 + (n² − 7n)/18`,
//! `(4 − n)/18` and `1/36`. The mean square of a tip error is right up to the fourth power of the
//! jitter, which is where the first order begins to fail.
//!
//! The rule is used at the jitter and at half of it. What it finds falls with the square of the
//! jitter, by four from one to the other, as long as it can be trusted; far beyond, it may cross
//! zero by chance at one of them, not at both.

use super::error::UncertaintyError;
use super::first_order::TipUncertainty;
use super::still::{Refit, Refitted, Still};
use crate::scenario::Scenario;
use crate::work::Work;
use nalgebra::Vector3;
use serde::Serialize;

/// Difference, as a part, up to which the first order counts as holding.
pub const TOLERANCE: f64 = 0.02;

/// Most numbers in one reading of all sensors; the rule takes twice its square of fits.
const MAX_DIMENSIONS: usize = 100;

/// What the first order's scatter is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FirstOrderCheck {
    /// RMS distance of the tip from where it is without jitter, right to the next order.
    pub next_order_rms_mm: f64,
    /// Its difference from the first order, as a part of itself; at the jitter, or four times that
    /// at half the jitter where it is larger.
    pub relative_difference: f64,
    /// Whether that is within 2 %.
    pub holds: bool,
    #[serde(skip)]
    pub work: Work,
}

/// Compares the first order's scatter with that of the real frame fits; `None` where there are too
/// many sensors to do it at once (more than 100 numbers a reading).
///
/// # Errors
/// See [`UncertaintyError`].
pub fn check_first_order(
    scenario: &Scenario,
    first_order: &TipUncertainty,
) -> Result<Option<FirstOrderCheck>, UncertaintyError> {
    let refit = Still::new(scenario)?.refit();
    let n = refit.dimensions();
    if n > MAX_DIMENSIONS {
        return Ok(None);
    }
    let (next_order_rms_mm, fits) = fifth_degree_rms(&refit, n, 1.0);
    let (half_rms_mm, half_fits) = fifth_degree_rms(&refit, n, 0.5);
    let relative_difference = part_of(first_order.rms_mm, next_order_rms_mm)
        .max(4.0 * part_of(0.5 * first_order.rms_mm, half_rms_mm));
    Ok(Some(FirstOrderCheck {
        next_order_rms_mm,
        relative_difference,
        holds: relative_difference <= TOLERANCE,
        work: Work { frame_fits: fits + half_fits, ..Work::default() },
    }))
}

/// How far two figures differ, as a part of the second.
fn part_of(figure: f64, reference: f64) -> f64 {
    let difference = (figure - reference).abs();
    if difference == 0.0 { 0.0 } else { difference / reference }
}

/// RMS distance of the tip from where it is without jitter, at `scale` times the jitter, and the
/// fits that it took.
fn fifth_degree_rms(refit: &Refit, n: usize, scale: f64) -> (f64, u64) {
    let base = refit.without_noise();
    let mut readings = Vec::new();
    let mut fits = refit.fits();
    let mut square = |moved: &[(usize, f64)]| {
        let mut next = 0;
        let normal = || {
            let value = moved.iter().find(|m| m.0 == next).map_or(0.0, |m| m.1);
            next += 1;
            value
        };
        fits += refit.fits();
        shift(&refit.with_noise(normal, &mut readings), &base).norm_squared()
    };
    let r = scale * 3.0_f64.sqrt();
    let (mut axes, mut pairs) = (0.0, 0.0);
    for i in 0..n {
        axes += square(&[(i, r)]) + square(&[(i, -r)]);
        for j in 0..i {
            for (a, b) in [(r, r), (r, -r), (-r, r), (-r, -r)] {
                pairs += square(&[(i, a), (j, b)]);
            }
        }
    }
    // The centre's own square is zero, whatever its weight. Others are negative: far beyond the
    // rule's reach, a mean square can be too.
    let mean_square = axes * (4.0 - n as f64) / 18.0 + pairs / 36.0;
    (mean_square.max(0.0).sqrt(), fits)
}

fn shift(refitted: &Refitted, base: &Refitted) -> Vector3<f64> {
    refitted.tip_error_mm - base.tip_error_mm
}
