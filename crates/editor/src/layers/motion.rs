//! The range of motion in the scene: the box that its shifts take the tip through, the fans of its
//! turns, and balls that drag the ends of each axis.
//!
//! Where lines and balls are, and what a drag makes of the motion, is the core's
//! ([`trackwright_simulation::motion_outline`]). Balls are there while nothing is selected, which is when the
//! panel beside the scene shows the motion's numbers; not in the Field workspace, which is about the
//! room; and not while a trial is shown, which has the tool elsewhere. Lines stay: the trial is
//! within them.

use crate::document::requests::OpenWorld;
use crate::document::selection::Selection;
use crate::document::shown::ShownDesign;
use crate::layers::legend::{LegendKey, Swatch};
use crate::layers::registry::{AddLayer, LayerInfo};
use crate::palette::Theme;
use crate::palette::ThemedColor;
use crate::scene::materials::glow::GlowMaterial;
use crate::scene::shapes::GlyphShapes;
use crate::schedule::EditorSystems;
use crate::shell::window::{Presentation, Workspace};
use crate::viewport::ball_handle::{self, BallHandle};
use crate::viewport::camera::Sight;
use crate::viewport::drag_edits::DragEdits;
use crate::widgets::basic::{THIN_SPACE, counted, signed};
use crate::{convert, palette};
use bevy::ecs::system::SystemParam;
use bevy::picking::events::{Drag, DragEnd, DragStart, Pointer};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use trackwright_design::{BodyRole, Design, Edit};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::Motion;
use trackwright_simulation::motion_outline::{
    HeldEnd, MotionHandle, MotionOutline, RangeEnd, motion_outline,
};

const LINE_ALPHA: f32 = 0.65;
const MARK_ALPHA: f32 = 0.45;
const STEM_ALPHA: f32 = 0.35;

/// A press that moves less than this changes nothing.
const DEAD_ZONE_PX: f32 = 3.0;

/// With Ctrl ends are rounded to this.
const ROUND_MM: f64 = 1.0;
const ROUND_DEG: f64 = 5.0;

const CTRL: [KeyCode; 2] = [KeyCode::ControlLeft, KeyCode::ControlRight];

/// Draws the range of motion while its layer is on and the design has one.
pub struct MotionPlugin;

const LAYER: LayerInfo = LayerInfo {
    keys: |open| {
        if outline_of(open.document.design()).is_none() {
            return Vec::new();
        }
        let key = |words: &str| LegendKey::new(Swatch::Line(palette::MOTION), words);
        vec![
            key("range of motion; balls move its ends").for_designers(),
            key("range of motion").for_slides(),
        ]
    },
    ..LayerInfo::new("Range of motion", 80, |layers| &mut layers.motion)
};

/// What the drawn lines were made for.
#[derive(Component, Clone, Debug, PartialEq)]
struct MotionLines {
    outline: MotionOutline,
    theme: Theme,
}

/// A ball that drags one end of an axis.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct MotionBall(pub MotionHandle);

/// The end that is held.
#[derive(Resource, Default)]
struct MotionDrag(Option<Held>);

struct Held {
    end: HeldEnd,
    /// Whether it moved far enough for an undo step to be open.
    has_begun: bool,
}

/// What it shows.
const ABOUT: &str = "What the range of motion runs through, with balls that set where it ends";

impl Plugin for MotionPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LAYER, ABOUT)
            .init_resource::<MotionDrag>()
            .add_observer(on_drag_start)
            .add_observer(on_drag)
            .add_observer(on_drag_end)
            .add_systems(
                Update,
                (
                    let_go_on_escape
                        .run_if(resource_exists::<ButtonInput<KeyCode>>)
                        .in_set(EditorSystems::Input),
                    (draw_lines, place_balls).run_if(needs_drawing).in_set(EditorSystems::Draw),
                ),
            );
    }
}

/// What the range of motion is drawn from.
#[derive(SystemParam)]
struct Shown<'w> {
    world: Option<Res<'w, OpenWorld>>,
    design: Option<Res<'w, ShownDesign>>,
    selection: Res<'w, Selection>,
    presentation: Res<'w, Presentation>,
    workspace: Res<'w, Workspace>,
    theme: Res<'w, Theme>,
}

impl Shown<'_> {
    /// `None` while the layer is off, and where there is no motion that can be visited.
    fn outline(&self) -> Option<MotionOutline> {
        let document = &self.world.as_ref()?.0.document;
        // It is where the design has the bodies, not where a tracker has them.
        if self.workspace.shows_live {
            return None;
        }
        match document.view().layers.motion {
            true => outline_of(document.design()),
            false => None,
        }
    }

    fn has_balls(&self) -> bool {
        self.presentation.window
            && self.workspace.edits_design
            && self.selection.primary().is_none()
            && self.design.as_ref().is_none_or(|shown| shown.trial.is_none())
    }
}

fn outline_of(design: &Design) -> Option<MotionOutline> {
    let tracker_from_crf = design.tracker_from_body(BodyRole::Crf).unwrap_or_else(Pose::identity);
    let tool = &design.tool;
    let motion = design.motion.as_ref()?;
    motion_outline(motion, &tool.body.rigid, &tool.crf_from_tool, &tracker_from_crf).ok()
}

fn needs_drawing(shown: Shown) -> bool {
    let is_changed = |world: &Res<OpenWorld>| world.is_changed();
    shown.world.as_ref().is_some_and(is_changed)
        || shown.design.as_ref().is_some_and(|design| design.is_changed())
        || shown.selection.is_changed()
        || shown.workspace.is_changed()
        || shown.theme.is_changed()
}

fn draw_lines(
    mut commands: Commands,
    shown: Shown,
    drawn: Query<(Entity, &MotionLines)>,
    mut gizmos: ResMut<Assets<GizmoAsset>>,
) {
    let wanted = shown.outline().map(|outline| MotionLines { outline, theme: *shown.theme });
    if drawn.iter().next().map(|(_, lines)| lines) == wanted.as_ref() {
        return;
    }
    for (entity, _) in &drawn {
        commands.entity(entity).despawn();
    }
    let Some(wanted) = wanted else { return };
    let outline = &wanted.outline;
    let mut asset = GizmoAsset::default();
    let mut add = |line: &[nalgebra::Point3<f64>], alpha: f32| {
        let color = palette::MOTION.color_alpha(alpha);
        asset.linestrip(line.iter().map(convert::point), color);
    };
    for edge in &outline.edges {
        add(edge, LINE_ALPHA);
    }
    for mark in &outline.marks {
        add(mark, MARK_ALPHA);
    }
    for fan in &outline.fans {
        add(&fan.arc, LINE_ALPHA);
        for spoke in &fan.spokes {
            add(spoke, MARK_ALPHA);
        }
    }
    for stem in &outline.stems {
        add(stem, STEM_ALPHA);
    }
    let lines = Gizmo {
        handle: gizmos.add(asset),
        line_config: GizmoLineConfig { width: 1.2, ..default() },
        ..default()
    };
    commands.spawn((Name::new("range of motion"), wanted, lines));
}

/// One a handle; those that are there keep their entity, so that a drag goes on.
fn place_balls(
    mut commands: Commands,
    shown: Shown,
    mut drawn: Query<(Entity, &mut MotionBall, &mut BallHandle)>,
    shapes: Res<GlyphShapes>,
    mut materials: ResMut<Assets<GlowMaterial>>,
) {
    let outline = shown.has_balls().then(|| shown.outline()).flatten();
    let mut wanted = outline.unwrap_or_default().handles;
    for (entity, mut ball, mut place) in &mut drawn {
        let is_its = |h: &MotionHandle| (h.axis, h.end) == (ball.0.axis, ball.0.end);
        let Some(index) = wanted.iter().position(is_its) else {
            commands.entity(entity).despawn();
            continue;
        };
        let handle = wanted.swap_remove(index);
        ball.set_if_neq(MotionBall(handle));
        place.set_if_neq(place_of(&handle));
    }
    if wanted.is_empty() {
        return;
    }
    let material = materials.add(ball_handle::material(palette::MOTION));
    for handle in wanted {
        commands.spawn((
            Name::new("motion handle"),
            MotionBall(handle),
            ball_handle::ball(place_of(&handle), words(&handle), &shapes, material.clone()),
        ));
    }
}

fn place_of(handle: &MotionHandle) -> BallHandle {
    BallHandle { at_mm: handle.at_mm, radius_px: ball_handle::SMALL_PX }
}

fn on_drag_start(
    mut drag: On<Pointer<DragStart>>,
    balls: Query<&MotionBall>,
    sight: Sight,
    mut held: ResMut<MotionDrag>,
    mut edits: DragEdits,
) {
    let Ok(ball) = balls.get(drag.entity) else {
        return;
    };
    drag.propagate(false);
    if drag.button != PointerButton::Primary {
        return;
    }
    let design = sight.world.as_ref().map(|world| world.0.document.design());
    let (Some(motion), Some(ray)) =
        (design.and_then(|design| design.motion), sight.ray(drag.pointer_location.position))
    else {
        return;
    };
    if let Some(end) = ball.0.take(&motion, &ray) {
        edits.take_hold();
        held.0 = Some(Held { end, has_begun: false });
    }
}

fn on_drag(
    mut drag: On<Pointer<Drag>>,
    balls: Query<(), With<MotionBall>>,
    sight: Sight,
    keys: Option<Res<ButtonInput<KeyCode>>>,
    mut held: ResMut<MotionDrag>,
    mut edits: DragEdits,
) {
    if !balls.contains(drag.entity) {
        return;
    }
    drag.propagate(false);
    let Some(held) = &mut held.0 else { return };
    if !held.has_begun && drag.distance.length() < DEAD_ZONE_PX {
        return;
    }
    let at = drag.pointer_location.position;
    let is_rounded = keys.is_some_and(|keys| keys.any_pressed(CTRL));
    let round_to = match held.end.handle().axis {
        0..3 => ROUND_MM,
        _ => ROUND_DEG,
    };
    let Some(motion) =
        sight.ray(at).and_then(|ray| held.end.motion_at(&ray, is_rounded.then_some(round_to)))
    else {
        return;
    };
    if !held.has_begun {
        held.has_begun = true;
        edits.begin("Set range of motion".to_owned());
    }
    let text = readout_text(held.end.handle(), &motion);
    edits.apply(Edit::SetMotion(Some(motion)), at, text);
}

fn on_drag_end(
    mut drag: On<Pointer<DragEnd>>,
    balls: Query<(), With<MotionBall>>,
    mut held: ResMut<MotionDrag>,
    mut edits: DragEdits,
) {
    if !balls.contains(drag.entity) || drag.button != PointerButton::Primary {
        return;
    }
    drag.propagate(false);
    edits.end(held.0.take().is_some_and(|held| held.has_begun));
}

fn let_go_on_escape(
    keys: Res<ButtonInput<KeyCode>>,
    mut held: ResMut<MotionDrag>,
    mut edits: DragEdits,
) {
    if keys.just_pressed(KeyCode::Escape) && held.0.take().is_some_and(|held| held.has_begun) {
        edits.cancel();
    }
}

/// What dragging its ball does.
fn words(handle: &MotionHandle) -> String {
    let (name, _) = Motion::default().axes()[handle.axis];
    let (verb, step) = match handle.axis {
        0..3 => ("shift", format!("{ROUND_MM:.0}\u{2009}mm")),
        _ => ("turn", format!("{ROUND_DEG:.0}°")),
    };
    let end = match handle.end {
        RangeEnd::Min => "begins",
        RangeEnd::Max => "ends",
    };
    format!("Drag to set where the {verb} {name} {end} · Ctrl rounds to {step} · Esc takes it back")
}

/// `x to +45 mm   375 poses`.
fn readout_text(handle: &MotionHandle, motion: &Motion) -> String {
    let (name, range) = motion.axes()[handle.axis];
    let Some(range) = range else {
        return name.to_owned();
    };
    let value = handle.end.of(&range);
    let decimals = if value.fract() == 0.0 { 0 } else { 1 };
    let value = signed(value, decimals);
    let unit = match handle.axis {
        0..3 => format!("{THIN_SPACE}mm"),
        _ => "°".to_owned(),
    };
    let end = match handle.end {
        RangeEnd::Min => "from",
        RangeEnd::Max => "to",
    };
    let poses = match motion.grid(&Pose::identity()) {
        Ok(grid) => counted(grid.trials(), "pose", "poses"),
        // The document reports why it refuses.
        Err(_) => "too many poses".to_owned(),
    };
    format!("{name} {end} {value}{unit}   {poses}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};
    use trackwright_simulation::AxisRange;
    use trackwright_simulation::motion_outline::HandlePath;

    #[test]
    fn a_handle_readout_names_axis_end_unit_and_poses() {
        let range = |min, max, step| Some(AxisRange { min, max, step });
        let motion =
            Motion { x: range(-50.0, 45.0, 5.0), rz: range(-22.5, 0.0, 22.5), ..Motion::default() };
        let text = |axis, end| {
            let handle = MotionHandle {
                axis,
                end,
                at_mm: Point3::origin(),
                path: HandlePath::Line(Vector3::x_axis()),
            };
            readout_text(&handle, &motion)
        };
        assert_eq!(text(0, RangeEnd::Max), "x to +45\u{2009}mm   40 poses");
        assert_eq!(text(5, RangeEnd::Min), "rz from \u{2212}22.5°   40 poses");
    }
}
