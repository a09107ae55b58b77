//! The formula against closed forms and the simulation; what moves it and what does not.

use super::{
    PUBLISHED, alone, assert_agree, body, built_in, fitzpatrick_mm, five, head, jitter, on_head,
    six, three_fives,
};
use crate::support::studies::{marker, one_direction, steps};
use nalgebra::{UnitQuaternion, Vector3};
use std::sync::Arc;
use trackwright_field::environment::{Jitter, JitterGrowth};
use trackwright_geometry::pose::pose_from_parts;
use trackwright_geometry::volume::Volume;
use trackwright_simulation::uncertainty::{first_order, over_motion};
use trackwright_simulation::{Motion, RigidBody, Scenario};
use trackwright_task::Task;

#[test]
fn a_six_dof_sensor_scatters_as_its_reading() {
    let lever: Vector3<f64> = Vector3::new(0.0, 30.0, 90.0);
    let tool = body(vec![six([0.0; 3], [0.1, 0.2, 0.3])], lever.into());
    let found = first_order(&alone(tool, 95.0, jitter())).unwrap();
    let Jitter { position_mm, angle_rad, .. } = jitter();
    let expected = (3.0 * position_mm.powi(2) + 2.0 * (angle_rad * lever.norm()).powi(2)).sqrt();
    assert!((found.rms_mm - expected).abs() < 1e-13);
    assert!((found.rotation_rms_rad - 3.0_f64.sqrt() * angle_rad).abs() < 1e-16);
}

#[test]
fn position_only_tools_have_fitzpatricks_error() {
    for (places, tip, published) in PUBLISHED {
        // With no weight on axes any will do, and a marker has none.
        let coils = (places.map(|p| five(p, [0.0, 0.0, 1.0])).to_vec(), 0.0);
        let markers = (places.map(marker).to_vec(), 100.0);
        for (sensors, weight_mm) in [coils, markers] {
            let scenario = alone(body(sensors, tip), weight_mm, Jitter::uniform(0.25, 0.01));
            let found = first_order(&scenario).unwrap().rms_mm;
            let closed = fitzpatrick_mm(&places, tip, 0.25);
            assert!((found - closed).abs() < 1e-13, "{weight_mm}: {found} {closed}");
            assert!((found - published).abs() < 5e-5, "{weight_mm}: {found} {published}");
            assert_agree(&scenario, "markers");
        }
    }
}

#[test]
fn tool_and_crf_add_up_as_west_and_maurer_state() {
    let tool = alone(three_fives(), 60.0, jitter());
    let both = on_head(tool.clone(), head());
    let tip_in_crf = both.crf_from_tool * both.tool.judged_tip_in_body();
    let crf = alone(RigidBody { tip_in_body: Some(tip_in_crf), ..head() }, 60.0, jitter());
    let [tool, crf, both] = [tool, crf, both].map(|s| first_order(&s).unwrap());
    assert!((both.rms_mm - tool.rms_mm.hypot(crf.rms_mm)).abs() < 1e-12);
    assert!(
        (both.rotation_rms_rad - tool.rotation_rms_rad.hypot(crf.rotation_rms_rad)).abs() < 1e-15
    );
}

#[test]
fn moving_the_tool_changes_only_the_axes() {
    let scenario = alone(three_fives(), 60.0, jitter());
    let at_home = first_order(&scenario).unwrap();
    let turn = pose_from_parts(
        Vector3::new(-100.0, 70.0, -20.0),
        UnitQuaternion::from_euler_angles(2.0, 1.4, -0.8),
    );
    let moved = first_order(&Scenario { crf_from_tool: turn * scenario.crf_from_tool, ..scenario })
        .unwrap();
    let r = turn.rotation.to_rotation_matrix().into_inner();
    let expected = r * at_home.covariance_mm2 * r.transpose();
    assert!((moved.covariance_mm2 - expected).norm() < 1e-13);
    assert!((moved.rms_mm - at_home.rms_mm).abs() < 1e-13);
    let (a, b) = (moved.ellipsoid.lengths_mm(), at_home.ellipsoid.lengths_mm());
    assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-12), "{a:?} {b:?}");
}

#[test]
fn growing_jitter_scatters_more_farther_away() {
    let scenario = alone(
        three_fives(),
        60.0,
        Jitter { growth: Some(JitterGrowth::dipole(200.0)), ..jitter() },
    );
    let at = |z_mm: f64| {
        first_order(&Scenario {
            crf_from_tool: pose_from_parts(
                Vector3::new(0.0, 0.0, z_mm),
                UnitQuaternion::identity(),
            ),
            ..scenario.clone()
        })
        .unwrap()
        .rms_mm
    };
    let rms = [-150.0, -300.0, -500.0].map(at);
    assert!(rms[0] < rms[1] && rms[1] < rms[2], "{rms:?}");
}

#[test]
fn the_order_of_the_sensors_does_not_matter() {
    let scenario = on_head(alone(three_fives(), 60.0, jitter()), head());
    let mut other = scenario.clone();
    other.tool.sensors.rotate_left(1);
    other.crf.as_mut().unwrap().body.sensors.swap(0, 2);
    let (a, b) = (first_order(&scenario).unwrap(), first_order(&other).unwrap());
    assert!((a.covariance_mm2 - b.covariance_mm2).norm() < 1e-13);
    assert!((a.cross_covariance_mm_rad - b.cross_covariance_mm_rad).norm() < 1e-15);
}

#[test]
fn first_order_bias_is_right_to_second_order() {
    let difference = [1.0, 0.1, 0.01].map(|field| {
        let tip = first_order(&built_in(field)).unwrap();
        assert!(tip.bias_check.holds, "{:?}", tip.bias_check);
        assert_eq!(
            (tip.bias_mm - tip.bias_check.simulated_mm).norm(),
            tip.bias_check.difference_mm
        );
        tip.bias_check.difference_mm
    });
    // Ten times less field, a hundred times less of the second order; the third adds some per
    // cent to the first ratio.
    for (ratio, slack) in
        [(difference[0] / difference[1], 20.0), (difference[1] / difference[2], 2.0)]
    {
        assert!((ratio - 100.0).abs() < slack, "{ratio}");
    }
}

#[test]
fn a_uniform_field_is_no_bias_against_a_crf() {
    let bounds = Volume::AuroraCube.bounds();
    let error = [0.7, -0.4, 0.2, 1e-4, 2e-4, -3e-4];
    let mut scenario = on_head(alone(three_fives(), 1e6, jitter()), head());
    let room = Arc::make_mut(&mut scenario.environment);
    room.model = one_direction(1, bounds, vec![error; 8]);
    let tip = first_order(&scenario).unwrap();
    // With this weight axes decide the rotations: both bodies turn alike, and each shifts by the
    // same, so that what is left is the turn times the distance of the centroids.
    assert!(tip.rotation_bias_rad.norm() < 1e-9, "{tip:?}");
    scenario.crf = None;
    assert!(first_order(&scenario).unwrap().rotation_bias_rad.norm() > 3e-4);
}

#[test]
fn over_motion_each_pose_scatters_as_alone() {
    let motion = Motion { x: steps(30.0, 1.0), ry: steps(40.0, 2.0), ..Motion::default() };
    let grown = Jitter { growth: Some(JitterGrowth::dipole(250.0)), ..jitter() };
    let scenario =
        Scenario { motion: Some(motion), ..on_head(alone(three_fives(), 60.0, grown), head()) };
    let over = over_motion(&scenario, &Task::default()).unwrap();
    let grid = scenario.motion_grid().unwrap().unwrap();
    let each: Vec<_> = (0..grid.trials())
        .map(|index| {
            let at = Scenario { crf_from_tool: grid.pose(index), ..scenario.clone() };
            let tip = first_order(&at).unwrap();
            (tip.rms_mm, tip.rotation_rms_rad.to_degrees())
        })
        .collect();
    assert_eq!(over.trials, 6);
    let n = each.len() as f64;
    let rms =
        |of: fn(&(f64, f64)) -> f64| (each.iter().map(|e| of(e).powi(2)).sum::<f64>() / n).sqrt();
    assert!((over.rms_mm.rms() - rms(|e| e.0)).abs() < 1e-12);
    assert!((over.rotation_rms_deg.rms() - rms(|e| e.1)).abs() < 1e-12);
    assert!((each[over.worst_trial].0 - over.rms_mm.max()).abs() < 1e-12);
    assert!(each.iter().all(|e| e.0 >= over.rms_mm.min() - 1e-12));
    assert!(over.rms_mm.max() > 1.01 * over.rms_mm.min());
    assert_eq!(over.total_rms_mm(0.0), over.rms_mm.rms());
}
