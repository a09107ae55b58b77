//! A room's box in cells, the smaller the more the metal's field varies: the fields in each, and where poses there are
//! read.

use crate::computed::DisturbedCoils;
use crate::generator::Generator;
use crate::generator::reading::axis_error;
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;

/// Cells along each side of the box before they are halved.
const CELLS: usize = 8;

/// Halvings of a cell: those of the tracker's cube are 1 mm wide then.
const MOST_HALVINGS: u32 = 6;

/// A cell is halved where the metal's field varies in it by more than this part of the coils' own, and half of it
/// by more than twice as much.
const VARIES: f64 = 0.01;

/// Halvings that are left where metal no longer hides between the places of a cell that are looked at: cells nearer to
/// metal than they are large are halved until then.
const FINE_HALVINGS: u32 = 3;

/// Poses of a cell may be read farther off than those in its middle, by this part of where these are read.
const BETWEEN: f64 = 2.0;

/// A part of the box, and what the coils' fields are in its middle.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    pub center_mm: Point3<f64>,
    pub size_mm: f64,
    pub fields: Vec<Vector3<f64>>,
    /// How each of them changes, a mm.
    pub slopes: Vec<Matrix3<f64>>,
    /// Where poses here are read.
    pub readings: Bounds,
}

/// All fields at a place; nothing in metal.
pub(super) fn fields(coils: &dyn DisturbedCoils, p: &Point3<f64>) -> Option<Vec<Vector3<f64>>> {
    let mut added = coils.disturbance(p)?;
    let own = coils.generator().own_fields(p);
    added.iter_mut().zip(own).for_each(|(added, own)| *added += own);
    Some(added)
}

fn apart(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum::<f64>().sqrt()
}

/// A place and all fields there; none in metal.
type Place = (Point3<f64>, Option<Vec<Vector3<f64>>>);

/// A cell, or its halves where the metal's field varies too much.
fn halve(
    coils: &dyn DisturbedCoils,
    (center_mm, there): Place,
    size_mm: Vector3<f64>,
    halvings: u32,
    found: &mut Vec<Cell>,
) {
    let half = |index: usize| -> Place {
        let side = |k: usize| if index >> k & 1 == 1 { 0.25 } else { -0.25 };
        let from_center = Vector3::new(side(0), side(1), side(2)).component_mul(&size_mm);
        let place = center_mm + from_center;
        (place, fields(coils, &place))
    };
    // Four halves no two of which are neighbours: their middles are the corners of a tetrahedron.
    const CORNERS: [usize; 4] = [0, 3, 5, 6];
    let corners = CORNERS.map(half);
    let own = coils.generator().own_fields(&center_mm);
    let whole = own.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
    let varies = VARIES * f64::from(1 << (MOST_HALVINGS - halvings)) * whole;
    let added = |place: &Place| {
        let fields = place.1.as_ref()?;
        let own = coils.generator().own_fields(&place.0);
        Some(fields.iter().zip(own).map(|(field, own)| field - own).collect::<Vec<_>>())
    };
    let center = (center_mm, there);
    let of_center = added(&center);
    let differs = |corner: &Place| match (&of_center, added(corner)) {
        (Some(center), Some(corner)) => apart(center, &corner) > varies,
        (None, None) => false,
        _ => true,
    };
    let may_hide_metal =
        halvings > FINE_HALVINGS && coils.metal_distance_mm(&center_mm) < size_mm.max();
    if !may_hide_metal && !corners.iter().any(differs) {
        if let Some(there) = center.1 {
            found.push(Cell::new(coils, center_mm, &size_mm, there, &corners));
        }
        return;
    }
    let others = [1, 2, 4, 7].map(half);
    if halvings > 1 {
        for place in corners.into_iter().chain(others) {
            halve(coils, place, size_mm / 2.0, halvings - 1, found);
        }
        return;
    }
    let all: Vec<Place> = corners.into_iter().chain(others).collect();
    for (place, fields) in &all {
        if let Some(fields) = fields {
            found.push(Cell::new(coils, *place, &(size_mm / 2.0), fields.clone(), &all));
        }
    }
}

impl Cell {
    /// Of a box.
    pub fn all(coils: &dyn DisturbedCoils, bounds: &Bounds) -> Vec<Self> {
        let size_mm = bounds.size_mm() / CELLS as f64;
        let cell = |index: usize| {
            let at = [index / (CELLS * CELLS), index / CELLS % CELLS, index % CELLS];
            let from_min = Vector3::from_fn(|k, _| (at[k] as f64 + 0.5) * size_mm[k]);
            let mut found = Vec::new();
            let center_mm = bounds.min_mm + from_min;
            let there = fields(coils, &center_mm);
            halve(coils, (center_mm, there), size_mm, MOST_HALVINGS, &mut found);
            found
        };
        (0..CELLS.pow(3)).into_par_iter().flat_map_iter(cell).collect()
    }

    /// `around` are places around its middle, or that of the cell that it is a half of.
    fn new(
        coils: &dyn DisturbedCoils,
        center_mm: Point3<f64>,
        size_mm: &Vector3<f64>,
        fields: Vec<Vector3<f64>>,
        around: &[Place],
    ) -> Self {
        let generator = coils.generator();
        let own = generator.own_fields(&center_mm);
        let added: Vec<_> = fields.iter().zip(own).map(|(field, own)| field - own).collect();
        let read_mm = |axis| {
            let error = axis_error(generator, &center_mm, axis, &added).ok()?;
            Some(center_mm + error.position_mm)
        };
        // An axis turned round has the same error. Where some are read far apart or not at all, others may be many times
        // as far off.
        let mut read: Vec<Option<_>> = DirectionSet::TwentySix.up_to_sign().map(read_mm).collect();
        let is_near = |b: &Bounds| b.size_mm().max() <= size_mm.max();
        let bounds = |read: &[Option<_>]| Bounds::around(read.iter().copied().flatten());
        if read.contains(&None) || !bounds(&read).is_some_and(|read| is_near(&read)) {
            read.extend(DirectionSet::FortyTwo.up_to_sign().map(read_mm));
        }
        let middle = Bounds { min_mm: center_mm, max_mm: center_mm };
        let readings = bounds(&read).map_or(middle, |read| {
            let more = read.size_mm() * BETWEEN + size_mm;
            Bounds { min_mm: read.min_mm - more, max_mm: read.max_mm + more }
        });
        let slopes = slopes(generator, &center_mm, &fields, around);
        Self { center_mm, size_mm: size_mm.max(), fields, slopes, readings }
    }
}

/// By least squares, from a place and others around it; those of the coils alone where metal leaves too few.
fn slopes(
    generator: &Generator,
    center_mm: &Point3<f64>,
    fields: &[Vector3<f64>],
    around: &[Place],
) -> Vec<Matrix3<f64>> {
    let steps =
        around.iter().filter_map(|(place, fields)| Some((place - center_mm, fields.as_ref()?)));
    let steps: Vec<_> = steps.collect();
    let squares: Matrix3<f64> = steps.iter().map(|(step, _)| step * step.transpose()).sum();
    let Some(inverse) = squares.try_inverse() else {
        let mut own = vec![(Vector3::zeros(), Matrix3::zeros()); fields.len()];
        generator.field_and_gradient(center_mm, &mut own);
        return own.into_iter().map(|(_, slope)| slope).collect();
    };
    let slope = |(coil, field): (usize, &Vector3<f64>)| {
        let each = steps.iter().map(|(step, there)| (there[coil] - field) * step.transpose());
        each.sum::<Matrix3<f64>>() * inverse
    };
    fields.iter().enumerate().map(slope).collect()
}
