//! What several tests share: where data is, and comparing to a relative tolerance.

pub mod close;
pub mod data;
