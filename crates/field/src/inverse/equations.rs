//! The equations behind a reading, `p + e_pos(p, n) = p_m` and `exp(e_ori(p, n)) n = n_m`: what is
//! left of them at a guess, their Jacobian in five unknowns, and how exactly they can hold.

use super::regions::Regions;
use crate::DistortionModel;
use crate::evaluation::Linearization;
use crate::samples::PoseError;
use nalgebra::{Matrix5, Point3, Unit, Vector3, Vector5};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::perpendicular;

/// A position and an axis: the five unknowns, or the five numbers that were read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisPose {
    pub position_mm: Point3<f64>,
    pub axis: Unit<Vector3<f64>>,
}

impl AxisPose {
    pub fn of(pose: &Pose) -> Self {
        Self {
            position_mm: pose.translation.vector.into(),
            axis: pose.rotation * Vector3::z_axis(),
        }
    }

    pub fn is_finite(&self) -> bool {
        self.position_mm.iter().chain(self.axis.iter()).all(|v| v.is_finite())
    }
}

/// What was read, with a frame of its tangent plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    pub place: AxisPose,
    tangents: [Vector3<f64>; 2],
}

/// What is left of the equations: a length, and an angle in the reading's tangent frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Remainder {
    pub position_mm: Vector3<f64>,
    pub axis_rad: [f64; 2],
}

impl Remainder {
    pub fn length_mm(&self) -> f64 {
        self.position_mm.norm()
    }

    pub fn angle_rad(&self) -> f64 {
        self.axis_rad[0].hypot(self.axis_rad[1])
    }

    pub fn is_reached(&self, tolerance: &Tolerance) -> bool {
        tolerance.is_reached(self.length_mm(), self.angle_rad())
    }

    pub fn is_accepted(&self, tolerance: &Tolerance) -> bool {
        tolerance.is_accepted(self.length_mm(), self.angle_rad())
    }
}

impl Reading {
    pub fn new(place: AxisPose) -> Self {
        let first = perpendicular(&place.axis).into_inner();
        Self { place, tangents: [first, place.axis.cross(&first)] }
    }

    /// What is left of the equations at a guess with this error.
    pub fn remainder(&self, guess: &AxisPose, error: &PoseError) -> Remainder {
        let turned = Turn::new(&error.rotation_rad).apply(&guess.axis);
        Remainder {
            position_mm: (guess.position_mm - self.place.position_mm) + error.position_mm,
            axis_rad: self.angles_to(&turned),
        }
    }

    /// The rotation vector from the read axis, as two angles along the tangents.
    fn angles_to(&self, axis: &Vector3<f64>) -> [f64; 2] {
        let [x, y] = self.tangents.map(|t| t.dot(axis));
        let sine = x.hypot(y);
        let cosine = self.place.axis.dot(axis);
        if sine == 0.0 {
            return if cosine > 0.0 { [0.0; 2] } else { [std::f64::consts::PI, 0.0] };
        }
        let scale = sine.atan2(cosine) / sine;
        [x * scale, y * scale]
    }

    /// The frame of a guess's tangent plane that the unknowns are steps in. Both frames are
    /// right-handed with their axes, so that the determinant's sign is that of the map.
    pub fn tangents_at(&self, axis: &Unit<Vector3<f64>>) -> [Vector3<f64>; 2] {
        let along = self.tangents[0] - axis.as_ref() * axis.dot(&self.tangents[0]);
        let first = Unit::try_new(along, 1e-3).unwrap_or_else(|| perpendicular(axis));
        [first.into_inner(), axis.cross(&first)]
    }

    /// The Jacobian of the equations: three rows in mm, two in radians; columns x, y, z in mm and
    /// two radians along [`Self::tangents_at`].
    ///
    /// `d(exp(e) n) = (J de) × m + exp(e) dn` with `m = exp(e) n` and the left Jacobian `J` of the
    /// rotations, projected on the reading's tangents. Angles beyond the first order of their
    /// sine are left out: they vanish at a solution.
    pub fn jacobian(&self, guess: &AxisPose, there: &Linearization) -> Matrix5<f64> {
        let turn = Turn::new(&there.at.error.rotation_rad);
        let turned = turn.apply(&guess.axis);
        let steps = self.tangents_at(&guess.axis);
        let mut jacobian = Matrix5::zeros();
        for row in 0..3 {
            for column in 0..3 {
                jacobian[(row, column)] = there.by_position[(row, column)];
            }
            jacobian[(row, row)] += 1.0;
            for (column, step) in steps.iter().enumerate() {
                jacobian[(row, 3 + column)] =
                    (0..3).map(|k| there.by_axis[(row, k)] * step[k]).sum();
            }
        }
        for (row, tangent) in self.tangents.iter().enumerate() {
            // t · ((J de) × m) = (Jᵀ (m × t)) · de
            let by_error = turn.left_jacobian_transposed(&turned.cross(tangent));
            let back = turn.apply_back(tangent);
            for column in 0..3 {
                jacobian[(3 + row, column)] =
                    (0..3).map(|k| by_error[k] * there.by_position[(3 + k, column)]).sum();
            }
            for (column, step) in steps.iter().enumerate() {
                let by_axis = there.by_axis.fixed_rows::<3>(3) * step;
                jacobian[(3 + row, 3 + column)] = by_error.dot(&by_axis) + back.dot(step);
            }
        }
        jacobian
    }

    /// The guess moved by five unknowns in its tangent frame.
    pub fn moved(&self, guess: &AxisPose, step: &Vector5<f64>) -> AxisPose {
        let [first, second] = self.tangents_at(&guess.axis);
        AxisPose {
            position_mm: guess.position_mm + step.fixed_rows::<3>(0),
            axis: Unit::new_normalize(guess.axis.as_ref() + first * step[3] + second * step[4]),
        }
    }
}

/// `exp(-e) v`.
#[inline]
pub(super) fn turned_back(vector_rad: &Vector3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    let squared = vector_rad.norm_squared();
    // Errors of sensors are a few degrees: no sine, no root.
    if squared >= SERIES_BELOW_RAD * SERIES_BELOW_RAD {
        return Turn::new(vector_rad).apply_back(v);
    }
    let (sine, versine) = sine_and_versine(squared);
    let once = vector_rad.cross(v);
    v - once * sine + vector_rad.cross(&once) * versine
}

/// Angle below which the series of [`sine_and_versine`] leave out less than the last bit: the
/// next terms are `θ¹⁴ / 15!` and `θ¹⁴ / 16!`.
const SERIES_BELOW_RAD: f64 = 0.4;

/// `sin θ / θ` and `(1 - cos θ) / θ²` of a squared angle.
#[inline]
fn sine_and_versine(t: f64) -> (f64, f64) {
    (
        1.0 - t / 6.0
            * (1.0
                - t / 20.0
                    * (1.0 - t / 42.0 * (1.0 - t / 72.0 * (1.0 - t / 110.0 * (1.0 - t / 156.0))))),
        0.5 * (1.0
            - t / 12.0
                * (1.0
                    - t / 30.0
                        * (1.0
                            - t / 56.0
                                * (1.0 - t / 90.0 * (1.0 - t / 132.0 * (1.0 - t / 182.0)))))),
    )
}

/// A rotation vector with the functions of its angle that rotations are made of.
pub(super) struct Turn {
    vector_rad: Vector3<f64>,
    /// `sin θ / θ`, `(1 - cos θ) / θ²`, `(θ - sin θ) / θ³`.
    sine: f64,
    versine: f64,
    third: f64,
}

impl Turn {
    pub fn new(vector_rad: &Vector3<f64>) -> Self {
        let squared = vector_rad.norm_squared();
        let (sine, versine, third) = if squared < SERIES_BELOW_RAD * SERIES_BELOW_RAD {
            let (sine, versine) = sine_and_versine(squared);
            let t = squared;
            let third = 1.0
                - t / 20.0
                    * (1.0 - t / 42.0 * (1.0 - t / 72.0 * (1.0 - t / 110.0 * (1.0 - t / 156.0))));
            (sine, versine, third / 6.0)
        } else {
            let angle = squared.sqrt();
            let half = (0.5 * angle).sin();
            (
                angle.sin() / angle,
                2.0 * half * half / squared,
                (angle - angle.sin()) / (squared * angle),
            )
        };
        Self { vector_rad: *vector_rad, sine, versine, third }
    }

    pub fn apply(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let once = self.vector_rad.cross(v);
        v + once * self.sine + self.vector_rad.cross(&once) * self.versine
    }

    pub fn apply_back(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let once = self.vector_rad.cross(v);
        v - once * self.sine + self.vector_rad.cross(&once) * self.versine
    }

    /// `Jᵀ v` with `exp(e + de) = exp(J de) exp(e)` to first order.
    fn left_jacobian_transposed(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let once = self.vector_rad.cross(v);
        v - once * self.versine + self.vector_rad.cross(&once) * self.third
    }
}

/// Residual below which a position counts as found, mm, where round-off allows.
pub const POSITION_TOLERANCE_MM: f64 = 1e-9;

/// Residual below which an axis counts as found, radians, where round-off allows.
pub const AXIS_TOLERANCE_RAD: f64 = 1e-12;

/// How much further than the tolerances the search goes where it can: an answer is off by its
/// residual times what the inverse magnifies.
const FURTHER: f64 = 1e-2;

/// Roundings of a coordinate that meet in one residual, each half an epsilon of it: the guess, its
/// sum with the error, the difference from the reading, and on the way to the unit cube a
/// difference and a quotient, with room for the norm of three.
const ROUNDINGS: f64 = 8.0;

/// Bounds of one reading's residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tolerance {
    reached_mm: f64,
    reached_rad: f64,
    accepted_mm: f64,
    accepted_rad: f64,
}

impl Tolerance {
    pub fn of(model: &DistortionModel, regions: &Regions, reading: &AxisPose) -> Self {
        let half = 0.5 * f64::EPSILON;
        let errors = &regions.errors;
        let error_mm = errors.least_mm.abs().sup(&errors.largest_mm.abs()).norm();
        let slopes = &regions.everywhere;
        // A guess cannot be written down more exactly than to half an epsilon of its coordinates,
        // and the field turns that into an error as well.
        let coordinates = ROUNDINGS * (reading.position_mm.coords.norm() + error_mm);
        // Sums over i, j, k are sums of n + 1 products three deep, the bases take n steps each.
        let per_value = ROUNDINGS + 6.0 * model.order() as f64;
        let floor_mm = half * ((1.0 + slopes.pp) * coordinates + per_value * error_mm);
        let floor_rad =
            half * (ROUNDINGS + slopes.np * coordinates + per_value * errors.largest_rad);
        Self {
            reached_mm: floor_mm.max(FURTHER * POSITION_TOLERANCE_MM),
            reached_rad: floor_rad.max(FURTHER * AXIS_TOLERANCE_RAD),
            accepted_mm: floor_mm.max(POSITION_TOLERANCE_MM),
            accepted_rad: floor_rad.max(AXIS_TOLERANCE_RAD),
        }
    }

    /// Whether the search can end.
    pub fn is_reached(&self, residual_mm: f64, residual_rad: f64) -> bool {
        residual_mm <= self.reached_mm && residual_rad <= self.reached_rad
    }

    /// The same for squares.
    #[inline]
    pub fn is_reached_squared(&self, residual_mm2: f64, residual_rad2: f64) -> bool {
        residual_mm2 <= self.reached_mm * self.reached_mm
            && residual_rad2 <= self.reached_rad * self.reached_rad
    }

    /// Whether the equations hold as exactly as they have to.
    pub fn is_accepted(&self, residual_mm: f64, residual_rad: f64) -> bool {
        residual_mm <= self.accepted_mm && residual_rad <= self.accepted_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_geometry::rotation::{axis_rotation, exp_vector};

    #[test]
    fn turn_is_the_rotation_at_every_angle() {
        let v = Vector3::new(0.3, -0.5, 0.81);
        let direction = Vector3::new(0.6, 0.64, -0.48);
        for angle in [0.0, 1e-12, 1e-3, 0.1, 0.399, 0.4, 0.401, 1.0, 3.0, 3.2, 7.0] {
            let e = direction * angle;
            let rotation = exp_vector(&e);
            let turn = Turn::new(&e);
            assert!((turn.apply(&v) - rotation * v).norm() < 1e-15 * (1.0 + angle));
            assert!((turn.apply_back(&v) - rotation.inverse() * v).norm() < 1e-15 * (1.0 + angle));
            assert!((turned_back(&e, &v) - turn.apply_back(&v)).norm() < 4e-16);
        }
    }

    #[test]
    fn the_left_jacobian_is_that_of_finite_differences() {
        let direction = Vector3::new(0.6, 0.64, -0.48);
        let (v, step) = (Vector3::new(0.3, -0.5, 0.81), Vector3::new(-0.2, 0.9, 0.4));
        for angle in [1e-6, 0.1, 0.399, 0.401, 2.0] {
            let e = direction * angle;
            let h = 1e-5;
            let turned = |e: Vector3<f64>| exp_vector(&e) * v;
            let difference = (turned(e + step * h) - turned(e - step * h)) / (2.0 * h);
            // For any w: w · ((J de) × m) = (Jᵀ (m × w)) · de.
            let turn = Turn::new(&e);
            for w in [Vector3::x(), Vector3::y(), Vector3::z()] {
                let found = turn.left_jacobian_transposed(&turn.apply(&v).cross(&w)).dot(&step);
                assert!((found - w.dot(&difference)).abs() < 1e-9, "{angle}");
            }
        }
    }

    #[test]
    fn jacobian_is_that_of_finite_differences() {
        use crate::OutsidePolicy;
        use crate::random_models::{Seeded, random_model, room};
        use trackwright_geometry::directions::{DirectionSet, Weighting};
        let model = random_model(3, DirectionSet::Fourteen, Weighting::Area, [20.0, 0.3], 4);
        let mut seeded = Seeded::new(8);
        let outside = OutsidePolicy::Extrapolate;
        for _ in 0..20 {
            let guess = AxisPose::of(&seeded.pose(&room(), 0.0));
            let there = model.evaluate_with_jacobian(&guess.position_mm, &guess.axis, outside);
            // A reading near what the guess reads, so that angles are small.
            let read = Turn::new(&there.at.error.rotation_rad).apply(&guess.axis);
            let near = Unit::new_normalize(read + Vector3::new(1e-9, -2e-9, 1e-9));
            assert!(axis_rotation(&near, &Unit::new_normalize(read)).vector_rad.norm() < 1e-8);
            let reading = Reading::new(AxisPose {
                position_mm: guess.position_mm + there.at.error.position_mm,
                axis: near,
            });
            let jacobian = reading.jacobian(&guess, &there);
            let remainder = |step: Vector5<f64>| {
                let moved = reading.moved(&guess, &step);
                let at = model.evaluate(&moved.position_mm, &moved.axis, outside);
                let left = reading.remainder(&moved, &at.error);
                let [a, b] = left.axis_rad;
                let p = left.position_mm;
                Vector5::new(p.x, p.y, p.z, a, b)
            };
            for column in 0..5 {
                let h = if column < 3 { 1e-2 } else { 1e-5 };
                let mut step = Vector5::zeros();
                step[column] = h;
                let difference = (remainder(step) - remainder(-step)) / (2.0 * h);
                // Third derivatives of size 20 · 3³ mm a radian times h², round-off 1e-13 / h.
                let worst = (difference - jacobian.column(column)).amax();
                assert!(worst < 2e-6, "column {column}: {worst:e}");
            }
        }
    }
}
