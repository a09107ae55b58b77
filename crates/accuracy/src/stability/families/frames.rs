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

/// A body, where it is, what its sensors read there, and what they determine.
struct Setup {
    body: RigidBody,
    weight_mm: f64,
    tracker_from_body: Pose,
    readings: Vec<Reading>,
    expected: Determinacy,
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
    let places = [
        ("", HERE, [0.0; 3]),
        (", 1e6 mm away", FAR, [0.0; 3]),
        (", body 1e6 mm off its origin", HERE, FAR),
    ];
    let sets = sets.into_iter().flat_map(|(name, sensors, weight_mm, expected)| {
        places.into_iter().flat_map(move |(place, at, body_offset)| {
            [("", 0.0), (", distorted", 1.0)].map(|(how, distortion)| {
                let body = five_dof(sensors, body_offset);
                let setup = read(body, weight_mm, at, distortion);
                (format!("{name}{place}{how}"), Setup { expected, ..setup })
            })
        })
    });
    let mut plane = read(five_dof(&ONE_PLANE, [0.0; 3]), 0.0, HERE, 0.3);
    plane.tracker_from_body = Pose::identity();
    let plane = reading_at(plane, |p| Point3::new(p.x, p.y, 1e-3 * (p.x - p.y)));
    let four = read(five_dof(&SPREAD, [0.0; 3]), 0.0, HERE, 0.0);
    let scaled = |scale: f64| {
        let mut body = five_dof(&SPREAD, [0.0; 3]);
        for sensor in &mut body.sensors {
            sensor.position_in_body *= scale;
        }
        read(body, 0.0, [0.0; 3], 0.0)
    };
    let many = extent.of(10_000, 500);
    let others = [
        ("a plane read as its mirror image, w = 0".to_owned(), plane),
        (
            "four sensors read through a mirror, w = 0".to_owned(),
            reading_at(four, |p| Point3::new(p.x, -p.y, p.z)),
        ),
        ("four sensors, 1e-6 times the size, w = 0".to_owned(), scaled(1e-6)),
        ("four sensors, 1e6 times the size, w = 0".to_owned(), scaled(1e6)),
        ("one 6-DOF sensor".to_owned(), six_dof(1)),
        (format!("{many} sensors"), six_dof(many)),
    ];
    Family::new(
        "frames",
        "The frame that fits a body's sensors, against the same fit in 192 bits: \
            cross-covariance, SVD by one-sided Jacobi, determinant sign. A rotation that is free \
            is the one nearest to the true pose, and is reported as free.",
        &[ROTATION, TIP],
    )
    .with(sets, rows)
    .with(others, rows)
}

fn five_dof(sensors: &[At], offset: [f64; 3]) -> RigidBody {
    body_of(sensors.iter().map(|(position, axis)| {
        let place = Point3::from(*position) + Vector3::from(offset);
        Sensor::five_dof("", place, Unit::new_normalize((*axis).into()))
    }))
}

/// Fully determined. `distortion` is in mm; in units of 0.01 rad it turns the sensors.
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
    Setup { body, weight_mm, tracker_from_body, readings, expected: Determinacy::Full }
}

/// Each sensor read at a place of its position in the body.
fn reading_at(mut setup: Setup, place: fn(Point3<f64>) -> Point3<f64>) -> Setup {
    for (reading, sensor) in setup.readings.iter_mut().zip(&setup.body.sensors) {
        reading.position_mm = place(sensor.position_in_body);
    }
    setup
}

fn six_dof(count: usize) -> Setup {
    let mut sequence = Sequence::new(19);
    let sensors =
        (0..count).map(|_| Sensor::six_dof("", sequence.vector() * 40.0, sequence.rotation()));
    read(body_of(sensors), 100.0, HERE, 1.0)
}

/// Rows of one fit; the exact one has to have the determinacy of the case, too.
fn rows(methods: &Methods, setup: &Setup) -> Found {
    let truth = &setup.tracker_from_body;
    let found = (methods.frame)(&setup.body, setup.weight_mm, &setup.readings, truth);
    let exact = HighFrame::of(&setup.body, setup.weight_mm, &setup.readings);
    let reported = [Determinacy::of(&found.determination), exact.determinacy()];
    let mut rows = vec![must(setup.expected.must(), reported == [setup.expected; 2])];
    let Some(fitted) = exact.fitted(truth) else {
        return Ok(rows);
    };
    let pose = found.tracker_from_body;
    let rotation = pose.rotation.to_rotation_matrix();
    let error = distance(rotation.matrix().as_slice(), &fitted.rotation);
    rows.push(ROTATION.row(fitted.condition, error, 1.0));
    // 200 mm from the body's first sensor, where a needle's tip would be.
    let tip = setup.body.sensors[0].position_in_body + Vector3::new(0.0, 30.0, -200.0);
    let (expected, arm) = fitted.moved(&tip);
    let readings = setup.readings.iter().map(|r| r.position_mm.coords.amax());
    let largest = readings.fold(tip.coords.amax().max(pose.translation.vector.amax()), f64::max);
    let error = distance((pose * tip).coords.as_slice(), &expected);
    rows.push(TIP.row(fitted.condition, error, arm + largest / fitted.condition));
    Ok(rows)
}
