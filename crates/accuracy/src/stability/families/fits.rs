//! Fits of distortion models to samples of fields that measurements can have.

use super::prelude::*;
use crate::stability::systems::{Reference, SOLUTION};
use trackwright_field::fit::{Fit, FitMethod};
use trackwright_geometry::directions::DirectionWeights;

const RESIDUAL: Quantity = Quantity::new(
    "position RMS after the fit, mm",
    10.0,
    "1",
    "position RMS before it plus the largest coefficient, mm",
);

type Field = fn(&Vector3<f64>) -> Vector3<f64>;

/// What is sampled, in coordinates from the middle of the box over its half size.
const SMOOTH: Field =
    |u| Vector3::new((u.x + 0.4 * u.y).sin(), 0.5 * (u.z * 0.8).exp(), u.x * u.y - u.z);

pub(super) fn family(extent: Extent) -> Family {
    let room = cube([-250.0, -250.0, -600.0], 500.0);
    let smooth =
        |order: usize, rows_per_unknown: f64| scattered(room, order, rows_per_unknown, SMOOTH);
    let orders = extent
        .of(vec![1, 2, 3, 4, 5], vec![1, 2])
        .into_iter()
        .map(|order| (format!("order {order}, a smooth field"), one(order, smooth(order, 1.4))));
    let boxes = [
        ("order 2, a box of 1e-6 mm", cube([-3e-7; 3], 1e-6)),
        ("order 2, a box of 1e6 mm", cube([-5e5; 3], 1e6)),
        ("order 2, a box of 300 mm, offset by 1e6 mm", cube([1e6, -1e6, 1e6], 300.0)),
        ("order 2, a box of 1e-6 mm, offset by 1 mm", cube([1.0; 3], 1e-6)),
        (
            "order 2, a box of 1e-9 mm height",
            Bounds::from(([-100.0, -100.0, 0.0], [100.0, 100.0, 1e-9])),
        ),
    ]
    .map(|(name, bounds)| (name, one(2, scattered(bounds, 2, 2.0, SMOOTH))));
    let sharp = extent.of(4, 2);
    // 60 mm wide: twelve doublings.
    let edge: Field = |u| Vector3::new((u.x * 6.0).exp2(), 0.3 * (u.y * 6.0).exp2(), 0.1 * u.z);
    let source: Field = |u| {
        let r = u - Vector3::new(1.1, 0.2, -0.1);
        r / r.norm().powi(4)
    };
    let fields = [
        ("a metal edge: doubles within 5 mm", cube([0.0; 3], 60.0), edge),
        ("a 1/r³ source 5 mm beside the volume", cube([-50.0; 3], 100.0), source),
    ]
    .map(|(name, bounds, field)| {
        (format!("order {sharp}, {name}"), one(sharp, scattered(bounds, sharp, 1.6, field)))
    });
    let clusters = moved(smooth(2, 3.0), |i, p| {
        Sequence::new(300 + (i % 5) as u64).point_in(&room) + (p - room.center_mm()) * 0.01
    });
    type Move = fn(Point3<f64>) -> Point3<f64>;
    let placed: [(&str, Move); 4] = [
        ("order 2, positions in one plane", |p| Point3::new(p.x, p.y, -350.0)),
        ("order 2, positions in a tilted plane", |p| {
            Point3::new(p.x, p.y, -350.0 + 0.3 * p.x - 0.1 * p.y)
        }),
        ("order 2, positions on one line", |p| Point3::new(p.x, 0.5 * p.x, p.x - 350.0)),
        ("order 2, all samples at one place", |_| Point3::new(10.0, 20.0, -300.0)),
    ];
    let placed = placed.map(|(name, place)| (name, one(2, moved(smooth(2, 2.0), |_, p| place(p)))));
    let gnomonic = Problem {
        weighting: Weighting::Gnomonic,
        ..each(1, DirectionSet::FortyTwo, smooth(1, 30.0))
    };
    // Mirrors axes that have a part along +x.
    let mirrored = turned(smooth(1, 20.0), |v| Vector3::new(-v.x.abs(), v.y, v.z));
    let faint = turned(smooth(1, 20.0), |v| Vector3::new(1e-12 * (1.0 + v.x.abs()), v.y, v.z));
    let several = [
        ("order 2, 14 orientations", each(2, DirectionSet::Fourteen, smooth(2, 20.0))),
        ("order 1, 42 orientations, gnomonic weights", gnomonic),
        ("order 1, 6 orientations, none sampled near +x", each(1, DirectionSet::Six, mirrored)),
        (
            "order 1, 6 orientations, +x known by weights of 1e-12 alone",
            each(1, DirectionSet::Six, faint),
        ),
    ];
    let joint = |problem: Problem| Problem { is_joint: true, ..problem };
    let sets = vec![(1, DirectionSet::Six), (1, DirectionSet::Fourteen), (2, DirectionSet::Six)];
    let sets = extent.of(sets, vec![(1, DirectionSet::Six)]).into_iter().map(|(order, set)| {
        let samples = smooth(order, 1.5 * set.len() as f64);
        let name = format!("order {order}, {} orientations, joint", set.len());
        (name, joint(each(order, set, samples)))
    });
    let mirrored = turned(smooth(1, 9.0), |v| Vector3::new(-v.x.abs(), v.y, v.z));
    let mirrored = joint(each(1, DirectionSet::Six, mirrored));
    Family::new(
        "fits",
        "Coefficients of fitted models, against each system built and solved in 192 bits \
            from the samples' own numbers. The samples' weights are the program's; they have rows \
            of their own.",
        &[SOLUTION, RESIDUAL],
    )
    .with(orders, rows)
    .with(boxes, rows)
    .with(fields, rows)
    .with([("order 2, five clusters of 5 mm in 500 mm", one(2, clusters))], rows)
    .with(placed, rows)
    .with(several, rows)
    .with(sets, rows)
    .with([("order 1, 6 orientations, joint, none sampled near +x", mirrored)], rows)
}

/// Samples and how they are to be fitted.
struct Problem {
    samples: Vec<Sample>,
    order: usize,
    directions: DirectionSet,
    weighting: Weighting,
    is_joint: bool,
}

fn one(order: usize, samples: Vec<Sample>) -> Problem {
    each(order, DirectionSet::One, samples)
}

fn each(order: usize, directions: DirectionSet, samples: Vec<Sample>) -> Problem {
    Problem { samples, order, directions, weighting: Weighting::Area, is_joint: false }
}

fn scattered(bounds: Bounds, order: usize, rows_per_unknown: f64, field: Field) -> Vec<Sample> {
    let mut sequence = Sequence::new(order as u64 + 500);
    let count = (coefficient_count(order) as f64 * rows_per_unknown).round() as usize + 2;
    let half = bounds.size_mm() / 2.0;
    (0..count)
        .map(|_| {
            let position_mm = sequence.point_in(&bounds);
            let axis = sequence.axis();
            let u = (position_mm - bounds.center_mm()).component_div(&half);
            // Errors depend on the axis, too, and are noisy as measured ones are.
            let e = field(&u) + axis.into_inner() * 0.2 + sequence.vector() * 0.01;
            Sample::new(
                position_mm,
                axis,
                PoseError { position_mm: e, rotation_rad: e.cross(&axis) * 0.01 },
            )
        })
        .collect()
}

fn moved(
    mut samples: Vec<Sample>,
    place: impl Fn(usize, Point3<f64>) -> Point3<f64>,
) -> Vec<Sample> {
    for (i, s) in samples.iter_mut().enumerate() {
        s.position_mm = place(i, s.position_mm);
    }
    samples
}

fn turned(mut samples: Vec<Sample>, turn: fn(Vector3<f64>) -> Vector3<f64>) -> Vec<Sample> {
    for s in &mut samples {
        s.axis = Unit::new_normalize(turn(s.axis.into_inner()));
    }
    samples
}

fn rows(methods: &Methods, problem: &Problem) -> Found {
    let settings = FitSettings {
        method: if problem.is_joint { FitMethod::Joint } else { FitMethod::PerDirection },
        weighting: problem.weighting,
        ..FitSettings::new(problem.order, problem.directions)
    };
    let set = SampleSet { samples: problem.samples.clone(), has_rotations: true, ambiguous: 0 };
    let fit = (methods.fit)(&set, &settings, None).map_err(|_| "is fitted")?;
    let systems = systems(&set.samples, &settings, fit.model.bounds());
    let per_system = fit.model.coefficients().len() / systems.len();
    let mut rows = Vec::new();
    let mut is_rank_right = systems.len() == fit.systems.len();
    for ((k, (a, b)), report) in systems.iter().enumerate().zip(&fit.systems) {
        let found = &fit.model.coefficients()[k * per_system..][..per_system];
        let reference = Reference::of(a.clone(), b.clone(), settings.rcond, 0.0);
        is_rank_right &= report.rank == reference.rank;
        let solution = SOLUTION.worst(reference.condition, &reference.off_by(found));
        rows.push(reference.noted(solution));
        if problem.directions == DirectionSet::One {
            rows.push(reference.noted(residual(&fit, &reference, a, b)));
        }
    }
    rows.push(must("ranks as exact", is_rank_right));
    Ok(rows)
}

fn residual(fit: &Fit, reference: &Reference, a: &HighMatrix, b: &HighMatrix) -> Row {
    let left = a * &reference.x - b;
    let exact = norm(left.columns(0, 3)) / High::from(a.nrows() as f64).sqrt();
    let coefficients = fit.model.coefficients().iter();
    let largest = coefficients.flat_map(|c| &c[..3]).fold(0.0, |m: f64, v| m.max(v.abs()));
    let error = (High::from(fit.after.position_rms_mm) - exact).abs().to_f64();
    RESIDUAL.row(1.0, error, fit.before.position_rms_mm + largest)
}

/// Design matrix and values of each orientation, or of all of them.
fn systems(
    samples: &[Sample],
    settings: &FitSettings,
    bounds: &Bounds,
) -> Vec<(HighMatrix, HighMatrix)> {
    let count = coefficient_count(settings.order);
    let rows: Vec<Exact> = samples.iter().map(|s| Exact::of(s, settings, bounds)).collect();
    let sets = settings.directions.len();
    if settings.method == FitMethod::Joint {
        let a = HighMatrix::from_fn(rows.len(), sets * count, |i, j| {
            &rows[i].products[j % count] * rows[i].weights.of(j / count)
        });
        return vec![(a, HighMatrix::from_fn(rows.len(), 6, |i, k| rows[i].values[k].into()))];
    }
    let of_direction = |direction| {
        let own = rows.iter().map(|r| (r.weights.of(direction), r)).filter(|(w, _)| *w > 0.0);
        let own: Vec<_> = own.collect();
        let value = |i: usize, k: usize| High::from(own[i].1.values[k]) * own[i].0;
        (
            HighMatrix::from_fn(own.len(), count, |i, j| &own[i].1.products[j] * own[i].0),
            HighMatrix::from_fn(own.len(), 6, value),
        )
    };
    (0..sets).map(of_direction).collect()
}

/// A sample as an exact row.
struct Exact {
    products: Vec<High>,
    weights: DirectionWeights,
    values: [f64; 6],
}

impl Exact {
    fn of(sample: &Sample, settings: &FitSettings, bounds: &Bounds) -> Self {
        let unit = references::unit_position(bounds, &point3(&sample.position_mm));
        let [x, y, z] = [0, 1, 2].map(|k| references::basis(settings.order, &unit[k]));
        Self {
            products: x
                .iter()
                .flat_map(|x| y.iter().map(move |y| x * y))
                .flat_map(|xy| z.iter().map(move |z| &xy * z))
                .collect(),
            weights: settings.directions.weights(&sample.axis, settings.weighting),
            values: sample.error.values(),
        }
    }
}
