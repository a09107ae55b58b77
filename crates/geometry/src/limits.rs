//! Largest lengths and angles that are taken from a person or a file: what is beyond is a mistake,
//! and would become infinite where it is squared.

/// Longest length and farthest coordinate, in millimetres: 1 km. Trackers reach a few metres.
pub const MAX_LENGTH_MM: f64 = 1e6;

/// Largest angle in degrees, either way: ten turns.
pub const MAX_ANGLE_DEG: f64 = 3600.0;

/// Beyond these sizes numbers in messages have an exponent.
const LONG: f64 = 1e16;
const TINY: f64 = 1e-9;

/// What was expected of the coordinates of a position, in millimetres; `None` where they are fine.
pub fn position_problem<'a>(
    coordinates_mm: impl IntoIterator<Item = &'a f64>,
) -> Option<&'static str> {
    coordinates_mm.into_iter().find_map(|value| {
        if !value.is_finite() {
            return Some("finite numbers");
        }
        (value.abs() > MAX_LENGTH_MM).then_some("coordinates of at most 1e6 mm")
    })
}

/// What was expected of a length above zero; `None` where it is one.
pub fn length_above_zero_problem(length_mm: f64) -> Option<&'static str> {
    // What is not a number is not above zero either.
    match length_mm > 0.0 && length_mm.is_finite() {
        false => Some("a length above zero"),
        true => too_long(length_mm),
    }
}

/// What was expected of a length of zero or more; `None` where it is one.
pub fn length_problem(length_mm: f64) -> Option<&'static str> {
    match length_mm >= 0.0 && length_mm.is_finite() {
        false => Some("zero or more"),
        true => too_long(length_mm),
    }
}

/// What was expected of an angle of zero or more; `None` where it is one.
pub fn angle_problem(angle_deg: f64) -> Option<&'static str> {
    match angle_deg >= 0.0 && angle_deg.is_finite() {
        false => Some("zero or more"),
        true => (angle_deg > MAX_ANGLE_DEG).then_some("an angle of at most 3600 degrees"),
    }
}

fn too_long(length_mm: f64) -> Option<&'static str> {
    (length_mm > MAX_LENGTH_MM).then_some("a length of at most 1e6 mm")
}

/// A number for a message: `1e308`, not three hundred digits.
pub fn short(value: f64) -> String {
    let is_long = value != 0.0 && value.is_finite() && !(TINY..LONG).contains(&value.abs());
    if is_long { format!("{value:e}") } else { value.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_messages_are_short() {
        for (value, text) in [(0.0, "0"), (2.5, "2.5"), (-1e-300, "-1e-300"), (1e308, "1e308")] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn a_kilometre_is_the_longest_length() {
        assert_eq!(length_above_zero_problem(MAX_LENGTH_MM), None);
        assert_eq!(length_problem(0.0), None);
        assert_eq!(length_above_zero_problem(0.0), Some("a length above zero"));
        assert_eq!(length_problem(-1.0), Some("zero or more"));
        for absurd in [MAX_LENGTH_MM * 1.001, 1e308] {
            let expected = Some("a length of at most 1e6 mm");
            assert_eq!(length_problem(absurd), expected);
            assert_eq!(length_above_zero_problem(absurd), expected);
            let expected = Some("coordinates of at most 1e6 mm");
            assert_eq!(position_problem(&[0.0, -absurd]), expected);
        }
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(length_problem(value).is_some() && angle_problem(value).is_some());
            assert!(length_above_zero_problem(value).is_some());
            assert_eq!(position_problem(&[value]), Some("finite numbers"));
        }
        assert_eq!(position_problem(&[-MAX_LENGTH_MM, 0.0]), None);
    }

    #[test]
    fn ten_turns_are_the_largest_angle() {
        assert_eq!(angle_problem(MAX_ANGLE_DEG), None);
        let expected = Some("an angle of at most 3600 degrees");
        assert_eq!(angle_problem(1e308), expected);
        assert_eq!(angle_problem(-1e-9), Some("zero or more"));
    }

    #[test]
    fn large_numbers_are_short_in_messages() {
        let texts = [1e308, -0.5, 300.0, f64::NAN, f64::NEG_INFINITY].map(short);
        assert_eq!(texts, ["1e308", "-0.5", "300", "NaN", "-inf"]);
    }
}
