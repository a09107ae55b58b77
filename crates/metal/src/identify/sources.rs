//! Compact bodies as sources: what they add to the rows, as dipoles or as spheres, and the slopes of it.

use super::rows::Rows;
use crate::body::{MetalBody, MetalShape};
use crate::material::Material;
use crate::room::{MetalRoom, PlacedBody};
use nalgebra::{DMatrix, Matrix3, Point3, Vector3};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::Arc;
use trackwright_field::generator::dipole::Dipole;
use trackwright_field::generator::{Coil, Generator};
use trackwright_geometry::pose::Pose;
use trackwright_task::Task;

/// Unknowns of a body: its middle, and the logarithm of its strength.
pub(super) const OF_BODY: usize = 4;

/// Steps of the slopes of spheres: of a middle in mm, and of a logarithm. What they leave out is a
/// thousandth where fields vary over 100 mm.
const STEP_MM: f64 = 0.1;
const STEP_LOG: f64 = 1e-3;

/// Frequency at which the two materials below are ideal: the skin of the conductor is 5 µm deep.
const IDEAL_HZ: f64 = 1e7;

/// Farther bodies are none: what they add is even over any tracker's volume.
const MAX_DISTANCE_MM: f64 = 5_000.0;

/// Least distance of a middle from a coil's. Nearer, it would stand for a coil that is not as known.
const MIN_FROM_COIL_MM: f64 = 20.0;

/// A compact body: where, and how much field it adds far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// In the tracker frame.
    pub center_mm: Point3<f64>,
    /// `f a³`: the induced dipole is so many times the field. Below zero for a conductor.
    pub strength_mm3: f64,
}

/// What bodies are modelled as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SourceModel {
    /// Induced dipoles, each in the fields of the coils alone.
    Dipoles,
    /// Spheres of the sources' radii, with all orders, each in the fields of the coils alone. What bodies of
    /// 4 radii from each other answer to one another is less than 1 % of that.
    Spheres,
    /// Bodies of any form: a dipole that depends on the field's direction, and the multipoles next to it.
    Multipoles,
}

impl Source {
    /// Radius of a sphere with this strength: one that no flux enters, or one of high permeability. A
    /// sphere of another material is larger.
    pub fn radius_mm(&self) -> f64 {
        radius_mm(self.strength_mm3)
    }

    /// In steps of the unknowns.
    pub(super) fn moved(&self, step: &[f64]) -> Self {
        Self {
            center_mm: self.center_mm + Vector3::new(step[0], step[1], step[2]),
            strength_mm3: self.strength_mm3 * step[3].clamp(-1.0, 1.0).exp(),
        }
    }
}

/// See [`Source::radius_mm`].
pub(super) fn radius_mm(strength_mm3: f64) -> f64 {
    let factor = if strength_mm3 < 0.0 { 0.5 } else { 1.0 };
    (strength_mm3.abs() / factor).cbrt()
}

/// Whether bodies can be there: no two in one another, none at a coil, none out of any reach.
pub(super) fn are_possible(rows: &Rows, sources: &[Source]) -> bool {
    let is_apart = |i: usize, j: usize| {
        let (a, b) = (&sources[i], &sources[j]);
        (a.center_mm - b.center_mm).norm() > a.radius_mm() + b.radius_mm()
    };
    let is_free = |source: &Source| {
        source.strength_mm3.is_finite()
            && source.center_mm.coords.norm() < MAX_DISTANCE_MM
            && rows.generator.coils.iter().all(|coil| {
                let (Coil::Dipole { at_mm, .. } | Coil::SquareLoop { center_mm: at_mm, .. }) = coil;
                let from_coil_mm = (source.center_mm - at_mm).norm();
                from_coil_mm > source.radius_mm().max(MIN_FROM_COIL_MM)
            })
    };
    sources.iter().all(is_free) && (0..sources.len()).all(|i| (0..i).all(|j| is_apart(i, j)))
}

impl SourceModel {
    /// What sources add to the rows; `None` where they cannot be.
    pub(super) fn explained(self, rows: &Rows, sources: &[Source]) -> Option<Vec<f64>> {
        if !are_possible(rows, sources) {
            return None;
        }
        match self {
            Self::Dipoles | Self::Multipoles => {
                let mut sum = vec![0.0; rows.right.len()];
                for source in sources {
                    let column = of_unit_dipole(rows, &source.center_mm);
                    for (sum, value) in sum.iter_mut().zip(column) {
                        *sum += source.strength_mm3 * value;
                    }
                }
                Some(sum)
            }
            Self::Spheres => {
                let mut sum = vec![0.0; rows.right.len()];
                for source in sources {
                    let column = of_sphere(rows, source)?;
                    for (sum, value) in sum.iter_mut().zip(column) {
                        *sum += value;
                    }
                }
                Some(sum)
            }
        }
    }

    /// Slopes of what sources add, [`OF_BODY`] columns a source.
    pub(super) fn slopes(self, rows: &Rows, sources: &[Source]) -> Option<DMatrix<f64>> {
        let mut slopes = DMatrix::zeros(rows.right.len(), OF_BODY * sources.len());
        for (body, source) in sources.iter().enumerate() {
            match self {
                Self::Dipoles | Self::Multipoles => dipole_slopes(rows, source, body, &mut slopes),
                Self::Spheres => {
                    let here = of_sphere(rows, source)?;
                    for unknown in 0..OF_BODY {
                        let size = if unknown < 3 { STEP_MM } else { STEP_LOG };
                        let mut step = [0.0; OF_BODY];
                        step[unknown] = size;
                        let moved = of_sphere(rows, &source.moved(&step))?;
                        let mut column = slopes.column_mut(OF_BODY * body + unknown);
                        for (slope, (new, old)) in column.iter_mut().zip(moved.iter().zip(&here)) {
                            *slope = (new - old) / size;
                        }
                    }
                }
            }
        }
        Some(slopes)
    }
}

/// What a sphere adds to the rows; `None` where it cannot be, or a measurement is in it.
fn of_sphere(rows: &Rows, source: &Source) -> Option<Vec<f64>> {
    let room = room(&rows.generator, source)?;
    rows.explained(|p, fields| room.disturbance(p, fields).is_ok())
}

/// What dipoles add to the field of every coil at a point.
pub(super) fn dipole_fields(
    generator: &Generator,
    sources: &[Source],
    p: &Point3<f64>,
    fields: &mut [Vector3<f64>],
) {
    for (field, coil) in fields.iter_mut().zip(&generator.coils) {
        let of_source = |source: &Source| {
            let moment = coil.field(&source.center_mm) * source.strength_mm3;
            Dipole::new(&source.center_mm, &moment).field(p)
        };
        *field = sources.iter().map(of_source).sum();
    }
}

/// The room of a sphere with the strength of a source; `None` where it cannot be.
pub(super) fn room(generator: &Generator, source: &Source) -> Option<MetalRoom> {
    let material = match source.strength_mm3 < 0.0 {
        true => Material::new(1e9, 1.0).ok()?,
        false => Material::new(0.0, 1e6).ok()?,
    };
    let shape = MetalShape::Sphere { radius_mm: source.radius_mm() };
    let body = Arc::new(MetalBody::new(shape, material, IDEAL_HZ, &Task::default()).ok()?);
    let c = source.center_mm;
    let placed = PlacedBody { body, tracker_from_body: Pose::translation(c.x, c.y, c.z) };
    MetalRoom::new(generator.clone(), None, vec![placed], &Task::default()).ok()
}

/// What a dipole of unit strength adds to the rows.
pub(super) fn of_unit_dipole(rows: &Rows, center_mm: &Point3<f64>) -> Vec<f64> {
    let coils = rows.generator.coils.len();
    let mut incident = vec![Vector3::zeros(); coils];
    rows.generator.field(center_mm, &mut incident);
    let mut out = vec![0.0; rows.right.len()];
    let mut signals = vec![0.0; rows.signals()];
    for (m, out) in out.chunks_exact_mut(rows.dof).enumerate() {
        for (axis, n) in rows.axes(m).iter().enumerate() {
            // A dipole's signal is the same with axis and moment exchanged.
            let along = Dipole::new(center_mm, n).field(&rows.positions_mm[m]);
            for (coil, incident) in incident.iter().enumerate() {
                signals[axis * coils + coil] = along.dot(incident);
            }
        }
        rows.map(m, &signals, out);
    }
    out
}

fn dipole_slopes(rows: &Rows, source: &Source, body: usize, slopes: &mut DMatrix<f64>) {
    let coils = rows.generator.coils.len();
    let mut incident = vec![(Vector3::zeros(), Matrix3::zeros()); coils];
    rows.generator.field_and_gradient(&source.center_mm, &mut incident);
    let dof = rows.dof;
    let blocks: Vec<[f64; 6 * OF_BODY]> = (0..rows.len())
        .into_par_iter()
        .map(|m| {
            let mut signals = vec![[0.0; OF_BODY]; rows.signals()];
            for (axis, n) in rows.axes(m).iter().enumerate() {
                let dipole = Dipole::new(&source.center_mm, n);
                let (along, gradient) = dipole.field_and_gradient(&rows.positions_mm[m]);
                for (coil, (field, slope)) in incident.iter().enumerate() {
                    let moved = slope.tr_mul(&along) - gradient * field;
                    signals[axis * coils + coil] = [moved.x, moved.y, moved.z, along.dot(field)];
                }
            }
            let mut block = [0.0; 6 * OF_BODY];
            for unknown in 0..OF_BODY {
                let column: Vec<f64> = signals.iter().map(|s| s[unknown]).collect();
                rows.map(m, &column, &mut block[unknown * 6..][..dof]);
            }
            block
        })
        .collect();
    for unknown in 0..OF_BODY {
        let mut column = slopes.column_mut(OF_BODY * body + unknown);
        for (m, block) in blocks.iter().enumerate() {
            for row in 0..dof {
                column[m * dof + row] = source.strength_mm3 * block[unknown * 6 + row];
            }
        }
    }
}
