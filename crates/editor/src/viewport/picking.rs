//! Which entity is under the pointer: handles and sensors by their distance on the screen, bodies
//! and metal by the core's own surfaces.
//!
//! A backend for Bevy's picking, whose events the observers of drags and selection receive. It
//! works in f64 on the document, so that a coil inside a shaft can be picked and nothing has to
//! be marked as not to be picked.

use crate::document::requests::OpenWorld;
use crate::scene::metal::MetalRoot;
use crate::scene::{BodyRoot, SensorMark, sensors};
use crate::viewport::ball_handle::{BallHandle, HANDLE_PX};
use crate::viewport::camera::{MainCamera, OrbitRig, Sight};
use crate::viewport::gizmo::{CurrentGizmo, GizmoHandle};
use crate::viewport::mounting::state::{MountingOwner, MountingTarget};
use crate::viewport::surfaces::{Surfaces, make_surfaces};
use bevy::ecs::system::SystemParam;
use bevy::picking::PickingSystems;
use bevy::picking::backend::{HitData, PointerHits};
use bevy::picking::pointer::{PointerAction, PointerId, PointerInput, PointerLocation};
use bevy::prelude::*;
use nalgebra::{Point3, Vector3};
use trackwright_design::Design;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::surface::Ray;
use trackwright_simulation::body::Sensor;

/// How near to a sensor's axis the pointer takes hold of it, in pixels.
const REACH_PX: f64 = 9.0;

/// Answers Bevy's picking from the core's geometry.
pub struct PickPlugin;

impl Plugin for PickPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Surfaces>()
            .add_message::<PointerHits>()
            .add_message::<PointerInput>()
            .add_systems(
                PreUpdate,
                (
                    make_surfaces.run_if(resource_exists_and_changed::<OpenWorld>),
                    pick.run_if(resource_exists::<OpenWorld>),
                )
                    .chain()
                    .in_set(PickingSystems::Backend),
            );
    }
}

/// What can be picked.
#[derive(SystemParam)]
pub struct Targets<'w, 's> {
    surfaces: Res<'w, Surfaces>,
    sensors: Query<'w, 's, (Entity, &'static SensorMark)>,
    roots: Query<'w, 's, (Entity, &'static BodyRoot)>,
    metal: Query<'w, 's, (Entity, &'static MetalRoot)>,
    handles: Query<'w, 's, (Entity, &'static BallHandle)>,
    gizmo: Option<Res<'w, CurrentGizmo>>,
    gizmo_handles: Query<'w, 's, (Entity, &'static GizmoHandle)>,
    mounting: Query<'w, 's, (Entity, &'static MountingTarget)>,
}

fn pick(
    pointers: Query<(&PointerId, &PointerLocation)>,
    sight: Sight,
    targets: Targets,
    camera: Option<Single<Entity, With<MainCamera>>>,
    mut inputs: MessageReader<PointerInput>,
    mut hits: MessageWriter<PointerHits>,
) {
    let presses: Vec<(PointerId, Vec2)> = inputs
        .read()
        .filter(|input| matches!(input.action, PointerAction::Press(_)))
        .map(|input| (input.pointer_id, input.location.position))
        .collect();
    let Some(camera) = camera else { return };
    for (id, location) in &pointers {
        let Some(location) = location.location() else {
            continue;
        };
        // Between two slow frames a pointer can press and move on: what counts is where it
        // pressed.
        let pressed = presses.iter().rev().find(|press| press.0 == *id);
        let at = pressed.map_or(location.position, |press| press.1);
        if !sight.contains(at) {
            continue;
        }
        let picks = targets
            .under(&sight, at)
            .into_iter()
            .map(|(entity, depth)| (entity, HitData::new(*camera, depth as f32, None, None)))
            .collect();
        hits.write(PointerHits::new(*id, picks, 0.0));
    }
}

impl Targets<'_, '_> {
    /// The sensor under a place in the window, be there a handle of the gizmo before it or not.
    pub fn sensor_under(&self, sight: &Sight, at: Vec2) -> Option<Entity> {
        let under = self.under(sight, at).into_iter();
        under
            .filter(|(entity, _)| self.sensors.contains(*entity))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(entity, _)| entity)
    }

    /// How far along a ray the anatomy is that is painted.
    fn anatomy_depth_mm(
        &self,
        world: &OpenWorld,
        design: &Design,
        index: usize,
        ray: &Ray,
    ) -> Option<f64> {
        let anatomy = design.anatomy.get(index)?;
        let surface = self.surfaces.of_anatomy(world.0.anatomy_mesh(&anatomy.mesh)?)?;
        let in_mesh = ray.transformed_by(&anatomy.tracker_from_mesh(design).inverse());
        Some((surface.cast(&in_mesh)?.position_mm - in_mesh.origin_mm).norm())
    }

    /// Everything under a place in the window, with a depth that orders it.
    fn under(&self, sight: &Sight, at: Vec2) -> Vec<(Entity, f64)> {
        let (Some(world), Some(design), Some(pixel), Some(ray)) =
            (&sight.world, sight.design(), sight.pixel(at), sight.ray(at))
        else {
            return Vec::new();
        };
        let view = world.0.document.view();
        // Whoever selected something reaches for its handles, whatever lies behind them.
        let held = self.gizmo.as_ref().and_then(|gizmo| {
            let (handle, distance) = gizmo.0?.gizmo.under(pixel, &sight.eye())?;
            let entity = self.gizmo_handles.iter().find(|(_, own)| own.0 == handle)?.0;
            Some((entity, distance - GIZMO_BEFORE))
        });
        let handles = self.handles.iter().filter_map(|(entity, handle)| {
            let distance = distance_px(&sight.rig, pixel, [handle.at_mm; 2])?;
            (distance <= HANDLE_PX).then_some((entity, distance))
        });
        // In front of every body, the nearest on the screen first.
        let sensors = self.sensors.iter().filter_map(|(entity, mark)| {
            let sensor = design.body(mark.body)?.rigid.sensors.get(mark.index)?;
            if [&view.hidden, &view.locked]
                .iter()
                .any(|things| things.has_sensor(mark.body, &sensor.name))
            {
                return None;
            }
            let pose = design.tracker_from_body(mark.body)?;
            let distance = sensor_distance_px(&sight.rig, pixel, sensor, &pose)?;
            Some((entity, distance))
        });
        let bodies = self.roots.iter().filter_map(|(entity, BodyRoot(role))| {
            if view.hidden.has_body(*role) || view.locked.has_body(*role) {
                return None;
            }
            let pose = design.tracker_from_body(*role)?;
            let in_body = ray.transformed_by(&pose.inverse());
            let hit = self.surfaces.of(*role)?.cast(&in_body)?;
            let depth = (hit.position_mm - in_body.origin_mm).norm();
            Some((entity, BODIES_FROM + depth))
        });
        // A tool for mounting regions is used on the surface, whatever is mounted there.
        match self.mounting.iter().next() {
            Some((target, MountingTarget(MountingOwner::Body(_)))) => {
                return bodies.filter(|(entity, _)| *entity == target).collect();
            }
            Some((target, MountingTarget(MountingOwner::Anatomy(index)))) => {
                let depth = self.anatomy_depth_mm(world, design, *index, &ray);
                return depth.map(|depth| (target, BODIES_FROM + depth)).into_iter().collect();
            }
            None => {}
        }
        let metal = self.metal.iter().filter_map(|(entity, MetalRoot(index))| {
            let object = design.metal_object(*index)?;
            if view.hidden.has_metal(&object.name) || view.locked.has_metal(&object.name) {
                return None;
            }
            let in_object = ray.transformed_by(&object.tracker_from_object.inverse());
            let hit = self.surfaces.of_metal(*index)?.cast(&in_object)?;
            let depth = (hit.position_mm - in_object.origin_mm).norm();
            Some((entity, BODIES_FROM + depth))
        });
        let things = handles.chain(sensors).chain(bodies).chain(metal);
        held.into_iter().chain(things).collect()
    }
}

/// How far the pointer is from a coil as it is drawn; `None` where that is out of reach.
fn sensor_distance_px(
    rig: &OrbitRig,
    pixel: [f64; 2],
    sensor: &Sensor,
    tracker_from_body: &Pose,
) -> Option<f64> {
    let (across, along) = sensors::drawn_size(sensor);
    let middle = tracker_from_body * sensor.position_in_body;
    let mm_per_px = rig.mm_per_px(&middle);
    let radius_px = across.mm(mm_per_px) / mm_per_px / 2.0;
    // A ball's ends are both at its middle.
    let half_mm = match sensor.axis_in_body() {
        Some(axis) => axis.into_inner() * along.mm(mm_per_px) / 2.0,
        None => Vector3::zeros(),
    };
    let axis = tracker_from_body.rotation * half_mm;
    let distance = distance_px(rig, pixel, [middle - axis, middle + axis])?;
    (distance <= REACH_PX.max(radius_px + 2.0)).then_some(distance)
}

/// How far the handles of the gizmo are before everything else.
const GIZMO_BEFORE: f64 = 1000.0;

/// Depth at which bodies begin: sensors come before all of them.
const BODIES_FROM: f64 = 1000.0;

/// Distance on the screen from a pixel to a segment of the tracker frame.
fn distance_px(rig: &OrbitRig, pixel: [f64; 2], ends_mm: [Point3<f64>; 2]) -> Option<f64> {
    rig.camera.distance_px(pixel, ends_mm, rig.view_px)
}
