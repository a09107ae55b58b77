//! A box in cells: in each, harmonic functions stand for the metal that is far from it, and what is near is
//! evaluated itself.
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
use trackwright_field::generator::reading::axis_error;
use trackwright_field::harmonic::HarmonicModel;
use trackwright_geometry::bounds::Bounds;

/// Halvings of the box: cells of the tracker's cube are 125 mm wide then. Where smaller ones would be needed,
/// the metal itself is evaluated sooner than they are fitted.
const MOST_HALVINGS: u32 = 3;

/// Metal is near where it is nearer to a cell's middle than this times half its diagonal: harmonics of
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
    /// By harmonic functions alone.
    pub harmonic_poses: u64,
    /// By the field itself of what metal is near.
    pub direct_poses: u64,
    /// Cells of harmonic functions alone.
    pub harmonic_cells: usize,
    /// Cells that metal is near to.
    pub direct_cells: usize,
}

#[derive(Debug)]
struct Cell {
    bounds: Bounds,
    halvings: u32,
    content: OnceLock<Content>,
}

/// What makes the field in a cell, and its halves where metal is near that may be far from them.
#[derive(Debug)]
struct Content {
    part: Part,
    halves: Option<Box<[Cell; 8]>>,
}

/// What makes the field in a cell.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Stands for all but the bodies that are near.
    far: Option<Arc<HarmonicModel>>,
    /// Indices of bodies that are evaluated themselves.
    near: Vec<usize>,
}

impl Part {
    /// The harmonics that stand for all metal.
    fn whole(&self) -> Option<&Arc<HarmonicModel>> {
        self.far.as_ref().filter(|_| self.near.is_empty())
    }

    /// What all but some bodies add, where those are of the near ones.
    pub fn disturbance_without(
        &self,
        errors: &impl NearMetal,
        bodies: &[usize],
        p: &Point3<f64>,
    ) -> Disturbance {
        let Some(far) = &self.far else { return errors.disturbance_without(bodies, p) };
        let mut fields = DisturbedCoils::disturbance(far.as_ref(), p)?;
        let others = self.near.iter().copied().filter(|body| !bodies.contains(body));
        let others: Vec<usize> = others.collect();
        if !others.is_empty() {
            let near = errors.disturbance_of(&others, p)?;
            fields.iter_mut().zip(near).for_each(|(field, near)| *field += near);
        }
        Some(fields)
    }
}

/// Of every coil; `None` in metal.
pub(crate) type Disturbance = Option<Vec<Vector3<f64>>>;

/// Errors in fields of metal of which it is known how near it is.
pub(crate) trait NearMetal: DisturbedCoils + PoseErrors {
    /// Of each body, a distance that it is no nearer than.
    fn distances_mm(&self, p: &Point3<f64>) -> Vec<f64>;

    /// What some of the bodies add to the field of every coil; `None` in their metal.
    fn disturbance_of(&self, bodies: &[usize], p: &Point3<f64>) -> Disturbance;

    /// What all else adds: the other bodies, and what disturbs the coils without metal.
    fn disturbance_without(&self, bodies: &[usize], p: &Point3<f64>) -> Disturbance;
}

impl<E: NearMetal> Cells<E> {
    pub fn new(errors: Arc<E>, sampling: Arc<Sampling>, bounds: Bounds) -> Self {
        let root = Cell { bounds, halvings: 0, content: OnceLock::new() };
        Self { errors, sampling, root, poses: AtomicU64::new(0), direct_poses: AtomicU64::new(0) }
    }

    /// Harmonics of the whole box, where one set stands for all of it.
    pub fn whole(&self) -> Option<Arc<HarmonicModel>> {
        self.content(&self.root, None).part.whole().cloned()
    }

    pub fn counts(&self) -> CellCounts {
        let direct_poses = self.direct_poses.load(Ordering::Relaxed);
        let harmonic_poses = self.poses.load(Ordering::Relaxed).saturating_sub(direct_poses);
        let mut counts = CellCounts { harmonic_poses, direct_poses, ..CellCounts::default() };
        self.root.count(&mut counts);
        counts
    }

    /// What makes the field at a place of the box.
    fn part(&self, p: &Point3<f64>) -> &Part {
        let mut content = self.content(&self.root, None);
        let mut cell = &self.root;
        while let Some(halves) = &content.halves {
            cell = &halves[cell.half_of(p)];
            content = self.content(cell, Some(&content.part));
        }
        &content.part
    }

    fn content<'a>(&self, cell: &'a Cell, around: Option<&Part>) -> &'a Content {
        // No other thread is waited for in here, which might be waiting for this one.
        cell.content.get_or_init(|| {
            let part = self.part_of(&cell.bounds, around);
            let has_halves = part.whole().is_none() && cell.halvings < MOST_HALVINGS;
            Content { part, halves: has_halves.then(|| Box::new(cell.halves())) }
        })
    }

    /// What makes the field in a box, by what does in a larger one around it.
    fn part_of(&self, bounds: &Bounds, around: Option<&Part>) -> Part {
        let distances_mm = self.errors.distances_mm(&bounds.center_mm());
        let near_mm = LEAST_RATIO * bounds.size_mm().norm() / 2.0;
        let near: Vec<usize> =
            (0..distances_mm.len()).filter(|&body| distances_mm[body] < near_mm).collect();
        if let Some(around) = around.filter(|around| around.far.is_some() && around.near == near) {
            return around.clone();
        }
        let all = Part { far: None, near: (0..distances_mm.len()).collect() };
        if near == all.near {
            return all;
        }
        let errors = self.errors.as_ref();
        let fitted = |by: &Part| self.sampling.fit(bounds, errors, &near, by);
        match around.and_then(fitted).or_else(|| fitted(&all)) {
            Some(far) => Part { far: Some(far), near },
            None => all,
        }
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
        let Some(content) = self.content.get() else { return };
        match (&content.halves, content.part.whole()) {
            (Some(halves), _) => halves.iter().for_each(|cell| cell.count(counts)),
            (None, Some(_)) => counts.harmonic_cells.add_assign(1),
            (None, None) => counts.direct_cells.add_assign(1),
        }
    }
}

impl<E: NearMetal> DisturbedCoils for Cells<E> {
    fn generator(&self) -> &Generator {
        self.errors.generator()
    }

    fn disturbance(&self, p: &Point3<f64>) -> Disturbance {
        self.part(p).disturbance_without(self.errors.as_ref(), &[], p)
    }

    fn metal_distance_mm(&self, p: &Point3<f64>) -> f64 {
        self.errors.distances_mm(p).into_iter().fold(f64::INFINITY, f64::min)
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
        let mut groups: Vec<(&Part, Vec<usize>)> = Vec::new();
        for (index, p) in positions_mm.iter().enumerate() {
            let part = self.part(p);
            match groups.iter_mut().rev().find(|(other, _)| std::ptr::eq(*other, part)) {
                Some((_, group)) => group.push(index),
                None => groups.push((part, vec![index])),
            }
        }
        for (part, group) in groups {
            let places: Vec<_> = group.iter().map(|&index| positions_mm[index]).collect();
            let directions: Vec<_> = group.iter().map(|&index| axes[index]).collect();
            let mut read = vec![None; group.len()];
            match part.whole() {
                Some(model) => model.axis_errors(&places, &directions, &mut read),
                None => {
                    self.direct_poses.fetch_add(group.len() as u64, Ordering::Relaxed);
                    let errors = self.errors.as_ref();
                    let fields = |p: &Point3<f64>| part.disturbance_without(errors, &[], p);
                    errors_among(self.generator(), fields, &places, &directions, &mut read);
                }
            }
            for (index, read) in group.into_iter().zip(read) {
                out[index] = read;
            }
        }
    }
}

/// Errors of poses in fields.
pub(crate) fn errors_among(
    generator: &Generator,
    fields: impl Fn(&Point3<f64>) -> Disturbance,
    positions_mm: &[Point3<f64>],
    axes: &[Unit<Vector3<f64>>],
    out: &mut [Option<Coefficient>],
) {
    // Several axes at one place are read in one field.
    let mut there: Option<(Point3<f64>, Disturbance)> = None;
    for ((p, axis), out) in positions_mm.iter().zip(axes).zip(out) {
        if there.as_ref().is_none_or(|(place, _)| place != p) {
            there = Some((*p, fields(p)));
        }
        let fields = there.as_ref().and_then(|(_, fields)| fields.as_ref());
        let error = fields.and_then(|d| axis_error(generator, p, axis, d).ok());
        *out = error.map(|error| error.values());
    }
}
