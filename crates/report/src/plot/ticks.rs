//! Where an axis begins and ends, and which of its values are written beside it.

use super::Scale;
use trackwright_geometry::number::round_above;

/// Part of the data's extent that is left free at either end of an axis.
const MARGIN: f64 = 0.05;

/// Least extent of a logarithmic axis: two of 1, 2, 5 lie within any so many decades.
const MIN_DECADES: f64 = 0.8;

/// Decades that a logarithmic axis may have and still be labelled at 1, 2 and 5.
const MAX_DECADES_IN_THREE: f64 = 1.7;

/// Decades beyond which lines at 2 to 9 would be a grey mass.
const MAX_DECADES_WITH_MINOR: f64 = 6.0;

/// Decades from one label to the next beyond which those between get no line.
const MAX_UNLABELLED_DECADES: i32 = 5;

/// A non-negative quantity starts at zero where its least value is below this part of its largest.
const START_AT_ZERO: f64 = 0.4;

/// Two ticks lie within any extent of this many steps; smaller steps are tried up to then.
const MOST_TRIES: usize = 8;

/// Part of an axis that zero's own lane takes, and where in the axis zero then lies.
const ZERO_LANE: f64 = 0.09;
const ZERO_AT: f64 = 0.035;

/// An axis laid out: its ends, the values that are labelled, and those that only have a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Ticks {
    pub scale: Scale,
    pub min: f64,
    pub max: f64,
    pub labelled: Vec<(f64, String)>,
    pub minor: Vec<f64>,
    /// Part of the axis, from its beginning, that is zero's alone; 0 where nothing is zero.
    pub zero_lane: f64,
}

impl Ticks {
    /// An axis that holds all values, with about `wanted` labels.
    pub fn new(scale: Scale, values: impl IntoIterator<Item = f64>, wanted: usize) -> Self {
        let values: Vec<f64> = values.into_iter().filter(|&v| scale.holds(v)).collect();
        match scale {
            Scale::Linear => linear(&values, wanted),
            Scale::Logarithmic => logarithmic(&values, wanted),
            Scale::LogarithmicAndZero => {
                let (zeros, others): (Vec<f64>, Vec<f64>) = values.iter().partition(|&&v| v == 0.0);
                let mut ticks = logarithmic(&others, wanted);
                ticks.scale = scale;
                if !zeros.is_empty() {
                    ticks.zero_lane = ZERO_LANE;
                    ticks.labelled.insert(0, (0.0, "0".to_owned()));
                }
                ticks
            }
        }
    }

    /// Where a value lies, 0 at the axis' beginning and 1 at its end.
    pub fn part(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.min) / (self.max - self.min),
            _ if value == 0.0 => ZERO_AT,
            Scale::Logarithmic | Scale::LogarithmicAndZero => {
                let (low, high) = (self.min.log10(), self.max.log10());
                let part = (value.log10() - low) / (high - low);
                self.zero_lane + (1.0 - self.zero_lane) * part
            }
        }
    }
}

fn extent(values: &[f64]) -> Option<(f64, f64)> {
    let min = values.iter().copied().reduce(f64::min)?;
    let max = values.iter().copied().reduce(f64::max)?;
    Some((min, max))
}

fn linear(values: &[f64], wanted: usize) -> Ticks {
    let (low, high) = extent(values).unwrap_or((0.0, 1.0));
    let span = high - low;
    let pad = if span > f64::EPSILON * high.abs().max(low.abs()) {
        MARGIN * span
    } else {
        // A single value, with room around it.
        (0.5 * high.abs()).max(0.5)
    };
    let (mut min, max) = (low - pad, high + pad);
    if low >= 0.0 && (low < START_AT_ZERO * high || min < 0.0) {
        min = 0.0;
    }
    let counts_things = max - min >= 2.0 && values.iter().all(|v| v.fract() == 0.0);
    // One number alone gives no scale: steps are smaller until there are two.
    let mut ticks = wanted.max(1)..=wanted.max(1) + MOST_TRIES;
    let found = ticks.find_map(|wanted| {
        let step = nice_step((max - min) / wanted as f64, counts_things);
        let first = (min / step).ceil();
        let steps = (max / step).floor() - first;
        (steps >= 1.0).then_some((step, first, steps as usize))
    });
    let (step, first, count) = found.unwrap_or((max - min, min / (max - min), 1));
    let labelled =
        (0..=count).map(|i| (first + i as f64) * step).map(|v| (v, decimal(v, step))).collect();
    Ticks { scale: Scale::Linear, min, max, labelled, minor: Vec::new(), zero_lane: 0.0 }
}

/// A step of an axis: 1, 2 or 5 times a power of ten that is at least `rough`, and at least 1 on an
/// axis of whole numbers.
pub fn nice_step(rough: f64, is_whole: bool) -> f64 {
    round_above(rough).max(if is_whole { 1.0 } else { 0.0 })
}

fn logarithmic(values: &[f64], wanted: usize) -> Ticks {
    let (low, high) = extent(values).unwrap_or((1.0, 10.0));
    let (low, high) = (low.log10(), high.log10());
    let pad = (MARGIN * (high - low)).max((MIN_DECADES - (high - low)) / 2.0);
    // As far as numbers go.
    let (low, high) = ((low - pad).max(-323.0), (high + pad).min(f64::MAX.log10()));
    let decades = high - low;
    let (first, last) = (low.floor() as i32, high.floor() as i32);
    let within = |log: f64| (low - 1e-9..=high + 1e-9).contains(&log);
    let at = |multiple: f64, power: i32| multiple.log10() + f64::from(power);
    let mantissas: &[f64] = if decades <= MAX_DECADES_IN_THREE { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let stride = (decades / wanted.max(1) as f64).ceil().max(1.0) as i32;
    let chosen: Vec<(f64, i32)> = (first..=last)
        .filter(|power| power.rem_euclid(stride) == 0)
        .flat_map(|power| mantissas.iter().map(move |&m| (m, power)))
        .filter(|&(m, power)| within(at(m, power)))
        .collect();
    let is_plain = chosen.iter().all(|(_, power)| (-3..=4).contains(power));
    let labelled = chosen
        .iter()
        .map(|&(m, power)| {
            let label = if is_plain { plain(m, power) } else { scientific(m, power) };
            (10.0_f64.powf(at(m, power)), label)
        })
        .collect();
    let minor = (first..=last)
        .filter(|_| stride <= MAX_UNLABELLED_DECADES)
        .flat_map(|power| {
            let multiples = if decades <= MAX_DECADES_WITH_MINOR { 1..10 } else { 1..2 };
            multiples.map(move |m| (f64::from(m), power))
        })
        .filter(|&(m, power)| within(at(m, power)) && !chosen.contains(&(m, power)))
        .map(|(m, power)| 10.0_f64.powf(at(m, power)))
        .collect();
    Ticks {
        scale: Scale::Logarithmic,
        min: 10.0_f64.powf(low),
        max: 10.0_f64.powf(high),
        labelled,
        minor,
        zero_lane: 0.0,
    }
}

fn plain(multiple: f64, power: i32) -> String {
    let decimals = (-power).max(0) as usize;
    format!("{:.decimals$}", multiple * 10.0_f64.powi(power))
}

fn scientific(multiple: f64, power: i32) -> String {
    let digits: String = power
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            digit => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹']
                [digit.to_digit(10).unwrap_or(0) as usize],
        })
        .collect();
    if multiple == 1.0 { format!("10{digits}") } else { format!("{multiple}·10{digits}") }
}

/// A value of a linear axis with the decimals that its step needs.
fn decimal(value: f64, step: f64) -> String {
    let power = step.log10().floor();
    if value == 0.0 {
        return "0".to_owned();
    }
    if (-5.0..=5.0).contains(&power) && value.abs() < 1e9 {
        let decimals = (-power).max(0.0) as usize;
        return format!("{value:.decimals$}").replace('-', "−");
    }
    let own = value.abs().log10().floor();
    let decimals = (own - power).clamp(0.0, 15.0) as usize;
    let mantissa = format!("{:.decimals$}", value / 10.0_f64.powf(own)).replace('-', "−");
    format!("{mantissa}·{}", scientific(1.0, own as i32))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCALES: [Scale; 3] = [Scale::Linear, Scale::Logarithmic, Scale::LogarithmicAndZero];

    fn labels(ticks: &Ticks) -> Vec<&str> {
        ticks.labelled.iter().map(|(_, l)| l.as_str()).collect()
    }

    #[test]
    fn a_linear_axis_counts_in_ones_twos_and_fives() {
        let t = Ticks::new(Scale::Linear, [0.13, 0.2, 0.97], 6);
        assert_eq!(labels(&t), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        let t = Ticks::new(Scale::Linear, [-30.0, 41.0], 6);
        assert_eq!(labels(&t), ["−20", "0", "20", "40"]);
    }

    #[test]
    fn no_linear_axis_has_a_single_tick() {
        // Turns to either side on a chart that is narrow: steps of 100 would leave 0 alone.
        for reach in [1.0, 10.0, 30.0, 45.0, 50.0, 60.0, 90.0, 180.0] {
            for wanted in 1..12 {
                let t = Ticks::new(Scale::Linear, [-reach, reach], wanted);
                assert!(t.labelled.len() >= 2, "{reach} {wanted} {t:?}");
                let t = Ticks::new(Scale::Linear, [0.37 * reach, 0.41 * reach], wanted);
                assert!(t.labelled.len() >= 2, "{reach} {wanted} {t:?}");
            }
        }
    }

    #[test]
    fn whole_numbers_get_whole_ticks() {
        let t = Ticks::new(Scale::Linear, [1.0, 2.0, 3.0], 8);
        assert_eq!(labels(&t), ["0", "1", "2", "3"]);
    }

    #[test]
    fn logarithmic_labels_follow_the_decades() {
        let t = Ticks::new(Scale::Logarithmic, [2e-15, 3e-1], 6);
        assert!(labels(&t).contains(&"10⁻¹²"), "{t:?}");
        assert!(t.labelled.len() >= 3 && t.labelled.len() <= 6, "{t:?}");
        let t = Ticks::new(Scale::Logarithmic, [0.03, 0.6], 6);
        assert_eq!(labels(&t), ["0.05", "0.1", "0.2", "0.5"]);
    }

    #[test]
    fn every_axis_holds_its_values() {
        let cases: [&[f64]; 9] = [
            &[],
            &[3.3],
            &[0.0],
            &[-7.0],
            &[1e-300, 1e300],
            &[5.0, 5.0 + 1e-9],
            &[f64::MIN_POSITIVE, 1.0],
            &[-1e300, 1e300],
            &[f64::NAN, 1.0, f64::INFINITY],
        ];
        for values in cases {
            for scale in SCALES {
                let t = Ticks::new(scale, values.iter().copied(), 6);
                assert!(t.min < t.max && t.labelled.len() >= 2, "{values:?} {t:?}");
                assert!(t.labelled.len() <= 12, "{values:?} {t:?}");
                for &v in values.iter().filter(|&&v| scale.holds(v)) {
                    let part = t.part(v);
                    assert!((-1e-9..=1.0 + 1e-9).contains(&part), "{v} {t:?}");
                }
            }
        }
    }

    #[test]
    fn zero_has_a_lane_of_its_own() {
        let scale = Scale::LogarithmicAndZero;
        let with = Ticks::new(scale, [1e-3, 0.0, 10.0], 6);
        assert_eq!(with.labelled[0], (0.0, "0".to_owned()));
        assert!(with.part(0.0) < with.zero_lane && with.part(with.min) >= with.zero_lane);
        assert!(with.part(with.max) <= 1.0);
        let without = Ticks::new(scale, [1e-3, 10.0], 6);
        assert_eq!((without.zero_lane, without.part(without.min)), (0.0, 0.0));
    }

    #[test]
    fn ticks_far_from_zero_keep_their_digits() {
        let t = Ticks::new(Scale::Linear, [1.0, 1.0 + 4e-6], 6);
        let mut labels = labels(&t);
        labels.dedup();
        assert_eq!(labels.len(), t.labelled.len(), "{t:?}");
    }
}
