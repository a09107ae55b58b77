//! Numbers as a person types them into a field: `12.5+3`, `(2 in - 1)/2`, `12,5`, `30°`.
//!
//! An expression of numbers, `+ - * /`, parentheses and units. What has no unit is in the field's
//! own. Lengths and angles cannot be multiplied with each other; a quotient of two lengths is a
//! plain number.
//!
//! No crate did: those that are maintained and free to use know neither units nor the place of an
//! error, and recurse as deep as the text is nested.

use std::fmt;

/// Deepest nesting of parentheses: more than anybody types, and far less than a stack holds.
pub const MAX_DEPTH: usize = 50;

/// Longest piece of text that an error quotes.
const MAX_QUOTE: usize = 24;

/// What a number is given in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NumberUnit {
    /// A count or a ratio; a field of this kind takes no units.
    Plain,
    Micrometre,
    Millimetre,
    Centimetre,
    Metre,
    Inch,
    Degree,
    Radian,
    Milliradian,
}

/// What kind of quantity a unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    Plain,
    Length,
    Angle,
}

/// Why a text is no number. Columns count characters from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TypedNumberError {
    #[error("found nothing, expected a number")]
    Empty,
    #[error("column {column}: found {found}, expected {expected}")]
    Unexpected { column: usize, found: String, expected: &'static str },
    #[error("column {column}: found no `)` for this `(`, expected one")]
    Unclosed { column: usize },
    #[error("column {column}: found `{found}`, expected {expected}")]
    UnknownUnit { column: usize, found: String, expected: &'static str },
    #[error("column {column}: found {found}, expected {expected}")]
    WrongDimension { column: usize, found: Dimension, expected: Dimension },
    #[error(
        "column {column}: found `{found}`, which can mean {decimal} or {thousands}, expected a decimal point or no comma"
    )]
    AmbiguousComma { column: usize, found: String, decimal: String, thousands: String },
    #[error("column {column}: found a division by zero, expected another divisor")]
    DivisionByZero { column: usize },
    #[error("column {column}: found a number that is too large, expected one below 1.8e308")]
    TooLarge { column: usize },
    #[error(
        "column {column}: found more than {MAX_DEPTH} parentheses within each other, expected fewer"
    )]
    TooDeep { column: usize },
}

/// What is expected where a number may begin.
const A_NUMBER: &str = "a number";

/// Most letters of a refused text that are shown.
const MOST_SHOWN: usize = 40;

impl TypedNumberError {
    /// Why a text is refused, for who typed it: `"a0" is not a number`, or where in an expression it
    /// goes wrong.
    pub fn words(&self, typed: &str) -> String {
        let begins_at =
            |column: usize| typed.chars().take(column.saturating_sub(1)).all(char::is_whitespace);
        match self {
            Self::Unexpected { column, expected: A_NUMBER, .. } if begins_at(*column) => {
                let shown: String = typed.trim().chars().take(MOST_SHOWN).collect();
                format!("\"{shown}\" is not a number")
            }
            other => other.to_string(),
        }
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Plain => "a plain number",
            Self::Length => "a length (µm, mm, cm, m, in)",
            Self::Angle => "an angle (°, deg, rad, mrad)",
        })
    }
}

impl NumberUnit {
    pub fn dimension(self) -> Dimension {
        match self {
            Self::Plain => Dimension::Plain,
            Self::Micrometre | Self::Millimetre | Self::Centimetre | Self::Metre | Self::Inch => {
                Dimension::Length
            }
            Self::Degree | Self::Radian | Self::Milliradian => Dimension::Angle,
        }
    }

    /// The unit as a fraction of millimetres or degrees, and whether that is to be divided by π.
    /// Whole numbers, so that `1 µm` is the double next to 0.001 and no product of rounded ones.
    fn size(self) -> (f64, f64, bool) {
        match self {
            Self::Plain | Self::Millimetre | Self::Degree => (1.0, 1.0, false),
            Self::Micrometre => (1.0, 1000.0, false),
            Self::Centimetre => (10.0, 1.0, false),
            Self::Metre => (1000.0, 1.0, false),
            Self::Inch => (254.0, 10.0, false),
            Self::Radian => (180.0, 1.0, true),
            Self::Milliradian => (180.0, 1000.0, true),
        }
    }

    /// A value in this unit, in another one of the same dimension.
    fn convert(self, value: f64, to: Self) -> f64 {
        if self == to {
            return value;
        }
        let ((a, b, over_pi), (c, d, to_over_pi)) = (self.size(), to.size());
        let value = value * (a * d) / (b * c);
        match (over_pi, to_over_pi) {
            (true, false) => value / std::f64::consts::PI,
            (false, true) => value * std::f64::consts::PI,
            _ => value,
        }
    }

    fn of_name(name: &str) -> Option<Self> {
        Some(match name {
            // The micro sign and the Greek letter.
            "um" | "\u{b5}m" | "\u{3bc}m" => Self::Micrometre,
            "mm" => Self::Millimetre,
            "cm" => Self::Centimetre,
            "m" => Self::Metre,
            "in" => Self::Inch,
            "°" | "deg" => Self::Degree,
            "rad" => Self::Radian,
            "mrad" => Self::Milliradian,
            _ => return None,
        })
    }
}

/// The value of what was typed into a field whose numbers are in `unit`, in that unit; finite.
///
/// `-`, `−` and `–` are minus, `*`, `×` and `·` times, `/` and `÷` divided by. A comma is a
/// decimal one unless it can as well set off thousands, as in `1,234`.
///
/// ```
/// use trackwright_formats::typed_number::{NumberUnit, parse};
///
/// assert_eq!(parse("1in + 2", NumberUnit::Millimetre), Ok(27.4));
/// assert_eq!(parse("12,5", NumberUnit::Plain), Ok(12.5));
/// ```
pub fn parse(text: &str, unit: NumberUnit) -> Result<f64, TypedNumberError> {
    let mut parser = Parser { chars: text.chars().collect(), at: 0, unit };
    if parser.peek().is_none() {
        return Err(TypedNumberError::Empty);
    }
    let value = parser.sum(0)?;
    if parser.peek().is_some() {
        return Err(parser.unexpected("an operator or the end"));
    }
    parser.in_field(value, 0).map(|value| value.number)
}

/// A value on the way: plain, or a length or angle in the field's unit.
#[derive(Clone, Copy)]
struct Value {
    number: f64,
    dimension: Dimension,
}

struct Parser {
    chars: Vec<char>,
    at: usize,
    unit: NumberUnit,
}

impl Parser {
    /// `product (+ product)*`
    fn sum(&mut self, depth: usize) -> Result<Value, TypedNumberError> {
        let start = self.at;
        let mut sum = self.product(depth)?;
        while let Some(sign) = self.peek().and_then(sign) {
            self.at += 1;
            let other_start = self.at;
            let mut other = self.product(depth)?;
            if sum.dimension != other.dimension {
                sum = self.in_field(sum, start)?;
                other = self.in_field(other, other_start)?;
            }
            sum.number = self.finite(sum.number + sign * other.number, start)?;
        }
        Ok(sum)
    }

    /// `factor (* factor)*`
    fn product(&mut self, depth: usize) -> Result<Value, TypedNumberError> {
        self.skip_spaces();
        let start = self.at;
        let mut product = self.factor(depth)?;
        loop {
            let is_division = match self.peek() {
                Some('*' | '×' | '·') => false,
                Some('/' | '÷') => true,
                _ => return Ok(product),
            };
            self.at += 1;
            self.skip_spaces();
            let other_start = self.at;
            let other = self.factor(depth)?;
            product.dimension = match (product.dimension, other.dimension) {
                (dimension, Dimension::Plain) => dimension,
                (Dimension::Plain, dimension) if !is_division => dimension,
                (a, b) if a == b && is_division => Dimension::Plain,
                (_, found) => {
                    return Err(TypedNumberError::WrongDimension {
                        column: other_start + 1,
                        found,
                        expected: Dimension::Plain,
                    });
                }
            };
            if is_division && other.number == 0.0 {
                let column = other_start + 1;
                return Err(TypedNumberError::DivisionByZero { column });
            }
            let number = if is_division {
                product.number / other.number
            } else {
                product.number * other.number
            };
            product.number = self.finite(number, start)?;
        }
    }

    /// Any signs, a number or a sum in parentheses, perhaps a unit.
    fn factor(&mut self, depth: usize) -> Result<Value, TypedNumberError> {
        let mut factor = 1.0;
        while let Some(sign) = self.peek().and_then(sign) {
            self.at += 1;
            factor *= sign;
        }
        self.skip_spaces();
        let start = self.at;
        let mut value = match self.peek() {
            Some('(') if depth == MAX_DEPTH => {
                return Err(TypedNumberError::TooDeep { column: start + 1 });
            }
            Some('(') => {
                self.at += 1;
                let sum = self.sum(depth + 1)?;
                match self.peek() {
                    Some(')') => self.at += 1,
                    None => return Err(TypedNumberError::Unclosed { column: start + 1 }),
                    Some(_) => return Err(self.unexpected("an operator or `)`")),
                }
                sum
            }
            Some(c) if c.is_ascii_digit() || is_decimal_mark(c) => {
                Value { number: self.number()?, dimension: Dimension::Plain }
            }
            _ => return Err(self.unexpected(A_NUMBER)),
        };
        if let Some((name, column)) = self.name() {
            value = self.with_unit(value, &name, column)?;
        }
        value.number = self.finite(factor * value.number, start)?;
        Ok(value)
    }

    fn with_unit(
        &self,
        value: Value,
        name: &str,
        column: usize,
    ) -> Result<Value, TypedNumberError> {
        let expected = self.unit.dimension();
        let Some(unit) = NumberUnit::of_name(name) else {
            return Err(TypedNumberError::UnknownUnit {
                column,
                found: shortened(name),
                expected: match expected {
                    Dimension::Plain => "an operator or the end",
                    Dimension::Length => "µm, mm, cm, m or in",
                    Dimension::Angle => "°, deg, rad or mrad",
                },
            });
        };
        if unit.dimension() != expected {
            return Err(TypedNumberError::WrongDimension {
                column,
                found: unit.dimension(),
                expected,
            });
        }
        if value.dimension != Dimension::Plain {
            return Err(TypedNumberError::Unexpected {
                column,
                found: format!("a second unit, `{name}`"),
                expected: "one",
            });
        }
        Ok(Value { number: unit.convert(value.number, self.unit), dimension: expected })
    }

    /// A value as one of the field's: what is plain is in its unit.
    fn in_field(&self, value: Value, start: usize) -> Result<Value, TypedNumberError> {
        let dimension = self.unit.dimension();
        match value.dimension {
            Dimension::Plain => Ok(Value { dimension, ..value }),
            found if found == dimension => Ok(value),
            found => Err(TypedNumberError::WrongDimension {
                column: start + 1,
                found,
                expected: dimension,
            }),
        }
    }

    /// Digits with at most one decimal point or comma, and an exponent.
    fn number(&mut self) -> Result<f64, TypedNumberError> {
        let start = self.at;
        let whole = self.digits();
        let mark = self.chars.get(self.at).copied().filter(|c| is_decimal_mark(*c));
        let fraction = match mark {
            None => String::new(),
            Some(_) => {
                self.at += 1;
                self.digits()
            }
        };
        if whole.is_empty() && fraction.is_empty() || mark == Some(',') && fraction.is_empty() {
            return Err(self.unexpected("a digit"));
        }
        if mark.is_some() && self.chars.get(self.at).copied().is_some_and(is_decimal_mark) {
            return Err(self.unexpected("one decimal point or comma"));
        }
        let exponent = self.exponent();
        if mark == Some(',') && can_be_thousands(&whole, &fraction) && exponent.is_empty() {
            return Err(TypedNumberError::AmbiguousComma {
                column: start + 1,
                found: format!("{whole},{fraction}"),
                decimal: format!("{whole}.{fraction}"),
                thousands: format!("{whole}{fraction}"),
            });
        }
        let number = format!("{whole}.{fraction}{exponent}").parse();
        // What was gathered is a number to Rust as well; one that is none is not let through.
        self.finite(number.unwrap_or(f64::NAN), start)
    }

    fn digits(&mut self) -> String {
        let rest = &self.chars[self.at..];
        let digits: String = rest.iter().take_while(|c| c.is_ascii_digit()).collect();
        self.at += digits.len();
        digits
    }

    /// `e-3`; nothing where an `e` is not followed by digits, so that it can be reported as a unit
    /// that there is not.
    fn exponent(&mut self) -> String {
        let start = self.at;
        if !matches!(self.chars.get(start), Some('e' | 'E')) {
            return String::new();
        }
        self.at += 1;
        let sign = self.chars.get(self.at).copied().and_then(sign);
        self.at += usize::from(sign.is_some());
        let digits = self.digits();
        if digits.is_empty() {
            self.at = start;
            return String::new();
        }
        format!("e{}{digits}", if sign == Some(-1.0) { "-" } else { "" })
    }

    /// The letters that stand here, and their column.
    fn name(&mut self) -> Option<(String, usize)> {
        let is_letter = |c: &&char| c.is_alphabetic() || **c == '°';
        self.peek().filter(|c| is_letter(&c))?;
        let start = self.at;
        let rest = &self.chars[start..];
        let name: String = match rest.first() {
            Some('°') => "°".to_owned(),
            _ => rest.iter().take_while(is_letter).collect(),
        };
        self.at += name.chars().count();
        Some((name, start + 1))
    }

    /// The next character that is no space; what is skipped stays skipped.
    fn peek(&mut self) -> Option<char> {
        self.skip_spaces();
        self.chars.get(self.at).copied()
    }

    fn skip_spaces(&mut self) {
        let rest = &self.chars[self.at..];
        self.at += rest.iter().take_while(|c| c.is_whitespace()).count();
    }

    fn finite(&self, number: f64, start: usize) -> Result<f64, TypedNumberError> {
        if number.is_finite() {
            Ok(number)
        } else {
            Err(TypedNumberError::TooLarge { column: start + 1 })
        }
    }

    fn unexpected(&mut self, expected: &'static str) -> TypedNumberError {
        let found = match self.peek() {
            None => "the end".to_owned(),
            Some(_) => {
                let rest = &self.chars[self.at..];
                // A word or a number whole, anything else by its character.
                let word = rest.iter().take_while(|c| c.is_alphanumeric()).count();
                let word: String = rest.iter().take(word.max(1)).collect();
                format!("`{}`", shortened(&word))
            }
        };
        TypedNumberError::Unexpected { column: self.at + 1, found, expected }
    }
}

fn sign(c: char) -> Option<f64> {
    match c {
        '+' => Some(1.0),
        '-' | '−' | '–' => Some(-1.0),
        _ => None,
    }
}

fn is_decimal_mark(c: char) -> bool {
    matches!(c, '.' | ',')
}

/// Whether `whole,fraction` can be one number with a comma behind its thousands.
fn can_be_thousands(whole: &str, fraction: &str) -> bool {
    (1..=3).contains(&whole.len()) && !whole.starts_with('0') && fraction.len() == 3
}

/// At most [`MAX_QUOTE`] characters, without any that a message cannot show.
fn shortened(text: &str) -> String {
    let mut short: String = text.chars().take(MAX_QUOTE).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short.escape_debug().to_string()
}

#[cfg(test)]
mod tests;
