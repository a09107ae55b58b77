//! Lays the registered panels out around the 3D view.

use crate::document::requests::OpenWorld;
use crate::palette::{self, Theme, ThemedColor};
use crate::schedule::UiSystems;
use crate::shell::registry::{Panels, Registered, Side};
use crate::shell::status_bar::status_bar;
use crate::shell::top_bar::top_bar;
use crate::shell::window::{
    PanelsShown, Presentation, SceneCover, SideWidths, ViewportRect, Workspace,
};
use crate::widgets::theme;
use bevy::ecs::system::SystemState;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::egui::{
    self, Align, CursorIcon, Frame, Id, LayerId, Layout, Margin, Panel, Rect, ScrollArea, Sense,
    Ui, UiBuilder,
};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

/// The panels around the 3D view.
///
/// Draws in [`EguiPrimaryContextPass`] and writes [`ViewportRect`]; the panels write requests.
pub struct LayoutPlugin;

impl Plugin for LayoutPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Panels>().add_systems(
            EguiPrimaryContextPass,
            (set_style, lay_out).chain().in_set(UiSystems::Panels),
        );
    }
}

/// Once a theme: a style set every frame would request the next frame.
fn set_style(
    mut contexts: EguiContexts,
    theme: Res<Theme>,
    mut set: Local<Option<Theme>>,
) -> Result {
    if *set != Some(*theme) {
        let ctx = contexts.ctx_mut()?;
        theme::apply(ctx);
        ctx.options_mut(|options| options.zoom_with_keyboard = false);
        *set = Some(*theme);
    }
    Ok(())
}

fn lay_out(world: &mut World, contexts: &mut SystemState<EguiContexts>) -> Result {
    let ctx = contexts.get_mut(world)?.ctx_mut()?.clone();
    let mut root = Ui::new(
        ctx.clone(),
        Id::new("root"),
        UiBuilder::new().layer_id(LayerId::background()).max_rect(ctx.viewport_rect()),
    );
    world.resource_mut::<SceneCover>().bypass_change_detection().0.clear();
    if world.resource::<Presentation>().panels && world.contains_resource::<OpenWorld>() {
        panels_ui(world, &mut root)?;
    }
    let hole = root.available_rect_before_wrap();
    // egui may be zoomed; the window's logical pixels are not.
    let rect = ViewportRect {
        min: Vec2::new(hole.min.x, hole.min.y) * ctx.zoom_factor(),
        size: Vec2::new(hole.width().max(1.0), hole.height().max(1.0)) * ctx.zoom_factor(),
    };
    if world.get_resource::<ViewportRect>() != Some(&rect) {
        world.insert_resource(rect);
        world.write_message(RequestRedraw);
    }
    Ok(())
}

fn panels_ui(world: &mut World, root: &mut Ui) -> Result {
    let workspace = *world.resource::<Workspace>();
    if !workspace.is_presentation {
        let bar = theme::panel_frame(Margin::symmetric(6, 0));
        let top = Panel::top("top bar").exact_size(theme::TOP_BAR_HEIGHT).frame(bar);
        top.show(root, |ui| world.run_system_cached_with(top_bar, ui)).inner?;
        let status = Panel::bottom("status").exact_size(theme::STATUS_BAR_HEIGHT).frame(bar);
        status.show(root, |ui| world.run_system_cached_with(status_bar, ui)).inner?;
    }
    let own = world.resource::<Panels>().0.iter();
    let own = own.filter(|panel| panel.info.workspace == workspace.name);
    let shown: Vec<Registered> =
        own.filter(|panel| (panel.info.is_shown)(world)).copied().collect();
    for panel in shown.iter().filter(|panel| panel.info.side == Side::Bottom) {
        Panel::bottom(Id::new(("bottom", workspace.name)))
            .exact_size((panel.info.height)(world))
            .frame(theme::panel_frame(Margin::symmetric(8, 0)))
            .show(root, |ui| draw(world, panel, ui));
    }
    let unfolded = *world.resource::<PanelsShown>();
    let sides = [(Side::Left, unfolded.left), (Side::Right, unfolded.right)];
    let sides = sides.map(|(side, is_unfolded)| {
        let of_side = shown.iter().filter(|panel| panel.info.side == side).copied();
        let of_side: Vec<Registered> = of_side.collect();
        let is_shown = !of_side.is_empty() && (is_unfolded || workspace.is_presentation);
        let wanted = is_shown.then(|| wanted_width(world, workspace, side));
        (side, of_side, wanted)
    });
    let wanted = [sides[0].2, sides[1].2];
    let widths = fitted_widths(wanted, root.ctx().viewport_rect().width());
    for ((side, of_side, _), width) in sides.iter().zip(widths) {
        if let Some(width) = width {
            side_ui(world, root, workspace, *side, width, of_side);
        }
    }
    for panel in shown.iter().filter(|panel| panel.info.side == Side::Stage) {
        draw(world, panel, root);
    }
    Ok(())
}

/// A panel whose optional neighbours are absent draws nothing.
fn draw(world: &mut World, panel: &Registered, ui: &mut Ui) {
    let _ = world.run_system_with(panel.system, ui);
}

/// Narrowest left and right side: names and switches; a label with three numbers.
const LEAST_WIDTHS: [f32; 2] = [190.0, 264.0];

/// Part of the window that a side may take.
const MOST_PART: f32 = 0.45;

/// Part of the window's width that is left for the 3D view.
const LEAST_SCENE_PART: f32 = 0.33;

/// What the preferences know a side's width by.
fn width_key(workspace: Workspace, side: Side) -> String {
    let name = if side == Side::Left { "left" } else { "right" };
    format!("{} {name}", workspace.name)
}

/// As it was dragged last, or as the workspace has it.
fn wanted_width(world: &World, workspace: Workspace, side: Side) -> f32 {
    let [left, right] = workspace.side_widths;
    let own = if side == Side::Left { left } else { right };
    let dragged = world.resource::<SideWidths>().0.get(&width_key(workspace, side)).copied();
    dragged.map_or(own, |dragged| dragged as f32)
}

/// Widths of the left and the right side in a window of this width, from those that are wanted.
/// Where they leave too little for the 3D view both are narrowed, and where they would be too narrow
/// to be read the left one goes: it is there again once the right one is folded.
fn fitted_widths(wanted: [Option<f32>; 2], window: f32) -> [Option<f32>; 2] {
    let for_both = window * (1.0 - LEAST_SCENE_PART);
    let [least_left, least_right] = LEAST_WIDTHS;
    let alone =
        |side: usize| wanted[side].map(|width| width_between(width, LEAST_WIDTHS[side], window));
    let (Some(left), Some(right)) = (alone(0), alone(1)) else {
        return [alone(0), alone(1)];
    };
    if for_both < least_left + least_right {
        return [None, Some(right)];
    }
    let over = (left + right - for_both).max(0.0);
    let spare = (left + right - least_left - least_right).max(1.0);
    let narrowed = |width: f32, least: f32| width - over * (width - least) / spare;
    [Some(narrowed(left, least_left)), Some(narrowed(right, least_right))]
}

/// A width that can be read and leaves the window its larger part.
fn width_between(width: f32, least: f32, window: f32) -> f32 {
    width.clamp(least, (window * MOST_PART).max(least))
}

fn side_ui(
    world: &mut World,
    root: &mut Ui,
    workspace: Workspace,
    side: Side,
    width: f32,
    panels: &[Registered],
) {
    let is_left = side == Side::Left;
    let key = width_key(workspace, side);
    let id = Id::new(("side", &key));
    // The panel is as wide as it is, whatever is in it.
    let panel = if is_left { Panel::left(id) } else { Panel::right(id) };
    let shown = panel.exact_size(width).frame(theme::panel_frame(Margin::ZERO)).show(root, |ui| {
        // What is wider than the side is cut; it would move the side's edge.
        let inside = UiBuilder::new().max_rect(ui.max_rect()).layout(Layout::top_down(Align::Min));
        let ui = &mut ui.new_child(inside);
        for panel in panels.iter().filter(|panel| panel.info.is_fixed) {
            draw(world, panel, ui);
        }
        let margin = if is_left { theme::LEFT_MARGIN } else { theme::RIGHT_MARGIN };
        Frame::new().inner_margin(Margin::symmetric(margin, 0)).show(ui, |ui| {
            ui.set_min_width(ui.available_width());
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                for panel in panels.iter().filter(|panel| !panel.info.is_fixed) {
                    draw(world, panel, ui);
                }
                ui.add_space(8.0);
            });
        });
    });
    if let Some(dragged) = drag_ui(root, id, shown.response.rect, is_left) {
        let least = LEAST_WIDTHS[usize::from(!is_left)];
        let dragged = width_between(dragged, least, root.ctx().viewport_rect().width()).round();
        world.resource_mut::<SideWidths>().0.insert(key, f64::from(dragged));
        world.write_message(RequestRedraw);
    }
}

/// Width of the strip at a side's edge by which it is made wider.
const GRIP_WIDTH: f32 = 5.0;

/// The edge of a side; the width that it is dragged to.
fn drag_ui(root: &Ui, id: Id, side: Rect, is_left: bool) -> Option<f32> {
    let mut grip = side;
    match is_left {
        true => grip.min.x = side.max.x - GRIP_WIDTH,
        false => grip.max.x = side.min.x + GRIP_WIDTH,
    }
    let response = root.interact(grip, id.with("grip"), Sense::drag());
    if !(response.hovered() || response.dragged()) {
        return None;
    }
    root.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
    let x = if is_left { side.max.x } else { side.min.x };
    let stroke = egui::Stroke::new(1.0, palette::ACCENT.color32());
    root.painter().vline(x, side.y_range(), stroke);
    let at = response.interact_pointer_pos().filter(|_| response.dragged())?;
    Some(if is_left { at.x - side.min.x } else { side.max.x - at.x })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_window_has_sides_as_wanted() {
        assert_eq!(fitted_widths([Some(240.0), Some(300.0)], 1440.0), [Some(240.0), Some(300.0)]);
        assert_eq!(fitted_widths([None, Some(300.0)], 1440.0), [None, Some(300.0)]);
        assert_eq!(fitted_widths([Some(5000.0), None], 1000.0), [Some(450.0), None]);
    }

    #[test]
    fn sides_leave_a_third_of_a_narrow_window() {
        for window in [683.0, 720.0, 800.0, 900.0_f32] {
            let [left, right] = fitted_widths([Some(240.0), Some(360.0)], window);
            let (left, right) = (left.unwrap(), right.unwrap());
            assert!(
                left >= LEAST_WIDTHS[0] && right >= LEAST_WIDTHS[1],
                "{window}: {left} {right}"
            );
            assert!(left + right <= 0.67 * window + 1e-3, "{window}: {left} {right}");
        }
    }

    #[test]
    fn one_side_stands_where_two_do_not_fit() {
        assert_eq!(fitted_widths([Some(240.0), Some(300.0)], 512.0), [None, Some(264.0)]);
        assert_eq!(fitted_widths([Some(240.0), None], 512.0), [Some(230.4), None]);
    }
}
