//! Designs electromagnetically tracked surgical tools without building them.

pub mod calibration;
pub mod design;
pub mod field;
pub mod formats;
pub mod geometry;
pub mod store;
pub mod study;
pub mod tracking;
