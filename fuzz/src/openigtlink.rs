//! Streams from a network.

use trackwright_openigtlink::codec::{Content, Decoded, Decoder, HEADER_BYTES};

/// What came of a part of a stream, in a form that equals itself also where numbers are none.
#[derive(Debug, PartialEq)]
enum Received {
    Message(Vec<u8>),
    Skipped(String, u64),
    Wrong(String),
}

/// A stream in pieces of a size that the first byte gives: it is decoded as if it came in one, no
/// message comes of less than a header, and each encodes and decodes again to the same.
pub fn openigtlink(bytes: &[u8]) -> bool {
    let Some((piece, stream)) = bytes.split_first() else {
        return false;
    };
    let whole = received(stream.len().max(1), stream);
    assert_eq!(received(usize::from(*piece) + 1, stream), whole);
    assert!(whole.len() * HEADER_BYTES <= stream.len());
    let messages = whole.iter().filter_map(|part| match part {
        Received::Message(message) => Some(message),
        _ => None,
    });
    let mut is_found = false;
    for message in messages {
        is_found = true;
        // Text that was no UTF-8 has become up to three times as long.
        assert!(message.len() <= 3 * stream.len() + HEADER_BYTES);
        let again = received(message.len(), message);
        assert_eq!(again, [Received::Message(message.clone())]);
    }
    is_found
}

fn received(piece: usize, stream: &[u8]) -> Vec<Received> {
    let mut decoder = Decoder::new(1 << 20);
    let mut all = Vec::new();
    for mut arrived in stream.chunks(piece) {
        while let Some(decoded) = decoder.next(&mut arrived) {
            all.push(match decoded {
                Ok(Decoded::Message(message)) => {
                    if let Content::Transform(matrix) = &message.content
                        && let Ok(pose) = matrix.pose()
                    {
                        assert!(pose.translation.vector.iter().all(|v| v.is_finite()));
                        assert!((pose.rotation.norm() - 1.0).abs() < 1e-9);
                    }
                    Received::Message(message.encode().expect("what had a place has one again"))
                }
                Ok(Decoded::Skipped { kind, body_bytes, .. }) => {
                    Received::Skipped(kind, body_bytes)
                }
                Err(error) => Received::Wrong(error.to_string()),
            });
        }
    }
    all
}
