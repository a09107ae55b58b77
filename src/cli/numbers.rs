//! Numbers as arguments: finite, and in the range that they have to be in.

use trackwright_geometry::limits::{MAX_LENGTH_MM, short};

/// Largest number of any argument, either way: 1 km, and more degrees, seconds or hertz than there
/// are uses of.
const MAX: f64 = MAX_LENGTH_MM;

pub fn zero_or_more(text: &str) -> Result<f64, String> {
    number(text, "zero or more", |value| value >= 0.0)
}

/// Degrees of an angle between two directions.
pub fn angle_deg(text: &str) -> Result<f64, String> {
    number(text, "0 to 180", |value| (0.0..=180.0).contains(&value))
}

pub fn above_zero(text: &str) -> Result<f64, String> {
    number(text, "a number above zero", |value| value > 0.0)
}

pub fn length_above_zero(text: &str) -> Result<f64, String> {
    number(text, "a length above zero", |value| value > 0.0)
}

/// One length for all axes, or one for each.
pub fn lengths_above_zero(text: &str) -> Result<[f64; 3], String> {
    let expected = "a length above zero, or three with commas";
    match text.split(',').count() {
        1 => length_above_zero(text).map(|length| [length; 3]),
        _ => list(text, expected, |value| value > 0.0),
    }
}

pub fn three(text: &str) -> Result<[f64; 3], String> {
    list(text, "three numbers with commas", |_| true)
}

pub fn six(text: &str) -> Result<[f64; 6], String> {
    list(text, "six numbers with commas", |_| true)
}

fn list<const N: usize>(
    text: &str,
    expected: &str,
    is_fine: fn(f64) -> bool,
) -> Result<[f64; N], String> {
    let values: Result<Vec<f64>, String> =
        text.split(',').map(|cell| number(cell.trim(), expected, is_fine)).collect();
    values?.try_into().map_err(|_| format!("expected {expected}"))
}

fn number(text: &str, expected: &str, is_fine: fn(f64) -> bool) -> Result<f64, String> {
    let value = text
        .parse()
        .ok()
        .filter(|value: &f64| value.is_finite() && is_fine(*value))
        .ok_or_else(|| format!("expected {expected}"))?;
    match value.abs() <= MAX {
        true => Ok(value),
        false => Err(format!("found {}, expected at most 1e6", short(value))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_beyond_a_million_are_refused() {
        let far = "found 1e308, expected at most 1e6";
        for refused in [
            zero_or_more("1e308").map(|_| ()),
            above_zero("1e308").map(|_| ()),
            length_above_zero("1e308").map(|_| ()),
            lengths_above_zero("1,1e308,1").map(|_| ()),
            three("0,0,1e308").map(|_| ()),
            six("0,0,0,0,0,1e308").map(|_| ()),
        ] {
            assert_eq!(refused, Err(far.to_owned()));
        }
        assert_eq!(three("-1e6,0,1e6"), Ok([-1e6, 0.0, 1e6]));
        assert_eq!(zero_or_more("inf"), Err("expected zero or more".to_owned()));
    }
}
