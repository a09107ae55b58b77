//! Designs electromagnetically tracked surgical tools without building them.
//!
//! Electromagnetic (EM) trackers tell where a tool's tip is inside a patient; metal in the room
//! distorts what they read. After Fischer & Taylor (2005) this program fits a distortion model to
//! measurements, distorts the sensors of a virtual tool and of the patient's coordinate reference
//! frame (CRF), refits both, and reads off the tip error.
//!
//! Units and frames, once for all: **millimetres and radians** inside, degrees only where a person
//! reads or types (`_deg`). A transform `target_from_source` maps coordinates of the source to
//! those of the target. The **tracker** frame is the field generator's own, its volume at negative
//! z; the **CRF** frame is the reference body's; the **tool** frame is the tool body's.
//!
//! Each room may call those above it, never below:

pub mod tracking;

pub mod calibration;

pub mod procedure;

pub mod study;

pub mod formats;

pub mod design;

pub mod store;

pub mod live;

pub mod scene;

pub mod report;

pub mod accuracy;

#[cfg(feature = "editor")]
pub mod editor;

pub mod cli;
