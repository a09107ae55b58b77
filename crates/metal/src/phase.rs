//! Answers that lag behind the fields that they answer: `in phase + i·lag`, of fields that go as `e^(iωt)`.

use faer::Mat;

/// A complex matrix as two real ones.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct InPhaseAndLag {
    pub in_phase: Mat<f64>,
    pub lag: Mat<f64>,
}

impl InPhaseAndLag {
    /// Times columns in phase: the part in phase.
    pub fn in_phase_of(&self, columns: &Mat<f64>) -> Mat<f64> {
        &self.in_phase * columns
    }

    /// Times complex columns, their parts in phase first and then as many that lag.
    pub fn of_both(&self, columns: &Mat<f64>) -> Mat<f64> {
        let half = columns.ncols() / 2;
        let (in_phase, lag) =
            (columns.as_ref().subcols(0, half), columns.as_ref().subcols(half, half));
        let turned = Mat::from_fn(columns.nrows(), 2 * half, |i, j| match j < half {
            true => -lag[(i, j)],
            false => in_phase[(i, j - half)],
        });
        &self.in_phase * columns + &self.lag * turned
    }
}

/// Real columns with as many that lag by nothing.
pub(crate) fn with_no_lag(columns: &Mat<f64>) -> Mat<f64> {
    let half = columns.ncols();
    Mat::from_fn(columns.nrows(), 2 * half, |i, j| if j < half { columns[(i, j)] } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::c64;

    #[test]
    fn products_are_those_of_complex_numbers() {
        let entry = |i: usize, j: usize| (1.7 * i as f64 + 0.3 * (j * j) as f64).sin();
        let matrix = InPhaseAndLag {
            in_phase: Mat::from_fn(4, 3, entry),
            lag: Mat::from_fn(4, 3, |i, j| entry(j + 7, i)),
        };
        let columns = Mat::from_fn(3, 4, |i, j| entry(i + 2, j + 5));
        let complex =
            Mat::from_fn(4, 3, |i, j| c64::new(matrix.in_phase[(i, j)], matrix.lag[(i, j)]));
        let right = Mat::from_fn(3, 2, |i, j| c64::new(columns[(i, j)], columns[(i, j + 2)]));
        let (found, expected) = (matrix.of_both(&columns), complex * right);
        for (i, j) in (0..4).flat_map(|i| (0..2).map(move |j| (i, j))) {
            assert!((found[(i, j)] - expected[(i, j)].re).abs() < 1e-15);
            assert!((found[(i, j + 2)] - expected[(i, j)].im).abs() < 1e-15);
        }
        let real = Mat::from_fn(3, 2, |i, j| columns[(i, j)]);
        let both = matrix.of_both(&with_no_lag(&real));
        assert_eq!(both.as_ref().subcols(0, 2), matrix.in_phase_of(&real).as_ref());
    }
}
