//! The field's position error as arrows on a lattice through the volume: magnified so that they fill
//! the lattice without running into each other, coloured by their true length.

use crate::convert;
use crate::document::requests::OpenWorld;
use crate::document::shown::{ShownDesign, ShownSystems, ShownTrial};
use crate::document::state::WorldGeneration;
use crate::layers::legend::{ColorBar, Legends};
use crate::layers::registry::{
    AddLayer, LayerInfo, ProbeInfo, ProbeRay, Probed, SettingsContext, is_layer_on,
};
use crate::layers::settings::{map_ui, range_ui, row_ui, sensor_axis_ui};
use crate::layers::slice::SliceScaleSystems;
use crate::layers::slice_picture::ColorScale;
use crate::runner::diagnostics::Diagnostics;
use crate::runner::jobs::Newest;
use crate::runner::wake::Waker;
use crate::scene::body_meshes::{Shapes, paints_in_software};
use crate::scene::materials::paint::PaintMaterial;
use crate::schedule::EditorSystems;
use crate::widgets::basic::{self, NumberField, decimal, with_unit};
use crate::widgets::tooltip::Explain;
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use bevy_egui::egui::{Slider, Ui};
use nalgebra::{Point3, Unit, Vector3};
use std::sync::Arc;
use trackwright_design::view::{ArrowsView, Layer, View};
use trackwright_geometry::colormap::ColorMap;
use trackwright_geometry::pointing::{Target, first_pointed_at};
use trackwright_scene::field_arrows::{Scale, arrow_plan, arrow_triangles, head_mm};
use trackwright_simulation::{ArrowOutcome, ArrowPlan, ArrowSensor, sample_arrows};

/// A spike's foot is a little wider than a shaft, so that it covers about as much.
const SPIKE_TO_HEAD: f64 = 0.6;

/// The layer.
pub const LAYER: LayerInfo = LayerInfo {
    is_of_room: true,
    settings: Some(settings_ui),
    is_idle,
    ..LayerInfo::new(&Layer::ARROWS)
};

/// Samples and draws the arrows while their layer is on.
pub struct ArrowsPlugin;

#[derive(Component)]
struct Arrows;

/// What is sampled, and for what.
#[derive(Resource)]
struct ArrowLayer {
    newest: Newest<Key, ArrowOutcome>,
    look: Look,
    /// How many times larger than life arrows are, and what they were when that was chosen: it stays
    /// while the tool moves, so that an arrow that grows is an error that grew.
    times: Option<(Lattice, f64)>,
}

/// How arrows are coloured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Look {
    map: ColorMap,
    /// Where colours end: those of the slice, or what a person set; `None` is automatic.
    range_mm: Option<f64>,
}

/// The arrows of a room, wherever the tool is.
#[derive(Clone, Debug, PartialEq)]
struct Lattice {
    generation: u64,
    environment: usize,
    plan: ArrowPlan,
}

impl Look {
    fn max_mm(&self, found: &ArrowOutcome) -> f64 {
        self.range_mm.unwrap_or(found.p95_mm)
    }
}

impl ArrowLayer {
    fn found(&self) -> Option<&ArrowOutcome> {
        self.newest.found().map(|(_, found)| found)
    }

    /// How the arrows that were found are drawn.
    fn scale(&self, found: &ArrowOutcome) -> Scale {
        let own = Scale::of(found);
        self.times.as_ref().map_or(own, |(_, times)| Scale { times: *times, ..own })
    }

    /// Keeps the magnification, or chooses one for other arrows.
    fn choose_times(&mut self) {
        let Some((key, found)) = self.newest.found() else { return };
        if self.times.as_ref().is_none_or(|(lattice, _)| *lattice != key.lattice) {
            self.times = Some((key.lattice.clone(), Scale::of(found).times));
        }
    }

    /// The length of the error whose arrow a ray meets first, and how far along the ray.
    fn pointed_at(&self, probe: &ProbeRay) -> Option<(f64, f64)> {
        let found = self.found()?;
        let scale = self.scale(found);
        let arrows = found.arrows().map(|(from, error)| {
            let arrow = scale.drawn(&error);
            Target {
                ends_mm: [from, from + arrow],
                radius_mm: head_mm(arrow.norm()),
                is: error.norm(),
            }
        });
        first_pointed_at(&probe.ray, probe.reach_rad, arrows)
    }

    /// What an arrow is called.
    fn quantity(&self) -> &'static str {
        match self.newest.requested().map(|key| key.lattice.plan.sensor) {
            Some(ArrowSensor::OfTool) => "position error of the tool",
            _ => "position error",
        }
    }
}

/// What arrows depend on.
#[derive(Clone, Debug, PartialEq)]
struct Key {
    /// The room is its address: another room is another one.
    lattice: Lattice,
    /// For arrows that depend on the design: its revision, and which trial or live pose shows it.
    design: Option<(u64, Option<ShownTrial>, Option<usize>)>,
}

impl FromWorld for ArrowLayer {
    fn from_world(world: &mut World) -> Self {
        Self {
            newest: Newest::new("arrows", world.get_resource_or_init::<Waker>().clone()),
            look: Look::default(),
            times: None,
        }
    }
}

impl Plugin for ArrowsPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER)
            .add_probe(ProbeInfo { is_on: |world| is_layer_on(world, &LAYER), value: value_at })
            .init_resource::<ArrowLayer>()
            .add_systems(
                Update,
                (
                    request.run_if(resource_exists::<OpenWorld>).run_if(may_differ),
                    receive.run_if(is_on),
                )
                    .chain()
                    // The trial and the scale of now, not those of the frame before.
                    .after(ShownSystems::Follow)
                    .after(SliceScaleSystems)
                    .in_set(EditorSystems::Sample),
            )
            .add_systems(
                Update,
                draw.run_if(resource_changed::<ArrowLayer>).in_set(EditorSystems::Draw),
            );
    }
}

fn is_idle(world: &World) -> bool {
    world.get_resource::<ArrowLayer>().is_none_or(|layer| layer.newest.is_idle())
}

fn value_at(world: &World, probe: &ProbeRay) -> Option<Probed> {
    let layer = world.get_resource::<ArrowLayer>()?;
    let (distance_mm, value_mm) = layer.pointed_at(probe)?;
    let value = with_unit(&decimal(value_mm, 2), "mm");
    Some(Probed { distance_mm, words: Some(format!("{} {value}", layer.quantity())) })
}

fn is_on(layer: Res<ArrowLayer>) -> bool {
    layer.newest.requested().is_some()
}

/// Live poses come while the arrows of an older one are still computed: those are shown first, so that
/// arrows move at all.
fn may_differ(
    world: Res<OpenWorld>,
    shown: Option<Res<ShownDesign>>,
    slice: Option<Res<ColorScale>>,
    layer: Res<ArrowLayer>,
) -> bool {
    let is_live = shown.as_ref().is_some_and(|shown| shown.live.is_some());
    let is_behind = is_live && layer.newest.requested().is_some() && layer.newest.is_idle();
    world.is_changed()
        || is_behind
        || shown.is_some_and(|shown| shown.is_changed())
        || slice.is_some_and(|slice| slice.is_changed())
}

fn key(world: &OpenWorld, shown: Option<&ShownDesign>, generation: u64) -> Option<Key> {
    let document = &world.0.document;
    let view = document.view();
    if !view.layers.arrows {
        return None;
    }
    Some(Key {
        lattice: Lattice {
            generation,
            environment: Arc::as_ptr(&world.0.environment).addr(),
            plan: arrow_plan(view),
        },
        design: view.arrows.of_tool.then(|| {
            let trial = shown.and_then(|shown| shown.trial.clone());
            (document.revision(), trial, shown.and_then(|shown| shown.live))
        }),
    })
}

fn request(
    mut layer: ResMut<ArrowLayer>,
    world: Res<OpenWorld>,
    shown: Option<Res<ShownDesign>>,
    generation: Res<WorldGeneration>,
    slice: Option<Res<ColorScale>>,
    mut legends: ResMut<Legends>,
) {
    let view = world.0.document.view();
    // One quantity has one scale.
    let of_slice = slice.filter(|scale| view.arrows_share_scale() && scale.max_mm > 0.0);
    let range_mm = of_slice.map_or(view.arrows.range_mm, |scale| Some(scale.max_mm));
    let look = Look { map: view.color_maps().arrows, range_mm };
    if layer.bypass_change_detection().look != look {
        layer.look = look;
        legends.set_bar(LAYER.row.order, layer.found().map(|found| bar(&layer, found)));
    }
    let key = key(&world, shown.as_deref(), generation.0);
    if layer.newest.requested() == key.as_ref() {
        return;
    }
    let is_live = shown.as_ref().is_some_and(|shown| shown.live.is_some());
    if is_live && key.is_some() && !layer.newest.is_idle() {
        return;
    }
    let Some(key) = key else {
        // A layer that is off keeps nothing.
        layer.newest.give_up();
        layer.times = None;
        legends.set_bar(LAYER.row.order, None);
        return;
    };
    // The tool's sensors point as they do where the tool is seen.
    let design = match &shown {
        Some(shown) => &shown.design,
        None => world.0.document.design(),
    };
    let scenario = trackwright_project::resolve(design, &world.0.environment);
    let plan = key.lattice.plan;
    layer.newest.request(key, move |task, _| sample_arrows(&scenario, &plan, &task.cancel).ok());
}

fn receive(
    mut layer: ResMut<ArrowLayer>,
    mut legends: ResMut<Legends>,
    mut diagnostics: ResMut<Diagnostics>,
) {
    let count = |found: &ArrowOutcome| diagnostics.work += found.work;
    if layer.bypass_change_detection().newest.receive(count) {
        layer.choose_times();
        layer.set_changed();
        legends.set_bar(LAYER.row.order, layer.found().map(|found| bar(&layer, found)));
    }
}

fn bar(layer: &ArrowLayer, found: &ArrowOutcome) -> ColorBar {
    let quantity = layer.quantity();
    ColorBar {
        label: match layer.scale(found).times {
            1.0 => format!("{quantity}, arrows"),
            times => format!("{quantity}, arrows {}× larger", basic::times(times)),
        },
        note: None,
        unit: "mm",
        map: layer.look.map,
        min: 0.0,
        max: layer.look.max_mm(found),
        largest: found.max_mm,
        decimals: 2,
        limit: None,
    }
}

fn draw(
    mut commands: Commands,
    layer: Res<ArrowLayer>,
    drawn: Query<Entity, With<Arrows>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<PaintMaterial>>,
    adapter: Option<Res<RenderAdapterInfo>>,
) {
    for entity in &drawn {
        commands.entity(entity).despawn();
    }
    let Some(found) = layer.found() else {
        return;
    };
    let scale = layer.scale(found);
    let fine = meshes.add(mesh(found, &layer.look, scale, push_arrow));
    let shapes = match paints_in_software(adapter) {
        true => Shapes::two(fine, meshes.add(mesh(found, &layer.look, scale, push_spike))),
        false => Shapes::one(fine),
    };
    commands.spawn((
        Name::new("field arrows"),
        Arrows,
        Mesh3d(shapes.fine.clone()),
        shapes,
        MeshMaterial3d(materials.add(PaintMaterial::flat())),
    ));
}

/// Adds the triangles of an arrow from a place, in a colour.
type Push = fn(&mut convert::Painted, &Point3<f64>, &Vector3<f64>, [f32; 4]);

/// All arrows as one mesh: one thing to draw, however many there are.
fn mesh(found: &ArrowOutcome, look: &Look, scale: Scale, push: Push) -> Mesh {
    let mut painted = convert::Painted::default();
    let max_mm = look.max_mm(found);
    for (from, error) in found.arrows() {
        let color = convert::linear(look.map.srgb_of_value(error.norm(), max_mm));
        push(&mut painted, &from, &scale.drawn(&error), color);
    }
    painted.mesh()
}

/// Three sides that meet in the tip: what an arrow comes to while something moves in software.
fn push_spike(
    painted: &mut convert::Painted,
    from: &Point3<f64>,
    arrow: &Vector3<f64>,
    color: [f32; 4],
) {
    const SIDES: usize = 3;
    let Some(along) = arrow.try_normalize(1e-9) else {
        return;
    };
    let across = trackwright_geometry::rotation::perpendicular(&Unit::new_unchecked(along));
    let other = along.cross(&across);
    let radius_mm = head_mm(arrow.norm()) * SPIKE_TO_HEAD;
    let foot: [_; SIDES] = std::array::from_fn(|k| {
        let angle = std::f64::consts::TAU * k as f64 / SIDES as f64;
        let out = across.into_inner() * angle.cos() + other * angle.sin();
        (from + out * radius_mm, out)
    });
    painted.pyramid(&foot, (from + arrow, along), color);
}

/// A shaft and a head with flat sides.
fn push_arrow(
    painted: &mut convert::Painted,
    from: &Point3<f64>,
    arrow: &Vector3<f64>,
    color: [f32; 4],
) {
    arrow_triangles(from, arrow, |corners_mm, normal| {
        painted.triangle(corners_mm, normal, color);
    });
}

fn settings_ui(ui: &mut Ui, view: &mut View, context: &SettingsContext) {
    row_ui(ui, "of", |ui| {
        for (of_tool, name, about) in [
            (false, "a sensor", "A sensor that is imagined at each arrow"),
            (true, "the tool's", "The mean of the tool's own sensors, turned as the tool is seen"),
        ] {
            let label = ui.selectable_label(view.arrows.of_tool == of_tool, name);
            if label.explained(about).clicked() {
                view.arrows.of_tool = of_tool;
            }
        }
    });
    if !view.arrows.of_tool {
        sensor_axis_ui(ui, &mut view.slice.sensor_axis);
    }
    row_ui(ui, "per side", |ui| {
        ui.spacing_mut().slider_width = 70.0;
        let mut per_side = view.arrows.per_side();
        let slider = Slider::new(&mut per_side, ArrowsView::PER_SIDE);
        let about = "How many arrows stand along each side of the lattice";
        let response = ui.add(slider).explained(about);
        ui.ctx().accesskit_node_builder(response.id, |node| {
            node.set_label("arrows per side".to_owned());
        });
        if response.changed() {
            view.arrows.per_side = per_side;
        }
    });
    let field = NumberField::length("arrows' colour range in mm");
    if view.arrows_share_scale() {
        let mut range_mm = view.slice_range();
        range_ui(ui, &field, context.largest, &mut range_mm);
        view.set_slice_range(range_mm);
    } else {
        range_ui(ui, &field, context.largest, &mut view.arrows.range_mm);
    }
    let map = view.color_maps().arrows;
    map_ui(ui, view, map);
}
