//! The same field as a model of a higher order: Bernstein polynomials of order n are also ones of
//! order n + 1 (degree elevation, exact but for rounding).

use super::bernstein::MAX_ORDER;
use super::evaluation::Coefficient;
use super::model::{DistortionModel, ModelError};

impl DistortionModel {
    /// This field with the coefficients of a higher order; as it is at its own order or below.
    ///
    /// Along one axis, with `c_{-1}` and `c_{n+1}` counted as zero,
    /// `c'_i = i / (n + 1) c_{i-1} + (1 - i / (n + 1)) c_i`; the three axes one after the other.
    ///
    /// # Errors
    /// [`ModelError::Order`] beyond [`MAX_ORDER`]. A field without distortion stays of order 0.
    pub fn elevated(&self, order: usize) -> Result<Self, ModelError> {
        if order > MAX_ORDER {
            return Err(ModelError::Order(order));
        }
        let mut now = self.order();
        if now == 0 {
            return Ok(self.clone());
        }
        let mut coefficients = self.coefficients().to_vec();
        while now < order {
            let n = now + 1;
            // The last axis first: the axes behind one set how far apart its values lie, and those
            // have one value more each once they are done.
            for stride in [1, n + 1, (n + 1) * (n + 1)] {
                coefficients = along_axis(&coefficients, n, stride);
            }
            now += 1;
        }
        self.with_coefficients(now, *self.bounds(), coefficients)
    }
}

/// Elevates the axis whose `n` values lie `stride` apart.
fn along_axis(coefficients: &[Coefficient], n: usize, stride: usize) -> Vec<Coefficient> {
    let mut elevated = Vec::with_capacity(coefficients.len() / n * (n + 1));
    for block in coefficients.chunks_exact(n * stride) {
        for i in 0..=n {
            let part = i as f64 / n as f64;
            for k in 0..stride {
                let value = |i: usize| block.get(i * stride + k).copied().unwrap_or([0.0; 6]);
                let before = if i == 0 { [0.0; 6] } else { value(i - 1) };
                let here = value(i);
                elevated.push(std::array::from_fn(|c| part * before[c] + (1.0 - part) * here[c]));
            }
        }
    }
    elevated
}
