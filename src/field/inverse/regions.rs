//! Where a model can be inverted without looking for a second answer: slopes over a grid of cells
//! of its box and neighbourhoods of its triangles.

use super::equations::Place;
use super::slopes::{Slopes, by_axis, by_position, largest_differences, steepest_weights};
use crate::field::bernstein::MAX_ORDER;
use crate::field::model::Coefficient;
use crate::field::{DistortionModel, OutsidePolicy};
use crate::geometry::bounds::Bounds;
use crate::geometry::directions::{DirectionSet, Weighting};
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;

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

/// What the coefficients say that errors lie between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errors {
    pub least_mm: Vector3<f64>,
    pub largest_mm: Vector3<f64>,
    pub largest_rad: f64,
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
        if model.order() == 0 {
            return regions;
        }
        let (whole, bounds) = if outside == OutsidePolicy::Extrapolate {
            (
                [-EXTRAPOLATED, 1.0 + EXTRAPOLATED],
                grown(model.bounds(), EXTRAPOLATED),
            )
        } else {
            ([0.0, 1.0], *model.bounds())
        };
        let sphere = Sphere::of(model);
        let nets = Nets::of(model, [whole; 3]);
        regions.errors = nets.errors();
        regions.everywhere = nets
            .all_slopes(&sphere, &bounds.size_mm())
            .into_iter()
            .reduce(Slopes::max)
            .unwrap_or_default();
        regions.jump = sphere.jump(&nets);
        if regions.everywhere.contraction() >= CERTAIN {
            let is_clamped = outside != OutsidePolicy::Extrapolate;
            regions.cells = Some(Cells::of(model, &sphere, whole, &bounds, is_clamped));
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
    pub fn possible(&self, reading: &Place, triangle: usize, cells: &mut Vec<usize>) -> Possible {
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

impl Errors {
    fn of(coefficients: &[Coefficient]) -> Self {
        let mut errors = Self {
            least_mm: Vector3::zeros(),
            largest_mm: Vector3::zeros(),
            largest_rad: 0.0,
        };
        if let Some(first) = coefficients.first() {
            errors.least_mm = Vector3::new(first[0], first[1], first[2]);
            errors.largest_mm = errors.least_mm;
        }
        for c in coefficients {
            let position = Vector3::new(c[0], c[1], c[2]);
            errors.least_mm = errors.least_mm.inf(&position);
            errors.largest_mm = errors.largest_mm.sup(&position);
            errors.largest_rad = errors
                .largest_rad
                .max(Vector3::new(c[3], c[4], c[5]).norm());
        }
        errors
    }

    fn hull(self, other: Self) -> Self {
        Self {
            least_mm: self.least_mm.inf(&other.least_mm),
            largest_mm: self.largest_mm.sup(&other.largest_mm),
            largest_rad: self.largest_rad.max(other.largest_rad),
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
    /// Cells that can be read in each cell, so that not all have to be asked.
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

#[derive(Clone, Copy, Debug)]
struct Neighbour {
    triangle: usize,
    /// No axes of the two are closer.
    apart_rad: f64,
}

impl Cells {
    fn of(
        model: &DistortionModel,
        sphere: &Sphere,
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
                let nets = Nets::of(model, place.map(|k| [part(k), part(k + 1)]));
                let errors = nets.errors();
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
                    jump: sphere.jump(&nets),
                    slopes: nets.all_slopes(sphere, &cell_size_mm),
                }
            })
            .collect();
        let corner = |place: [usize; 3]| {
            bounds.min_mm + Vector3::from_fn(|k, _| place[k] as f64 * cell_size_mm[k])
        };
        let sources = (0..cells.len())
            .map(|into| {
                let place = coordinates(into);
                let mut target = Bounds {
                    min_mm: corner(place),
                    max_mm: corner(place.map(|k| k + 1)),
                };
                // Readings beyond the box are looked up at its sides.
                for k in 0..3 {
                    if place[k] == 0 {
                        target.min_mm[k] = f64::NEG_INFINITY;
                    }
                    if place[k] + 1 == CELLS {
                        target.max_mm[k] = f64::INFINITY;
                    }
                }
                let overlaps = |b: &Bounds| {
                    (0..3)
                        .all(|k| b.min_mm[k] <= target.max_mm[k] && target.min_mm[k] <= b.max_mm[k])
                };
                (0..cells.len())
                    .filter(|&c| overlaps(&cells[c].readings))
                    .collect()
            })
            .collect();
        Self {
            bounds: *bounds,
            cells,
            neighbours: sphere.neighbours(),
            sources,
        }
    }

    fn possible(&self, reading: &Place, triangle: usize, kept: &mut Vec<usize>) -> Possible {
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
        // the cap around the reading's, if that is no more than half of the sphere.
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
                    slopes = near
                        .clone()
                        .map(|t| own.slopes[t])
                        .fold(slopes, Slopes::max);
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
        let mut possible = Possible {
            starts: Vec::new(),
            slopes,
            jump,
            largest_rad,
        };
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

/// A model's triangles and how steep weights are in them; for the set of one, a single triangle
/// in which nothing changes.
struct Sphere {
    set: DirectionSet,
    triangles: Vec<[usize; 3]>,
    steepest: Vec<[f64; 3]>,
    /// Ends of edges across which weights jump, and by how much.
    jumps: Vec<([usize; 2], f64)>,
}

impl Sphere {
    fn of(model: &DistortionModel) -> Self {
        let set = model.directions();
        if set == DirectionSet::One {
            return Self {
                set,
                triangles: vec![[0; 3]],
                steepest: vec![[0.0; 3]],
                jumps: Vec::new(),
            };
        }
        let triangles = set.triangles().to_vec();
        let steepest = triangles
            .iter()
            .map(|t| steepest_weights(&corners(set, t), model.weighting()))
            .collect();
        Self {
            set,
            jumps: match model.weighting() {
                Weighting::Area => weight_jumps(set),
                Weighting::Gnomonic => Vec::new(),
            },
            triangles,
            steepest,
        }
    }

    /// The largest jump of the error across any edge, mm and radians.
    fn jump(&self, nets: &Nets) -> [f64; 2] {
        let mut largest = [0.0_f64; 2];
        for ([a, b], weight) in &self.jumps {
            let apart = largest_differences(&nets.of_direction[*a], &nets.of_direction[*b]);
            for (largest, apart) in largest.iter_mut().zip(apart) {
                *largest = largest.max(weight * apart);
            }
        }
        largest
    }

    /// Of each triangle, all by how far they are from it at least, itself first.
    fn neighbours(&self) -> Vec<Vec<Neighbour>> {
        let caps: Vec<_> = self
            .triangles
            .iter()
            .map(|t| {
                let corners = corners(self.set, t);
                let middle = Unit::new_normalize(corners.iter().sum::<Vector3<f64>>());
                let radius = corners.iter().map(|c| middle.angle(c)).fold(0.0, f64::max);
                (middle, radius)
            })
            .collect();
        caps.iter()
            .map(|(middle, radius)| {
                let mut neighbours: Vec<_> = caps
                    .iter()
                    .enumerate()
                    .map(|(triangle, (other, other_radius))| Neighbour {
                        triangle,
                        // Less by a margin far above round-off and far below a triangle.
                        apart_rad: middle.angle(other) - radius - other_radius - 1e-6,
                    })
                    .collect();
                neighbours.sort_by(|a, b| a.apart_rad.total_cmp(&b.apart_rad));
                neighbours
            })
            .collect()
    }
}

fn corners(set: DirectionSet, triangle: &[usize; 3]) -> [Vector3<f64>; 3] {
    triangle.map(|d| set.directions()[d].into_inner())
}

/// The coefficients of all orientations over a part of the box.
struct Nets {
    order: usize,
    of_direction: Vec<Vec<Coefficient>>,
}

impl Nets {
    /// Over the given interval of each unit coordinate.
    fn of(model: &DistortionModel, intervals: [[f64; 2]; 3]) -> Self {
        let order = model.order();
        let n = order + 1;
        let restrictions = intervals.map(|interval| restriction(order, interval));
        let of_direction = (0..model.directions().len())
            .map(|d| {
                let mut net = model.of_direction(d).to_vec();
                for (axis, rows) in restrictions.iter().enumerate() {
                    net = along(&net, n, n.pow(2 - axis as u32), rows);
                }
                net
            })
            .collect();
        Self {
            order,
            of_direction,
        }
    }

    fn errors(&self) -> Errors {
        let each = self.of_direction.iter().map(|net| Errors::of(net));
        each.reduce(Errors::hull).unwrap_or(Errors::of(&[]))
    }

    /// Of each triangle.
    fn all_slopes(&self, sphere: &Sphere, size_mm: &Vector3<f64>) -> Vec<Slopes> {
        let positions: Vec<_> = self
            .of_direction
            .iter()
            .map(|net| by_position(net, self.order, size_mm))
            .collect();
        sphere
            .triangles
            .iter()
            .zip(&sphere.steepest)
            .map(|(t, steepest)| {
                let nets = t.map(|d| self.of_direction[d].as_slice());
                let [pn, nn] = by_axis(nets, steepest);
                let largest =
                    |half: usize| t.iter().map(|&d| positions[d][half]).fold(0.0, f64::max);
                Slopes {
                    pp: largest(0),
                    pn,
                    np: largest(1),
                    nn,
                }
            })
            .collect()
    }
}

type Rows = [[f64; MAX_ORDER + 1]; MAX_ORDER + 1];

/// What takes coefficients over `[0, 1]` to those over an interval: row i is the polar form at
/// `n - i` times the lower end and `i` times the upper.
fn restriction(order: usize, [low, high]: [f64; 2]) -> Rows {
    let mut rows = [[0.0; MAX_ORDER + 1]; MAX_ORDER + 1];
    for column in 0..=order {
        for i in 0..=order {
            let mut values = [0.0; MAX_ORDER + 1];
            values[column] = 1.0;
            for step in 0..order {
                let t = if step < order - i { low } else { high };
                for k in 0..order - step {
                    values[k] = (1.0 - t) * values[k] + t * values[k + 1];
                }
            }
            rows[i][column] = values[0];
        }
    }
    rows
}

/// Applies a restriction along the axis whose neighbours are `stride` apart.
fn along(net: &[Coefficient], n: usize, stride: usize, rows: &Rows) -> Vec<Coefficient> {
    let mut out = vec![[0.0; 6]; net.len()];
    for (index, out) in out.iter_mut().enumerate() {
        let i = index / stride % n;
        let start = index - i * stride;
        for (column, factor) in rows[i][..n].iter().enumerate() {
            for (sum, value) in out.iter_mut().zip(&net[start + column * stride]) {
                *sum += factor * value;
            }
        }
    }
    out
}

fn grown(bounds: &Bounds, margin: f64) -> Bounds {
    let by = bounds.size_mm() * margin;
    Bounds {
        min_mm: bounds.min_mm - by,
        max_mm: bounds.max_mm + by,
    }
}

/// Steps along an edge at which the jump of its weights is looked at, and what it may exceed the
/// largest of them by.
const EDGE_STEPS: usize = 48;
const BETWEEN_EDGE_STEPS: f64 = 0.05;

/// Jumps of weights below this are round-off of weights that are continuous.
const NO_JUMP: f64 = 1e-12;

/// Edges across which area weights jump.
fn weight_jumps(set: DirectionSet) -> Vec<([usize; 2], f64)> {
    let triangles = set.triangles();
    let mut jumps = Vec::new();
    for (first, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
            // The neighbour has the edge the other way round.
            let other = triangles[..first].iter().find_map(|o| {
                let m = (0..3).find(|&m| o[m] == b && o[(m + 1) % 3] == a)?;
                Some(o[(m + 2) % 3])
            });
            if let Some(d) = other {
                let weight = weight_jump([a, b, c, d].map(|i| set.directions()[i].into_inner()));
                if weight > NO_JUMP {
                    jumps.push(([a, b], weight));
                }
            }
        }
    }
    jumps
}

/// The largest difference along the edge from `a` to `b` between the weight of `a` in the triangle
/// with `c` and in that with `d`.
fn weight_jump([a, b, c, d]: [Vector3<f64>; 4]) -> f64 {
    let half_area = |n: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>| {
        n.dot(&b.cross(c))
            .abs()
            .atan2(1.0 + n.dot(b) + b.dot(c) + c.dot(n))
    };
    let weight = |n: &Vector3<f64>, third: &Vector3<f64>| {
        let (of_a, of_b) = (half_area(n, &b, third), half_area(n, &a, third));
        of_a / (of_a + of_b)
    };
    let largest = (0..=EDGE_STEPS)
        .map(|i| {
            let t = i as f64 / EDGE_STEPS as f64;
            let n = (a * (1.0 - t) + b * t).normalize();
            (weight(&n, &c) - weight(&n, &d)).abs()
        })
        .fold(0.0, f64::max);
    largest * (1.0 + BETWEEN_EDGE_STEPS)
}
