//! Rotation vectors: exponential, logarithms, angles, and the smallest rotation between axes.

use super::prelude::*;
use nalgebra::Quaternion;
use std::f64::consts::PI;

const EXPONENTIAL: Quantity = Quantity::new(
    "exponential, vector part",
    8.0,
    "1 + the angle, rad: how sine and cosine react to it",
    "length of the quaternion's vector part, at most 1",
);

const LOG_QUATERNION: Quantity =
    Quantity::new("logarithm of a quaternion, rad", 8.0, "1", "the angle, rad");

const LOG_MATRIX: Quantity =
    Quantity::new("logarithm of a matrix, rad", 16.0, "1", "the angle, rad");

const ANGLE: Quantity = Quantity::new("angle of a quaternion, rad", 8.0, "1", "the angle, rad");

const SMALLEST: Quantity =
    Quantity::new("smallest rotation between axes, rad", 8.0, "1", "the angle, rad");

const ANGLES: [(&str, f64); 15] = [
    ("0", 0.0),
    ("1e-150", 1e-150),
    ("1e-17", 1e-17),
    ("1e-12", 1e-12),
    ("0.99e-8", 0.99e-8),
    ("1.01e-8", 1.01e-8),
    ("1e-4", 1e-4),
    ("1", 1.0),
    ("π/2", PI / 2.0),
    ("2π/3", 2.0 * PI / 3.0),
    ("π − 1e-4", PI - 1e-4),
    ("π − 1e-8", PI - 1e-8),
    ("π − 1e-10", PI - 1e-10),
    ("π − 1e-12", PI - 1e-12),
    ("π", PI),
];

pub(super) fn family(_: Extent) -> Family {
    let mut cases = Vec::new();
    for (name, angle) in ANGLES {
        cases.push(Case::new(format!("rotation by {name}"), move |m, case| {
            let mut sequence = Sequence::new(31);
            let mut axes: Vec<_> = (0..12).map(|_| sequence.axis()).collect();
            axes.extend([Vector3::x_axis(), -Vector3::y_axis(), Vector3::z_axis()]);
            axes.push(Unit::new_normalize(Vector3::repeat(1.0)));
            let mut rows = [const { Vec::new() }; 4];
            for axis in axes {
                let vector = axis.into_inner() * angle;
                let exact = vector3(vector.into());
                let expected = references::exp(&exact);
                rows[0].push(exponential(case, &(m.exp)(&vector), &expected, angle));

                let nearest = UnitQuaternion::new_unchecked(Quaternion::new(
                    expected[0].to_f64(),
                    expected[1].to_f64(),
                    expected[2].to_f64(),
                    expected[3].to_f64(),
                ));
                let own = references::log(&references::quaternion(&nearest));
                let size = norm(&own).to_f64();
                let found = (m.log_quaternion)(&nearest);
                rows[1].push(LOG_QUATERNION.row(case, 1.0, distance(found.as_slice(), &own), size));
                let error = (High::from((m.angle)(&nearest)) - norm(&own)).abs();
                rows[2].push(ANGLE.row(case, 1.0, error.to_f64(), size));

                // A matrix in f64 is a little off the rotation; so is its logarithm.
                let matrix = references::nearest_matrix(&references::matrix(&expected));
                let found = (m.log_matrix)(&matrix);
                rows[3].push(log_matrix(case, &found, &exact, angle));
            }
            rows.into_iter().filter_map(Row::worst_of).collect()
        }));
    }
    for (name, angle) in ANGLES.into_iter().filter(|&(_, a)| a < PI - 1e-11) {
        cases.push(Case::new(format!("axes at {name}"), move |m, case| {
            let mut sequence = Sequence::new(13);
            let rows = (0..12).map(|_| {
                let from = sequence.axis();
                let turn = unit3(&vector3(sequence.vector().cross(&from).into()));
                let turn = references::matrix(&references::exp(&scale3(&turn, &High::from(angle))));
                let to = apply33(&turn, &axis3(&from));
                let to = Unit::new_unchecked(Vector3::from(to.map(|x| x.to_f64())));
                smallest(case, &(m.axis_rotation)(&from, &to).vector_rad, &from, &to)
            });
            Row::worst_of(rows.collect()).into_iter().collect()
        }));
    }
    // Closer to opposite than axes can be distinguished from opposite ones.
    for (name, gap) in [("π − 5e-13", 5e-13), ("π", 0.0)] {
        cases.push(Case::new(format!("axes at {name}"), move |m, case| {
            let mut sequence = Sequence::new(17);
            let is_right = (0..12).all(|_| {
                let from = sequence.axis();
                let aside = from.cross(&Vector3::y()).normalize() * gap;
                let found = (m.axis_rotation)(&from, &Unit::new_unchecked(aside - from.as_ref()));
                let v = found.vector_rad;
                found.is_ambiguous && (v.norm() - PI).abs() < 1e-15 && v.dot(&from).abs() < 1e-15
            });
            let must = "half a turn about a perpendicular, flagged";
            vec![Row::behaviour(case, must, is_right)]
        }));
    }
    Family {
        name: "rotations",
        about: "Exponential and logarithms between no turn and half a turn, about axes with and \
            without structure, against the same formulas.",
        quantities: vec![EXPONENTIAL, LOG_QUATERNION, ANGLE, LOG_MATRIX, SMALLEST],
        cases,
    }
}

fn exponential(case: &str, found: &UnitQuaternion<f64>, expected: &[High; 4], angle: f64) -> Row {
    let scale = norm(&expected[1..]).to_f64();
    let q = found.quaternion();
    let vector = distance(&[q.i, q.j, q.k], &expected[1..]);
    let scalar = (High::from(q.w) - &expected[0]).abs().to_f64();
    // The scalar part is good to the size of the whole.
    EXPONENTIAL.worst(case, 1.0 + angle, &[(vector, scale), (scalar, 1.0)])
}

/// At half a turn both signs of the axis are the same rotation.
fn log_matrix(case: &str, found: &Vector3<f64>, expected: &High3, angle: f64) -> Row {
    let near = distance(found.as_slice(), expected);
    let error = if angle < PI {
        near
    } else {
        near.min(distance(found.as_slice(), &scale3(expected, &-High::one())))
    };
    LOG_MATRIX.row(case, 1.0, error, angle)
}

fn smallest(
    case: &str,
    found: &Vector3<f64>,
    from: &Unit<Vector3<f64>>,
    to: &Unit<Vector3<f64>>,
) -> Row {
    let expected = references::axis_rotation(&axis3(from), &axis3(to));
    SMALLEST.row(case, 1.0, distance(found.as_slice(), &expected), norm(&expected).to_f64())
}
