//! The equations behind a reading, `p + e_pos(p, n) = p_m` and `exp(e_ori(p, n)) n = n_m`: what is
//! left of them at a guess, their Jacobian in five unknowns, and how exactly they can hold.

use crate::field::jacobian::Linearization;
use crate::field::samples::PoseError;
use crate::geometry::pose::Pose;
use crate::geometry::rotation::perpendicular;
use nalgebra::{Matrix5, Point3, Unit, Vector3, Vector5};

/// A position and an axis: the five unknowns, or the five numbers that were read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub position_mm: Point3<f64>,
    pub axis: Unit<Vector3<f64>>,
}

impl Place {
    pub fn of(pose: &Pose) -> Self {
        Self {
            position_mm: pose.translation.vector.into(),
            axis: pose.rotation * Vector3::z_axis(),
        }
    }

    pub fn is_finite(&self) -> bool {
        self.position_mm
            .iter()
            .chain(self.axis.iter())
            .all(|v| v.is_finite())
    }
}

/// What was read, with a frame of its tangent plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    pub place: Place,
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
}

impl Reading {
    pub fn new(place: Place) -> Self {
        let first = perpendicular(&place.axis).into_inner();
        Self {
            place,
            tangents: [first, place.axis.cross(&first)],
        }
    }

    /// What is left of the equations at a guess with this error.
    pub fn remainder(&self, guess: &Place, error: &PoseError) -> Remainder {
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
            return if cosine > 0.0 {
                [0.0; 2]
            } else {
                [std::f64::consts::PI, 0.0]
            };
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
    pub fn jacobian(&self, guess: &Place, there: &Linearization) -> Matrix5<f64> {
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
                jacobian[(3 + row, column)] = (0..3)
                    .map(|k| by_error[k] * there.by_position[(3 + k, column)])
                    .sum();
            }
            for (column, step) in steps.iter().enumerate() {
                let by_axis = there.by_axis.fixed_rows::<3>(3) * step;
                jacobian[(3 + row, 3 + column)] = by_error.dot(&by_axis) + back.dot(step);
            }
        }
        jacobian
    }

    /// The guess moved by five unknowns in its tangent frame.
    pub fn moved(&self, guess: &Place, step: &Vector5<f64>) -> Place {
        let [first, second] = self.tangents_at(&guess.axis);
        Place {
            position_mm: guess.position_mm + step.fixed_rows::<3>(0),
            axis: Unit::new_normalize(guess.axis.as_ref() + first * step[3] + second * step[4]),
        }
    }
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
        // Series to θ⁶ are exact to the last bit below this angle; errors are mostly that small.
        const SERIES_BELOW_RAD: f64 = 0.06;
        let (sine, versine, third) = if squared < SERIES_BELOW_RAD * SERIES_BELOW_RAD {
            let t = squared;
            (
                1.0 - t / 6.0 * (1.0 - t / 20.0 * (1.0 - t / 42.0 * (1.0 - t / 72.0))),
                0.5 * (1.0 - t / 12.0 * (1.0 - t / 30.0 * (1.0 - t / 56.0 * (1.0 - t / 90.0)))),
                (1.0 - t / 20.0 * (1.0 - t / 42.0 * (1.0 - t / 72.0 * (1.0 - t / 110.0)))) / 6.0,
            )
        } else {
            let angle = squared.sqrt();
            let half = (0.5 * angle).sin();
            (
                angle.sin() / angle,
                2.0 * half * half / squared,
                (angle - angle.sin()) / (squared * angle),
            )
        };
        Self {
            vector_rad: *vector_rad,
            sine,
            versine,
            third,
        }
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
