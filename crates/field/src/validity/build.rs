//! Makes the validity from a fit's singular value decompositions and the samples.

use super::cells::Cells;
use super::fit_validity::{AxisWeights, FitValidity, FitValidityParts, Pairs};
use super::form::coefficients;
use crate::bernstein::{coefficient_count, push_products};
use crate::fit::{Factored, FitError, FitMethod, FitSettings};
use crate::least_squares::Decomposition;
use crate::model::DistortionModel;
use crate::samples::{Sample, SampleSet};
use faer::{Mat, MatRef};
use rayon::prelude::*;
use std::collections::BTreeMap;
use trackwright_geometry::directions::DirectionSet;
use trackwright_task::{Cancelled, Task};

/// Most coefficients that are kept: some 3 MB of text in an environment.
pub const MAX_STORED: usize = 250_000;

/// Most unknowns of a joint fit whose validity is computed: a decomposition of so many takes some
/// ten seconds, of order 6 with 14 orientations (4,802) minutes.
pub const MAX_JOINT_UNKNOWNS: usize = 2000;

/// Forms are kept to this part of the samples' mean leverage: their text is short, and what is
/// dropped cannot be seen in four digits of a standard error.
const KEPT_DIGITS: f64 = 1e-6;

/// A combination of coefficients is left to the null space where a unit in the last place of its
/// variance's largest coefficient is above this part of the samples' mean leverage. What that
/// does to the variance is some ten thousand times less, because a coefficient in a far corner
/// hardly counts where the samples are: 2e-7 at a condition of 6e5 (measured, order 4, clusters).
const MAX_ROUND_OFF: f64 = 0.1;

/// Samples that are multiplied through at once.
const BLOCK: usize = 512;

/// Samples whose greatest leverage is looked for before the work may be stopped.
const STRIDE: usize = 16_384;

/// Why a fit has no validity to keep.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitValidityError {
    #[error("a fit of order 0 has no support")]
    NoOrder,
    #[error(
        "the support of order {order} with {directions} orientations is {values} numbers, expected \
         at most {MAX_STORED}"
    )]
    TooLarge { order: usize, directions: usize, values: usize },
    #[error(
        "the support of a joint fit needs a singular value decomposition of its {unknowns} unknowns, \
         expected at most {MAX_JOINT_UNKNOWNS}"
    )]
    TooManyUnknowns { unknowns: usize },
    #[error(transparent)]
    Fit(#[from] FitError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl FitValidity {
    /// Numbers that are kept at least.
    pub fn stored_values(order: usize, directions: DirectionSet, method: FitMethod) -> usize {
        let pairs = Pairs::of(directions).len();
        let forms = match method {
            FitMethod::PerDirection => pairs + directions.len(),
            FitMethod::Joint => pairs,
        };
        forms * (2 * order + 1).pow(3)
    }

    /// The validity of a fit. `model` is its solution with the rcond and ridge of the
    /// settings that it was factored with; the samples are those that it was made from.
    pub fn of_fit(
        set: &SampleSet,
        factored: &Factored,
        model: &DistortionModel,
        task: &Task,
    ) -> Result<Self, FitValidityError> {
        let (order, directions) = (model.order(), model.directions());
        if order == 0 {
            return Err(FitValidityError::NoOrder);
        }
        let FitSettings { method, rcond, ridge, .. } = factored.settings;
        let values = Self::stored_values(order, directions, method);
        if values > MAX_STORED {
            return Err(FitValidityError::TooLarge { order, directions: directions.len(), values });
        }
        let unknowns = directions.len() * coefficient_count(order);
        if method == FitMethod::Joint && unknowns > MAX_JOINT_UNKNOWNS {
            return Err(FitValidityError::TooManyUnknowns { unknowns });
        }
        let pairs = Pairs::of(directions);
        let factors: Vec<_> =
            factored.decompose()?.systems.iter().map(|s| Factor::of(s, rcond, ridge)).collect();
        let mut parts = match method {
            FitMethod::PerDirection => each_direction(set, &factors, &pairs, model, task)?,
            FitMethod::Joint => jointly(set, &factors, &pairs, model, ridge),
        };
        parts.cells = Cells::thinned(set.samples.iter().map(|s| {
            let w = directions.weights(&s.axis, model.weighting());
            let weights = AxisWeights::new(&w.directions, &w.weights);
            let bits = weights.iter().fold(0, |bits, (d, _)| bits | 1_u64 << d);
            (s.position_mm, bits)
        }));
        let mut validity = Self::new(parts, pairs, model);
        validity.find_greatest(set, task)?;
        Ok(validity)
    }

    /// The samples' own greatest leverage and undetermined part, by the forms as they are kept.
    fn find_greatest(&mut self, set: &SampleSet, task: &Task) -> Result<(), Cancelled> {
        let systems = self.parts.position_std_mm.len();
        let nothing = || vec![(0.0_f64, 0.0_f64); systems];
        let mut greatest = nothing();
        for (done, samples) in set.samples.chunks(STRIDE).enumerate() {
            task.step(done * STRIDE, set.samples.len())?;
            let found = samples
                .par_iter()
                .fold(nothing, |mut greatest, sample| {
                    let (basis, weights) = self.placed(&sample.position_mm, &sample.axis);
                    self.each_leverage(&basis, &weights, |system, leverage, undetermined| {
                        let (l, u) = &mut greatest[system];
                        (*l, *u) = (l.max(leverage), u.max(undetermined));
                    });
                    greatest
                })
                .reduce(nothing, larger);
            greatest = larger(greatest, found);
        }
        (self.parts.greatest_leverage, self.parts.greatest_undetermined) =
            greatest.into_iter().unzip();
        Ok(())
    }
}

fn larger(a: Vec<(f64, f64)>, b: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    a.iter().zip(&b).map(|(a, b)| (a.0.max(b.0), a.1.max(b.1))).collect()
}

/// What of a system's decomposition is used: the singular values that count.
struct Factor {
    rows: usize,
    /// Right singular vectors, a column each.
    v: Mat<f64>,
    /// `1 / s`.
    inverse: Vec<f64>,
    /// `s² / (s² + d²)`: 1 without ridge.
    filter: Vec<f64>,
    /// Whether something of the unknowns is not determined.
    is_deficient: bool,
}

impl Factor {
    fn of(system: &Decomposition, rcond: f64, ridge: f64) -> Self {
        let unknowns = system.v.nrows();
        let damping = (ridge * system.largest()).powi(2);
        let rank = system.rank(rcond);
        let mean_leverage = rank.max(1) as f64 / system.rows.max(1) as f64;
        let least = f64::EPSILON / (MAX_ROUND_OFF * mean_leverage);
        let kept: Vec<f64> = system.singular_values[..rank]
            .iter()
            .copied()
            .take_while(|s| s * s + damping >= least)
            .collect();
        Self {
            rows: system.rows,
            v: system.v.subcols(0, kept.len()).to_owned(),
            inverse: kept.iter().map(|s| 1.0 / s).collect(),
            filter: kept.iter().map(|s| s * s / (s * s + damping)).collect(),
            is_deficient: kept.len() < unknowns,
        }
    }

    fn mean_leverage(&self) -> f64 {
        self.filter.iter().sum::<f64>() / self.rows.max(1) as f64
    }

    /// Rows of `v` from `start`, columns scaled.
    fn scaled(&self, start: usize, count: usize, scale: impl Fn(usize) -> f64) -> Mat<f64> {
        Mat::from_fn(count, self.inverse.len(), |i, k| self.v[(start + i, k)] * scale(k))
    }
}

/// The step that a form's coefficients are rounded to: a power of ten.
fn rounding_step(mean_leverage: f64) -> i32 {
    if mean_leverage > 0.0 { (KEPT_DIGITS * mean_leverage).log10().floor() as i32 } else { 0 }
}

/// Rounded to a multiple of a power of ten, so that its shortest decimal is short.
fn rounded(mut form: Vec<f64>, step: i32) -> Vec<f64> {
    let scale = 10_f64.powi(-step);
    for c in &mut form {
        let multiple = (*c * scale).round();
        // From here on the number itself is no finer than the step.
        if multiple.abs() < 2_f64.powi(53) {
            *c = multiple / scale;
        }
    }
    form
}

/// Sums over the samples of one triangle.
struct Tally {
    /// `Σ w_ib w_ib' U_b(i)ᵀ U_b'(i)` by number of the pair.
    grams: Vec<(usize, Mat<f64>)>,
    /// By direction: `Σ w²`, and `Σ w² |r|²` of position and rotation.
    squares: Vec<(usize, [f64; 3])>,
}

fn each_direction(
    set: &SampleSet,
    factors: &[Factor],
    pairs: &Pairs,
    model: &DistortionModel,
    task: &Task,
) -> Result<FitValidityParts, Cancelled> {
    let order = model.order();
    let mut triangles: BTreeMap<Vec<usize>, Vec<usize>> = BTreeMap::new();
    for (i, sample) in set.samples.iter().enumerate() {
        let mut corners =
            model.directions().weights(&sample.axis, model.weighting()).directions.to_vec();
        corners.sort_unstable();
        corners.dedup();
        triangles.entry(corners).or_default().push(i);
    }
    let tallies: Vec<Tally> = triangles
        .par_iter()
        .map(|(corners, samples)| {
            task.step(0, 1)?;
            Ok(tally(set, corners, samples, factors, pairs, model))
        })
        .collect::<Result<_, Cancelled>>()?;
    let ranks: Vec<_> = factors.iter().map(|f| f.inverse.len()).collect();
    let mut grams: Vec<_> = pairs.iter().map(|[a, b]| Mat::zeros(ranks[a], ranks[b])).collect();
    let mut squares = vec![[0.0; 3]; factors.len()];
    for tally in tallies {
        for (pair, gram) in tally.grams {
            grams[pair] += gram;
        }
        for (direction, sums) in tally.squares {
            for (sum, add) in squares[direction].iter_mut().zip(sums) {
                *sum += add;
            }
        }
    }
    let noise = Noise::of(factors, &grams, &squares);
    let p = coefficient_count(order);
    let gains: Vec<_> =
        factors.iter().map(|f| f.scaled(0, p, |k| f.inverse[k] * f.filter[k])).collect();
    let steps: Vec<_> = factors.iter().map(|f| rounding_step(f.mean_leverage())).collect();
    let variance: Vec<_> = pairs
        .iter()
        .enumerate()
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(pair, [a, b])| {
            let matrix = &gains[a] * &grams[pair] * gains[b].transpose();
            rounded(both_ways(order, matrix, a == b), steps[a].min(steps[b]))
        })
        .collect();
    let leverage = factors
        .par_iter()
        .zip(&steps)
        .map(|(f, &step)| {
            let right = f.scaled(0, p, |k| f.inverse[k].powi(2) * f.filter[k]);
            rounded(coefficients(order, (&f.v * right.transpose()).as_ref()), step)
        })
        .collect();
    let undetermined = if factors.iter().any(|f| f.is_deficient) {
        factors
            .par_iter()
            .map(|f| match f.is_deficient {
                true => coefficients(order, projector(f.v.as_ref(), f.v.as_ref(), true).as_ref()),
                false => Vec::new(),
            })
            .collect()
    } else {
        Vec::new()
    };
    Ok(FitValidityParts {
        position_std_mm: noise.position_mm,
        angle_std_rad: set.has_rotations.then_some(noise.angle_rad),
        variance,
        leverage,
        undetermined,
        ..FitValidityParts::default()
    })
}

fn tally(
    set: &SampleSet,
    corners: &[usize],
    samples: &[usize],
    factors: &[Factor],
    pairs: &Pairs,
    model: &DistortionModel,
) -> Tally {
    let order = model.order();
    let p = coefficient_count(order);
    let directions: Vec<_> = corners
        .iter()
        .map(|&direction| {
            let f = &factors[direction];
            let coefficients = &model.coefficients()[direction * p..][..p];
            (
                direction,
                f.scaled(0, p, |k| f.inverse[k]),
                Mat::from_fn(p, 6, |i, k| coefficients[i][k]),
            )
        })
        .collect();
    let mut squares: Vec<_> = corners.iter().map(|&d| (d, [0.0; 3])).collect();
    let mut grams: Vec<_> = (0..corners.len())
        .flat_map(|a| (a..corners.len()).map(move |b| (a, b)))
        .map(|(a, b)| {
            let (rows, columns) = (directions[a].1.ncols(), directions[b].1.ncols());
            (pairs.index(corners[a], corners[b]), Mat::<f64>::zeros(rows, columns))
        })
        .collect();
    let mut products = Vec::new();
    for block in samples.chunks(BLOCK) {
        products.clear();
        for &i in block {
            let unit = model.bounds().to_unit(&set.samples[i].position_mm);
            push_products(order, &unit, &mut products);
        }
        let b = MatRef::from_row_major_slice(&products, block.len(), p);
        let weights: Vec<_> = block
            .iter()
            .map(|&i| model.directions().weights(&set.samples[i].axis, model.weighting()))
            .collect();
        let scaled: Vec<Mat<f64>> = directions
            .iter()
            .zip(&mut squares)
            .map(|((direction, inverse, coefficients), (_, sums))| {
                let modelled = b * coefficients;
                let mut rows = b * inverse;
                for (row, (&i, w)) in block.iter().zip(&weights).enumerate() {
                    let w2 = w.of(*direction).powi(2);
                    let residual = residual_squares(&set.samples[i], |k| modelled[(row, k)]);
                    sums[0] += w2;
                    sums[1] += w2 * residual[0];
                    sums[2] += w2 * residual[1];
                    for k in 0..rows.ncols() {
                        rows[(row, k)] *= w2;
                    }
                }
                rows
            })
            .collect();
        let mut at = grams.iter_mut();
        for a in 0..scaled.len() {
            for b in a..scaled.len() {
                if let Some((_, gram)) = at.next() {
                    *gram += scaled[a].transpose() * &scaled[b];
                }
            }
        }
    }
    Tally { grams, squares }
}

/// The form of a pair of directions, which counts in both orders.
fn both_ways(order: usize, matrix: Mat<f64>, is_same: bool) -> Vec<f64> {
    let times = if is_same { 1.0 } else { 2.0 };
    coefficients(order, (matrix * faer::Scale(times)).as_ref())
}

/// Squared lengths of what a model leaves of position and rotation.
fn residual_squares(sample: &Sample, model: impl Fn(usize) -> f64) -> [f64; 2] {
    let (p, r) = (&sample.error.position_mm, &sample.error.rotation_rad);
    [
        (0..3).map(|k| (p[k] - model(k)).powi(2)).sum(),
        (0..3).map(|k| (r[k] - model(3 + k)).powi(2)).sum(),
    ]
}

/// Standard deviations of a sample, summed over the axes, one a system.
struct Noise {
    position_mm: Vec<Option<f64>>,
    angle_rad: Vec<Option<f64>>,
}

/// Degrees of freedom below this part of a system's samples are round-off.
const NO_FREEDOM: f64 = 1e-9;

impl Noise {
    /// From the residuals of each direction and the degrees of freedom left in them,
    /// `tr((I - H) W² (I - H))`, with `H = U F Uᵀ` and `K = Uᵀ W² U`.
    fn of(factors: &[Factor], grams: &[Mat<f64>], squares: &[[f64; 3]]) -> Self {
        let freedom: Vec<f64> = factors
            .iter()
            .zip(grams)
            .zip(squares)
            .map(|((factor, gram), [weights, ..])| {
                let taken: f64 = factor
                    .filter
                    .iter()
                    .enumerate()
                    .map(|(k, f)| f * (2.0 - f) * gram[(k, k)])
                    .sum();
                let left = weights - taken;
                if left > NO_FREEDOM * weights { left } else { 0.0 }
            })
            .collect();
        let one = |value: usize| {
            let (all_squares, all_freedom) = freedom
                .iter()
                .zip(squares)
                .filter(|(f, _)| **f > 0.0)
                .fold((0.0, 0.0), |(s, f), (free, squares)| (s + squares[value], f + free));
            let pooled = (all_freedom > 0.0).then(|| all_squares / all_freedom);
            freedom
                .iter()
                .zip(squares)
                .map(|(&free, squares)| {
                    let variance = if free > 0.0 { Some(squares[value] / free) } else { pooled };
                    variance.map(f64::sqrt)
                })
                .collect()
        };
        Self { position_mm: one(1), angle_rad: one(2) }
    }
}

/// `I - V_a V_bᵀ`, with the identity only where the blocks are the same.
fn projector(a: MatRef<'_, f64>, b: MatRef<'_, f64>, is_same: bool) -> Mat<f64> {
    let product = a * b.transpose();
    Mat::from_fn(a.nrows(), b.nrows(), |i, j| {
        f64::from(u8::from(is_same && i == j)) - product[(i, j)]
    })
}

fn jointly(
    set: &SampleSet,
    factors: &[Factor],
    pairs: &Pairs,
    model: &DistortionModel,
    ridge: f64,
) -> FitValidityParts {
    let order = model.order();
    let p = coefficient_count(order);
    let Some(factor) = factors.first() else {
        return FitValidityParts::default();
    };
    let forms = |scale: &(dyn Fn(usize) -> f64 + Sync)| -> Vec<Vec<f64>> {
        let step = rounding_step(factor.mean_leverage());
        pairs
            .iter()
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|[a, b]| {
                let left = factor.scaled(a * p, p, scale);
                let right = factor.v.subrows(b * p, p);
                rounded(both_ways(order, &left * right.transpose(), a == b), step)
            })
            .collect()
    };
    let variance = forms(&|k| (factor.inverse[k] * factor.filter[k]).powi(2));
    let leverage = match ridge {
        0.0 => Vec::new(),
        _ => forms(&|k| factor.inverse[k].powi(2) * factor.filter[k]),
    };
    let undetermined = match factor.is_deficient {
        false => Vec::new(),
        true => pairs
            .iter()
            .map(|[a, b]| {
                let block = |d: usize| factor.v.subrows(d * p, p);
                both_ways(order, projector(block(a), block(b), a == b), a == b)
            })
            .collect(),
    };
    let squares = set
        .samples
        .iter()
        .map(|s| {
            let e =
                model.evaluate(&s.position_mm, &s.axis, crate::OutsidePolicy::Extrapolate).error;
            let e = [e.position_mm, e.rotation_rad];
            residual_squares(s, |k| e[k / 3][k % 3])
        })
        .fold([0.0; 2], |sum, s| [sum[0] + s[0], sum[1] + s[1]]);
    let rows = factor.rows as f64;
    let freedom = rows - factor.filter.iter().map(|f| f * (2.0 - f)).sum::<f64>();
    let std =
        |squares: f64| vec![(freedom > NO_FREEDOM * rows).then(|| (squares / freedom).sqrt())];
    FitValidityParts {
        position_std_mm: std(squares[0]),
        angle_std_rad: set.has_rotations.then(|| std(squares[1])),
        variance,
        leverage,
        undetermined,
        ..FitValidityParts::default()
    }
}
