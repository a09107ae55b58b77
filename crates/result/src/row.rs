//! Figures: each with its name for programs, its name for people, its unit and its decimals.

use serde::Serialize;
use serde_json::{Value, json};
use std::borrow::Cow;

/// One figure, or whatever else stands in a line of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name for programs, unit included; a dot leads into an object. Empty where only people read it.
    pub key: Cow<'static, str>,
    /// Name for people; empty where only programs read it.
    pub label: Cow<'static, str>,
    /// What programs read, to the bit; null where it is not known.
    pub value: Value,
    /// Of numbers that are not counts, where people read them.
    pub decimals: usize,
    pub unit: &'static str,
    /// What people read after the unit, such as the interval of the value.
    pub remark: Cow<'static, str>,
    /// A detail of the row above.
    pub is_part: bool,
}

impl Row {
    /// As a detail of the row above.
    pub fn part(self) -> Self {
        Self { is_part: true, ..self }
    }

    /// With words after the unit.
    pub fn remarked(self, remark: impl Into<Cow<'static, str>>) -> Self {
        Self { remark: remark.into(), ..self }
    }

    /// Only programs read it where this does not hold.
    pub fn shown_if(self, is_shown: bool) -> Self {
        if is_shown { self } else { Self { label: "".into(), ..self } }
    }

    /// The value as people read it, without its unit.
    pub fn value_text(&self) -> String {
        value_text(&self.value, self.decimals)
    }
}

fn row(
    key: impl Into<Cow<'static, str>>,
    label: impl Into<Cow<'static, str>>,
    value: impl Serialize,
    decimals: usize,
    unit: &'static str,
) -> Row {
    Row {
        key: key.into(),
        label: label.into(),
        value: json!(value),
        decimals,
        unit,
        remark: "".into(),
        is_part: false,
    }
}

/// A number of things.
pub fn count(
    key: impl Into<Cow<'static, str>>,
    label: impl Into<Cow<'static, str>>,
    count: usize,
) -> Row {
    row(key, label, count, 0, "")
}

/// A number, or none where it is not known.
pub fn number(
    key: impl Into<Cow<'static, str>>,
    label: impl Into<Cow<'static, str>>,
    value: impl Into<Option<f64>>,
    decimals: usize,
    unit: &'static str,
) -> Row {
    row(key, label, value.into(), decimals, unit)
}

/// A length, to the micrometre.
pub fn mm(
    key: impl Into<Cow<'static, str>>,
    label: impl Into<Cow<'static, str>>,
    value_mm: impl Into<Option<f64>>,
) -> Row {
    number(key, label, value_mm, 3, "mm")
}

/// An angle in degrees, to the thousandth, from radians.
pub fn deg(
    key: impl Into<Cow<'static, str>>,
    label: impl Into<Cow<'static, str>>,
    angle_rad: impl Into<Option<f64>>,
) -> Row {
    number(key, label, angle_rad.into().map(f64::to_degrees), 3, "deg")
}

/// Several numbers, such as coordinates, or none where they are not known.
pub fn vector<const N: usize>(
    key: impl Into<Cow<'static, str>>,
    label: impl Into<Cow<'static, str>>,
    values: impl Into<Option<[f64; N]>>,
    decimals: usize,
    unit: &'static str,
) -> Row {
    row(key, label, values.into().map(Vec::from), decimals, unit)
}

/// Words.
pub fn text(
    key: impl Into<Cow<'static, str>>,
    label: impl Into<Cow<'static, str>>,
    value: impl Into<String>,
) -> Row {
    row(key, label, value.into(), 0, "")
}

/// What only programs read.
pub fn data(key: impl Into<Cow<'static, str>>, value: impl Serialize) -> Row {
    row(key, "", value, 0, "")
}

/// A value as people read it.
pub fn value_text(value: &Value, decimals: usize) -> String {
    match value {
        Value::Null => "–".to_owned(),
        Value::Bool(holds) => if *holds { "yes" } else { "no" }.to_owned(),
        Value::Number(number) => match (number.as_u64(), number.as_f64()) {
            (Some(count), _) => with_separators(count as usize),
            (None, Some(value)) => format!("{value:.decimals$}"),
            (None, None) => number.to_string(),
        },
        Value::String(text) => text.clone(),
        Value::Array(values) => {
            let values = values.iter().map(|value| value_text(value, decimals));
            values.collect::<Vec<_>>().join(" ")
        }
        Value::Object(_) => value.to_string(),
    }
}

/// A count with a comma every three digits.
///
/// ```
/// assert_eq!(trackwright_result::with_separators(1_234_567), "1,234,567");
/// ```
pub fn with_separators(count: usize) -> String {
    let digits = count.to_string();
    let mut out = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_a_comma_every_three_digits() {
        for (count, text) in [(0, "0"), (999, "999"), (3375, "3,375"), (1_000_000, "1,000,000")] {
            assert_eq!(with_separators(count), text);
        }
    }

    #[test]
    fn what_is_not_known_is_a_dash() {
        let rows = [mm("", "", 1.0), mm("", "", None), mm("", "", f64::NAN), count("", "", 1200)];
        assert_eq!(rows.map(|row| row.value_text()), ["1.000", "–", "–", "1,200"]);
        assert_eq!(vector("", "", [0.5, -1.0], 2, "mm").value_text(), "0.50 -1.00");
        assert_eq!(vector::<3>("", "", None, 2, "mm").value_text(), "–");
    }
}
