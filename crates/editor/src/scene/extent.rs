//! How much room things take, for cameras that frame them.

use crate::document::selection::{Selected, Selection};
use nalgebra::Point3;
use trackwright_design::Design;
use trackwright_project::World;
use trackwright_scene::opening_view::{POINT_RADIUS_MM, Sphere, points_of};

/// What is selected, or everything, where the design as it is shown has it.
pub fn of_selection(world: &World, design: &Design, selection: &Selection) -> Option<Sphere> {
    match selection.primary() {
        None => Sphere::of_bodies(world, design),
        Some(Selected::Body(role)) => Sphere::around(points_of(world, design, role).into_iter()),
        Some(Selected::Sensor(..)) => {
            let (role, indices) = selection.sensors()?;
            let sensors = &design.body(role)?.rigid.sensors;
            let pose = design.tracker_from_body(role)?;
            let selected = indices.into_iter().filter_map(|index| sensors.get(index));
            Sphere::around(selected.map(|sensor| pose * sensor.position_in_body))
        }
        Some(Selected::Anatomy(index)) => {
            let anatomy = design.anatomy.get(index)?;
            let pose = anatomy.tracker_from_mesh(design);
            let parts = world.anatomy_mesh(&anatomy.mesh)?.parts.iter();
            Sphere::around(parts.flat_map(|part| part.positions_mm.iter().map(|p| pose * p)))
        }
        Some(Selected::Metal(index)) => {
            let object = design.metal_object(index)?;
            let mesh = object.shape.drawn().ok()?;
            let points = mesh.parts.iter().flat_map(|part| &part.positions_mm);
            Sphere::around(points.map(|p| object.tracker_from_object * p))
        }
        Some(Selected::Tip(role)) => {
            let tip = design.body(role)?.rigid.judged_tip_in_body();
            Some(at(design.tracker_from_body(role)? * tip))
        }
    }
}

fn at(center_mm: Point3<f64>) -> Sphere {
    Sphere { center_mm, radius_mm: POINT_RADIUS_MM }
}
