//! The selected sensor's body painted by the study's tip RMS if the sensor sat there: coarse at
//! first, better while one looks.

use crate::convert;
use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::selection::{Selected, Selection};
use crate::document::state::WorldGeneration;
use crate::layers::legend::{ColorBar, Legends};
use crate::layers::registry::{
    AddLayer, LayerInfo, ProbeInfo, ProbeRay, Probed, SettingsContext, is_layer_on,
};
use crate::layers::settings::{map_ui, range_ui, row_ui};
use crate::runner::diagnostics::Diagnostics;
use crate::runner::jobs::Newest;
use crate::runner::wake::Waker;
use crate::scene::BodyRoot;
use crate::scene::bodies::shown_mesh;
use crate::scene::body_meshes::is_same_mesh;
use crate::scene::materials::paint::PaintMaterial;
use crate::schedule::{EditorSystems, request_then_receive};
use crate::shell::window::Workspace;
use crate::viewport::surfaces::Surfaces;
use crate::widgets::basic::{NumberField, decimal, quiet_ui, with_unit};
use crate::widgets::tooltip::Explain;
use bevy::prelude::*;
use bevy_egui::egui::{ComboBox, Ui};
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_design::view::{Layer, View};
use trackwright_geometry::colormap::{ColorMap, NO_VALUE_SRGB};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::surface::Surface;
use trackwright_scene::painted::placement_range;
use trackwright_simulation::Metric;
use trackwright_simulation::placement::placement_mesh;
use trackwright_simulation::{
    AxisRule, BestPlace, CoilDepth, PlacedBody, PlacementOutcome, PlacementPlan, Work, place,
};

/// The layer.
pub const LAYER: LayerInfo =
    LayerInfo { settings: Some(settings_ui), is_idle, ..LayerInfo::new(&Layer::PLACEMENT) };

/// Finds and paints placements while their layer is on and a sensor is selected.
pub struct PlacementPlugin;

/// What is painted; child of its body.
#[derive(Component)]
struct Painted;

#[derive(Resource)]
pub(crate) struct PlacementLayer {
    newest: Newest<Key, PlacementOutcome>,
    look: Look,
    mesh: Option<PlacementMesh>,
    /// Work of the newest wish that was counted already.
    counted: Work,
}

/// The best place that was found, and what it was found for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FoundBest {
    pub body: BodyRole,
    pub sensor: usize,
    /// Of the document: in another one the place may be another.
    pub revision: u64,
    pub best: BestPlace,
}

impl PlacementLayer {
    /// `None` until the last picture is there, and while another one is on its way.
    pub(crate) fn best(&self) -> Option<FoundBest> {
        let (key, found) = self.newest.found()?;
        let is_newest = self.newest.requested() == Some(key);
        let best = found.best.clone().filter(|_| is_newest)?;
        Some(FoundBest { body: key.body, sensor: key.sensor, revision: key.revision, best })
    }

    /// Whether the last picture of a revision has no best place because the coil fits at none.
    pub(crate) fn fits_nowhere(&self, revision: u64) -> bool {
        let found = self.newest.found().filter(|(key, _)| self.newest.requested() == Some(key));
        found.is_some_and(|(key, found)| key.revision == revision && found.fits_nowhere)
    }
}

/// The mesh whose vertices are places, and what it was made from.
struct PlacementMesh {
    made_from: Arc<SurfaceMesh>,
    mesh: Arc<SurfaceMesh>,
    /// Where it is not the body's own, which others keep: of a finer mesh, or of a placeholder.
    surface: Option<Arc<Surface>>,
}

impl PlacementMesh {
    fn new(made_from: Arc<SurfaceMesh>, is_placeholder: bool) -> Self {
        let finer = placement_mesh(&made_from).map(Arc::new);
        let is_own = finer.is_none() && !is_placeholder;
        let mesh = finer.unwrap_or_else(|| Arc::clone(&made_from));
        let surface = if is_own { None } else { Surface::new(&mesh).map(Arc::new) };
        Self { made_from, mesh, surface }
    }
}

/// How places are coloured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Look {
    map: ColorMap,
    range_mm: Option<f64>,
    /// What the tip error's RMS may be.
    limit_mm: Option<f64>,
}

/// The tip RMS that is painted where the ray enters the painted body.
fn value_at(world: &World, probe: &ProbeRay) -> Option<Probed> {
    let layer = world.get_resource::<PlacementLayer>()?;
    let (key, found) = layer.newest.found()?;
    let open = world.get_resource::<OpenWorld>()?;
    if open.0.document.view().hidden.has_body(key.body) {
        return None;
    }
    let pose = probe.design.tracker_from_body(key.body)?;
    let own = world.get_resource::<Surfaces>()?.of(key.body);
    let finer = layer.mesh.as_ref()?.surface.as_ref();
    let hit = finer.or(own)?.hit(&probe.ray.transformed_by(&pose.inverse()))?;
    let value = found.between(hit.corners, hit.weights);
    let interval_mm = found.interval_between(hit.corners, hit.weights);
    let words = match value {
        Some(tip_rms_mm) => words(tip_rms_mm, interval_mm),
        None => "no tip error, sensor here".to_owned(),
    };
    Some(Probed { distance_mm: hit.distance_mm, words: Some(words) })
}

/// `tip error RMS 0.63 mm (95 %: 0.46 to 0.83), sensor here`.
fn words(tip_rms_mm: f64, interval_mm: Option<[f64; 2]>) -> String {
    let value = format!("{} {}", Metric::TIP_RMS.label(), with_unit(&decimal(tip_rms_mm, 2), "mm"));
    match interval_mm {
        Some(ends) => {
            let [low, high] = ends.map(|end| decimal(end, 2));
            format!("{value} (95\u{2009}%: {low} to {high}), sensor here")
        }
        None => format!("{value}, sensor here"),
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
    depth: CoilDepth,
}

impl FromWorld for PlacementLayer {
    fn from_world(world: &mut World) -> Self {
        Self {
            newest: Newest::new("placement", world.get_resource_or_init::<Waker>().clone()),
            look: Look::default(),
            mesh: None,
            counted: Work::default(),
        }
    }
}

impl Plugin for PlacementPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER)
            .add_probe(ProbeInfo { is_on: |world| is_layer_on(world, &LAYER), value: value_at })
            .init_resource::<PlacementLayer>()
            .add_systems(
                Update,
                request_then_receive(
                    request.run_if(resource_exists::<OpenWorld>).run_if(may_differ),
                    receive.run_if(is_on),
                ),
            )
            .add_systems(
                Update,
                draw.run_if(resource_changed::<PlacementLayer>)
                    .after(crate::scene::bodies::BodiesSystems)
                    .in_set(EditorSystems::Draw),
            );
    }
}

fn is_idle(world: &World) -> bool {
    world.get_resource::<PlacementLayer>().is_none_or(|layer| layer.newest.is_idle())
}

fn is_on(layer: Res<PlacementLayer>) -> bool {
    layer.newest.requested().is_some()
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
        _ if workspace.is_presentation => Some((BodyRole::Tool, 0)),
        _ => None,
    }
}

fn request(
    mut layer: ResMut<PlacementLayer>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
    selection: Res<Selection>,
    workspace: Res<Workspace>,
    drag: Res<ActiveDrag>,
    mut legends: ResMut<Legends>,
) {
    let document = &world.0.document;
    let (view, requirement) = (document.view(), document.design().requirement);
    let look = Look {
        map: view.color_maps().placement,
        range_mm: view.placement_range_mm,
        limit_mm: requirement.and_then(|of| of.bound(Metric::TIP_RMS)),
    };
    if layer.bypass_change_detection().look != look {
        layer.look = look;
        let found = layer.newest.found();
        legends.set_bar(LAYER.row.order, found.and_then(|(key, found)| bar(&look, key, found)));
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
        depth: document.view().placement_depth,
    });
    if layer.newest.requested() == key.as_ref() {
        return;
    }
    layer.newest.give_up();
    layer.counted = Work::default();
    legends.set_bar(LAYER.row.order, None);
    let shown = key.as_ref().and_then(|key| shown_mesh(&world.0, key.body));
    let (Some(key), Some(shown)) = (key, shown) else {
        layer.mesh = None;
        return;
    };
    let own_mesh = world.0.mesh(key.body).cloned();
    let is_placeholder = own_mesh.is_none();
    let made = layer.mesh.take().filter(|made| is_same_mesh(&made.made_from, &shown));
    let made = made.unwrap_or_else(|| PlacementMesh::new(shown, is_placeholder));
    let mesh = Arc::clone(&made.mesh);
    layer.mesh = Some(made);
    let own = document.design().body(key.body).and_then(|body| body.rigid.sensors.get(key.sensor));
    let Some(own_mm) = own.map(|own| own.position_in_body) else {
        return;
    };
    let scenario = trackwright_project::resolve(document.design(), &world.0.environment);
    layer.newest.request(key.clone(), move |task, report| {
        let plan = PlacementPlan {
            body: match key.body {
                BodyRole::Tool => PlacedBody::Tool,
                BodyRole::Crf => PlacedBody::Crf,
            },
            sensor: key.sensor,
            rule: key.rule,
            candidates: key.depth.places(&mesh, &own_mm).into(),
            depth: key.depth,
            surface: own_mesh.and_then(|mesh| Surface::new(&mesh)).map(Arc::new),
        };
        // What cannot be placed leaves the body unpainted: the result panel shows why.
        let _ = place(&scenario, &plan, task, &mut |outcome| {
            report(outcome.clone());
        });
        None
    });
}

fn receive(
    mut layer: ResMut<PlacementLayer>,
    mut legends: ResMut<Legends>,
    mut diagnostics: ResMut<Diagnostics>,
) {
    let PlacementLayer { newest, counted, .. } = layer.bypass_change_detection();
    // Each picture's work holds that of the pictures before it.
    let count = |found: &PlacementOutcome| {
        diagnostics.work.placement_evaluations +=
            found.work.placement_evaluations - counted.placement_evaluations;
        *counted = found.work;
    };
    if newest.receive(count) {
        layer.set_changed();
        let found = layer.newest.found();
        legends
            .set_bar(LAYER.row.order, found.and_then(|(key, found)| bar(&layer.look, key, found)));
    }
}

fn bar(look: &Look, key: &Key, found: &PlacementOutcome) -> Option<ColorBar> {
    let [_, largest] = found.range_mm()?;
    let [min, max] = placement_range(found, look.range_mm)?;
    Some(ColorBar {
        label: format!(
            "{}, sensor here{}",
            Metric::TIP_RMS.label(),
            if found.is_final { "" } else { "…" },
        ),
        note: Some(format!("coil {}, axis {}", key.depth.name(), key.rule.name())),
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
    legends: Res<Legends>,
    painted: Query<Entity, With<Painted>>,
    roots: Query<(Entity, &BodyRoot)>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<PaintMaterial>>,
) {
    for entity in &painted {
        commands.entity(entity).despawn();
    }
    let (Some((key, found)), Some(mesh), Some(bar)) =
        (layer.newest.found(), &layer.mesh, legends.bar(LAYER.row.order))
    else {
        return;
    };
    let Some((root, _)) = roots.iter().find(|(_, root)| root.0 == key.body) else {
        return;
    };
    let material = materials.add(PaintMaterial::over_a_body());
    let mut colors = found.places.iter().map(|place| color(place.shown_mm(), bar));
    for part in mesh.mesh.body_parts() {
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

fn settings_ui(ui: &mut Ui, view: &mut View, context: &SettingsContext) {
    if !context.is_sensor_selected {
        row_ui(ui, "of", |ui| {
            quiet_ui(ui, "select a sensor");
        });
    }
    row_ui(ui, "turned", |ui| {
        ComboBox::from_id_salt("placement rule")
            .selected_text(view.placement_rule.name())
            .width(110.0)
            .show_ui(ui, |ui| {
                for rule in AxisRule::ALL {
                    ui.selectable_value(&mut view.placement_rule, rule, rule.name());
                }
            })
            .response
            .explained("Which way the sensor points where it is imagined");
    });
    row_ui(ui, "coil", |ui| {
        ComboBox::from_id_salt("placement depth")
            .selected_text(view.placement_depth.name())
            .width(110.0)
            .show_ui(ui, |ui| {
                for depth in CoilDepth::ALL {
                    ui.selectable_value(&mut view.placement_depth, depth, depth.name());
                }
            })
            .response
            .on_hover_text(
                "How deep below the surface the sensor is imagined: as deep as it is for a bore",
            );
    });
    let field = NumberField::length("placement's colour range in mm");
    let range = &mut view.placement_range_mm;
    range_ui(ui, &field, context.largest, range);
    let map = view.color_maps().placement;
    map_ui(ui, view, map);
}
