//! Background work: the runner, what the solver computes on it, and the newest results.

pub mod diagnostics;
pub mod jobs;
pub mod metal;
pub mod process;
pub mod results;
pub mod solve;
pub mod solved;
pub mod wake;
