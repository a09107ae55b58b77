//! The noise of rows, and how a measurement counts that contradicts the others by more than that.

use super::rows::{POSITION_ROWS, Rows};
use trackwright_field::generator::reading::LEVER_MM;

/// Where Huber's loss becomes linear, in noise: twice the 90 % quantile of the length of 5 or 6 standard
/// normal components, as in the fit of harmonics.
fn limit(dof: usize) -> f64 {
    2.0 * if dof == 6 { 3.263 } else { 3.039 }
}

/// Median length of 2 and of 3 standard normal components.
const MEDIAN_LENGTH: [f64; 2] = [1.177_4, 1.538_2];

/// Standard deviation of a component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    pub position_mm: f64,
    pub rotation_rad: f64,
}

impl Noise {
    /// From what is left of rows in mm, of which `parameters` were fitted. By medians, so that a few
    /// measurements that are wrong do not count.
    pub(super) fn of(left_mm: &[f64], dof: usize, parameters: f64) -> Self {
        let rows = left_mm.len() as f64;
        let fitted = (rows / (rows - parameters).max(1.0)).sqrt();
        let std_dev = |from: usize, to: usize| {
            let length = |r: &[f64]| r[from..to].iter().map(|v| v * v).sum::<f64>().sqrt();
            let mut lengths: Vec<f64> = left_mm.chunks_exact(dof).map(length).collect();
            let middle = lengths.len() / 2;
            let (_, median, _) = lengths.select_nth_unstable_by(middle, f64::total_cmp);
            fitted * *median / MEDIAN_LENGTH[to - from - 2]
        };
        Self {
            position_mm: std_dev(0, POSITION_ROWS),
            rotation_rad: std_dev(POSITION_ROWS, dof) / LEVER_MM,
        }
    }

    /// The smaller of both.
    pub(super) fn min(&self, other: &Self) -> Self {
        Self {
            position_mm: self.position_mm.min(other.position_mm),
            rotation_rad: self.rotation_rad.min(other.rotation_rad),
        }
    }

    /// Of one of a measurement's rows.
    pub(super) fn of_row_mm(&self, row: usize) -> f64 {
        if row < POSITION_ROWS { self.position_mm } else { self.rotation_rad * LEVER_MM }
    }
}

/// Huber's loss of each measurement, of what is left in units of noise.
pub(super) fn losses(rows: &Rows, left: &[f64]) -> Vec<f64> {
    let limit = limit(rows.dof);
    let of_length = |length: f64| match length <= limit {
        true => length * length,
        false => (2.0 * length - limit) * limit,
    };
    let length = |r: &[f64]| r.iter().map(|v| v * v).sum::<f64>().sqrt();
    left.chunks_exact(rows.dof).map(|r| of_length(length(r))).collect()
}
