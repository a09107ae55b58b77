//! Rigid registration of corresponding points (Arun 1987, with Umeyama's sign, 1991).

use nalgebra::{Matrix3, Point3, Vector3};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::svd3::svd3;

/// Fewest pairs that can determine a pose.
pub const MIN_PAIRS: usize = 3;

/// Relative second singular value of points on one line. The same bound as in frame fitting.
const COLLINEAR_RATIO: f64 = 1e-10;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Registration {
    pub target_from_source: Pose,
    /// Fiducial registration error: RMS distance that is left, mm.
    pub fre_rms_mm: f64,
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RegistrationError {
    #[error("{source_len} source points but {target_len} target points")]
    LengthMismatch { source_len: usize, target_len: usize },
    #[error("{0} points, expected at least {MIN_PAIRS}")]
    TooFewPoints(usize),
    #[error(
        "the points lie on one line (singular values in the ratio {ratio:.1e}), so the rotation about it is not determined"
    )]
    Collinear { ratio: f64 },
}

/// The rotation and translation that minimise `Σ ‖target − T source‖²`.
///
/// ```
/// use nalgebra::{Point3, Vector3};
/// use trackwright_calibration::registration::register;
///
/// let source = [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 50.0, 0.0]].map(Point3::from);
/// let target = source.map(|p| p + Vector3::new(3.0, -1.0, 2.0));
/// let found = register(&source, &target)?;
/// assert!(found.fre_rms_mm < 1e-12);
/// assert!((found.target_from_source * source[1] - target[1]).norm() < 1e-12);
/// # Ok::<(), trackwright_calibration::registration::RegistrationError>(())
/// ```
pub fn register(
    source: &[Point3<f64>],
    target: &[Point3<f64>],
) -> Result<Registration, RegistrationError> {
    if source.len() != target.len() {
        return Err(RegistrationError::LengthMismatch {
            source_len: source.len(),
            target_len: target.len(),
        });
    }
    if source.len() < MIN_PAIRS {
        return Err(RegistrationError::TooFewPoints(source.len()));
    }
    let (source_mean, target_mean) = (mean(source), mean(target));
    let h: Matrix3<f64> = source
        .iter()
        .zip(target)
        .map(|(s, t)| (s.coords - source_mean) * (t.coords - target_mean).transpose())
        .sum();
    let svd = svd3(&h);
    let s = svd.singular_values;
    // Points that coincide have no spread at all; that is worse than a line, and reported alike.
    let ratio = if s[0] > 0.0 { s[1] / s[0] } else { 0.0 };
    if ratio <= COLLINEAR_RATIO {
        return Err(RegistrationError::Collinear { ratio });
    }
    let rotation = svd.best_rotation();
    let target_from_source = pose_from_parts(target_mean - rotation * source_mean, rotation);
    let squares: f64 =
        source.iter().zip(target).map(|(s, t)| (target_from_source * s - t).norm_squared()).sum();
    Ok(Registration { target_from_source, fre_rms_mm: (squares / source.len() as f64).sqrt() })
}

fn mean(points: &[Point3<f64>]) -> Vector3<f64> {
    points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    fn points() -> Vec<Point3<f64>> {
        [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 50.0, 0.0], [10.0, 20.0, 30.0]]
            .map(Point3::from)
            .to_vec()
    }

    #[test]
    fn exact_pairs_give_the_exact_pose_and_no_error() {
        let pose = pose_from_parts(
            Vector3::new(3.0, -200.0, 77.0),
            UnitQuaternion::from_euler_angles(1.0, -0.4, 3.0),
        );
        let target: Vec<_> = points().iter().map(|p| pose * p).collect();
        let found = register(&points(), &target).unwrap();
        assert!(found.fre_rms_mm < 1e-12);
        assert!(found.target_from_source.rotation.angle_to(&pose.rotation) < 1e-14);
    }

    #[test]
    fn mirrored_points_give_a_rotation_and_an_error() {
        let target: Vec<_> = points().iter().map(|p| Point3::new(-p.x, p.y, p.z)).collect();
        let found = register(&points(), &target).unwrap();
        let r = found.target_from_source.rotation.to_rotation_matrix();
        assert!((r.matrix().determinant() - 1.0).abs() < 1e-12);
        assert!(found.fre_rms_mm > 1.0);
    }

    #[test]
    fn what_cannot_be_registered_states_why() {
        let p = points();
        assert_eq!(register(&p[..2], &p[..2]), Err(RegistrationError::TooFewPoints(2)));
        assert!(matches!(
            register(&p, &p[..3]),
            Err(RegistrationError::LengthMismatch { source_len: 4, target_len: 3 })
        ));
        let line: Vec<_> = (0..4).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect();
        assert!(matches!(register(&line, &line), Err(RegistrationError::Collinear { .. })));
        let same = vec![Point3::origin(); 4];
        assert!(matches!(register(&same, &same), Err(RegistrationError::Collinear { .. })));
    }
}
