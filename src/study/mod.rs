//! Scenario in, outcome out: the three modes, statistics, requirements, work counted.

pub mod motion;
pub mod requirement;
pub mod statistics;
