#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    trackwright_fuzz::body_file(bytes);
});
