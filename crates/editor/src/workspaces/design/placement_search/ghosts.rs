//! The places that a search has found, as ghost sensors on the bodies in the scene.

use crate::convert;
use crate::document::shown::ShownDesign;
use crate::layers::legend::{Legend, LegendKey, Legends, Swatch};
use crate::palette;
use crate::scene::materials::glow::{GlowMaterial, Shown};
use crate::scene::screen_size::ScreenSized;
use crate::scene::shapes::GlyphShapes;
use crate::schedule::EditorSystems;
use crate::shell::window::Workspace;
use crate::workspaces::design::placement_search::charts_ui::objective_text;
use crate::workspaces::design::placement_search::state::PlacementSearch;
use crate::workspaces::design::placement_search::thumbnail::body_of;
use crate::workspaces::design::workspace::WORKSPACE;
use bevy::prelude::*;
use nalgebra::Point3;
use trackwright_design::BodyRole;
use trackwright_design::view::Layer;
use trackwright_geometry::pose::Pose;
use trackwright_scene::sensor_look::{SensorLook, axis_solid};
use trackwright_simulation::Sensor;

/// In the legend they come after the best place of one sensor.
pub const LEGEND_ORDER: u32 = Layer::PLACEMENT.order + 2;

/// Over what hides it, and before the design's own sensors.
const ORDER_MM: f32 = 18_500.0;
const ALPHA: f32 = 0.75;

/// Draws the places while the panel is open and they can be taken.
pub struct PlacementGhostsPlugin;

/// A body's sensors as they were found.
#[derive(Component)]
#[require(Transform, Visibility)]
struct FoundSensors;

/// What they are made of.
#[derive(Clone)]
struct Look {
    material: Handle<GlowMaterial>,
    axis: Handle<Mesh>,
}

impl Plugin for PlacementGhostsPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Update,
            show.run_if(
                resource_exists::<ShownDesign>.and_then(resource_exists::<PlacementSearch>),
            )
            .run_if(
                resource_changed::<PlacementSearch>
                    .or_else(resource_changed::<ShownDesign>)
                    .or_else(resource_changed::<Workspace>),
            )
            .in_set(EditorSystems::Draw),
        );
    }
}

fn show(
    mut commands: Commands,
    (search, shown, workspace): (Res<PlacementSearch>, Res<ShownDesign>, Res<Workspace>),
    drawn: Query<Entity, With<FoundSensors>>,
    shapes: Res<GlyphShapes>,
    (mut meshes, mut materials): (ResMut<Assets<Mesh>>, ResMut<Assets<GlowMaterial>>),
    mut legends: ResMut<Legends>,
    mut look: Local<Option<Look>>,
) {
    for entity in &drawn {
        commands.entity(entity).despawn();
    }
    let found = search.shown().filter(|_| *workspace == WORKSPACE);
    let mut is_any = false;
    if let Some((layout, ..)) = &found {
        let look = look.get_or_insert_with(|| Look {
            material: materials.add(
                GlowMaterial::translucent(palette::FOUND_PLACE, ALPHA, ALPHA)
                    .shown(Shown::Always)
                    .order(ORDER_MM),
            ),
            axis: {
                let solid = axis_solid();
                let mesh =
                    convert::triangle_mesh(&solid.positions_mm, &solid.normals, &solid.triangles);
                meshes.add(mesh)
            },
        });
        for role in BodyRole::ALL {
            let own = shown.design.body(role).map(|body| &body.rigid.sensors);
            let (Some(own), Some(body), Some(pose)) =
                (own, body_of(layout, role), shown.design.tracker_from_body(role))
            else {
                continue;
            };
            // Where a sensor stays its ghost would only hide it.
            let moved: Vec<&Sensor> = body.sensors.iter().filter(|s| !own.contains(s)).collect();
            if moved.is_empty() {
                continue;
            }
            is_any = true;
            let place = convert::transform(&pose);
            let mut root = commands.spawn((Name::new("found sensors"), FoundSensors, place));
            for sensor in moved {
                root.with_children(|root| spawn_ghost(root, sensor, &pose, &shapes, look));
            }
        }
    }
    let key = found.filter(|_| is_any).map(|(layout, searched, words)| {
        let value = objective_text(searched.goal, layout.objective);
        LegendKey::new(Swatch::Ball(palette::FOUND_PLACE), format!("{words}: {value}"))
    });
    legends.set(LEGEND_ORDER, Legend { keys: key.into_iter().collect(), ..Legend::default() });
}

/// A coil along z with its axes, or a ball.
fn spawn_ghost(
    root: &mut ChildSpawnerCommands,
    sensor: &Sensor,
    tracker_from_body: &Pose,
    shapes: &GlyphShapes,
    look: &Look,
) {
    let drawn = SensorLook::of(sensor);
    let (across, along) = drawn.drawn_size();
    let at_mm: Point3<f64> = tracker_from_body * sensor.position_in_body;
    let is_marker = drawn.is_marker();
    let shape = if is_marker { &shapes.ball } else { &shapes.coil };
    let place = convert::transform(&sensor.body_from_sensor());
    let material = MeshMaterial3d(look.material.clone());
    root.spawn((
        Name::new("found sensor"),
        Mesh3d(shape.clone()),
        material.clone(),
        place,
        ScreenSized { at_mm, across, along },
    ));
    if is_marker {
        return;
    }
    let quarter = std::f32::consts::FRAC_PI_2;
    let turns = [Quat::IDENTITY, Quat::from_rotation_y(quarter), Quat::from_rotation_x(-quarter)];
    let axes = if drawn.degrees_of_freedom == 6 { 3 } else { 1 };
    let length = drawn.axis_size();
    for turn in turns.into_iter().take(axes) {
        root.spawn((
            Mesh3d(look.axis.clone()),
            material.clone(),
            Transform { rotation: place.rotation * turn, ..place },
            ScreenSized { at_mm, across: length, along: length },
        ));
    }
}
