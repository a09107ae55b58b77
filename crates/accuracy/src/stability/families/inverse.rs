//! The pose behind a reading, by Newton's method on the distortion map.

use super::prelude::*;
use nalgebra::{Matrix5, Vector5};
use trackwright_field::inverse::InverseState;

const CONDITION: &str = "length of the Jacobian's inverse, angles taken as lengths of the box's \
    diagonal";

const POSITION: Quantity = Quantity::new(
    "position behind a reading, mm",
    20.0,
    CONDITION,
    "largest coordinate and the box's diagonal, times one plus the field's steepest slope",
);

const AXIS: Quantity = Quantity {
    name: "axis behind a reading, rad",
    scale: "the same over the box's diagonal",
    ..POSITION
};

/// Steps of the reference. Its Jacobian leaves out products of errors and their slopes, so each
/// step gains two digits at least.
const STEPS: usize = 30;

/// Where the reference has arrived, relative to the scale.
const ARRIVED: f64 = 1e-30;

pub(super) fn family(extent: Extent) -> Family {
    let poses = extent.of(5, 1);
    let room = cube([-100.0, -100.0, -300.0], 200.0);
    // Errors of 1 mm and 0.01 rad that change from coefficient to coefficient.
    let small = |order: usize, set, weighting, bounds| {
        (model(order, set, weighting, bounds, order as u64 + 3), poses)
    };
    let usual = |order, bounds| small(order, DirectionSet::Fourteen, Weighting::Area, bounds);
    let orders = extent
        .of(vec![1, 2, 3, 4], vec![1, 2])
        .into_iter()
        .map(|order| (format!("order {order}, 14 orientations"), usual(order, room)));
    let sets = extent
        .of(vec![DirectionSet::Six, DirectionSet::FortyTwo], vec![DirectionSet::Six])
        .into_iter()
        .map(|set| {
            let name = format!("order 2, {} orientations, gnomonic weights", set.len());
            (name, small(2, set, Weighting::Gnomonic, room))
        });
    let others = [
        ("order 2, a box of 1e6 mm", usual(2, cube([-5e5; 3], 1e6))),
        ("order 2, a box of 300 mm, offset by 1e6 mm", usual(2, cube([1e6, -1e6, 1e6], 300.0))),
        ("half of a fold, one orientation", (steep(66.0), poses)),
        ("a thousandth off a fold, one orientation", (steep(133.2), poses)),
    ];
    Family::new(
        "inverse",
        "The pose behind a reading, against the same equations solved in 192 bits from \
            there; next to a fold, and in a map that folds.",
        &[POSITION, AXIS],
    )
    .with(orders, rows)
    .with(sets, rows)
    .with(others, rows)
    .with([("a map that folds", steep(200.0))], folded)
}

/// `x` is moved by `3 a u (1 − u) (1 − 2 u)` in a box of 200 mm: the slope in the middle is
/// `−1.5 a / 200`, so that the map folds beyond a = 133.3 mm.
fn steep(a_mm: f64) -> Made {
    let along_x = [0.0, a_mm, -a_mm, 0.0];
    let coefficients =
        (0..64).map(|i| [along_x[i / 16], 0.3, -0.2, 0.0, 0.002 * (i % 4) as f64, 0.001]).collect();
    DistortionModel::of_position(3, cube([-100.0; 3], 200.0), coefficients)
        .map_err(|_| "is a model")
}

fn folded(methods: &Methods, model: &Made) -> Found {
    let model = &model.clone()?;
    let truths: Vec<_> = (0..81)
        .map(|i| {
            let x = -80.0 + 2.0 * f64::from(i) + 0.01;
            pose_from_parts(Vector3::new(x, 3.0, -4.0), UnitQuaternion::identity())
        })
        .collect();
    let readings: Vec<_> =
        truths.iter().map(|t| model.distort(t, OutsidePolicy::Clamp).0).collect();
    let found = (methods.undistort)(model, &readings, OutsidePolicy::Clamp);
    let is_back = |(truth, found): (&Pose, &(Option<Pose>, InverseState))| match found {
        (Some(pose), InverseState::Converged) => {
            (pose.translation.vector - truth.translation.vector).norm() < 1e-9
        }
        (Some(_), _) => true,
        (None, state) => *state != InverseState::Converged,
    };
    Ok(vec![
        must("what is not flagged is the pose", truths.iter().zip(&found).all(is_back)),
        must("some are flagged", found.iter().any(|f| f.1 != InverseState::Converged)),
    ])
}

/// Of so many readings in a model.
fn rows(methods: &Methods, (model, poses): &(Made, usize)) -> Found {
    let model = &model.clone()?;
    let bounds = model.bounds();
    let mut sequence = Sequence::new(55);
    // Well inside, so that no answer leaves the box, and as near to the middle of a steep
    // field as to its ends.
    let half = bounds.size_mm() * 0.5;
    let readings: Vec<_> = (0..*poses)
        .map(|i| {
            let part = 0.7 * i as f64 / *poses as f64;
            let at = bounds.center_mm() + sequence.vector().component_mul(&half) * part;
            let truth = pose_from_parts(at.coords, sequence.rotation());
            model.distort(&truth, OutsidePolicy::Clamp).0
        })
        .collect();
    let mut rows = Vec::new();
    let found = (methods.undistort)(model, &readings, OutsidePolicy::Clamp);
    for (reading, (pose, state)) in readings.iter().zip(&found) {
        let (Some(pose), InverseState::Converged) = (pose, state) else {
            return Err("converges");
        };
        rows.extend(compared(methods, model, reading, pose));
    }
    Ok(rows)
}

fn compared(methods: &Methods, model: &DistortionModel, reading: &Pose, found: &Pose) -> [Row; 2] {
    let equations = Equations::new(model, reading);
    let start = EvaluationPoint {
        position: vector3(found.translation.vector.into()),
        axis: unit3(&axis3(&(found.rotation * Vector3::z_axis()))),
    };
    let jacobian = equations.jacobian(methods, found);
    let diagonal = model.bounds().diagonal_mm();
    let [mm, rad] = [0..3, 3..6].map(|own| {
        let all = model.coefficients().iter().flat_map(|c| &c[own.clone()]);
        all.fold(0.0, |m: f64, v| m.max(v.abs()))
    });
    let extent = model.bounds().size_mm().min();
    let slope = 2.0 * model.order() as f64 * (mm + rad * diagonal) / extent;
    let coordinate = reading.translation.vector.amax();
    let scale = (1.0 + slope) * (coordinate + diagonal);
    let Some(inverse) = jacobian.try_inverse() else {
        return [POSITION, AXIS].map(|q| q.row(f64::INFINITY, f64::NAN, scale));
    };
    let condition = scaled(&inverse, diagonal).svd(false, false).singular_values.max();
    let (position, axis) = match equations.solved(start, &inverse, scale) {
        Some(exact) => (
            distance(found.translation.vector.as_slice(), &exact.position),
            distance((found.rotation * Vector3::z()).as_slice(), &exact.axis),
        ),
        None => (f64::NAN, f64::NAN),
    };
    [POSITION.row(condition, position, scale), AXIS.row(condition, axis, scale / diagonal)]
}

/// Rows and columns of an inverse Jacobian as lengths throughout.
fn scaled(inverse: &Matrix5<f64>, mm_per_rad: f64) -> Matrix5<f64> {
    Matrix5::from_fn(|i, j| {
        let row = if i < 3 { 1.0 } else { mm_per_rad };
        let column = if j < 3 { 1.0 } else { mm_per_rad };
        inverse[(i, j)] * row / column
    })
}

/// Position and unit axis of a sensor, to all digits.
struct EvaluationPoint {
    position: High3,
    axis: High3,
}

/// `p + e_pos(p, n) = p_m`, `exp(e_ori(p, n)) n = n_m`.
struct Equations<'a> {
    model: &'a DistortionModel,
    position: High3,
    axis: High3,
    /// Tangents of the read axis.
    tangents: [Vector3<f64>; 2],
}

impl<'a> Equations<'a> {
    fn new(model: &'a DistortionModel, reading: &Pose) -> Self {
        let axis: Unit<Vector3<f64>> = reading.rotation * Vector3::z_axis();
        let first = trackwright_geometry::rotation::perpendicular(&axis).into_inner();
        let turn = matrix(&quaternion(&reading.rotation));
        Self {
            model,
            position: vector3(reading.translation.vector.into()),
            axis: turn.column(2).into_owned(),
            tangents: [first, axis.cross(&first)],
        }
    }

    /// What is left of the five equations.
    fn remainder(&self, at: &EvaluationPoint) -> Option<Vector5<f64>> {
        let policy = OutsidePolicy::Clamp;
        let all = references::evaluate(self.model, &at.position, &at.axis, policy);
        let [x, y, z, rx, ry, rz] = all.into_iter().next()?.values;
        let [x, y, z] = (&at.position + High3::new(x, y, z) - &self.position).into();
        let turned = matrix(&references::exp(&High3::new(rx, ry, rz))) * &at.axis;
        // The tangents are those of f64; the read axis has a little of them.
        let off = turned - &self.axis;
        let [a, b] = self.tangents.map(|t| vector3(t.into()).dot(&off));
        Some([x, y, z, a, b].map(|x| x.to_f64()).into())
    }

    /// To first order in the errors, which is enough to go by.
    fn jacobian(&self, methods: &Methods, at: &Pose) -> Matrix5<f64> {
        let position = Point3::from(at.translation.vector);
        let axis = at.rotation * Vector3::z_axis();
        let policy = OutsidePolicy::Clamp;
        let [by_position, by_axis] = (methods.derivatives)(self.model, &position, &axis, policy);
        let e = (methods.evaluate)(self.model, &position, &axis, policy);
        let turn = UnitQuaternion::from_scaled_axis(e.rotation_rad);
        let turned = turn * axis.into_inner();
        let columns = [0, 1, 2, 3, 4].map(|column| {
            let (change, moved, tilted) = match column {
                0..3 => (by_position.column(column).into_owned(), Vector3::ith(column, 1.0), None),
                _ => (by_axis * self.tangents[column - 3], Vector3::zeros(), Some(column - 3)),
            };
            let length: Vector3<f64> = change.fixed_rows::<3>(0) + moved;
            let rotation: Vector3<f64> = change.fixed_rows::<3>(3).into_owned();
            let tilted = tilted.map_or(Vector3::zeros(), |k| turn * self.tangents[k]);
            let tilt = rotation.cross(&turned) + tilted;
            let [a, b] = self.tangents.map(|tangent| tangent.dot(&tilt));
            Vector5::new(length.x, length.y, length.z, a, b)
        });
        Matrix5::from_columns(&columns)
    }

    /// The exact answer near a start; `None` where the steps do not end.
    fn solved(
        &self,
        mut at: EvaluationPoint,
        inverse: &Matrix5<f64>,
        scale: f64,
    ) -> Option<EvaluationPoint> {
        for _ in 0..STEPS {
            let step = inverse * self.remainder(&at)?;
            at.position -= vector3([step[0], step[1], step[2]]);
            let [first, second] = self.tangents.map(|t| vector3(t.into()));
            let turn = first * High::from(step[3]) + second * High::from(step[4]);
            at.axis = unit3(&(&at.axis - turn));
            if step.norm() < ARRIVED * scale {
                return Some(at);
            }
        }
        None
    }
}
