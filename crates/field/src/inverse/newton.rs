//! Damped Newton on the five unknowns behind a reading, watching the sign of the determinant.

use super::equations::{AxisPose, Reading, Remainder, Tolerance};
use crate::computed::MadeOfCoils;
use crate::evaluation::Linearization;
use crate::{DistortionModel, OutsidePolicy};
use nalgebra::{Matrix5, Vector5};

/// Newton doubles the digits; damped steps through a strong field need some tens.
const MAX_STEPS: usize = 60;

/// Halvings of one step before the search gives up: 1/4096 of a Newton step.
const MAX_HALVINGS: usize = 12;

/// Part of the decrease that the linear model promises which a damped step has to reach (Armijo).
const SUFFICIENT: f64 = 1e-4;

/// Longest step of the axis, radians: its tangent plane does not hold further away.
const MAX_TURN_RAD: f64 = 0.5;

/// Determinant below which the map counts as folded there, where 1 is no distortion: the answer's
/// error is then more than a million times the residual.
pub(super) const SINGULAR: f64 = 1e-6;

/// Where a search ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub place: AxisPose,
    pub there: Linearization,
    pub remainder: Remainder,
    pub determinant: f64,
    /// The smallest determinant on the way, the end included.
    pub least_determinant: f64,
    /// The most that the inverse of the Jacobian lengthens anything, a radian counting like
    /// [`Newton::mm_per_rad`].
    pub magnification: f64,
    pub evaluations: usize,
    pub is_solution: bool,
}

impl Found {
    /// Whether the map keeps its handedness here and is not about to lose it.
    pub fn is_regular(&self) -> bool {
        self.determinant > SINGULAR
    }
}

/// One model, one policy, and what lengths weigh against angles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Newton<'a> {
    pub model: &'a DistortionModel,
    pub outside: OutsidePolicy,
    /// A radian of the axis counts like this length.
    pub mm_per_rad: f64,
}

struct Iterate {
    place: AxisPose,
    there: Linearization,
    remainder: Remainder,
    merit: f64,
}

impl<'a> Newton<'a> {
    /// Searches from a guess until the equations hold as exactly as they can.
    pub fn solve(&self, reading: &Reading, start: AxisPose, tolerance: &Tolerance) -> Found {
        let mut at = self.iterate(reading, start);
        let mut evaluations = 1;
        let mut least_determinant = f64::INFINITY;
        let mut determinant = f64::NAN;
        for _ in 0..MAX_STEPS {
            let jacobian = reading.jacobian(&at.place, &at.there);
            let lu = self.scaled(&jacobian).lu();
            determinant = lu.determinant();
            least_determinant = least_determinant.min(determinant);
            if at.remainder.is_reached(tolerance) || !determinant.is_finite() {
                break;
            }
            let Some(full) = lu.solve(&-self.scaled_remainder(&at.remainder)) else {
                break;
            };
            let full = self.bounded(&full);
            let mut next = None;
            let mut damping = 1.0;
            for _ in 0..=MAX_HALVINGS {
                let tried = self.iterate(reading, reading.moved(&at.place, &(full * damping)));
                evaluations += 1;
                if tried.merit <= at.merit * (1.0 - SUFFICIENT * damping) {
                    next = Some(tried);
                    break;
                }
                damping *= 0.5;
            }
            match next {
                Some(better) => at = better,
                // No way down: the best there is, for better or worse.
                None => break,
            }
        }
        let jacobian = self.scaled(&reading.jacobian(&at.place, &at.there));
        Found {
            magnification: jacobian.try_inverse().map_or(f64::INFINITY, |inverse| inverse.norm()),
            is_solution: at.remainder.is_accepted(tolerance)
                && self.is_read(at.there.at.is_inside, &at.place),
            place: at.place,
            there: at.there,
            remainder: at.remainder,
            determinant,
            least_determinant,
            evaluations,
        }
    }

    /// The coils whose disturbed fields the model's errors are made of.
    pub fn coils(&self) -> Option<MadeOfCoils<'a>> {
        self.model.computed()?.coils()
    }

    /// Whether the tracker reads a pose at a place that is, or is not, inside: in metal it does not.
    pub fn is_read(&self, is_inside: bool, place: &AxisPose) -> bool {
        if self.model.computed().is_none() {
            return true;
        }
        let bounds = self.model.bounds();
        let nearest = bounds.clamp(&place.position_mm);
        let of_nearest =
            || self.model.evaluate(&nearest, &place.axis, OutsidePolicy::Clamp).is_inside;
        is_inside || nearest != place.position_mm && of_nearest()
    }

    fn iterate(&self, reading: &Reading, place: AxisPose) -> Iterate {
        let there =
            self.model.evaluate_with_jacobian(&place.position_mm, &place.axis, self.outside);
        let remainder = reading.remainder(&place, &there.at.error);
        Iterate { place, there, remainder, merit: self.scaled_remainder(&remainder).norm_squared() }
    }

    fn scaled_remainder(&self, remainder: &Remainder) -> Vector5<f64> {
        let p = &remainder.position_mm;
        let [a, b] = remainder.axis_rad.map(|angle| angle * self.mm_per_rad);
        Vector5::new(p.x, p.y, p.z, a, b)
    }

    /// Rows and columns in mm throughout; the determinant stays the same.
    fn scaled(&self, jacobian: &Matrix5<f64>) -> Matrix5<f64> {
        let mut scaled = *jacobian;
        for k in 0..3 {
            for angle in 3..5 {
                scaled[(k, angle)] /= self.mm_per_rad;
                scaled[(angle, k)] *= self.mm_per_rad;
            }
        }
        scaled
    }

    /// A step in mm and radians, shortened where its turn is too long.
    fn bounded(&self, scaled: &Vector5<f64>) -> Vector5<f64> {
        let mut step = *scaled;
        step[3] /= self.mm_per_rad;
        step[4] /= self.mm_per_rad;
        let turn = step[3].hypot(step[4]);
        if turn > MAX_TURN_RAD {
            step *= MAX_TURN_RAD / turn;
        }
        step
    }
}
