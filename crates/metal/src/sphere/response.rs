//! How a sphere responds to each order of the field around it, at any frequency.
//!
//! In the incident potential `Σ c_n r^n Y_n` a sphere of radius `a` adds `Σ g_n c_n a^{2n+1} Y_n /
//! r^{n+1}`. With the field inside a spherical Bessel function `j_n(x r/a)`, `x = (1 + i) a/δ`, the
//! normal flux density and the tangential field are continuous where
//!
//! `g_n = n (v_n − (n + 1) μ) / ((n + 1) (v_n + n μ))`, `v_n = (x j_n(x))' / j_n(x)`
//!
//! (Smythe, Static and Dynamic Electricity, 1968, section 10.06, for n = 1). That is `n/(n + 1)` where
//! no flux enters, `−n (μ − 1)/(n μ + n + 1)` at rest, and for n = 1 minus the factor of
//! [`sphere_factor`].

use crate::material::{Material, MaterialError, check_frequency};
use nalgebra::Complex;
use trackwright_geometry::limits::{length_above_zero_problem, short};

/// Highest order of a series. A source and a point both 0.1 % of the radius off the sphere need it.
pub const MAX_ORDER: usize = 20_000;

/// Largest `|x|`, which the orders that are computed have to exceed. 0.5 m of steel 416 at 1 MHz
/// has 5·10⁴.
const MAX_ARGUMENT: f64 = 1e6;

/// From this `|x|` on the first order is computed from the cotangent, which has no digits to lose
/// there: `1 − x cot x` is about `i x`.
const LARGE_ARGUMENT: f64 = 20.0;

/// Orders beyond `|x|` and beyond the last one wanted, at which the downward recurrence may begin with
/// any value: each order above `|x|` shrinks the error of the start at least by a third at first, more
/// later.
const EXTRA_ORDERS: usize = 60;

/// Why there is no such sphere.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SphereError {
    #[error("radius is {found} mm, expected {expected}")]
    Radius { found: String, expected: &'static str },
    #[error(transparent)]
    Material(#[from] MaterialError),
    #[error(
        "the radius is {radius_over_skin_depth:.3e} skin depths, expected at most 7e5: take a perfect conductor"
    )]
    ThinSkin { radius_over_skin_depth: f64 },
}

/// Induced dipole of a sphere in a uniform field, over `a³ B`: complex, as phase lags.
///
/// `f = (2μ − u) / (2 (μ + u))`, `u = x² / (1 − x cot x) − 1`, `x = (1 + i) a/δ`. At rest it is
/// `(μ − 1)/(μ + 2)`, fast `−1/2`; the imaginary part is never negative.
///
/// With `h = x j₂(x)/j₁(x)`, which is `2 − u`, it is `(2 (μ − 1) + h) / (2 (μ + 2 − h))`: nothing
/// cancels for small `x`, where `f` of a metal that is not magnetic is `h/6`. `h` is the continued
/// fraction `x²/(5 − x²/(7 − …))`, in which real and imaginary part keep all digits each; for large
/// `|x|` it follows from `cot x = −i (1 + q)/(1 − q)`, `q = e^{2ix}`, which underflows instead of
/// overflowing.
///
/// # Errors
/// A radius, frequency or skin depth that cannot be; see [`SphereError`].
///
/// ```
/// use trackwright_metal::material::Material;
/// use trackwright_metal::sphere::sphere_factor;
///
/// let ball_bearing = Material::named("steel-304").unwrap();
/// let factor = sphere_factor(20.0, &ball_bearing, 10e3)?;
/// assert!(-0.5 < factor.re && factor.re < -0.3 && factor.im > 0.0);
/// # Ok::<(), trackwright_metal::sphere::SphereError>(())
/// ```
pub fn sphere_factor(
    radius_mm: f64,
    material: &Material,
    frequency_hz: f64,
) -> Result<Complex<f64>, SphereError> {
    let squared = argument_squared(radius_mm, material, frequency_hz)?;
    let h = if squared.sqrt() < LARGE_ARGUMENT {
        ratio_terms(squared, 1)[0]
    } else {
        first_ratio_term_of_large(squared)
    };
    Ok(-response_of_order(1, material.relative_permeability(), h))
}

/// `g_n` of a sphere about the origin, order by order.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereResponse {
    radius_mm: f64,
    ratios: Ratios,
}

#[derive(Clone, Debug, PartialEq)]
enum Ratios {
    PerfectConductor,
    /// At rest.
    Permeable(f64),
    /// With currents and finite skin depth: orders 1 to [`MAX_ORDER`], of fields that go as `e^(iωt)`.
    Currents(Vec<Complex<f64>>),
}

impl SphereResponse {
    /// A sphere that no flux enters: a conductor at a frequency whose skin depth is small.
    ///
    /// # Errors
    /// [`SphereError::Radius`].
    pub fn perfect_conductor(radius_mm: f64) -> Result<Self, SphereError> {
        check_radius(radius_mm)?;
        Ok(Self { radius_mm, ratios: Ratios::PerfectConductor })
    }

    /// A sphere of a material at a frequency, in phase with the source: the real part, which is what
    /// a tracker that demodulates in phase measures.
    ///
    /// # Errors
    /// A radius, frequency or skin depth that cannot be; see [`SphereError`].
    pub fn new(
        radius_mm: f64,
        material: &Material,
        frequency_hz: f64,
    ) -> Result<Self, SphereError> {
        let squared = argument_squared(radius_mm, material, frequency_hz)?;
        let permeability = material.relative_permeability();
        let ratios = if squared == 0.0 {
            Ratios::Permeable(permeability)
        } else {
            let terms = ratio_terms(squared, MAX_ORDER);
            // The terms are of fields that go as `e^(−iωt)`.
            let of_order =
                |(index, h): (usize, &_)| response_of_order(index + 1, permeability, *h).conj();
            Ratios::Currents(terms.iter().enumerate().map(of_order).collect())
        };
        Ok(Self { radius_mm, ratios })
    }

    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// `g_n`, in phase; between −1 and 1. 0 for order 0 and above [`MAX_ORDER`].
    pub fn ratio(&self, order: usize) -> f64 {
        self.complex_ratio(order).re
    }

    /// `g_n` of fields that go as `e^(iωt)`: the imaginary part is above 0, as currents lag and lose energy.
    pub fn complex_ratio(&self, order: usize) -> Complex<f64> {
        let n = order as f64;
        match &self.ratios {
            _ if order == 0 || order > MAX_ORDER => 0.0.into(),
            Ratios::PerfectConductor => (n / (n + 1.0)).into(),
            Ratios::Permeable(mu) => (-n * (mu - 1.0) / (n * mu + n + 1.0)).into(),
            Ratios::Currents(ratios) => ratios[order - 1],
        }
    }
}

fn check_radius(radius_mm: f64) -> Result<(), SphereError> {
    match length_above_zero_problem(radius_mm) {
        None => Ok(()),
        Some(expected) => Err(SphereError::Radius { found: short(radius_mm), expected }),
    }
}

/// `|x²| = 2 (a/δ)²`; `x²` is that on the imaginary axis.
fn argument_squared(
    radius_mm: f64,
    material: &Material,
    frequency_hz: f64,
) -> Result<f64, SphereError> {
    check_radius(radius_mm)?;
    check_frequency(frequency_hz)?;
    let per_mm2 = material.inverse_squared_skin_depth_per_mm2(frequency_hz);
    let squared = 2.0 * per_mm2 * radius_mm * radius_mm;
    if squared.sqrt() > MAX_ARGUMENT {
        return Err(SphereError::ThinSkin { radius_over_skin_depth: (0.5 * squared).sqrt() });
    }
    Ok(squared)
}

/// `h_n = x j_{n+1}(x) / j_n(x) = n + 1 − v_n` of orders 1 to `orders`, by `h_n = x²/(2n + 3 − h_{n+1})`
/// downward (Miller's algorithm: what is lost going up is gained going down).
fn ratio_terms(squared: f64, orders: usize) -> Vec<Complex<f64>> {
    let first = orders.max(squared.sqrt() as usize) + EXTRA_ORDERS;
    let mut terms = vec![Complex::new(0.0, 0.0); orders];
    let mut h = Complex::new(0.0, 0.0);
    for n in (1..=first).rev() {
        let below = Complex::new((2 * n + 3) as f64 - h.re, -h.im);
        // i s / (p + i q) = s (q + i p) / (p² + q²): no sum in either part.
        let scale = squared / below.norm_sqr();
        h = Complex::new(below.im * scale, below.re * scale);
        if n <= orders {
            terms[n - 1] = h;
        }
    }
    terms
}

/// `h_1 = 2 − u` from the cotangent.
fn first_ratio_term_of_large(squared: f64) -> Complex<f64> {
    let part = (0.5 * squared).sqrt();
    let x = Complex::new(part, part);
    let q = Complex::from_polar((-2.0 * part).exp(), 2.0 * part);
    let i = Complex::new(0.0, 1.0);
    let one_less_x_cot_x = i * x * ((q + 1.0) / (-q + 1.0)) + 1.0;
    Complex::new(3.0, -0.0) - Complex::new(0.0, squared) / one_less_x_cot_x
}

/// `g_n` from `h_n`, its imaginary part without a difference.
fn response_of_order(order: usize, mu: f64, h: Complex<f64>) -> Complex<f64> {
    let n = order as f64;
    let above = (n + 1.0) * (mu - 1.0) + h.re;
    let below = n + 1.0 + n * mu - h.re;
    let scale = -n / ((n + 1.0) * (below * below + h.im * h.im));
    Complex::new(above * below - h.im * h.im, h.im * (2.0 * n + 1.0) * mu) * scale
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::physics;

    /// The last case's real part, 2·10⁻⁶ of the imaginary one, has lost six digits in the worked file:
    /// it is 2·10⁻¹⁷ off, as `2 − u` by a difference is. This is the one of 60 digits.
    const REAL_OF_1_MM: f64 = -6.657_710_369_146_771_5e-12;

    #[test]
    fn factors_are_the_worked_ones() {
        let golden = physics();
        let cases = golden["sphere_factors"].as_array().unwrap();
        assert_eq!(cases.len(), 10);
        for case in cases {
            let number = |key: &str| case[key].as_f64().unwrap();
            let material =
                Material::new(number("conductivity_S_m"), number("relative_permeability")).unwrap();
            let found = sphere_factor(number("radius_mm"), &material, number("frequency_hz"));
            let found = found.unwrap();
            let worked = Complex::new(number("re"), number("im"));
            assert!((found - worked).norm() <= 1e-9 * worked.norm(), "{case} {found}");
            let re = if number("radius_mm") == 1.0 { REAL_OF_1_MM } else { worked.re };
            for (found, worked) in [(found.re, re), (found.im, worked.im)] {
                assert!((found - worked).abs() <= 1e-9 * worked.abs(), "{case} {found}");
            }
        }
    }

    /// `f` of a metal that is not magnetic is `j₂(x)/j₀(x) / 2 = w/30 + w²/315 + …`, `w = x²`.
    #[test]
    fn small_spheres_follow_their_series() {
        let copper = Material::named("copper").unwrap();
        for (radius_mm, frequency_hz) in [(0.1, 1.0), (0.01, 10.0), (0.5, 20.0)] {
            let per_mm2 = copper.inverse_squared_skin_depth_per_mm2(frequency_hz);
            let t = 2.0 * radius_mm * radius_mm * per_mm2;
            let found = sphere_factor(radius_mm, &copper, frequency_hz).unwrap();
            // w = i t; what follows is t² of each part.
            assert!((found.im / (t / 30.0) - 1.0).abs() < t * t);
            assert!((found.re / (-t * t / 315.0) - 1.0).abs() < t * t);
        }
    }

    #[test]
    fn both_ways_to_the_first_order_agree() {
        for size in [5.0, 12.0, 20.0, 40.0, 300.0, 9000.0] {
            let squared: f64 = size * size;
            let (small, large) = (ratio_terms(squared, 1)[0], first_ratio_term_of_large(squared));
            // The fraction sums |x| terms, each with a rounding of its own that later ones forget.
            assert!((small - large).norm() < 1e-13 * large.norm(), "{size}: {small} {large}");
        }
    }

    #[test]
    fn responses_go_from_rest_to_no_flux() {
        let ideal = SphereResponse::perfect_conductor(500.0).unwrap();
        for mu in [1.0, 1.008, 100.0] {
            let material = Material::new(1e9, mu).unwrap();
            let fast = SphereResponse::new(500.0, &material, 1e6).unwrap();
            let slow = SphereResponse::new(1.0, &material, 1e-9).unwrap();
            let rest = SphereResponse::new(10.0, &Material::new(0.0, mu).unwrap(), 1e4).unwrap();
            for order in [1, 2, 5, 20] {
                assert!((slow.ratio(order) - rest.ratio(order)).abs() < 1e-12);
                // `v_n` is −i x where the skin is thin; what is left is of second order in the skin.
                let skin = (2 * order + 1) as f64 * mu * material.skin_depth_mm(1e6) / 1e3;
                let lack = 1.0 - fast.ratio(order) / ideal.ratio(order);
                assert!((lack / skin - 1.0).abs() < 10.0 * skin + 1e-3, "{mu} {order} {lack:e}");
            }
            assert_eq!(rest.ratio(1), -(mu - 1.0) / (mu + 2.0));
        }
    }

    #[test]
    fn factors_are_passive_over_all_sizes() {
        for radius_mm in [0.1, 1.0, 20.0, 500.0] {
            for decade in 0..=6 {
                for key in ["copper", "titanium", "steel-416", "ferrite"] {
                    let frequency_hz = 10.0_f64.powi(decade);
                    let material = Material::named(key).unwrap();
                    let factor = sphere_factor(radius_mm, &material, frequency_hz).unwrap();
                    // A passive sphere takes energy in, and is between its two limits.
                    assert!(factor.im > 0.0, "{key} {radius_mm} {frequency_hz} {factor}");
                    assert!((-0.5..1.0).contains(&factor.re), "{key} {factor}");
                    let response = SphereResponse::new(radius_mm, &material, frequency_hz).unwrap();
                    assert!((response.ratio(1) + factor.re).abs() < 1e-13);
                    for order in [1, 7, 100, MAX_ORDER] {
                        assert!(response.ratio(order).abs() <= 1.0);
                    }
                }
            }
        }
    }

    #[test]
    fn spheres_that_cannot_be_are_refused() {
        let copper = Material::named("copper").unwrap();
        for (radius_mm, frequency_hz, message) in [
            (0.0, 1e3, "radius is 0 mm, expected a length above zero"),
            (f64::NAN, 1e3, "radius is NaN mm, expected a length above zero"),
            (10.0, f64::NAN, "frequency is NaN Hz, expected 0 to 1e7"),
            (10.0, -5.0, "frequency is -5 Hz, expected 0 to 1e7"),
            (
                1e6,
                1e7,
                "the radius is 4.785e7 skin depths, expected at most 7e5: take a perfect conductor",
            ),
        ] {
            let error = sphere_factor(radius_mm, &copper, frequency_hz).unwrap_err();
            assert_eq!(error.to_string(), message);
        }
        assert!(SphereResponse::perfect_conductor(-1.0).is_err());
    }
}
