//! First-order uncertainty of a fitted frame at a point (MATH, first-order uncertainty; DOMAIN 3.4).
//!
//! A sensor's position error `e` and rotation error `φ` move the point `r` by
//! `δ = mean(e) + θ × d`, so `Cov(r) = Σ J C Jᵀ + Σ K Cφ Kᵀ`.

use super::body::{RigidBody, SensorOrientation};
use nalgebra::{Matrix3, Point3, Vector3};

/// Largest over smallest eigenvalue of `A` above which the rotation counts as not determined;
/// `A` grows with the square of lengths, as `H` does in frame fitting.
const SINGULAR_RATIO: f64 = 1e10;

/// Independent errors of one sensor, body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorCovariance {
    pub position_mm2: Matrix3<f64>,
    pub rotation_rad2: Matrix3<f64>,
}

/// The sensors leave a rotation free, so a point away from their centroid has no covariance.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the sensors do not determine the rotation: eigenvalues {smallest:.3e} and {largest:.3e} mm²"
)]
pub struct RotationNotDetermined {
    pub smallest: f64,
    pub largest: f64,
}

/// Covariance in mm² of a point of the body, all in the body frame, from one covariance a sensor.
///
/// # Errors
/// [`RotationNotDetermined`] where the sensors leave a rotation free.
pub fn point_covariance_mm2(
    body: &RigidBody,
    orientation_weight_mm: f64,
    sensors: &[SensorCovariance],
    point_in_body: &Point3<f64>,
) -> Result<Matrix3<f64>, RotationNotDetermined> {
    let n = body.sensors.len() as f64;
    let weight = orientation_weight_mm * orientation_weight_mm;
    let centroid = body
        .sensors
        .iter()
        .map(|s| s.position_in_body.coords)
        .sum::<Vector3<f64>>()
        / n;
    let arms: Vec<_> = body
        .sensors
        .iter()
        .map(|s| {
            (
                s.position_in_body.coords - centroid,
                seen_rotations(&s.orientation),
            )
        })
        .collect();
    let a: Matrix3<f64> = arms
        .iter()
        .map(|(x, seen)| Matrix3::identity() * x.norm_squared() - x * x.transpose() + seen * weight)
        .sum();
    let eigenvalues = a.symmetric_eigenvalues();
    let (smallest, largest) = (eigenvalues.min(), eigenvalues.max());
    let inverse = a
        .try_inverse()
        .filter(|_| smallest * SINGULAR_RATIO > largest)
        .ok_or(RotationNotDetermined { smallest, largest })?;
    let lever = (point_in_body.coords - centroid).cross_matrix();
    Ok(arms
        .iter()
        .zip(sensors)
        .map(|((x, seen), c)| {
            let j = Matrix3::identity() / n - lever * inverse * x.cross_matrix();
            let k = -lever * inverse * seen * weight;
            j * c.position_mm2 * j.transpose() + k * c.rotation_rad2 * k.transpose()
        })
        .sum())
}

/// `I − n nᵀ` for a 5-DOF sensor, which does not see its roll; `2 I` for a 6-DOF one.
fn seen_rotations(orientation: &SensorOrientation) -> Matrix3<f64> {
    match orientation {
        SensorOrientation::FiveDof(n) => Matrix3::identity() - n.into_inner() * n.transpose(),
        SensorOrientation::SixDof(_) => Matrix3::identity() * 2.0,
    }
}
