//! Measurements beside a sphere of metal.

use super::table::measurement_columns;
use nalgebra::{Point3, Vector3};
use std::fmt::Write;
use std::sync::Arc;
use trackwright_field::generator::Generator;
use trackwright_field::random_models::Seeded;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::{Pose, pose_from_parts, pose_to_array};
use trackwright_geometry::rotation::{axis_rotation, exp_vector};
use trackwright_metal::body::{MetalBody, MetalShape};
use trackwright_metal::material::Material;
use trackwright_metal::room::{MetalRoom, PlacedBody};
use trackwright_task::Task;

/// Middle of the sphere, tracker frame.
pub const AT_MM: [f64; 3] = [200.0, 40.0, -210.0];
pub const RADIUS_MM: f64 = 45.0;

/// A table of so many rows beside an aluminium sphere, or in an empty room.
pub fn metal_table(rows: usize, has_metal: bool) -> String {
    table_beside(rows, has_metal.then_some(AT_MM))
}

/// The same with the sphere anywhere.
pub fn table_beside(rows: usize, at_mm: Option<[f64; 3]>) -> String {
    let aluminium = Material::named("aluminium").unwrap();
    let shape = MetalShape::Sphere { radius_mm: RADIUS_MM };
    let body = Arc::new(MetalBody::new(shape, aluminium, 1e4, &Task::default()).unwrap());
    let placed =
        |[x, y, z]: [f64; 3]| PlacedBody { body, tracker_from_body: Pose::translation(x, y, z) };
    let bodies = at_mm.map(placed).into_iter().collect();
    let room = MetalRoom::new(Generator::planar_nine(), None, bodies, &Task::default()).unwrap();
    let volume = Bounds::from(([-140.0, -140.0, -380.0], [140.0, 140.0, -100.0]));
    let mut seeded = Seeded::new(1);
    let mut text = measurement_columns();
    for _ in 0..rows {
        let pose = seeded.pose(&volume, 0.0);
        let axis = pose.rotation * Vector3::z_axis();
        let read = room.read_axis(&Point3::from(pose.translation.vector), &axis).unwrap();
        let turn = exp_vector(&axis_rotation(&axis, &read.axis).vector_rad);
        let read = pose_from_parts(read.position_mm.coords, turn * pose.rotation);
        let measured = seeded.around(&read, 0.1, 2e-3);
        text.push('\n');
        let numbers = [pose, measured].map(|pose| pose_to_array(&pose)).concat();
        let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
        write!(text, "{}", numbers.join(",")).unwrap();
    }
    text
}
