//! The bodies that explain rows best, one more at a time: from starts all around the measurements.

use super::rows::Rows;
use super::solve::{Solution, solve};
use super::sources::{Source, SourceModel, are_possible, of_unit_dipole};
use nalgebra::{DMatrix, DVector, Point3, Vector3};
use rayon::prelude::*;
use trackwright_geometry::bounds::Bounds;
use trackwright_task::{Cancelled, Task};

/// Starts along the longest side of the box that is searched. Their steps of about 70 mm in a volume of
/// 300 mm are within reach of Levenberg–Marquardt.
const STARTS_A_SIDE: f64 = 12.0;

/// Starts that are followed, the most promising ones.
const FOLLOWED: usize = 6;

/// Measurements at which starts are judged, at most.
const JUDGED: usize = 600;

/// How much worse than the best another solution may be, in squares of noise, to be refined as well.
const NEARLY_AS_GOOD: f64 = 50.0;

/// The best solutions of a number of bodies, the best one first.
pub(super) type Solutions = Vec<Solution>;

/// For 0 to `most` bodies the best solutions; fewer numbers where more bodies lead nowhere.
pub(super) fn search(
    task: &Task,
    rows: &Rows,
    most: usize,
) -> Result<Vec<Solutions>, Cancelled> {
    let places = places(rows);
    let none = Solution::none(rows);
    let mut dipoles = vec![none.clone()];
    let mut all = vec![vec![none]];
    for count in 1..=most {
        task.step(count - 1, most)?;
        let mut found = Vec::new();
        // A body more, and each of the others anew beside it.
        for round in 0..count {
            let base: Vec<Source> = match round {
                0 => dipoles[0].sources.clone(),
                _ => {
                    let Some(best) = best(&found) else { break };
                    let mut others = best.sources.clone();
                    others.remove(round - 1);
                    others
                }
            };
            let weights = dipoles[0].weights.clone();
            for start in starts(rows, &places, &base, &weights) {
                let mut sources = base.clone();
                sources.push(start);
                let solution = solve(task, rows, SourceModel::Dipoles, &sources, &weights)?;
                found.extend(solution.filter(|new| is_new(&found, new)));
            }
        }
        found.sort_by(|a: &Solution, b: &Solution| a.loss.total_cmp(&b.loss));
        let Some(least) = found.first().map(|best| best.loss) else { break };
        found.retain(|solution| solution.loss <= least + NEARLY_AS_GOOD);
        found.truncate(2);
        let mut refined = Vec::new();
        for solution in &found {
            let (sources, weights) = (&solution.sources, &solution.weights);
            let spheres = solve(task, rows, SourceModel::Spheres, sources, weights)?;
            refined.push(spheres.filter(|s| s.loss < solution.loss).unwrap_or(solution.clone()));
        }
        refined.sort_by(|a, b| a.loss.total_cmp(&b.loss));
        dipoles = found;
        all.push(refined);
    }
    Ok(all)
}

fn best(found: &[Solution]) -> Option<&Solution> {
    found.iter().min_by(|a, b| a.loss.total_cmp(&b.loss))
}

/// Whether no solution found has the same bodies, in any order.
fn is_new(found: &[Solution], new: &Solution) -> bool {
    let has = |old: &Solution, source: &Source| {
        old.sources.iter().any(|other| (other.center_mm - source.center_mm).norm() < 1.0)
    };
    !found.iter().any(|old| new.sources.iter().all(|source| has(old, source)))
}

/// A lattice in the box of the measurements and the generator, grown by half its diagonal to each side.
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

/// Where one more dipole gains most beside others, with all their unknowns free to follow.
fn starts(
    rows: &Rows,
    places: &[Point3<f64>],
    base: &[Source],
    weights: &[f64],
) -> Vec<Source> {
    let step = rows.len().div_ceil(JUDGED).max(1);
    let picked: Vec<usize> = (0..rows.len()).step_by(step).collect();
    let rows = rows.some(&picked);
    let root = |row: usize| weights[picked[row / rows.dof]].sqrt();
    let Some(explained) = SourceModel::Dipoles.explained(&rows, base) else {
        return Vec::new();
    };
    let left = rows.left(&explained);
    let left = DVector::from_fn(left.len(), |i, _| left[i] * root(i));
    let slopes = match base.is_empty() {
        true => None,
        false => SourceModel::Dipoles.slopes(&rows, base, &explained),
    };
    let known = slopes.map(|slopes| {
        let (count, columns) = slopes.shape();
        DMatrix::from_fn(count, columns, |i, j| slopes[(i, j)] * root(i)).qr().q()
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
        let is_apart =
            |other: &Source| (other.center_mm - source.center_mm).norm() > 1.8 * spacing;
        if starts.iter().all(is_apart) && is_possible_beside(&rows, base, &source) {
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
