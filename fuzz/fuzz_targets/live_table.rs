//! Any bytes after the header of a recording of live poses.

#![no_main]

use libfuzzer_sys::fuzz_target;
use trackwright::formats::recording::live_table::{HEADER, parse};

fuzz_target!(|bytes: &[u8]| {
    let _ = parse(&[HEADER.as_bytes(), b"\n", bytes].concat());
});
