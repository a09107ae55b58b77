//! What several tests share: where data is, comparing to a tolerance, running the
//! program and those of others.

pub mod close;
pub mod data;
pub mod golden;
pub mod jhu_cis;
pub mod live_load;
pub mod live_program;
pub mod metal_table;
pub mod peers;
pub mod program;
pub mod studies;
pub mod table;
pub mod wire;
