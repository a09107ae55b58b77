//! What nearly every family names.

pub use crate::high::High;
pub use crate::high_linear::{
    High3, High33, HighMatrix, add3, apply33, cross3, dot, inverse33, least_squares,
    matrix_from_fn, norm, scale3, sub3, svd, times33, transposed33, unit3, vector3,
};
pub use crate::references::{self, axis3, distance, matrix, moved, point3, quaternion};
pub use crate::stability::case::{
    Extent, Family, Found, Made, Methods, Quantity, Row, Sequence, cube, model, must,
};
pub use nalgebra::{Matrix3, Point3, Unit, UnitQuaternion, Vector3};
pub use trackwright_field::bernstein::{coefficient_count, products};
pub use trackwright_field::fit::FitSettings;
pub use trackwright_field::samples::{PoseError, Sample, SampleSet};
pub use trackwright_field::{DistortionModel, OutsidePolicy};
pub use trackwright_geometry::bounds::Bounds;
pub use trackwright_geometry::directions::{DirectionSet, Weighting};
pub use trackwright_geometry::pose::{Pose, pose_from_parts};
pub use trackwright_simulation::frame_fit::Reading;
pub use trackwright_simulation::{RigidBody, Sensor, SensorOrientation};
