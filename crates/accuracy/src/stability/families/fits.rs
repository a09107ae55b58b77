//! Fits of distortion models to samples of fields that measurements can have.

use super::prelude::*;
use crate::stability::systems::{Reference, SOLUTION, off_by};
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
    let mut cases = Vec::new();
    let room = Bounds::from(([-250.0, -250.0, -600.0], [250.0, 250.0, -100.0]));
    for order in extent.of(&[1, 2, 3, 4, 5], &[1, 2]) {
        cases.push(case(format!("order {order}, a smooth field"), move || {
            one(order, scattered(room, order, 1.4, SMOOTH))
        }));
    }
    for (name, bounds) in [
        ("a box of 1e-6 mm", cube([-3e-7; 3], 1e-6)),
        ("a box of 1e6 mm", cube([-5e5; 3], 1e6)),
        ("a box of 300 mm, offset by 1e6 mm", cube([1e6, -1e6, 1e6], 300.0)),
        ("a box of 1e-6 mm, offset by 1 mm", cube([1.0; 3], 1e-6)),
        ("a box of 1e-9 mm height", Bounds::from(([-100.0, -100.0, 0.0], [100.0, 100.0, 1e-9]))),
    ] {
        cases.push(case(format!("order 2, {name}"), move || {
            one(2, scattered(bounds, 2, 2.0, SMOOTH))
        }));
    }
    let sharp = if extent.is_full() { 4 } else { 2 };
    cases.push(case(format!("order {sharp}, a metal edge: doubles within 5 mm"), move || {
        // 60 mm wide: twelve doublings.
        let edge: Field = |u| Vector3::new((u.x * 6.0).exp2(), 0.3 * (u.y * 6.0).exp2(), 0.1 * u.z);
        one(sharp, scattered(cube([0.0; 3], 60.0), sharp, 1.6, edge))
    }));
    cases.push(case(format!("order {sharp}, a 1/r³ source 5 mm beside the volume"), move || {
        let source: Field = |u| {
            let r = u - Vector3::new(1.1, 0.2, -0.1);
            r / r.norm().powi(4)
        };
        one(sharp, scattered(cube([-50.0; 3], 100.0), sharp, 1.6, source))
    }));
    cases.push(case("order 2, five clusters of 5 mm in 500 mm", move || {
        one(
            2,
            moved(scattered(room, 2, 3.0, SMOOTH), |i, p| {
                let center = Sequence::new(300 + (i % 5) as u64).point_in(&room);
                center + (p - room.center_mm()) * 0.01
            }),
        )
    }));
    type Move = fn(Point3<f64>) -> Point3<f64>;
    let placed: [(&str, Move); 4] = [
        ("positions in one plane", |p| Point3::new(p.x, p.y, -350.0)),
        ("positions in a tilted plane", |p| Point3::new(p.x, p.y, -350.0 + 0.3 * p.x - 0.1 * p.y)),
        ("positions on one line", |p| Point3::new(p.x, 0.5 * p.x, p.x - 350.0)),
        ("all samples at one place", |_| Point3::new(10.0, 20.0, -300.0)),
    ];
    for (name, place) in placed {
        cases.push(case(format!("order 2, {name}"), move || {
            one(2, moved(scattered(room, 2, 2.0, SMOOTH), |_, p| place(p)))
        }));
    }
    cases.push(case("order 2, 14 orientations", move || {
        each(2, DirectionSet::Fourteen, scattered(room, 2, 20.0, SMOOTH))
    }));
    cases.push(case("order 1, 42 orientations, gnomonic weights", move || Problem {
        weighting: Weighting::Gnomonic,
        ..each(1, DirectionSet::FortyTwo, scattered(room, 1, 30.0, SMOOTH))
    }));
    cases.push(case("order 1, 6 orientations, none sampled near +x", move || {
        let mut samples = scattered(room, 1, 20.0, SMOOTH);
        samples.iter_mut().for_each(turn_from_x);
        each(1, DirectionSet::Six, samples)
    }));
    cases.push(case("order 1, 6 orientations, +x known by weights of 1e-12 alone", move || {
        let mut samples = scattered(room, 1, 20.0, SMOOTH);
        for s in &mut samples {
            let v = s.axis.into_inner();
            s.axis = Unit::new_normalize(Vector3::new(1e-12 * (1.0 + v.x.abs()), v.y, v.z));
        }
        each(1, DirectionSet::Six, samples)
    }));
    for (order, set) in extent.of(
        &[(1, DirectionSet::Six), (1, DirectionSet::Fourteen), (2, DirectionSet::Six)],
        &[(1, DirectionSet::Six)],
    ) {
        cases.push(case(format!("order {order}, {} orientations, joint", set.len()), move || {
            Problem {
                is_joint: true,
                ..each(order, set, scattered(room, order, 1.5 * set.len() as f64, SMOOTH))
            }
        }));
    }
    cases.push(case("order 1, 6 orientations, joint, none sampled near +x", move || {
        let mut samples = scattered(room, 1, 9.0, SMOOTH);
        samples.iter_mut().for_each(turn_from_x);
        Problem { is_joint: true, ..each(1, DirectionSet::Six, samples) }
    }));
    Family {
        name: "fits",
        about: "Coefficients of fitted models, against each system built and solved in 192 bits \
            from the samples' own numbers. The samples' weights are the program's; they have rows \
            of their own.",
        quantities: vec![SOLUTION, RESIDUAL],
        cases,
    }
}

/// Mirrors an axis that has a part along +x.
fn turn_from_x(sample: &mut Sample) {
    let mirror = Vector3::new(-sample.axis.x.signum(), 1.0, 1.0);
    sample.axis = Unit::new_normalize(sample.axis.component_mul(&mirror));
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

fn case(name: impl Into<String>, make: impl Fn() -> Problem + Send + Sync + 'static) -> Case {
    Case::new(name, move |m, case| rows(m, case, make()))
}

fn rows(methods: &Methods, case: &str, problem: Problem) -> Vec<Row> {
    let settings = FitSettings {
        method: if problem.is_joint { FitMethod::Joint } else { FitMethod::PerDirection },
        weighting: problem.weighting,
        ..FitSettings::new(problem.order, problem.directions)
    };
    let set = SampleSet { samples: problem.samples, has_rotations: true, ambiguous: 0 };
    let Ok(fit) = (methods.fit)(&set, &settings, None) else {
        return vec![Row::behaviour(case, "is fitted", false)];
    };
    let systems = systems(&set.samples, &settings, fit.model.bounds());
    let per_system = fit.model.coefficients().len() / systems.len();
    let mut solutions = Vec::new();
    let mut is_rank_right = systems.len() == fit.systems.len();
    for ((k, (a, b)), report) in systems.iter().enumerate().zip(&fit.systems) {
        let found = &fit.model.coefficients()[k * per_system..][..per_system];
        let reference = Reference::of(a.clone(), b.clone(), settings.rcond, 0.0);
        let case = reference.named(case);
        is_rank_right &= report.rank == reference.rank;
        solutions.push(SOLUTION.worst(&case, reference.condition, &off_by(&reference, found)));
        if problem.directions == DirectionSet::One {
            solutions.push(residual(&case, &fit, &reference, a, b));
        }
    }
    let mut rows: Vec<Row> = [SOLUTION.name, RESIDUAL.name]
        .iter()
        .filter_map(|name| {
            let own = solutions.iter().filter(|r| r.quantity == *name).cloned();
            Row::worst_of(own.collect())
        })
        .collect();
    rows.push(Row::behaviour(case, "ranks as exact", is_rank_right));
    rows
}

fn residual(case: &str, fit: &Fit, reference: &Reference, a: &HighMatrix, b: &HighMatrix) -> Row {
    let left = a.times(&reference.x).minus(b);
    let squares: High = left.columns[..3]
        .iter()
        .map(|c| {
            let length = norm(c);
            &length * &length
        })
        .sum();
    let exact = (squares / a.rows() as f64).sqrt();
    let coefficients = fit.model.coefficients().iter();
    let largest = coefficients.flat_map(|c| &c[..3]).fold(0.0, |m: f64, v| m.max(v.abs()));
    let error = (High::from(fit.after.position_rms_mm) - exact).abs().to_f64();
    RESIDUAL.row(case, 1.0, error, fit.before.position_rms_mm + largest)
}

/// Design matrix and values of each orientation, or of all of them.
fn systems(
    samples: &[Sample],
    settings: &FitSettings,
    bounds: &Bounds,
) -> Vec<(HighMatrix, HighMatrix)> {
    let order = settings.order;
    let count = coefficient_count(order);
    let rows: Vec<Exact> = samples.iter().map(|s| Exact::of(s, settings, bounds)).collect();
    let sets = settings.directions.len();
    if settings.method == FitMethod::Joint {
        let a = HighMatrix::from_fn(rows.len(), sets * count, |i, j| {
            let weight = rows[i].weights.of(j / count);
            if weight > 0.0 { &rows[i].products[j % count] * weight } else { High::zero() }
        });
        let b = HighMatrix::from_fn(rows.len(), 6, |i, k| High::from(rows[i].values[k]));
        return vec![(a, b)];
    }
    (0..sets)
        .map(|direction| {
            let own: Vec<_> = rows
                .iter()
                .map(|r| (r.weights.of(direction), r))
                .filter(|(w, _)| *w > 0.0)
                .collect();
            let a = HighMatrix::from_fn(own.len(), count, |i, j| &own[i].1.products[j] * own[i].0);
            let b =
                HighMatrix::from_fn(own.len(), 6, |i, k| High::from(own[i].1.values[k]) * own[i].0);
            (a, b)
        })
        .collect()
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
        let [x, y, z] = unit.map(|u| references::basis(settings.order, &u));
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
