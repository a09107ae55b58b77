//! What is sent on is good, what is not is reported as such, and every sample is counted once.

use super::*;
use crate::codec::{Extension, Position, Status, StatusCode, TrackingElement};
use crate::codec::{Orientation, QuaternionElement};
use proptest::prelude::*;
use std::sync::Arc;
use trackwright_field::compensation::Method;
use trackwright_field::{DistortionModel, Environment, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::pose_from_array;

fn pose(x: f64) -> Pose {
    pose_from_array([x, -20.0, -300.0, 0.8, 0.0, 0.6, 0.0]).unwrap()
}

fn stamp(seconds: f64) -> Timestamp {
    Timestamp::from_unix(Duration::from_secs_f64(1e9 + seconds))
}

fn transform(tool: &str, x: f64, seconds: f64) -> Message {
    let content = Content::Transform(Matrix::from_pose(&pose(x)));
    Message::new(tool, stamp(seconds), content)
}

/// A relay and the moment it began at; messages arrive as they are stamped.
struct TestRelay<'a> {
    relay: Relay<'a>,
    start: Instant,
}

impl<'a> TestRelay<'a> {
    fn new(correction: Option<Correction<'a>>) -> Self {
        Self { relay: Relay::new(correction, RelayOptions::default()), start: Instant::now() }
    }

    fn moment(&self, seconds: f64) -> Instant {
        self.start + Duration::from_secs_f64(seconds)
    }

    fn receive(&mut self, message: &Message, seconds: f64) -> Vec<Output> {
        let mut out = Vec::new();
        let at = self.moment(seconds);
        self.relay.receive(message, at, &mut out);
        out
    }

    fn tick(&mut self, seconds: f64) -> Vec<Output> {
        let mut out = Vec::new();
        let at = self.moment(seconds);
        self.relay.tick(at, &mut out);
        out
    }
}

fn sent(out: &[Output]) -> Vec<&SentPose> {
    out.iter()
        .filter_map(|output| match output {
            Output::Pose(sent) => Some(sent),
            _ => None,
        })
        .collect()
}

fn statuses(out: &[Output]) -> Vec<(&str, ToolState, &Status)> {
    out.iter()
        .filter_map(|output| match output {
            Output::Status { tool, state, message } => match &message.content {
                Content::Status(status) => Some((tool.as_str(), *state, status)),
                other => panic!("{other:?} is no status"),
            },
            _ => None,
        })
        .collect()
}

#[test]
fn without_a_room_a_transform_is_sent_on_as_it_came() {
    let mut bench = TestRelay::new(None);
    let mut message = transform("ProbeToReference", 1.0, 0.0);
    let mut extension = Extension::default();
    extension.set("TransformStatus", "OK");
    extension.set("Elsewhere", "kept");
    message.extension = Some(extension);
    let out = bench.receive(&message, 0.0);
    let found = &sent(&out)[0].message;
    assert!(is_same(found, &message), "{found:?}");
    assert_eq!(value(found, "Elsewhere"), "kept");
    // Nothing is known of it but that it is the first.
    for key in described::KEYS {
        let expected = match key {
            described::LATENCY_MS | described::CLOCK_SHIFT_MS => "0.000",
            _ => described::UNKNOWN,
        };
        assert_eq!(value(found, key), expected, "{key}");
    }
    assert_eq!(statuses(&out), []);
}

/// But for its metadata.
fn is_same(a: &Message, b: &Message) -> bool {
    (&a.device, a.timestamp, &a.content) == (&b.device, b.timestamp, &b.content)
}

fn value<'m>(message: &'m Message, key: &str) -> &'m str {
    let extension = message.extension.as_ref().expect("metadata");
    extension.get(key).expect("a value")
}

/// A room that measures everything 2 mm too far along x.
fn shifted_room() -> LiveRoom {
    let model = DistortionModel::of_position(
        1,
        Bounds::from(([-200.0, -200.0, -500.0], [200.0, 200.0, -100.0])),
        vec![[2.0, 0.0, 0.0, 0.0, 0.0, 0.0]; 8],
    )
    .unwrap();
    LiveRoom {
        environment: Arc::new(Environment::of_model("shifted", model)),
        outside: OutsidePolicy::Reject,
        method: Method::Inverse,
        design: None,
    }
}

#[test]
fn with_a_room_poses_are_compensated() {
    let room = shifted_room();
    let mut bench = TestRelay::new(Some(Correction::new(&room)));
    let out = bench.receive(&transform("Probe", 12.0, 0.0), 0.0);
    let found = sent(&out)[0];
    // To the tolerance of the inverse, and single precision.
    let off_mm = found.pose.translation.vector - pose(10.0).translation.vector;
    assert!(off_mm.norm() < 1e-5, "{off_mm}");
    assert!(found.pose.rotation.angle_to(&pose(0.0).rotation) < 1e-6);
    let Content::Transform(matrix) = &found.message.content else { panic!("{:?}", found.message) };
    assert_eq!(*matrix, Matrix::from_pose(&found.pose));
    assert_eq!((found.message.device.as_str(), found.message.timestamp), ("Probe", stamp(0.0)));

    // Far outside the box, and in a frame that the room is not measured in.
    let content = Content::Transform(Matrix::from_pose(&pose(1e5)));
    let out = bench.receive(&Message::new("Probe", stamp(0.1), content), 0.1);
    assert!(sent(&out).is_empty());
    assert_eq!(statuses(&out)[0].1, ToolState::NotGood(Reason::OutsideModel));
    let out = bench.receive(&transform("ProbeToReference", 1.0, 0.2), 0.2);
    assert!(sent(&out).is_empty());
    assert_eq!(statuses(&out)[0].1, ToolState::NotGood(Reason::OtherFrame));
    // What was measured is recorded in any case.
    assert!(matches!(&out[0], Output::Measured { pose: Ok(_), .. }));
}

#[test]
fn a_tool_named_as_a_body_uses_its_sensors() {
    let world = trackwright_project::open_builtin("pointer-on-head").unwrap();
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    let detail = trackwright_simulation::simulate_pose(&scenario);
    let mut design = LiveDesign::of(&scenario);
    design.assigned.insert("Other".to_owned(), None);
    let room = LiveRoom {
        environment: scenario.environment.clone(),
        outside: OutsidePolicy::Reject,
        method: Method::Inverse,
        design: Some(design),
    };
    let mut bench = TestRelay::new(Some(Correction::new(&room)));
    let crf = detail.crf.as_ref().unwrap();
    let mut received = |name: &str, seen: &trackwright_simulation::BodyDetail, seconds: f64| {
        let matrix = Matrix::from_pose(&seen.tracker_from_body_fitted);
        let message = Message::new(name, stamp(seconds), Content::Transform(matrix));
        let out = bench.receive(&message, seconds);
        sent(&out)[0].clone()
    };
    for (name, role, seen) in [
        ("StylusToTracker", BodyRole::Tool, &detail.tool),
        ("ReferenceToTracker", BodyRole::Crf, crf),
    ] {
        let found = received(name, seen, 0.0);
        assert_eq!(found.role, Some(role));
        let known = found.known.expect("a room with support");
        let tip_rms_mm = known.tip_rms_mm.unwrap();
        // The room leaves 0.036 mm RMS of measurements held out.
        assert!((0.001..0.1).contains(&tip_rms_mm), "{name}: {tip_rms_mm}");
        let written: f64 = value(&found.message, described::TIP_RMS_MM).parse().unwrap();
        assert!((written - tip_rms_mm).abs() <= 5.1e-5);
        let std_mm: f64 = value(&found.message, described::STD_MM).parse().unwrap();
        assert!((0.001..0.1).contains(&std_mm), "{name}: {std_mm}");
        let validity = value(&found.message, described::VALIDITY);
        assert_eq!(validity, if known.is_valid { "valid" } else { "invalid" });
        // Single precision at half a metre, there and back.
        let off_mm = found.pose.translation.vector - seen.tracker_from_body.translation.vector;
        assert!(off_mm.norm() < 5e-4, "{name}: {off_mm}");
    }
    let other = received("Other", &detail.tool, 0.0);
    assert_eq!(other.role, None);
    // A sensor at the frame's origin would read something else.
    let off_mm = other.pose.translation.vector - detail.tool.tracker_from_body.translation.vector;
    assert!(off_mm.norm() > 0.1, "{off_mm}");
}

#[test]
fn every_kind_of_message_gives_one_transform_a_tool() {
    let expected = pose(5.0);
    let [x, y, z] = expected.translation.vector.map(|v| v as f32).into();
    let q = expected.rotation.coords.map(|v| v as f32);
    let quaternion = [q.x, q.y, q.z, q.w];
    let position = Position { at_mm: [x, y, z], orientation: Orientation::Full(quaternion) };
    let elements = ["a", "b"].map(|name| TrackingElement {
        name: name.to_owned(),
        kind: ToolKind::FiveDof,
        matrix: Matrix::from_pose(&expected),
    });
    let quaternions = ["a", "b"].map(|name| QuaternionElement {
        name: name.to_owned(),
        kind: ToolKind::SixDof,
        at_mm: [x, y, z],
        quaternion,
    });
    for (content, names) in [
        (Content::Position(position), vec!["device"]),
        (Content::Tracking(elements.to_vec()), vec!["a", "b"]),
        (Content::QuaternionTracking(quaternions.to_vec()), vec!["a", "b"]),
    ] {
        let mut bench = TestRelay::new(None);
        let out = bench.receive(&Message::new("device", stamp(0.0), content), 0.0);
        let found = sent(&out);
        let devices: Vec<&str> = found.iter().map(|s| s.message.device.as_str()).collect();
        assert_eq!(devices, names);
        for sent in found {
            assert!((sent.pose.translation.vector - expected.translation.vector).norm() < 1e-5);
            assert!(sent.pose.rotation.angle_to(&expected.rotation) < 1e-6);
        }
    }
    // A place alone is no pose.
    let bare = Position { at_mm: [x, y, z], orientation: Orientation::None };
    let mut three = elements.to_vec();
    three[0].kind = ToolKind::ThreeDof;
    for content in [Content::Position(bare), Content::Tracking(three[..1].to_vec())] {
        let mut bench = TestRelay::new(None);
        let out = bench.receive(&Message::new("device", stamp(0.0), content), 0.0);
        assert!(sent(&out).is_empty());
        assert_eq!(statuses(&out)[0].1, ToolState::NotGood(Reason::NoOrientation));
    }
}

#[test]
fn untracked_tools_are_reported_until_tracked() {
    let mut bench = TestRelay::new(None);
    assert_eq!(sent(&bench.receive(&transform("Probe", 0.0, 0.0), 0.0)).len(), 1);
    let mut invalid = transform("Probe", 1.0, 0.025);
    invalid.extension = Some(Extension::default());
    let extension = invalid.extension.as_mut().unwrap();
    extension.set("TransformStatus", "INVALID");
    let out = bench.receive(&invalid, 0.025);
    assert!(sent(&out).is_empty());
    let [(tool, state, status)] = statuses(&out)[..] else { panic!("{out:?}") };
    assert_eq!((tool, state), ("Probe", ToolState::NotGood(Reason::NotTracked)));
    assert_eq!(status.code, StatusCode::NOT_PRESENT);
    assert_eq!(status.name, "NOT_TRACKED");
    let recorded = Err(Unusable::State("INVALID".to_owned()));
    assert!(matches!(&out[0], Output::Measured { pose, .. } if *pose == recorded));

    invalid.timestamp = stamp(0.05);
    assert!(statuses(&bench.receive(&invalid, 0.05)).is_empty());
    assert!(statuses(&bench.tick(0.9)).is_empty());
    assert_eq!(statuses(&bench.tick(1.1)).len(), 1);
    assert!(statuses(&bench.tick(1.2)).is_empty());

    let out = bench.receive(&transform("Probe", 2.0, 1.3), 1.3);
    assert_eq!(statuses(&out)[0].2.code, StatusCode::OK);
    assert_eq!(sent(&out).len(), 1);
    // In the order in which they are sent.
    assert!(matches!(&out[1..], [Output::Status { .. }, Output::Pose(_)]));
}

#[test]
fn a_silent_tool_is_stale_after_its_time() {
    let mut bench = TestRelay::new(None);
    bench.receive(&transform("Probe", 0.0, 0.0), 0.0);
    assert!(bench.tick(0.25).is_empty());
    let out = bench.tick(0.26);
    let [(_, state, status)] = statuses(&out)[..] else { panic!("{out:?}") };
    assert_eq!(state, ToolState::NotGood(Reason::Stale));
    assert_eq!(status.code, StatusCode::TIME_OUT);
    assert_eq!(bench.relay.counts().went_stale, 1);

    // One that sends the last sample again and again is as silent.
    let mut bench = TestRelay::new(None);
    let frozen = transform("Probe", 0.0, 0.0);
    for frame in 0..8 {
        let out = bench.receive(&frozen, f64::from(frame) / 40.0);
        assert_eq!(sent(&out).len(), usize::from(frame == 0));
    }
    assert_eq!(statuses(&bench.tick(0.26))[0].1, ToolState::NotGood(Reason::Stale));
    assert_eq!(bench.relay.counts().dropped[&Reason::Repeated], 7);
    // Without timestamps a tool that lies still looks like that, and is taken as it comes.
    let mut still = frozen;
    still.timestamp = Timestamp::NONE;
    assert_eq!(sent(&bench.receive(&still, 0.3)).len(), 1);
    assert_eq!(sent(&bench.receive(&still, 0.4)).len(), 1);
}

#[test]
fn a_lost_server_takes_tools_and_clock_with_it() {
    let mut bench = TestRelay::new(None);
    for tool in ["a", "b"] {
        bench.receive(&transform(tool, 0.0, 100.0), 0.0);
    }
    let mut out = Vec::new();
    let now = bench.moment(0.1);
    bench.relay.lost(now, &mut out);
    let lost = statuses(&out);
    assert_eq!(lost.len(), 2);
    assert!(lost.iter().all(|s| s.1 == ToolState::NotGood(Reason::LinkLost)));
    // It comes back with a clock that was set back, which is taken once it has lasted, and shown.
    let mut first = None;
    for frame in 0..120 {
        let after = f64::from(frame) / 40.0;
        let out = bench.receive(&transform("a", after, 3.0 + after), 0.2 + after);
        if let Some(sent) = sent(&out).first() {
            first.get_or_insert((frame, sent.clock.shift_s));
        }
    }
    let (frame, shift_s) = first.unwrap();
    assert!((80..=81).contains(&frame), "{frame}");
    assert!((shift_s - 97.2).abs() < 1e-3, "{shift_s}");
    assert_eq!(bench.relay.counts().clock_jumps, 1);
}

#[test]
fn late_samples_are_not_sent_and_reported_as_late() {
    let mut bench = TestRelay::new(None);
    let (mut taken, mut changes) = (0, Vec::new());
    let mut reasons = Vec::new();
    for frame in 0..400 {
        let at = f64::from(frame) / 40.0;
        // After a second everything is two seconds late.
        let sent_at = if frame < 40 { at } else { at - 2.0 };
        let mut out = bench.receive(&transform("Probe", at, 10.0 + sent_at), at);
        out.extend(bench.tick(at));
        taken += sent(&out).len();
        reasons.extend(statuses(&out).into_iter().map(|(_, state, _)| state));
        changes.extend(out.into_iter().filter_map(|output| match output {
            Output::Clock { change, .. } => Some(change),
            _ => None,
        }));
    }
    assert_eq!(taken, 40);
    // At once, and every second.
    assert!(reasons.len() >= 8, "{reasons:?}");
    assert!(reasons.iter().all(|state| *state == ToolState::NotGood(Reason::Late)));
    assert!(
        matches!(changes[..], [ClockChange::Late { by_s }] if (by_s - 2.0).abs() < 1e-6),
        "{changes:?}"
    );
    let out = bench.receive(&transform("Probe", 0.0, 20.0), 10.0);
    assert_eq!(statuses(&out)[0].2.code, StatusCode::OK);
    assert_eq!(bench.relay.counts().dropped[&Reason::Late], 360);
}

#[test]
fn latency_is_stated_for_every_pose() {
    let mut bench = TestRelay::new(None);
    for frame in 0..40 {
        let at = f64::from(frame) / 40.0;
        let delay = if frame % 2 == 0 { 0.0 } else { 0.1 };
        let out = bench.receive(&transform("Probe", at, at), at + delay);
        let [sent] = sent(&out)[..] else { panic!("{out:?}") };
        let found: f64 = value(&sent.message, described::LATENCY_MS).parse().unwrap();
        // What drift allows for in a second.
        assert!((found - 1e3 * delay).abs() < 0.3, "{found}");
    }
}

#[test]
fn samples_without_a_name_are_reported_once() {
    let mut bench = TestRelay::new(None);
    let elements = ["", "b", " "].map(|name| TrackingElement {
        name: name.to_owned(),
        kind: ToolKind::SixDof,
        matrix: Matrix::from_pose(&pose(1.0)),
    });
    let mut refused = 0;
    for frame in 0..10 {
        let at = f64::from(frame) / 40.0;
        let content = Content::Tracking(elements.to_vec());
        let out = bench.receive(&Message::new("", stamp(at), content), at);
        assert_eq!(sent(&out).len(), 1);
        let is_refusal = |output: &&Output| matches!(output, Output::Refused { .. });
        refused += out.iter().filter(is_refusal).count();
    }
    assert_eq!(refused, 1);
    assert_eq!(bench.relay.counts().dropped[&Reason::NoName], 20);
    assert_eq!(bench.relay.tools.len(), 1);
}

#[test]
fn unordered_frames_are_dropped_and_steps_counted() {
    let mut bench = TestRelay::new(None);
    for frame in 0..40 {
        bench.receive(
            &transform("Probe", f64::from(frame), f64::from(frame) / 40.0),
            f64::from(frame) / 40.0,
        );
    }
    let out = bench.receive(&transform("Probe", -1.0, 0.95), 1.0);
    assert!(sent(&out).is_empty() && statuses(&out).is_empty());
    assert_eq!(bench.relay.counts().dropped[&Reason::OutOfOrder], 1);
    // Set ahead by an hour: too early for a quarter of a second, then taken.
    let mut taken = 0;
    for frame in 41..121 {
        let at = f64::from(frame) / 40.0;
        let out = bench.receive(&transform("Probe", f64::from(frame), at + 3600.0), at);
        taken += sent(&out).len();
    }
    assert!((69..=70).contains(&taken), "{taken}");
    assert_eq!(bench.relay.counts().clock_jumps, 1);
}

#[test]
fn a_sender_that_goes_on_naming_tools_fills_no_memory() {
    let mut bench = TestRelay::new(None);
    for n in 0..MAX_TOOLS + 50 {
        bench.receive(&transform(&format!("tool {n}"), 0.0, 0.0), 0.0);
    }
    assert_eq!(bench.relay.tools.len(), MAX_TOOLS);
    assert_eq!(bench.relay.counts().dropped[&Reason::TooManyTools], 50);
    assert_eq!(bench.relay.counts().sent, MAX_TOOLS as u64);
}

proptest! {
    #[test]
    fn every_sample_is_sent_or_dropped(
        messages in prop::collection::vec(
            (0..3_usize, -2.0..2.0_f64, prop::array::uniform12(-2.0_f32..2.0), any::<bool>(), any::<bool>()),
            0..60,
        ),
    ) {
        let mut bench = TestRelay::new(None);
        for (index, (tool, stamped, values, is_pose, is_valid)) in messages.iter().enumerate() {
            let at = index as f64 / 40.0;
            let matrix = if *is_pose { Matrix::from_pose(&pose(*stamped)) } else { Matrix(*values) };
            let mut message = Message::new(["a", "b", "c"][*tool], stamp(10.0 + stamped), Content::Transform(matrix));
            if !is_valid {
                let mut extension = Extension::default();
                extension.set("Status", "MISSING");
                message.extension = Some(extension);
            }
            let out = bench.receive(&message, at);
            for sent in sent(&out) {
                prop_assert!(is_valid);
                prop_assert!(matrix.pose().is_ok());
                prop_assert!(is_same(&sent.message, &message));
            }
            bench.tick(at);
        }
        let counts = bench.relay.counts();
        prop_assert_eq!(counts.poses, messages.len() as u64);
        prop_assert_eq!(counts.sent + counts.dropped.values().sum::<u64>(), counts.poses);
    }
}
