//! First-order covariance of a fitted point, and the tip error itself.

use super::prelude::*;
use crate::references::cross_matrix;
use trackwright_geometry::rotation::exp_vector;
use trackwright_simulation::linear_fit::SensorCovariance;

const COVARIANCE: Quantity = Quantity::new(
    "covariance of the tip, mm²",
    20.0,
    "of A, times how much longer the sensors' coordinates are than their distances \
        from the centroid, plus one",
    "the covariance, largest entry",
);

const TIP_ERROR: Quantity = Quantity::new(
    "tip error, mm",
    8.0,
    "1",
    "the largest coordinate of poses, plus the tip's distance from the tool's origin, mm",
);

const ANGLE_ERROR: Quantity = Quantity::new("angle error, rad", 8.0, "1", "1");

pub(super) fn family(extent: Extent) -> Family {
    let near = |aside_mm: f64| body(4, aside_mm, false, 0.0);
    let far = |aside_mm: f64| body(4, aside_mm, false, 1e6);
    let parallel = |aside_mm: f64| body(4, aside_mm, true, 0.0);
    let many = extent.of(10_000, 300);
    let bodies = [
        ("four sensors", near(10.0), 100.0),
        ("four sensors, body 1e6 mm off its origin", far(10.0), 100.0),
        ("four sensors, w = 0", near(10.0), 0.0),
        ("four sensors, w = 0, body 1e6 mm off its origin", far(10.0), 0.0),
        ("four sensors, w = 1e-12", near(10.0), 1e-12),
        ("four sensors, w = 1e-12, body 1e6 mm off its origin", far(10.0), 1e-12),
        ("four sensors, w = 1e12", near(10.0), 1e12),
        ("four sensors, w = 1e12, body 1e6 mm off its origin", far(10.0), 1e12),
        ("four sensors 0.1 mm off a line, w = 0", near(0.1), 0.0),
        ("four sensors 0.1 mm off a line, w = 0, body 1e6 mm off its origin", far(0.1), 0.0),
        // Coordinates of 1e6 mm do not hold what these are about.
        ("four sensors 2e-3 mm off a line, w = 0", near(2e-3), 0.0),
        ("four sensors 2e-3 mm off a line, parallel axes, w = 1", parallel(2e-3), 1.0),
    ]
    .map(|(name, body, weight_mm)| (name, (body, weight_mm)));
    let refused = [
        ("four sensors on a line", (parallel(0.0), 0.0)),
        ("parallel axes, w = 1e12", (parallel(10.0), 1e12)),
    ];
    let many = (format!("{many} sensors"), (body(many, 10.0, false, 0.0), 100.0));
    let tools = [
        ("tool 300 mm away, off by 1 mm and 0.01 rad", (300.0, 0.01)),
        ("tool 300 mm away, off by 1 mm and 1e-12 rad", (300.0, 1e-12)),
        ("tool 1e6 mm away, off by 1 mm and 0.01 rad", (1e6, 0.01)),
        ("tool 300 mm away, off by 1 mm and 3 rad", (300.0, 3.0)),
    ];
    Family::new(
        "uncertainty and tip error",
        "The first-order covariance of a tip 200 mm away from unlike sensor covariances, \
            near the bodies that determine no rotation, and the tip error of two poses.",
        &[COVARIANCE, TIP_ERROR, ANGLE_ERROR],
    )
    .with(bodies, covariance)
    .with(refused, not_determined)
    .with([many], covariance)
    .with(tools, tip_error)
}

/// A body and the weight of its axes in mm.
type Weighted = (RigidBody, f64);

fn not_determined(methods: &Methods, (body, weight_mm): &Weighted) -> Found {
    let one = Matrix3::identity();
    let own = [SensorCovariance { position_mm2: one, rotation_rad2: one }; 4];
    let refused = (methods.covariance)(body, *weight_mm, &own, &Point3::origin()).is_err();
    Ok(vec![must("refused: not determined", refused)])
}

/// Sensors along z, off that line by `aside_mm`.
fn body(count: usize, aside_mm: f64, is_parallel: bool, offset_mm: f64) -> RigidBody {
    let mut sequence = Sequence::new(61);
    body_of((0..count).map(|i| {
        let along = 25.0 * i as f64 / (count as f64 / 4.0);
        let aside = Vector3::new(sequence.signed(), sequence.signed(), 0.0) * aside_mm;
        let place = Vector3::new(0.0, 0.0, along) + aside + Vector3::repeat(offset_mm);
        let axis = sequence.axis();
        Sensor::five_dof("", place, if is_parallel { Vector3::z_axis() } else { axis })
    }))
}

fn covariance(methods: &Methods, (body, weight_mm): &Weighted) -> Found {
    let mut sequence = Sequence::new(62);
    let mut symmetric = |size: f64| {
        let m = Matrix3::from_fn(|_, _| sequence.signed());
        m * m.transpose() * size
    };
    let sensor =
        |_| SensorCovariance { position_mm2: symmetric(0.25), rotation_rad2: symmetric(2.5e-5) };
    let sensors: Vec<_> = (0..body.sensors.len()).map(sensor).collect();
    let tip = body.sensors[0].position_in_body + Vector3::new(0.0, 30.0, -200.0);
    let found =
        (methods.covariance)(body, *weight_mm, &sensors, &tip).map_err(|_| "is determined")?;
    let exact = HighCovariance::of(body, *weight_mm, &sensors, &tip);
    let expected = exact.covariance;
    let scale = expected.iter().map(|x| x.abs().to_f64()).fold(0.0, f64::max);
    let error = distance(found.as_slice(), &expected);
    Ok(vec![COVARIANCE.row(exact.condition, error, scale)])
}

/// First-order uncertainty as `docs/methods/uncertainty.md` states it.
struct HighCovariance {
    covariance: High33,
    condition: f64,
}

impl HighCovariance {
    fn of(
        body: &RigidBody,
        weight_mm: f64,
        sensors: &[SensorCovariance],
        tip: &Point3<f64>,
    ) -> Self {
        let n = body.sensors.len() as f64;
        let weight = High::from(weight_mm) * weight_mm;
        let own: Vec<_> = body.sensors.iter().map(|s| point3(&s.position_in_body)).collect();
        let centroid = own.iter().sum::<High3>() / High::from(n);
        let arms: Vec<_> = own.iter().map(|p| p - &centroid).collect();
        let crosses: Vec<_> = arms.iter().map(cross_matrix).collect();
        let seen: Vec<_> =
            body.sensors.iter().map(|s| seen(&s.orientation) * weight.clone()).collect();
        // |x|² I − x xᵀ = −[x]²
        let terms = seen.iter().zip(&crosses).map(|(seen, cross)| seen - cross * cross);
        let a: High33 = terms.sum();
        let values = a.map(|x| x.to_f64()).symmetric_eigenvalues();
        let gain = cross_matrix(&(point3(tip) - &centroid)) * inverse33(&a);
        let mut covariance = High33::zeros();
        for ((cross, seen), c) in crosses.iter().zip(&seen).zip(sensors) {
            let j = High33::identity() / High::from(n) - &gain * cross;
            for (gain, c) in [(j, c.position_mm2), (&gain * seen, c.rotation_rad2)] {
                covariance += &gain * c.map(High::from) * gain.transpose();
            }
        }
        let longest = |points: &[High3]| {
            let lengths = points.iter().map(|p| norm(p).to_f64());
            lengths.fold(0.0, f64::max)
        };
        Self {
            covariance,
            condition: values.max() / values.min() * (1.0 + longest(&own) / longest(&arms)),
        }
    }
}

fn seen(orientation: &SensorOrientation) -> High33 {
    match orientation {
        SensorOrientation::Marker => High33::zeros(),
        SensorOrientation::FiveDof(axis) => {
            let n = axis3(axis);
            High33::identity() - &n * n.transpose()
        }
        SensorOrientation::SixDof(_) => High33::identity() * High::from(2.0),
    }
}

/// Of poses so far away, turned against each other by so much.
fn tip_error(methods: &Methods, &(place_mm, turn_rad): &(f64, f64)) -> Found {
    let mut sequence = Sequence::new(71);
    let mut rows = Vec::new();
    for _ in 0..6 {
        let truth = pose_from_parts(sequence.vector() * place_mm, sequence.rotation());
        let turn = exp_vector(&(sequence.axis().into_inner() * turn_rad));
        let simulated =
            pose_from_parts(truth.translation.vector + sequence.vector(), turn * truth.rotation);
        let tip = Point3::from(sequence.vector() * 200.0);
        let found = (methods.relative_error)(&truth, &simulated, &tip);
        let at = |pose: &Pose| {
            let place = vector3(pose.translation.vector.into());
            matrix(&quaternion(&pose.rotation)) * point3(&tip) + place
        };
        let expected = at(&simulated) - at(&truth);
        let scale = place_mm + tip.coords.norm();
        let error = distance(found.tip_error_in_crf_mm.as_slice(), &expected);
        rows.push(TIP_ERROR.row(1.0, error, scale));
        let between = between(&quaternion(&simulated.rotation), &quaternion(&truth.rotation));
        let angle = norm(&references::log(&between));
        let error = (High::from(found.angle_rad) - angle).abs().to_f64();
        rows.push(ANGLE_ERROR.row(1.0, error, 1.0));
    }
    Ok(rows)
}

/// `a b⁻¹`, up to its length.
fn between(a: &[High; 4], b: &[High; 4]) -> [High; 4] {
    let vector = |[_, x, y, z]: &[High; 4]| High3::new(x.clone(), y.clone(), z.clone());
    let (av, bv) = (vector(a), -vector(b));
    let scalar = &a[0] * &b[0] - av.dot(&bv);
    let [x, y, z] = (&av * b[0].clone() + &bv * a[0].clone() + av.cross(&bv)).into();
    [scalar, x, y, z]
}
