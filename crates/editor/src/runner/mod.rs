//! Background work: jobs, the solver thread and their results.

pub mod diagnostics;
pub mod job;
pub mod latest;
pub mod results;
pub mod solve;
pub mod solver;
pub mod wake;
