//! A box in cells: harmonic functions stand for the metal in the cells where they can, and the metal is
//! evaluated itself in those where it is too near.
//!
//! A cell is fitted when the first pose is in it, and always the same way, so that a pose's error does not
//! depend on what was evaluated before.

use crate::harmonics::Sampling;
use nalgebra::{Point3, Unit, Vector3};
use std::ops::AddAssign;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use trackwright_field::computed::{DisturbedCoils, MadeOfCoils, PoseErrors};
use trackwright_field::evaluation::Coefficient;
use trackwright_field::generator::Generator;
use trackwright_field::harmonic::HarmonicModel;
use trackwright_geometry::bounds::Bounds;

/// Halvings of the box: cells of the tracker's cube are 125 mm wide then. Where smaller ones would be needed,
/// the metal itself is evaluated sooner than they are fitted.
const MOST_HALVINGS: u32 = 2;

/// A cell is not tried where metal is nearer to its middle than this times half its diagonal: harmonics of
/// degree 10 would leave some per cent of the field there.
const LEAST_RATIO: f64 = 1.4;

/// A tracker's errors among metal in a box.
#[derive(Debug)]
pub(crate) struct Cells<E> {
    errors: Arc<E>,
    sampling: Arc<Sampling>,
    root: Cell,
    poses: AtomicU64,
    direct_poses: AtomicU64,
}

/// How poses were evaluated so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellCounts {
    /// By harmonic functions.
    pub harmonic_poses: u64,
    /// By the metal's field itself.
    pub direct_poses: u64,
    /// Cells that have harmonic functions.
    pub harmonic_cells: usize,
    /// Cells that have none.
    pub direct_cells: usize,
}

#[derive(Debug)]
struct Cell {
    bounds: Bounds,
    halvings: u32,
    content: OnceLock<Content>,
}

#[derive(Debug)]
enum Content {
    Harmonic(Arc<HarmonicModel>),
    Direct,
    Halves(Box<[Cell; 8]>),
}

/// Errors in fields of metal of which it is known how near it is.
pub(crate) trait NearMetal: DisturbedCoils + PoseErrors {
    /// A distance that no metal is nearer than.
    fn distance_mm(&self, p: &Point3<f64>) -> f64;
}

impl<E: NearMetal> Cells<E> {
    pub fn new(errors: Arc<E>, sampling: Arc<Sampling>, bounds: Bounds) -> Self {
        let root = Cell { bounds, halvings: 0, content: OnceLock::new() };
        Self { errors, sampling, root, poses: AtomicU64::new(0), direct_poses: AtomicU64::new(0) }
    }

    /// Harmonics of the whole box, where one set stands for all of it.
    pub fn whole(&self) -> Option<Arc<HarmonicModel>> {
        match self.content(&self.root) {
            Content::Harmonic(model) => Some(Arc::clone(model)),
            Content::Direct | Content::Halves(_) => None,
        }
    }

    pub fn counts(&self) -> CellCounts {
        let direct_poses = self.direct_poses.load(Ordering::Relaxed);
        let harmonic_poses = self.poses.load(Ordering::Relaxed).saturating_sub(direct_poses);
        let mut counts = CellCounts { harmonic_poses, direct_poses, ..CellCounts::default() };
        self.root.count(&mut counts);
        counts
    }

    /// The harmonics at a place of the box; `None` where there are none.
    fn harmonics(&self, p: &Point3<f64>) -> Option<&HarmonicModel> {
        let mut cell = &self.root;
        loop {
            match self.content(cell) {
                Content::Harmonic(model) => return Some(model),
                Content::Direct => return None,
                Content::Halves(halves) => cell = &halves[cell.half_of(p)],
            }
        }
    }

    fn content<'a>(&self, cell: &'a Cell) -> &'a Content {
        // No other thread is waited for in here, which might be waiting for this one.
        cell.content.get_or_init(|| {
            let center = cell.bounds.center_mm();
            let is_far = self.errors.distance_mm(&center)
                >= LEAST_RATIO * cell.bounds.size_mm().norm() / 2.0;
            let fitted = is_far.then(|| self.sampling.fit(&cell.bounds, self.errors.as_ref()));
            match fitted.flatten() {
                Some(model) => Content::Harmonic(model),
                _ if cell.halvings < MOST_HALVINGS => Content::Halves(Box::new(cell.halves())),
                _ => Content::Direct,
            }
        })
    }
}

impl Cell {
    /// Which half of each side a place is in: bit `k` of the side along axis `k`.
    fn half_of(&self, p: &Point3<f64>) -> usize {
        let center = self.bounds.center_mm();
        (0..3).map(|k| usize::from(p[k] >= center[k]) << k).sum()
    }

    fn halves(&self) -> [Self; 8] {
        let center = self.bounds.center_mm();
        std::array::from_fn(|half| {
            let (mut min, mut max) = (self.bounds.min_mm, center);
            for k in (0..3).filter(|k| half >> k & 1 == 1) {
                (min[k], max[k]) = (center[k], self.bounds.max_mm[k]);
            }
            let bounds = Bounds { min_mm: min, max_mm: max };
            Self { bounds, halvings: self.halvings + 1, content: OnceLock::new() }
        })
    }

    fn count(&self, counts: &mut CellCounts) {
        match self.content.get() {
            None => {}
            Some(Content::Harmonic(_)) => counts.harmonic_cells.add_assign(1),
            Some(Content::Direct) => counts.direct_cells.add_assign(1),
            Some(Content::Halves(halves)) => halves.iter().for_each(|cell| cell.count(counts)),
        }
    }
}

impl<E: NearMetal> DisturbedCoils for Cells<E> {
    fn generator(&self) -> &Generator {
        self.errors.generator()
    }

    fn disturbance(&self, p: &Point3<f64>) -> Option<Vec<Vector3<f64>>> {
        match self.harmonics(p) {
            Some(model) => DisturbedCoils::disturbance(model, p),
            None => self.errors.disturbance(p),
        }
    }
}

impl<E: NearMetal> PoseErrors for Cells<E> {
    fn coils(&self) -> Option<MadeOfCoils<'_>> {
        Some(MadeOfCoils { coils: self, has_others: false })
    }

    fn axis_errors(
        &self,
        positions_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
        out: &mut [Option<Coefficient>],
    ) {
        self.poses.fetch_add(positions_mm.len() as u64, Ordering::Relaxed);
        // Poses of one cell after the other, so that the vectors of the machine are filled.
        let mut groups: Vec<(Option<&HarmonicModel>, Vec<usize>)> = Vec::new();
        for (index, p) in positions_mm.iter().enumerate() {
            let model = self.harmonics(p);
            let is_same = |other: &Option<&HarmonicModel>| match (other, &model) {
                (Some(a), Some(b)) => std::ptr::eq(*a, *b),
                (a, b) => a.is_none() && b.is_none(),
            };
            match groups.iter_mut().rev().find(|(other, _)| is_same(other)) {
                Some((_, group)) => group.push(index),
                None => groups.push((model, vec![index])),
            }
        }
        for (model, group) in groups {
            let places: Vec<_> = group.iter().map(|&index| positions_mm[index]).collect();
            let directions: Vec<_> = group.iter().map(|&index| axes[index]).collect();
            let mut read = vec![None; group.len()];
            match model {
                Some(model) => model.axis_errors(&places, &directions, &mut read),
                None => {
                    self.direct_poses.fetch_add(group.len() as u64, Ordering::Relaxed);
                    self.errors.axis_errors(&places, &directions, &mut read);
                }
            }
            for (index, read) in group.into_iter().zip(read) {
                out[index] = read;
            }
        }
    }
}
