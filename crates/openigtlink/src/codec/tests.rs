//! Every message survives its bytes, and no bytes do harm.

use super::*;
use proptest::prelude::*;
use trackwright_geometry::pose::{Pose, pose_from_array};

/// Enough for every message of these tests.
const MAX_BODY_BYTES: usize = 1 << 16;

/// All that a stream gives when it arrives in pieces of so many bytes.
fn decode_in(piece: usize, stream: &[u8]) -> (Vec<Result<Decoded, DecodeError>>, Decoder) {
    let mut decoder = Decoder::new(MAX_BODY_BYTES);
    let mut found = Vec::new();
    for mut arrived in stream.chunks(piece.max(1)) {
        while let Some(decoded) = decoder.next(&mut arrived) {
            found.push(decoded);
        }
    }
    (found, decoder)
}

fn messages(stream: &[u8]) -> Vec<Result<Decoded, DecodeError>> {
    decode_in(stream.len(), stream).0
}

/// A header with a right checksum before any body.
fn framed(version: u16, kind: &str, body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let header = Header {
        version: Version::One,
        kind: kind.to_owned(),
        device: "Probe".to_owned(),
        timestamp: Timestamp(7),
        body_bytes: body.len() as u64,
        checksum: super::header::checksum(body),
    };
    header.encode(&mut bytes).unwrap();
    bytes[..2].copy_from_slice(&version.to_be_bytes());
    bytes.extend_from_slice(body);
    bytes
}

fn name(limit: usize) -> impl Strategy<Value = String> {
    prop::collection::vec(prop::char::range('!', '~'), 0..=limit)
        .prop_map(|chars| chars.into_iter().collect())
}

fn floats<const N: usize>() -> impl Strategy<Value = [f32; N]> {
    prop::collection::vec(-1e6_f32..1e6, N).prop_map(|values| values.try_into().unwrap())
}

fn content() -> impl Strategy<Value = Content> {
    let list = 0..4_usize;
    let orientation = prop_oneof![
        Just(Orientation::None),
        floats().prop_map(Orientation::Vector),
        floats().prop_map(Orientation::Full),
    ];
    let position = (floats(), orientation);
    let tracking = (name(20), any::<u8>(), floats()).prop_map(|(name, kind, values)| {
        TrackingElement { name, kind: kind.into(), matrix: Matrix(values) }
    });
    let quaternions =
        (name(20), any::<u8>(), floats(), floats()).prop_map(|(name, kind, at_mm, quaternion)| {
            QuaternionElement { name, kind: kind.into(), at_mm, quaternion }
        });
    let points = (name(64), name(32), any::<[u8; 4]>(), floats(), 0.0_f32..9.0, name(20));
    let points = points.prop_map(|(name, group, rgba, at_mm, radius_mm, owner)| Point {
        name,
        group,
        rgba,
        at_mm,
        radius_mm,
        owner,
    });
    let status = (any::<u16>(), any::<i64>(), name(20), name(90));
    let status = status.prop_map(|(code, subcode, name, text)| Status {
        code: StatusCode(code),
        subcode,
        name,
        text,
    });
    let text = (any::<u16>(), prop::collection::vec(any::<u8>(), 0..90));
    let start = || {
        (any::<u32>(), name(32))
            .prop_map(|(resolution_ms, frame)| StartTracking { resolution_ms, frame })
    };
    prop_oneof![
        floats().prop_map(|values| Content::Transform(Matrix(values))),
        position
            .prop_map(|(at_mm, orientation)| Content::Position(Position { at_mm, orientation })),
        prop::collection::vec(tracking, list.clone()).prop_map(Content::Tracking),
        prop::collection::vec(quaternions, list.clone()).prop_map(Content::QuaternionTracking),
        prop::collection::vec(points, list).prop_map(Content::Points),
        status.prop_map(Content::Status),
        text.prop_map(|(encoding, bytes)| Content::Text(Text { encoding, bytes })),
        start().prop_map(Content::StartTracking),
        start().prop_map(Content::StartQuaternionTracking),
        any::<i8>().prop_map(Content::TrackingReply),
        any::<i8>().prop_map(Content::QuaternionTrackingReply),
        prop::sample::select(vec![
            Content::StopTracking,
            Content::StopQuaternionTracking,
            Content::GetTransform,
            Content::GetStatus,
        ]),
    ]
}

fn message() -> impl Strategy<Value = Message> {
    let value = prop::collection::vec(any::<u8>(), 0..20);
    let entry = (name(40), any::<u16>(), value).prop_map(|(key, encoding, value)| MetadataEntry {
        key,
        encoding,
        value,
    });
    let extension = (any::<u32>(), prop::collection::vec(entry, 0..4))
        .prop_map(|(message_id, metadata)| Extension { message_id, metadata });
    (name(20), any::<u64>(), content(), prop::option::of(extension)).prop_map(
        |(device, timestamp, content, extension)| Message {
            device,
            timestamp: Timestamp(timestamp),
            content,
            extension,
        },
    )
}

proptest! {
    #[test]
    fn messages_survive_their_bytes_however_these_arrive(
        sent in prop::collection::vec(message(), 1..4),
        piece in 1..200_usize,
    ) {
        let stream: Vec<u8> = sent.iter().flat_map(|message| message.encode().unwrap()).collect();
        let (found, decoder) = decode_in(piece, &stream);
        let found: Vec<_> = found.into_iter().map(Result::unwrap).collect();
        let expected: Vec<_> = sent.into_iter().map(Decoded::Message).collect();
        prop_assert_eq!(found, expected);
        prop_assert!(decoder.is_between_messages());
    }

    #[test]
    fn no_stream_of_bytes_panics(bytes in prop::collection::vec(any::<u8>(), 0..400), piece in 1..99_usize) {
        let _ = decode_in(piece, &bytes);
    }

    #[test]
    fn no_body_of_a_known_type_panics(
        sample in message(),
        version in 1..3_u16,
        body in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let stream = framed(version, sample.content.kind(), &body);
        let found = messages(&stream);
        prop_assert_eq!(found.len(), 1);
        // A wrong body is one wrong message and no more: the next one is found.
        prop_assert!(!matches!(&found[0], Err(error) if error.ends_the_stream()));
        let next = Message::new("next", Timestamp::NONE, Content::GetStatus);
        let found = messages(&[stream, next.encode().unwrap()].concat());
        prop_assert_eq!(found.last(), Some(&Ok(Decoded::Message(next))));
    }

    #[test]
    fn a_changed_byte_fails_its_own_message_only(
        sample in message(),
        at in any::<prop::sample::Index>(),
        change in 1..=255_u8,
    ) {
        let mut stream = sample.encode().unwrap();
        prop_assume!(stream.len() > HEADER_BYTES);
        let at = HEADER_BYTES + at.index(stream.len() - HEADER_BYTES);
        stream[at] ^= change;
        let next = Message::new("next", Timestamp::NONE, Content::GetStatus);
        stream.extend(next.encode().unwrap());
        let found = messages(&stream);
        prop_assert!(matches!(&found[0], Err(DecodeError::Checksum { .. })), "{:?}", found);
        prop_assert_eq!(&found[1], &Ok(Decoded::Message(next)));
    }

    #[test]
    fn a_pose_survives_single_precision(
        numbers in prop::array::uniform7(-1.0..1.0_f64),
    ) {
        let Some(pose) = pose_from_array(numbers) else { return Ok(()) };
        let back = Matrix::from_pose(&pose).pose().unwrap();
        // Half a unit in the last place of numbers up to 1, and the turn of nine such.
        prop_assert!((back.translation.vector - pose.translation.vector).amax() <= 6e-8);
        prop_assert!(back.rotation.angle_to(&pose.rotation) < 3e-7);
    }
}

#[test]
fn a_cut_stream_gives_its_whole_messages() {
    let extension =
        Extension { message_id: 3, metadata: vec![MetadataEntry::text("TransformStatus", "OK")] };
    let matrix = Matrix::from_pose(&Pose::translation(1.0, 2.0, 3.0));
    let mut sent = [
        Message::new("A", Timestamp(1), Content::Transform(matrix)),
        Message::new("B", Timestamp(2), Content::Status(Status::ok("fine"))),
        Message::new("C", Timestamp(3), Content::StopTracking),
    ];
    sent[1].extension = Some(extension);
    let parts: Vec<Vec<u8>> = sent.iter().map(|message| message.encode().unwrap()).collect();
    let ends: Vec<usize> = (1..=parts.len()).map(|n| parts[..n].concat().len()).collect();
    let stream = parts.concat();
    for cut in 0..=stream.len() {
        let (found, decoder) = decode_in(7, &stream[..cut]);
        let whole = ends.iter().filter(|end| **end <= cut).count();
        assert_eq!(found.len(), whole, "{cut}");
        assert!(found.iter().all(Result::is_ok));
        assert_eq!(decoder.is_between_messages(), cut == 0 || ends.contains(&cut), "{cut}");
    }
}

#[test]
fn announced_bytes_are_not_allocated() {
    for (version, kind, limit) in [
        (1, "TRANSFORM", 1024),
        (2, "TRANSFORM", 1024 + 65_536),
        (1, "TDATA", 71_680),
        (1, "STRING", 65_539),
        (1, "IMAGE", MAX_SKIPPED_BYTES),
    ] {
        for announced in [limit + 1, 900_000_000, 1 << 62, u64::MAX] {
            let mut stream = framed(version, kind, &[]);
            stream[42..50].copy_from_slice(&announced.to_be_bytes());
            let (found, mut decoder) = decode_in(9, &stream);
            let error = found[0].as_ref().unwrap_err();
            assert!(error.ends_the_stream());
            let expected =
                format!("found a body of {announced} bytes announced, expected {limit} at most");
            assert!(error.to_string().contains(&expected), "{error}");
            assert_eq!(decoder.next(&mut &stream[..]), None);
        }
    }

    // Longer than this decoder keeps, and an image: passed over without keeping any.
    for (kind, bytes) in [("TDATA", MAX_BODY_BYTES as u64 + 1), ("IMAGE", 200_000)] {
        let mut stream = framed(1, kind, &[]);
        stream[42..50].copy_from_slice(&bytes.to_be_bytes());
        stream.resize(HEADER_BYTES + bytes as usize, 0xa5);
        let next = Message::new("next", Timestamp::NONE, Content::GetStatus);
        stream.extend(next.encode().unwrap());
        let (found, decoder) = decode_in(1000, &stream);
        let skipped = Decoded::Skipped {
            kind: kind.to_owned(),
            device: "Probe".to_owned(),
            body_bytes: bytes,
        };
        assert_eq!(found, [Ok(skipped), Ok(Decoded::Message(next))]);
        assert!(decoder.kept.capacity() <= 128, "{}", decoder.kept.capacity());
    }
}

#[test]
fn lengths_that_lie_are_named() {
    let of_string = [0, 3, 255, 255, b'a'];
    let of_all_metadata = [0, 12, 255, 255, 255, 255, 255, 255, 0, 0, 0, 1];
    let of_an_entry =
        [0, 12, 0, 10, 0, 0, 0, 2, 0, 0, 0, 1, 0, 1, 0, 9, 0, 3, 0, 0, 0, 9, b'k', b'v'];
    let mut of_entries = vec![0, 12, 0x3e, 0x82, 0, 0, 0, 0, 0, 0, 0, 1];
    of_entries.extend(2000_u16.to_be_bytes());
    of_entries.resize(12 + 0x3e82, 0);
    // Shorter than it is, and longer than the body.
    let extended = |length: [u8; 2]| [&length[..], &[0; 60]].concat();
    for (version, kind, body, expected) in [
        (1, "TRANSFORM", vec![0; 47], "TRANSFORM of \"Probe\": found 47 bytes, expected 48"),
        (1, "POSITION", vec![0; 20], "found 20 bytes, expected 12, 24 or 28"),
        (1, "TDATA", vec![0; 71], "found 71 bytes, expected a multiple of 70"),
        (1, "QTDATA", vec![0; 49], "found 49 bytes, expected a multiple of 50"),
        (1, "POINT", vec![0; 1], "found 1 bytes, expected a multiple of 136"),
        (1, "STATUS", vec![0; 29], "found 29 bytes, expected 30 at least"),
        (1, "STT_TDATA", vec![0; 35], "found 35 bytes, expected 36"),
        (1, "STP_TDATA", vec![0; 1], "found 1 bytes, expected none"),
        (1, "STRING", of_string.to_vec(), "found 5 bytes"),
        (
            2,
            "TRANSFORM",
            of_all_metadata.to_vec(),
            "found an extended header and metadata of 4295032842 bytes, \
             expected no more than the body's 12",
        ),
        (2, "STP_TDATA", of_an_entry.to_vec(), "metadata that end in entry 1, expected 1 entries"),
        (2, "STP_TDATA", of_entries, "found 2000 entries of metadata, expected 1024 at most"),
        (2, "TRANSFORM", extended([0, 0]), "extended header"),
        (2, "TRANSFORM", extended([0, 11]), "extended header"),
        (2, "TRANSFORM", extended([255, 255]), "extended header"),
        (2, "TRANSFORM", vec![0; 5], "found 5 bytes, expected 12 at least"),
    ] {
        let error = messages(&framed(version, kind, &body))[0].as_ref().unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

#[test]
fn a_bad_name_costs_its_own_message_only() {
    let next = Message::new("next", Timestamp::NONE, Content::GetStatus);
    let names: [&[u8]; 3] = [b"Pr\xffobe", b"Pr\x1b[31m", b"\xc3"];
    for name in names {
        let mut stream = framed(1, "TRANSFORM", &[0; 48]);
        stream[14..34].fill(0);
        stream[14..14 + name.len()].copy_from_slice(name);
        stream.extend(next.encode().unwrap());
        let wrong = DecodeError::Name { kind: "TRANSFORM".to_owned(), device: name.to_vec() };
        let error = wrong.to_string();
        assert!(error.contains(&name.escape_ascii().to_string()), "{error}");
        for piece in [1, 1000] {
            let found = decode_in(piece, &stream).0;
            let expected = [Err(wrong.clone()), Ok(Decoded::Message(next.clone()))];
            assert_eq!(found, expected);
        }
    }
    // A length that lies is refused behind such a name too.
    let mut stream = framed(1, "IMAGE", &[]);
    stream[14] = 0xff;
    stream[42..50].copy_from_slice(&u64::MAX.to_be_bytes());
    assert!(messages(&stream)[0].as_ref().unwrap_err().ends_the_stream());
}

#[test]
fn a_bad_name_in_a_list_costs_its_own_tool_only() {
    let element = |name: &str| TrackingElement {
        name: name.to_owned(),
        kind: ToolKind::SixDof,
        matrix: Matrix([1.0; 12]),
    };
    let elements = vec![element("a"), element("b"), element("c")];
    let mut body = Vec::new();
    Content::Tracking(elements).encode(&mut body).unwrap();
    body[70] = 0xff;
    let found = messages(&framed(1, "TDATA", &body));
    let Ok(Decoded::Message(message)) = &found[0] else { panic!("{found:?}") };
    let expected = vec![element("a"), element(""), element("c")];
    assert_eq!(message.content, Content::Tracking(expected));
}

#[test]
fn other_protocols_end_the_stream() {
    let cases: [(Vec<u8>, &str); 3] = [
        (
            b"GET / HTTP/1.1\r\nHost: localhost\r\nUser-Agent: some browser\r\n\r\n".to_vec(),
            "found header version 18245, expected",
        ),
        (framed(1, "transform", &[]), "found a message type that begins \"transform\\x00"),
        (framed(3, "TRANSFORM", &[]), "found header version 3, expected"),
    ];
    for (stream, expected) in cases {
        let found = messages(&stream);
        let error = found[0].as_ref().unwrap_err();
        assert!(error.ends_the_stream() && error.to_string().contains(expected), "{error}");
        assert_eq!(found.len(), 1);
    }
}

#[test]
fn only_rotations_and_numbers_are_poses() {
    let quarter = Matrix([0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 10.0, 20.0, 30.0]);
    let pose = quarter.pose().unwrap();
    // Column by column: the x axis goes to y.
    let moved = pose * nalgebra::Point3::new(1.0, 0.0, 0.0);
    assert!((moved.coords - nalgebra::Vector3::new(10.0, 21.0, 30.0)).norm() < 1e-12);
    let changed = |index: usize, value: f32| {
        let mut matrix = quarter;
        matrix.0[index] = value;
        matrix.pose()
    };
    for (index, value) in [(0, f32::NAN), (11, f32::INFINITY)] {
        assert_eq!(changed(index, value), Err(NotAPose::NotFinite));
    }
    // A reflection, a scale, nothing at all.
    assert!(matches!(changed(8, -1.0), Err(NotAPose::NotARotation { .. })));
    assert!(matches!(changed(8, 1.05), Err(NotAPose::NotARotation { .. })));
    assert!(matches!(Matrix([0.0; 12]).pose(), Err(NotAPose::NotARotation { .. })));
    assert!(matches!(Matrix([f32::MAX; 12]).pose(), Err(NotAPose::NotARotation { .. })));
    assert!(changed(8, 1.0001).is_ok());

    let at = [1.0, 2.0, 3.0];
    assert_eq!(Orientation::None.pose(at), Err(NotAPose::NoOrientation));
    assert!(matches!(Orientation::Full([0.0; 4]).pose(at), Err(NotAPose::NotAUnit { .. })));
    assert_eq!(Orientation::Full([f32::NAN, 0.0, 0.0, 1.0]).pose(at), Err(NotAPose::NotFinite));
    assert_eq!(
        Orientation::Full([0.0, 0.0, 0.0, 1.0]).pose([f32::NAN, 0.0, 0.0]),
        Err(NotAPose::NotFinite)
    );
    // The scalar part that the short form leaves out.
    let third = Orientation::Vector([0.5, 0.5, 0.5]).pose(at).unwrap();
    let full = Orientation::Full([0.5, 0.5, 0.5, 0.5]).pose(at).unwrap();
    assert!(third.rotation.angle_to(&full.rotation) < 1e-7);
}

#[test]
fn what_a_field_cannot_hold_is_an_error() {
    let long = Message::new("a device of 21 bytes.", Timestamp::NONE, Content::GetStatus);
    let error = long.encode().unwrap_err().to_string();
    assert_eq!(
        error,
        "device name \"a device of 21 bytes.\" has 21 bytes, the message's field holds 20"
    );
    let text = Text { encoding: 3, bytes: vec![b'a'; 65_536] };
    let long = Message::new("", Timestamp::NONE, Content::Text(text));
    assert!(matches!(long.encode(), Err(EncodeError::TooMany { found: 65_536, .. })));
}

#[test]
fn timestamps_are_seconds_in_fixed_point() {
    let at = Timestamp::from_unix(std::time::Duration::new(1_700_000_000, 250_000_000));
    assert_eq!(at.0, (1_700_000_000_u64 << 32) | (1 << 30));
    assert!((at.seconds() - 1_700_000_000.25).abs() < 1e-6);
    let later = Timestamp(at.0 + (3 << 31));
    assert!((later.seconds_since(at) - 1.5).abs() < 1e-12);
    assert!((at.seconds_since(later) + 1.5).abs() < 1e-12);
    assert!(!Timestamp::NONE.is_stated() && at.is_stated());
}
