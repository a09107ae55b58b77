//! Round numbers for scale bars and colour bars.

pub use trackwright_geometry::magnification::round_below;

/// Round values from 0 to `max`, at most `count` steps apart.
pub fn ticks(max: f64, count: usize) -> Vec<f64> {
    if !(max.is_finite() && max > 0.0) {
        return vec![0.0];
    }
    let least = max / count.max(1) as f64;
    let below = round_below(least);
    let step = [1.0, 2.0, 2.5, 5.0, 10.0]
        .into_iter()
        .map(|factor| below * factor)
        .find(|step| *step >= least * (1.0 - 1e-12) && is_round(*step))
        .unwrap_or(below * 10.0);
    (0..=count).map(|k| k as f64 * step).take_while(|value| *value <= max * (1.0 + 1e-12)).collect()
}

/// Whether a number is 1, 2 or 5 times a power of ten.
fn is_round(value: f64) -> bool {
    (value / round_below(value) - 1.0).abs() < 1e-9
}

/// As many decimals as the step between ticks needs.
pub fn decimals(values: &[f64]) -> usize {
    let step = values.get(1).copied().unwrap_or(1.0);
    if step > 0.0 { (-(step.log10() + 1e-9).floor()).clamp(0.0, 6.0) as usize } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_numbers_are_1_2_or_5_times_a_power_of_ten() {
        for (limit, round) in
            [(7.3, 5.0), (1.0, 1.0), (1.99, 1.0), (260.0, 200.0), (0.034, 0.02), (1000.0, 1000.0)]
        {
            assert!((round_below(limit) / round - 1.0).abs() < 1e-12, "{limit}");
        }
    }

    #[test]
    fn ticks_begin_at_zero_and_stay_within_the_range() {
        let near = |a: &[f64], b: &[f64]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
        };
        assert!(near(&ticks(3.2, 4), &[0.0, 1.0, 2.0, 3.0]));
        assert!(near(&ticks(10.0, 5), &[0.0, 2.0, 4.0, 6.0, 8.0, 10.0]));
        assert!(near(&ticks(0.9, 4), &[0.0, 0.5]));
        assert_eq!(ticks(f64::NAN, 4), [0.0]);
    }

    #[test]
    fn a_step_of_a_half_needs_one_decimal() {
        assert_eq!(decimals(&[0.0, 0.5]), 1);
        assert_eq!(decimals(&[0.0, 1.0]), 0);
        assert_eq!(decimals(&[0.0, 0.02]), 2);
        assert_eq!(decimals(&[0.0, 20.0]), 0);
    }
}
