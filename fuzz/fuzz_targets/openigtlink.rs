//! Any stream of bytes, in pieces of any size: no panic, and what is decoded encodes and decodes again
//! to the same.

#![no_main]

use libfuzzer_sys::fuzz_target;
use trackwright::live::codec::{Decoded, Decoder};

fuzz_target!(|bytes: &[u8]| {
    let Some((piece, stream)) = bytes.split_first() else {
        return;
    };
    let mut decoder = Decoder::new(1 << 16);
    for mut arrived in stream.chunks(usize::from(*piece) + 1) {
        while let Some(decoded) = decoder.next(&mut arrived) {
            let Ok(Decoded::Message(message)) = decoded else {
                continue;
            };
            let again = message.encode().expect("what had a place has one again");
            let mut left = again.as_slice();
            // Text that was no UTF-8 has become longer.
            match Decoder::new(1 << 20).next(&mut left) {
                // Numbers that are none differ from themselves: compared as bytes.
                Some(Ok(Decoded::Message(second))) => {
                    assert_eq!(second.encode().as_deref(), Ok(again.as_slice()));
                }
                other => panic!("{other:?}"),
            }
        }
    }
});
