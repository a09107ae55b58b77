//! The core's speed; see docs/measurements.md.
fn main() {}
