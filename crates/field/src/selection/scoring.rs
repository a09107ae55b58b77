//! Scores of held-out residuals, whatever kind of model left them: per fold, over all, and paired.

use crate::least_squares::VALUES;
use std::iter::Sum;

/// What a model left of a row that it was not fitted to: X, Y, Z in mm, Rx, Ry, Rz in radians.
pub type Residual = [f64; VALUES];

/// What a candidate leaves of rows that it has not seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scores {
    pub position_rms_mm: f64,
    pub position_max_mm: f64,
    /// `None` where orientations were not measured.
    pub angle_rms_rad: Option<f64>,
}

/// Sums over the rows of one fold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FoldSums {
    pub rows: usize,
    pub position_squares_mm2: f64,
    pub position_max_square_mm2: f64,
    pub rotation_squares_rad2: f64,
}

/// How a candidate did in one set of folds.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOutScores {
    pub overall: Scores,
    /// In the order of the folds, so that two candidates can be compared fold by fold.
    pub by_fold: Vec<FoldSums>,
}

/// The difference of two candidates' mean squares, paired by fold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairedDifference {
    /// Mean over the folds of the first candidate's mean square less the second's.
    pub mean: f64,
    /// Infinite where fewer than two folds have rows.
    pub std_error: f64,
}

impl FoldSums {
    /// Sums of one row.
    pub fn of(residual: &Residual) -> Self {
        let [x, y, z, rx, ry, rz] = residual.map(|value| value * value);
        let position = x + y + z;
        Self {
            rows: 1,
            position_squares_mm2: position,
            position_max_square_mm2: position,
            rotation_squares_rad2: rx + ry + rz,
        }
    }

    /// Adds the rows of other sums.
    pub fn add(&mut self, other: &Self) {
        self.rows += other.rows;
        self.position_squares_mm2 += other.position_squares_mm2;
        self.position_max_square_mm2 =
            self.position_max_square_mm2.max(other.position_max_square_mm2);
        self.rotation_squares_rad2 += other.rotation_squares_rad2;
    }

    /// Mean square of the position residuals, mm².
    pub fn position_mean_square_mm2(&self) -> f64 {
        self.position_squares_mm2 / self.rows as f64
    }

    /// Mean square of the rotation residuals, rad².
    pub fn rotation_mean_square_rad2(&self) -> f64 {
        self.rotation_squares_rad2 / self.rows as f64
    }
}

impl Sum for FoldSums {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        let mut all = Self::default();
        parts.for_each(|part| all.add(&part));
        all
    }
}

impl HeldOutScores {
    /// Scores over all folds from the sums of each.
    pub fn of_sums(by_fold: Vec<FoldSums>, has_rotations: bool) -> Self {
        let all: FoldSums = by_fold.iter().copied().sum();
        Self {
            overall: Scores {
                position_rms_mm: all.position_mean_square_mm2().sqrt(),
                position_max_mm: all.position_max_square_mm2.sqrt(),
                angle_rms_rad: has_rotations.then(|| all.rotation_mean_square_rad2().sqrt()),
            },
            by_fold,
        }
    }

    /// This candidate's position mean squares less another's in the same folds, mm².
    pub fn position_difference(&self, other: &Self) -> PairedDifference {
        self.difference(other, FoldSums::position_mean_square_mm2)
    }

    /// This candidate's rotation mean squares less another's in the same folds, rad².
    pub fn rotation_difference(&self, other: &Self) -> PairedDifference {
        self.difference(other, FoldSums::rotation_mean_square_rad2)
    }

    fn difference(&self, other: &Self, mean_square: fn(&FoldSums) -> f64) -> PairedDifference {
        let pairs = self.by_fold.iter().zip(&other.by_fold);
        let differences: Vec<f64> = pairs
            .filter(|(a, b)| a.rows > 0 && b.rows > 0)
            .map(|(a, b)| mean_square(a) - mean_square(b))
            .collect();
        let count = differences.len() as f64;
        let mean = differences.iter().sum::<f64>() / count;
        let squares: f64 = differences.iter().map(|d| (d - mean).powi(2)).sum();
        PairedDifference {
            mean,
            std_error: match differences.len() {
                0 | 1 => f64::INFINITY,
                _ => (squares / (count - 1.0) / count).sqrt(),
            },
        }
    }
}

/// Scores of residuals, one for each row of the table.
#[cfg(test)]
pub(super) fn of_residuals(residuals: &[Residual], folds: &super::folds::Folds) -> HeldOutScores {
    let of_rows = |rows: &Vec<usize>| rows.iter().map(|&row| FoldSums::of(&residuals[row])).sum();
    let by_fold = folds.rows.iter().map(of_rows);
    HeldOutScores::of_sums(by_fold.collect(), true)
}

#[cfg(test)]
mod tests {
    use super::super::folds::Folds;
    use super::*;

    fn scores(values: &[f64], folds: &Folds) -> HeldOutScores {
        let residuals: Vec<Residual> = values.iter().map(|&v| [v, 0.0, 0.0, 0.0, v, 0.0]).collect();
        of_residuals(&residuals, folds)
    }

    #[test]
    fn scores_are_root_mean_squares_and_the_largest() {
        let folds = Folds { rows: vec![vec![0, 2], vec![1, 3]] };
        let found = scores(&[3.0, 0.0, 4.0, -5.0], &folds);
        let rms = (50.0_f64 / 4.0).sqrt();
        assert!((found.overall.position_rms_mm - rms).abs() < 1e-15);
        assert!((found.overall.angle_rms_rad.unwrap() - rms).abs() < 1e-15);
        assert_eq!(found.overall.position_max_mm, 5.0);
        assert_eq!(found.by_fold[0].position_squares_mm2, 25.0);
        assert_eq!(found.by_fold[1].rows, 2);
    }

    #[test]
    fn pairing_takes_out_what_folds_have_in_common() {
        // Folds differ by a factor of hundred, the candidates by 1 mm² in each.
        let folds = Folds { rows: vec![vec![0], vec![1], vec![2]] };
        let a = scores(&[1.0, 10.0, 100.0], &folds);
        let squares = [2.0_f64, 101.0, 10_001.0].map(f64::sqrt);
        let difference = scores(&squares, &folds).position_difference(&a);
        assert!((difference.mean - 1.0).abs() < 1e-9, "{difference:?}");
        assert!(difference.std_error < 1e-9, "{difference:?}");
    }

    #[test]
    fn one_fold_has_no_noise_to_judge_by() {
        let folds = Folds { rows: vec![vec![0, 1], vec![]] };
        let a = scores(&[1.0, 1.0], &folds);
        let b = scores(&[2.0, 2.0], &folds);
        assert_eq!(a.rotation_difference(&b).std_error, f64::INFINITY);
    }
}
