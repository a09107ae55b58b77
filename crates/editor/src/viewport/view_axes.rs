//! The tracker's axes in a corner of the 3D view: a click on an end looks from there, one in the
//! middle switches between perspective and orthographic, and a drag orbits.

use crate::document::requests::ViewRequest;
use crate::palette::{self, ThemedColor};
use crate::schedule::UiSystems;
use crate::shell::commands::{Command, RunCommand};
use crate::shell::requests::Requests;
use crate::shell::window::{Presentation, SceneCover, ViewportRect, Workspace};
use crate::viewport::camera::OrbitRig;
use crate::viewport::commands::{LOOK_FROM, SWITCH_PROJECTION};
use crate::widgets::theme;
use crate::widgets::tooltip::Explain;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui::{
    self, Align2, Area, Color32, Id, Order, Pos2, Sense, Stroke, Ui, WidgetInfo, WidgetType, pos2,
    vec2,
};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use trackwright_geometry::orbit::{AxisEnd, OrbitCamera, Projection};

/// Draws the axes over the 3D view, in [`UiSystems::SceneControls`].
pub struct ViewAxesPlugin;

impl Plugin for ViewAxesPlugin {
    fn build(&self, app: &mut App) {
        app.add_message::<RunCommand>()
            .add_systems(EguiPrimaryContextPass, draw.in_set(UiSystems::SceneControls));
    }
}

/// Distance from the edges of the 3D view, in pixels.
const MARGIN: f32 = 12.0;
/// Side of the square that it takes, in pixels.
const SIDE: f32 = 92.0;
/// From the middle to an end that lies across the view.
const REACH: f32 = 34.0;
const END_RADIUS: f32 = 10.0;
const MIDDLE_RADIUS: f32 = 9.0;
/// An end that is nearer to the middle than this leaves it free.
const LEAST_OFF: f32 = 12.0;

/// How opaque an end is that points away from the viewer.
const FAR_ALPHA: f32 = 0.55;

/// What a person requested there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewAxesAction {
    /// A command, by its name.
    Run(&'static str),
    /// Turns by a drag, in egui's points.
    Orbit([f64; 2]),
    EndOrbit,
}

/// An end with its place on the screen.
struct Placed {
    end: AxisEnd,
    command: Command,
    at: Pos2,
    /// Towards the viewer, of a whole one.
    near: f64,
}

/// Where the ends are, the farthest first.
fn placed(camera: &OrbitCamera, middle: Pos2) -> Vec<Placed> {
    let mut ends: Vec<Placed> = LOOK_FROM
        .iter()
        .map(|(end, command)| {
            let [right, down, near] = camera.on_screen(&end.unit());
            let at = middle + vec2(right as f32, down as f32) * REACH;
            Placed { end: *end, command: *command, at, near }
        })
        .collect();
    ends.sort_by(|a, b| a.near.total_cmp(&b.near));
    ends
}

/// Draws the axes as a camera sees them.
pub fn view_axes_ui(ui: &mut Ui, camera: &OrbitCamera) -> Vec<ViewAxesAction> {
    let mut actions = Vec::new();
    // With clicks, a drag begins where the pointer moves and not with each press.
    let (rect, whole) = ui.allocate_exact_size(vec2(SIDE, SIDE), Sense::click_and_drag());
    ui.painter().circle_filled(rect.center(), SIDE / 2.0, palette::plate());
    if whole.dragged() && whole.drag_delta() != egui::Vec2::ZERO {
        let by = whole.drag_delta();
        actions.push(ViewAxesAction::Orbit([f64::from(by.x), f64::from(by.y)]));
    }
    if whole.drag_stopped() {
        actions.push(ViewAxesAction::EndOrbit);
    }
    let is_before = |placed: &Placed| placed.near >= 0.0;
    let (near, far): (Vec<Placed>, Vec<Placed>) =
        placed(camera, rect.center()).into_iter().partition(is_before);
    for placed in far {
        end_ui(ui, &placed, rect.center(), &mut actions);
    }
    middle_ui(ui, camera.projection, rect.center(), &mut actions);
    for placed in near {
        end_ui(ui, &placed, rect.center(), &mut actions);
    }
    actions
}

/// An end that can be clicked. One that points at the viewer, or away, leaves the middle free.
fn end_ui(ui: &mut Ui, placed: &Placed, middle: Pos2, actions: &mut Vec<ViewAxesAction>) {
    let Placed { end, command, at, near } = placed;
    let color = palette::AXES[end.axis as usize].color32();
    let fade = if *near < 0.0 { FAR_ALPHA } else { 1.0 };
    let color = color.gamma_multiply(fade);
    if at.distance(middle) < LEAST_OFF {
        return;
    }
    let rect = egui::Rect::from_center_size(*at, egui::Vec2::splat(2.0 * END_RADIUS));
    let response = ui.interact(rect, ui.id().with(end), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, command.name));
    let toward = (*at - middle).normalized();
    let stroke = Stroke::new(2.0, color);
    let line = [middle + toward * MIDDLE_RADIUS, *at - toward * END_RADIUS];
    let painter = ui.painter();
    let mut ink = color;
    if end.is_positive {
        painter.line_segment(line, stroke);
        painter.circle_filled(*at, END_RADIUS, color);
        ink = palette::BACKGROUND.color32();
    } else {
        painter.circle_filled(*at, END_RADIUS, color.gamma_multiply(0.2));
        painter.circle_stroke(*at, END_RADIUS - 0.5, Stroke::new(1.0, color));
    }
    if response.hovered() {
        let stroke = Stroke::new(2.0, palette::TEXT_STRONG.color32());
        painter.circle_stroke(*at, END_RADIUS, stroke);
    }
    name(painter, *at, end.name(), ink);
    if response.explained(command.tooltip()).clicked() {
        actions.push(ViewAxesAction::Run(command.name));
    }
}

fn middle_ui(ui: &mut Ui, projection: Projection, at: Pos2, actions: &mut Vec<ViewAxesAction>) {
    let command = &SWITCH_PROJECTION;
    let rect = egui::Rect::from_center_size(at, egui::Vec2::splat(2.0 * MIDDLE_RADIUS));
    let response = ui.interact(rect, ui.id().with("middle"), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, command.name));
    let color = match response.hovered() {
        true => palette::TEXT_STRONG,
        false => palette::TEXT_QUIET,
    };
    let (name_of, now) = match projection {
        Projection::Perspective => ("P", "The view is in perspective."),
        Projection::Orthographic => ("O", "The view is orthographic."),
    };
    ui.painter().circle_stroke(at, MIDDLE_RADIUS, Stroke::new(1.0, color.color32()));
    name(ui.painter(), at, name_of, color.color32());
    if response.explained(format!("{now} {}", command.tooltip())).clicked() {
        actions.push(ViewAxesAction::Run(command.name));
    }
}

fn name(painter: &egui::Painter, at: Pos2, text: &str, color: Color32) {
    painter.text(at, Align2::CENTER_CENTER, text, theme::label_font(), color);
}

/// What decides whether and where it stands.
#[derive(SystemParam)]
struct Corner<'w> {
    rig: Option<Res<'w, OrbitRig>>,
    rect: Option<Res<'w, ViewportRect>>,
    presentation: Res<'w, Presentation>,
    workspace: Res<'w, Workspace>,
}

/// A view that is too small has no room for it.
const LEAST_VIEW: f32 = 3.0 * SIDE;

/// Draws it into the upper right corner of the 3D view; labels of the scene leave it free.
fn draw(
    mut contexts: EguiContexts,
    corner: Corner,
    mut cover: ResMut<SceneCover>,
    mut run: Requests<RunCommand>,
    mut views: Requests<ViewRequest>,
) -> Result {
    let (Some(rig), Some(rect)) = (&corner.rig, &corner.rect) else {
        return Ok(());
    };
    let is_hidden = !corner.presentation.panels || corner.workspace.is_presentation;
    if is_hidden || rect.size.min_element() < LEAST_VIEW {
        return Ok(());
    }
    let ctx = contexts.ctx_mut()?;
    let zoom = ctx.zoom_factor();
    let right = (rect.min.x + rect.size.x) / zoom;
    let at = pos2(right - MARGIN - SIDE, rect.min.y / zoom + MARGIN);
    let area = Area::new(Id::new("view axes")).fixed_pos(at).order(Order::Middle);
    let shown = area.constrain(false).fade_in(false).show(ctx, |ui| view_axes_ui(ui, &rig.camera));
    cover.bypass_change_detection().0.push(shown.response.rect);
    for action in shown.inner {
        match action {
            ViewAxesAction::Run(command) => run.write(RunCommand(command)),
            ViewAxesAction::Orbit(drag) => {
                views.write(ViewRequest::Orbit(drag.map(|by| by * f64::from(zoom))));
            }
            ViewAxesAction::EndOrbit => views.write(ViewRequest::EndOrbit),
        }
    }
    Ok(())
}
