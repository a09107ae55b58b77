//! A plane through the room coloured by position error, and the handle that moves it.
//!
//! Sampling is the solver's; this only draws.

use crate::document::requests::{ActiveDrag, OpenWorld, ViewRequest};
use crate::layers::legend::{ColorBar, Legend, LegendKey, Legends, Swatch};
use crate::layers::registry::{
    AddLayer, LayerInfo, ProbeInfo, ProbeRay, Probed, SettingsContext, is_layer_on,
};
use crate::layers::settings::{
    AXIS_NAMES, INDENT, map_ui, range_ui, row_ui, sensor_axis_ui, set_from,
};
use crate::layers::slice_picture::{ColorScale, SliceLook, inset, picture};
use crate::runner::results::Results;
use crate::scene::materials::map::MapMaterial;
use crate::schedule::EditorSystems;
use crate::shell::window::{DragReadout, DragText, Workspace};
use crate::viewport::ball_handle::{BallHandle, Balls, LARGE_PX};
use crate::viewport::camera::Sight;
use crate::widgets::basic::{NumberField, decimal, number_ui, with_unit};
use crate::widgets::tooltip::Explain;
use crate::{convert, palette};
use bevy::asset::RenderAssetUsages;
use bevy::ecs::system::SystemParam;
use bevy::mesh::Indices;
use bevy::picking::events::{Drag, DragEnd, DragStart, Pointer};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use bevy::render::render_resource::PrimitiveTopology;
use bevy_egui::egui::{self, ComboBox, Slider, SliderClamping, Ui};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_design::view::{Layer, Quantity, SliceAxis, SliceView, View};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::colormap::ColorMap;
use trackwright_simulation::{Reading, Requirement, SliceHit, SliceOutcome};

/// The layer.
pub const LAYER: LayerInfo =
    LayerInfo { is_of_room: true, settings: Some(settings_ui), ..LayerInfo::new(&Layer::SLICE) };

const FACE: &str = "Turns the slice to face the view, through what the camera looks at, and keeps it \
    there while the view turns; press again to turn it again";

/// Why nothing is known of where the model is valid.
pub const NO_SUPPORT: &str =
    "This room has no model validity; fit its measurements again to add it";

/// Shown of field where the samples do not carry the model.
const POORLY_SUPPORTED: &str = "poorly supported field";

/// Draws the slice while its layer is on.
pub struct SlicePlugin;

/// When [`ColorScale`] is that of the slice.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SliceScaleSystems;

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
        app.add_layer(LAYER)
            .add_probe(ProbeInfo { is_on: |world| is_layer_on(world, &LAYER), value: value_at })
            .init_resource::<SliceDrag>()
            .insert_resource(ColorScale { map: ColorMap::default(), max_mm: 0.0 })
            .add_observer(on_drag_start)
            .add_observer(on_drag)
            .add_observer(on_drag_end)
            .add_systems(
                Update,
                (
                    choose_scale.in_set(SliceScaleSystems).in_set(EditorSystems::Sample),
                    (draw, place_handle).chain().in_set(EditorSystems::Draw),
                )
                    .run_if(needs_drawing),
            );
    }
}

fn needs_drawing(world: Option<Res<OpenWorld>>, results: Res<Results>) -> bool {
    world.is_some_and(|world| world.is_changed() || results.is_changed())
}

fn choose_scale(
    world: Res<OpenWorld>,
    results: Res<Results>,
    mut scale: ResMut<ColorScale>,
    mut legends: ResMut<Legends>,
) {
    let document = &world.0.document;
    let view = document.view();
    let slice = results.slice.as_ref().map(|slice| &slice.value);
    let max_mm = view.slice_range().or(slice.map(|slice| slice.p95)).unwrap_or(0.0);
    scale.set_if_neq(ColorScale { map: view.color_maps().slice, max_mm });
    let shown = slice.filter(|_| document.view().layers.slice);
    let requirement = document.design().requirement;
    legends.set(
        LAYER.row.order,
        shown.map_or_else(Legend::default, |slice| Legend {
            bar: Some(bar(slice, &scale, requirement)),
            keys: keys(slice, scale.map),
            stroke: None,
        }),
    );
}

fn bar(slice: &SliceOutcome, scale: &ColorScale, requirement: Option<Requirement>) -> ColorBar {
    let quantity = slice.quantity;
    ColorBar {
        label: quantity.label().to_owned(),
        note: None,
        unit: quantity.unit(),
        map: scale.map,
        min: 0.0,
        max: scale.max_mm,
        largest: slice.max,
        decimals: quantity.decimals(),
        limit: requirement.and_then(|of| quantity.limit(&of)),
    }
}

/// What the hatchings and the ball mean.
fn keys(slice: &SliceOutcome, map: ColorMap) -> Vec<LegendKey> {
    let key = LegendKey::new;
    let ball = Swatch::Ball(palette::SLICE_HANDLE);
    let mut keys = vec![key(ball, "moves the slice").for_designers()];
    let points = || slice.values.iter().zip(&slice.is_inside);
    if points().any(|(value, is_inside)| !is_inside && !value.is_nan()) {
        keys.push(key(Swatch::NoValue, outside_words(slice.quantity)));
    }
    if points().any(|(value, _)| value.is_nan()) {
        keys.push(key(Swatch::NoValue, "not determined"));
    }
    let mut supported = slice.is_supported.iter().zip(&slice.is_inside);
    if supported.any(|(is_supported, is_inside)| *is_inside && !is_supported) {
        keys.push(key(Swatch::Unsupported(map), POORLY_SUPPORTED));
    }
    keys
}

fn value_at(world: &World, probe: &ProbeRay) -> Option<Probed> {
    let slice = world.get_resource::<Results>()?.slice.as_ref()?;
    let hit = slice.value.hit(&probe.ray)?;
    let words = words(slice.value.quantity, &hit);
    Some(Probed { distance_mm: hit.distance_mm, words: Some(words) })
}

/// `position error 1.24 mm`.
fn words(quantity: Quantity, hit: &SliceHit) -> String {
    let words = match hit.reading {
        Reading::Value(value) => {
            let value = with_unit(&decimal(value, quantity.decimals()), quantity.unit());
            format!("{} {value}", quantity.label())
        }
        Reading::Outside => return outside_words(quantity).to_owned(),
        Reading::Undetermined => return format!("{} not determined", quantity.label()),
    };
    match hit.is_supported {
        true => words,
        false => format!("{words}, {POORLY_SUPPORTED}"),
    }
}

/// Where a slice has no value.
fn outside_words(quantity: Quantity) -> &'static str {
    match quantity.needs_tool() {
        true => "a sensor outside the room's box",
        false => "outside the room's box",
    }
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
    world: Res<OpenWorld>,
    workspace: Option<Res<Workspace>>,
    results: Res<Results>,
    mut balls: Balls<SliceHandle>,
) {
    // An audience takes hold of nothing.
    let is_held = workspace.is_none_or(|workspace| !workspace.is_presentation);
    let is_on = is_held && world.0.document.view().layers.slice;
    let wanted = results.slice.as_ref().filter(|_| is_on).map(|slice| {
        let handle = handle_of(&slice.value);
        let place = BallHandle { at_mm: handle.at_mm, radius_px: LARGE_PX };
        let words = "Drag to move the slice across its plane, in whole millimetres".to_owned();
        (handle, place, words)
    });
    balls.place("slice handle", |_| palette::SLICE_HANDLE, wanted, |_, _| true);
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

fn settings_ui(ui: &mut Ui, view: &mut View, context: &SettingsContext) {
    let slice = &mut view.slice;
    quantity_ui(ui, context.environment.has_validity(), slice);
    plane_ui(ui, context, slice);
    position_ui(ui, context.environment.model.bounds(), slice);
    if !slice.quantity.needs_tool() {
        sensor_axis_ui(ui, &mut slice.sensor_axis);
    }
    let field = NumberField {
        unit: slice.quantity.unit(),
        decimals: slice.quantity.decimals(),
        ..NumberField::length("colour range")
    };
    let mut range = view.slice_range();
    range_ui(ui, &field, context.largest, &mut range);
    view.set_slice_range(range);
    let map = view.color_maps().slice;
    map_ui(ui, view, map);
}

fn plane_ui(ui: &mut Ui, context: &SettingsContext, slice: &mut SliceView) {
    row_ui(ui, "across", |ui| {
        for axis in SliceAxis::ALL {
            let name = AXIS_NAMES[axis.index()];
            let is_shown = slice.free.is_none() && slice.axis == axis;
            if ui.selectable_label(is_shown, name).clicked() && !is_shown {
                if slice.axis != axis {
                    // The old place means nothing along another axis.
                    slice.position_mm =
                        context.environment.model.bounds().center_mm()[axis.index()];
                }
                slice.axis = axis;
                slice.free = None;
            }
        }
        let name = egui::Button::selectable(slice.free.is_some(), "the view");
        let face = ui.add_enabled(context.camera.is_some(), name).explained(FACE);
        if let Some(camera) = context.camera.filter(|_| face.clicked()) {
            slice.face(&camera, context.environment.model.bounds());
        }
    });
}

fn quantity_ui(ui: &mut Ui, has_support: bool, slice: &mut SliceView) {
    row_ui(ui, "shows", |ui| {
        let choice = ComboBox::from_id_salt("slice quantity")
            .selected_text(short_name(slice.quantity))
            .width(110.0)
            .show_ui(ui, |ui| {
                for quantity in Quantity::ALL {
                    let is_known = has_support || !quantity.needs_support();
                    let is_shown = slice.quantity == quantity;
                    let name = egui::Button::selectable(is_shown, short_name(quantity));
                    let choice = ui
                        .add_enabled(is_known, name)
                        .explained(quantity.label())
                        .on_disabled_hover_text(NO_SUPPORT);
                    if choice.clicked() && !is_shown {
                        slice.quantity = quantity;
                        // The old range means nothing for another quantity.
                        slice.range_mm = None;
                    }
                }
            });
        choice.response.explained("What the slice is coloured by");
    });
    if !has_support && slice.quantity.needs_support() {
        crate::widgets::basic::warning_ui(ui, NO_SUPPORT);
    }
}

/// For a narrow panel; the colour bar has the whole name.
fn short_name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::PositionErrorMm => "position error",
        Quantity::OrientationErrorDeg => "orientation error",
        Quantity::TipErrorMm => "tip error",
        Quantity::GradientMmPerMm => "gradient",
        Quantity::StdErrorMm => "standard error",
        Quantity::SupportDistanceMm => "nearest sample",
    }
}

fn position_ui(ui: &mut Ui, bounds: &Bounds, slice: &mut SliceView) {
    let [least, most] = bounds.span_mm(&slice.normal());
    row_ui(ui, "at", |ui| {
        let field =
            NumberField { decimals: 1, speed: 1.0, ..NumberField::length("slice position in mm") };
        set_from(number_ui(ui, &field, slice.offset_mm()), |v| {
            slice.set_offset_mm(v);
        });
    });
    ui.horizontal(|ui| {
        ui.add_space(INDENT);
        let mut offset_mm = slice.offset_mm();
        ui.spacing_mut().slider_width = (ui.available_width() - 8.0).max(40.0);
        let slider = Slider::new(&mut offset_mm, least..=most)
            .show_value(false)
            .clamping(SliderClamping::Never)
            .step_by(1.0);
        if ui.add(slider).explained("Where the slice stands along its axis").changed() {
            slice.set_offset_mm(offset_mm);
        }
    });
}
