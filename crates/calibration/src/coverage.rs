//! Where a recording has been: which parts of a volume, turned which ways, and what is missing, so
//! that whoever waves the sensor knows where to go next.
//!
//! The volume is cut into cells some 50 mm wide; a cell keeps which basis orientations the sensor's
//! axis was nearest to there. Samples that lie close to one that was taken, turned alike, add nothing
//! to a fit but weight, and are counted apart.

use nalgebra::{Point3, Unit, Vector3};
use std::collections::HashSet;
use trackwright_field::Environment;
use trackwright_field::bernstein::coefficient_count;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::volume::Volume;

/// What cells are as wide as, nearly: ten along the side of an Aurora's cube, more than the seven
/// places a side that distinguish the polynomials of order 6.
const CELL_MM: f64 = 50.0;

/// A volume that is far larger has larger cells: a hand visits hundreds, not thousands.
const MOST_CELLS_A_SIDE: usize = 12;

/// Parts of a cell a side; samples in one of them, turned alike, are alike.
const PARTS: usize = 4;

/// What coverage is judged against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoveragePlan {
    pub volume: Volume,
    pub directions: DirectionSet,
}

impl CoveragePlan {
    /// The tracker's volume, else the model's box; the model's basis orientations, else the paper's
    /// fourteen where it has none to speak of.
    pub fn of(environment: &Environment) -> Self {
        let directions = environment.model.directions();
        Self {
            volume: (environment.volume).unwrap_or(Volume::Box(*environment.model.bounds())),
            directions: match directions {
                DirectionSet::One => DirectionSet::Fourteen,
                some => some,
            },
        }
    }
}

/// A cell of the volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    pub center_mm: Point3<f64>,
    /// Samples in it that are not alike.
    pub samples: u32,
    /// The part of the basis orientations that it was sampled in, from 0 to 1.
    pub turned: f64,
}

/// Where samples were taken.
#[derive(Clone, Debug)]
pub struct Coverage {
    plan: CoveragePlan,
    bounds: Bounds,
    counts: [usize; 3],
    /// By cell, x fastest; `None` where its middle is outside the volume.
    cells: Vec<Option<Taken>>,
    by_direction: Vec<u64>,
    /// Part of a cell and orientation, of every sample: at most 64 parts of 1,728 cells and 42
    /// orientations.
    taken: HashSet<(u32, u8)>,
    samples: u64,
    outside: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Taken {
    samples: u32,
    /// A bit a basis orientation: there are at most 42.
    directions: u64,
}

/// How far a recording has come.
#[derive(Clone, Debug, PartialEq)]
pub struct CoverageSummary {
    /// All that were added.
    pub samples: u64,
    /// Those in the volume that are not like one before.
    pub distinct: u64,
    pub outside: u64,
    pub cells: usize,
    pub cells_sampled: usize,
    /// Distinct samples whose axis was nearest to each basis orientation.
    pub by_direction: Vec<(Unit<Vector3<f64>>, u64)>,
}

impl CoverageSummary {
    /// The basis orientation with the fewest samples, the first of several.
    pub fn least_direction(&self) -> Option<(Unit<Vector3<f64>>, u64)> {
        self.by_direction.iter().copied().min_by_key(|(_, n)| *n)
    }

    /// Samples for each unknown of a model of an order, at the basis orientation with the fewest.
    pub fn samples_per_unknown(&self, order: usize) -> f64 {
        let least = self.least_direction().map_or(0, |(_, n)| n);
        least as f64 / coefficient_count(order) as f64
    }

    /// The highest order, up to 6, that the samples determine at every basis orientation.
    pub fn highest_order(&self) -> Option<usize> {
        (0..=6).take_while(|order| self.samples_per_unknown(*order) >= 1.0).last()
    }
}

impl Coverage {
    /// Coverage without samples.
    pub fn new(plan: CoveragePlan) -> Self {
        let bounds = plan.volume.bounds();
        let size = bounds.size_mm();
        let counts: [usize; 3] = std::array::from_fn(|k| {
            ((size[k] / CELL_MM).round() as usize).clamp(1, MOST_CELLS_A_SIDE)
        });
        let mut coverage = Self {
            plan,
            bounds,
            counts,
            cells: vec![None; counts.iter().product()],
            by_direction: vec![0; plan.directions.len()],
            taken: HashSet::new(),
            samples: 0,
            outside: 0,
        };
        for index in 0..coverage.cells.len() {
            if plan.volume.contains(&coverage.center_mm(index)) {
                coverage.cells[index] = Some(Taken::default());
            }
        }
        coverage
    }

    /// What coverage is judged against.
    pub fn plan(&self) -> &CoveragePlan {
        &self.plan
    }

    /// Adds a sample, as it was measured; whether it adds anything to what there was.
    pub fn add(&mut self, tracker_from_sensor: &Pose) -> bool {
        self.samples += 1;
        let position = Point3::from(tracker_from_sensor.translation.vector);
        let Some(part) = self.part_at(&position) else {
            self.outside += 1;
            return false;
        };
        let axis = tracker_from_sensor.rotation * Vector3::z_axis();
        let direction = nearest(self.plan.directions, &axis);
        let [x, y, z] = part.map(|p| p / PARTS);
        let cell = x + self.counts[0] * (y + self.counts[1] * z);
        let Some(Some(taken)) = self.cells.get_mut(cell) else {
            self.outside += 1;
            return false;
        };
        let [w, h] = [self.counts[0] * PARTS, self.counts[1] * PARTS];
        let index = part[0] + w * (part[1] + h * part[2]);
        // At most 48 parts a side and 42 orientations.
        let key = (index as u32, direction as u8);
        if !self.taken.insert(key) {
            return false;
        }
        taken.samples += 1;
        taken.directions |= 1 << direction;
        self.by_direction[direction] += 1;
        true
    }

    /// Size of a cell.
    pub fn cell_mm(&self) -> Vector3<f64> {
        let size = self.bounds.size_mm();
        Vector3::from_fn(|k, _| size[k] / self.counts[k] as f64)
    }

    /// The cells of the volume.
    pub fn cells(&self) -> impl Iterator<Item = Cell> {
        let directions = self.plan.directions.len() as f64;
        (self.cells.iter().enumerate()).filter_map(move |(index, taken)| {
            let taken = (*taken)?;
            Some(Cell {
                center_mm: self.center_mm(index),
                samples: taken.samples,
                turned: f64::from(taken.directions.count_ones()) / directions,
            })
        })
    }

    /// Counts of all samples.
    pub fn summary(&self) -> CoverageSummary {
        let directions = self.plan.directions.directions();
        CoverageSummary {
            samples: self.samples,
            distinct: self.taken.len() as u64,
            outside: self.outside,
            cells: self.cells.iter().flatten().count(),
            cells_sampled: self.cells.iter().flatten().filter(|taken| taken.samples > 0).count(),
            by_direction: (directions.iter().copied())
                .zip(self.by_direction.iter().copied())
                .collect(),
        }
    }

    /// Where to go next: the middle of the empty cell that is farthest from any sampled one, the
    /// one nearest to the middle of the volume while nothing is sampled; `None` once all are.
    pub fn next_mm(&self) -> Option<Point3<f64>> {
        let sampled: Vec<_> =
            (self.cells().filter(|cell| cell.samples > 0)).map(|cell| cell.center_mm).collect();
        let middle = self.bounds.center_mm();
        let from_sampled = |at: &Point3<f64>| {
            (sampled.iter().map(|s| (s - at).norm_squared())).fold(f64::INFINITY, f64::min)
        };
        let empty = self.cells().filter(|cell| cell.samples == 0);
        let score = |cell: &Cell| {
            let at = &cell.center_mm;
            if sampled.is_empty() { -(at - middle).norm_squared() } else { from_sampled(at) }
        };
        // Of several alike the first, so that it stays where it is.
        let best = empty
            .map(|cell| (score(&cell), cell.center_mm))
            .reduce(|best, next| if next.0 > best.0 { next } else { best });
        best.map(|(_, at)| at)
    }

    /// The part of a cell that a position is in, along each axis.
    fn part_at(&self, position: &Point3<f64>) -> Option<[usize; 3]> {
        if !self.bounds.contains(position) {
            return None;
        }
        let unit = self.bounds.to_unit(position);
        Some(std::array::from_fn(|k| {
            let parts = self.counts[k] * PARTS;
            ((unit[k] * parts as f64) as usize).min(parts - 1)
        }))
    }

    fn center_mm(&self, index: usize) -> Point3<f64> {
        let [nx, ny, _] = self.counts;
        let cell = [index % nx, (index / nx) % ny, index / (nx * ny)];
        let step = self.cell_mm();
        self.bounds.min_mm + Vector3::from_fn(|k, _| (cell[k] as f64 + 0.5) * step[k])
    }
}

/// The basis orientation nearest to an axis.
fn nearest(directions: DirectionSet, axis: &Unit<Vector3<f64>>) -> usize {
    let along = directions.directions().iter().map(|d| d.dot(axis));
    let best = along.enumerate().reduce(|best, next| if next.1 > best.1 { next } else { best });
    best.map_or(0, |(index, _)| index)
}

#[cfg(test)]
mod tests;
