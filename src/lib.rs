//! Designs electromagnetically tracked surgical tools without building them.

pub mod calibration;
pub mod cli;
pub mod design;
#[cfg(feature = "editor")]
pub mod editor;
pub mod field;
pub mod formats;
pub mod geometry;
pub mod store;
pub mod study;
pub mod tracking;
