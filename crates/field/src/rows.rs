//! Samples as rows of least-squares systems, made on the fly, eight side by side.
//!
//! Samples are sorted by the triangle of basis orientations that holds their axis: a system takes
//! the triangles it needs and never looks at the others.

use super::bernstein::{MAX_ORDER, coefficient_count};
use super::joint::face_blocks;
use super::least_squares::{LANES, Lanes, LeastSquares, Triangle, VALUES};
use super::samples::Sample;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_task::{Cancelled, Task};

/// Rows that one thread reduces at a time; fixed, so that no result depends on how many threads
/// there are. Merging costs less than a hundredth of it from here on.
const CHUNK_ROWS: usize = 16_384;

/// The same, in multiples of the unknowns.
const CHUNK_PER_UNKNOWN: usize = 32;

/// Rows between two looks at whether to go on: some milliseconds at order 4.
const ROWS_PER_STEP: usize = 1024;

/// Samples with their weights, sorted by triangle.
pub struct Rows<'a> {
    samples: &'a [Sample],
    order: usize,
    bounds: Bounds,
    weights: Vec<[f64; 3]>,
    /// Places of the samples, triangle after triangle, in their own order within each.
    places: Vec<u32>,
    pub faces: Vec<Face>,
}

/// A triangle of basis orientations and its samples.
#[derive(Clone, Debug)]
pub struct Face {
    corners: [usize; 3],
    /// The corners in the order of [`face_blocks`], as places in `corners`.
    order: [usize; 3],
    range: Range<usize>,
}

/// Which column blocks a row has: one of a corner, or one of each.
#[derive(Clone, Copy)]
enum Columns {
    Corner(usize),
    Corners([usize; 3]),
}

/// Samples of a face, seen from one system.
type Piece = (Columns, Range<usize>);

/// What [`Rows`] cannot hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} samples, expected fewer than {max}", max = u32::MAX)]
pub struct TooManySamples(pub usize);

/// Progress of work that several threads share.
pub struct Progress<'a> {
    task: &'a Task,
    done: AtomicUsize,
    all: usize,
}

impl<'a> Progress<'a> {
    pub fn new(task: &'a Task, all: usize) -> Self {
        Self { task, done: AtomicUsize::new(0), all }
    }

    /// The same cancel token, without a listener.
    pub fn quiet(&self) -> Task {
        Task::cancelled_by(self.task.cancel.clone())
    }

    /// More is done.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn add(&self, done: usize) -> Result<(), Cancelled> {
        let before = self.done.fetch_add(done, Ordering::Relaxed);
        self.task.step((before + done).min(self.all), self.all)
    }
}

impl<'a> Rows<'a> {
    /// Finds the triangle and the weights of every sample.
    ///
    /// # Errors
    /// [`TooManySamples`].
    pub fn new(
        samples: &'a [Sample],
        order: usize,
        set: DirectionSet,
        weighting: Weighting,
        bounds: &Bounds,
    ) -> Result<Self, TooManySamples> {
        let count = u32::try_from(samples.len()).map_err(|_| TooManySamples(samples.len()))?;
        let (corners, face_of) = faces_of(set);
        let mut weights = vec![[0.0; 3]; samples.len()];
        let mut faces = vec![0_u8; samples.len()];
        (weights.par_iter_mut(), faces.par_iter_mut(), samples).into_par_iter().for_each(
            |(weights, face, sample)| {
                let found = set.weights(&sample.axis, weighting);
                let [a, b, _] = found.directions;
                (*weights, *face) = (found.weights, face_of[a * set.len() + b]);
            },
        );
        let mut ends = vec![0; corners.len() + 1];
        for &face in &faces {
            ends[usize::from(face) + 1] += 1;
        }
        for i in 1..ends.len() {
            ends[i] += ends[i - 1];
        }
        let ranges: Vec<_> = ends.windows(2).map(|w| w[0]..w[1]).collect();
        let mut places = vec![0; samples.len()];
        for (place, &face) in (0..count).zip(&faces) {
            let next = &mut ends[usize::from(face)];
            places[*next] = place;
            *next += 1;
        }
        Ok(Self {
            samples,
            order,
            bounds: *bounds,
            weights,
            places,
            faces: corners
                .into_iter()
                .zip(ranges)
                .zip(face_blocks(set))
                .map(|((corners, range), blocks)| Face {
                    corners,
                    order: std::array::from_fn(|b| {
                        corners.iter().position(|c| blocks.get(b) == Some(c)).unwrap_or_default()
                    }),
                    range,
                })
                .collect(),
        })
    }

    /// Rows of all per-direction systems together, those of weight 0 counted too.
    pub fn count_each_direction(&self) -> usize {
        self.faces.iter().map(|face| distinct(face.corners) * face.range.len()).sum()
    }

    /// Rows of all faces together.
    pub fn count(&self) -> usize {
        self.samples.len()
    }

    /// The system of one basis orientation: rows of positive weight on it, scaled by it.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn of_direction(
        &self,
        direction: usize,
        progress: &Progress<'_>,
    ) -> Result<Triangle, Cancelled> {
        let pieces = self.faces.iter().filter_map(|face| {
            let corner = face.corners.iter().position(|&c| c == direction)?;
            Some((Columns::Corner(corner), face.range.clone()))
        });
        self.reduce(coefficient_count(self.order), pieces.collect(), progress)
    }

    /// The system of one face: the coefficients of its three corners in the order of
    /// [`face_blocks`], each block scaled by the corner's weight. A set of one orientation has one block.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn of_face(&self, face: &Face, progress: &Progress<'_>) -> Result<Triangle, Cancelled> {
        let blocks = distinct(face.corners);
        let columns = match blocks {
            1 => Columns::Corner(0),
            _ => Columns::Corners(face.order),
        };
        self.reduce(
            blocks * coefficient_count(self.order),
            vec![(columns, face.range.clone())],
            progress,
        )
    }

    fn reduce(
        &self,
        unknowns: usize,
        pieces: Vec<Piece>,
        progress: &Progress<'_>,
    ) -> Result<Triangle, Cancelled> {
        let size = CHUNK_ROWS.max(CHUNK_PER_UNKNOWN * unknowns);
        let parts: Vec<Triangle> = chunks(pieces, size)
            .into_par_iter()
            .map(|chunk| {
                let mut system = LeastSquares::new(unknowns);
                for (columns, range) in chunk {
                    for places in self.places[range].chunks(ROWS_PER_STEP) {
                        self.push(&mut system, columns, places);
                        progress.add(places.len())?;
                    }
                }
                Ok(system.into_triangle())
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(Triangle::merged(&parts).unwrap_or_else(|| LeastSquares::new(unknowns).into_triangle()))
    }

    fn push(&self, system: &mut LeastSquares, columns: Columns, places: &[u32]) {
        let mut counted =
            places.iter().map(|&place| place as usize).filter(|&place| match columns {
                Columns::Corner(corner) => self.weights[place][corner] > 0.0,
                Columns::Corners(_) => true,
            });
        loop {
            let mut group = [0; LANES];
            let mut count = 0;
            for (slot, place) in group.iter_mut().zip(&mut counted) {
                *slot = place;
                count += 1;
            }
            if count == 0 {
                break;
            }
            // Lanes without a sample repeat the first; they are never counted as rows.
            let first = group[0];
            group[count..].fill(first);
            system.push_lanes(count, |lanes| self.fill(lanes, columns, &group));
        }
    }

    fn fill(&self, lanes: &mut Lanes<'_>, columns: Columns, group: &[usize; LANES]) {
        let (mut units, mut columns_of_values) = ([[0.0; LANES]; 3], [[0.0; LANES]; VALUES]);
        let mut weights = [[0.0; LANES]; 3];
        for (l, &i) in group.iter().enumerate() {
            let sample = &self.samples[i];
            let unit = self.bounds.to_unit(&sample.position_mm);
            for k in 0..3 {
                units[k][l] = unit[k];
                weights[k][l] = self.weights[i][k];
                columns_of_values[k][l] = sample.error.position_mm[k];
                columns_of_values[k + 3][l] = sample.error.rotation_rad[k];
            }
        }
        let [bx, by, bz] = units.each_ref().map(|unit| bases(self.order, unit));
        let n = self.order;
        let mut push_block = |weights: &[f64; LANES]| {
            for x in &bx[..=n] {
                let scaled = product(weights, x);
                for y in &by[..=n] {
                    let plane = product(&scaled, y);
                    for z in &bz[..=n] {
                        lanes.push(&product(&plane, z));
                    }
                }
            }
        };
        let scale = match columns {
            Columns::Corner(corner) => {
                push_block(&weights[corner]);
                weights[corner]
            }
            Columns::Corners(order) => {
                order.iter().for_each(|&corner| push_block(&weights[corner]));
                [1.0; LANES]
            }
        };
        for values in &columns_of_values {
            lanes.push(&product(&scale, values));
        }
    }
}

#[inline(always)]
fn product(a: &[f64; LANES], b: &[f64; LANES]) -> [f64; LANES] {
    let mut out = *a;
    for (out, b) in out.iter_mut().zip(b) {
        *out *= b;
    }
    out
}

/// [`super::bernstein::basis`] for several places at once, step by step the same.
fn bases(order: usize, x: &[f64; LANES]) -> [[f64; LANES]; MAX_ORDER + 1] {
    let mut b = [[0.0; LANES]; MAX_ORDER + 1];
    b[0] = [1.0; LANES];
    for n in 1..=order {
        let mut carried = [0.0; LANES];
        for value in &mut b[..n] {
            for l in 0..LANES {
                let old = value[l];
                value[l] = carried[l] + (1.0 - x[l]) * old;
                carried[l] = x[l] * old;
            }
        }
        b[n] = carried;
    }
    b
}

/// How many of a face's corners are different orientations: three, or one in the set of one.
fn distinct(corners: [usize; 3]) -> usize {
    if corners[0] == corners[1] { 1 } else { 3 }
}

/// The faces of a set, and the face of each pair of first corners (`first · len + second`): faces
/// are counter-clockwise, so that no two share such a pair.
fn faces_of(set: DirectionSet) -> (Vec<[usize; 3]>, Vec<u8>) {
    if set == DirectionSet::One {
        return (vec![[0; 3]], vec![0]);
    }
    let corners = set.triangles().to_vec();
    let mut face_of = vec![0; set.len() * set.len()];
    for (face, &[a, b, _]) in (0..).zip(&corners) {
        face_of[a * set.len() + b] = face;
    }
    (corners, face_of)
}

/// Cuts pieces into chunks of at most `size` samples.
fn chunks(pieces: Vec<Piece>, size: usize) -> Vec<Vec<Piece>> {
    let mut chunks = vec![Vec::new()];
    let mut room = size;
    for (columns, mut range) in pieces {
        while !range.is_empty() {
            if room == 0 {
                chunks.push(Vec::new());
                room = size;
            }
            let taken = room.min(range.len());
            let middle = range.start + taken;
            if let Some(chunk) = chunks.last_mut() {
                chunk.push((columns, range.start..middle));
            }
            range.start = middle;
            room -= taken;
        }
    }
    chunks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bernstein::basis;
    use crate::samples::PoseError;
    use nalgebra::{Point3, Unit, Vector3};

    #[test]
    fn eight_bases_are_eight_times_one_basis() {
        let x = [0.0, 0.1, 0.3, 0.5, 0.77, 1.0, -0.2, 1.3];
        for order in 0..=MAX_ORDER {
            let side_by_side = bases(order, &x);
            for l in 0..LANES {
                let one = basis(order, x[l]);
                assert!((0..=order).all(|i| side_by_side[i][l] == one[i]));
            }
        }
    }

    #[test]
    fn chunks_keep_order_and_lose_nothing() {
        let pieces = vec![
            (Columns::Corner(0), 0..5),
            (Columns::Corner(2), 5..5),
            (Columns::Corner(1), 9..30),
        ];
        let cut = chunks(pieces, 8);
        let flat: Vec<_> = cut.iter().flatten().flat_map(|(_, r)| r.clone()).collect();
        assert_eq!(flat, (0..5).chain(9..30).collect::<Vec<_>>());
        assert!(cut.iter().all(|c| c.iter().map(|(_, r)| r.len()).sum::<usize>() <= 8));
    }

    #[test]
    fn samples_are_in_the_face_of_their_weights() {
        let samples: Vec<_> = (0..300)
            .map(|i| {
                let turn = f64::from(i);
                Sample::new(
                    Point3::new(turn.sin(), turn.cos(), 0.0),
                    Unit::new_normalize(Vector3::new(
                        (1.7 * turn).sin(),
                        (2.3 * turn).cos(),
                        (0.9 * turn).sin(),
                    )),
                    PoseError::default(),
                )
            })
            .collect();
        for set in DirectionSet::ALL {
            let bounds = Bounds::from(([-1.0; 3], [1.0; 3]));
            let rows = Rows::new(&samples, 1, set, Weighting::Area, &bounds).unwrap();
            let mut seen = 0;
            for face in &rows.faces {
                let mut last = None;
                for &place in &rows.places[face.range.clone()] {
                    let found = set.weights(&samples[place as usize].axis, Weighting::Area);
                    assert_eq!(found.directions, face.corners);
                    assert!(Some(place) > last, "samples keep their order");
                    last = Some(place);
                    seen += 1;
                }
            }
            assert_eq!(seen, samples.len());
        }
    }
}
