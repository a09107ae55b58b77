//! How much room things take, for cameras that frame them.

use crate::document::selection::{Selected, Selection};
use nalgebra::Point3;
use trackwright_design::{BodyRole, Design};
use trackwright_project::World;
use trackwright_scene::opening_view::{POINT_RADIUS_MM, Sphere, points_of};

/// What is selected, or both bodies, where the design as it is shown has it.
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
        Some(Selected::Anatomy(index)) => Sphere::around(anatomy(world, design, index)),
        Some(Selected::Metal(index)) => Sphere::around(metal(design, index)),
        Some(Selected::Tip(role)) => {
            let tip = design.body(role)?.rigid.judged_tip_in_body();
            Some(at(design.tracker_from_body(role)? * tip))
        }
    }
}

/// All that is drawn: bodies and metal that are not hidden, anatomy and the volume while their layers are on.
pub fn of_everything(world: &World, design: &Design) -> Option<Sphere> {
    let view = world.document.view();
    let roles = BodyRole::ALL.into_iter().filter(|role| !view.hidden.has_body(*role));
    let bodies = roles.flat_map(|role| points_of(world, design, role));
    let anatomies = if view.layers.anatomy { 0..design.anatomy.len() } else { 0..0 };
    let anatomies = anatomies.flat_map(|index| anatomy(world, design, index));
    let objects = design.room_metal.iter().flat_map(|metal| metal.objects.iter().enumerate());
    let metals = objects
        .filter(|(_, object)| !view.hidden.has_metal(&object.name))
        .flat_map(|(index, _)| metal(design, index));
    let volume = world.environment.volume.filter(|_| view.layers.volume);
    let volume = volume.into_iter().flat_map(|volume| volume.bounds().corners_mm());
    Sphere::around(bodies.chain(anatomies).chain(metals).chain(volume))
}

/// The corners of an anatomy's mesh, tracker frame; none while it is read.
fn anatomy(world: &World, design: &Design, index: usize) -> impl Iterator<Item = Point3<f64>> {
    let shown = design.anatomy.get(index).and_then(|anatomy| {
        Some((anatomy.tracker_from_mesh(design), world.anatomy_mesh(&anatomy.mesh)?))
    });
    shown.into_iter().flat_map(|(pose, mesh)| {
        let corners = mesh.parts.iter().flat_map(|part| &part.positions_mm);
        corners.map(move |p| pose * p)
    })
}

/// The corners of a metal object as it is drawn, tracker frame.
fn metal(design: &Design, index: usize) -> impl Iterator<Item = Point3<f64>> {
    let drawn = design
        .metal_object(index)
        .and_then(|object| Some((object.tracker_from_object, object.shape.drawn().ok()?)));
    drawn.into_iter().flat_map(|(pose, mesh)| {
        let corners = mesh.parts.iter().flat_map(|part| &part.positions_mm);
        corners.map(|p| pose * p).collect::<Vec<_>>()
    })
}

fn at(center_mm: Point3<f64>) -> Sphere {
    Sphere { center_mm, radius_mm: POINT_RADIUS_MM }
}
