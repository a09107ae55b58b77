//! How far a solved room may be off: solved with other triangles, and with other materials.

use super::{FurnishError, Furnisher, keep, kept, solved};
use crate::room::MetalRoom;
use crate::setup::{MIN_TRIANGLES, MetalObject, ObjectShape, RoomMetal};
use crate::surface::MAX_TRIANGLES;
use crate::uncertainty::material_std;
use nalgebra::{Point3, Vector3};
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_task::{Cancelled, Task};

/// Triangles by which it is seen how much a response changes with the material.
const SPREAD_TRIANGLES: usize = 150;

/// Places a side of the volume's box at which two solutions are compared.
const COMPARED: usize = 4;

/// What a solution is off by at least, and where there is no second one to compare it with.
const LEAST_ERROR: f64 = 0.002;
const UNKNOWN_ERROR: f64 = 0.05;

/// What a solved room is off by.
pub(super) struct SolutionError {
    /// As a part of the metal's field in the volume.
    pub part: f64,
    /// Another solution, and how many times what it changes the first one is off by.
    pub other: Option<(Arc<MetalRoom>, f64)>,
}

impl SolutionError {
    /// What is left at each pose by itself where another solution is known.
    pub fn own_std(&self) -> f64 {
        if self.other.is_some() { LEAST_ERROR } else { self.part }
    }
}

impl Furnisher {
    /// What half as many triangles change of the metal's field in the volume, and the room that is solved with them:
    /// the error falls with the square of their size, so that as much is left of it. Of the fewest triangles there
    /// are, twice what twice as many change.
    pub(super) fn solution_error(
        &mut self,
        room: &MetalRoom,
        bare: &Environment,
        metal: &RoomMetal,
        task: &Task,
    ) -> Result<SolutionError, FurnishError> {
        let of_sphere = |object: &MetalObject| matches!(object.shape, ObjectShape::Sphere { .. });
        if metal.objects.iter().all(of_sphere) {
            return Ok(SolutionError { part: LEAST_ERROR, other: None });
        }
        let has_fewest = |object: &MetalObject| object.most_triangles < 2 * MIN_TRIANGLES;
        let is_finer = metal.objects.iter().any(|object| !of_sphere(object) && has_fewest(object));
        let mut second = metal.clone();
        for object in &mut second.objects {
            object.most_triangles = match is_finer {
                true => (2 * object.most_triangles).min(MAX_TRIANGLES),
                false => object.most_triangles / 2,
            };
        }
        let other = self.placed(&second, &task.subtask(0.0, 0.8)).and_then(|placed| {
            let last = self.last_second.as_deref();
            solved(last, bare, &second, placed, &task.subtask(0.8, 1.0))
        });
        // Shapes that need all their triangles, or touch with others.
        let Ok(other) = other else {
            return if task.cancel.is_cancelled() {
                Err(Cancelled.into())
            } else {
                Ok(SolutionError { part: UNKNOWN_ERROR, other: None })
            };
        };
        let bounds = bare.model.bounds();
        let side = 0..COMPARED;
        let part = |k: usize| (k as f64 + 0.5) / COMPARED as f64;
        let places = side.clone().flat_map(|x| {
            let side = side.clone();
            side.clone().flat_map(move |y| side.clone().map(move |z| [x, y, z]))
        });
        let places: Vec<Point3<f64>> = places
            .map(|at| bounds.min_mm + bounds.size_mm().component_mul(&Vector3::from(at.map(part))))
            .collect();
        let (mut changed, mut whole) = (0.0, 0.0);
        for fields in room.disturbances(&places).into_iter().zip(other.disturbances(&places)) {
            let (Ok(own), Ok(other)) = fields else { continue };
            for (own, other) in own.iter().zip(&other) {
                changed += (own - other).norm_squared();
                whole += own.norm_squared();
            }
        }
        let other = Arc::new(other);
        self.last_second = Some(Arc::clone(&other));
        let times = if is_finer { 2.0 } else { 1.0 };
        let error = if whole > 0.0 { times * (changed / whole).sqrt() } else { 0.0 };
        Ok(SolutionError { part: error.max(LEAST_ERROR), other: Some((other, times)) })
    }

    /// The largest of all objects, by few triangles: how much a response changes with the material settles long before
    /// the response does.
    pub(super) fn material_std(
        &mut self,
        metal: &RoomMetal,
        task: &Task,
    ) -> Result<f64, FurnishError> {
        let mut largest = 0.0_f64;
        for (done, object) in metal.objects.iter().enumerate() {
            task.step(done, metal.objects.len())?;
            let most_triangles = object.most_triangles.min(SPREAD_TRIANGLES);
            let coarse = MetalObject { most_triangles, ..object.clone() };
            let key =
                ((coarse.key(), object.material.material(), metal.frequency_hz), object.tolerance);
            let found = match kept(&mut self.spreads, &key) {
                Some(found) => found,
                None => {
                    let quiet = Task::cancelled_by(task.cancel.clone());
                    let shape = match self.shape(&coarse, &quiet) {
                        Ok(shape) => shape,
                        // A mesh that needs all its triangles.
                        Err(_) => self.shape(object, &quiet)?,
                    };
                    let (_, material, frequency_hz) = &key.0;
                    let found = material_std(&shape, material, &key.1, *frequency_hz, &quiet);
                    let name = || object.name.clone();
                    let of_body = |cause| FurnishError::Body { name: name(), cause };
                    let found = Arc::new(found.map_err(of_body)?);
                    keep(&mut self.spreads, key, &found);
                    found
                }
            };
            largest = largest.max(*found);
        }
        Ok(largest)
    }
}
