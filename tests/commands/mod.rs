//! The program as a person runs it: the built binary, its output, its exit status.

mod bad_input;
mod characterize;
mod compensate;
mod convert;
mod explain;
mod export;
mod export_tips;
mod golden_designs;
mod jhu_chain;
mod jhu_cis;
mod live;
mod main_job;
mod pivot;
mod precision;
mod register;
mod report;
mod select;
mod spin;
mod stability;
mod support;
mod uncertainty;
mod verify;
mod volume;
