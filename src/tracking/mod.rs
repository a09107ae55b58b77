//! Rigid bodies and sensors, frame fitting, tool in CRF, uncertainty, what is not determined.

pub mod body;
