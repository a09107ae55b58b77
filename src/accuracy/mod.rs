//! How far the program's own numbers can be trusted: against references of higher precision.

pub mod high;
pub mod high_linear;
pub mod stability;
