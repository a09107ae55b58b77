//! The bodies that explain rows best, one more at a time: from starts all around the measurements.

use super::extended::{Extended, solve_extended, solve_tensors, widened};
use super::multipoles::{OF_TENSOR, columns};
use super::rows::Rows;
use super::solve::{Solution, solve};
use super::sources::{Source, SourceModel, are_possible, of_unit_dipole};
use nalgebra::{DMatrix, DVector, Point3, Vector3};
use rayon::prelude::*;
use trackwright_geometry::bounds::Bounds;
use trackwright_task::{Cancelled, Task};

/// Starts along the longest side of the box that is searched. Their steps of about 80 mm in a volume of
/// 300 mm are within reach of Levenberg–Marquardt.
const STARTS_A_SIDE: f64 = 10.0;

/// Starts that are followed as a dipole, the most promising ones.
const FOLLOWED: usize = 6;

/// Of those, the ones that are followed together with the other bodies.
const REFINED: usize = 2;

/// Measurements at which starts are judged, at most.
const JUDGED: usize = 400;

/// One more body has to gain so much, in squares of what is left: what the best of all places gains
/// by chance is 10 to 19, and a strength that is clear gains 25.
const LEAST_GAIN: f64 = 20.0;

/// The same of a tensor and its middle: nine numbers where a dipole has four.
const LEAST_TENSOR_GAIN: f64 = 35.0;

/// Measurements at which tensors are judged, at most.
const JUDGED_TENSORS: usize = 150;

/// Bodies nearer than this to each other are the same, found as dipoles and as spheres.
const SAME_MM: f64 = 20.0;

/// A gain that no other place has by chance, in squares of what is left.
const CLEAR_GAIN: f64 = 200.0;

/// Part of the best dipole's gain that another one has to have to be followed as well.
const GAIN_OF_ANOTHER: f64 = 0.6;

/// The best solutions of a number of bodies, the best one first.
pub(super) type Solutions = Vec<Solution>;

/// As many compact bodies, one more than the base has; none where that gains nothing.
///
/// `known` are those of rows that are nearly the same: where they gain much, the search starts there, as no search would
/// find others.
pub(super) fn compact(
    task: &Task,
    rows: &Rows,
    base: &Solution,
    known: &[Solution],
    known_base: Option<&Solution>,
) -> Result<Solutions, Cancelled> {
    let mut found = Vec::new();
    if let (Some(after), Some(before)) = (known.first(), known_base)
        && after.loss < before.loss - CLEAR_GAIN * after.variance(rows.dof)
    {
        for Solution { model, sources, weights, .. } in known {
            let picked = if weights.len() == rows.len() { weights } else { &base.weights };
            found.extend(solve(task, rows, *model, sources, picked)?);
        }
        found.sort_by(|a, b| a.loss.total_cmp(&b.loss));
    }
    if found.is_empty() {
        found = one_more(task, rows, &places(rows), base)?;
    }
    let is_better = |new: &Solution| new.loss < base.loss;
    match found.first().is_some_and(is_better) {
        true => Ok(found),
        false => Ok(Vec::new()),
    }
}

/// So many bodies of any form, one more than the base has; none where that gains nothing.
///
/// `compact` are as many spheres or dipoles; `known` as in [`compact()`].
pub(super) fn extended(
    task: &Task,
    rows: &Rows,
    base: &Solution,
    compact: Option<&Solution>,
    known: &[Solution],
) -> Result<Solutions, Cancelled> {
    let mut found: Vec<Solution> = Vec::new();
    for Solution { extended, weights, .. } in known {
        let picked = if weights.len() == rows.len() { weights } else { &base.weights };
        found.extend(solve_extended(task, rows, extended, picked, true)?);
    }
    if known.is_empty() {
        let mut starts = Vec::new();
        if let Some(compact) = compact {
            let centers: Vec<_> = compact.sources.iter().map(|s| s.center_mm).collect();
            let tensors = solve_tensors(task, rows, &centers, &compact.weights)?;
            starts.extend(tensors.map(|tensors| tensors.extended));
        }
        // Where compact bodies leave noise alone, others are near them.
        if starts.is_empty() || !compact.is_some_and(|compact| compact.is_noise(rows.dof)) {
            starts.extend(extended_starts(task, rows, &places(rows), base)?);
        }
        for start in starts {
            found.extend(solve_extended(task, rows, &start, &base.weights, true)?);
        }
    }
    found.sort_by(|a, b| a.loss.total_cmp(&b.loss));
    let mut distinct: Vec<Solution> = Vec::new();
    for solution in found {
        if is_new(&distinct, &solution) {
            distinct.push(solution);
        }
    }
    let least = base.loss - LEAST_TENSOR_GAIN * base.variance(rows.dof);
    if distinct.first().is_none_or(|new| new.loss >= least) {
        return Ok(Vec::new());
    }
    if known.iter().all(|solution| solution.weights.len() == rows.len()) {
        let best = distinct.remove(0);
        let again = solve_extended(task, rows, &best.extended, &best.weights, false)?;
        distinct.insert(0, widened(task, rows, again.unwrap_or(best))?);
    }
    Ok(distinct)
}

/// The base's bodies with one more, a tensor that explains much of what they leave.
fn extended_starts(
    task: &Task,
    rows: &Rows,
    places: &[Point3<f64>],
    base: &Solution,
) -> Result<Vec<Vec<Extended>>, Cancelled> {
    let left = rows.with_right(base.left.clone());
    let mut single: Vec<Solution> = Vec::new();
    for start in tensor_starts(&left, places, base) {
        let found = solve_tensors(task, &left, &[start], &base.weights)?;
        single.extend(found.filter(|new| is_new(&single, new)));
    }
    let least = base.loss - LEAST_TENSOR_GAIN * base.variance(rows.dof);
    single.retain(|solution| solution.loss < least);
    single.sort_by(|a, b| a.loss.total_cmp(&b.loss));
    let with_base = |solution: Solution| [&base.extended[..], &solution.extended].concat();
    Ok(single.into_iter().take(REFINED).map(with_base).collect())
}

/// Where one more tensor gains most in what a base leaves.
fn tensor_starts(left: &Rows, places: &[Point3<f64>], base: &Solution) -> Vec<Point3<f64>> {
    let step = left.len().div_ceil(JUDGED_TENSORS).max(1);
    let picked: Vec<usize> = (0..left.len()).step_by(step).collect();
    let rows = left.some(&picked);
    let root = |row: usize| base.weights[picked[row / rows.dof]].sqrt();
    let right = DVector::from_fn(rows.right.len(), |i, _| rows.right[i] * root(i));
    let gain = |place: &Point3<f64>| {
        let mut columns = columns(&rows, place, OF_TENSOR);
        for (i, mut row) in columns.row_iter_mut().enumerate() {
            row *= root(i);
        }
        let gain = (columns.qr().q().tr_mul(&right)).norm_squared();
        if gain.is_finite() { gain } else { 0.0 }
    };
    let gains: Vec<f64> = places.par_iter().map(gain).collect();
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| gains[b].total_cmp(&gains[a]));
    let mut starts: Vec<Point3<f64>> = Vec::new();
    let spacing = spacing_mm(places);
    for k in order {
        let is_apart = |other: &Point3<f64>| (other - places[k]).norm() > 1.8 * spacing;
        let source = Source { center_mm: places[k], strength_mm3: 1.0 };
        if starts.iter().all(is_apart) && is_possible_beside(&rows, &base.sources, &source) {
            starts.push(places[k]);
        }
        if starts.len() == FOLLOWED {
            break;
        }
    }
    starts
}

/// The best solutions with one body more than a base has.
fn one_more(
    task: &Task,
    rows: &Rows,
    places: &[Point3<f64>],
    base: &Solution,
) -> Result<Solutions, Cancelled> {
    // A dipole in what the base leaves.
    let left = rows.with_right(base.left.clone());
    let mut single: Vec<Solution> = Vec::new();
    for start in starts(&left, places, base) {
        let found = solve(task, &left, SourceModel::Dipoles, &[start], &base.weights)?;
        single.extend(found.filter(|new| is_new(&single, new)));
    }
    let least = LEAST_GAIN * base.variance(rows.dof);
    single.retain(|solution| solution.loss < base.loss - least);
    single.sort_by(|a, b| a.loss.total_cmp(&b.loss));
    let gain = |solution: &Solution| base.loss - solution.loss;
    let enough = single.first().map_or(0.0, |best| GAIN_OF_ANOTHER * gain(best));
    single.retain(|solution| gain(solution) >= enough);
    let mut found: Vec<Solution> = Vec::new();
    for solution in single.iter().take(REFINED) {
        let mut sources = base.sources.clone();
        sources.extend(&solution.sources);
        let dipoles = solve(task, rows, SourceModel::Dipoles, &sources, &base.weights)?;
        // Beside other bodies dipoles are pulled to what those lack as dipoles.
        if let (Some(dipoles), true) = (&dipoles, base.sources.is_empty()) {
            sources.clone_from(&dipoles.sources);
        }
        let spheres = solve(task, rows, SourceModel::Spheres, &sources, &base.weights)?;
        found.extend(dipoles.into_iter().chain(spheres));
    }
    found.sort_by(|a, b| a.loss.total_cmp(&b.loss));
    let mut distinct: Vec<Solution> = Vec::new();
    for solution in found {
        if is_new(&distinct, &solution) {
            distinct.push(solution);
        }
    }
    Ok(distinct)
}

/// Whether no solution found has the same bodies, in any order.
fn is_new(found: &[Solution], new: &Solution) -> bool {
    let has = |old: &Solution, source: &Source| {
        old.sources.iter().any(|other| (other.center_mm - source.center_mm).norm() < SAME_MM)
    };
    !found.iter().any(|old| new.sources.iter().all(|source| has(old, source)))
}

/// A lattice in the box of the measurements, grown by half its diagonal to each side.
fn places(rows: &Rows) -> Vec<Point3<f64>> {
    let Some(bounds) = Bounds::around(rows.positions_mm.iter().copied()) else {
        return Vec::new();
    };
    let margin = Vector3::repeat(0.5 * bounds.diagonal_mm().max(200.0));
    let (low, high) = (bounds.min_mm - margin, bounds.max_mm + margin);
    let size = high - low;
    let step = size.max() / STARTS_A_SIDE;
    let count = size.map(|side| (side / step).ceil().max(1.0));
    let mut places = Vec::new();
    for i in 0..count.x as usize {
        for j in 0..count.y as usize {
            for k in 0..count.z as usize {
                let part = Vector3::new(i as f64, j as f64, k as f64).add_scalar(0.5);
                places.push(low + size.component_mul(&part.component_div(&count)));
            }
        }
    }
    places
}

/// Where one more dipole gains most in what a base leaves, with the base's unknowns free to follow.
fn starts(left: &Rows, places: &[Point3<f64>], base: &Solution) -> Vec<Source> {
    let step = left.len().div_ceil(JUDGED).max(1);
    let picked: Vec<usize> = (0..left.len()).step_by(step).collect();
    let rows = left.some(&picked);
    let dof = rows.dof;
    let root = |row: usize| base.weights[picked[row / dof]].sqrt();
    let left = DVector::from_fn(rows.right.len(), |i, _| rows.right[i] * root(i));
    let known = (base.slopes.ncols() > 0).then(|| {
        let slope = |i: usize, j: usize| base.slopes[(picked[i / dof] * dof + i % dof, j)];
        let (count, columns) = (rows.right.len(), base.slopes.ncols());
        DMatrix::from_fn(count, columns, |i, j| slope(i, j) * root(i)).qr().q()
    });
    let free = |v: &DVector<f64>| match &known {
        Some(known) => v - known * known.tr_mul(v),
        None => v.clone(),
    };
    let left = free(&left);
    let gain = |place: &Point3<f64>| {
        let column = of_unit_dipole(&rows, place);
        let column = free(&DVector::from_fn(column.len(), |i, _| column[i] * root(i)));
        let square = column.norm_squared();
        let along = column.dot(&left);
        let gain = along * along / square;
        (if gain.is_finite() { gain } else { 0.0 }, along / square)
    };
    let gains: Vec<(f64, f64)> = places.par_iter().map(gain).collect();
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| gains[b].0.total_cmp(&gains[a].0));
    let mut starts: Vec<Source> = Vec::new();
    let spacing = spacing_mm(places);
    for k in order {
        let source = Source { center_mm: places[k], strength_mm3: gains[k].1 };
        // Of neighbours the best.
        let is_apart = |other: &Source| (other.center_mm - source.center_mm).norm() > 1.8 * spacing;
        if starts.iter().all(is_apart) && is_possible_beside(&rows, &base.sources, &source) {
            starts.push(source);
        }
        if starts.len() == FOLLOWED {
            break;
        }
    }
    starts
}

fn is_possible_beside(rows: &Rows, base: &[Source], source: &Source) -> bool {
    // Strengths follow; only the place has to be free.
    let mut all = base.to_vec();
    all.push(Source { strength_mm3: 1.0, ..*source });
    are_possible(rows, &all)
}

fn spacing_mm(places: &[Point3<f64>]) -> f64 {
    match places {
        [first, second, ..] => (second - first).norm(),
        _ => 0.0,
    }
}
