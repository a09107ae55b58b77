//! The protocol's own test vectors, to the byte.

use crate::support::data::third_party;
use trackwright_openigtlink::codec::{Content, Decoded, Decoder, Message, NotAPose, ToolKind};

/// Decodes a vector, after it was seen to encode to the same bytes.
fn vector(name: &str, checksum: Option<u64>) -> Option<Message> {
    let file = third_party(&format!("openigtlink/test_{name}.bin"))?;
    let bytes = std::fs::read(file).unwrap();
    let mut left = bytes.as_slice();
    let message = match Decoder::new(1024).next(&mut left) {
        Some(Ok(Decoded::Message(message))) => message,
        other => panic!("{name}: {other:?}"),
    };
    assert!(left.is_empty(), "{name}");
    assert_eq!(message.encode().unwrap(), bytes, "{name}");
    if let Some(checksum) = checksum {
        let found = u64::from_be_bytes(bytes[50..58].try_into().unwrap());
        assert_eq!(found, checksum, "{name}");
    }
    assert_eq!(message.device, "DeviceName");
    assert_eq!(message.timestamp.0, 0x4996_02d4);
    Some(message)
}

#[test]
fn every_vector_is_encoded_to_the_same_bytes() {
    let vectors = [
        ("transform_message", Some(0xf6dd_2b8e_b4df_6dd2)),
        ("transform_message_Format2", Some(0xf698_f64f_dae2_66dd)),
        ("tdata_message", Some(0x5c7c_ebfd_2767_6877)),
        ("tdata_messageFormat2", None),
        ("position_message", None),
        ("position_messageFormat2", None),
        ("point_message", None),
        ("status_message", None),
        ("string_message", None),
    ];
    for (name, checksum) in vectors {
        let Some(message) = vector(name, checksum) else { return };
        let extension = message.extension.as_ref();
        assert_eq!(extension.is_some(), name.contains("Format2"), "{name}");
        if let Some(extension) = extension {
            assert_eq!(extension.message_id, 1);
            assert_eq!(extension.get("First patient age"), Some("22"));
            assert_eq!(extension.get("Second patient age"), Some("25"));
        }
        let at = [46.0531, 19.4709, 46.0531];
        let is_there = |found: [f64; 3]| found.iter().zip(at).all(|(f, e)| (f - e).abs() < 1e-4);
        match message.content {
            Content::Transform(matrix) => {
                let pose = matrix.pose().unwrap();
                assert!(is_there(pose.translation.vector.into()));
                // The first column, as the vector's own sources have it.
                let axis = pose.rotation * nalgebra::Vector3::x();
                let expected = nalgebra::Vector3::new(-0.954_892, 0.196_632, -0.222_525);
                assert!((axis - expected).amax() < 1e-5, "{axis}");
            }
            Content::Position(position) => {
                assert!(is_there(position.at_mm.map(f64::from)));
                // (0, 0.5774, 0.5774, 0.3333) turns nothing.
                let length = (2.0 / 3.0 + 1.0 / 9.0_f64).sqrt();
                assert!(
                    matches!(position.pose(), Err(NotAPose::NotAUnit { length: found }) if (found - length).abs() < 1e-4)
                );
            }
            Content::Tracking(tools) => {
                let names: Vec<&str> = tools.iter().map(|tool| tool.name.as_str()).collect();
                assert_eq!(names, ["Tracker0", "Tracker1", "Tracker2"]);
                assert!(tools.iter().all(|tool| tool.kind == ToolKind::SixDof));
                assert!(tools.iter().all(|tool| tool.matrix.pose().is_ok()));
            }
            Content::Points(points) => {
                let names: Vec<&str> = points.iter().map(|point| point.group.as_str()).collect();
                assert_eq!(names, ["Landmark"; 3]);
                assert_eq!(points[1].at_mm, [25.0, 30.0, 35.0]);
                assert_eq!(points[2].rgba, [0, 0, 255, 255]);
            }
            Content::Status(status) => {
                assert_eq!((status.code.0, status.subcode), (15, 10));
                assert_eq!(status.name, "ACTUATOR_DISABLED");
                assert_eq!(status.text, "Actuator A is disabled.");
            }
            Content::Text(text) => assert_eq!(text.bytes, b"Welcome to OpenIGTLink"),
            other => panic!("{name}: {other:?}"),
        }
    }
}
