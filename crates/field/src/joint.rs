//! Joint fits by their sparsity: a row touches the three orientations around its axis and no other.
//!
//! Each face of the sphere is reduced to a triangle of its own. Then orientations are eliminated
//! one front after the other (multifrontal QR: Davis, ACM TOMS 38(1), 2011), those with the fewest
//! neighbours first: of the set of 14 first the axes, each by itself, then two opposite corners of
//! the cube, then the six left. What comes out is the triangle of the whole design matrix, with
//! most of its blocks left out.

use super::least_squares::{NoConvergence, Solution, Triangle, VALUES, determined};
use super::qr_update::{Block, ROW_UNIT, Scratch, qr_update};
use super::singular::{Dense, UpperTriangle, add_scaled, dot};
use faer::Mat;
use rayon::prelude::*;
use std::borrow::Cow;
use trackwright_geometry::directions::DirectionSet;
use trackwright_task::{Cancelled, Task};

/// The faces of a set with the orientations that each touches, first those that are eliminated
/// first: so ordered, rows come to their turn late and cost little before.
pub fn face_blocks(set: DirectionSet) -> Vec<Vec<usize>> {
    if set == DirectionSet::One {
        return vec![vec![0]];
    }
    let faces: Vec<Vec<usize>> = set.triangles().iter().map(|face| face.to_vec()).collect();
    let mut rank = vec![0; set.len()];
    let mut eliminated = 0;
    let mut parts = faces.clone();
    while let Some(round) = next_round(&parts) {
        for front in round {
            for pivot in &front.pivots {
                rank[*pivot] = eliminated;
                eliminated += 1;
            }
            parts.retain(|part| !part.contains(&front.pivots[0]));
            parts.push(front.others);
        }
    }
    let ranked = |mut face: Vec<usize>| {
        face.sort_by_key(|&direction| rank[direction]);
        face
    };
    faces.into_iter().map(ranked).collect()
}

/// Orientations that are eliminated together, and the others that their rows touch.
#[derive(Clone, Debug, PartialEq)]
struct FrontPlan {
    pivots: Vec<usize>,
    others: Vec<usize>,
}

/// Fronts that have no part in common, those of the fewest neighbours; `None` when nothing is
/// left. A front that touches all that is left eliminates all of it.
fn next_round(parts: &[Vec<usize>]) -> Option<Vec<FrontPlan>> {
    let mut left: Vec<usize> = parts.iter().flatten().copied().collect();
    left.sort_unstable();
    left.dedup();
    let others_of = |pivot: usize| -> Vec<usize> {
        let is_neighbour = |&other: &usize| {
            other != pivot
                && parts.iter().any(|part| part.contains(&pivot) && part.contains(&other))
        };
        left.iter().copied().filter(is_neighbour).collect()
    };
    let plans: Vec<_> = left
        .iter()
        .map(|&pivot| FrontPlan { pivots: vec![pivot], others: others_of(pivot) })
        .collect();
    let fewest = plans.iter().map(|plan| plan.others.len()).min()?;
    if fewest + 1 == left.len() {
        return Some(vec![FrontPlan { pivots: left, others: Vec::new() }]);
    }
    let mut round: Vec<FrontPlan> = Vec::new();
    for plan in plans {
        let shares = |other: &FrontPlan| {
            let both = [plan.pivots[0], other.pivots[0]];
            parts.iter().any(|part| both.iter().all(|p| part.contains(p)))
        };
        if plan.others.len() == fewest && !round.iter().any(shares) {
            round.push(plan);
        }
    }
    Some(round)
}

/// Rows that touch some orientations: their blocks in order, then the values.
struct Part<'a> {
    blocks: Vec<usize>,
    rows: Cow<'a, Mat<f64>>,
}

/// Eliminated orientations: the rows of the triangle that begin with them.
struct Front {
    /// Where the pivots begin among the unknowns, in the order of elimination.
    start: usize,
    /// Where the blocks of the others begin.
    others: Vec<usize>,
    /// Pivots, others, values.
    rows: Mat<f64>,
}

/// The triangle of a whole design matrix in the order of elimination, fronts first to last.
struct SparseTriangle {
    /// Unknowns of an orientation.
    block: usize,
    /// Orientations in the order of elimination; those without rows are not among them.
    order: Vec<usize>,
    fronts: Vec<Front>,
    /// Rows that touch nothing any more: what no solution reaches.
    tail: Mat<f64>,
}

/// Systems of the faces, put together.
pub struct JointSystem<'a> {
    pub set: DirectionSet,
    /// Unknowns of an orientation.
    pub block: usize,
    /// In the order of [`face_blocks`].
    pub faces: &'a [Triangle],
}

/// Why a joint system is not solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JointError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error(transparent)]
    NoConvergence(#[from] NoConvergence),
}

impl JointSystem<'_> {
    pub fn rows(&self) -> usize {
        self.faces.iter().map(Triangle::rows).sum()
    }

    /// The solution of least norm, as [`Triangle::solve`] gives it for the whole design matrix.
    /// Where not all unknowns are determined that takes the decomposition of all of them, which
    /// for thousands takes minutes and cannot be stopped.
    pub fn solve(&self, rcond: f64, ridge: f64, task: &Task) -> Result<Solution, JointError> {
        let damped_from = if ridge > 0.0 { 0.5 } else { 1.0 };
        let triangle = self.eliminate(None, &task.subtask(0.0, damped_from))?;
        let found = (triangle.order.len() == self.set.len())
            .then(|| determined(&triangle, rcond, |i| triangle.diagonal(i)))
            .flatten();
        let Some(found) = found else {
            let whole = self.assemble(&triangle);
            drop(triangle);
            return Ok(whole.solve(rcond, ridge)?);
        };
        let damped = match ridge > 0.0 {
            true => {
                let task = task.subtask(damped_from, 1.0);
                Some(self.eliminate(Some(ridge * found.largest), &task)?)
            }
            false => None,
        };
        Ok(Solution {
            unknowns: damped.as_ref().unwrap_or(&triangle).solutions(self.set.len()),
            rank: self.set.len() * self.block,
            condition: found.largest / found.smallest,
        })
    }

    /// The whole design matrix as one system.
    pub fn whole(&self) -> Triangle {
        match self.eliminate(None, &Task::default()) {
            Ok(triangle) => self.assemble(&triangle),
            Err(Cancelled) => unreachable!("nobody else has this task to stop it"),
        }
    }

    /// The triangle of the design matrix, with a row more for each unknown where it is damped.
    fn eliminate(&self, damping: Option<f64>, task: &Task) -> Result<SparseTriangle, Cancelled> {
        let mut parts = self.parts(damping);
        let mut triangle = SparseTriangle {
            block: self.block,
            order: Vec::new(),
            fronts: Vec::new(),
            tail: Mat::zeros(0, VALUES),
        };
        let mut plans = Vec::new();
        let all = self.set.len();
        task.step(0, all)?;
        while let Some(round) = next_round(&blocks_of(&parts)) {
            let mut work: Vec<(FrontPlan, Vec<Part<'_>>)> = Vec::new();
            for plan in round {
                let (own, rest) = std::mem::take(&mut parts).into_iter().partition(|part| {
                    part.blocks.contains(&plan.pivots[0]) || plan.others.is_empty()
                });
                parts = rest;
                work.push((plan, own));
            }
            let done: Vec<_> = work
                .into_par_iter()
                .map(|(plan, own)| {
                    task.step(triangle.order.len(), all)?;
                    let (rows, left) = factor_front(&plan, own, self.block);
                    Ok((plan, rows, left))
                })
                .collect::<Result<_, Cancelled>>()?;
            for (plan, rows, left) in done {
                triangle.order.extend(&plan.pivots);
                if plan.others.is_empty() {
                    triangle.tail = left;
                } else {
                    parts.push(Part { blocks: plan.others.clone(), rows: Cow::Owned(left) });
                }
                plans.push((plan, rows));
            }
            task.step(triangle.order.len(), all)?;
        }
        let place = |direction: usize| {
            let place = triangle.order.iter().position(|&d| d == direction);
            place.unwrap_or_default() * self.block
        };
        triangle.fronts = plans
            .into_iter()
            .map(|(plan, rows)| Front {
                start: place(plan.pivots[0]),
                others: plan.others.iter().map(|&d| place(d)).collect(),
                rows,
            })
            .collect();
        Ok(triangle)
    }

    /// The faces' rows without the columns of orientations that no row touches.
    fn parts(&self, damping: Option<f64>) -> Vec<Part<'_>> {
        let blocks = face_blocks(self.set);
        let mut is_touched = vec![false; self.set.len()];
        for (blocks, face) in blocks.iter().zip(self.faces) {
            for (b, &direction) in blocks.iter().enumerate() {
                let columns = b * self.block..(b + 1) * self.block;
                is_touched[direction] |=
                    columns.flat_map(|j| face.reduced().col(j).iter()).any(|&entry| entry != 0.0);
            }
        }
        let faces = blocks.iter().zip(self.faces).map(|(blocks, face)| {
            let kept: Vec<_> = (0..blocks.len()).filter(|&b| is_touched[blocks[b]]).collect();
            let rows = face.reduced();
            if kept.len() == blocks.len() {
                return Part { blocks: blocks.clone(), rows: Cow::Borrowed(rows) };
            }
            let mut own = Mat::zeros(rows.nrows(), kept.len() * self.block + VALUES);
            for (to, &from) in kept.iter().enumerate() {
                own.subcols_mut(to * self.block, self.block)
                    .copy_from(rows.subcols(from * self.block, self.block));
            }
            own.subcols_mut(kept.len() * self.block, VALUES)
                .copy_from(rows.subcols(blocks.len() * self.block, VALUES));
            Part { blocks: kept.iter().map(|&b| blocks[b]).collect(), rows: Cow::Owned(own) }
        });
        let damped = damping.into_iter().flat_map(|damping| {
            (0..self.set.len()).filter(|&direction| is_touched[direction]).map(move |direction| {
                Part {
                    blocks: vec![direction],
                    rows: Cow::Owned(Mat::from_fn(self.block, self.block + VALUES, |i, j| {
                        if i == j { damping } else { 0.0 }
                    })),
                }
            })
        });
        let damped: Vec<_> = damped.collect();
        faces.filter(|part| part.rows.nrows() > 0).chain(damped).collect()
    }

    /// The triangle with all its blocks, orientations in their own order.
    fn assemble(&self, triangle: &SparseTriangle) -> Triangle {
        let unknowns = self.set.len() * self.block;
        let pivots = triangle.order.len() * self.block;
        let mut dense = Mat::zeros(pivots + triangle.tail.nrows(), unknowns + VALUES);
        let mut copy = |rows: &Mat<f64>, at: usize, from: usize, to: usize, columns: usize| {
            dense
                .submatrix_mut(at, to, rows.nrows(), columns)
                .copy_from(rows.subcols(from, columns));
        };
        for front in &triangle.fronts {
            for (k, place) in front.places(self.block).enumerate() {
                let direction = triangle.order[place / self.block];
                copy(&front.rows, front.start, k * self.block, direction * self.block, self.block);
            }
            let from = front.rows.ncols() - VALUES;
            copy(&front.rows, front.start, from, unknowns, VALUES);
        }
        copy(&triangle.tail, pivots, 0, unknowns, VALUES);
        Triangle::from_rows(unknowns, self.rows(), dense)
    }
}

fn blocks_of(parts: &[Part<'_>]) -> Vec<Vec<usize>> {
    parts.iter().map(|part| part.blocks.clone()).filter(|blocks| !blocks.is_empty()).collect()
}

/// Eliminates a front's pivots: their rows of the triangle, and the rows that are left on the
/// others and the values, no more than those have columns.
fn factor_front(plan: &FrontPlan, parts: Vec<Part<'_>>, block: usize) -> (Mat<f64>, Mat<f64>) {
    let columns: Vec<usize> = plan.pivots.iter().chain(&plan.others).copied().collect();
    let pivots = plan.pivots.len() * block;
    let width = columns.len() * block + VALUES;
    let (mut stacked, leads) = stack(&columns, parts, block, width);
    // Rows that outnumber the columns are reduced to a triangle of all columns at once.
    let is_reduced = leads.len() > width || plan.others.is_empty();
    let cleared = if is_reduced { width } else { pivots };
    let mut triangle = Mat::zeros(cleared, width);
    let rows = Block { rows: stacked.as_mut(), leads: Some(&leads) };
    qr_update(triangle.as_mut(), rows, &mut Scratch::default());
    if is_reduced {
        let left = triangle.get(pivots.., pivots..).to_owned();
        (triangle.get(..pivots, ..).to_owned(), left)
    } else {
        let left = stacked.get(..leads.len(), pivots..).to_owned();
        (triangle, left)
    }
}

/// The rows of all parts in the front's columns, sorted by their first entry that is not zero,
/// with those entries' columns; rows of zeros are left out.
fn stack(
    columns: &[usize],
    parts: Vec<Part<'_>>,
    block: usize,
    width: usize,
) -> (Mat<f64>, Vec<usize>) {
    let places: Vec<Vec<usize>> = parts
        .iter()
        .map(|part| {
            let place = |direction| {
                let place = columns.iter().position(|&c| c == direction);
                place.unwrap_or_default() * block
            };
            part.blocks.iter().map(|&direction| place(direction)).collect()
        })
        .collect();
    let mut order = Vec::new();
    for (p, (part, places)) in parts.iter().zip(&places).enumerate() {
        let mut leads = vec![width; part.rows.nrows()];
        for j in 0..part.rows.ncols() {
            let to = match places.get(j / block) {
                Some(start) => start + j % block,
                None => width - VALUES + j - places.len() * block,
            };
            for (lead, &entry) in leads.iter_mut().zip(part.rows.col(j).iter()) {
                if entry != 0.0 {
                    *lead = (*lead).min(to);
                }
            }
        }
        let used = leads.into_iter().enumerate().filter(|&(_, lead)| lead < width);
        order.extend(used.map(|(i, lead)| (lead, p, i)));
    }
    order.sort_unstable();
    let mut stacked = Mat::zeros(order.len().next_multiple_of(ROW_UNIT), width);
    for (b, &direction) in columns.iter().enumerate() {
        let from: Vec<_> =
            parts.iter().map(|part| part.blocks.iter().position(|&d| d == direction)).collect();
        for j in 0..block {
            let mut column = stacked.col_mut(b * block + j);
            for (row, &(_, p, i)) in order.iter().enumerate() {
                if let Some(from) = from[p] {
                    column[row] = parts[p].rows[(i, from * block + j)];
                }
            }
        }
    }
    for k in 0..VALUES {
        let mut column = stacked.col_mut(width - VALUES + k);
        for (row, &(_, p, i)) in order.iter().enumerate() {
            column[row] = parts[p].rows[(i, places[p].len() * block + k)];
        }
    }
    (stacked, order.into_iter().map(|(lead, ..)| lead).collect())
}

impl Front {
    fn pivots(&self) -> usize {
        self.rows.nrows()
    }

    /// Where the blocks of all columns begin, pivots first.
    fn places(&self, block: usize) -> impl Iterator<Item = usize> {
        let pivots = (0..self.pivots() / block).map(move |k| self.start + k * block);
        pivots.chain(self.others.iter().copied())
    }

    /// Columns of the others, each with its place among the unknowns.
    fn off_diagonal(&self, block: usize) -> impl Iterator<Item = (usize, &[f64])> {
        let places = self.others.iter().flat_map(move |&at| at..at + block);
        let first = self.pivots();
        places.enumerate().map(move |(j, place)| (place, self.rows.col_as_slice(first + j)))
    }

    fn triangle(&self) -> Dense<'_> {
        Dense::leading(&self.rows, self.pivots())
    }
}

impl SparseTriangle {
    fn diagonal(&self, i: usize) -> f64 {
        let front = self.fronts.partition_point(|front| front.start <= i) - 1;
        let i = i - self.fronts[front].start;
        self.fronts[front].rows[(i, i)]
    }

    /// Solutions for all values, orientations in their own order.
    fn solutions(&self, directions: usize) -> Vec<[f64; VALUES]> {
        let mut unknowns = vec![[0.0; VALUES]; directions * self.block];
        #[expect(clippy::needless_range_loop, reason = "k is a column of all fronts too")]
        for k in 0..VALUES {
            let mut x: Vec<f64> = self
                .fronts
                .iter()
                .flat_map(|front| front.rows.col(front.rows.ncols() - VALUES + k).iter())
                .copied()
                .collect();
            self.solve(&mut x);
            for (values, &direction) in x.chunks(self.block).zip(&self.order) {
                for (i, &value) in values.iter().enumerate() {
                    unknowns[direction * self.block + i][k] = value;
                }
            }
        }
        unknowns
    }
}

impl UpperTriangle for SparseTriangle {
    fn len(&self) -> usize {
        self.order.len() * self.block
    }

    // Fronts touch themselves and later ones only, so that each step below may be made in place.

    fn multiply(&self, x: &mut [f64]) {
        for front in &self.fronts {
            let (head, later) = x.split_at_mut(front.start + front.pivots());
            let own = &mut head[front.start..];
            front.triangle().multiply(own);
            for (place, column) in front.off_diagonal(self.block) {
                add_scaled(own, later[place - front.start - front.pivots()], column);
            }
        }
    }

    fn multiply_transposed(&self, x: &mut [f64]) {
        for front in self.fronts.iter().rev() {
            let (head, later) = x.split_at_mut(front.start + front.pivots());
            let own = &mut head[front.start..];
            for (place, column) in front.off_diagonal(self.block) {
                later[place - front.start - front.pivots()] += dot(column, own);
            }
            front.triangle().multiply_transposed(own);
        }
    }

    fn solve(&self, x: &mut [f64]) {
        for front in self.fronts.iter().rev() {
            let (head, later) = x.split_at_mut(front.start + front.pivots());
            let own = &mut head[front.start..];
            for (place, column) in front.off_diagonal(self.block) {
                add_scaled(own, -later[place - front.start - front.pivots()], column);
            }
            front.triangle().solve(own);
        }
    }

    fn solve_transposed(&self, x: &mut [f64]) {
        for front in &self.fronts {
            let (head, later) = x.split_at_mut(front.start + front.pivots());
            let own = &mut head[front.start..];
            front.triangle().solve_transposed(own);
            for (place, column) in front.off_diagonal(self.block) {
                later[place - front.start - front.pivots()] -= dot(column, own);
            }
        }
    }
}
