//! What people type, what they mistype, and what nobody types.

use super::NumberUnit::*;
use super::*;
use crate::test_cases::{any_text, assert_refused};
use proptest::prelude::*;

#[test]
fn sums_products_and_parentheses_are_worked_out() {
    for (text, value) in [
        ("12.5+3", 15.5),
        ("25/2", 12.5),
        ("1e-3", 1e-3),
        ("1E+2", 100.0),
        ("1e−3", 1e-3),
        ("-(3.5+1)*2", -9.0),
        ("−(3.5 + 1) × 2", -9.0),
        ("8/4/2", 1.0),
        ("8-4-2", 2.0),
        ("2+3*4", 14.0),
        ("3--2", 5.0),
        ("2*-3", -6.0),
        ("+ - + 4", -4.0),
        ("\u{a0}7\u{2009}÷ 2 ", 3.5),
        (".5", 0.5),
        ("5.", 5.0),
        ("0", 0.0),
    ] {
        assert_eq!(parse(text, Plain), Ok(value), "{text}");
        assert_eq!(parse(text, Millimetre), Ok(value), "{text}");
    }
}

#[test]
fn commas_are_decimal_unless_ambiguous() {
    for (text, value) in [
        ("12,5", 12.5),
        (",5", 0.5),
        ("0,125", 0.125),
        ("1234,567", 1234.567),
        ("1,2345", 1.2345),
        ("1,5+2.5", 4.0),
        ("1,234e0", 1.234),
    ] {
        assert_eq!(parse(text, Plain), Ok(value), "{text}");
    }
    assert_eq!(
        parse("2*1,234", Plain).unwrap_err().to_string(),
        "column 3: found `1,234`, which can mean 1.234 or 1234, \
         expected a decimal point or no comma"
    );
}

#[test]
fn units_are_the_fields_own_unless_stated() {
    for (text, unit, value) in [
        ("2 in", Millimetre, 50.8),
        ("1in + 2", Millimetre, 27.4),
        ("2 + 1cm", Centimetre, 3.0),
        ("(1 + 2) cm", Millimetre, 30.0),
        ("0.3 m", Millimetre, 300.0),
        ("1 µm", Millimetre, 0.001),
        ("1 μm", Millimetre, 0.001),
        ("0.7 mm", Millimetre, 0.7),
        ("0.7 mm", Metre, 0.0007),
        ("2*3mm", Millimetre, 6.0),
        ("10 cm / 4", Millimetre, 25.0),
        ("10 cm / 4 cm * 1 in", Inch, 2.5),
        ("90°", Degree, 90.0),
        ("90 deg", Radian, std::f64::consts::FRAC_PI_2),
        ("1 rad", Degree, 1_f64.to_degrees()),
        ("2mrad", Radian, 0.002),
        ("-30° + 10", Degree, -20.0),
        ("2e3mm", Metre, 2.0),
    ] {
        assert_eq!(parse(text, unit), Ok(value), "{text}");
    }
}

#[test]
fn errors_state_what_is_wrong_and_where() {
    for empty in ["", " \t\u{a0}"] {
        assert_eq!(parse(empty, Plain), Err(TypedNumberError::Empty));
    }
    let plain = r#"
        12 + | column 5: found the end, expected a number
        −−x | column 3: found `x`, expected a number
        12 34 | column 4: found `34`, expected an operator or the end
        (1+2 | column 1: found no `)` for this `(`, expected one
        (1 2) | column 4: found `2`, expected an operator or `)`
        1) | column 2: found `)`, expected an operator or the end
        () | column 2: found `)`, expected a number
        5 / (2-2) | column 5: found a division by zero, expected another divisor
        0/0 | column 3: found a division by zero, expected another divisor
        1e999 | column 1: found a number that is too large, expected one below 1.8e308
        1e300*1e300 | column 1: found a number that is too large, expected one below 1.8e308
        1.2.3 | column 4: found `.`, expected one decimal point or comma
        1,234,567 | column 6: found `,`, expected one decimal point or comma
        1.234,5 | column 6: found `,`, expected one decimal point or comma
        5, | column 3: found the end, expected a digit
        . | column 2: found the end, expected a digit
        nan | column 1: found `nan`, expected a number
        5 mm | column 3: found a length (µm, mm, cm, m, in), expected a plain number
        ٣ | column 1: found `٣`, expected a number
        1💥 | column 2: found `💥`, expected an operator or the end
    "#;
    let lengths = r#"
        5e | column 2: found `e`, expected µm, mm, cm, m or in
        5 MM | column 3: found `MM`, expected µm, mm, cm, m or in
        5 rad
            | column 3: found an angle (°, deg, rad, mrad), expected a length (µm, mm, cm, m, in)
        5 mm cm | column 6: found `cm`, expected an operator or the end
        (5 mm) cm | column 8: found a second unit, `cm`, expected one
        5 mm * 2 mm | column 8: found a length (µm, mm, cm, m, in), expected a plain number
        5 / 2 mm | column 5: found a length (µm, mm, cm, m, in), expected a plain number
    "#;
    for (cases, unit) in [(plain, Plain), (lengths, Millimetre)] {
        assert_refused("", cases, |text| parse(text, unit).unwrap_err().to_string());
    }
}

#[test]
fn nesting_is_bounded_and_signs_cost_no_stack() {
    let nested = |n: usize| format!("{}1{}", "(".repeat(n), ")".repeat(n));
    assert_eq!(parse(&nested(MAX_DEPTH), Plain), Ok(1.0));
    for n in [MAX_DEPTH + 1, 1_000_000] {
        let error = parse(&nested(n), Plain);
        let column = MAX_DEPTH + 1;
        assert_eq!(error, Err(TypedNumberError::TooDeep { column }));
    }
    assert_eq!(parse(&("-".repeat(1_000_000) + "1"), Plain), Ok(1.0));
    assert_eq!(
        parse(&"1+".repeat(100_000), Plain).map_err(|e| e.to_string().len() < 80),
        Err(true)
    );
    let digits = "9".repeat(1_000_000);
    assert_eq!(parse(&digits, Plain), Err(TypedNumberError::TooLarge { column: 1 }));
    let message = parse(&format!("1{}", "x".repeat(1_000_000)), Millimetre);
    assert!(message.unwrap_err().to_string().chars().count() < 100);
}

/// What a typing person, or a cat, may produce.
fn typed() -> impl Strategy<Value = String> {
    let piece = prop::sample::select(vec![
        "1", "2.5", "0", "e", "e5", "-", "−", "+", "*", "/", "(", ")", "(", ")", ",", ".", " ",
        "mm", "in", "°", "rad", "1e308", "💥", "\u{301}", "\0", "㎜", "٣",
    ]);
    prop::collection::vec(piece, 0..24).prop_map(|pieces| pieces.concat())
}

proptest! {
    #[test]
    fn any_text_is_a_finite_number_or_an_error(
        text in prop_oneof![
            typed(),
            any_text(0..24),
        ],
        unit in prop::sample::select(vec![Plain, Millimetre, Metre, Degree, Radian]),
    ) {
        match parse(&text, unit) {
            Ok(value) => prop_assert!(value.is_finite()),
            Err(error) => prop_assert!(error.to_string().contains("expected")),
        }
    }

    /// What a field shows can be typed back into it.
    #[test]
    fn any_number_written_is_read_back_to_the_bit(value in any::<f64>()) {
        prop_assume!(value.is_finite());
        for text in [trackwright_geometry::number::shortest(value), format!("{value:?} mm")] {
            prop_assert_eq!(parse(&text, Millimetre).unwrap().to_bits(), value.to_bits());
        }
    }
}
