use super::*;
use nalgebra::UnitQuaternion;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use trackwright_field::random_models::Seeded;
use trackwright_geometry::rotation::exp_vector;

/// No axis of any frame.
fn shaft() -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::new(0.2, -0.5, 0.8))
}

/// Where the tool stands in the tracker, and a turn about its shaft.
fn spun(turn_rad: f64) -> Pose {
    let stands = exp_vector(&Vector3::new(0.9, -1.7, 0.4));
    let turn = UnitQuaternion::from_axis_angle(&shaft(), turn_rad);
    pose_from_parts(Vector3::new(20.0, 30.0, -300.0), stands * turn)
}

fn turned_by(count: usize, sweep_rad: f64) -> Vec<Pose> {
    (0..count).map(|i| spun(sweep_rad * i as f64 / (count - 1) as f64)).collect()
}

fn off_rad(found: &Spin) -> f64 {
    let cosine = found.shaft_in_tool.dot(&shaft());
    found.shaft_in_tool.cross(&shaft()).norm().atan2(cosine)
}

#[test]
fn an_exact_turn_gives_the_shaft() {
    for sweep_deg in [16.0_f64, 90.0, 360.0, 1000.0] {
        let poses = turned_by(40, sweep_deg.to_radians());
        let found = spin(&poses, &SpinLimits::default()).unwrap();
        // Round-off over 1 − σ², which is 0.006 for the shortest turn.
        assert!(off_rad(&found) < 1e-12, "{sweep_deg}: {}", off_rad(&found));
        let there = poses[7].rotation * shaft();
        assert!((there.into_inner() - found.shaft_in_tracker.into_inner()).norm() < 1e-12);
        assert!(found.rms_rad < 1e-12 && found.worst_rad < 1e-12 && found.std_error_rad < 1e-12);
    }
    // Over whole turns every direction across the shaft is as often here as there.
    let whole: Vec<Pose> = (0..36).map(|i| spun(TAU / 36.0 * f64::from(i))).collect();
    let found = spin(&whole, &SpinLimits::default()).unwrap();
    assert!((found.turn_rad - 1.0).abs() < 1e-12);
    assert!((found.orientation_range_rad - PI).abs() < 1e-7);
}

#[test]
fn a_coning_shaft_is_off_by_its_half_angle() {
    // The tool turns about an axis of the tracker, and twice as far about its shaft: the shaft is
    // anywhere on a cone about the first, whose middle is what it points along on average.
    let half_rad = 1.5_f64.to_radians();
    let tilt = exp_vector(&(Vector3::x() * half_rad));
    let poses: Vec<Pose> = (0..72)
        .map(|i| {
            let turn = TAU / 36.0 * f64::from(i);
            let about = |angle: f64| exp_vector(&(Vector3::z() * angle));
            pose_from_parts(Vector3::zeros(), about(turn) * tilt * about(2.0 * turn))
        })
        .collect();
    let found = spin(&poses, &SpinLimits::default()).unwrap();
    assert!(found.shaft_in_tool.cross(&Vector3::z()).norm() < 1e-12);
    assert!(found.shaft_in_tracker.cross(&Vector3::z()).norm() < 1e-12);
    for angle in [found.rms_rad, found.worst_rad] {
        assert!((angle - half_rad).abs() < 1e-12, "{angle}");
    }
}

#[test]
fn each_insufficient_recording_is_refused() {
    let limits = SpinLimits::default();
    let refused = |poses: &[Pose]| spin(poses, &limits).unwrap_err();
    let few = refused(&turned_by(9, 3.0));
    assert_eq!(few, SpinError::TooFewPoses { found: 9, needed: 10 });
    let still = refused(&turned_by(50, 0.2));
    let SpinError::TooSmallRange { found_deg, .. } = still else {
        panic!("{still}");
    };
    assert!((found_deg - 0.2_f64.to_degrees()).abs() < 1e-9);
    // One pose of a thousand is turned.
    let mut hardly = vec![spun(0.0); 999];
    hardly.push(spun(1.0));
    assert!(matches!(refused(&hardly), SpinError::TooLittleTurn { .. }));
    // Swung in two directions, as for a pivot.
    let swung: Vec<Pose> = (0..60)
        .map(|i| {
            let (s, c) = (f64::from(i) * 2.4).sin_cos();
            let turn = exp_vector(&(Vector3::new(s, c, 0.0) * 0.5));
            pose_from_parts(Vector3::zeros(), turn)
        })
        .collect();
    let error = refused(&swung);
    let SpinError::TooLargeError { rms_deg, .. } = error else {
        panic!("{error}");
    };
    // Axes of swings lie across z: what lies there too moves by 0.5 rad times the sine between.
    let expected_deg = (0.5 / 2.0_f64.sqrt()).to_degrees();
    assert!((rms_deg - expected_deg).abs() < 1.0, "{rms_deg}");
    let lenient = SpinLimits { max_rms_rad: 1.0, min_poses: 0, ..limits };
    assert!(spin(&swung, &lenient).is_ok());
    let none = SpinError::TooFewPoses { found: 2, needed: 3 };
    assert_eq!(spin(&swung[..2], &lenient), Err(none));
}

#[test]
fn the_covariance_is_what_noise_does_to_the_shaft() {
    const RUNS: usize = 600;
    let mut noise = Seeded::new(11);
    // Less than a turn, so that both directions across the shaft are known differently well by
    // chance only, and a noise that a quarter of the limit is made of.
    let exact = turned_by(50, 2.0);
    let (mut measured, mut stated, mut rms) = (Matrix3::zeros(), Matrix3::zeros(), 0.0);
    for _ in 0..RUNS {
        let poses: Vec<Pose> = exact.iter().map(|p| noise.around(p, 0.0, 0.01)).collect();
        let found = spin(&poses, &SpinLimits::default()).unwrap();
        let off = found.shaft_in_tool.into_inner() - shaft().into_inner();
        measured += off * off.transpose() / RUNS as f64;
        stated += found.covariance / RUNS as f64;
        rms += found.rms_rad / RUNS as f64;
    }
    // Of a variance from 600 runs the standard deviation is √(2/600) of it; four of them, for the
    // largest of three entries, in the plane across the shaft.
    let allowed = 4.0 * (2.0 / RUNS as f64).sqrt() * stated.amax();
    assert!((measured - stated).amax() < allowed, "{measured} {stated}");
    assert!((stated * shaft().into_inner()).norm() < 1e-3 * stated.amax());
    // Two components a pose, of which four numbers are fitted to a hundred.
    let expected_rad = 0.01 * (2.0 * 96.0_f64 / 100.0).sqrt();
    assert!((rms / expected_rad - 1.0).abs() < 0.02, "{rms}");
}

#[test]
fn intervals_hold_for_a_hand_that_drifts() {
    const RUNS: usize = 200;
    for correlation in [0.0, 0.8, 0.95] {
        let mut noise = Seeded::new(12);
        let exact = turned_by(600, 8.0 * TAU);
        let across = shaft().cross(&Vector3::x()).normalize();
        let across = [across, shaft().cross(&across)];
        let (mut within, mut simple) = (0_u32, 0_u32);
        for _ in 0..RUNS {
            let drift = noise.autocorrelated(exact.len(), correlation);
            let poses: Vec<Pose> = exact
                .iter()
                .zip(&drift)
                .map(|(pose, turn)| {
                    let rotation = exp_vector(&(turn * 0.01)) * pose.rotation;
                    pose_from_parts(pose.translation.vector, rotation)
                })
                .collect();
            let found = spin(&poses, &SpinLimits::default()).unwrap();
            let off = found.shaft_in_tool.into_inner() - shaft().into_inner();
            let student = found.effective_size.student_975().unwrap();
            for axis in &across {
                let std_error = axis.dot(&(found.covariance * axis)).sqrt();
                within += u32::from(axis.dot(&off).abs() < student * std_error);
                // Whole turns: (2 · 0.01²)/2 a component, over as many poses.
                let independent = 0.01 / (exact.len() as f64).sqrt();
                simple += u32::from(axis.dot(&off).abs() < 1.96 * independent);
            }
        }
        let [within, simple] = [within, simple].map(|n| f64::from(n) / (2 * RUNS) as f64);
        // Of 400 the standard deviation of a part of 0.95 is 0.011; four of them.
        assert!(within > 0.95 - 0.044, "{correlation}: {within}");
        assert!(correlation == 0.0 || simple < 0.9, "{correlation}: {simple}");
    }
}

#[test]
fn the_shaft_points_to_the_tip() {
    let found = spin(&turned_by(30, 3.0), &SpinLimits::default()).unwrap();
    let tip = |mm: f64| Point3::from(shaft().into_inner() * mm);
    let forward = found.towards(&tip(150.0), 1.0);
    let back = found.towards(&tip(-150.0), 1.0);
    assert_eq!(forward.shaft_in_tool, -back.shaft_in_tool);
    assert_eq!(forward.shaft_in_tracker, -back.shaft_in_tracker);
    assert!(forward.shaft_in_tool.dot(&shaft()) > 0.0);
    assert_eq!(forward.direction, ShaftDirection::TowardsTip);
    assert_eq!(found.towards(&tip(2.9), 1.0).direction, ShaftDirection::Open);
    assert_eq!(found.towards(&Point3::origin(), 0.0).direction, ShaftDirection::Open);
}

#[test]
fn the_tip_frame_has_z_along_the_shaft() {
    let tip = Point3::new(1.0, -2.0, 150.0);
    for (towards, near) in [
        (Vector3::new(0.1, 0.2, 0.9), Vector3::x()),
        (Vector3::new(0.3, 0.0, -0.9), Vector3::x()),
        (Vector3::new(-0.95, 0.1, 0.1), Vector3::y()),
    ] {
        let towards = Unit::new_normalize(towards);
        let frame = tool_from_tip(&tip, &towards);
        assert_eq!(frame * Point3::origin(), tip);
        assert!((frame * Vector3::z() - towards.into_inner()).norm() < 1e-14);
        let x = frame * Vector3::x();
        // In the plane of the shaft and the tool's axis, and on that axis' side.
        assert!(x.dot(&near) > 0.9 && x.dot(&towards.cross(&near)).abs() < 1e-14);
        assert!((x.cross(&(frame * Vector3::y())) - towards.into_inner()).norm() < 1e-14);
    }
}

proptest! {
    /// Neither where the tracker's frame is nor which poses come first matters; a tool's frame
    /// that is turned turns the shaft with it.
    #[test]
    fn the_shaft_depends_on_the_tools_frame_alone(
        turn in prop::array::uniform3(-3.0..3.0_f64),
        own in prop::array::uniform3(-3.0..3.0_f64),
    ) {
        let mut noise = Seeded::new(5);
        let poses: Vec<Pose> = turned_by(30, 4.0)
            .iter()
            .map(|p| noise.around(p, 1.0, 0.01))
            .collect();
        let [turn, own] = [turn, own].map(|v| exp_vector(&v.into()));
        let other: Vec<Pose> = poses
            .iter()
            .rev()
            .map(|p| pose_from_parts(p.translation.vector, turn * p.rotation * own))
            .collect();
        let [a, b] = [poses, other].map(|p| spin(&p, &SpinLimits::default()).unwrap());
        let moved = own.inverse() * a.shaft_in_tool;
        prop_assert!(moved.cross(&b.shaft_in_tool).norm() < 1e-12);
        let moved = turn * a.shaft_in_tracker;
        prop_assert!(moved.cross(&b.shaft_in_tracker).norm() < 1e-12);
        prop_assert!((a.rms_rad - b.rms_rad).abs() < 1e-12);
        prop_assert!((a.std_error_rad - b.std_error_rad).abs() < 1e-12);
    }
}
