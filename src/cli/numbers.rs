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

fn number(text: &str, expected: &str, is_fine: fn(f64) -> bool) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|value: &f64| value.is_finite() && is_fine(*value))
        .ok_or_else(|| format!("expected {expected}"))
}
