//! Rows that two tables of measurements share: a model is not judged by what it was fitted to.

use std::collections::HashMap;
use trackwright_field::samples::{Sample, SampleSet};

/// How far the numbers of equal rows may differ, mm or no unit: what writing them anew may change.
const TOLERANCE: f64 = 1e-9;

/// Rotation errors are differences of quaternions, each off by as much as their numbers.
const ROTATION_TOLERANCE_RAD: f64 = 1e-8;

/// Cells of positions: far larger than the tolerance, far smaller than distances of readings.
const CELL_MM: f64 = 1e-5;

type Cell = [i64; 6];

/// How many rows of the second table are rows of the first, in any order. Readings that differ only
/// by round-off are the same reading: no tracker repeats itself to 1e-9 mm.
pub fn shared_rows(fitted: &SampleSet, judged: &SampleSet) -> usize {
    let mut cells: HashMap<Cell, Vec<&Sample>> = HashMap::new();
    for sample in &fitted.samples {
        let same = cells.entry(key(sample).map(cell)).or_default();
        // A thousand equal rows are found by one of them.
        if !same.iter().any(|other| is_same(other, sample)) {
            same.push(sample);
        }
    }
    let is_shared = |sample: &&Sample| {
        near(&key(sample)).iter().any(|cell| {
            let same = cells.get(cell).into_iter().flatten();
            same.into_iter().any(|other| is_same(other, sample))
        })
    };
    judged.samples.iter().filter(is_shared).count()
}

/// What a row is found by: its position and its position error.
fn key(sample: &Sample) -> [f64; 6] {
    let (p, e) = (&sample.position_mm, &sample.error.position_mm);
    [p.x, p.y, p.z, e.x, e.y, e.z]
}

fn cell(value: f64) -> i64 {
    (value / CELL_MM).floor() as i64
}

/// The cells that hold what is within the tolerance: one, or two a number at a border.
fn near(key: &[f64; 6]) -> Vec<Cell> {
    let mut cells = vec![[0; 6]];
    for (i, value) in key.iter().enumerate() {
        let ends = [cell(value - 2.0 * TOLERANCE), cell(value + 2.0 * TOLERANCE)];
        let mut next = Vec::new();
        for mut found in cells {
            found[i] = ends[0];
            next.push(found);
            if ends[1] != ends[0] {
                found[i] = ends[1];
                next.push(found);
            }
        }
        cells = next;
    }
    cells
}

fn is_same(a: &Sample, b: &Sample) -> bool {
    let near = |a: &[f64], b: &[f64], tolerance: f64| {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance)
    };
    let position = [&a.position_mm.coords, &b.position_mm.coords].map(|v| v.as_slice());
    let error = [&a.error.position_mm, &b.error.position_mm].map(|v| v.as_slice());
    let turn = [&a.error.rotation_rad, &b.error.rotation_rad].map(|v| v.as_slice());
    near(position[0], position[1], TOLERANCE)
        // A difference of two numbers.
        && near(error[0], error[1], 2.0 * TOLERANCE)
        && near(turn[0], turn[1], ROTATION_TOLERANCE_RAD)
        && near(a.axis.as_slice(), b.axis.as_slice(), ROTATION_TOLERANCE_RAD)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Unit, Vector3};
    use trackwright_field::samples::PoseError;

    /// Row `i` of a table; `seed` makes another table.
    fn row(i: usize, seed: f64) -> Sample {
        let at = |step: f64| ((i as f64 + seed) * step).fract() * 200.0 - 100.0;
        let position_mm = Point3::new(at(0.819_172_5), at(0.671_043_6), at(0.549_700_4));
        let axis = Unit::new_normalize(Vector3::new(at(0.3), at(0.7), at(0.9)));
        let error = PoseError {
            position_mm: Vector3::new(at(0.11), at(0.13), at(0.17)) * 0.01,
            rotation_rad: Vector3::new(at(0.19), at(0.23), at(0.29)) * 1e-4,
        };
        Sample::new(position_mm, axis, error)
    }

    fn set(samples: Vec<Sample>) -> SampleSet {
        SampleSet { samples, has_rotations: true, ambiguous: 0 }
    }

    fn table(rows: usize, seed: f64) -> SampleSet {
        set((0..rows).map(|i| row(i, seed)).collect())
    }

    #[test]
    fn a_table_shares_all_rows_with_itself_in_any_order() {
        let mut reversed = table(300, 0.5);
        reversed.samples.reverse();
        assert_eq!(shared_rows(&table(300, 0.5), &reversed), 300);
        assert_eq!(shared_rows(&table(100, 0.5), &reversed), 100);
    }

    #[test]
    fn rows_written_anew_are_the_same_rows() {
        let mut written = table(300, 0.5);
        for (i, sample) in written.samples.iter_mut().enumerate() {
            let off = if i % 2 == 0 { 0.9e-9 } else { -0.9e-9 };
            sample.position_mm += Vector3::repeat(off);
            sample.error.position_mm -= Vector3::repeat(off);
            sample.error.rotation_rad += Vector3::repeat(off);
        }
        assert_eq!(shared_rows(&table(300, 0.5), &written), 300);
        // A border of cells runs between what is equal to 1e-9.
        let at = |x: f64| {
            let mut sample = row(0, 0.5);
            sample.position_mm.x = x;
            set(vec![sample])
        };
        assert_eq!(shared_rows(&at(CELL_MM - 4e-10), &at(CELL_MM + 4e-10)), 1);
    }

    #[test]
    fn other_readings_are_not_shared() {
        assert_eq!(shared_rows(&table(300, 0.5), &table(300, 0.25)), 0);
        assert_eq!(shared_rows(&table(0, 0.0), &table(10, 0.0)), 0);
        // The same pose read again.
        let mut again = table(300, 0.5);
        for sample in &mut again.samples {
            sample.error.position_mm.x += 1e-3;
        }
        assert_eq!(shared_rows(&table(300, 0.5), &again), 0);
        let mut turned = table(300, 0.5);
        for sample in &mut turned.samples {
            sample.error.rotation_rad.y += 1e-5;
        }
        assert_eq!(shared_rows(&table(300, 0.5), &turned), 0);
    }

    #[test]
    fn rows_at_one_place_are_counted_each() {
        let all = set(vec![row(3, 0.5); 5_000]);
        assert_eq!(shared_rows(&all, &all), 5_000);
    }
}
