//! Rigid bodies and sensors, recordings of them, frame fitting, tool in CRF, uncertainty, what is not
//! determined.

pub mod body;
pub mod distinct;
pub mod frame_fit;
pub mod linear_fit;
pub mod pairs;
pub mod recording;
pub mod tool_in_crf;

pub use body::{Coil, RigidBody, Sensor, SensorOrientation};
pub use frame_fit::Determination;
