//! Draws from the covariance of a fit's coefficients: other fields that it might as well have given.
//!
//! The file keeps the variance `B(u)ᵀ Q_bb' B(u)` at every pose, not the matrices `Q_bb'`. Covariances
//! between two places follow from where the samples were, which is kept too (`Cells`): samples are put
//! back, each gets normal noise of unit variance, and the fit's own equations give
//! `δ_b = (A_bᵀ A_b + d²)⁻¹ A_bᵀ W_b ε` with `A_b` of rows `w_ib B(u_i)`. Of a sample's axis only the
//! triangle is known: sums take the mean of the powers of its weights over the triangle (a joint fit's
//! an axis drawn from it), and a cell of many samples has one for each triangle of its directions. One
//! factor a direction then makes the variance at its samples' places the stored one on average, and
//! `σ_b` makes it mm and rad. `tests/invariants/field_draws.rs` compares with refits.

use super::fit_validity::{AxisWeights, FitValidity};
use super::form::FormBasis;
use crate::bernstein::push_products;
use crate::evaluation::Coefficient;
use crate::model::DistortionModel;
use faer::linalg::solvers::Solve;
use faer::{Mat, MatMut, MatRef, RowRef, Side};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Exp1, StandardNormal};
use rayon::prelude::*;
use trackwright_geometry::directions::DirectionSet;
use trackwright_task::{Cancelled, Task};

/// Samples whose rows are multiplied through at once.
const BLOCK: usize = 512;

/// Values of a coefficient.
const VALUES: usize = 6;

/// Normal numbers of a sample: one that its directions share, and one of each.
const SHARES: usize = 4;

/// Places at which the variance of a direction's draws is set to the stored one.
const CALIBRATED_AT: usize = 64;

/// Draws of one fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldDraws {
    pub models: Vec<DistortionModel>,
}

/// Why there are no draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DrawError {
    #[error("its samples do not determine the field everywhere")]
    NotDetermined,
    #[error("its fit has no residual to estimate the noise from")]
    NoResidual,
    #[error("it keeps {rows} places of samples for {unknowns} unknowns")]
    TooFewPlaces { rows: usize, unknowns: usize },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A sample put back where it was.
struct SamplePosition {
    unit: Vector3<f64>,
    weights: AxisWeights,
}

/// One system of a fit: a direction, or all of them in a joint fit.
struct System {
    /// `None` for all.
    direction: Option<usize>,
    unknowns: usize,
}

/// A sample in a system.
#[derive(Clone, Copy)]
struct Used {
    place: usize,
    weight: f64,
    /// What it takes of the noise that its directions share, and of its own, by number.
    shared: f64,
    own: (usize, f64),
}

impl Used {
    /// With all its directions, whose weights are those of its place.
    fn whole(place: usize) -> Self {
        Self { place, weight: 1.0, shared: 1.0, own: (0, 0.0) }
    }

    /// Its part of one direction, where it has one: with `w` over a triangle, an edge or a corner
    /// (k = 3, 2, 1 directions) with equal chance, `E w² = 2 / k(k + 1)`, and of the noise `w_b² ε`,
    /// `E w_b⁴ = 24 / k(k + 1)(k + 2)(k + 3)` and `E w_b² w_c²` a sixth of it (moments of the flat
    /// Dirichlet distribution).
    fn part(place: usize, weights: &AxisWeights, direction: usize) -> Option<Self> {
        let corner = weights.iter().position(|(d, _)| d == direction)?;
        let k = weights.iter().count() as f64;
        let weight = (2.0 / (k * (k + 1.0))).sqrt();
        let fourth = 24.0 / (k * (k + 1.0) * (k + 2.0) * (k + 3.0));
        Some(Self {
            place,
            weight,
            shared: (fourth / 6.0).sqrt() / weight,
            own: (1 + corner, (fourth * 5.0 / 6.0).sqrt() / weight),
        })
    }

    fn noise(&self, noise: &[f64]) -> f64 {
        let at = self.place * SHARES;
        self.shared * noise[at] + self.own.1 * noise[at + self.own.0]
    }
}

impl FitValidity {
    /// `count` fields that the fit might as well have given, of the model that this support stands
    /// beside and the ridge that it was fitted with. A seed gives the same fields on any number of
    /// threads.
    pub fn draw(
        &self,
        model: &DistortionModel,
        ridge: f64,
        count: usize,
        seed: u64,
        task: &Task,
    ) -> Result<FieldDraws, DrawError> {
        let parts = &self.parts;
        if parts.undetermined.iter().any(|form| !form.is_empty()) {
            return Err(DrawError::NotDetermined);
        }
        let position_std_mm = known(&parts.position_std_mm)?;
        let angle_std_rad = match &parts.angle_std_rad {
            Some(std) => known(std)?,
            None => vec![0.0; position_std_mm.len()],
        };
        let places = self.places(seed);
        let columns = count * VALUES;
        let noise: Vec<Vec<f64>> = (0..columns)
            .into_par_iter()
            .map(|column| {
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                // The first stream is that of the places.
                random.set_stream(1 + column as u64);
                (0..places.len() * SHARES).map(|_| StandardNormal.sample(&mut random)).collect()
            })
            .collect();
        let per_direction = model.of_direction(0).len();
        let directions = self.directions.len();
        let systems: Vec<_> = match self.is_joint() {
            true => vec![System { direction: None, unknowns: directions * per_direction }],
            false => (0..directions)
                .map(|direction| System { direction: Some(direction), unknowns: per_direction })
                .collect(),
        };
        let moved: Vec<Mat<f64>> = systems
            .par_iter()
            .map(|system| self.moved(system, &places, &noise, ridge, task))
            .collect::<Result<_, DrawError>>()?;
        let models = (0..count).map(|draw| {
            let mut coefficients: Vec<Coefficient> = model.coefficients().to_vec();
            for (system, (moved, scales)) in
                moved.iter().zip(position_std_mm.iter().zip(&angle_std_rad)).enumerate()
            {
                let first = system * moved.nrows();
                let of_system = &mut coefficients[first..first + moved.nrows()];
                for (row, coefficient) in of_system.iter_mut().enumerate() {
                    for (k, value) in coefficient.iter_mut().enumerate() {
                        let std = if k < 3 { scales.0 } else { scales.1 };
                        // The deviation is that of a vector, over three axes.
                        *value += std / 3.0_f64.sqrt() * moved[(row, draw * VALUES + k)];
                    }
                }
            }
            DistortionModel::of_parts_known_to_fit(
                model.order(),
                model.directions(),
                model.weighting(),
                model.map(),
                *model.bounds(),
                coefficients,
            )
        });
        Ok(FieldDraws { models: models.collect() })
    }

    /// What unit noise does to a system's unknowns: a row each, a column a draw and value.
    fn moved(
        &self,
        system: &System,
        places: &[SamplePosition],
        noise: &[Vec<f64>],
        ridge: f64,
        task: &Task,
    ) -> Result<Mat<f64>, DrawError> {
        let used: Vec<Used> = places
            .iter()
            .enumerate()
            .filter_map(|(place, at)| match system.direction {
                None => Some(Used::whole(place)),
                Some(direction) => Used::part(place, &at.weights, direction),
            })
            .collect();
        let unknowns = system.unknowns;
        if used.len() < unknowns {
            return Err(DrawError::TooFewPlaces { rows: used.len(), unknowns });
        }
        let mut normal = Mat::<f64>::zeros(unknowns, unknowns);
        let mut right = Mat::<f64>::zeros(unknowns, noise.len());
        for block in used.chunks(BLOCK) {
            task.step(0, 1)?;
            let rows = self.rows(system, places, block);
            let rows = rows.as_ref();
            let shaken = Mat::from_fn(block.len(), noise.len(), |row, column| {
                block[row].noise(&noise[column])
            });
            normal += rows.transpose() * rows;
            right += rows.transpose() * &shaken;
        }
        let damping = ridge * ridge * largest_eigenvalue(normal.as_ref());
        for k in 0..unknowns {
            normal[(k, k)] += damping;
        }
        let factor = normal.llt(Side::Lower).map_err(|_| DrawError::NotDetermined)?;
        let mut moved = factor.solve(&right);
        let directions = system.direction.map_or(0..self.directions.len(), |d| d..d + 1);
        let each = unknowns / directions.len();
        for (block, direction) in directions.enumerate() {
            self.calibrate(direction, places, moved.as_mut().subrows_mut(block * each, each))?;
        }
        Ok(moved)
    }

    /// `w B(u)` of each sample; of a joint fit for each of its directions.
    fn rows(&self, system: &System, places: &[SamplePosition], used: &[Used]) -> Mat<f64> {
        let mut rows = Mat::zeros(used.len(), system.unknowns);
        let mut products = Vec::new();
        for (row, &Used { place, weight, .. }) in used.iter().enumerate() {
            let place = &places[place];
            products.clear();
            push_products(self.order, &place.unit, &mut products);
            let mut put = |block: usize, weight: f64| {
                let first = block * products.len();
                for (column, value) in products.iter().enumerate() {
                    rows[(row, first + column)] = weight * value;
                }
            };
            match system.direction {
                Some(_) => put(0, weight),
                None => place.weights.iter().for_each(|(direction, weight)| put(direction, weight)),
            }
        }
        rows
    }

    /// Makes the variance of a direction's draws the stored one at its samples' places: the geometric
    /// mean of what each of them needs, because a few at the edges of what is known would decide
    /// any other.
    fn calibrate(
        &self,
        direction: usize,
        places: &[SamplePosition],
        mut moved: MatMut<'_, f64>,
    ) -> Result<(), DrawError> {
        let is_of = |place: &&SamplePosition| place.weights.iter().any(|(d, _)| d == direction);
        let step = places.iter().filter(is_of).count().div_ceil(CALIBRATED_AT);
        let at = places.iter().filter(is_of).step_by(step.max(1));
        let variance = &self.parts.variance[self.pairs.index(direction, direction)];
        let (mut sum, mut count) = (0.0, 0);
        let mut products = Vec::new();
        for place in at {
            products.clear();
            push_products(self.order, &place.unit, &mut products);
            let basis = RowRef::from_slice(&products);
            let found = (basis * moved.as_ref()).squared_norm_l2() / moved.ncols().max(1) as f64;
            let stored = FormBasis::new(2 * self.order, &place.unit).value(variance);
            sum += (stored / found).ln();
            count += 1;
        }
        let factor = (sum / f64::from(count) / 2.0).exp();
        if !factor.is_finite() {
            return Err(DrawError::NotDetermined);
        }
        moved *= faer::Scale(factor);
        Ok(())
    }

    /// The samples, put back.
    fn places(&self, seed: u64) -> Vec<SamplePosition> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let cells = &self.parts.cells;
        let mut places = Vec::new();
        for cell in cells.cells() {
            let unit = self.bounds.to_unit(&self.bounds.clamp(&cells.center_mm(cell)));
            let samples = samples_of(self.directions, cell.directions, &mut random);
            places.extend(samples.into_iter().map(|weights| SamplePosition { unit, weights }));
        }
        places
    }
}

/// Every system's deviation, or that one has none.
fn known(std: &[Option<f64>]) -> Result<Vec<f64>, DrawError> {
    std.iter().copied().collect::<Option<_>>().ok_or(DrawError::NoResidual)
}

/// Samples whose axes weigh these directions: one where they are a triangle or part of one, else as
/// many as are needed.
fn samples_of(set: DirectionSet, bits: u64, random: &mut ChaCha8Rng) -> Vec<AxisWeights> {
    let has = |direction: usize| bits >> direction & 1 == 1;
    let mut exponential = || -> f64 { Exp1.sample(random) };
    let mut samples = Vec::new();
    let mut left = bits;
    // Exponential numbers over their sum are even over the triangle (the flat Dirichlet distribution).
    let mut put = |directions: [usize; 3], counts: usize| {
        let mut weights = [0.0; 3];
        for weight in &mut weights[..counts] {
            *weight = exponential();
        }
        let sum: f64 = weights.iter().sum();
        samples.push(AxisWeights::new(&directions, &weights.map(|w| w / sum)));
    };
    for &triangle in set.triangles() {
        let is_needed = triangle.iter().any(|&d| left >> d & 1 == 1);
        if is_needed && triangle.iter().all(|&d| has(d)) {
            put(triangle, 3);
            for d in triangle {
                left &= !(1 << d);
            }
        }
    }
    let alone: Vec<usize> = (0..set.len()).filter(|d| left >> d & 1 == 1).collect();
    match alone.as_slice() {
        // An axis on the edge between two.
        &[a, b] if bits.count_ones() == 2 => put([a, b, a], 2),
        alone => {
            for &d in alone {
                put([d; 3], 1);
            }
        }
    }
    samples
}

/// Of a symmetric matrix without negative ones, to within a per cent or so: what damping needs.
fn largest_eigenvalue(matrix: MatRef<'_, f64>) -> f64 {
    let mut vector = Mat::from_fn(matrix.ncols(), 1, |_, _| 1.0);
    let mut value = 0.0;
    for _ in 0..POWER_STEPS {
        let next = matrix * &vector;
        value = next.norm_l2() / vector.norm_l2();
        if !(value.is_finite() && value > 0.0) {
            return 0.0;
        }
        vector = next * faer::Scale(1.0 / value);
    }
    value
}

/// Steps of the power method. Sums of products of a non-negative basis have one eigenvector without
/// a change of sign, far ahead of the others, and the start is close to it.
const POWER_STEPS: usize = 12;
