//! The field's position error as arrows on a lattice through the volume: magnified so that they fill
//! the lattice without running into each other, coloured by their true length.

use crate::convert;
use crate::document::apply::WorldGeneration;
use crate::document::requests::OpenWorld;
use crate::document::shown::{ShownDesign, ShownSystems, ShownTrial};
use crate::layers::ColorBars;
use crate::layers::color_bar::ColorBar;
use crate::runner::diagnostics::Diagnostics;
use crate::runner::latest::Latest;
use crate::runner::wake::Waker;
use crate::scene::materials::paint::PaintMaterial;
use crate::schedule::EditorSystems;
use crate::viewport::light_drawing::{Shapes, paints_in_software};
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use nalgebra::{Point3, Unit, Vector3};
use std::sync::Arc;
use trackwright_geometry::colormap::ColorMap;
use trackwright_geometry::pointing::{Target, first_pointed_at};
use trackwright_geometry::surface::Ray;
use trackwright_scene::field_arrows::{Scale, arrow_plan, arrow_triangles, head_mm};
use trackwright_simulation::{ArrowOutcome, ArrowPlan, ArrowSensor, sample_arrows};

/// A spike's foot is a little wider than a shaft, so that it covers about as much.
const SPIKE_TO_HEAD: f64 = 0.6;

/// Samples and draws the arrows while their layer is on.
pub struct ArrowsPlugin;

#[derive(Component)]
struct Arrows;

/// What is sampled, and for what.
#[derive(Resource)]
pub(crate) struct ArrowLayer {
    latest: Latest<ArrowOutcome>,
    key: Option<Key>,
    look: Look,
    found: Option<ArrowOutcome>,
}

/// How arrows are coloured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Look {
    map: ColorMap,
    range_mm: Option<f64>,
}

impl Look {
    fn max_mm(&self, found: &ArrowOutcome) -> f64 {
        self.range_mm.unwrap_or(found.p95_mm)
    }
}

impl ArrowLayer {
    /// The length of the error whose arrow a ray meets first, and how far along the ray.
    pub fn pointed_at(&self, ray: &Ray, reach_rad: f64) -> Option<(f64, f64)> {
        let found = self.found.as_ref()?;
        let scale = Scale::of(found);
        let arrows = found.arrows().map(|(from, error)| {
            let arrow = scale.drawn(&error);
            Target {
                ends_mm: [from, from + arrow],
                radius_mm: head_mm(arrow.norm()),
                is: error.norm(),
            }
        });
        first_pointed_at(ray, reach_rad, arrows)
    }

    /// What an arrow is called.
    pub fn quantity(&self) -> &'static str {
        match self.key.as_ref().map(|key| key.plan.sensor) {
            Some(ArrowSensor::OfTool) => "position error of the tool",
            _ => "position error",
        }
    }
}

/// What arrows depend on.
#[derive(Clone, Debug, PartialEq)]
struct Key {
    generation: u64,
    /// The room's address: another room is another one.
    environment: usize,
    plan: ArrowPlan,
    /// For arrows that depend on the design: its revision, and which trial shows it.
    design: Option<(u64, Option<ShownTrial>)>,
}

impl FromWorld for ArrowLayer {
    fn from_world(world: &mut World) -> Self {
        Self {
            latest: Latest::new("arrows", world.get_resource_or_init::<Waker>().clone()),
            key: None,
            look: Look::default(),
            found: None,
        }
    }
}

impl Plugin for ArrowsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ArrowLayer>()
            .init_resource::<ColorBars>()
            .init_resource::<Diagnostics>()
            .init_resource::<WorldGeneration>()
            .add_systems(
                Update,
                (ask.run_if(resource_exists::<OpenWorld>).run_if(may_differ), hear.run_if(is_on))
                    .chain()
                    // The trial of now, not that of the frame before.
                    .after(ShownSystems::Follow)
                    .in_set(EditorSystems::Sample),
            )
            .add_systems(
                Update,
                draw.run_if(resource_changed::<ArrowLayer>).in_set(EditorSystems::Draw),
            );
    }
}

pub(crate) fn is_idle(world: &World) -> bool {
    world.get_resource::<ArrowLayer>().is_none_or(|layer| layer.latest.is_idle())
}

fn is_on(layer: Res<ArrowLayer>) -> bool {
    layer.key.is_some()
}

fn may_differ(world: Res<OpenWorld>, shown: Option<Res<ShownDesign>>) -> bool {
    world.is_changed() || shown.is_some_and(|shown| shown.is_changed())
}

fn key(world: &OpenWorld, shown: Option<&ShownDesign>, generation: u64) -> Option<Key> {
    let document = &world.0.document;
    let view = document.view();
    if !view.layers.arrows {
        return None;
    }
    Some(Key {
        generation,
        environment: Arc::as_ptr(&world.0.environment).addr(),
        plan: arrow_plan(view),
        design: view.arrows.of_tool.then(|| {
            let trial = shown.and_then(|shown| shown.trial.clone());
            (document.revision(), trial)
        }),
    })
}

fn ask(
    mut layer: ResMut<ArrowLayer>,
    world: Res<OpenWorld>,
    shown: Option<Res<ShownDesign>>,
    generation: Res<WorldGeneration>,
    mut bars: ResMut<ColorBars>,
) {
    let view = world.0.document.view();
    let look = Look { map: view.slice.color_map, range_mm: view.arrows.range_mm };
    if layer.bypass_change_detection().look != look {
        layer.look = look;
        bars.arrows = layer.found.as_ref().map(|found| bar(&layer, found));
    }
    let key = key(&world, shown.as_deref(), generation.0);
    if layer.bypass_change_detection().key == key {
        return;
    }
    layer.key.clone_from(&key);
    let Some(key) = key else {
        // A layer that is off keeps nothing.
        layer.latest.give_up();
        layer.found = None;
        bars.arrows = None;
        return;
    };
    // The tool's sensors point as they do where the tool is seen.
    let design = match &shown {
        Some(shown) => &shown.design,
        None => world.0.document.design(),
    };
    let scenario = trackwright_project::resolve(design, &world.0.environment);
    let work = move |task: &trackwright_task::Task, found: &mut dyn FnMut(ArrowOutcome)| {
        if let Ok(outcome) = sample_arrows(&scenario, &key.plan, &task.cancel) {
            found(outcome);
        }
    };
    if let Err(error) = layer.latest.wish(Box::new(work)) {
        warn!("no thread for the arrows: {error}");
    }
}

fn hear(
    mut layer: ResMut<ArrowLayer>,
    mut bars: ResMut<ColorBars>,
    mut diagnostics: ResMut<Diagnostics>,
) {
    let Some(found) = layer.bypass_change_detection().latest.answers().pop() else {
        return;
    };
    diagnostics.work += found.work;
    bars.arrows = Some(bar(&layer, &found));
    layer.found = Some(found);
}

fn bar(layer: &ArrowLayer, found: &ArrowOutcome) -> ColorBar {
    let quantity = layer.quantity();
    ColorBar {
        label: match Scale::of(found).times {
            1.0 => format!("{quantity}, arrows"),
            times => format!("{quantity}, arrows × {times}"),
        },
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
    let Some(found) = &layer.found else {
        return;
    };
    let fine = meshes.add(mesh(found, &layer.look, push_arrow));
    let shapes = match paints_in_software(adapter) {
        true => Shapes::two(fine, meshes.add(mesh(found, &layer.look, push_spike))),
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
fn mesh(found: &ArrowOutcome, look: &Look, push: Push) -> Mesh {
    let mut painted = convert::Painted::default();
    let (scale, max_mm) = (Scale::of(found), look.max_mm(found));
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
