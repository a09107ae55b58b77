//! From recordings to measurements: registration, and what a calibration object should read.

pub mod calibration_object;
pub mod registration;
