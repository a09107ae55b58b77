//! Where in its box a model is valid: the surface within which a sensor turned one way finds
//! field that the samples support.
//!
//! The scalar is [`ModelValidity::shares`], 1 where support ends. The surface ends on the faces of the box,
//! as the model does.

use nalgebra::{Unit, Vector3};
use rayon::prelude::*;
use trackwright_field::validity::ModelValidity;
use trackwright_field::{Environment, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::isosurface::{Isosurface, ScalarLattice};
use trackwright_task::{Cancelled, Task};

/// Lattice points that one core does before it looks whether anyone still wants them.
const PIECE: usize = 512;

/// Where the field is supported.
#[derive(Clone, Debug, PartialEq)]
pub struct SupportedRegion {
    /// Axis of the sensor that was requested, tracker frame.
    pub axis: Unit<Vector3<f64>>,
    /// Where the field ceases to be supported within the box, tracker frame; open where supported field
    /// reaches the box's faces.
    pub surface: Isosurface,
    pub volume_cm3: f64,
    /// Of the model's box, 0 to 1.
    pub fraction: f64,
    /// Poses that were looked up.
    pub evaluations: u64,
}

/// Why there is no region.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SupportedRegionError {
    #[error("the environment {0:?} has no model validity")]
    NoSupport(String),
    #[error("{count} points along an axis, expected at least 2")]
    Count { count: usize },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The region where a sensor along `axis` (tracker frame) finds supported field, from a lattice of
/// `count` points along each side of the model's box. The result does not depend on the number of
/// threads.
///
/// # Errors
/// See [`SupportedRegionError`].
pub fn supported_region(
    environment: &Environment,
    axis: &Unit<Vector3<f64>>,
    count: usize,
    task: &Task,
) -> Result<SupportedRegion, SupportedRegionError> {
    let no_support = || SupportedRegionError::NoSupport(environment.name.clone());
    let validity = environment.model_validity(OutsidePolicy::Clamp).ok_or_else(no_support)?;
    if count < 2 {
        return Err(SupportedRegionError::Count { count });
    }
    let own = *environment.model.bounds();
    let share = shares(&validity, &own, axis, count, task)?;
    let surface = share.isosurface(1.0);
    let whole_mm3 = own.size_mm().product();
    Ok(SupportedRegion {
        axis: *axis,
        volume_cm3: surface.volume_mm3 / 1e3,
        fraction: match whole_mm3 > 0.0 {
            true => (surface.volume_mm3 / whole_mm3).min(1.0),
            false => 0.0,
        },
        surface,
        evaluations: count.pow(3) as u64,
    })
}

/// The scalar over the box.
fn shares(
    validity: &ModelValidity,
    bounds: &Bounds,
    axis: &Unit<Vector3<f64>>,
    count: usize,
    task: &Task,
) -> Result<ScalarLattice, Cancelled> {
    let mut lattice = ScalarLattice { bounds: *bounds, counts: [count; 3], values: Vec::new() };
    let points = count.pow(3);
    let starts: Vec<usize> = (0..points).step_by(PIECE).collect();
    let pieces: Result<Vec<Vec<f64>>, Cancelled> = starts
        .into_par_iter()
        .map(|start| {
            if task.cancel.is_cancelled() {
                return Err(Cancelled);
            }
            let places = start..(start + PIECE).min(points);
            let points: Vec<_> = places.map(|at| lattice.point_mm(lattice.index(at))).collect();
            Ok(validity.shares(&points, axis))
        })
        .collect();
    lattice.values = pieces?.concat();
    Ok(lattice)
}
