//! Sums, extremes and percentiles of a sample.

/// Values that are summed up in several ways; what two of them need is computed once.
pub struct Sample<'a> {
    values: &'a mut [f64],
    mean: Option<f64>,
    range: Option<[f64; 2]>,
}

impl<'a> Sample<'a> {
    /// Of at least one value. Percentiles reorder them.
    pub fn new(values: &'a mut [f64]) -> Self {
        Self { values, mean: None, range: None }
    }

    fn range(&mut self) -> [f64; 2] {
        let values = &self.values;
        *self.range.get_or_insert_with(|| {
            let min = values.iter().copied().fold(f64::INFINITY, f64::min);
            [min, values.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
        })
    }

    /// Smallest value.
    pub fn min(&mut self) -> f64 {
        self.range()[0]
    }

    /// Largest value.
    pub fn max(&mut self) -> f64 {
        self.range()[1]
    }

    /// Arithmetic mean, summed pairwise.
    pub fn mean(&mut self) -> f64 {
        let values = &self.values;
        *self.mean.get_or_insert_with(|| {
            let n = values.len() as f64;
            let rough = pairwise_sum(values, &|v| v) / n;
            // Once more from there: equal values have exactly their own mean, and no deviation.
            rough + pairwise_sum(values, &|v| v - rough) / n
        })
    }

    /// Root of the mean square.
    pub fn rms(&mut self) -> f64 {
        self.root_mean_square(0.0)
    }

    /// Population standard deviation.
    pub fn std(&mut self) -> f64 {
        let mean = self.mean();
        self.root_mean_square(mean)
    }

    fn root_mean_square(&mut self, from: f64) -> f64 {
        let [min, max] = self.range();
        let unit = unit_of_squares(min.abs().max(max.abs()));
        let n = self.values.len() as f64;
        (pairwise_sum(self.values, &|v| ((v - from) / unit).powi(2)) / n).sqrt() * unit
    }

    /// The `p`-th quantile, `0 <= p <= 1`.
    pub fn percentile(&mut self, p: f64) -> f64 {
        percentile(self.values, p)
    }

    /// The values, in any order.
    pub fn values(&self) -> &[f64] {
        self.values
    }
}

/// What values are divided by before they are squared: 1, or a power of two where their squares
/// would leave the range of numbers.
fn unit_of_squares(largest: f64) -> f64 {
    if (1e-120..1e120).contains(&largest) || largest == 0.0 || largest.is_infinite() {
        1.0
    } else {
        largest.log2().floor().exp2()
    }
}

/// The `p`-th quantile, `0 <= p <= 1`, of at least one value; reorders them.
///
/// ```
/// use trackwright_simulation::statistics::percentile;
/// assert_eq!(percentile(&mut [3.0, 1.0, 2.0], 0.25), 1.5);
/// ```
pub fn percentile(values: &mut [f64], p: f64) -> f64 {
    let place = (values.len() - 1) as f64 * p;
    let below = place.floor() as usize;
    let (_, &mut low, above) = values.select_nth_unstable_by(below, f64::total_cmp);
    let high = above.iter().copied().min_by(f64::total_cmp).unwrap_or(low);
    let part = place - below as f64;
    // Zero times an infinite neighbour is not a number.
    if part == 0.0 { low } else { low + (high - low) * part }
}

/// Pairwise summation: error grows with the logarithm of the count.
fn pairwise_sum(values: &[f64], of: &impl Fn(f64) -> f64) -> f64 {
    if values.len() <= 128 {
        return values.iter().map(|&v| of(v)).sum();
    }
    let (left, right) = values.split_at(values.len() / 2);
    pairwise_sum(left, of) + pairwise_sum(right, of)
}
