//! What `optimize` takes as text: numbers of sensors, kinds of them, figures, bounds.

use crate::cli::numbers::{length_above_zero, zero_or_more};
use std::ops::RangeInclusive;
use trackwright_optimization::SensorChoice;
use trackwright_project::MOST_SENSORS;
use trackwright_simulation::{Coil, METRICS, Metric};

/// How far something may be moved and turned, or is off: mm and degrees.
pub fn bounds(text: &str) -> Result<(f64, f64), String> {
    let expected = "expected mm and degrees with a comma, each zero or more";
    let (mm, deg) = text.split_once(',').ok_or(expected)?;
    let [mm, deg] = [mm, deg].map(|number| zero_or_more(number.trim()));
    match (mm, deg) {
        (Ok(mm), Ok(deg @ 0.0..=180.0)) => Ok((mm, deg)),
        (Ok(_), Ok(deg)) => Err(format!("found {deg} degrees, expected at most 180")),
        _ => Err(expected.to_owned()),
    }
}

pub fn sensors(text: &str) -> Result<RangeInclusive<usize>, String> {
    let expected = || {
        format!("expected a number from 1 to {MOST_SENSORS}, or two with - between, least first")
    };
    let (least, most) = text.split_once('-').unwrap_or((text, text));
    let [least, most] = [least, most].map(|number| number.trim().parse::<usize>());
    match (least, most) {
        (Ok(least @ 1..), Ok(most @ ..=MOST_SENSORS)) if least <= most => Ok(least..=most),
        _ => Err(expected()),
    }
}

pub fn kind(text: &str) -> Result<SensorChoice, String> {
    let expected = "expected DOF:COST or DOF:COST:DIAMETERxLENGTH, such as 5:120:0.8x9";
    let mut parts = text.split(':');
    let degrees_of_freedom = match parts.next() {
        Some("5") => 5,
        Some("6") => 6,
        _ => return Err(format!("{expected}, with 5 or 6 degrees of freedom")),
    };
    let cost = zero_or_more(parts.next().ok_or(expected)?).map_err(|why| format!("cost: {why}"))?;
    let coil = parts.next().map(|size| {
        let (diameter, length) = size.split_once('x').ok_or(expected)?;
        let [diameter_mm, length_mm] = [diameter, length].map(length_above_zero);
        let of_coil = |why| format!("coil: {why}");
        Ok::<Coil, String>(Coil {
            diameter_mm: diameter_mm.map_err(of_coil)?,
            length_mm: length_mm.map_err(of_coil)?,
        })
    });
    match parts.next() {
        None => Ok(SensorChoice { degrees_of_freedom, coil: coil.transpose()?, cost }),
        Some(_) => Err(expected.to_owned()),
    }
}

pub fn metric(name: &str) -> Result<Metric, String> {
    let known = || METRICS.iter().map(|metric| metric.name()).collect::<Vec<_>>().join(", ");
    Metric::named(name).ok_or_else(|| format!("expected one of {}", known()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensors_are_one_number_or_two() {
        assert_eq!(sensors("3"), Ok(3..=3));
        assert_eq!(sensors("2-4"), Ok(2..=4));
        for refused in ["0", "0-3", "4-2", "2-33", "", "-3", "2-", "two", "2-3-4"] {
            assert!(sensors(refused).unwrap_err().starts_with("expected a number from 1"));
        }
    }

    #[test]
    fn kinds_have_a_cost_and_perhaps_a_coil() {
        let coil = Coil { diameter_mm: 0.8, length_mm: 9.0 };
        let expected = SensorChoice { degrees_of_freedom: 5, coil: Some(coil), cost: 120.0 };
        assert_eq!(kind("5:120:0.8x9"), Ok(expected));
        let expected = SensorChoice { degrees_of_freedom: 6, coil: None, cost: 0.0 };
        assert_eq!(kind("6:0"), Ok(expected));
        for refused in ["5", "4:1", "5:-1", "5:1:0.8", "5:1:0x9", "5:1:0.8x9:2", "5:1e9"] {
            assert!(kind(refused).is_err(), "{refused}");
        }
    }

    #[test]
    fn bounds_are_two_numbers_from_zero() {
        assert_eq!(bounds("50, 10"), Ok((50.0, 10.0)));
        assert_eq!(bounds("0,0"), Ok((0.0, 0.0)));
        for refused in ["50", "-1,5", "1,-5", "1,181", "1,2,3", "a,b", "inf,1"] {
            assert!(bounds(refused).is_err(), "{refused}");
        }
    }
}
