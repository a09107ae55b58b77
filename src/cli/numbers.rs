//! Numbers as arguments: finite, and in the range that they have to be in.

pub fn zero_or_more(text: &str) -> Result<f64, String> {
    number(text, "zero or more", |value| value >= 0.0)
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
    let values: Result<Vec<f64>, String> = text
        .split(',')
        .map(|cell| number(cell.trim(), expected, is_fine))
        .collect();
    values?
        .try_into()
        .map_err(|_| format!("expected {expected}"))
}

fn number(text: &str, expected: &str, is_fine: fn(f64) -> bool) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|value: &f64| value.is_finite() && is_fine(*value))
        .ok_or_else(|| format!("expected {expected}"))
}
