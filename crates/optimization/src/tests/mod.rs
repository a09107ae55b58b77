//! Searches against what is known otherwise.

mod brute_force;
mod cases;
mod constraints;
mod marker_layouts;
mod promises;
