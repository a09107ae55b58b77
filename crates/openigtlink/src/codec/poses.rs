//! Poses as messages have them, and which of them are poses.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::svd3::svd3;

/// How far an entry of a matrix may be from the nearest rotation's, and the length of a quaternion
/// from 1. Single precision is 1e-7 off, senders that pass text on 1e-4; a scale or a shear that
/// somebody meant is more than a hundredth.
pub const MAX_OFF: f64 = 1e-2;

/// Why numbers are no pose.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotAPose {
    #[error("a number that is not finite")]
    NotFinite,
    #[error("a 3x3 part that differs from a rotation by {off:.2e}")]
    NotARotation { off: f64 },
    #[error("a quaternion of length {length:.4}")]
    NotAUnit { length: f64 },
    #[error("no orientation")]
    NoOrientation,
}

/// The upper three rows of a 4x4 matrix, column by column: three axes, then the place in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix(pub [f32; 12]);

impl Matrix {
    /// The matrix of a pose, in single precision.
    pub fn from_pose(pose: &Pose) -> Self {
        let turn = pose.rotation.to_rotation_matrix();
        let mut values = [0.0; 12];
        let numbers = turn.matrix().iter().chain(pose.translation.vector.iter());
        for (value, number) in values.iter_mut().zip(numbers) {
            *value = *number as f32;
        }
        Self(values)
    }

    /// The pose with the nearest rotation, where that is within [`MAX_OFF`].
    pub fn pose(&self) -> Result<Pose, NotAPose> {
        let values = self.0.map(f64::from);
        if values.iter().any(|value| !value.is_finite()) {
            return Err(NotAPose::NotFinite);
        }
        let [turn @ .., x, y, z] = values;
        let turn: [f64; 9] = turn;
        let turn = Matrix3::from_column_slice(&turn);
        let rotation = svd3(&turn.transpose()).best_rotation();
        let off = (rotation.to_rotation_matrix().matrix() - turn).amax();
        if off.is_nan() || off > MAX_OFF {
            return Err(NotAPose::NotARotation { off });
        }
        Ok(pose_from_parts(Vector3::new(x, y, z), rotation))
    }
}

/// How a position message encodes where a tool points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Orientation {
    /// 12 bytes: it does not.
    None,
    /// 24 bytes: x, y, z of a unit quaternion with a scalar part that is not negative.
    Vector([f32; 3]),
    /// 28 bytes: x, y, z, w.
    Full([f32; 4]),
}

impl Orientation {
    /// The rotation of a quaternion whose length is 1 to [`MAX_OFF`].
    pub fn rotation(&self) -> Result<UnitQuaternion<f64>, NotAPose> {
        let [x, y, z, w] = match *self {
            Self::None => return Err(NotAPose::NoOrientation),
            Self::Vector(vector) => {
                let [x, y, z] = vector.map(f64::from);
                let rest = 1.0 - (x * x + y * y + z * z);
                // Rounded, half a turn's vector may be a little too long.
                let w = if rest > 0.0 { rest.sqrt() } else { 0.0 };
                [x, y, z, w]
            }
            Self::Full(numbers) => numbers.map(f64::from),
        };
        let quaternion = Quaternion::new(w, x, y, z);
        let length = quaternion.norm();
        if !length.is_finite() {
            return Err(NotAPose::NotFinite);
        }
        if (length - 1.0).abs() > MAX_OFF {
            return Err(NotAPose::NotAUnit { length });
        }
        Ok(UnitQuaternion::from_quaternion(quaternion))
    }

    /// The pose at a place.
    pub fn pose(&self, at_mm: [f32; 3]) -> Result<Pose, NotAPose> {
        let rotation = self.rotation()?;
        if at_mm.iter().any(|value| !value.is_finite()) {
            return Err(NotAPose::NotFinite);
        }
        Ok(pose_from_parts(Vector3::from(at_mm.map(f64::from)), rotation))
    }
}

/// What a tool of tracking data is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToolKind {
    Tracker,
    SixDof,
    /// A place without an orientation.
    ThreeDof,
    /// The turn about its own axis is arbitrary.
    FiveDof,
    Other(u8),
}

impl From<u8> for ToolKind {
    fn from(number: u8) -> Self {
        match number {
            1 => Self::Tracker,
            2 => Self::SixDof,
            3 => Self::ThreeDof,
            4 => Self::FiveDof,
            other => Self::Other(other),
        }
    }
}

impl From<ToolKind> for u8 {
    fn from(kind: ToolKind) -> Self {
        match kind {
            ToolKind::Tracker => 1,
            ToolKind::SixDof => 2,
            ToolKind::ThreeDof => 3,
            ToolKind::FiveDof => 4,
            ToolKind::Other(other) => other,
        }
    }
}
