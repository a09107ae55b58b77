//! Finds the spherical triangle of an axis by a table over the faces of a cube.
//!
//! An axis, scaled until its largest component is ±1, lies in a cell of a square grid on one face
//! of the cube. Each cell knows which triangles an axis in it can belong to, mostly one. Whether
//! an axis belongs to a triangle is decided by three linear forms, and a form that is negative at
//! all four corners of a cell is negative in all of it: leaving such triangles out is exact, and
//! the answer is that of a search through all triangles.

use nalgebra::{Matrix3, Vector3};
use pulp::Simd;

/// Cells along a face's edge. Of 16, 32 and 64 the fastest for 14 to 42 orientations: larger
/// tables leave fewer cells with two triangles, but do not stay in the nearest cache.
const CELLS: usize = 32;

/// Entries of the table: six faces, rounded up to a power of two so that a mask keeps any index in
/// it, even that of an axis that is not a number.
const TABLE: usize = 8192;

/// A triangle is left out where a form is below minus this at all corners of a cell, on the scale
/// of the cube. The forms are of size 1 and rounded to 1e-15; an axis belongs to a triangle down
/// to -1e-14.
const MARGIN: f64 = 1e-12;

/// Marks a table entry that points into the lists.
const IS_LIST: u16 = 0x8000;

/// Adding it to a whole number below 2^51 leaves the number in the low bits, and rounds others.
const MAGIC: f64 = 6_755_399_441_055_744.0;

/// The triangles of a set by cell.
pub(super) struct TriangleTable {
    /// A triangle, or where in `lists` the cell's list is.
    entries: Box<[u16; TABLE]>,
    /// Lists one after the other: length, then triangles in ascending order.
    lists: Vec<u8>,
}

/// What a cell yields for its axes.
pub(super) enum Candidates<'a> {
    One(usize),
    /// In ascending order.
    Several(&'a [u8]),
}

impl TriangleTable {
    /// From the matrices that take an axis to its coordinates in each triangle.
    pub fn new(forms: &[Matrix3<f64>]) -> Self {
        let mut entries = Box::new([0; TABLE]);
        let mut lists = Vec::new();
        for (cell, entry) in entries.iter_mut().enumerate().take(6 * CELLS * CELLS) {
            let corners = cell_corners(cell);
            let candidates: Vec<u8> = (0_u8..)
                .zip(forms)
                .filter(|(_, form)| {
                    let at_corners = corners.map(|c| *form * c);
                    (0..3).all(|row| at_corners.iter().any(|l| l[row] >= -MARGIN))
                })
                .map(|(triangle, _)| triangle)
                .collect();
            *entry = match candidates[..] {
                [only] => u16::from(only),
                _ => {
                    let start = u16::try_from(lists.len()).expect("some hundred short lists");
                    lists.push(candidates.len() as u8);
                    lists.extend(candidates);
                    IS_LIST | start
                }
            };
        }
        Self { entries, lists }
    }

    /// The triangles that axes with this code can belong to.
    #[inline(always)]
    pub fn candidates(&self, code: u64) -> Candidates<'_> {
        let entry = self.entries[code as usize % TABLE];
        if entry & IS_LIST == 0 {
            return Candidates::One(usize::from(entry));
        }
        let start = usize::from(entry & !IS_LIST);
        let len = usize::from(self.lists[start]);
        Candidates::Several(&self.lists[start + 1..][..len])
    }
}

/// The codes of axes, one a lane: the low bits index the table, the others mean nothing.
#[inline(always)]
pub(super) fn cell_codes<S: Simd>(simd: S, [x, y, z]: [S::f64s; 3]) -> S::u64s {
    let (ax, ay, az) = (simd.abs_f64s(x), simd.abs_f64s(y), simd.abs_f64s(z));
    let largest = simd.max_f64s(ax, simd.max_f64s(ay, az));
    let is_x = simd.greater_than_or_equal_f64s(ax, largest);
    let is_y = simd.greater_than_or_equal_f64s(ay, largest);
    let splat = |v| simd.splat_f64s(v);
    let major = simd.select_f64s(is_x, x, simd.select_f64s(is_y, y, z));
    let column = simd.select_f64s(is_x, y, x);
    let row = simd.select_f64s(is_x, z, simd.select_f64s(is_y, z, y));
    let face = simd.select_f64s(is_x, splat(0.0), simd.select_f64s(is_y, splat(2.0), splat(4.0)));
    let is_negative = simd.less_than_f64s(major, splat(0.0));
    let face = simd.add_f64s(face, simd.select_f64s(is_negative, splat(1.0), splat(0.0)));
    let half = CELLS as f64 / 2.0;
    let scale = simd.div_f64s(splat(half), largest);
    let cell = |v| {
        // Rounding to the nearest of what is lower by a half is rounding down.
        let place = simd.mul_add_e_f64s(v, scale, splat(half - 0.5));
        let place = simd.sub_f64s(simd.add_f64s(place, splat(MAGIC)), splat(MAGIC));
        simd.max_f64s(simd.min_f64s(place, splat(CELLS as f64 - 1.0)), splat(0.0))
    };
    let cells = splat(CELLS as f64);
    let code = simd.mul_add_e_f64s(face, cells, cell(row));
    let code = simd.mul_add_e_f64s(code, cells, cell(column));
    simd.transmute_u64s_f64s(simd.add_f64s(code, splat(MAGIC)))
}

/// The corners of a cell on the cube, in the order of [`cell_codes`].
fn cell_corners(cell: usize) -> [Vector3<f64>; 4] {
    let (column, row, face) = (cell % CELLS, cell / CELLS % CELLS, cell / CELLS / CELLS);
    let edge = |index: usize| index as f64 / (CELLS as f64 / 2.0) - 1.0;
    [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(a, b)| {
        let major = if face % 2 == 0 { 1.0 } else { -1.0 };
        let (column, row) = (edge(column + a), edge(row + b));
        match face / 2 {
            0 => Vector3::new(major, column, row),
            1 => Vector3::new(column, major, row),
            _ => Vector3::new(column, row, major),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::Scalar;

    fn code(v: Vector3<f64>) -> usize {
        cell_codes(Scalar::new(), v.into()) as usize % TABLE
    }

    #[test]
    fn the_middle_of_a_cell_has_its_code() {
        for cell in 0..6 * CELLS * CELLS {
            let middle = cell_corners(cell).iter().sum::<Vector3<f64>>() / 4.0;
            assert_eq!(code(middle * 0.37), cell);
        }
    }

    #[test]
    fn a_corner_is_in_a_cell_that_has_it() {
        for cell in 0..6 * CELLS * CELLS {
            for corner in cell_corners(cell) {
                let found = cell_corners(code(corner * 0.11));
                assert!(found.iter().any(|c| (c - corner).norm() < 1e-14), "{corner}");
            }
        }
    }

    #[test]
    fn nan_axes_stay_in_the_table() {
        let table = TriangleTable::new(&[Matrix3::identity()]);
        for v in [f64::NAN, f64::INFINITY, 0.0] {
            let code = cell_codes(Scalar::new(), [v, -v, 1.0]);
            // Any triangle will do; the weights are not numbers either.
            match table.candidates(code) {
                Candidates::One(triangle) => assert_eq!(triangle, 0),
                Candidates::Several(list) => assert!(list.iter().all(|&t| t == 0)),
            }
        }
    }
}
