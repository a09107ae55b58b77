//! The least-squares solver on design matrices that are given exactly.

use super::prelude::*;
use crate::stability::systems::{Reference, SOLUTION};

const CONDITION: Quantity = Quantity::new("condition number, relative", 10.0, "itself", "1");

/// Unknowns up to which the singular values themselves are found in high precision.
const EXACT_CONDITION_UNKNOWNS: usize = 27;

const RCOND: f64 = 1e-10;

/// A system as the solver gets it.
struct System {
    rows: Vec<Vec<f64>>,
    values: Vec<[f64; 6]>,
    ridge: f64,
}

pub(super) fn family(extent: Extent) -> Family {
    let orders = extent.of(vec![1, 2, 3, 4, 5], vec![1, 2]).into_iter().map(|order| {
        (format!("order {order}, scattered positions"), scattered(order, 1.4, |_, u| u))
    });
    // Height squeezed until the columns with a power of it are nearly the same.
    let slab =
        |squeeze: f64| scattered(2, 2.0, move |_, u| Vector3::new(u.x, u.y, 0.4 + squeeze * u.z));
    let clusters = |i: usize, u: Vector3<f64>| cluster_center(i) + u * 0.02;
    let repeated = |count: usize, rows_per_unknown: f64| {
        scattered(2, rows_per_unknown, |i, _| cluster_center(1000 + i % count))
    };
    let plane = || scattered(2, 3.0, |_, u| Vector3::new(u.x, u.y, 0.0));
    let whole = |order: usize, rows_per_unknown: f64| scattered(order, rows_per_unknown, |_, u| u);
    let systems = [
        ("order 2, positions in a slab of 1e-2", slab(1e-2)),
        ("order 2, positions in a slab of 1e-4", slab(1e-4)),
        // What the polynomials reach leaves no residual, and so no room for the condition's square.
        ("order 2, slab of 1e-2, a field of order 2", reached(slab(1e-2))),
        ("order 2, slab of 1e-3, a field of order 2", reached(slab(1e-3))),
        (
            "order 2, seven clusters of 0.02, a field of order 2",
            reached(scattered(2, 3.0, clusters)),
        ),
        (
            "order 1, positions in a slab of 1e-9",
            scattered(1, 3.0, |_, u| Vector3::new(u.x, u.y, 0.4 + 1e-9 * u.z)),
        ),
        ("order 2, seven clusters of 0.02", scattered(2, 3.0, clusters)),
        ("order 2, 40 positions, each repeated 5 times", repeated(40, 200.0 / 27.0)),
        ("order 2, 10 positions, each repeated 5 times", repeated(10, 50.0 / 27.0)),
        ("order 2, all positions in one plane", plane()),
        (
            "order 2, all positions on one line",
            scattered(2, 3.0, |_, u| Vector3::new(u.x, 0.25 + 0.5 * u.x, 1.0 - u.x)),
        ),
        ("order 3, fewer samples than unknowns", whole(3, 0.5)),
        ("order 2, one sample", whole(2, 1.0 / 27.0)),
        (
            "order 1, row weights from 1e-12 to 1e12",
            weighted(whole(1, 10.0), |i| 10.0_f64.powi(4 * (i % 7) - 12)),
        ),
        (
            "order 1, heavy rows last",
            weighted(whole(1, 10.0), |i| 10.0_f64.powi(i.min(72) / 3 - 12)),
        ),
        ("order 2, all rows weighted by 1e-12", weighted(whole(2, 2.0), |_| 1e-12)),
        ("order 2, all rows weighted by 1e12", weighted(whole(2, 2.0), |_| 1e12)),
        ("order 2, slab of 1e-3, ridge 1e-8", System { ridge: 1e-8, ..slab(1e-3) }),
        ("order 2, one plane, ridge 1e-8", System { ridge: 1e-8, ..plane() }),
        ("order 2, slab of 1e-3, ridge 1e-3", System { ridge: 1e-3, ..slab(1e-3) }),
        ("order 2, one plane, ridge 1e-3", System { ridge: 1e-3, ..plane() }),
        ("columns from 1 to 1e-9", graded_columns()),
    ];
    Family::new(
        "least squares",
        "Solutions of least norm for design matrices that are given to the last bit, \
            against Householder QR or, where rank is missing, one-sided Jacobi.",
        &[SOLUTION, CONDITION],
    )
    .with(orders, rows)
    .with(systems, rows)
}

/// Centres of clusters by their number.
fn cluster_center(i: usize) -> Vector3<f64> {
    let mut sequence = Sequence::new(100 + (if i < 1000 { i % 7 } else { i }) as u64);
    Vector3::from_fn(|_, _| 0.05 + 0.85 * sequence.unit())
}

/// Products of Bernstein polynomials at positions in the unit cube; `place` moves them by number.
fn scattered(
    order: usize,
    rows_per_unknown: f64,
    place: impl Fn(usize, Vector3<f64>) -> Vector3<f64>,
) -> System {
    let mut sequence = Sequence::new(order as u64 + 40);
    let count = (coefficient_count(order) as f64 * rows_per_unknown).round() as usize;
    let (mut rows, mut values) = (Vec::new(), Vec::new());
    for i in 0..count {
        let u = place(i, Vector3::from_fn(|_, _| sequence.unit()));
        rows.push(products(order, &u));
        // A field that no polynomial reaches, and noise.
        values.push(std::array::from_fn(|k| {
            (1.0 + u.x + 0.3 * (k as f64) * u.y).powi(-3) * u.z.cos() + 0.01 * sequence.signed()
        }));
    }
    System { rows, values, ridge: 0.0 }
}

/// The same with values that a solution without residual has, up to their own rounding.
fn reached(mut system: System) -> System {
    let mut sequence = Sequence::new(21);
    let x: Vec<[f64; 6]> =
        (0..system.rows[0].len()).map(|_| std::array::from_fn(|_| sequence.signed())).collect();
    for (row, values) in system.rows.iter().zip(&mut system.values) {
        let sum = |k: usize| row.iter().zip(&x).map(|(a, x)| High::from(*a) * x[k]).sum::<High>();
        *values = std::array::from_fn(|k| sum(k).to_f64());
    }
    system
}

fn weighted(mut system: System, weight: impl Fn(i32) -> f64) -> System {
    for (i, (row, values)) in system.rows.iter_mut().zip(&mut system.values).enumerate() {
        let w = weight(i as i32);
        row.iter_mut().chain(values.iter_mut()).for_each(|x| *x *= w);
    }
    system
}

fn graded_columns() -> System {
    let mut system = scattered(2, 2.0, |_, u| u);
    for row in &mut system.rows {
        for (j, x) in row.iter_mut().enumerate() {
            *x *= 10.0_f64.powf(-(j as f64) / 4.0);
        }
    }
    system
}

fn rows(methods: &Methods, system: &System) -> Found {
    let unknowns = system.rows[0].len();
    let a = HighMatrix::from_fn(system.rows.len(), unknowns, |i, j| system.rows[i][j].into());
    let b = HighMatrix::from_fn(system.rows.len(), 6, |i, k| system.values[i][k].into());
    let reference = Reference::of(a, b, RCOND, system.ridge);
    let Ok(found) = (methods.solve)(&system.rows, &system.values, RCOND, system.ridge) else {
        return Ok(vec![reference.noted(must("is solved", false))]);
    };
    let mut rows = vec![
        SOLUTION.worst(reference.condition, &reference.off_by(&found.unknowns)),
        must("rank as exact", found.rank == reference.rank),
    ];
    if let Some(exact) = reference.exact_condition(EXACT_CONDITION_UNKNOWNS) {
        let error = (High::from(found.condition) - &exact).abs() / &exact;
        rows.push(CONDITION.row(exact.to_f64(), error.to_f64(), 1.0));
    }
    Ok(rows.into_iter().map(|row| reference.noted(row)).collect())
}
