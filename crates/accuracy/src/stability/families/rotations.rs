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
    // Closer to opposite than axes can be distinguished from opposite ones.
    let opposite = [("axes at π − 5e-13", 5e-13), ("axes at π", 0.0)];
    let named = |what: &str| ANGLES.map(|(name, angle)| (format!("{what} {name}"), angle));
    let less = named("axes at").into_iter().filter(|&(_, angle)| angle < PI - 1e-11);
    Family::new(
        "rotations",
        "Exponential and logarithms between no turn and half a turn, about axes with and \
            without structure, against the same formulas.",
        &[EXPONENTIAL, LOG_QUATERNION, ANGLE, LOG_MATRIX, SMALLEST],
    )
    .with(named("rotation by"), rotations)
    .with(less, between_axes)
    .with(opposite, half_turns)
}

/// By an angle about axes with and without structure.
fn rotations(methods: &Methods, &angle: &f64) -> Found {
    let mut sequence = Sequence::new(31);
    let mut axes: Vec<_> = (0..12).map(|_| sequence.axis()).collect();
    axes.extend([Vector3::x_axis(), -Vector3::y_axis(), Vector3::z_axis()]);
    axes.push(Unit::new_normalize(Vector3::repeat(1.0)));
    let mut rows = Vec::new();
    for axis in axes {
        let vector = axis.into_inner() * angle;
        let exact = vector3(vector.into());
        let expected = references::exp(&exact);
        rows.push(exponential(&(methods.exp)(&vector), &expected, angle));

        let [w, x, y, z] = expected.each_ref().map(High::to_f64);
        let nearest = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        let own = references::log(&quaternion(&nearest));
        let size = norm(&own).to_f64();
        let found = (methods.log_quaternion)(&nearest);
        rows.push(LOG_QUATERNION.row(1.0, distance(found.as_slice(), &own), size));
        let error = (High::from((methods.angle)(&nearest)) - norm(&own)).abs();
        rows.push(ANGLE.row(1.0, error.to_f64(), size));

        // A matrix in f64 is a little off the rotation; so is its logarithm.
        let turn = matrix(&expected);
        let found = (methods.log_matrix)(&turn.map(|x| x.to_f64()));
        rows.push(log_matrix(&found, &exact, angle));
    }
    Ok(rows)
}

fn between_axes(methods: &Methods, &angle: &f64) -> Found {
    let mut sequence = Sequence::new(13);
    let rows = (0..12).map(|_| {
        let from = sequence.axis();
        let turn = unit3(&vector3(sequence.vector().cross(&from).into()));
        let to = matrix(&references::exp(&(turn * High::from(angle)))) * axis3(&from);
        let to = Unit::new_unchecked(to.map(|x| x.to_f64()));
        let found = (methods.axis_rotation)(&from, &to).vector_rad;
        let expected = references::axis_rotation(&axis3(&from), &axis3(&to));
        SMALLEST.row(1.0, distance(found.as_slice(), &expected), norm(&expected).to_f64())
    });
    Ok(rows.collect())
}

/// Between axes that lack so little of being opposite.
fn half_turns(methods: &Methods, &gap: &f64) -> Found {
    let mut sequence = Sequence::new(17);
    let is_right = (0..12).all(|_| {
        let from = sequence.axis();
        let aside = from.cross(&Vector3::y()).normalize() * gap;
        let to = Unit::new_unchecked(aside - from.as_ref());
        let found = (methods.axis_rotation)(&from, &to);
        let v = found.vector_rad;
        found.is_ambiguous && (v.norm() - PI).abs() < 1e-15 && v.dot(&from).abs() < 1e-15
    });
    Ok(vec![must("half a turn about a perpendicular, flagged", is_right)])
}

fn exponential(found: &UnitQuaternion<f64>, expected: &[High; 4], angle: f64) -> Row {
    let scale = norm(&expected[1..]).to_f64();
    let q = found.quaternion();
    let vector = distance(&[q.i, q.j, q.k], &expected[1..]);
    let scalar = (High::from(q.w) - &expected[0]).abs().to_f64();
    // The scalar part is good to the size of the whole.
    EXPONENTIAL.worst(1.0 + angle, &[(vector, scale), (scalar, 1.0)])
}

/// At half a turn both signs of the axis are the same rotation.
fn log_matrix(found: &Vector3<f64>, expected: &High3, angle: f64) -> Row {
    let near = distance(found.as_slice(), expected);
    let error = if angle < PI { near } else { near.min(distance(found.as_slice(), &-expected)) };
    LOG_MATRIX.row(1.0, error, angle)
}
