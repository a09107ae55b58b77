//! Numbers of some 106 bits as unevaluated sums of two `f64`: the reference that `f64` is held
//! against.
//!
//! Error-free sums and products after Dekker, Numerische Mathematik 18, 1971; compound operations
//! as in Hida, Li and Bailey's QD library, 2001. Relative errors are a few 1e-32 as long as
//! nothing overflows or comes near the smallest numbers.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// `hi + lo`, with `lo` at most half an ulp of `hi`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DoubleDouble {
    hi: f64,
    lo: f64,
}

/// Splits 53 bits into two halves whose products are exact.
const SPLITTER: f64 = 134_217_729.0;

/// `a + b` and its round-off.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let bb = sum - a;
    (sum, (a - (sum - bb)) + (b - bb))
}

/// [`two_sum`] where `|a| >= |b|`.
fn quick_two_sum(a: f64, b: f64) -> DoubleDouble {
    let sum = a + b;
    DoubleDouble { hi: sum, lo: b - (sum - a) }
}

/// `a b` and its round-off.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let split = |v: f64| {
        let t = SPLITTER * v;
        let hi = t - (t - v);
        (hi, v - hi)
    };
    let product = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    (product, ((ah * bh - product) + ah * bl + al * bh) + al * bl)
}

impl DoubleDouble {
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };
    pub const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    /// The nearest `f64`.
    pub fn to_f64(self) -> f64 {
        self.hi + self.lo
    }

    pub fn is_negative(self) -> bool {
        self.hi < 0.0
    }

    pub fn abs(self) -> Self {
        if self.is_negative() { -self } else { self }
    }

    /// Sine and cosine of an angle in radians, `|angle| <= 2π`.
    ///
    /// By Taylor's series at a 32nd of the angle, which is exact, and five doublings.
    fn sin_cos(angle: f64) -> (Self, Self) {
        const DOUBLINGS: i32 = 5;
        const TERMS: i32 = 15;
        let small = Self::from(angle * 0.5_f64.powi(DOUBLINGS));
        let square = small * small;
        let (mut sin, mut cos) = (Self::ZERO, Self::ZERO);
        let (mut sin_term, mut cos_term) = (small, Self::ONE);
        for k in 0..TERMS {
            sin += sin_term;
            cos += cos_term;
            let n = f64::from(2 * k);
            cos_term = -(cos_term * square) / Self::from((n + 1.0) * (n + 2.0));
            sin_term = -(sin_term * square) / Self::from((n + 2.0) * (n + 3.0));
        }
        for _ in 0..DOUBLINGS {
            (sin, cos) = (Self::from(2.0) * sin * cos, cos * cos - sin * sin);
        }
        (sin, cos)
    }

    /// The angle of the vector `(x, y)` in radians, from -π to π.
    ///
    /// The `f64` angle, put right by the angle that is left when the vector is turned back by it;
    /// that is 1e-16, so its tangent stands for it to 1e-48.
    pub fn atan2(y: Self, x: Self) -> Self {
        let near = y.hi.atan2(x.hi);
        let (sin, cos) = Self::sin_cos(near);
        Self::from(near) + (y * cos - x * sin) / (x * cos + y * sin)
    }
}

impl From<f64> for DoubleDouble {
    fn from(value: f64) -> Self {
        Self { hi: value, lo: 0.0 }
    }
}

impl Neg for DoubleDouble {
    type Output = Self;

    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (s1, s2) = two_sum(self.hi, other.hi);
        let (t1, t2) = two_sum(self.lo, other.lo);
        let first = quick_two_sum(s1, s2 + t1);
        quick_two_sum(first.hi, first.lo + t2)
    }
}

impl AddAssign for DoubleDouble {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (p1, p2) = two_product(self.hi, other.hi);
        quick_two_sum(p1, p2 + (self.hi * other.lo + self.lo * other.hi))
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    /// Long division by three quotients.
    fn div(self, other: Self) -> Self {
        let q1 = self.hi / other.hi;
        let rest = self - other * Self::from(q1);
        let q2 = rest.hi / other.hi;
        let rest = rest - other * Self::from(q2);
        let q3 = rest.hi / other.hi;
        quick_two_sum(q1, q2) + Self::from(q3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dd(value: f64) -> DoubleDouble {
        DoubleDouble::from(value)
    }

    #[test]
    fn what_f64_loses_is_kept() {
        let tiny = 1e-25;
        assert_eq!((dd(1.0) + dd(tiny) - dd(1.0)).to_f64(), tiny);
        let third = dd(1.0) / dd(3.0);
        assert!((third * dd(3.0) - dd(1.0)).abs().to_f64() < 1e-31);
        // 1/3 - f64(1/3) = 1/(3 · 2^54), exactly.
        assert_eq!((third - dd(1.0 / 3.0)).to_f64(), 1.0 / 3.0 * 2.0_f64.powi(-54));
    }

    #[test]
    fn sine_and_cosine_lie_on_the_circle_at_the_nearest_f64() {
        for angle in [-3.1, -1.0, 0.0, 1e-9, 0.5, 2.0, std::f64::consts::PI] {
            let (sin, cos) = DoubleDouble::sin_cos(angle);
            assert!((sin * sin + cos * cos - dd(1.0)).abs().to_f64() < 1e-30);
            assert!((sin.to_f64() - angle.sin()).abs() < 2e-16);
            assert!((cos.to_f64() - angle.cos()).abs() < 2e-16);
        }
    }

    #[test]
    fn machins_formula_gives_pi_to_thirty_digits() {
        let part = |n: f64| DoubleDouble::atan2(dd(1.0), dd(n));
        let pi = dd(16.0) * part(5.0) - dd(4.0) * part(239.0);
        // The first two f64 of π, as fdlibm has them.
        let expected = dd(std::f64::consts::PI) + dd(1.224_646_799_147_353_2e-16);
        assert!((pi - expected).abs().to_f64() < 1e-30);
    }
}
