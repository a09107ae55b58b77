//! All answers to a reading that a search from several starts finds, for fields that may fold.

use super::contraction::stepped;
use super::equations::{AxisPose, Reading, Tolerance};
use super::newton::{Found, Newton};
use super::regions::Possible;
use crate::OutsidePolicy;
use crate::evaluation::Evaluation;
use nalgebra::{Point3, Unit, Vector3};

/// Answers closer than this part of the box, or this many radians, are one: two that merge in a
/// fold are distinct until the determinant there is as small.
const SAME: f64 = 1e-6;

/// Turns of the axis below which other starts for it are of no use: so small a region around the
/// reading is searched by any start.
const SMALL_TURN_RAD: f64 = 0.2;

/// What is left at an answer that the coils' signals have led to, at most.
const NEARLY_MM: f64 = 1e-4;
const NEARLY_RAD: f64 = 1e-6;

/// What a search found.
pub(super) struct Search {
    /// From the first start, wherever it ended.
    pub first: Found,
    /// Different answers, in the order in which they were found.
    pub answers: Vec<Found>,
    pub evaluations: usize,
}

impl Search {
    /// After a first search, searches from other starts, and, unless there can be one answer only,
    /// from wherever else one can be, until a fourth one turns up.
    pub fn run(
        newton: &Newton,
        possible: &Possible,
        reading: &Reading,
        tolerance: &Tolerance,
        first: Found,
        others: Vec<AxisPose>,
    ) -> Self {
        let mut search = Self { first, answers: Vec::new(), evaluations: first.evaluations };
        search.see(newton, first);
        let is_signals = !others.is_empty();
        let others = match possible.is_certain() || possible.is_too_steep() {
            true => others,
            false => starts(newton, possible, &reading.place, &search.first.place),
        };
        for start in others {
            if search.answers.len() > 3 && search.best(&reading.place).is_some() {
                break;
            }
            let mut found = newton.solve(reading, start, tolerance);
            search.evaluations += found.evaluations + 1;
            // So near to metal that there are no differences, Newton makes nothing more exact.
            found.is_solution |= is_signals
                && newton.is_read(found.there.at.is_inside, &found.place)
                && found.remainder.length_mm() < NEARLY_MM
                && found.remainder.angle_rad() < NEARLY_RAD;
            search.see(newton, found);
        }
        search
    }

    /// Of the answers around which the map keeps its handedness, the nearest to the reading.
    pub fn best(&self, reading: &AxisPose) -> Option<&Found> {
        let distance = |f: &&Found| (f.place.position_mm - reading.position_mm).norm();
        let regular = self.answers.iter().filter(|f| f.is_regular());
        regular.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// Other answers than one.
    pub fn others(&self, found: &Found) -> impl Iterator<Item = &Found> {
        self.answers.iter().filter(|other| other.place != found.place)
    }

    /// All others; nothing where there may be more.
    pub fn two_others(&self, found: &Found) -> [Option<&Found>; 2] {
        let mut others = self.others(found);
        match [others.next(), others.next(), others.next()] {
            [one, other, None] => [one, other],
            _ => [None; 2],
        }
    }

    fn see(&mut self, newton: &Newton, found: Found) {
        // What was left out by policy when it was measured is no answer to what was not.
        let is_excluded = newton.outside == OutsidePolicy::Reject
            && !found.there.at.is_inside
            && !self.answers.is_empty();
        let is_known = |known: &Found| is_same(newton, &known.place, &found.place);
        if found.is_solution && !is_excluded && !self.answers.iter().any(is_known) {
            self.answers.push(found);
        }
    }
}

/// Whether two answers are one.
pub(super) fn is_same(newton: &Newton, a: &AxisPose, b: &AxisPose) -> bool {
    let [mm, rad] = apart(a, b);
    mm <= SAME * newton.mm_per_rad && rad <= SAME
}

/// Distance in mm and angle in radians.
pub(super) fn apart(a: &AxisPose, b: &AxisPose) -> [f64; 2] {
    let sine = a.axis.cross(&b.axis).norm();
    [(a.position_mm - b.position_mm).norm(), sine.atan2(a.axis.dot(&b.axis))]
}

/// The found place mirrored in the reading, the middles of the cells that can hold an answer, and,
/// where errors turn axes far, axes around the reading's.
fn starts(
    newton: &Newton,
    possible: &Possible,
    reading: &AxisPose,
    found: &AxisPose,
) -> Vec<AxisPose> {
    let mirrored = reading.position_mm - (found.position_mm - reading.position_mm);
    let mut starts: Vec<_> = std::iter::once(mirrored)
        .chain(possible.starts.iter().copied())
        .map(|p| at_position(newton, reading, p))
        .collect();
    let largest_rad = possible.largest_rad.min(std::f64::consts::FRAC_PI_2);
    if largest_rad > SMALL_TURN_RAD {
        let [first, second] = Reading::new(*reading).tangents_at(&reading.axis);
        for side in [first, -first, second, -second] {
            let axis = reading.axis.as_ref() * largest_rad.cos() + side * largest_rad.sin();
            starts
                .push(AxisPose { position_mm: found.position_mm, axis: Unit::new_normalize(axis) });
        }
    }
    starts
}

/// A start at a position, with the axis that the error there leads back to.
fn at_position(newton: &Newton, reading: &AxisPose, position_mm: Point3<f64>) -> AxisPose {
    let Evaluation { error, .. } =
        newton.model.evaluate(&position_mm, &reading.axis, newton.outside);
    AxisPose { position_mm, axis: stepped(reading, &error).axis }
}

/// How far an axis is from the nearest edge of its triangle, radians.
pub(super) fn edge_distance_rad(newton: &Newton, axis: &Unit<Vector3<f64>>) -> f64 {
    use trackwright_geometry::directions::Weighting;
    let set = newton.model.directions();
    let corners =
        set.weights(axis, Weighting::Gnomonic).directions.map(|d| set.directions()[d].into_inner());
    (0..3)
        .map(|k| {
            let normal = corners[(k + 1) % 3].cross(&corners[(k + 2) % 3]);
            (axis.dot(&normal) / normal.norm()).abs().min(1.0).asin()
        })
        .fold(f64::INFINITY, f64::min)
}
