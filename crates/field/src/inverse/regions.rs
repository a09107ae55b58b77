//! Where a model can be inverted without looking for a second answer: slopes over a grid of cells
//! of its box and neighbourhoods of its triangles.

use super::equations::AxisPose;
use super::nets::{Errors, Nets};
use super::slopes::Slopes;
use super::triangles::{Neighbour, Triangles};
use crate::{DistortionModel, OutsidePolicy};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use trackwright_geometry::bounds::Bounds;

/// Cells along each axis of the box: an eighth of it is about what a real field bends over.
const CELLS: usize = 8;

/// How far beyond its box, as a part of its size, an extrapolated model is looked at: poses
/// further away are not known to read differently.
pub(super) const EXTRAPOLATED: f64 = 0.25;

/// Contraction from which on an answer does not count as the only one. Below 1 by what round-off
/// could add to the bounds.
const CERTAIN: f64 = 1.0 - 1e-9;

/// Contraction from which on a search is not trusted to see every answer: in fits of order 4 that
/// their data do not determine one answer in five was missed from 600 on, up to 40 none was.
const STEEP: f64 = 32.0;

/// Turns of an axis from which on it is not either: where errors could turn by 60° or more, two
/// answers in 20,000 were missed.
const STEEP_TURN_RAD: f64 = 1.0;

/// Bounds of a model's slopes, everywhere or cell by cell.
#[derive(Clone, Debug)]
pub(super) struct Regions {
    /// All over the box and the sphere.
    pub everywhere: Slopes,
    /// What the error jumps by at most where an axis crosses from triangle to triangle, mm and
    /// radians; 0 for continuous weights.
    pub jump: [f64; 2],
    pub errors: Errors,
    cells: Option<Cells>,
}

/// Where answers to one reading can be.
#[derive(Clone, Debug)]
pub(super) struct Possible {
    /// Middles of the cells that can hold one; none where one is certain.
    pub starts: Vec<Point3<f64>>,
    /// Bounds of the slopes between any two of them.
    pub slopes: Slopes,
    /// What the error jumps by at most between triangles there, mm and radians.
    pub jump: [f64; 2],
    /// The farthest that an error turns an axis in them.
    pub largest_rad: f64,
}

impl Possible {
    /// Whether there can be one answer at most.
    pub fn is_certain(&self) -> bool {
        self.slopes.contraction() < CERTAIN
    }

    /// Whether the field is too steep for a search from one start a cell to see every answer.
    pub fn is_too_steep(&self) -> bool {
        !self.is_certain()
            && (self.slopes.contraction() > STEEP || self.largest_rad > STEEP_TURN_RAD)
    }
}

impl Regions {
    pub fn of(model: &DistortionModel, outside: OutsidePolicy) -> Self {
        let mut regions = Self {
            everywhere: Slopes::default(),
            jump: [0.0; 2],
            errors: Errors::of(&[]),
            cells: None,
        };
        // Where errors are made of coils' fields, other answers are looked for by these.
        if model.is_zero() || model.computed().is_some_and(|field| field.coils().is_some()) {
            return regions;
        }
        let (whole, bounds) = if outside == OutsidePolicy::Extrapolate {
            ([-EXTRAPOLATED, 1.0 + EXTRAPOLATED], model.bounds().grown(EXTRAPOLATED))
        } else {
            ([0.0, 1.0], *model.bounds())
        };
        let triangles = Triangles::of(model);
        let over = Part::of(model, &triangles, [whole; 3], &bounds.size_mm());
        regions.errors = over.errors;
        regions.everywhere = over.slopes.into_iter().reduce(Slopes::max).unwrap_or_default();
        regions.jump = over.jump;
        if regions.everywhere.contraction() >= CERTAIN {
            let is_clamped = outside != OutsidePolicy::Extrapolate;
            regions.cells = Some(Cells::of(model, &triangles, whole, &bounds, is_clamped));
        }
        regions
    }

    /// Whether any reading has one answer at most.
    pub fn is_certain_everywhere(&self) -> bool {
        self.cells.is_none()
    }

    /// Where answers to a reading can be; nothing is listed where one is certain everywhere.
    ///
    /// `cells` is a buffer.
    pub fn possible(
        &self,
        reading: &AxisPose,
        triangle: usize,
        cells: &mut Vec<usize>,
    ) -> Possible {
        match &self.cells {
            Some(all) => all.possible(reading, triangle, cells),
            None => self.anywhere(),
        }
    }

    /// What holds for every reading.
    pub fn anywhere(&self) -> Possible {
        Possible {
            starts: Vec::new(),
            slopes: self.everywhere,
            jump: self.jump,
            largest_rad: self.errors.largest_rad,
        }
    }
}

/// Bounds cell by cell.
#[derive(Clone, Debug)]
struct Cells {
    bounds: Bounds,
    /// x slowest.
    cells: Vec<Cell>,
    /// Of each triangle, the others by how far they are from it, itself first.
    neighbours: Vec<Vec<Neighbour>>,
    /// Cells that can be read in each cell, so that not all have to be searched.
    sources: Vec<Vec<usize>>,
}

#[derive(Clone, Debug)]
struct Cell {
    /// The readings that can come from here.
    readings: Bounds,
    largest_rad: f64,
    jump: [f64; 2],
    /// Of each triangle.
    slopes: Vec<Slopes>,
}

/// What is known of a model over a part of its box.
struct Part {
    errors: Errors,
    jump: [f64; 2],
    /// Of each triangle.
    slopes: Vec<Slopes>,
}

impl Part {
    fn of(
        model: &DistortionModel,
        triangles: &Triangles,
        intervals: [[f64; 2]; 3],
        size_mm: &Vector3<f64>,
    ) -> Self {
        if let Some(computed) = model.computed() {
            let over = computed.bounds_over(intervals);
            return Self {
                errors: Errors {
                    least_mm: over.least_mm,
                    largest_mm: over.largest_mm,
                    largest_rad: over.largest_rad,
                },
                jump: [0.0; 2],
                slopes: vec![Slopes {
                    pp: over.by_position[0],
                    pn: over.by_axis[0],
                    np: over.by_position[1],
                    nn: over.by_axis[1],
                }],
            };
        }
        let nets = Nets::of(model, intervals);
        Self {
            errors: nets.errors(),
            jump: triangles.jump(&nets),
            slopes: nets.all_slopes(triangles, size_mm),
        }
    }
}

impl Cells {
    fn of(
        model: &DistortionModel,
        triangles: &Triangles,
        [low, high]: [f64; 2],
        bounds: &Bounds,
        is_clamped: bool,
    ) -> Self {
        let part = |index: usize| low + (high - low) * index as f64 / CELLS as f64;
        let cell_size_mm = bounds.size_mm() / CELLS as f64;
        let cells: Vec<Cell> = (0..CELLS.pow(3))
            .into_par_iter()
            .map(|cell| {
                let place = coordinates(cell);
                let intervals = place.map(|k| [part(k), part(k + 1)]);
                let over = Part::of(model, triangles, intervals, &cell_size_mm);
                let errors = over.errors;
                // Positions outside are clamped to the cells at the sides.
                let side = |k: usize, at_end: bool, value: f64| match (is_clamped, at_end) {
                    (true, true) => value * f64::INFINITY,
                    _ => {
                        bounds.min_mm[k]
                            + (place[k] as f64 + f64::from(value > 0.0)) * cell_size_mm[k]
                    }
                };
                let min_mm = Point3::from(Vector3::from_fn(|k, _| side(k, place[k] == 0, -1.0)));
                let max_mm =
                    Point3::from(Vector3::from_fn(|k, _| side(k, place[k] + 1 == CELLS, 1.0)));
                // A hair wider than the bounds, so that round-off cuts nothing off.
                let hair = (bounds.diagonal_mm() + bounds.min_mm.coords.amax()) * 1e-12;
                Cell {
                    readings: Bounds {
                        min_mm: min_mm + errors.least_mm - Vector3::repeat(hair),
                        max_mm: max_mm + errors.largest_mm + Vector3::repeat(hair),
                    },
                    largest_rad: errors.largest_rad,
                    jump: over.jump,
                    slopes: over.slopes,
                }
            })
            .collect();
        let corner = |place: [usize; 3]| {
            bounds.min_mm + Vector3::from_fn(|k, _| place[k] as f64 * cell_size_mm[k])
        };
        let sources = (0..cells.len())
            .map(|into| {
                let place = coordinates(into);
                let mut target =
                    Bounds { min_mm: corner(place), max_mm: corner(place.map(|k| k + 1)) };
                // Readings beyond the box are looked up at its sides.
                for (k, &index) in place.iter().enumerate() {
                    if index == 0 {
                        target.min_mm[k] = f64::NEG_INFINITY;
                    }
                    if index + 1 == CELLS {
                        target.max_mm[k] = f64::INFINITY;
                    }
                }
                let overlaps = |b: &Bounds| {
                    (0..3)
                        .all(|k| b.min_mm[k] <= target.max_mm[k] && target.min_mm[k] <= b.max_mm[k])
                };
                (0..cells.len()).filter(|&c| overlaps(&cells[c].readings)).collect()
            })
            .collect();
        Self { bounds: *bounds, cells, neighbours: triangles.neighbours(), sources }
    }

    fn possible(&self, reading: &AxisPose, triangle: usize, kept: &mut Vec<usize>) -> Possible {
        let unit = self.bounds.to_unit(&reading.position_mm);
        let here =
            [0, 1, 2].map(|k| (unit[k] * CELLS as f64).clamp(0.0, CELLS as f64 - 1.0) as usize);
        let p = &reading.position_mm;
        kept.clear();
        let (mut first, mut last) = ([CELLS; 3], [0; 3]);
        let mut largest_rad = 0.0_f64;
        for &cell in &self.sources[index(here)] {
            let readings = &self.cells[cell].readings;
            if !(0..3).all(|k| readings.min_mm[k] <= p[k] && p[k] <= readings.max_mm[k]) {
                continue;
            }
            kept.push(cell);
            largest_rad = largest_rad.max(self.cells[cell].largest_rad);
            let place = coordinates(cell);
            for k in 0..3 {
                first[k] = first[k].min(place[k]);
                last[k] = last[k].max(place[k]);
            }
        }
        // Between two answers lies nothing outside the box around their cells, and no axis outside
        // the cap around the reading's, if that is no more than half of the triangles.
        let cap_rad = if largest_rad < std::f64::consts::FRAC_PI_2 {
            largest_rad
        } else {
            std::f64::consts::PI
        };
        let near = self.neighbours[triangle]
            .iter()
            .take_while(|n| n.apart_rad <= cap_rad)
            .map(|n| n.triangle);
        let mut slopes = Slopes::default();
        let mut jump = [0.0_f64; 2];
        for x in first[0]..=last[0] {
            for y in first[1]..=last[1] {
                for z in first[2]..=last[2] {
                    let own = &self.cells[index([x, y, z])];
                    slopes = near.clone().map(|t| own.slopes[t]).fold(slopes, Slopes::max);
                    for (jump, own) in jump.iter_mut().zip(own.jump) {
                        *jump = jump.max(own);
                    }
                }
            }
        }
        let size_mm = self.bounds.size_mm() / CELLS as f64;
        let middle = |cell: usize| {
            let place = coordinates(cell);
            self.bounds.min_mm + Vector3::from_fn(|k, _| (place[k] as f64 + 0.5) * size_mm[k])
        };
        let mut possible = Possible { starts: Vec::new(), slopes, jump, largest_rad };
        if !possible.is_certain() && !possible.is_too_steep() {
            possible.starts = kept.iter().copied().map(middle).collect();
        }
        possible
    }
}

fn coordinates(cell: usize) -> [usize; 3] {
    [cell / CELLS.pow(2), cell / CELLS % CELLS, cell % CELLS]
}

fn index([x, y, z]: [usize; 3]) -> usize {
    (x * CELLS + y) * CELLS + z
}
