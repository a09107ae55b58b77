//! Bytes that mean harm, or are broken: what the fuzz targets found worth keeping, again on every run.

mod corpora;
#[path = "../../fuzz/src/lib.rs"]
mod targets;
