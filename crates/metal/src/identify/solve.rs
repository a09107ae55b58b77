//! The best places and strengths of so many bodies near a start: Levenberg–Marquardt on all unknowns,
//! strengths of dipoles solved for by themselves (variable projection), measurements weighted anew after
//! each step (Huber).

use super::extended::{Extended, explained};
use super::noise::losses;
use super::rows::Rows;
use super::sources::{OF_BODY, Source, SourceModel, of_unit_dipole};
use nalgebra::{DMatrix, DVector};
use trackwright_field::harmonic::huber_weights;
use trackwright_task::{Cancelled, Task};

/// Standard errors of a variance up to which what is left is noise.
const NOISE_ERRORS: f64 = 2.0;

/// Steps after which a start leads nowhere; most need 5 to 15.
const MAX_STEPS: usize = 40;

/// Expected gain of a step, in squares of what is left, where it is the last: 3 % of a standard deviation.
const CONVERGED: f64 = 1e-3;

/// Slopes of spheres serve where no body is farther than this from where they were taken, and no strength
/// changed by more than this part: steps then still fall tenfold.
const KEPT_MM: f64 = 4.0;
const KEPT_PART: f64 = 0.06;

const FIRST_DAMPING: f64 = 1e-3;
const MORE_DAMPING: f64 = 8.0;
const LESS_DAMPING: f64 = 0.1;
const MAX_DAMPING: f64 = 1e6;

/// Bodies and what they are modelled as.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bodies {
    pub model: SourceModel,
    pub sources: Vec<Source>,
    /// The same by their multipoles; none of dipoles and spheres.
    pub extended: Vec<Extended>,
}

impl Bodies {
    /// What they add to the rows; `None` where they cannot be.
    pub fn explained(&self, rows: &Rows) -> Option<Vec<f64>> {
        match self.model {
            SourceModel::Multipoles => Some(explained(rows, &self.extended)),
            model => model.explained(rows, &self.sources),
        }
    }
}

/// Bodies that explain rows best, and what follows from the slopes there.
#[derive(Clone)]
pub(super) struct Solution {
    pub model: SourceModel,
    pub sources: Vec<Source>,
    pub extended: Vec<Extended>,
    /// What each unknown is held near zero with, in noise.
    pub prior: DVector<f64>,
    /// Unknowns that the rows decide, those of the prior counted in part.
    pub unknowns: f64,
    /// What is left of the rows, in noise.
    pub left: Vec<f64>,
    /// Of each measurement.
    pub weights: Vec<f64>,
    /// Sum of Huber's losses.
    pub loss: f64,
    pub slopes: DMatrix<f64>,
}

impl Solution {
    /// No bodies.
    pub fn none(rows: &Rows) -> Self {
        let left = rows.right.clone();
        Self {
            model: SourceModel::Dipoles,
            sources: Vec::new(),
            extended: Vec::new(),
            prior: DVector::zeros(0),
            unknowns: 0.0,
            weights: huber_weights(&left, rows.dof),
            loss: losses(rows, &left).iter().sum(),
            slopes: DMatrix::zeros(left.len(), 0),
            left,
        }
    }

    /// Variance of what is left, in squares of noise; 1 where all is explained.
    pub fn variance(&self, dof: usize) -> f64 {
        let free = self.left.len() as f64 - self.unknowns;
        weighted_square(&self.left, &self.weights, dof) / free.max(1.0)
    }

    /// Whether noise alone is left.
    pub fn is_noise(&self, dof: usize) -> bool {
        let std_error = (2.0 / self.left.len() as f64).sqrt();
        self.variance(dof) < 1.0 + NOISE_ERRORS * std_error
    }

    /// Covariance of the unknowns; `None` where the rows do not determine them.
    ///
    /// `σ² (Aᵀ W A)⁻¹`, where an unknown has a larger variance by what each measurement left with its
    /// standard deviations stretched to that: noise need not be alike everywhere.
    pub fn covariance(&self, dof: usize) -> Option<DMatrix<f64>> {
        let unknowns = self.slopes.ncols();
        let inverse = self.inverse(dof)?;
        // Scaled, so that mm and strengths are alike.
        let scale = inverse.diagonal().map(f64::sqrt);
        let inverse =
            DMatrix::from_fn(unknowns, unknowns, |i, j| inverse[(i, j)] / (scale[i] * scale[j]));
        let mut meat = DMatrix::zeros(unknowns, unknowns);
        for (m, weight) in self.weights.iter().enumerate() {
            let slopes = self.slopes.rows(m * dof, dof);
            let left = DVector::from_column_slice(&self.left[m * dof..][..dof]);
            let pull = slopes.tr_mul(&left).component_mul(&scale) * *weight;
            meat += &pull * pull.transpose();
        }
        let by_measurement = &inverse * meat * &inverse;
        let variance = self.variance(dof);
        let stretch = |k: usize| (by_measurement[(k, k)] / (variance * inverse[(k, k)])).sqrt();
        let stretches = DVector::from_fn(unknowns, |k, _| stretch(k).max(1.0) * scale[k]);
        let covariance = DMatrix::from_fn(unknowns, unknowns, |i, j| {
            inverse[(i, j)] * stretches[i] * stretches[j] * variance
        });
        covariance.iter().all(|v| v.is_finite()).then_some(covariance)
    }

    /// `(Aᵀ W A + P)⁻¹`; `None` where the rows do not determine the unknowns.
    pub fn inverse(&self, dof: usize) -> Option<DMatrix<f64>> {
        inverse(&self.slopes, &self.left, &self.weights, &self.prior, dof)
    }

    pub fn bodies(&self) -> Bodies {
        let Self { model, sources, extended, .. } = self;
        Bodies { model: *model, sources: sources.clone(), extended: extended.clone() }
    }
}

/// The best bodies near a start; `None` where it leads nowhere.
pub(super) fn solve(
    task: &Task,
    rows: &Rows,
    model: SourceModel,
    start: &[Source],
    weights: &[f64],
) -> Result<Option<Solution>, Cancelled> {
    let Some(mut state) = State::new(rows, model, start.to_vec(), weights) else {
        return Ok(None);
    };
    let mut weights = weights.to_vec();
    let mut damping = FIRST_DAMPING;
    let mut kept: Option<Slopes> = None;
    for step in 0..MAX_STEPS {
        task.step(0, 1)?;
        if step > 0 {
            weights = huber_weights(&state.left, rows.dof);
            state.square = weighted_square(&state.left, &weights, rows.dof);
        }
        let slopes = match kept.take().filter(|kept| kept.serve(&state.sources, model)) {
            Some(slopes) => slopes,
            None => match Slopes::at(rows, model, &state) {
                Some(slopes) => slopes,
                None => return Ok(None),
            },
        };
        let (normal, slope) = equations(&slopes.matrix, &state.left, &weights, rows.dof);
        let converged = CONVERGED * state.square / state.left.len() as f64;
        let mut gain = f64::INFINITY;
        let next = loop {
            let mut damped = normal.clone();
            for k in 0..slope.len() {
                damped[(k, k)] *= 1.0 + damping;
            }
            if let Some(factor) = damped.cholesky() {
                let step = factor.solve(&slope);
                gain = step.dot(&slope);
                let moved = state.sources.iter().zip(step.as_slice().chunks_exact(OF_BODY));
                let moved = moved.map(|(source, step)| source.moved(step)).collect();
                let next = State::new(rows, model, moved, &weights);
                if let Some(next) = next.filter(|next| next.square < state.square) {
                    break Some(next);
                }
            }
            damping *= MORE_DAMPING;
            if damping > MAX_DAMPING || gain < converged {
                break None;
            }
        };
        damping = (damping * LESS_DAMPING).max(1e-12);
        let (has_converged, is_stuck) = (gain < converged, next.is_none());
        if let Some(next) = next {
            state = next;
        }
        if has_converged {
            return Ok(Some(state.solution(rows, model, slopes.matrix)));
        }
        if is_stuck {
            return Ok(None);
        }
        kept = Some(slopes);
    }
    Ok(None)
}

/// Slopes and where they are from.
struct Slopes {
    sources: Vec<Source>,
    matrix: DMatrix<f64>,
}

impl Slopes {
    fn at(rows: &Rows, model: SourceModel, state: &State) -> Option<Self> {
        let matrix = model.slopes(rows, &state.sources)?;
        Some(Self { sources: state.sources.clone(), matrix })
    }

    /// Whether they are near enough; those of spheres take long.
    fn serve(&self, sources: &[Source], model: SourceModel) -> bool {
        let is_near = |(old, new): (&Source, &Source)| {
            let strength = new.strength_mm3 / old.strength_mm3 - 1.0;
            (old.center_mm - new.center_mm).norm() < KEPT_MM && strength.abs() < KEPT_PART
        };
        model == SourceModel::Spheres && self.sources.iter().zip(sources).all(is_near)
    }
}

/// Bodies and what they leave.
struct State {
    sources: Vec<Source>,
    left: Vec<f64>,
    square: f64,
}

impl State {
    /// Strengths of dipoles are the best for their places.
    fn new(
        rows: &Rows,
        model: SourceModel,
        mut sources: Vec<Source>,
        weights: &[f64],
    ) -> Option<Self> {
        if model == SourceModel::Dipoles {
            let columns: Vec<_> =
                sources.iter().map(|s| of_unit_dipole(rows, &s.center_mm)).collect();
            let columns = DMatrix::from_fn(rows.right.len(), sources.len(), |i, j| columns[j][i]);
            let (normal, slope) = equations(&columns, &rows.right, weights, rows.dof);
            let scale = normal.diagonal().map(|d| 1.0 / d.sqrt());
            let scaled = DMatrix::from_fn(sources.len(), sources.len(), |i, j| {
                normal[(i, j)] * scale[i] * scale[j]
            });
            let strengths = scaled.cholesky()?.solve(&slope.component_mul(&scale));
            for (k, source) in sources.iter_mut().enumerate() {
                source.strength_mm3 = strengths[k] * scale[k];
            }
        }
        let explained = model.explained(rows, &sources)?;
        let left = rows.left(&explained);
        let square = weighted_square(&left, weights, rows.dof);
        square.is_finite().then_some(Self { sources, left, square })
    }

    fn solution(self, rows: &Rows, model: SourceModel, slopes: DMatrix<f64>) -> Solution {
        Solution {
            model,
            sources: self.sources,
            weights: huber_weights(&self.left, rows.dof),
            loss: losses(rows, &self.left).iter().sum(),
            left: self.left,
            extended: Vec::new(),
            prior: DVector::zeros(slopes.ncols()),
            unknowns: slopes.ncols() as f64,
            slopes,
        }
    }
}

/// See [`Solution::inverse`].
pub(super) fn inverse(
    slopes: &DMatrix<f64>,
    left: &[f64],
    weights: &[f64],
    prior: &DVector<f64>,
    dof: usize,
) -> Option<DMatrix<f64>> {
    let (mut normal, _) = equations(slopes, left, weights, dof);
    let count = normal.nrows();
    for i in 0..count {
        normal[(i, i)] += prior[i];
    }
    let scale = normal.diagonal().map(|d| 1.0 / d.sqrt());
    let scaled = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] * scale[i] * scale[j]))
}

pub(super) fn weighted_square(left: &[f64], weights: &[f64], dof: usize) -> f64 {
    let of_measurement = |(r, w): (&[f64], &f64)| w * r.iter().map(|v| v * v).sum::<f64>();
    left.chunks_exact(dof).zip(weights).map(of_measurement).sum()
}

/// `Aᵀ W A` and `Aᵀ W r`.
pub(super) fn equations(
    slopes: &DMatrix<f64>,
    left: &[f64],
    weights: &[f64],
    dof: usize,
) -> (DMatrix<f64>, DVector<f64>) {
    let transposed =
        DMatrix::from_fn(slopes.ncols(), slopes.nrows(), |j, i| slopes[(i, j)] * weights[i / dof]);
    let left = DVector::from_column_slice(left);
    // Several times as fast as `tr_mul`.
    (&transposed * slopes, &transposed * left)
}
