//! What nearly every family names.

pub(super) use crate::high::{High, One, Zero};
pub(super) use crate::high_linear::{
    High3, High33, HighMatrix, dot, inverse33, least_squares, norm, svd, unit3, vector3,
};
pub(super) use crate::references::{self, axis3, distance, matrix, point3, quaternion};
pub(super) use crate::stability::case::{
    Extent, Family, Found, Made, Methods, Quantity, Row, Sequence, body_of, cube, model, must,
};
pub(super) use nalgebra::{Matrix3, Point3, Unit, UnitQuaternion, Vector3};
pub(super) use trackwright_field::bernstein::{coefficient_count, products};
pub(super) use trackwright_field::fit::FitSettings;
pub(super) use trackwright_field::samples::{PoseError, Sample, SampleSet};
pub(super) use trackwright_field::{DistortionModel, OutsidePolicy};
pub(super) use trackwright_geometry::bounds::Bounds;
pub(super) use trackwright_geometry::directions::{DirectionSet, Weighting};
pub(super) use trackwright_geometry::pose::{Pose, pose_from_parts};
pub(super) use trackwright_simulation::frame_fit::Reading;
pub(super) use trackwright_simulation::{RigidBody, Sensor, SensorOrientation};
