//! Position-only markers: what they read, what frame they give, and how sure it is.

use super::uncertainty::PUBLISHED;
use crate::support::studies::{body, default_in_polynomials, marker, steps, study};
use nalgebra::{UnitQuaternion, Vector3};
use trackwright_field::OutsidePolicy;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_simulation::frame_fit::{FrameFitter, Reading};
use trackwright_simulation::{
    CancelToken, Determination, Mode, Motion, RigidBody, Scenario, Sensor, Trial, run,
    simulate_pose,
};

fn markers(positions: &[[f64; 3]]) -> RigidBody {
    body(positions.iter().map(|at| marker(*at)).collect(), None)
}

/// Readings without error, turned at random: nobody reads a marker's rotation.
fn readings(body: &RigidBody, tracker_from_body: &Pose) -> Vec<Reading> {
    let read = |(index, sensor): (usize, &Sensor)| Reading {
        position_mm: tracker_from_body * sensor.position_in_body,
        rotation: UnitQuaternion::from_euler_angles(index as f64, 1.0, -2.0),
    };
    body.sensors.iter().enumerate().map(read).collect()
}

fn some_pose() -> Pose {
    pose_from_parts(
        Vector3::new(30.0, -40.0, -300.0),
        UnitQuaternion::from_euler_angles(0.4, -1.1, 2.5),
    )
}

/// A pointer in the room of the built-in design, with markers in the place of coils.
fn optical() -> Scenario {
    let mut scenario = default_in_polynomials();
    scenario.tool = RigidBody {
        tip_in_body: scenario.tool.tip_in_body,
        ..markers(&[[0.0, 0.0, 60.0], [15.0, 0.0, 100.0], [-12.0, 10.0, 130.0]])
    };
    scenario
}

/// A 5-DOF sensor of the tool that `optical` stands in for.
fn coil_of_pointer() -> Sensor {
    default_in_polynomials().tool.sensors[0].clone()
}

#[test]
fn markers_in_a_row_leave_their_turn_free() {
    let truth = some_pose();
    for weight_mm in [0.0, 100.0, 1e6] {
        let (probe, ..) = PUBLISHED[0];
        let body = markers(&probe);
        let fit =
            FrameFitter::new(&body, weight_mm).fit(&readings(&body, &truth), &Pose::identity());
        let gap = fit.tracker_from_body.inverse() * truth;
        // Some 300 mm, with round-off of 1e-16, over levers of some 30 mm.
        assert!(gap.rotation.angle() < 1e-13, "{}", gap.rotation.angle());
        assert!(gap.translation.vector.norm() < 1e-11);
        assert_eq!(fit.determination, Determination::Full);
        let row = markers(&probe[..2]);
        let fit = FrameFitter::new(&row, weight_mm).fit(&readings(&row, &truth), &truth);
        let Determination::FreeAxis { axis_in_body } = fit.determination else {
            panic!("{:?}", fit.determination);
        };
        assert!(axis_in_body.cross(&Vector3::z()).norm() < 1e-12);
    }
}

#[test]
fn a_marker_reads_the_mean_over_orientations() {
    let mut scenario = optical();
    // Beside a coil, so that both kinds are evaluated in one body.
    scenario.tool.sensors.insert(1, coil_of_pointer());
    let detail = simulate_pose(&scenario);
    let model = &scenario.environment.model;
    let axes = model.directions().directions();
    assert!(axes.len() > 1, "one orientation would prove nothing");
    for (sensor, read) in scenario.tool.sensors.iter().zip(&detail.tool.sensors) {
        let at = detail.tool.tracker_from_body * sensor.position_in_body;
        let along = |axis| model.evaluate(&at, axis, OutsidePolicy::Clamp).error;
        match sensor.axis_in_body() {
            None => {
                let sum: Vector3<f64> = axes.iter().map(|axis| along(axis).position_mm).sum();
                let mean = sum / axes.len() as f64;
                assert!((read.error.position_mm - mean).norm() < 1e-12);
                assert!(mean.norm() > 0.01);
                assert_eq!(read.error.rotation_rad, Vector3::zeros());
            }
            Some(axis) => {
                let axis = detail.tool.tracker_from_body.rotation * axis;
                let expected = along(&axis).position_mm;
                assert!((read.error.position_mm - expected).norm() < 1e-12);
            }
        }
    }
}

#[test]
fn a_motion_is_its_poses_one_by_one() {
    let mut scenario = optical();
    scenario.tool.sensors.push(coil_of_pointer());
    // Long runs of one orientation, which are evaluated another way than single poses.
    let (x, rz) = (steps(20.0, 4.0), steps(0.2, 4.0));
    scenario.motion = Some(Motion { x, y: x, rz, ..Motion::default() });
    let mut trials = Vec::new();
    let mut log = |trial: &Trial| trials.push((trial.crf_from_tool, trial.tip_error_mm));
    run(&scenario, &Mode::Motion, &CancelToken::default(), Some(&mut log)).unwrap();
    assert_eq!(trials.len(), 125);
    for (crf_from_tool, tip_error_mm) in trials {
        scenario.crf_from_tool = crf_from_tool;
        let single_mm = study(&scenario, &Mode::Single).room_field.position_mm.max();
        let gap_mm = (tip_error_mm - single_mm).abs();
        assert!(gap_mm < 1e-11, "{tip_error_mm} {single_mm}");
    }
}
