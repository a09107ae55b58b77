//! Designs electromagnetically tracked surgical tools without building them.

pub mod field;
pub mod geometry;
pub mod study;
pub mod tracking;
