//! Frame fits (9)–(13) in [`High`] numbers.

use crate::high::High;
use crate::high_linear::{
    High3, High33, HighMatrix, HighSvd, add3, apply33, cross3, determinant33, dot, matrix_from_fn,
    norm, scale3, sub3, svd, times33, transposed33, unit3, vector3,
};
use crate::references::{self, matrix, moved, point3, quaternion};
use nalgebra::Point3;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::frame_fit::{FREE_AXIS_RATIO, POOR_RATIO, Reading};
use trackwright_simulation::{Determination, RigidBody, SensorOrientation};

/// Below this part of the rows' lengths a cross-covariance in high precision is zero: sensors at
/// one place leave 1e-57 of themselves.
const ZERO: f64 = 1e-45;

/// What a fit has to report about its own determination.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Determinacy {
    Full,
    Poor,
    FreeAxis,
    FreeRotation,
}

impl Determinacy {
    /// What the program reports.
    pub fn of(determination: &Determination) -> Self {
        match determination {
            Determination::Full => Self::Full,
            Determination::Poor { .. } => Self::Poor,
            Determination::FreeAxis { .. } => Self::FreeAxis,
            Determination::FreeRotation => Self::FreeRotation,
        }
    }

    /// The claim of a row.
    pub fn must(self) -> &'static str {
        match self {
            Self::Full => "reported: determined",
            Self::Poor => "reported: poorly determined",
            Self::FreeAxis => "reported: one axis is free",
            Self::FreeRotation => "reported: rotation not determined",
        }
    }
}

/// The decomposed cross-covariance of a fit.
pub struct HighFrame {
    svd: HighSvd,
    is_reflection: bool,
    /// Sum of the products of the rows' lengths, body and reading.
    lengths: f64,
    centroid_in_body: High3,
    centroid_mm: High3,
}

/// The fitted frame.
pub struct HighFit {
    pub rotation: High33,
    pub condition: f64,
    centroid_in_body: High3,
    centroid_mm: High3,
}

impl HighFrame {
    /// The cross-covariance of a body's readings, decomposed.
    pub fn of(body: &RigidBody, weight_mm: f64, readings: &[Reading]) -> Self {
        let mean = |points: Vec<High3>| {
            let n = High::from(points.len() as f64);
            let sum = points.iter().fold(vector3([0.0; 3]), |sum, p| add3(&sum, p));
            sum.map(|x| x / &n)
        };
        let own: Vec<_> = body.sensors.iter().map(|s| point3(&s.position_in_body)).collect();
        let read: Vec<_> = readings.iter().map(|r| point3(&r.position_mm)).collect();
        let (centroid_in_body, centroid_mm) = (mean(own.clone()), mean(read.clone()));
        let weight = High::from(weight_mm) * weight_mm;
        let mut h = matrix_from_fn(|_, _| High::zero());
        let mut lengths = 0.0;
        let mut add = |a: &High3, b: &High3, weight: &High| {
            for i in 0..3 {
                for j in 0..3 {
                    h[i][j] += &a[i] * &b[j] * weight;
                }
            }
            lengths += (norm(a) * norm(b) * weight).to_f64();
        };
        for ((sensor, reading), (p, q)) in
            body.sensors.iter().zip(readings).zip(own.iter().zip(&read))
        {
            add(&sub3(p, &centroid_in_body), &sub3(q, &centroid_mm), &High::one());
            let measured = transposed33(&matrix(&quaternion(&reading.rotation)));
            match &sensor.orientation {
                SensorOrientation::Marker => {}
                SensorOrientation::FiveDof(axis) => {
                    add(&vector3(axis.into_inner().into()), &measured[2], &weight);
                }
                SensorOrientation::SixDof(rotation) => {
                    let own = transposed33(&matrix(&quaternion(rotation)));
                    for (a, b) in own.iter().zip(&measured) {
                        add(a, b, &weight);
                    }
                }
            }
        }
        Self {
            svd: svd(&HighMatrix::from_fn(3, 3, |i, j| h[i][j].clone())),
            is_reflection: determinant33(&h).is_negative(),
            lengths,
            centroid_in_body,
            centroid_mm,
        }
    }

    fn singular_value(&self, k: usize) -> f64 {
        self.svd.singular_values[k].to_f64()
    }

    /// What the exact singular values give.
    pub fn determinacy(&self) -> Determinacy {
        let [s0, s1] = [0, 1].map(|k| self.singular_value(k));
        if s0 <= ZERO * self.lengths.max(f64::MIN_POSITIVE) {
            Determinacy::FreeRotation
        } else if s1 <= FREE_AXIS_RATIO * s0 {
            Determinacy::FreeAxis
        } else if s1 <= POOR_RATIO * s0 {
            Determinacy::Poor
        } else {
            Determinacy::Full
        }
    }

    /// The fit; `None` where no rotation is determined.
    pub fn fitted(&self, truth: &Pose) -> Option<HighFit> {
        let [s0, s1, s2] = [0, 1, 2].map(|k| self.singular_value(k));
        let column = |m: &HighMatrix, k: usize| -> High3 {
            std::array::from_fn(|i| m.columns[k][i].clone())
        };
        let (u0, v0) = (column(&self.svd.u, 0), column(&self.svd.v, 0));
        let (rotation, least) = match self.determinacy() {
            Determinacy::FreeRotation => return None,
            Determinacy::FreeAxis => {
                let own = matrix(&quaternion(&truth.rotation));
                let turn = references::axis_rotation(&apply33(&own, &u0), &v0);
                (times33(&matrix(&references::exp(&turn)), &own), s0 - s1)
            }
            Determinacy::Full | Determinacy::Poor => {
                // `V diag(1, 1, det) Uᵀ`: third columns made right-handed carry the sign.
                let u1 = orthogonal(&column(&self.svd.u, 1), &u0);
                let v1 = orthogonal(&column(&self.svd.v, 1), &v0);
                let (u2, v2) = (cross3(&u0, &u1), cross3(&v0, &v1));
                let rotation =
                    matrix_from_fn(|i, j| &v0[i] * &u0[j] + &v1[i] * &u1[j] + &v2[i] * &u2[j]);
                let sign = if self.is_reflection { -1.0 } else { 1.0 };
                (rotation, s1 + sign * s2)
            }
        };
        Some(HighFit {
            rotation,
            condition: self.lengths / least,
            centroid_in_body: self.centroid_in_body.clone(),
            centroid_mm: self.centroid_mm.clone(),
        })
    }
}

impl HighFit {
    /// A point of the body in the tracker frame, and its distance from the sensors' centroid.
    pub fn moved(&self, point: &Point3<f64>) -> (High3, f64) {
        let arm = sub3(&point3(point), &self.centroid_in_body);
        let length = norm(&arm).to_f64();
        (moved(&self.rotation, &self.centroid_mm, &arm), length)
    }
}

/// A unit vector made perpendicular to another to all digits.
fn orthogonal(a: &High3, to: &High3) -> High3 {
    unit3(&sub3(a, &scale3(to, &dot(a, to))))
}
