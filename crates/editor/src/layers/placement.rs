//! The selected sensor's body painted by the study's tip RMS if the sensor sat there: coarse at
//! first, better while one looks.

use crate::convert;
use crate::document::apply::WorldGeneration;
use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::selection::{Selected, Selection};
use crate::layers::ColorBars;
use crate::layers::color_bar::ColorBar;
use crate::runner::diagnostics::Diagnostics;
use crate::runner::latest::Latest;
use crate::runner::wake::Waker;
use crate::scene::BodyRoot;
use crate::scene::bodies::{mesh_of, shown_mesh};
use crate::scene::materials::paint::PaintMaterial;
use crate::schedule::EditorSystems;
use crate::shell::window::Workspace;
use bevy::prelude::*;
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_geometry::colormap::{ColorMap, NO_VALUE_SRGB};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::surface::{Ray, Surface};
use trackwright_scene::painted::placement_range;
use trackwright_simulation::placement::vertices;
use trackwright_simulation::{AxisRule, PlacedBody, PlacementOutcome, PlacementPlan, Work, place};

/// Finds and paints placements while their layer is on and a sensor is selected.
pub struct PlacementPlugin;

/// What is painted; child of its body.
#[derive(Component)]
struct Painted;

#[derive(Resource)]
pub(crate) struct PlacementLayer {
    latest: Latest<PlacementOutcome>,
    key: Option<Key>,
    look: Look,
    mesh: Option<Arc<SurfaceMesh>>,
    /// Of a placeholder's mesh, which nobody else keeps.
    surface: Option<Arc<Surface>>,
    found: Option<PlacementOutcome>,
    /// Work of the newest wish that was counted already.
    counted: Work,
}

/// What a painted body shows at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PaintedValue {
    /// Expected where there is an interval, else in the room's own field.
    pub tip_rms_mm: f64,
    /// 95 %.
    pub interval_mm: Option<[f64; 2]>,
}

/// How places are coloured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Look {
    map: ColorMap,
    range_mm: Option<f64>,
    /// What the tip error's RMS may be.
    limit_mm: Option<f64>,
}

impl PlacementLayer {
    /// What is painted where a ray of the body's frame enters the painted body, and how far along the
    /// ray: the tip RMS that is painted there; `None` where there is none.
    pub fn under(
        &self,
        body: BodyRole,
        own: Option<&Arc<Surface>>,
        ray: &Ray,
    ) -> Option<(f64, Option<PaintedValue>)> {
        let found = self.found.as_ref()?;
        self.key.as_ref().filter(|key| key.body == body)?;
        let hit = own.or(self.surface.as_ref())?.hit(ray)?;
        let value = found.between(hit.corners, hit.weights);
        let value = value.map(|tip_rms_mm| PaintedValue {
            tip_rms_mm,
            interval_mm: found.interval_between(hit.corners, hit.weights),
        });
        Some((hit.distance_mm, value))
    }
}

/// What placements depend on.
#[derive(Clone, Debug, PartialEq)]
struct Key {
    generation: u64,
    revision: u64,
    body: BodyRole,
    sensor: usize,
    rule: AxisRule,
}

impl FromWorld for PlacementLayer {
    fn from_world(world: &mut World) -> Self {
        Self {
            latest: Latest::new("placement", world.get_resource_or_init::<Waker>().clone()),
            key: None,
            look: Look::default(),
            mesh: None,
            surface: None,
            found: None,
            counted: Work::default(),
        }
    }
}

impl Plugin for PlacementPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<PlacementLayer>()
            .init_resource::<ColorBars>()
            .init_resource::<Diagnostics>()
            .init_resource::<WorldGeneration>()
            .init_resource::<Selection>()
            .init_resource::<Workspace>()
            .init_resource::<ActiveDrag>()
            .add_systems(
                Update,
                (ask.run_if(resource_exists::<OpenWorld>).run_if(may_differ), hear.run_if(is_on))
                    .chain()
                    .in_set(EditorSystems::Solve),
            )
            .add_systems(
                Update,
                draw.run_if(resource_changed::<PlacementLayer>)
                    .after(crate::scene::bodies::BodiesSystems)
                    .in_set(EditorSystems::Draw),
            );
    }
}

pub(crate) fn is_idle(world: &World) -> bool {
    world.get_resource::<PlacementLayer>().is_none_or(|layer| layer.latest.is_idle())
}

fn is_on(layer: Res<PlacementLayer>) -> bool {
    layer.key.is_some()
}

fn may_differ(
    world: Res<OpenWorld>,
    selection: Res<Selection>,
    workspace: Res<Workspace>,
    drag: Res<ActiveDrag>,
) -> bool {
    world.is_changed() || selection.is_changed() || workspace.is_changed() || drag.is_changed()
}

/// The sensor that is imagined elsewhere: the selected one. On a slide nothing is selected; the
/// tool's first stands for it.
fn imagined(selection: &Selection, workspace: Workspace) -> Option<(BodyRole, usize)> {
    match selection.primary() {
        Some(Selected::Sensor(body, sensor)) => Some((body, sensor)),
        _ if workspace == Workspace::Present => Some((BodyRole::Tool, 0)),
        _ => None,
    }
}

fn ask(
    mut layer: ResMut<PlacementLayer>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
    selection: Res<Selection>,
    workspace: Res<Workspace>,
    drag: Res<ActiveDrag>,
    mut bars: ResMut<ColorBars>,
) {
    let document = &world.0.document;
    let (view, requirement) = (document.view(), document.design().requirement);
    let look = Look {
        map: view.slice.color_map,
        range_mm: view.placement_range_mm,
        limit_mm: requirement.and_then(|of| of.position_rms_mm),
    };
    if layer.bypass_change_detection().look != look {
        layer.look = look;
        bars.placement = layer.found.as_ref().and_then(|found| bar(&look, found));
    }
    let is_wanted = document.view().layers.placement;
    // While something moves, every step would begin anew: what is painted stays until it rests.
    if drag.0 && is_wanted {
        return;
    }
    let sensor = imagined(&selection, *workspace).filter(|_| is_wanted);
    let key = sensor.map(|(body, sensor)| Key {
        generation: generation.0,
        revision: document.revision(),
        body,
        sensor,
        rule: document.view().placement_rule,
    });
    if layer.bypass_change_detection().key == key {
        return;
    }
    layer.key.clone_from(&key);
    layer.found = None;
    layer.counted = Work::default();
    bars.placement = None;
    let mesh = key.as_ref().and_then(|key| shown_mesh(&world.0, key.body));
    layer.mesh.clone_from(&mesh);
    let is_placeholder = key.as_ref().is_some_and(|key| mesh_of(&world.0, key.body).is_none());
    layer.surface = mesh.as_deref().filter(|_| is_placeholder).and_then(Surface::new).map(Arc::new);
    let (Some(key), Some(mesh)) = (key, mesh) else {
        layer.latest.give_up();
        return;
    };
    let scenario = trackwright_project::resolve(document.design(), &world.0.environment);
    let work = move |task: &trackwright_task::Task, found: &mut dyn FnMut(PlacementOutcome)| {
        let plan = PlacementPlan {
            body: match key.body {
                BodyRole::Tool => PlacedBody::Tool,
                BodyRole::Crf => PlacedBody::Crf,
            },
            sensor: key.sensor,
            rule: key.rule,
            candidates: vertices(&mesh).into(),
        };
        // What cannot be placed leaves the body unpainted: the result panel says why.
        let _ = place(&scenario, &plan, task, &mut |outcome| {
            found(outcome.clone());
        });
    };
    if let Err(error) = layer.latest.wish(Box::new(work)) {
        warn!("no thread for placements: {error}");
    }
}

fn hear(
    mut layer: ResMut<PlacementLayer>,
    mut bars: ResMut<ColorBars>,
    mut diagnostics: ResMut<Diagnostics>,
) {
    let Some(found) = layer.bypass_change_detection().latest.answers().pop() else {
        return;
    };
    // Each picture's work holds that of the pictures before it.
    diagnostics.work.placement_evaluations +=
        found.work.placement_evaluations - layer.counted.placement_evaluations;
    layer.counted = found.work;
    bars.placement = bar(&layer.look, &found);
    layer.found = Some(found);
}

fn bar(look: &Look, found: &PlacementOutcome) -> Option<ColorBar> {
    let [_, largest] = found.range_mm()?;
    let [min, max] = placement_range(found, look.range_mm)?;
    Some(ColorBar {
        label: format!(
            "{}, sensor here{}",
            found.figure_label(),
            if found.is_final { "" } else { "…" },
        ),
        unit: "mm",
        map: look.map,
        min,
        max,
        largest,
        decimals: 2,
        limit: look.limit_mm,
    })
}

fn draw(
    mut commands: Commands,
    layer: Res<PlacementLayer>,
    bars: Res<ColorBars>,
    painted: Query<Entity, With<Painted>>,
    roots: Query<(Entity, &BodyRoot)>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<PaintMaterial>>,
) {
    for entity in &painted {
        commands.entity(entity).despawn();
    }
    let (Some(found), Some(mesh), Some(key), Some(bar)) =
        (&layer.found, &layer.mesh, &layer.key, &bars.placement)
    else {
        return;
    };
    let Some((root, _)) = roots.iter().find(|(_, root)| root.0 == key.body) else {
        return;
    };
    let material = materials.add(PaintMaterial::over_a_body());
    let mut colors = found.places.iter().map(|place| color(place.shown_mm(), bar));
    for part in mesh.body_parts() {
        let own: Vec<[f32; 4]> = colors.by_ref().take(part.positions_mm.len()).collect();
        let mesh = convert::mesh(part).with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, own);
        commands.entity(root).with_child((
            Name::new("placement"),
            Painted,
            Mesh3d(meshes.add(mesh)),
            MeshMaterial3d(material.clone()),
        ));
    }
}

fn color(shown_mm: Option<f64>, bar: &ColorBar) -> [f32; 4] {
    let srgb = shown_mm.map_or(NO_VALUE_SRGB, |value| color_on(bar.map, value, bar));
    convert::linear(srgb)
}

fn color_on(map: ColorMap, value: f64, bar: &ColorBar) -> [u8; 3] {
    map.srgb_of_value(value - bar.min, bar.max - bar.min)
}
