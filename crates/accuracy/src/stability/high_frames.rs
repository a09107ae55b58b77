//! Frame fits (9)–(13) in [`High`] numbers.

use crate::high::{High, One};
use crate::high_linear::{High3, High33, HighMatrix, HighSvd, column3, norm, svd, unit3};
use crate::references::{self, axis3, matrix, point3, quaternion};
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
        let centered = |points: Vec<High3>| {
            let mean = points.iter().sum::<High3>() / High::from(points.len() as f64);
            (points.iter().map(|p| p - &mean).collect::<Vec<_>>(), mean)
        };
        let own = body.sensors.iter().map(|s| point3(&s.position_in_body));
        let read = readings.iter().map(|r| point3(&r.position_mm));
        let (own, centroid_in_body) = centered(own.collect());
        let (read, centroid_mm) = centered(read.collect());
        let weight = High::from(weight_mm) * weight_mm;
        let mut h = High33::zeros();
        let mut lengths = 0.0;
        let mut add = |a: &High3, b: &High3, weight: &High| {
            h += a * b.transpose() * weight.clone();
            lengths += (norm(a) * norm(b) * weight).to_f64();
        };
        let pairs = body.sensors.iter().zip(readings);
        for ((sensor, reading), (p, q)) in pairs.zip(own.iter().zip(&read)) {
            add(p, q, &High::one());
            let column = |m: &High33, k| m.column(k).into_owned();
            let measured = matrix(&quaternion(&reading.rotation));
            match &sensor.orientation {
                SensorOrientation::Marker => {}
                SensorOrientation::FiveDof(axis) => {
                    add(&axis3(axis), &column(&measured, 2), &weight);
                }
                SensorOrientation::SixDof(rotation) => {
                    let own = matrix(&quaternion(rotation));
                    for k in 0..3 {
                        add(&column(&own, k), &column(&measured, k), &weight);
                    }
                }
            }
        }
        let [x, y, z] = [0, 1, 2].map(|k| h.column(k).into_owned());
        Self {
            svd: svd(&HighMatrix::from_fn(3, 3, |i, j| h[(i, j)].clone())),
            is_reflection: x.dot(&y.cross(&z)).is_negative(),
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
        let (u0, v0) = (column3(&self.svd.u, 0), column3(&self.svd.v, 0));
        let (rotation, least) = match self.determinacy() {
            Determinacy::FreeRotation => return None,
            Determinacy::FreeAxis => {
                let own = matrix(&quaternion(&truth.rotation));
                let turn = references::axis_rotation(&(&own * u0), &v0);
                (matrix(&references::exp(&turn)) * own, s0 - s1)
            }
            Determinacy::Full | Determinacy::Poor => {
                // `V diag(1, 1, det) Uᵀ`: third columns made right-handed carry the sign.
                let u1 = orthogonal(&column3(&self.svd.u, 1), &u0);
                let v1 = orthogonal(&column3(&self.svd.v, 1), &v0);
                let [u, v] = [[u0, u1], [v0, v1]].map(|[a, b]| {
                    let c = a.cross(&b);
                    High33::from_columns(&[a, b, c])
                });
                let rotation = v * u.transpose();
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
        let arm = point3(point) - &self.centroid_in_body;
        let length = norm(&arm).to_f64();
        (&self.rotation * arm + &self.centroid_mm, length)
    }
}

/// A unit vector made perpendicular to another to all digits.
fn orthogonal(a: &High3, to: &High3) -> High3 {
    unit3(&(a - to * a.dot(to)))
}
