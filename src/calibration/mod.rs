//! From recordings to measurements, and from measurements to a room: registration, what a
//! calibration object should read, and which model a room gets.

pub mod calibration_object;
pub mod registration;
pub mod room_choice;
pub mod room_fit;
pub mod room_worth;
