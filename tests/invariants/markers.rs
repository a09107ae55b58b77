//! Position-only markers: what they read, what frame they give, and how sure it is.

use super::uncertainty::fitzpatrick_mm;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use trackwright_design::BodyRole;
use trackwright_field::OutsidePolicy;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_simulation::frame_fit::{FrameFitter, Reading};
use trackwright_simulation::linear_fit::{LinearFit, SensorCovariance};
use trackwright_simulation::{AxisRange, CancelToken, Mode, Motion, Scenario, simulate_pose};
use trackwright_simulation::{Determination, RigidBody, Sensor, SensorOrientation};

/// The four markers of NDI's passive probe 8700340 and of its reference frame 8700339.
const PROBE: [[f64; 3]; 4] =
    [[0.0, 0.0, 0.0], [0.0, 0.0, 50.0], [0.0, 25.0, 100.0], [0.0, -25.0, 135.0]];
const REFERENCE: [[f64; 3]; 4] =
    [[0.0, 0.0, 0.0], [0.0, 28.59, 41.02], [0.0, 0.0, 88.0], [0.0, -44.32, 40.45]];

fn markers(positions: &[[f64; 3]]) -> RigidBody {
    let marker = |(index, position): (usize, &[f64; 3])| Sensor {
        name: format!("marker {}", index + 1),
        position_in_body: (*position).into(),
        orientation: SensorOrientation::Marker,
        coil: None,
    };
    RigidBody {
        name: "optical".into(),
        tip_in_body: None,
        sensors: positions.iter().enumerate().map(marker).collect(),
    }
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
    let world = trackwright_project::open_builtin("pointer-on-head").unwrap();
    let mut scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    scenario.tool = RigidBody {
        tip_in_body: scenario.tool.tip_in_body,
        ..markers(&[[0.0, 0.0, 60.0], [15.0, 0.0, 100.0], [-12.0, 10.0, 130.0]])
    };
    scenario
}

/// A 5-DOF sensor of the tool that `optical` stands in for.
fn coil_of_pointer() -> Sensor {
    let world = trackwright_project::open_builtin("pointer-on-head").unwrap();
    let design = world.document.design();
    design.body(BodyRole::Tool).unwrap().rigid.sensors[0].clone()
}

#[test]
fn markers_in_a_row_leave_their_turn_free() {
    let truth = some_pose();
    for weight_mm in [0.0, 100.0, 1e6] {
        let body = markers(&PROBE);
        let fit =
            FrameFitter::new(&body, weight_mm).fit(&readings(&body, &truth), &Pose::identity());
        let gap = fit.tracker_from_body.inverse() * truth;
        // Some 300 mm, with round-off of 1e-16, over levers of some 30 mm.
        assert!(gap.rotation.angle() < 1e-13, "{}", gap.rotation.angle());
        assert!(gap.translation.vector.norm() < 1e-11);
        assert_eq!(fit.determination, Determination::Full);
        let row = markers(&PROBE[..2]);
        let fit = FrameFitter::new(&row, weight_mm).fit(&readings(&row, &truth), &truth);
        let Determination::FreeAxis { axis_in_body } = fit.determination else {
            panic!("{:?}", fit.determination);
        };
        assert!(axis_in_body.cross(&Vector3::z()).norm() < 1e-12);
    }
}

#[test]
fn markers_have_fitzpatricks_registration_error() {
    // Some figures were checked by 20,000 trials each: 0.7878 and 0.9547 mm.
    let cases = [(PROBE, [0.0, 0.0, -150.0], 0.7881), (REFERENCE, [120.0, 30.0, -60.0], 0.9575)];
    for (positions, target, published_mm) in cases {
        let body = markers(&positions);
        let target: Point3<f64> = target.into();
        let fit = LinearFit::new(&body, 100.0);
        // Rotations as uncertain as can be: a marker has none.
        let each = vec![SensorCovariance::isotropic(0.25, 1e3); 4];
        let variance = fit.covariance(&each).point_mm2(&fit.lever_mm(&target));
        let tre_mm = variance.trace().sqrt();
        assert!((tre_mm - published_mm).abs() < 5e-5, "{tre_mm}");

        let formula_mm = fitzpatrick_mm(&positions, target.into(), 0.25);
        assert!((tre_mm - formula_mm).abs() < 1e-12 * formula_mm);
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
    let range = |size: f64| Some(AxisRange { min: -size, max: size, step: size / 2.0 });
    // Long runs of one orientation, which are evaluated another way than single poses.
    scenario.motion =
        Some(Motion { x: range(20.0), y: range(20.0), rz: range(0.2), ..Motion::default() });
    let mut trials = Vec::new();
    let mut log = |trial: &trackwright_simulation::Trial| {
        trials.push((trial.crf_from_tool, trial.tip_error_mm));
    };
    trackwright_simulation::run(&scenario, &Mode::Motion, &CancelToken::default(), Some(&mut log))
        .unwrap();
    assert_eq!(trials.len(), 125);
    for (crf_from_tool, tip_error_mm) in trials {
        scenario.crf_from_tool = crf_from_tool;
        let single =
            trackwright_simulation::run(&scenario, &Mode::Single, &CancelToken::default(), None)
                .unwrap();
        let single_mm = single.figures.position_mm.max();
        let gap_mm = (tip_error_mm - single_mm).abs();
        assert!(gap_mm < 1e-11, "{tip_error_mm} {single_mm}");
    }
}
