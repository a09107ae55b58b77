//! Few poses that stand for a range of motion: Gauss quadrature on its grid.

use super::motion::{MotionError, MotionGrid};
use super::scenario::Scenario;
use nalgebra::DMatrix;
use std::ops::Range;
use trackwright_geometry::pose::Pose;

/// Poses that one core computes before it looks whether anyone still wants them: some 0.5 ms.
const PIECE: usize = 512;

/// Poses `crf_from_tool` with weights that add to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseRule {
    pub poses: Vec<Pose>,
    pub weights: Vec<f64>,
    /// Poses come in runs of one orientation, each so long.
    pub run: usize,
}

/// Nodes along one axis: value and weight.
type Nodes = Vec<(f64, f64)>;

impl PoseRule {
    /// The design's own pose.
    pub fn single(scenario: &Scenario) -> Self {
        Self { poses: vec![scenario.crf_from_tool], weights: vec![1.0], run: 1 }
    }

    /// Every pose of the grid.
    pub fn whole(grid: &MotionGrid) -> Self {
        let (trials, orientations) = (grid.trials(), grid.orientations());
        let places = trials / orientations;
        let order = (0..orientations)
            .flat_map(|turn| (0..places).map(move |place| place * orientations + turn));
        Self {
            poses: order.map(|trial| grid.pose(trial)).collect(),
            weights: vec![1.0 / trials as f64; trials],
            run: places,
        }
    }

    /// As many nodes an axis as make at most so many poses.
    ///
    /// Sums over the rule are those over the grid for every polynomial up to degree `2m - 1` in
    /// each axis with `m` nodes, whatever the grid's step; with as many nodes as the axis has
    /// values it is the grid itself. Errors of a tool change smoothly within its range of motion,
    /// so few nodes go far.
    ///
    /// # Errors
    /// See [`super::motion::Motion::grid`].
    pub fn gauss(scenario: &Scenario, most: usize) -> Result<Self, MotionError> {
        let Some(grid) = scenario.motion_grid()? else { return Ok(Self::single(scenario)) };
        let counts = grid.counts();
        let poses = |m: usize| counts.iter().fold(1_usize, |p, n| p.saturating_mul(m.min(*n)));
        let longest = counts.iter().copied().max().unwrap_or(1);
        let m = (1..=longest).take_while(|&m| poses(m) <= most).last();
        let axes: Vec<Nodes> = grid
            .motion()
            .axes()
            .iter()
            .zip(counts)
            .map(|((_, range), count)| {
                let nodes = gauss_nodes(count, m.unwrap_or(1).min(count));
                let at = |index: f64| range.map_or(0.0, |r| r.min + index * r.step);
                nodes.into_iter().map(|(i, weight)| (at(i), weight)).collect()
            })
            .collect();
        let lengths: Vec<usize> = axes.iter().map(Vec::len).collect();
        let run = lengths[..3].iter().product();
        let all: usize = lengths.iter().product();
        // Translations run fastest.
        let order = [2, 1, 0, 5, 4, 3];
        let (poses, weights) = (0..all)
            .map(|index| {
                let (mut rest, mut values, mut weight) = (index, [0.0; 6], 1.0);
                for k in order {
                    let (value, share) = axes[k][rest % lengths[k]];
                    rest /= lengths[k];
                    values[k] = value;
                    weight *= share;
                }
                (grid.moved(values), weight)
            })
            .unzip();
        Ok(Self { poses, weights, run })
    }

    /// What one core computes at a time: whole runs, or a piece of a long one.
    pub fn pieces(&self) -> Vec<Range<usize>> {
        let run = self.run.max(1);
        let step = if run < PIECE { PIECE / run * run } else { run };
        let all = self.poses.len();
        (0..all)
            .step_by(step)
            .flat_map(|start| {
                let end = (start + step).min(all);
                let pieces = (start..end).step_by(PIECE);
                pieces.map(move |start| start..(start + PIECE).min(end))
            })
            .collect()
    }
}

/// Where all axes of a motion are at one of their ends.
pub fn corners(grid: &MotionGrid) -> Vec<Pose> {
    let counts = grid.counts();
    (0..64_usize)
        .filter(|corner| (0..6).all(|k| counts[k] > 1 || corner >> k & 1 == 0))
        .map(|corner| {
            let trial = (0..6).fold(0, |trial, k| {
                let index = if corner >> k & 1 == 0 { 0 } else { counts[k] - 1 };
                trial * counts[k] + index
            });
            grid.pose(trial)
        })
        .collect()
}

/// Nodes and weights of the Gauss rule for the mean over `0, 1, …, count - 1`.
///
/// The nodes are the eigenvalues of the Jacobi matrix of the discrete Chebyshev (Gram)
/// polynomials, `a = (N - 1) / 2` and `b_k² = k² (N² - k²) / (4 (4 k² - 1))`, the weights the squares
/// of the eigenvectors' first components (Golub and Welsch, Mathematics of Computation 23, 1969).
pub fn gauss_nodes(count: usize, nodes: usize) -> Nodes {
    let n = count as f64;
    let mut jacobi = DMatrix::from_diagonal_element(nodes, nodes, (n - 1.0) / 2.0);
    for i in 1..nodes {
        let k = i as f64;
        let b = (k * k * (n * n - k * k) / (4.0 * (4.0 * k * k - 1.0))).sqrt();
        (jacobi[(i - 1, i)], jacobi[(i, i - 1)]) = (b, b);
    }
    let eigen = jacobi.symmetric_eigen();
    let mut nodes: Nodes =
        (0..nodes).map(|i| (eigen.eigenvalues[i], eigen.eigenvectors[(0, i)].powi(2))).collect();
    nodes.sort_by(|a, b| a.0.total_cmp(&b.0));
    nodes
}
