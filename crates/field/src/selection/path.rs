//! Finds rows that were recorded along a path. A row held out there is between those before and after it, which
//! is no test of poses beside the path.

use crate::samples::{Sample, SampleSet};
use nalgebra::{Vector3, Vector6};

/// Pieces of a path that are held out as wholes: some for every fold, each far longer than a step.
const PIECES: usize = 40;

/// Rows that are compared with all others; of more, so many at equal distances in the table.
const COMPARED: usize = 300;

/// Sensors whose rows may come by turns.
const MOST_SENSORS: usize = 4;

/// Part of the table within which rows count as neighbours in time.
const NEAR_IN_TIME: f64 = 0.02;

/// How much nearer the next row has to be than any row of another time, in the median. By chance it is
/// farther away, in a grid measured line by line as far; along a path that meets itself seldom it is nearer by
/// as many steps as count as neighbours.
const MIN_NEARNESS: f64 = 3.0;

/// The piece of each row where the rows, in their order, are a path in place and axis.
pub fn pieces(set: &SampleSet) -> Option<Vec<usize>> {
    let rows = set.samples.len();
    let near = (NEAR_IN_TIME * rows as f64).ceil() as usize;
    if rows < 2 * PIECES {
        return None;
    }
    let poses = scaled(set);
    let compared = COMPARED.min(rows);
    let mut nearness: Vec<f64> = (0..compared)
        .map(|k| {
            let row = k * rows / compared;
            let to = |other: usize| (poses[other] - poses[row]).norm();
            let step_of = |sensors: usize| {
                let next = Some(row + sensors).filter(|next| *next < rows);
                let both = [row.checked_sub(sensors), next].into_iter().flatten();
                both.map(to).fold(0.0, f64::max)
            };
            let step = (1..=MOST_SENSORS).map(step_of).fold(f64::INFINITY, f64::min);
            let others = (0..rows).filter(|other| other.abs_diff(row) > near);
            let nearest = others.map(to).fold(f64::INFINITY, f64::min);
            // Readings of one pose are no path; whether they depend on each other is for [`super::places`].
            if step > 0.0 { nearest / step } else { 0.0 }
        })
        .collect();
    let (_, median, _) = nearness.select_nth_unstable_by(compared / 2, f64::total_cmp);
    (*median >= MIN_NEARNESS).then(|| (0..rows).map(|row| row * PIECES / rows).collect())
}

/// Place and axis of each row, each with a mean square of 1 around its mean.
fn scaled(set: &SampleSet) -> Vec<Vector6<f64>> {
    let part = |of: fn(&Sample) -> Vector3<f64>| -> Vec<Vector3<f64>> {
        let values: Vec<_> = set.samples.iter().map(of).collect();
        let mean = values.iter().sum::<Vector3<f64>>() / values.len() as f64;
        let square = values.iter().map(|v| (v - mean).norm_squared()).sum::<f64>();
        let by = (values.len() as f64 / square).sqrt();
        let by = if by.is_finite() { by } else { 0.0 };
        values.iter().map(|v| (v - mean) * by).collect()
    };
    let places = part(|s| s.position_mm.coords);
    let axes = part(|s| s.axis.into_inner());
    let both = places.iter().zip(&axes).map(|(p, n)| {
        let n = if set.has_rotations { *n } else { Vector3::zeros() };
        Vector6::new(p.x, p.y, p.z, n.x, n.y, n.z)
    });
    both.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::PoseError;
    use nalgebra::Unit;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// Rows at these places, with these axes.
    fn set(rows: usize, mut pose: impl FnMut(usize) -> (Vector3<f64>, Vector3<f64>)) -> SampleSet {
        let sample = |row| {
            let (place, axis) = pose(row);
            Sample::new(place.into(), Unit::new_normalize(axis), PoseError::default())
        };
        SampleSet { samples: (0..rows).map(sample).collect(), has_rotations: true, ambiguous: 0 }
    }

    /// A hand that sweeps and turns, with some tremor.
    fn hand(rows: usize, tremor_mm: f64) -> SampleSet {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        set(rows, |row| {
            let t = 20.0 * row as f64 / rows as f64;
            let tremor = Vector3::from_fn(|_, _| StandardNormal.sample(&mut random));
            let place = Vector3::new(t.sin(), (1.3 * t).cos(), (0.7 * t).sin()) * 100.0;
            let axis = Vector3::new((0.9 * t).sin(), (1.1 * t).cos(), 1.0);
            (place + tremor_mm * tremor, axis)
        })
    }

    #[test]
    fn a_path_comes_in_pieces_of_its_rows() {
        for rows in [200, 1_000, 5_000] {
            let found = pieces(&hand(rows, 0.2)).unwrap();
            assert!(found.is_sorted());
            for piece in 0..PIECES {
                let count = found.iter().filter(|own| **own == piece).count();
                assert!(count.abs_diff(rows / PIECES) <= 1, "{piece}: {count} of {rows}");
            }
        }
    }

    #[test]
    fn sensors_of_a_moving_body_come_by_turns() {
        let of_one = hand(300, 0.2);
        for sensors in [2, 3, 4] {
            let rows = of_one.samples.iter().flat_map(|sample| {
                (0..sensors).map(|k| {
                    let turned = Vector3::new(sample.axis.y, -sample.axis.z, sample.axis.x);
                    let beside = Vector3::x() * 40.0 * f64::from(k);
                    let axis = if k == 0 { sample.axis } else { Unit::new_normalize(turned) };
                    Sample { position_mm: sample.position_mm + beside, axis, ..*sample }
                })
            });
            let set = SampleSet { samples: rows.collect(), ..of_one.clone() };
            assert!(pieces(&set).is_some(), "{sensors}");
        }
    }

    #[test]
    fn rows_in_no_order_grids_and_repeats_are_no_path() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let mut normal =
            || -> Vector3<f64> { Vector3::from_fn(|_, _| StandardNormal.sample(&mut random)) };
        assert_eq!(pieces(&set(500, |_| (100.0 * normal(), normal()))), None);
        // Line by line, to and fro or not, with a turn of the sensor at each place or one for all.
        for (is_serpentine, axes) in [(false, 1), (true, 1), (false, 6), (true, 6)] {
            let grid = set(8 * 8 * 8 * axes, |row| {
                let (k, turn) = (row / axes, (row % axes) as f64);
                let back = |k: usize, is_odd: bool| if is_serpentine && is_odd { 7 - k } else { k };
                let (x, y, z) = (k % 8, k / 8 % 8, k / 64);
                let place = Vector3::new(back(x, y % 2 == 1), back(y, z % 2 == 1), z);
                (place.map(|k| 40.0 * k as f64), Vector3::new(turn.cos(), turn.sin(), 0.3))
            });
            assert_eq!(pieces(&grid), None, "{is_serpentine}, {axes}");
        }
        let of_ten = set(1_000, |row| {
            let t = (row / 10) as f64;
            (Vector3::new(t.sin(), (1.7 * t).cos(), t.cos()) * 100.0, Vector3::z())
        });
        assert_eq!(pieces(&of_ten), None);
    }

    #[test]
    fn a_hand_that_trembles_as_far_as_it_moves_is_no_path() {
        // 1,000 rows, 3 mm apart.
        assert!(pieces(&hand(1_000, 1.0)).is_some());
        assert_eq!(pieces(&hand(1_000, 30.0)), None);
    }
}
