//! Which values the numbers of a plan have at each of its points.
//!
//! A point's values depend on its number alone, so that any worker can compute any of them.

use sobol::Sobol;
use sobol::params::JoeKuoD6;
use trackwright_formats::number_path::NumberPath;
use trackwright_formats::sweep_plan::{SampledRange, Variation};

/// Bits of a Sobol sequence: it does not repeat within a sweep.
const SOBOL_BITS: usize = 40;

/// Rounds of the permutation of a Latin hypercube. Four make a permutation of a half's bits that no
/// statistic of a few dimensions can separate from a random one (Luby and Rackoff 1988).
const ROUNDS: u64 = 4;

/// The points of a plan.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    groups: Vec<Group>,
    count: u64,
}

#[derive(Clone, Debug)]
struct Group {
    variation: Variation,
    count: u64,
    seed: u64,
    /// Of a Sobol sequence, an axis each.
    directions: Vec<Vec<u64>>,
}

impl Points {
    /// The points of variations whose number was checked.
    pub fn new(vary: &[Variation], seed: u64) -> Self {
        let group = |(index, variation): (usize, &Variation)| Group {
            count: variation.count() as u64,
            seed: mixed(seed, index as u64),
            directions: match variation {
                Variation::Sobol { ranges, .. } => Sobol::<f64>::init_direction_vals(
                    ranges.len(),
                    SOBOL_BITS,
                    &JoeKuoD6::minimal(),
                ),
                _ => Vec::new(),
            },
            variation: variation.clone(),
        };
        let groups: Vec<Group> = vary.iter().enumerate().map(group).collect();
        Self { count: groups.iter().map(|group| group.count).product(), groups }
    }

    pub fn count(&self) -> u64 {
        self.count
    }

    /// The values at a point, in the order of [`SweepPlan::paths`](trackwright_formats::sweep_plan::SweepPlan::paths).
    pub fn values(&self, point: u64) -> Vec<f64> {
        let mut rest = point;
        let mut each: Vec<Vec<f64>> = self
            .groups
            .iter()
            .rev()
            .map(|group| {
                let of_group = rest % group.count;
                rest /= group.count;
                group.values(of_group)
            })
            .collect();
        each.reverse();
        each.concat()
    }
}

impl Group {
    fn values(&self, point: u64) -> Vec<f64> {
        match &self.variation {
            Variation::Grid(axes) => {
                let mut rest = point;
                let mut values: Vec<f64> = axes
                    .iter()
                    .rev()
                    .map(|axis| {
                        let count = axis.values.count();
                        let value = axis.values.get(rest % count);
                        rest /= count;
                        value
                    })
                    .collect();
                values.reverse();
                values
            }
            Variation::Sobol { ranges, .. } => {
                let gray = point ^ point >> 1;
                let of_axis = |(axis, range): (usize, &SampledRange)| {
                    let directions = self.directions[axis].iter().enumerate();
                    let bits = directions.filter(|(k, _)| gray >> k & 1 == 1);
                    let sum = bits.fold(0, |sum, (_, direction)| sum ^ direction);
                    let shift = mixed(self.seed, axis as u64);
                    at(range, unit(sum.wrapping_add(shift)))
                };
                ranges.iter().enumerate().map(of_axis).collect()
            }
            Variation::LatinHypercube { count, ranges } => {
                let of_axis = |(axis, range): (usize, &SampledRange)| {
                    let key = mixed(self.seed, axis as u64);
                    let within = unit(mixed(mixed(key, ROUNDS), point));
                    at(range, (permuted(point, *count, key) as f64 + within) / *count as f64)
                };
                ranges.iter().enumerate().map(of_axis).collect()
            }
        }
    }
}

fn at(range: &SampledRange, part: f64) -> f64 {
    range.from * (1.0 - part) + range.to * part
}

/// A number from 0 to below 1 of the highest 53 bits.
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// A number that another one and a key determine and that looks random: the finaliser of SplitMix64 (Steele, Lea
/// and Flood 2014).
fn mixed(key: u64, value: u64) -> u64 {
    let mut z = key.wrapping_add(value.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// A permutation of the numbers below `count`: a Feistel network over as many bits as they have, again
/// where it leads beyond them.
fn permuted(index: u64, count: u64, key: u64) -> u64 {
    let bits = (64 - count.saturating_sub(1).leading_zeros()).max(2);
    let half = bits.div_ceil(2);
    let mask = (1_u64 << half) - 1;
    let mut value = index;
    loop {
        let (mut left, mut right) = (value >> half, value & mask);
        for round in 0..ROUNDS {
            (left, right) = (right, left ^ mixed(mixed(key, round), right) & mask);
        }
        value = left << half | right;
        if value < count {
            return value;
        }
    }
}

/// The column of each number.
pub(crate) fn columns<'a>(
    paths: impl Iterator<Item = &'a NumberPath>,
) -> Vec<(String, &'static str)> {
    paths.map(|path| (path.to_string(), path.unit())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_formats::sweep_plan;

    fn points(vary: &str, seed: u64) -> Points {
        let text = format!("(version: 1, designs: [\"a\"], vary: [{vary}])");
        Points::new(&sweep_plan::parse(text.as_bytes()).unwrap().vary, seed)
    }

    fn all(points: &Points) -> Vec<Vec<f64>> {
        (0..points.count()).map(|point| points.values(point)).collect()
    }

    #[test]
    fn a_grid_has_every_pair_once_the_last_fastest() {
        let grid = points(
            r#"Grid([(path: "a", values: List([5, 7])), (path: "b", values: Range(from: 0, to: 1, count: 3))]),
               Grid([(path: "c", values: List([1, 2]))])"#,
            1,
        );
        let found = all(&grid);
        assert_eq!(found.len(), 12);
        assert_eq!(found[..3], [[5.0, 0.0, 1.0], [5.0, 0.0, 2.0], [5.0, 0.5, 1.0]]);
        assert_eq!(found[11], [7.0, 1.0, 2.0]);
    }

    #[test]
    fn a_latin_hypercube_has_one_point_in_each_part() {
        for count in [1_u64, 2, 3, 64, 1000] {
            let found = all(&points(
                &format!(
                    r#"LatinHypercube(count: {count}, ranges: [(path: "a", from: -1, to: 1), (path: "b", from: 0, to: 1)])"#
                ),
                9,
            ));
            for axis in 0..2 {
                let part = |v: f64| if axis == 0 { (v + 1.0) / 2.0 } else { v };
                let mut cells: Vec<u64> =
                    found.iter().map(|values| (part(values[axis]) * count as f64) as u64).collect();
                cells.sort_unstable();
                assert_eq!(cells, (0..count).collect::<Vec<_>>());
            }
            // The axes are permuted each in its own way.
            if count == 1000 {
                let mean = found.iter().map(|v| v[0] * (v[1] - 0.5)).sum::<f64>() / 1000.0;
                // Standard error of the mean of a product of independent deviates.
                let error = (1.0 / 3.0_f64 / 12.0 / 1000.0).sqrt();
                assert!(mean.abs() < 4.0 * error, "{mean}");
            }
        }
    }

    #[test]
    fn a_shifted_sobol_sequence_stays_even() {
        let sobol = points(
            r#"Sobol(count: 4096, ranges: [(path: "a", from: 0, to: 1), (path: "b", from: 0, to: 1)])"#,
            3,
        );
        // A digital net modulo one has in each of 16 by 16 squares 16 points and 2 by 2 at the borders
        // that the shift cuts.
        let mut squares = [[0_u32; 16]; 16];
        for values in all(&sobol) {
            squares[(values[0] * 16.0) as usize][(values[1] * 16.0) as usize] += 1;
        }
        let counts = squares.iter().flatten();
        assert!(counts.clone().all(|count| (10..=22).contains(count)), "{squares:?}");
        // Without the shift it is the crate's own sequence.
        let plain: Vec<Vec<f64>> =
            Sobol::<f64>::new_with_resolution(2, &JoeKuoD6::minimal(), Some(SOBOL_BITS))
                .take(50)
                .collect();
        let shift = [0, 1].map(|axis| unit(mixed(sobol.groups[0].seed, axis)));
        for (point, plain) in plain.iter().enumerate() {
            for (axis, value) in sobol.values(point as u64).iter().enumerate() {
                let expected = (plain[axis] + shift[axis]).fract();
                assert!((value - expected).abs() < 1e-12, "{point} {axis}");
            }
        }
    }

    #[test]
    fn another_seed_gives_other_samples() {
        let text = r#"LatinHypercube(count: 8, ranges: [(path: "a", from: 0, to: 1)])"#;
        assert_ne!(all(&points(text, 1)), all(&points(text, 2)));
        assert_eq!(all(&points(text, 1)), all(&points(text, 1)));
    }
}
