//! Where a fit is valid: the standard error of its field, its leverage, and the distance to the
//! nearest sample.
//!
//! **Standard error.** A fit is linear in its samples' errors. With `g_b = V D Uᵀ` of direction b's
//! weighted system (`D = s/(s² + d²)`, d the ridge's damping) independent noise of standard deviation σ
//! in every sample moves the field (8) at `(u, n)` by a variance of
//! `σ² Σ_bb' w_b w_b' B(u)ᵀ Q_bb' B(u)`, `Q_bb' = V_b D_b K_bb' D_b' V_b'ᵀ`,
//! `K_bb' = Σ_i w_ib w_ib' U_b(i)ᵀ U_b'(i)`: directions share samples, and rows are scaled by other
//! weights than the noise. For a joint fit `Q` is made of blocks of `V D² Vᵀ`.
//! `σ_b² = Σ_i w_ib² |r_ib|² / tr((I − H) W² (I − H))` over a direction's own residuals `r_ib`, so that
//! misfit counts as noise where it is; a direction without a degree of freedom takes the others' mean.
//! σ² is summed over x, y, z. A bias (of a ridge, of a field that no polynomial follows) is not in it.
//! `tests/invariants/support.rs` compares it with 200 refits.
//!
//! **Leverage** is `h_b = w_b² B(u)ᵀ (AᵀA)⁺ B(u)`, that of the pose as a sample of direction b. A pose
//! with a greater one than any fitted sample extrapolates, even inside the box (Montgomery, Peck,
//! Vining, *Introduction to Linear Regression Analysis*, 3.8). The model is valid at a pose in the box
//! where no direction extrapolates and nothing lies in the null space of the fit.
//!
//! **Storage.** `B(u)ᵀ Q B(u)` is a polynomial of twice the order: `(2n + 1)³` coefficients for a
//! matrix of `(n + 1)⁶`.

use super::cells::Cells;
use super::form::FormBasis;
use crate::bernstein::MAX_ORDER;
use crate::evaluation::OutsidePolicy;
use crate::model::DistortionModel;
use nalgebra::{Point3, Unit, Vector3};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_geometry::limits::short;

/// Slack of the comparison with the samples' greatest leverage: round-off of sums of up to 25³
/// terms of one sign.
const LEVERAGE_SLACK: f64 = 1e-9;

/// A part of a pose in the null space counts as none where its square is below this: the
/// round-off of polynomials whose coefficients are at most 1.
pub(super) const NULL_TOLERANCE: f64 = 100.0 * f64::EPSILON;

/// What a fit knows about its own reach.
#[derive(Clone, Debug, PartialEq)]
pub struct FitValidity {
    pub(super) order: usize,
    pub(super) directions: DirectionSet,
    pub(super) weighting: Weighting,
    pub(super) bounds: Bounds,
    pub(super) pairs: Pairs,
    pub(super) parts: FitValidityParts,
}

/// The numbers that it is made of, as a file holds them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FitValidityParts {
    /// σ of the samples' position, one a system (direction, or one for all of a joint fit); `None` where
    /// there is no degree of freedom.
    pub position_std_mm: Vec<Option<f64>>,
    /// Likewise of their rotation vectors; `None` where orientations were not measured.
    pub angle_std_rad: Option<Vec<Option<f64>>>,
    /// Greatest leverage of the samples, one a system.
    pub greatest_leverage: Vec<f64>,
    /// Greatest squared part of the samples in what is not determined, one a system.
    pub greatest_undetermined: Vec<f64>,
    /// `B Q B` of every direction, then of every edge between neighbours, both ways added up.
    pub variance: Vec<Vec<f64>>,
    /// `B (AᵀA)⁺ B` of every direction, of every edge too for a joint fit; empty where it is the
    /// variance (one system without ridge).
    pub leverage: Vec<Vec<f64>>,
    /// Squared part in the null space: of every direction, for a joint fit of every edge too.
    /// Empty where nothing is undetermined; a form without coefficients is zero.
    pub undetermined: Vec<Vec<f64>>,
    pub cells: Cells,
}

/// What a model's answer at one pose depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitValidityAt {
    /// RMS length of the error vector of the field's position; infinite where it is not determined.
    pub position_std_error_mm: f64,
    /// Likewise of the rotation; `None` where orientations were not measured.
    pub angle_std_error_rad: Option<f64>,
    /// Of the pose as a sample, the largest over the directions; infinite where not determined.
    pub leverage: f64,
    pub is_valid: bool,
    /// To the nearest sample, the largest over the directions that the pose weighs; infinite
    /// where one has none.
    pub distance_mm: f64,
}

/// Numbers that make no validity.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitValidityPartsError {
    #[error("{name} has {found} entries, expected {expected}")]
    Count { name: &'static str, found: usize, expected: usize },
    #[error("{name} holds {}, expected {expected}", short(*found))]
    Value { name: &'static str, found: f64, expected: &'static str },
    #[error("a model of order 0 has none")]
    NoOrder,
}

impl FitValidity {
    /// The validity from what a file holds, for the model that stands beside it.
    pub fn from_parts(
        parts: FitValidityParts,
        model: &DistortionModel,
    ) -> Result<Self, FitValidityPartsError> {
        let pairs = Pairs::of(model.directions());
        check(&parts, &pairs, model)?;
        Ok(Self::new(parts, pairs, model))
    }

    pub(super) fn new(parts: FitValidityParts, pairs: Pairs, model: &DistortionModel) -> Self {
        Self {
            order: model.order(),
            directions: model.directions(),
            weighting: model.weighting(),
            bounds: *model.bounds(),
            pairs,
            parts,
        }
    }

    /// The numbers, as a file holds them.
    pub fn parts(&self) -> &FitValidityParts {
        &self.parts
    }

    /// Whether one system holds all directions.
    pub(super) fn is_joint(&self) -> bool {
        self.parts.position_std_mm.len() == 1
    }

    /// The system that a direction's coefficients are from.
    pub(super) fn system(&self, direction: usize) -> usize {
        if self.is_joint() { 0 } else { direction }
    }

    /// What the model's field at a position in the tracker frame and a unit axis depends on. Under
    /// [`OutsidePolicy::Clamp`] figures are those of the nearest point of the box, but outside it
    /// nothing is valid, and the distance is the position's own.
    pub fn at(
        &self,
        position_mm: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
        outside: OutsidePolicy,
    ) -> FitValidityAt {
        let bounds = &self.bounds;
        let at = match outside {
            OutsidePolicy::Extrapolate => *position_mm,
            OutsidePolicy::Clamp | OutsidePolicy::Reject => bounds.clamp(position_mm),
        };
        let (basis, weights) = self.placed(&at, axis);
        let reach = self.reach(&basis, &weights);
        let is_determined = reach.is_determined;
        let mut variance = [0.0; 6];
        if is_determined {
            for (value, (_, _, pair)) in variance.iter_mut().zip(weights.pairs(&self.pairs)) {
                *value = basis.value(&self.parts.variance[pair]);
            }
        }
        let std_error = |std: &[Option<f64>]| {
            if is_determined { self.std_error(&variance, &weights, std) } else { f64::INFINITY }
        };
        FitValidityAt {
            position_std_error_mm: std_error(&self.parts.position_std_mm),
            angle_std_error_rad: self.parts.angle_std_rad.as_deref().map(std_error),
            leverage: if is_determined { reach.leverage } else { f64::INFINITY },
            is_valid: is_determined && reach.is_within && bounds.contains(position_mm),
            distance_mm: self.distance_mm(position_mm, &weights),
        }
    }

    /// Leverage of a pose as a sample against the greatest of the fitted samples, the largest such
    /// share over the directions that it weighs. Infinite outside the box, and where the fit leaves
    /// the pose undetermined.
    pub fn leverage_share(&self, position_mm: &Point3<f64>, axis: &Unit<Vector3<f64>>) -> f64 {
        if !self.bounds.contains(position_mm) {
            return f64::INFINITY;
        }
        let parts = &self.parts;
        let (basis, weights) = self.placed(&self.bounds.clamp(position_mm), axis);
        let mut most = 0.0_f64;
        self.each_leverage(&basis, &weights, |system, leverage, undetermined| {
            let is_determined =
                undetermined <= parts.greatest_undetermined[system].max(NULL_TOLERANCE);
            let share = match leverage > 0.0 {
                true => leverage / parts.greatest_leverage[system],
                false => 0.0,
            };
            most = most.max(if is_determined { share } else { f64::INFINITY });
        });
        most
    }

    /// As [`FitValidityAt::is_valid`], without the other figures, which cost more.
    pub fn is_valid(&self, position_mm: &Point3<f64>, axis: &Unit<Vector3<f64>>) -> bool {
        self.leverage_share(position_mm, axis) <= 1.0 + LEVERAGE_SLACK
    }

    /// As [`Self::at`]; for a marker, which has no axis, the worst over the basis orientations, whose
    /// mean is its error, and no angle.
    pub fn at_sensor(
        &self,
        position_mm: &Point3<f64>,
        axis: Option<&Unit<Vector3<f64>>>,
        outside: OutsidePolicy,
    ) -> FitValidityAt {
        if let Some(axis) = axis {
            return self.at(position_mm, axis, outside);
        }
        let each = self.directions.directions().iter();
        let worst =
            each.map(|axis| self.at(position_mm, axis, outside)).reduce(|a, b| FitValidityAt {
                position_std_error_mm: a.position_std_error_mm.max(b.position_std_error_mm),
                angle_std_error_rad: None,
                leverage: a.leverage.max(b.leverage),
                is_valid: a.is_valid && b.is_valid,
                distance_mm: a.distance_mm.max(b.distance_mm),
            });
        FitValidityAt {
            angle_std_error_rad: None,
            ..worst.unwrap_or_else(|| self.at(position_mm, &Vector3::z_axis(), outside))
        }
    }

    /// As [`FitValidityAt::is_valid`] of [`Self::at_sensor`], without the other figures.
    pub fn is_sensor_valid(
        &self,
        position_mm: &Point3<f64>,
        axis: Option<&Unit<Vector3<f64>>>,
    ) -> bool {
        let axes = axis.map_or(self.directions.directions(), std::slice::from_ref);
        axes.iter().all(|axis| self.is_valid(position_mm, axis))
    }

    /// As [`FitValidityAt::distance_mm`] of [`Self::at_sensor`], without the other figures.
    pub(super) fn sensor_distance_mm(
        &self,
        position_mm: &Point3<f64>,
        axis: Option<&Unit<Vector3<f64>>>,
    ) -> f64 {
        let axes = axis.map_or(self.directions.directions(), std::slice::from_ref);
        let of_axis = |axis: &Unit<Vector3<f64>>| {
            let weights = self.directions.weights(axis, self.weighting);
            self.distance_mm(position_mm, &AxisWeights::new(&weights.directions, &weights.weights))
        };
        axes.iter().map(of_axis).fold(0.0, f64::max)
    }

    /// What the forms are evaluated with.
    pub(super) fn placed(
        &self,
        at: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
    ) -> (FormBasis, AxisWeights) {
        let weights = self.directions.weights(axis, self.weighting);
        (
            FormBasis::new(2 * self.order, &self.bounds.to_unit(at)),
            AxisWeights::new(&weights.directions, &weights.weights),
        )
    }

    fn distance_mm(&self, position_mm: &Point3<f64>, weights: &AxisWeights) -> f64 {
        weights
            .iter()
            .map(|(direction, _)| self.parts.cells.distance_mm(position_mm, direction))
            .fold(0.0, f64::max)
    }

    /// What the pose would be as a sample: leverage against the greatest, undetermined part against
    /// the greatest.
    fn reach(&self, basis: &FormBasis, weights: &AxisWeights) -> Reach {
        let parts = &self.parts;
        let mut reach = Reach { leverage: 0.0, is_within: true, is_determined: true };
        self.each_leverage(basis, weights, |system, leverage, undetermined| {
            reach.leverage = reach.leverage.max(leverage);
            reach.is_within &= leverage <= parts.greatest_leverage[system] * (1.0 + LEVERAGE_SLACK);
            reach.is_determined &=
                undetermined <= parts.greatest_undetermined[system].max(NULL_TOLERANCE);
        });
        reach
    }

    /// Visits each system that a pose would be a sample of: its number, the leverage there, and
    /// the squared part that the system leaves undetermined.
    pub(super) fn each_leverage(
        &self,
        basis: &FormBasis,
        weights: &AxisWeights,
        mut visit: impl FnMut(usize, f64, f64),
    ) {
        let leverage = match self.parts.leverage.as_slice() {
            [] => self.parts.variance.as_slice(),
            leverage => leverage,
        };
        let undetermined = self.parts.undetermined.as_slice();
        let value = |forms: &[Vec<f64>], i: usize| forms.get(i).map_or(0.0, |f| basis.value(f));
        if self.is_joint() {
            let (mut all, mut off_diagonal) = (0.0, 0.0);
            for ((_, wa), (_, wb), pair) in weights.pairs(&self.pairs) {
                all += wa * wb * value(leverage, pair);
                off_diagonal += wa * wb * value(undetermined, pair);
            }
            visit(0, all, off_diagonal);
        } else {
            for (d, w) in weights.iter() {
                let w2 = w * w;
                visit(d, w2 * value(leverage, d), w2 * value(undetermined, d));
            }
        }
    }

    /// From the values of the pairs' variances, in the pairs' order.
    pub(super) fn std_error(
        &self,
        variance: &[f64; 6],
        weights: &AxisWeights,
        std: &[Option<f64>],
    ) -> f64 {
        let std = |(direction, w): (usize, f64)| Some(w * std[self.system(direction)]?);
        let sum: Option<f64> = weights
            .pairs(&self.pairs)
            .zip(variance)
            .map(|((a, b, _), value)| Some(std(a)? * std(b)? * value))
            .sum();
        sum.map_or(f64::INFINITY, |variance| variance.max(0.0).sqrt())
    }
}

struct Reach {
    leverage: f64,
    is_within: bool,
    is_determined: bool,
}

/// Directions with a weight that is not zero.
pub(super) struct AxisWeights {
    entries: [(usize, f64); 3],
    len: usize,
}

impl AxisWeights {
    pub(super) fn new(directions: &[usize; 3], weights: &[f64; 3]) -> Self {
        let mut found = Self { entries: [(0, 0.0); 3], len: 0 };
        for (&direction, &w) in directions.iter().zip(weights) {
            if w > 0.0 {
                found.entries[found.len] = (direction, w);
                found.len += 1;
            }
        }
        found
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.entries[..self.len].iter().copied()
    }

    /// Each two of them (and each by itself) with the number of the pair, at most six.
    pub(super) fn pairs<'a>(
        &'a self,
        pairs: &'a Pairs,
    ) -> impl Iterator<Item = ((usize, f64), (usize, f64), usize)> + 'a {
        self.iter()
            .enumerate()
            .flat_map(move |(i, a)| self.iter().skip(i).map(move |b| (a, b, pairs.index(a.0, b.0))))
    }
}

/// A set's directions and the edges between neighbours, numbered: directions first, then edges
/// with the lower direction first.
#[derive(Clone, Debug, PartialEq)]
pub struct Pairs {
    directions: usize,
    edges: Vec<[usize; 2]>,
    /// Number of a pair, for each two directions; those that share no triangle are never requested.
    numbers: Vec<usize>,
}

impl Pairs {
    pub fn of(set: DirectionSet) -> Self {
        let directions = set.len();
        let mut edges: Vec<[usize; 2]> = set
            .triangles()
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [a, c]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let mut numbers = vec![usize::MAX; directions * directions];
        for d in 0..directions {
            numbers[d * directions + d] = d;
        }
        for (i, &[a, b]) in edges.iter().enumerate() {
            numbers[a * directions + b] = directions + i;
            numbers[b * directions + a] = directions + i;
        }
        Self { directions, edges, numbers }
    }

    pub fn len(&self) -> usize {
        self.directions + self.edges.len()
    }

    pub(super) fn index(&self, a: usize, b: usize) -> usize {
        self.numbers[a * self.directions + b]
    }

    /// All pairs in their order.
    pub(super) fn iter(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        (0..self.directions).map(|d| [d, d]).chain(self.edges.iter().copied())
    }
}

fn check(
    parts: &FitValidityParts,
    pairs: &Pairs,
    model: &DistortionModel,
) -> Result<(), FitValidityPartsError> {
    debug_assert!(model.order() <= MAX_ORDER);
    if model.order() == 0 {
        return Err(FitValidityPartsError::NoOrder);
    }
    let directions = model.directions().len();
    let is_joint = parts.position_std_mm.len() == 1;
    let (systems, forms_each) = if is_joint { (1, pairs.len()) } else { (directions, directions) };
    let count = |name, found, expected| {
        if found == expected {
            Ok(())
        } else {
            Err(FitValidityPartsError::Count { name, found, expected })
        }
    };
    let wrong = |name, found, expected| Err(FitValidityPartsError::Value { name, found, expected });
    let values = |name, values: &[f64]| match values.iter().find(|v| !(v.is_finite() && **v >= 0.0))
    {
        Some(&found) => wrong(name, found, "zero or more"),
        None => Ok(()),
    };
    let some = |std: &[Option<f64>]| std.iter().flatten().copied().collect::<Vec<_>>();
    count("position_std_mm", parts.position_std_mm.len(), systems)?;
    values("position_std_mm", &some(&parts.position_std_mm))?;
    if let Some(std) = &parts.angle_std_rad {
        count("angle_std_rad", std.len(), systems)?;
        values("angle_std_rad", &some(std))?;
    }
    count("greatest_leverage", parts.greatest_leverage.len(), systems)?;
    values("greatest_leverage", &parts.greatest_leverage)?;
    count("greatest_undetermined", parts.greatest_undetermined.len(), systems)?;
    values("greatest_undetermined", &parts.greatest_undetermined)?;
    let coefficients = (2 * model.order() + 1).pow(3);
    let forms = |name, forms: &[Vec<f64>], expected: usize, may_be_zero: bool| {
        count(name, forms.len(), expected)?;
        for form in forms.iter().filter(|f| !(may_be_zero && f.is_empty())) {
            count(name, form.len(), coefficients)?;
            if let Some(&found) = form.iter().find(|v| !v.is_finite()) {
                return wrong(name, found, "finite numbers");
            }
        }
        Ok(())
    };
    forms("variance", &parts.variance, pairs.len(), false)?;
    if !(is_joint && parts.leverage.is_empty()) {
        forms("leverage", &parts.leverage, forms_each, false)?;
    }
    if !parts.undetermined.is_empty() {
        forms("undetermined", &parts.undetermined, forms_each, true)?;
    }
    parts.cells.check(directions)
}
