//! Numbers of 192 bits, for references only: what the program computes in 53 bits is compared with
//! the same formula in these.

use astro_float_num::{BigFloat, Consts, RoundingMode, Sign};
pub use rand_distr::num_traits::{One, Zero};
use std::borrow::Cow;
use std::cell::RefCell;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// Bits of a number: three machine words. A reference may lose 90 of them to cancellation and
/// still be more than 100 bits good.
pub const BITS: usize = 192;

const ROUNDING: RoundingMode = RoundingMode::ToEven;

thread_local! {
    /// π and its like, computed once a thread; `None` only where there is no memory for them.
    static CONSTANTS: RefCell<Option<Consts>> = RefCell::new(Consts::new().ok());
}

/// A number of [`BITS`] bits. Not-a-number and infinities behave as those of `f64`. The vectors and
/// matrices of `nalgebra` hold it.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
pub struct High(BigFloat);

impl High {
    /// π.
    pub fn pi() -> Self {
        with_constants(|c| c.pi(BITS, ROUNDING))
    }

    /// The nearest `f64`; numbers too small for one become zero.
    pub fn to_f64(&self) -> f64 {
        if self.0.is_nan() {
            return f64::NAN;
        }
        if self.0.is_inf_pos() {
            return f64::INFINITY;
        }
        if self.0.is_inf_neg() {
            return f64::NEG_INFINITY;
        }
        let Some((words, _, sign, exponent, _)) = self.0.as_raw_parts() else {
            return f64::NAN;
        };
        // The mantissa is a fraction below one, its highest word last. What the lower words hold
        // matters only for ties, which a reference does not depend on.
        let top = words.last().copied().unwrap_or(0) as f64 * 2.0_f64.powi(-64);
        // Two steps, because 2^exponent alone may leave the range where the product does not.
        let half = exponent / 2;
        let magnitude = top * power_of_two(half) * power_of_two(exponent - half);
        match sign {
            Sign::Pos => magnitude,
            Sign::Neg => -magnitude,
        }
    }

    /// Whether it is below zero.
    pub fn is_negative(&self) -> bool {
        self.0.is_negative() && !self.0.is_zero()
    }

    /// The absolute value.
    pub fn abs(&self) -> Self {
        Self(self.0.abs())
    }

    /// The square root.
    pub fn sqrt(&self) -> Self {
        Self(self.0.sqrt(BITS, ROUNDING))
    }

    /// `e` to this power.
    pub fn exp(&self) -> Self {
        with_constants(|c| self.0.exp(BITS, ROUNDING, c))
    }

    /// The sine of an angle in radians.
    pub fn sin(&self) -> Self {
        with_constants(|c| self.0.sin(BITS, ROUNDING, c))
    }

    /// The cosine of an angle in radians.
    pub fn cos(&self) -> Self {
        with_constants(|c| self.0.cos(BITS, ROUNDING, c))
    }

    /// Angle of the point `(x, self)`, in `(-π, π]`.
    pub fn atan2(&self, x: &Self) -> Self {
        if x.is_zero() && self.is_zero() {
            return Self::zero();
        }
        // The quotient that is at most one keeps its digits at both ends.
        if self.abs() <= x.abs() {
            let near = with_constants(|c| (self / x).0.atan(BITS, ROUNDING, c));
            match (x.is_negative(), self.is_negative()) {
                (false, _) => near,
                (true, false) => near + Self::pi(),
                (true, true) => near - Self::pi(),
            }
        } else {
            let quarter = Self::pi() * 0.5;
            let near = with_constants(|c| (x / self).0.atan(BITS, ROUNDING, c));
            if self.is_negative() { -quarter - near } else { quarter - near }
        }
    }
}

fn with_constants(compute: impl FnOnce(&mut Consts) -> BigFloat) -> High {
    CONSTANTS.with_borrow_mut(|constants| match constants {
        Some(c) => High(compute(c)),
        None => High(BigFloat::nan(None)),
    })
}

fn power_of_two(exponent: i32) -> f64 {
    2.0_f64.powi(exponent)
}

impl From<f64> for High {
    fn from(value: f64) -> Self {
        if value.is_subnormal() {
            // astro-float makes zeros of these; lifted by a power of two they are as good as any.
            let lifted = Self(BigFloat::from_f64(value * power_of_two(100), BITS));
            return lifted * Self(BigFloat::from_f64(power_of_two(-100), BITS));
        }
        Self(BigFloat::from_f64(value, BITS))
    }
}

impl Neg for High {
    type Output = High;
    fn neg(self) -> High {
        High(-self.0)
    }
}

impl Neg for &High {
    type Output = High;
    fn neg(self) -> High {
        High(BigFloat::neg(&self.0))
    }
}

/// What stands on the right of an operation.
pub trait Operand {
    fn high(&self) -> Cow<'_, High>;
}

impl Operand for High {
    fn high(&self) -> Cow<'_, High> {
        Cow::Borrowed(self)
    }
}

impl Operand for &High {
    fn high(&self) -> Cow<'_, High> {
        Cow::Borrowed(self)
    }
}

impl Operand for f64 {
    fn high(&self) -> Cow<'_, High> {
        Cow::Owned(High::from(*self))
    }
}

macro_rules! operation {
    ($trait:ident, $name:ident, $assign_trait:ident, $assign:ident) => {
        impl<T: Operand> $trait<T> for &High {
            type Output = High;
            fn $name(self, other: T) -> High {
                High(self.0.$name(&other.high().0, BITS, ROUNDING))
            }
        }
        impl<T: Operand> $trait<T> for High {
            type Output = High;
            fn $name(self, other: T) -> High {
                (&self).$name(other)
            }
        }
        impl<T: Operand> $assign_trait<T> for High {
            fn $assign(&mut self, other: T) {
                *self = (&*self).$name(other);
            }
        }
    };
}

operation!(Add, add, AddAssign, add_assign);
operation!(Sub, sub, SubAssign, sub_assign);
operation!(Mul, mul, MulAssign, mul_assign);
operation!(Div, div, DivAssign, div_assign);

impl Zero for High {
    fn zero() -> Self {
        Self::from(0.0)
    }

    fn is_zero(&self) -> bool {
        self.0.is_zero()
    }
}

impl One for High {
    fn one() -> Self {
        Self::from(1.0)
    }
}

impl Sum for High {
    fn sum<I: Iterator<Item = High>>(items: I) -> High {
        items.fold(High::zero(), |sum, item| sum + item)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use astro_float_num::Radix;

    /// A published decimal expansion.
    fn published(digits: &str) -> High {
        with_constants(|c| BigFloat::parse(digits, Radix::Dec, BITS, ROUNDING, c))
    }

    #[track_caller]
    fn assert_good_to_180_bits(found: &High, expected: &High) {
        let difference = (found - expected).abs();
        let allowed = expected.abs() * 2.0_f64.powi(-180);
        assert!(difference <= allowed, "off by {:e} of {}", difference.to_f64(), expected.to_f64());
    }

    const PI: &str =
        "3.14159265358979323846264338327950288419716939937510582097494459230781640628620899";
    const SQRT_2: &str =
        "1.41421356237309504880168872420969807856967187537694807317667973799073247846210704";
    /// cos 1 and sin 1, OEIS A049470 and A049469.
    const COS_1: &str =
        "0.540302305868139717400936607442976603732310420617922227670097255381100394774471764";
    const SIN_1: &str =
        "0.841470984807896506652502321630298999622563060798371065672751709991910404391239669";

    #[test]
    fn pi_and_the_root_of_two_are_the_published_ones() {
        assert_good_to_180_bits(&High::pi(), &published(PI));
        assert_good_to_180_bits(&High::from(2.0).sqrt(), &published(SQRT_2));
    }

    #[test]
    fn sine_and_cosine_of_one_are_the_published_ones() {
        assert_good_to_180_bits(&High::one().cos(), &published(COS_1));
        assert_good_to_180_bits(&High::one().sin(), &published(SIN_1));
    }

    #[test]
    fn exponentials_multiply_and_begin_at_one() {
        assert_eq!(High::zero().exp(), High::one());
        let (a, b) = (High::from(0.3), High::from(-70.1));
        assert_good_to_180_bits(&((&a + &b).exp() / b.exp()), &a.exp());
        let e = published("2.71828182845904523536028747135266249775724709369995957496696763");
        assert_good_to_180_bits(&High::one().exp(), &e);
    }

    #[test]
    fn machins_formula_gives_pi() {
        let fifth = High::one().atan2(&High::from(5.0));
        let small = High::one().atan2(&High::from(239.0));
        assert_good_to_180_bits(&(fifth * 16.0 - small * 4.0), &published(PI));
    }

    #[test]
    fn the_eight_directions_are_eighths_of_a_turn() {
        for k in -3..=4_i32 {
            let (y, x) = [
                (0.0, 1.0),
                (1.0, 1.0),
                (1.0, 0.0),
                (1.0, -1.0),
                (0.0, -1.0),
                (-1.0, -1.0),
                (-1.0, 0.0),
                (-1.0, 1.0),
            ][k.rem_euclid(8) as usize];
            let found = High::from(y).atan2(&High::from(x));
            let expected = High::pi() * f64::from(k) * 0.25;
            assert!((found - expected).abs() < High::from(1e-54), "{k}");
        }
    }

    #[test]
    fn what_cancels_in_53_bits_is_kept() {
        let one_and_a_bit = High::from(1e-30) + 1.0;
        assert_eq!((one_and_a_bit - 1.0).to_f64(), 1e-30);
    }

    #[test]
    fn numbers_survive_the_way_there_and_back() {
        for value in [0.0, 1.0, -0.1, 1e300, -1e-300, 5e-324, f64::MAX, 1.0 / 3.0] {
            assert_eq!(High::from(value).to_f64(), value);
        }
        assert!(High::from(f64::NAN).to_f64().is_nan());
        assert_eq!(High::from(f64::INFINITY).to_f64(), f64::INFINITY);
        assert_eq!((-High::from(f64::INFINITY)).to_f64(), f64::NEG_INFINITY);
    }
}
