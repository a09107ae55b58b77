//! From recordings to measurements, and from measurements to a room: registration, where a tool's
//! tip is, what a calibration object should read, and which model a room gets.

pub mod calibration_object;
pub mod marker_body;
pub mod pivot;
pub mod registration;
pub mod registration_error;
pub mod room_choice;
pub mod room_fit;
pub mod room_worth;
