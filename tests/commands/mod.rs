//! The program as a person runs it: the built binary, its output, its exit status.

mod bad_input;
mod characterize;
mod compensate;
mod explain;
mod golden_designs;
mod jhu_cis;
mod main_job;
mod pivot;
mod precision;
mod select;
mod stability;
mod support;
mod uncertainty;
mod volume;
