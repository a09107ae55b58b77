//! Sensors: an amber coil with one axis (5-DOF) or a triad (6-DOF), an amber ball for a marker; its
//! outline when selected, its mark when outside.
//!
//! A coil is drawn at its true size within bounds on the screen. What a shaft hides of it shines
//! through, dimmed and still amber.

use crate::document::requests::OpenWorld;
use crate::document::selection::{Hovered, Selected, Selection};
use crate::document::shown::ShownDesign;
use crate::layers::legend::{Legend, LegendKey, Legends, Swatch};
use crate::runner::results::Results;
use crate::scene::materials::glow::{GlowMaterial, Shown};
use crate::scene::screen_size::{ScreenSized, SizeBounds};
use crate::scene::shapes::GlyphShapes;
use crate::scene::{BodyRoot, SensorMark};
use crate::schedule::EditorSystems;
use crate::{convert, palette};
use bevy::prelude::*;
use nalgebra::Point3;
use trackwright_design::BodyRole;
use trackwright_scene::sensor_look::{
    AXIS_HEAD_LENGTH, AXIS_HEAD_WIDTH, AXIS_WIDTH, HATCH_AT, HATCH_SCALE, HATCH_SLANT_RAD,
    SensorLook,
};
use trackwright_simulation::BodyDetail;
use trackwright_simulation::body::Sensor;

/// Opacity of what shines through.
const HIDDEN_ALPHA: f32 = 0.9;

/// Both sides of an outline together.
const OUTLINE_PX: f64 = 4.0;

/// In the legend the mark comes after the sensors.
const OUTSIDE_LEGEND_ORDER: u32 = 1;

/// Later than everything else that is translucent.
const ORDER_MM: f32 = 20_000.0;

/// Draws the sensors of both bodies.
pub struct SensorsPlugin;

/// What a sensor's entity was made for: anything else makes it anew.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
struct Look(SensorLook);

/// Shown while its sensor is selected or hovered.
#[derive(Component)]
struct Outline(SensorMark);

/// Shown while its sensor is outside the model's box or the measurement volume.
#[derive(Component)]
struct OutsideHatch(SensorMark);

/// Coil or axes, each scaled to its own size on the screen.
#[derive(Component)]
struct Part(SensorMark);

#[derive(Resource)]
struct SensorMaterials {
    coil: [Handle<GlowMaterial>; 2],
    axis: [Handle<GlowMaterial>; 2],
    triad: [[Handle<GlowMaterial>; 2]; 3],
    selected: Handle<GlowMaterial>,
    outside: Handle<GlowMaterial>,
}

impl Plugin for SensorsPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PreStartup, make_materials).add_systems(
            Update,
            (
                (spawn_sensors, ApplyDeferred, place_sensors)
                    .chain()
                    .run_if(resource_exists_and_changed::<ShownDesign>),
                outline,
                mark_outside.run_if(resource_changed::<Results>),
            )
                .chain()
                .after(crate::scene::bodies::BodiesSystems)
                .in_set(EditorSystems::Draw),
        );
    }
}

fn make_materials(mut commands: Commands, mut materials: ResMut<Assets<GlowMaterial>>) {
    let mut both = |color: palette::Rgb| {
        // Also over what is seen anyway: it covers the middle of the outline, which is drawn
        // before it.
        let hidden = GlowMaterial::translucent(color, HIDDEN_ALPHA, HIDDEN_ALPHA)
            .shown(Shown::Always)
            .order(ORDER_MM);
        [materials.add(GlowMaterial::solid(color)), materials.add(hidden)]
    };
    let coil = both(palette::SENSOR);
    let axis = both(palette::SENSOR_AXIS);
    let triad = [palette::AXIS_X, palette::AXIS_Y, palette::AXIS_Z].map(&mut both);
    commands.insert_resource(SensorMaterials {
        coil,
        axis,
        triad,
        selected: materials.add(GlowMaterial::outline(palette::SELECTED).order(ORDER_MM - 1000.0)),
        outside: materials.add(
            GlowMaterial::translucent(palette::OUTSIDE, 0.95, 0.95)
                .shown(Shown::Always)
                .order(ORDER_MM),
        ),
    });
}

fn spawn_sensors(
    mut commands: Commands,
    shown: Res<ShownDesign>,
    roots: Query<(Entity, &BodyRoot)>,
    drawn: Query<(Entity, &SensorMark, &Look, &ChildOf)>,
    shapes: Res<GlyphShapes>,
    materials: Res<SensorMaterials>,
) {
    for (root, BodyRoot(role)) in &roots {
        let Some(body) = shown.design.body(*role) else {
            continue;
        };
        let sensors = &body.rigid.sensors;
        let mut has = vec![false; sensors.len()];
        for (entity, mark, look, _) in drawn.iter().filter(|(.., of)| of.parent() == root) {
            if sensors.get(mark.index).map(look_of) == Some(*look) && mark.body == *role {
                has[mark.index] = true;
            } else {
                commands.entity(entity).despawn();
            }
        }
        for (index, sensor) in sensors.iter().enumerate().filter(|(i, _)| !has[*i]) {
            let mark = SensorMark { body: *role, index };
            let entity = spawn_sensor(&mut commands, mark, look_of(sensor), &shapes, &materials);
            commands.entity(root).add_child(entity);
        }
    }
}

fn look_of(sensor: &Sensor) -> Look {
    Look(SensorLook::of(sensor))
}

/// A coil along z and its axes, each with its own size on the screen; or a ball.
fn spawn_sensor(
    commands: &mut Commands,
    mark: SensorMark,
    look: Look,
    shapes: &GlyphShapes,
    materials: &SensorMaterials,
) -> Entity {
    let Look(drawn) = look;
    let (across, along) = drawn.drawn_size();
    let size = ScreenSized { at_mm: Point3::origin(), across, along };
    let is_marker = drawn.is_marker();
    let (shape, outline) = match is_marker {
        true => (&shapes.ball, &shapes.ball),
        false => (&shapes.coil, &shapes.cylinder),
    };
    let mut sensor = commands.spawn((Name::new("sensor"), mark, look));
    sensor.with_children(|sensor| {
        sensor
            .spawn((Part(mark), size, Transform::default(), Visibility::default()))
            .with_children(|coil| spawn_coil(coil, mark, (shape, &shapes.cylinder), materials));
        let outlined = |size: SizeBounds| SizeBounds { extra_px: OUTLINE_PX, ..size };
        sensor.spawn((
            Part(mark),
            Outline(mark),
            ScreenSized { across: outlined(size.across), along: outlined(size.along), ..size },
            Visibility::Hidden,
            Mesh3d(outline.clone()),
            MeshMaterial3d(materials.selected.clone()),
        ));
        if is_marker {
            return;
        }
        let length = drawn.axis_size();
        let axes = ScreenSized { across: length, along: length, ..size };
        sensor
            .spawn((Part(mark), axes, Transform::default(), Visibility::default()))
            .with_children(|axes| {
                if drawn.degrees_of_freedom == 6 {
                    let quarter = std::f32::consts::FRAC_PI_2;
                    let [x, y, z] = &materials.triad;
                    spawn_axis(axes, x, Quat::from_rotation_y(quarter), shapes);
                    spawn_axis(axes, y, Quat::from_rotation_x(-quarter), shapes);
                    spawn_axis(axes, z, Quat::IDENTITY, shapes);
                } else {
                    spawn_axis(axes, &materials.axis, Quat::IDENTITY, shapes);
                }
            });
    });
    sensor.id()
}

fn spawn_coil(
    coil: &mut ChildSpawnerCommands,
    mark: SensorMark,
    (shape, disc): (&Handle<Mesh>, &Handle<Mesh>),
    materials: &SensorMaterials,
) {
    for material in &materials.coil {
        coil.spawn((Mesh3d(shape.clone()), MeshMaterial3d(material.clone())));
    }
    for at in HATCH_AT {
        coil.spawn((
            OutsideHatch(mark),
            Visibility::Hidden,
            Mesh3d(disc.clone()),
            MeshMaterial3d(materials.outside.clone()),
            Transform::from_translation(Vec3::Z * at as f32)
                .with_rotation(Quat::from_rotation_x(HATCH_SLANT_RAD as f32))
                .with_scale(Vec3::from(HATCH_SCALE.map(|part| part as f32))),
        ));
    }
}

/// From the middle of the coil along `turn * z`.
fn spawn_axis(
    axes: &mut ChildSpawnerCommands,
    materials: &[Handle<GlowMaterial>; 2],
    turn: Quat,
    shapes: &GlyphShapes,
) {
    let [width, head_width, head_length] =
        [AXIS_WIDTH, AXIS_HEAD_WIDTH, AXIS_HEAD_LENGTH].map(|part| part as f32);
    let rod_length = 1.0 - head_length;
    let rod = Transform::from_translation(turn * Vec3::Z * (rod_length / 2.0))
        .with_rotation(turn)
        .with_scale(Vec3::new(width, width, rod_length));
    let head = Transform::from_translation(turn * Vec3::Z * rod_length)
        .with_rotation(turn)
        .with_scale(Vec3::new(head_width, head_width, head_length));
    for (mesh, at) in [(&shapes.cylinder, rod), (&shapes.cone, head)] {
        for material in materials {
            axes.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()), at));
        }
    }
}

fn place_sensors(
    world: Res<OpenWorld>,
    shown: Res<ShownDesign>,
    mut sensors: Query<(&SensorMark, &mut Transform, &mut Visibility)>,
    mut parts: Query<(&Part, &mut ScreenSized)>,
) {
    let design = &shown.design;
    let sensor_of = |mark: &SensorMark| design.body(mark.body)?.rigid.sensors.get(mark.index);
    let hidden = &world.0.document.view().hidden;
    for (mark, mut transform, mut visibility) in &mut sensors {
        if let Some(sensor) = sensor_of(mark) {
            visibility.set_if_neq(match hidden.has_sensor(mark.body, &sensor.name) {
                true => Visibility::Hidden,
                false => Visibility::Inherited,
            });
            transform.set_if_neq(convert::transform(&sensor.body_from_sensor()));
        }
    }
    for (Part(mark), mut size) in &mut parts {
        if let (Some(sensor), Some(pose)) = (sensor_of(mark), design.tracker_from_body(mark.body)) {
            let at_mm = pose * sensor.position_in_body;
            size.set_if_neq(ScreenSized { at_mm, ..*size });
        }
    }
}

/// How wide and how long a sensor is drawn: its coil, or a marker's ball.
pub fn drawn_size(sensor: &Sensor) -> (SizeBounds, SizeBounds) {
    SensorLook::of(sensor).drawn_size()
}

fn outline(
    selection: Res<Selection>,
    hovered: Res<Hovered>,
    mut outlines: Query<(&Outline, &mut Visibility)>,
) {
    for (Outline(mark), mut visibility) in &mut outlines {
        let me = Selected::Sensor(mark.body, mark.index);
        let wanted = if selection.contains(me) || hovered.0 == Some(me) {
            Visibility::Inherited
        } else {
            Visibility::Hidden
        };
        visibility.set_if_neq(wanted);
    }
}

fn mark_outside(
    results: Res<Results>,
    mut hatches: Query<(&OutsideHatch, &mut Visibility)>,
    mut legends: ResMut<Legends>,
) {
    let mut is_any_outside = false;
    let detail = results.pose.as_ref().map(|pose| &pose.value);
    for (OutsideHatch(mark), mut visibility) in &mut hatches {
        let body: Option<&BodyDetail> = detail.and_then(|detail| match mark.body {
            BodyRole::Tool => Some(&detail.tool),
            BodyRole::Crf => detail.crf.as_ref(),
        });
        let is_outside = body
            .and_then(|body| body.sensors.get(mark.index))
            .is_some_and(|sensor| !(sensor.is_inside && sensor.is_in_volume));
        is_any_outside |= is_outside;
        visibility.set_if_neq(if is_outside { Visibility::Inherited } else { Visibility::Hidden });
    }
    let words = "sensor outside the room's box or the volume";
    let key = is_any_outside.then(|| LegendKey::new(Swatch::Line(palette::OUTSIDE), words));
    let legend = Legend { keys: key.into_iter().collect(), ..Legend::default() };
    legends.set(OUTSIDE_LEGEND_ORDER, legend);
}
