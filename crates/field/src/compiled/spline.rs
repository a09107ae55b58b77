//! Cubic B-splines along one axis of a box, over cells of equal length.
//!
//! Knots are `0, 0, 0, 0, 1/n, 2/n, …, 1, 1, 1, 1` (de Boor, *A Practical Guide to Splines*, 2001), so
//! that splines need no values outside the box; the `n + 3` coefficients follow from values at the
//! Greville abscissae, the means of three knots each.

use nalgebra::DMatrix;

/// Functions that are not zero at a place.
pub const LOCAL: usize = 4;

/// The splines along one axis; places are parts of the box's edge, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SplineAxis {
    cells: usize,
}

/// The functions that are not zero at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    /// Index of the first of them.
    pub first: usize,
    pub values: [f64; LOCAL],
}

impl SplineAxis {
    /// # Panics
    /// Without a cell.
    pub fn new(cells: usize) -> Self {
        assert!(cells > 0, "an axis has a cell");
        Self { cells }
    }

    /// Cells along the axis.
    pub fn cells(self) -> usize {
        self.cells
    }

    /// Number of functions.
    pub fn functions(self) -> usize {
        self.cells + 3
    }

    /// A knot, in cells.
    #[inline(always)]
    fn knot(self, index: usize) -> usize {
        index.saturating_sub(3).min(self.cells)
    }

    /// The cell of a place; of one outside the box the nearest.
    #[inline(always)]
    fn cell(self, unit: f64) -> usize {
        // What is not a number goes to the first cell, and its values are not numbers.
        ((unit * self.cells as f64) as usize).min(self.cells - 1)
    }

    /// Values at a place (Piegl & Tiller, *The NURBS Book*, 1997, algorithm A2.2).
    #[inline(always)]
    pub fn at(self, unit: f64) -> Local {
        let first = self.cell(unit);
        let along = unit * self.cells as f64;
        let mut values = [1.0, 0.0, 0.0, 0.0];
        values = self.raised::<1>(first, along, values);
        values = self.raised::<2>(first, along, values);
        values = self.raised::<3>(first, along, values);
        Local { first, values }
    }

    /// Derivatives by the place, of the same functions as [`Self::at`].
    pub fn slopes(self, unit: f64) -> [f64; LOCAL] {
        let first = self.cell(unit);
        let along = unit * self.cells as f64;
        let lower = self.raised::<1>(first, along, [1.0, 0.0, 0.0, 0.0]);
        let values = self.raised::<2>(first, along, lower);
        // N'_{i,3} = 3 (N_{i,2} / (t_{i+3} - t_i) - N_{i+1,2} / (t_{i+4} - t_{i+1})).
        let mut slopes = [0.0; LOCAL];
        for (k, value) in values.iter().take(3).enumerate() {
            let function = first + k + 1;
            let part = self.slope_factor(function - 1) * value;
            slopes[k] -= part;
            slopes[k + 1] += part;
        }
        slopes
    }

    /// The functions of a degree at a place from those of one less.
    #[inline(always)]
    fn raised<const DEGREE: usize>(
        self,
        cell: usize,
        along: f64,
        lower: [f64; LOCAL],
    ) -> [f64; LOCAL] {
        // Neighbouring knots of a function of this degree are one to three cells apart.
        const PER_CELLS: [f64; 4] = [0.0, 1.0, 0.5, 1.0 / 3.0];
        let knot = cell + 3;
        let mut values = [0.0; LOCAL];
        for (r, value) in lower.iter().take(DEGREE).enumerate() {
            let right = self.knot(knot + r + 1);
            let left = self.knot(knot + r + 1 - DEGREE);
            let part = value * PER_CELLS[right - left];
            values[r] += (right as f64 - along) * part;
            values[r + 1] = (along - left as f64) * part;
        }
        values
    }

    /// Where values are needed to find the coefficients: one place a function.
    pub fn places(self) -> Vec<f64> {
        (0..self.functions())
            .map(|i| (1..=3).map(|k| self.knot(i + k)).sum::<usize>() as f64 / 3.0)
            .map(|along| along / self.cells as f64)
            .collect()
    }

    /// Coefficients from values at [`Self::places`].
    pub fn from_values(self) -> DMatrix<f64> {
        let count = self.functions();
        let mut matrix = DMatrix::zeros(count, count);
        for (row, unit) in self.places().into_iter().enumerate() {
            let local = self.at(unit);
            for (k, value) in local.values.into_iter().enumerate() {
                matrix[(row, local.first + k)] = value;
            }
        }
        // The places lie within the functions' supports in order, so that the matrix is regular
        // (Schoenberg and Whitney, 1953).
        matrix.try_inverse().unwrap_or_else(|| DMatrix::identity(count, count))
    }

    /// Functions that are not zero somewhere between two places, first and after the last.
    pub fn functions_between(self, low: f64, high: f64) -> [usize; 2] {
        [self.cell(low), self.cell(high) + LOCAL]
    }

    /// What a difference of the coefficients `i` and `i + 1` is in the derivative's coefficients.
    pub fn slope_factor(self, i: usize) -> f64 {
        3.0 * self.cells as f64 / (self.knot(i + 4) - self.knot(i + 1)) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_reproduced_by_any_number_of_cells() {
        let cubic = |x: f64| 1.0 - 2.0 * x + 3.0 * x * x - 5.0 * x.powi(3);
        let slope = |x: f64| -2.0 + 6.0 * x - 15.0 * x * x;
        for cells in [1, 2, 3, 7, 40] {
            let axis = SplineAxis::new(cells);
            let values = axis.places().into_iter().map(cubic);
            let values = nalgebra::DVector::from_iterator(axis.functions(), values);
            let coefficients = axis.from_values() * values;
            for i in 0..=100 {
                let unit = f64::from(i) / 100.0;
                let local = axis.at(unit);
                let sum = |factors: [f64; LOCAL]| -> f64 {
                    let each = factors.iter().enumerate();
                    each.map(|(k, f)| f * coefficients[local.first + k]).sum()
                };
                assert!((sum(local.values) - cubic(unit)).abs() < 1e-12);
                assert!((sum(axis.slopes(unit)) - slope(unit)).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn coefficients_bound_values_and_slopes() {
        let axis = SplineAxis::new(6);
        let coefficients: Vec<f64> =
            (0..axis.functions()).map(|i| (i as f64 * 1.7).sin()).collect();
        let [first, end] = axis.functions_between(0.3, 0.45);
        let own = &coefficients[first..end];
        let most = own.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let steepest = (first..end - 1)
            .map(|i| (axis.slope_factor(i) * (coefficients[i + 1] - coefficients[i])).abs())
            .fold(0.0, f64::max);
        for i in 0..=150 {
            let unit = 0.3 + f64::from(i) / 1000.0;
            let local = axis.at(unit);
            let sum = |factors: [f64; LOCAL]| -> f64 {
                let each = factors.iter().enumerate();
                each.map(|(k, f)| f * coefficients[local.first + k]).sum()
            };
            assert!(sum(local.values) <= most + 1e-15);
            assert!(sum(axis.slopes(unit)).abs() <= steepest + 1e-12);
        }
    }
}
