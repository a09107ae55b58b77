//! A room of the bodies that were found, to be looked at and simulated in.

use super::found_body::MetalKind;
use super::identification::Identification;
use crate::setup::{
    DEFAULT_TRIANGLES, MaterialTolerance, MetalObject, ObjectMaterial, ObjectShape, RoomMetal,
};
use trackwright_field::generator::Generator;
use trackwright_field::samples::{MapKind, MeasurementSet};
use trackwright_field::{DistortionModel, Environment};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::volume::Volume;

/// The bodies that are determined as spheres in an ideal room, in the box of the true positions; `None`
/// without any.
///
/// `table` is the name of what they were found in.
pub fn room_of_found(
    table: &str,
    generator: &Generator,
    set: &MeasurementSet,
    found: &Identification,
) -> Option<(Environment, RoomMetal)> {
    let objects: Vec<_> = found
        .determined()
        .zip(1..)
        .map(|(body, number)| {
            let center = body.source.center_mm;
            let material = match body.kind {
                MetalKind::Conductor => "copper",
                MetalKind::Ferromagnetic => "ferrite",
            };
            MetalObject {
                name: format!("found {number}"),
                shape: ObjectShape::Sphere { radius_mm: body.source.radius_mm() },
                material: ObjectMaterial::Named(material),
                tracker_from_object: Pose::translation(center.x, center.y, center.z),
                most_triangles: DEFAULT_TRIANGLES,
                tolerance: MaterialTolerance::default(),
            }
        })
        .collect();
    if objects.is_empty() {
        return None;
    }
    let true_mm = set.measurements.iter().map(|m| m.tracker_from_ideal.translation.vector.into());
    let volume = Volume::Box(Bounds::around(true_mm)?);
    let model = DistortionModel::zero(volume.bounds(), MapKind::Distortion);
    let name = format!("Metal found in {table}");
    let bare = Environment { volume: Some(volume), ..Environment::of_model(name, model) };
    Some((bare, RoomMetal { objects, ..RoomMetal::empty(generator.clone()) }))
}
