//! How much room things take, for cameras that frame them.

use crate::design::{BodyRole, Design};
use crate::editor::state::{Selected, Selection};
use crate::geometry::bounds::Bounds;
use crate::store::World;
use nalgebra::Point3;

/// What a single sensor or tip is framed with, millimetres around it.
const POINT_RADIUS_MM: f64 = 25.0;

/// A ball in the tracker frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    pub center_mm: Point3<f64>,
    pub radius_mm: f64,
}

/// Tool and CRF with whatever their meshes show.
pub fn of_bodies(world: &World, design: &Design) -> Option<Sphere> {
    let roles = BodyRole::ALL.iter();
    around(roles.flat_map(|role| points(world, design, *role)))
}

/// What is selected, or everything, where the design as it is shown has it.
pub fn of_selection(world: &World, design: &Design, selection: &Selection) -> Option<Sphere> {
    match selection.primary() {
        None => of_bodies(world, design),
        Some(Selected::Body(role)) => around(points(world, design, role).into_iter()),
        Some(Selected::Sensor(..)) => {
            let (role, indices) = selection.sensors()?;
            let sensors = &design.body(role)?.rigid.sensors;
            let pose = design.tracker_from_body(role)?;
            let selected = indices.into_iter().filter_map(|index| sensors.get(index));
            around(selected.map(|sensor| pose * sensor.position_in_body))
        }
        Some(Selected::Tip(role)) => {
            let tip = design.body(role)?.rigid.judged_tip_in_body();
            Some(at(design.tracker_from_body(role)? * tip))
        }
    }
}

fn at(center_mm: Point3<f64>) -> Sphere {
    Sphere {
        center_mm,
        radius_mm: POINT_RADIUS_MM,
    }
}

fn around(points: impl Iterator<Item = Point3<f64>>) -> Option<Sphere> {
    let bounds = Bounds::around(points)?;
    Some(Sphere {
        center_mm: bounds.center_mm(),
        radius_mm: (bounds.diagonal_mm() / 2.0).max(POINT_RADIUS_MM),
    })
}

/// Mesh corners, sensors and tip of a body, tracker frame.
fn points(world: &World, design: &Design, role: BodyRole) -> Vec<Point3<f64>> {
    let (Some(body), Some(pose)) = (design.body(role), design.tracker_from_body(role)) else {
        return Vec::new();
    };
    let corners = world
        .mesh(role)
        .into_iter()
        .flat_map(|mesh| mesh.parts.iter().flat_map(|part| part.positions_mm.iter()));
    let sensors = body.rigid.sensors.iter().map(|s| &s.position_in_body);
    corners
        .chain(sensors)
        .chain(body.rigid.tip_in_body.iter())
        .map(|p| pose * p)
        .collect()
}
