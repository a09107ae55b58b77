//! What a person types into a field.

use super::read;
use trackwright_formats::typed_number::{NumberUnit, parse};

const UNITS: [NumberUnit; 9] = [
    NumberUnit::Plain,
    NumberUnit::Micrometre,
    NumberUnit::Millimetre,
    NumberUnit::Centimetre,
    NumberUnit::Metre,
    NumberUnit::Inch,
    NumberUnit::Degree,
    NumberUnit::Radian,
    NumberUnit::Milliradian,
];

/// A text in a field of every unit: its number is finite, and typed in digits is the same again.
pub fn typed_number(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    let mut is_number = false;
    for unit in UNITS {
        if let Some(number) = read(parse(&text, unit)) {
            is_number = true;
            assert!(number.is_finite());
            for typed in [format!("{number}"), format!("{number:e}")] {
                assert_eq!(parse(&typed, unit), Ok(number), "{typed}");
            }
        }
    }
    is_number
}
