//! Searches against what is known otherwise.

mod brute_force;
pub(crate) mod cases;
mod constraints;
mod crf_patch;
mod marker_layouts;
mod promises;
