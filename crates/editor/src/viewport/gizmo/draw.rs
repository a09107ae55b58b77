//! The entities of the gizmo: arrows and rings in the colours of their axes, over everything.

use crate::document::requests::ActiveDrag;
use crate::scene::materials::glow::{GlowMaterial, Shown};
use crate::scene::screen_size::{ScreenSized, SizeBounds};
use crate::scene::shapes::GlyphShapes;
use crate::schedule::EditorSystems;
use crate::viewport::camera::OrbitRig;
use crate::viewport::gizmo::drag::HeldHandle;
use crate::viewport::gizmo::{CurrentGizmo, GizmoHandle, HoveredHandle, ShownGizmo};
use crate::{convert, palette};
use bevy::prelude::*;
use std::f32::consts::FRAC_PI_2;
use trackwright_geometry::gizmo::{self as core, ARROW_PX, HandleKind, RING_PX};
use trackwright_geometry::orbit::Axis;

/// On the screen, pixels.
const ROD_WIDTH_PX: f32 = 3.2;
const HEAD_WIDTH_PX: f32 = 12.0;
const HEAD_LENGTH_PX: f32 = 17.0;
const RING_WIDTH_PX: f32 = 2.6;

const RING_SIDES: usize = 8;
const RING_CORNERS: usize = 96;

const ALPHA: f32 = 0.95;

/// Later than sensors, which are drawn over their bodies in the same way.
const ORDER_MM: f32 = 24_000.0;

/// What is below it is as many pixels large as its transforms are in millimetres.
const PIXEL: SizeBounds = SizeBounds { true_mm: 0.0, least_px: 1.0, most_px: 1.0, extra_px: 0.0 };

/// When the entities follow [`CurrentGizmo`].
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct GizmoDrawSystems;

/// The parent of the handles that it was made for.
#[derive(Component)]
#[require(Visibility)]
struct GizmoRoot(&'static [core::Handle]);

/// A piece of a handle.
#[derive(Component)]
struct Piece(core::Handle);

#[derive(Resource)]
struct GizmoLook {
    ring: Handle<Mesh>,
    axes: [Handle<GlowMaterial>; 3],
    highlighted: Handle<GlowMaterial>,
}

pub(crate) fn plugin(app: &mut App) {
    app.add_systems(PreStartup, make_look).add_systems(
        Update,
        (
            (spawn, ApplyDeferred, place).chain().run_if(resource_changed::<CurrentGizmo>),
            highlight.run_if(has_another_look),
        )
            .chain()
            .in_set(GizmoDrawSystems)
            .in_set(EditorSystems::Draw),
    );
}

fn make_look(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<GlowMaterial>>,
) {
    let mut over_everything = |color| {
        let material = GlowMaterial::translucent(color, ALPHA, ALPHA);
        materials.add(material.shown(Shown::Always).order(ORDER_MM))
    };
    let ring = Torus { minor_radius: RING_WIDTH_PX / 2.0, major_radius: convert::length(RING_PX) };
    let ring = ring.mesh();
    commands.insert_resource(GizmoLook {
        ring: meshes.add(
            ring.minor_resolution(RING_SIDES)
                .major_resolution(RING_CORNERS)
                .build()
                // Bevy's torus lies around y.
                .rotated_by(Quat::from_rotation_x(FRAC_PI_2)),
        ),
        axes: palette::AXES.map(&mut over_everything),
        highlighted: over_everything(palette::SELECTED),
    });
}

/// Entities as long as the handles are the same: a drag would be lost with them.
fn spawn(
    mut commands: Commands,
    current: Res<CurrentGizmo>,
    drawn: Query<(Entity, &GizmoRoot)>,
    shapes: Res<GlyphShapes>,
    look: Res<GizmoLook>,
) {
    let wanted = current.0.map(|shown| shown.gizmo);
    let mut is_drawn = false;
    for (entity, root) in &drawn {
        if wanted.is_some_and(|gizmo| gizmo.handles == root.0) {
            is_drawn = true;
        } else {
            commands.entity(entity).despawn();
        }
    }
    let Some(gizmo) = wanted.filter(|_| !is_drawn) else {
        return;
    };
    let size = ScreenSized { at_mm: gizmo.pivot_mm(), across: PIXEL, along: PIXEL };
    commands
        .spawn((Name::new("gizmo"), GizmoRoot(gizmo.handles), Transform::default(), size))
        .with_children(|root| {
            for handle in gizmo.handles {
                spawn_handle(root, *handle, &shapes, &look);
            }
        });
}

fn spawn_handle(
    root: &mut ChildSpawnerCommands,
    handle: core::Handle,
    shapes: &GlyphShapes,
    look: &GizmoLook,
) {
    let turn = match handle.axis {
        Axis::X => Quat::from_rotation_y(FRAC_PI_2),
        Axis::Y => Quat::from_rotation_x(-FRAC_PI_2),
        Axis::Z => Quat::IDENTITY,
    };
    let own = Transform::from_rotation(turn);
    let material = look.axes[handle.axis as usize].clone();
    let mut entity = root.spawn((Name::new("gizmo handle"), GizmoHandle(handle), own));
    entity.with_children(|handle_pieces| {
        let mut piece = |mesh: &Handle<Mesh>, at: Transform| {
            handle_pieces.spawn((
                Piece(handle),
                Mesh3d(mesh.clone()),
                MeshMaterial3d(material.clone()),
                at,
            ));
        };
        match handle.kind {
            HandleKind::Ring => piece(&look.ring, Transform::default()),
            HandleKind::Arrow => {
                let [from, to] = ARROW_PX.map(convert::length);
                let neck = to - HEAD_LENGTH_PX;
                let rod = Vec3::new(ROD_WIDTH_PX, ROD_WIDTH_PX, neck - from);
                let head = Vec3::new(HEAD_WIDTH_PX, HEAD_WIDTH_PX, HEAD_LENGTH_PX);
                let at = |z: f32| Transform::from_translation(Vec3::Z * z);
                piece(&shapes.cylinder, at((from + neck) / 2.0).with_scale(rod));
                piece(&shapes.cone, at(neck).with_scale(head));
            }
        }
    });
}

fn place(
    current: Res<CurrentGizmo>,
    mut roots: Query<(&mut Transform, &mut ScreenSized), With<GizmoRoot>>,
) {
    let Some(ShownGizmo { gizmo, .. }) = current.0 else {
        return;
    };
    for (mut transform, mut size) in &mut roots {
        let wanted =
            Transform { scale: transform.scale, ..convert::transform(&gizmo.tracker_from_gizmo) };
        transform.set_if_neq(wanted);
        let at_mm = gizmo.pivot_mm();
        size.set_if_neq(ScreenSized { at_mm, ..*size });
    }
}

fn has_another_look(
    current: Res<CurrentGizmo>,
    hovered: Res<HoveredHandle>,
    held: Res<HeldHandle>,
    drag: Res<ActiveDrag>,
    rig: Res<OrbitRig>,
) -> bool {
    let is_shown = current.0.is_some();
    let is_used = hovered.is_changed() || held.is_changed() || drag.is_changed();
    is_shown && (is_used || current.is_changed() || rig.is_changed())
}

/// The one that is hovered stands out; while one, or anything else, is dragged the others make
/// room.
fn highlight(
    current: Res<CurrentGizmo>,
    (hovered, held): (Res<HoveredHandle>, Res<HeldHandle>),
    drag: Res<ActiveDrag>,
    rig: Res<OrbitRig>,
    look: Res<GizmoLook>,
    mut handles: Query<(&GizmoHandle, &mut Visibility)>,
    mut pieces: Query<(&Piece, &mut MeshMaterial3d<GlowMaterial>)>,
) {
    let Some(ShownGizmo { gizmo, .. }) = current.0 else {
        return;
    };
    let eye = rig.eye();
    for (GizmoHandle(handle), mut visibility) in &mut handles {
        let is_shown = match held.handle() {
            Some(held) => held == *handle,
            None => !drag.0 && gizmo.is_usable(*handle, &eye),
        };
        visibility.set_if_neq(match is_shown {
            true => Visibility::Inherited,
            false => Visibility::Hidden,
        });
    }
    for (Piece(handle), mut material) in &mut pieces {
        let is_highlighted = held.handle().or(hovered.0) == Some(*handle);
        let wanted = match is_highlighted {
            true => &look.highlighted,
            false => &look.axes[handle.axis as usize],
        };
        if material.0 != *wanted {
            material.0 = wanted.clone();
        }
    }
}
