//! From recordings to measurements, and from measurements to a room: registration, where a tool's
//! tip is, what a calibration object or sensors beside a reference tracker should read, and which
//! model a room gets.

pub mod agreement;
pub mod built_tool;
pub mod calibration_object;
pub mod characterisation;
pub mod coverage;
pub mod dependence;
pub mod doubts;
pub mod fiducial_outliers;
pub mod fit_quality;
pub mod hand_eye;
pub mod kind_choice;
pub mod learning_curve;
pub mod long_run;
pub mod marker_body;
mod orientation_range;
pub mod pivot;
pub mod pose_stream;
pub mod registration;
pub mod registration_error;
pub mod rigid_check;
pub mod robust;
pub mod room_choice;
pub mod room_fit;
pub mod room_model;
pub mod room_process;
pub mod shared_rows;
pub mod spin;
pub mod still_pose;
pub mod time_alignment;
