//! Numbers in files: shortest decimals that read back exactly, and unit vectors that stay put.

use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

use super::pose::MIN_NORM;

/// How far the squared length of a vector that was normalised before may be from 1. Dividing by
/// a rounded root costs each component one and a half units in the last place, squares double it.
const NORMALISED: f64 = 8.0 * f64::EPSILON;

/// The shortest decimal that reads back exactly; very large and small ones with an exponent.
pub fn shortest(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude != 0.0 && !(1e-5..1e16).contains(&magnitude) {
        format!("{value:e}")
    } else {
        format!("{value}")
    }
}

/// The direction of a vector; `None` where it has none or is not finite.
///
/// A vector of length 1 is kept to the bit, so that reading what was written changes nothing.
pub fn direction(components: [f64; 3]) -> Option<Unit<Vector3<f64>>> {
    let vector = Vector3::from(components);
    if is_normalised(vector.norm_squared()) {
        return Some(Unit::new_unchecked(vector));
    }
    let vector = scaled_down(&components).map(Vector3::from)?;
    Unit::try_new(vector, MIN_NORM)
}

/// The rotation of a quaternion, scalar first; `None` where it has no length or is not finite.
pub fn rotation(components: [f64; 4]) -> Option<UnitQuaternion<f64>> {
    let [w, x, y, z] = components;
    let quaternion = Quaternion::new(w, x, y, z);
    if is_normalised(quaternion.norm_squared()) {
        return Some(Unit::new_unchecked(quaternion));
    }
    let [w, x, y, z] = scaled_down(&components)?;
    UnitQuaternion::try_new(Quaternion::new(w, x, y, z), MIN_NORM)
}

fn is_normalised(squared_length: f64) -> bool {
    (squared_length - 1.0).abs() <= NORMALISED
}

/// Components that can be squared without overflow; `None` for ones that are not finite.
fn scaled_down<const N: usize>(components: &[f64; N]) -> Option<[f64; N]> {
    let largest = components.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if components.iter().any(|v| !v.is_finite()) {
        return None;
    }
    Some(if largest > 1e100 { components.map(|v| v / largest) } else { *components })
}

/// The largest of 1, 2 or 5 times a power of ten that is not above `limit`.
pub fn round_below(limit: f64) -> f64 {
    if !(limit.is_finite() && limit > 0.0) {
        return 1.0;
    }
    let decade = 10f64.powi(limit.log10().floor() as i32);
    // Round-off must not make a decade of its own limit too large.
    let slack = 1.0 + 1e-12;
    [10.0, 5.0, 2.0, 1.0]
        .into_iter()
        .map(|digit| digit * decade)
        .find(|value| *value <= limit * slack)
        .unwrap_or(decade)
}

/// The smallest of 1, 2 or 5 times a power of ten that is not below a positive value.
///
/// ```
/// use trackwright_geometry::number::{round_above, round_below};
/// assert_eq!([round_above(0.3), round_above(2.0), round_above(61.0)], [0.5, 2.0, 100.0]);
/// assert_eq!([round_below(0.3), round_below(2.0), round_below(61.0)], [0.2, 2.0, 50.0]);
/// ```
pub fn round_above(value: f64) -> f64 {
    let decade = 10_f64.powf(value.log10().floor());
    // Round-off must not make a step of its own value too small.
    let slack = 1.0 - 1e-9;
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|digit| digit * decade)
        .find(|step| *step >= value * slack)
        .unwrap_or(10.0 * decade)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn decimals_are_short() {
        assert_eq!(shortest(1.0), "1");
        assert_eq!(shortest(0.1 + 0.2), "0.30000000000000004");
        assert_eq!(shortest(-2.5e-9), "-2.5e-9");
        assert_eq!(shortest(0.0), "0");
        assert_eq!(shortest(1e300), "1e300");
    }

    #[test]
    fn nothing_has_no_direction() {
        assert!(direction([0.0; 3]).is_none());
        assert!(direction([f64::NAN, 0.0, 1.0]).is_none());
        assert!(direction([f64::INFINITY, 0.0, 1.0]).is_none());
        assert!(rotation([0.0; 4]).is_none());
        assert!(rotation([1.0, f64::NAN, 0.0, 0.0]).is_none());
    }

    proptest! {
        #[test]
        fn decimals_read_back_exactly(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            prop_assert_eq!(shortest(value).parse::<f64>().unwrap().to_bits(), bits);
        }

        #[test]
        fn normalising_twice_is_normalising_once(v in prop::array::uniform4(-1e3..1e3_f64)) {
            let [x, y, z, w] = v;
            let Some(axis) = direction([x, y, z]) else { return Ok(()) };
            let again = direction((*axis).into()).unwrap();
            prop_assert_eq!(axis.into_inner(), again.into_inner());
            let Some(q) = rotation([w, x, y, z]) else { return Ok(()) };
            let again = rotation([q.w, q.i, q.j, q.k]).unwrap();
            prop_assert_eq!(q.into_inner().coords, again.into_inner().coords);
        }
    }
}
