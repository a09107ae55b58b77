//! A plane through the room coloured by position error, and the handle that moves it.
//!
//! Sampling is the solver's; this only draws.

use crate::document::requests::{ActiveDrag, OpenWorld, ViewRequest};
use crate::layers::color_bar::ColorScale;
use crate::layers::slice_picture::{SliceLook, inset, picture};
use crate::runner::results::Results;
use crate::scene::materials::glow::GlowMaterial;
use crate::scene::materials::map::MapMaterial;
use crate::scene::shapes::GlyphShapes;
use crate::schedule::EditorSystems;
use crate::shell::window::{DragReadout, DragText, Workspace};
use crate::viewport::ball_handle::{self, BallHandle};
use crate::viewport::camera::Sight;
use crate::{convert, palette};
use bevy::asset::RenderAssetUsages;
use bevy::ecs::system::SystemParam;
use bevy::mesh::Indices;
use bevy::picking::events::{Drag, DragEnd, DragStart, Pointer};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use bevy::render::render_resource::PrimitiveTopology;
use nalgebra::{Point3, Unit, Vector3};
use trackwright_geometry::colormap::ColorMap;
use trackwright_simulation::SliceOutcome;

/// Draws the slice while its layer is on.
pub struct SlicePlugin;

#[derive(Component)]
struct Slice;

/// A ball on the slice's edge: dragging it moves the slice along its normal.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[require(Transform, Visibility)]
pub struct SliceHandle {
    pub at_mm: Point3<f64>,
    pub normal: Unit<Vector3<f64>>,
}

/// A slice that is being moved: where it and the pointer were on the line along its normal.
#[derive(Resource, Default)]
struct SliceDrag(Option<HeldSlice>);

#[derive(Clone, Copy, Debug)]
struct HeldSlice {
    handle: SliceHandle,
    start_mm: f64,
    grabbed_at_mm: f64,
}

impl Plugin for SlicePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<SliceDrag>()
            .insert_resource(ColorScale { map: ColorMap::default(), max_mm: 0.0 })
            .add_observer(on_drag_start)
            .add_observer(on_drag)
            .add_observer(on_drag_end)
            .add_systems(
                Update,
                (
                    choose_scale.in_set(EditorSystems::Sample),
                    (draw, place_handle).chain().in_set(EditorSystems::Draw),
                )
                    .run_if(needs_drawing),
            );
    }
}

fn needs_drawing(world: Option<Res<OpenWorld>>, results: Res<Results>) -> bool {
    world.is_some_and(|world| world.is_changed() || results.is_changed())
}

fn choose_scale(world: Res<OpenWorld>, results: Res<Results>, mut scale: ResMut<ColorScale>) {
    let view = &world.0.document.view().slice;
    let max_mm =
        view.range_mm.or(results.slice.as_ref().map(|slice| slice.value.p95)).unwrap_or(0.0);
    scale.set_if_neq(ColorScale { map: view.color_map, max_mm });
}

/// What a slice is made of.
#[derive(SystemParam)]
struct SliceAssets<'w> {
    meshes: ResMut<'w, Assets<Mesh>>,
    images: ResMut<'w, Assets<Image>>,
    materials: ResMut<'w, Assets<MapMaterial>>,
}

/// Mesh and picture anew with every result: there is one only when something changed.
fn draw(
    mut commands: Commands,
    world: Res<OpenWorld>,
    results: Res<Results>,
    scale: Res<ColorScale>,
    drawn: Query<Entity, With<Slice>>,
    mut assets: SliceAssets,
    mut last: Local<Option<(SliceOutcome, SliceLook)>>,
) {
    let is_on = world.0.document.view().layers.slice;
    let Some(slice) = results.slice.as_ref().filter(|_| is_on) else {
        for entity in &drawn {
            commands.entity(entity).despawn();
        }
        *last = None;
        return;
    };
    let requirement = world.0.document.design().requirement;
    let look = SliceLook {
        scale: *scale,
        level: requirement.and_then(|of| slice.value.quantity.limit(&of)),
    };
    if last.as_ref().is_some_and(|(old, with)| *with == look && is_same(old, &slice.value)) {
        return;
    }
    for entity in &drawn {
        commands.entity(entity).despawn();
    }
    *last = Some((slice.value.clone(), look));
    commands.spawn((
        Name::new("slice"),
        Slice,
        Mesh3d(assets.meshes.add(plane(&slice.value))),
        MeshMaterial3d(
            assets
                .materials
                .add(MapMaterial { picture: assets.images.add(picture(&slice.value, &look)) }),
        ),
    ));
}

/// Whether two slices look the same; what has no value equals itself here.
fn is_same(a: &SliceOutcome, b: &SliceOutcome) -> bool {
    let bits =
        |slice: &SliceOutcome| -> Vec<u64> { slice.values.iter().map(|v| v.to_bits()).collect() };
    a.plan == b.plan
        && a.quantity == b.quantity
        && a.is_inside == b.is_inside
        && a.is_supported == b.is_supported
        && bits(a) == bits(b)
}

/// The lattice's rectangle. Texels sit on its points, so it reaches half a texel into the
/// outermost ones.
fn plane(slice: &SliceOutcome) -> Mesh {
    let [nu, nv] = slice.plan.counts;
    let corners = [(0, 0), (nu - 1, 0), (nu - 1, nv - 1), (0, nv - 1)]
        .map(|(u, v)| convert::point(&slice.plan.point_mm(u, v)).to_array());
    let [inset_u, inset_v] = [nu, nv].map(inset);
    let (lo, hi) = ([inset_u, inset_v], [1.0 - inset_u, 1.0 - inset_v]);
    let normal = convert::vec3(&slice.plan.plane.normal()).to_array();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners.to_vec())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![normal; 4])
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_UV_0,
            vec![[lo[0], lo[1]], [hi[0], lo[1]], [hi[0], hi[1]], [lo[0], hi[1]]],
        )
        .with_inserted_indices(Indices::U32(vec![0, 1, 2, 0, 2, 3]))
}

/// In the middle of the edge where the first of the plane's axes ends.
fn handle_of(slice: &SliceOutcome) -> SliceHandle {
    let [nu, nv] = slice.plan.counts;
    SliceHandle {
        at_mm: nalgebra::center(
            &slice.plan.point_mm(nu - 1, 0),
            &slice.plan.point_mm(nu - 1, nv - 1),
        ),
        normal: slice.plan.plane.normal(),
    }
}

fn place_handle(
    mut commands: Commands,
    world: Res<OpenWorld>,
    workspace: Option<Res<Workspace>>,
    results: Res<Results>,
    mut drawn: Query<(Entity, &mut SliceHandle, &mut BallHandle)>,
    shapes: Res<GlyphShapes>,
    mut materials: ResMut<Assets<GlowMaterial>>,
) {
    // An audience takes hold of nothing.
    let is_held = workspace.is_none_or(|workspace| *workspace != Workspace::Present);
    let is_on = is_held && world.0.document.view().layers.slice;
    let Some(slice) = results.slice.as_ref().filter(|_| is_on) else {
        for (entity, ..) in &drawn {
            commands.entity(entity).despawn();
        }
        return;
    };
    let handle = handle_of(&slice.value);
    let place = BallHandle { at_mm: handle.at_mm, radius_px: ball_handle::LARGE_PX };
    if let Some((_, mut old, mut ball)) = drawn.iter_mut().next() {
        old.set_if_neq(handle);
        ball.set_if_neq(place);
        return;
    }
    let material = materials.add(ball_handle::material(palette::TEXT_STRONG));
    let words = "Drag to move the slice across its plane, in whole millimetres".to_owned();
    commands.spawn((
        Name::new("slice handle"),
        handle,
        ball_handle::ball(place, words, &shapes, material),
    ));
}

fn on_drag_start(
    mut drag: On<Pointer<DragStart>>,
    handles: Query<&SliceHandle>,
    sight: Sight,
    mut held: ResMut<SliceDrag>,
    mut active: ResMut<ActiveDrag>,
) {
    let (Ok(handle), Some(world)) = (handles.get(drag.entity), &sight.world) else {
        return;
    };
    drag.propagate(false);
    if drag.button != PointerButton::Primary {
        return;
    }
    if let Some(grabbed_at_mm) = sight
        .ray(drag.pointer_location.position)
        .and_then(|ray| ray.nearest_on_line(&handle.at_mm, &handle.normal))
    {
        active.set_if_neq(ActiveDrag(true));
        held.0 = Some(HeldSlice {
            handle: *handle,
            start_mm: world.0.document.view().slice.offset_mm(),
            grabbed_at_mm,
        });
    }
}

fn on_drag(
    mut drag: On<Pointer<Drag>>,
    handles: Query<&SliceHandle>,
    sight: Sight,
    held: Res<SliceDrag>,
    mut readout: ResMut<DragReadout>,
    mut views: MessageWriter<ViewRequest>,
) {
    let (Some(held), Some(world)) = (held.0, &sight.world) else {
        return;
    };
    if !handles.contains(drag.entity) {
        return;
    }
    drag.propagate(false);
    let at = drag.pointer_location.position;
    let Some(now) =
        sight.ray(at).and_then(|ray| ray.nearest_on_line(&held.handle.at_mm, &held.handle.normal))
    else {
        return;
    };
    let mut view = world.0.document.view().clone();
    let bounds = world.0.environment.model.bounds();
    let [least, most] = bounds.span_mm(&held.handle.normal);
    let offset_mm = (held.start_mm + now - held.grabbed_at_mm).clamp(least, most);
    // Whole millimetres: nobody needs a slice at 0.37 mm, and round numbers read better.
    view.slice.set_offset_mm(offset_mm.round());
    readout.set_if_neq(DragReadout(Some(DragText {
        at,
        text: format!("{:.0}\u{2009}mm", view.slice.offset_mm()).replace('-', "\u{2212}"),
    })));
    views.write(ViewRequest::Set(view));
}

fn on_drag_end(
    mut drag: On<Pointer<DragEnd>>,
    handles: Query<&SliceHandle>,
    mut held: ResMut<SliceDrag>,
    mut active: ResMut<ActiveDrag>,
    mut readout: ResMut<DragReadout>,
) {
    if handles.contains(drag.entity) && held.0.take().is_some() {
        drag.propagate(false);
        active.set_if_neq(ActiveDrag(false));
        readout.set_if_neq(DragReadout(None));
    }
}
