//! Bytes that mean harm, or are broken: the inputs kept from the fuzz targets, read again on every run.

mod corpora;
#[path = "../../fuzz/src/lib.rs"]
mod targets;
