//! From recordings to measurements, and from measurements to a room: registration, where a tool's
//! tip is, what a calibration object or sensors beside a reference tracker should read, and which
//! model a room gets.
//!
//! A tool that was turned about its tip, which rested in one point:
//!
//! ```
//! use nalgebra::{Point3, UnitQuaternion, Vector3};
//! use trackwright_calibration::pivot::{PivotLimits, pivot};
//! use trackwright_geometry::pose::pose_from_parts;
//!
//! let (tip, point) = (Vector3::new(0.0, 0.0, 150.0), Vector3::new(80.0, -30.0, -310.0));
//! let poses: Vec<_> = (0..20)
//!     .map(|i| {
//!         let (s, c) = (2.4 * f64::from(i)).sin_cos();
//!         let turn = UnitQuaternion::from_scaled_axis(Vector3::new(c, 0.3, s) * 0.4);
//!         pose_from_parts(point - turn * tip, turn)
//!     })
//!     .collect();
//! let found = pivot(&poses, &PivotLimits::default())?;
//! assert!((found.tip_in_tool - Point3::from(tip)).norm() < 1e-9);
//! assert!((found.pivot_in_tracker - Point3::from(point)).norm() < 1e-9);
//! # Ok::<(), trackwright_calibration::pivot::PivotError>(())
//! ```

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
pub mod judged_registration;
pub mod kind_choice;
pub mod lag;
pub mod learning_curve;
pub mod long_run;
pub mod marker_body;
mod orientation_range;
pub mod pivot;
pub mod pose_stream;
pub mod protocol;
pub mod registration;
pub mod registration_error;
mod remedies;
pub mod rigid_check;
pub mod robust;
pub mod room_choice;
pub mod room_fit;
pub mod room_model;
pub mod room_process;
pub mod row_labels;
pub mod shared_rows;
pub mod spin;
pub mod still_pose;
pub mod time_alignment;
