//! What a model's answer at a pose is made of.

use super::samples::PoseError;
use nalgebra::SMatrix;

/// The six values of one coefficient, X, Y, Z in mm and Rx, Ry, Rz in radians.
pub type Coefficient = [f64; 6];

/// Six rows, X, Y, Z in mm and Rx, Ry, Rz in radians; three columns.
pub type Matrix6x3 = SMatrix<f64, 6, 3>;

/// What happens to a position outside the model's box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OutsidePolicy {
    /// The nearest point of the box stands for it.
    #[default]
    Clamp,
    /// The polynomial is used as it is.
    Extrapolate,
    /// The trial is left out of the statistics and counted.
    Reject,
}

/// A model's answer at one pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation {
    pub error: PoseError,
    /// Whether the position lies in the model's box.
    pub is_inside: bool,
}

/// A model's answer at one pose and how it changes around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearization {
    pub at: Evaluation,
    /// Per mm. A coordinate that is clamped to the box moves nothing, so its column is zero; on a
    /// face of the box it is the derivative from inside.
    pub by_position: Matrix6x3,
    /// Per radian, along the tangent plane: the change for a step `t` perpendicular to the axis is
    /// this times `t`; the column space along the axis is zero. On an edge between triangles it is
    /// the derivative inside the triangle that the weights were taken from.
    pub by_axis: Matrix6x3,
}
