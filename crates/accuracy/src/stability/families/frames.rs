//! Frames of rigid bodies: what sensors determine together, and what they leave open.

use super::prelude::*;
use crate::stability::high_frames::{Determinacy, HighFrame};
use trackwright_geometry::rotation::exp_vector;

const ROTATION: Quantity = Quantity::new(
    "rotation, rad",
    10.0,
    "sum of the rows' lengths, body times reading, over the two smaller singular \
        values' sum (their difference where the best orthogonal matrix is a reflection); for a \
        free axis over the difference of the two largest",
    "1",
);

const TIP: Quantity = Quantity::new(
    "fitted tip, mm",
    10.0,
    "as for the rotation",
    "distance of the tip from the sensors' centroid, plus the largest coordinate over the \
        condition, mm",
);

/// A body, where it is, and what its sensors read there.
#[derive(Clone)]
struct Setup {
    body: RigidBody,
    weight_mm: f64,
    tracker_from_body: Pose,
    readings: Vec<Reading>,
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];
const SKEW: [f64; 3] = [0.3, -0.8, 0.52];

/// Position and axis of a 5-DOF sensor.
type At = ([f64; 3], [f64; 3]);

const SPREAD: [At; 4] = [
    ([0.0, 0.0, 60.0], Z),
    ([8.0, 1.0, 95.0], SKEW),
    ([-7.0, 9.0, 30.0], X),
    ([3.0, -11.0, 12.0], Y),
];
const ONE_LINE: [At; 3] = [([1.0, 2.0, 10.0], SKEW), ([2.0, 4.0, 20.0], X), ([4.0, 8.0, 40.0], Y)];
const ONE_LINE_PARALLEL: [At; 3] =
    [([0.0, 0.0, 10.0], Z), ([0.0, 0.0, 25.0], Z), ([0.0, 0.0, 70.0], Z)];
const NEARLY_ONE_LINE: [At; 3] =
    [([0.0, 0.0, 10.0], Z), ([0.0, 3e-2, 25.0], Z), ([0.0, 0.0, 70.0], Z)];
const ONE_PLANE: [At; 4] =
    [([0.0, 0.0, 5.0], X), ([30.0, 0.0, 5.0], Y), ([0.0, 20.0, 5.0], X), ([31.0, 22.0, 5.0], Y)];
const ONE_PLANE_PARALLEL: [At; 4] =
    [([0.0, 0.0, 5.0], Z), ([30.0, 0.0, 5.0], Z), ([0.0, 20.0, 5.0], Z), ([31.0, 22.0, 5.0], Z)];
const PARALLEL: [At; 3] =
    [([0.0, 0.0, 60.0], SKEW), ([8.0, 1.0, 95.0], SKEW), ([-7.0, 9.0, 30.0], SKEW)];
/// Three times one place whose mean is not that place to the last bit.
const SAME_PLACE: [At; 3] = [([0.1, 0.7, 1.3], SKEW), ([0.1, 0.7, 1.3], X), ([0.1, 0.7, 1.3], Y)];
const SAME_PLACE_PARALLEL: [At; 3] =
    [([0.1, 0.7, 1.3], SKEW), ([0.1, 0.7, 1.3], SKEW), ([0.1, 0.7, 1.3], SKEW)];
const ONE: [At; 1] = [([1.0, 2.0, 3.0], SKEW)];

const FAR: [f64; 3] = [1e6, -1e6, 1e6];
const HERE: [f64; 3] = [120.0, -80.0, -300.0];

pub(super) fn family(extent: Extent) -> Family {
    let sets: [(&str, &'static [At], f64, Determinacy); 22] = [
        ("four sensors", &SPREAD, 100.0, Determinacy::Full),
        ("four sensors, w = 0", &SPREAD, 0.0, Determinacy::Full),
        ("four sensors, w = 1e-12", &SPREAD, 1e-12, Determinacy::Full),
        ("four sensors, w = 1e-3", &SPREAD, 1e-3, Determinacy::Full),
        ("four sensors, w = 1e6", &SPREAD, 1e6, Determinacy::Full),
        ("four sensors, w = 1e12", &SPREAD, 1e12, Determinacy::Full),
        ("one line", &ONE_LINE, 100.0, Determinacy::Full),
        ("one line, w = 1e-12", &ONE_LINE, 1e-12, Determinacy::FreeAxis),
        ("one line, w = 0", &ONE_LINE, 0.0, Determinacy::FreeAxis),
        ("one line, parallel axes", &ONE_LINE_PARALLEL, 100.0, Determinacy::FreeAxis),
        ("nearly one line, parallel axes", &NEARLY_ONE_LINE, 100.0, Determinacy::Poor),
        ("one plane", &ONE_PLANE, 100.0, Determinacy::Full),
        ("one plane, parallel axes", &ONE_PLANE_PARALLEL, 100.0, Determinacy::Full),
        ("one plane, w = 0", &ONE_PLANE, 0.0, Determinacy::Full),
        ("parallel axes", &PARALLEL, 100.0, Determinacy::Full),
        ("parallel axes, w = 1e12", &PARALLEL, 1e12, Determinacy::FreeAxis),
        ("same place", &SAME_PLACE, 100.0, Determinacy::Full),
        ("same place, w = 1e-12", &SAME_PLACE, 1e-12, Determinacy::Full),
        ("same place, w = 0", &SAME_PLACE, 0.0, Determinacy::FreeRotation),
        ("same place, parallel axes", &SAME_PLACE_PARALLEL, 100.0, Determinacy::FreeAxis),
        ("one sensor", &ONE, 100.0, Determinacy::FreeAxis),
        ("one sensor, w = 0", &ONE, 0.0, Determinacy::FreeRotation),
    ];
    let mut cases = Vec::new();
    for (name, sensors, weight_mm, expected) in sets {
        for (place, at, body_offset) in [
            ("", HERE, [0.0; 3]),
            (", 1e6 mm away", FAR, [0.0; 3]),
            (", body 1e6 mm off its origin", HERE, FAR),
        ] {
            cases.push(Case::new(format!("{name}{place}"), move |m, case| {
                rows(m, case, &setup(sensors, body_offset, weight_mm, at, 0.0), expected)
            }));
            cases.push(Case::new(format!("{name}{place}, distorted"), move |m, case| {
                let setup = setup(sensors, body_offset, weight_mm, at, 1.0);
                rows(m, case, &setup, expected)
            }));
        }
    }
    cases.push(Case::new("a plane read as its mirror image, w = 0", |m, case| {
        let mut setup = setup(&ONE_PLANE, [0.0; 3], 0.0, HERE, 0.3);
        setup.tracker_from_body = Pose::identity();
        for (reading, sensor) in setup.readings.iter_mut().zip(&setup.body.sensors) {
            let p = sensor.position_in_body;
            let height = 1e-3 * (p.x - p.y);
            reading.position_mm = Point3::new(p.x, p.y, height);
        }
        rows(m, case, &setup, Determinacy::Full)
    }));
    cases.push(Case::new("four sensors read through a mirror, w = 0", |m, case| {
        let mut setup = setup(&SPREAD, [0.0; 3], 0.0, HERE, 0.0);
        for (reading, sensor) in setup.readings.iter_mut().zip(&setup.body.sensors) {
            let p = sensor.position_in_body;
            reading.position_mm = Point3::new(p.x, -p.y, p.z);
        }
        rows(m, case, &setup, Determinacy::Full)
    }));
    for (name, scale) in [("1e-6", 1e-6), ("1e6", 1e6)] {
        cases.push(Case::new(
            format!("four sensors, {name} times the size, w = 0"),
            move |m, case| {
                let mut body = five_dof(&SPREAD, [0.0; 3]);
                for sensor in &mut body.sensors {
                    sensor.position_in_body *= scale;
                }
                let setup = read(body, 0.0, [0.0; 3], 0.0);
                rows(m, case, &setup, Determinacy::Full)
            },
        ));
    }
    cases.push(Case::new("one 6-DOF sensor", |m, case| {
        rows(m, case, &six_dof(1, 1.0), Determinacy::Full)
    }));
    let many = if extent.is_full() { 10_000 } else { 500 };
    cases.push(Case::new(format!("{many} sensors"), move |m, case| {
        rows(m, case, &six_dof(many, 1.0), Determinacy::Full)
    }));
    Family {
        name: "frames",
        about: "The frame that fits a body's sensors, against the same fit in 192 bits: \
            cross-covariance, SVD by one-sided Jacobi, determinant sign. A rotation that is free \
            is the one nearest to the true pose, and is reported as free.",
        quantities: vec![ROTATION, TIP],
        cases,
    }
}

fn five_dof(sensors: &[At], offset: [f64; 3]) -> RigidBody {
    RigidBody {
        name: "body".to_owned(),
        tip_in_body: None,
        sensors: sensors
            .iter()
            .map(|(position, axis)| {
                let place = Point3::from(*position) + Vector3::from(offset);
                Sensor::five_dof("", place, Unit::new_normalize((*axis).into()))
            })
            .collect(),
    }
}

/// `distortion` is in mm; in units of 0.01 rad it turns the sensors.
fn setup(
    sensors: &[At],
    body_offset: [f64; 3],
    weight_mm: f64,
    at: [f64; 3],
    distortion: f64,
) -> Setup {
    read(five_dof(sensors, body_offset), weight_mm, at, distortion)
}

fn read(body: RigidBody, weight_mm: f64, at: [f64; 3], distortion: f64) -> Setup {
    let mut sequence = Sequence::new(8);
    let tracker_from_body =
        pose_from_parts(at.into(), UnitQuaternion::from_euler_angles(0.4, -1.1, 2.5));
    let readings = body
        .sensors
        .iter()
        .map(|s| {
            let true_pose = tracker_from_body * s.body_from_sensor();
            let turn = exp_vector(&(sequence.vector() * (0.01 * distortion)));
            Reading {
                position_mm: Point3::from(
                    true_pose.translation.vector + sequence.vector() * distortion,
                ),
                rotation: turn * true_pose.rotation,
            }
        })
        .collect();
    Setup { body, weight_mm, tracker_from_body, readings }
}

fn six_dof(count: usize, distortion: f64) -> Setup {
    let mut sequence = Sequence::new(19);
    let sensors =
        (0..count).map(|_| Sensor::six_dof("", sequence.vector() * 40.0, sequence.rotation()));
    let body = RigidBody { name: "body".to_owned(), tip_in_body: None, sensors: sensors.collect() };
    read(body, 100.0, HERE, distortion)
}

/// Rows of one fit; the exact one has to have the determinacy of the case, too.
fn rows(methods: &Methods, case: &str, setup: &Setup, expected: Determinacy) -> Vec<Row> {
    let truth = &setup.tracker_from_body;
    let found = (methods.frame)(&setup.body, setup.weight_mm, &setup.readings, truth);
    let exact = HighFrame::of(&setup.body, setup.weight_mm, &setup.readings);
    let is_right =
        Determinacy::of(&found.determination) == expected && exact.determinacy() == expected;
    let mut rows = vec![Row::behaviour(case, expected.must(), is_right)];
    let Some(fitted) = exact.fitted(truth) else {
        return rows;
    };
    let pose = found.tracker_from_body;
    let rotation = pose.rotation.to_rotation_matrix();
    let error = distance(rotation.matrix().transpose().as_slice(), &fitted.rotation.concat());
    rows.push(ROTATION.row(case, fitted.condition, error, 1.0));
    // 200 mm from the body's first sensor, where a needle's tip would be.
    let tip = setup.body.sensors[0].position_in_body + Vector3::new(0.0, 30.0, -200.0);
    let (expected, arm) = fitted.moved(&tip);
    let largest = [tip.coords.amax(), pose.translation.vector.amax()];
    let largest = setup
        .readings
        .iter()
        .map(|r| r.position_mm.coords.amax())
        .fold(largest[0].max(largest[1]), f64::max);
    let scale = arm + largest / fitted.condition;
    let error = distance((pose * tip).coords.as_slice(), &expected);
    rows.push(TIP.row(case, fitted.condition, error, scale));
    rows
}
