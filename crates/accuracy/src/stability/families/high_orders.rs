//! Least squares beyond what can be solved in high precision directly.

use super::prelude::*;
use crate::high_linear::gradient;
use crate::stability::systems::{SOLUTION, singular_values};
use nalgebra::DVector;
use trackwright_field::least_squares::LeastSquares;

/// Twelve Bernstein polynomials an axis come to a condition of 1e10; none of them is cut off.
const RCOND: f64 = 1e-14;

/// How much one refinement step has to shrink the gradient for its length to be the error.
const SHRINKS: f64 = 0.1;

const REFINED: Quantity =
    Quantity { name: "solution against its refinement, mm or rad", ..SOLUTION };

pub(super) fn family(extent: Extent) -> Family {
    let named = |what: &'static str| move |order| (format!("order {order}{what}"), order);
    let grids = extent.of(vec![6, 7, 8, 9, 10, 11, 12], vec![4]);
    let scattered = extent.of(vec![6, 7], vec![3]);
    Family::new(
        "high orders",
        "Fits of more than 216 unknowns. On a grid the design matrix is a product of three \
            small ones, so the exact solution is found axis by axis. For scattered positions the \
            gradient of the computed solution is evaluated in 192 bits; one refinement step with \
            it, which has to shrink the gradient tenfold, is the error.",
        &[SOLUTION, REFINED],
    )
    .with(grids.into_iter().map(named(" on a grid")), on_grid)
    .with(scattered.into_iter().map(named(", scattered positions")), refined)
}

/// Points along an axis of a grid, two more than there are polynomials.
fn nodes(order: usize) -> Vec<f64> {
    let n = order + 3;
    (0..n).map(|i| -100.0 * ((i as f64) * std::f64::consts::PI / (n - 1) as f64).cos()).collect()
}

fn on_grid(methods: &Methods, &order: &usize) -> Found {
    let nodes = nodes(order);
    let n = nodes.len();
    let mut sequence = Sequence::new(order as u64);
    let mut samples = Vec::with_capacity(n * n * n);
    for &x in &nodes {
        for &y in &nodes {
            for &z in &nodes {
                let u = Vector3::new(x, y, z) / 100.0;
                // Two fields that leave a residual; the third is a polynomial and leaves none, so
                // that its error has no room for the condition's square.
                let e = Vector3::new(
                    (2.0 * u.x - u.y).sin() + 0.01 * sequence.signed(),
                    1.0 / (1.5 + u.x) + 0.01 * sequence.signed(),
                    1.0 + u.x * u.y - 0.5 * u.z,
                );
                samples.push(Sample::new(
                    Point3::new(x, y, z),
                    Vector3::z_axis(),
                    PoseError { position_mm: e, rotation_rad: e * 0.01 },
                ));
            }
        }
    }
    let bounds = Bounds::around(samples.iter().map(|s| s.position_mm));
    let set = SampleSet { samples, has_rotations: true, ambiguous: 0 };
    let settings = FitSettings { rcond: RCOND, ..FitSettings::new(order, DirectionSet::One) };
    let (Ok(fit), Some(bounds)) = ((methods.fit)(&set, &settings, bounds), bounds) else {
        return Err("is fitted");
    };
    let axis = GridAxis::of(order, &nodes, &bounds);
    let condition = axis.condition.powi(3);
    let errors: Vec<_> = (1..3)
        .map(|value| {
            let b = set.samples.iter().map(|s| High::from(s.error.position_mm[value]));
            let b: Vec<High> = b.collect();
            let x = axis.each(&axis.inverse, &b);
            let back = axis.each(&axis.matrix, &x);
            let left: Vec<High> = back.iter().zip(&b).map(|(a, b)| a - b).collect();
            let scale = norm(&x).to_f64() + condition * norm(&left).to_f64() / axis.largest.powi(3);
            let found: Vec<f64> = fit.model.coefficients().iter().map(|c| c[value]).collect();
            (distance(&found, &x), scale)
        })
        .collect();
    let is_full = fit.systems.iter().all(|s| s.rank == coefficient_count(order));
    Ok(vec![SOLUTION.worst(condition, &errors), must("full rank", is_full)])
}

/// One axis of a grid: its small design matrix and the inverse of that.
struct GridAxis {
    matrix: HighMatrix,
    inverse: HighMatrix,
    condition: f64,
    largest: f64,
}

impl GridAxis {
    fn of(order: usize, nodes: &[f64], bounds: &Bounds) -> Self {
        let rows: Vec<_> = nodes
            .iter()
            .map(|&x| {
                let unit = references::unit_position(bounds, &vector3([x, 0.0, 0.0]));
                references::basis(order, &unit[0])
            })
            .collect();
        let matrix = HighMatrix::from_fn(nodes.len(), order + 1, |i, j| rows[i][j].clone());
        let s = singular_values(&matrix);
        Self {
            inverse: least_squares(&matrix, &HighMatrix::identity(nodes.len(), nodes.len())),
            matrix,
            condition: s[0] / s[s.len() - 1],
            largest: s[0],
        }
    }

    /// A small matrix applied along each axis of a cube of numbers.
    fn each(&self, matrix: &HighMatrix, cube: &[High]) -> Vec<High> {
        let (to, from) = matrix.shape();
        // The last axis is worked on and becomes the first: three times brings all back.
        let mut now = cube.to_vec();
        for _ in 0..3 {
            let others = now.len() / from;
            let lines: Vec<&[High]> = now.chunks_exact(from).collect();
            let entry = |k| dot(matrix.row(k / others), lines[k % others]);
            now = (0..to * others).map(entry).collect();
        }
        now
    }
}

fn refined(methods: &Methods, &order: &usize) -> Found {
    let unknowns = coefficient_count(order);
    let mut sequence = Sequence::new(order as u64 + 900);
    let (mut rows, mut values) = (Vec::new(), Vec::new());
    for _ in 0..unknowns * 3 / 2 {
        let u = Vector3::from_fn(|_, _| sequence.unit());
        rows.push(products(order, &u));
        values.push([(1.0 + u.x + u.y).powi(-3) * u.z.cos() + 0.01 * sequence.signed(); 6]);
    }
    let mut system = LeastSquares::new(unknowns);
    for (row, v) in rows.iter().zip(&values) {
        system.push(|out| out.extend(row), *v);
    }
    let (Ok(found), Ok(svd)) =
        ((methods.solve)(&rows, &values, RCOND, 0.0), system.into_triangle().decompose())
    else {
        return Err("is solved");
    };
    let s = &svd.singular_values;
    let condition = s[0] / s[s.len() - 1];
    let gradient = |x: &[High]| gradient(&rows, |i| values[i][0], x);
    let x: Vec<High> = found.unknowns.iter().map(|x| High::from(x[0])).collect();
    let (first, residual) = gradient(&x);
    // (AᵀA)⁻¹ g by the factors: V Λ⁻² Vᵀ g.
    let along = (0..s.len()).map(|k| {
        let along: f64 = (0..unknowns).map(|i| svd.v[(i, k)] * first[i]).sum();
        along / s[k] / s[k]
    });
    let along: Vec<f64> = along.collect();
    let step = DVector::from_fn(unknowns, |i, _| {
        along.iter().enumerate().map(|(k, along)| svd.v[(i, k)] * along).sum::<f64>()
    });
    let refined: Vec<High> = x.iter().zip(&step).map(|(x, &d)| x + d).collect();
    let (second, _) = gradient(&refined);
    let [first, second] = [first, second].map(|g| DVector::from(g).norm());
    let scale = norm(&refined).to_f64() + condition * residual / s[0];
    Ok(vec![
        REFINED.row(condition, step.norm(), scale),
        must("refinement shrinks the gradient", second <= SHRINKS * first),
    ])
}
