//! Which widget has the keyboard: a ring around it, and which keys are its own.

use crate::palette::{self, ThemedColor};
use crate::schedule::UiSystems;
use crate::shell::shortcuts::{KeyboardFocus, KeysTaken};
use bevy::prelude::*;
use bevy_egui::egui::{Context, Event, Key, Stroke, StrokeKind};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

const RING_WIDTH: f32 = 2.0;
const RING_RADIUS: f32 = 3.0;

pub(super) fn plugin(app: &mut App) {
    app.add_systems(
        EguiPrimaryContextPass,
        follow.run_if(resource_exists::<KeyboardFocus>).after(UiSystems::Dialogs),
    );
}

fn follow(
    mut contexts: EguiContexts,
    mut focus: ResMut<KeyboardFocus>,
    taken: Res<KeysTaken>,
    mut is_by_keys: Local<bool>,
) -> Result {
    let ctx = contexts.ctx_mut()?;
    // What takes the keys has them alone.
    if let Some(id) = ctx.memory(|memory| memory.focused()).filter(|_| taken.0) {
        ctx.memory_mut(|memory| memory.surrender_focus(id));
    }
    focus.set_if_neq(focus_ui(ctx, &mut is_by_keys));
    Ok(())
}

/// Draws the ring around whatever has the keyboard, once the keyboard led there; a field of text shows it by
/// itself. At the end of a pass, when all that can have it has been drawn.
pub fn focus_ui(ctx: &Context, is_by_keys: &mut bool) -> KeyboardFocus {
    ctx.input(|input| {
        for event in &input.events {
            match event {
                Event::Key { key: Key::Tab, pressed: true, .. } => *is_by_keys = true,
                Event::PointerButton { pressed: true, .. } => *is_by_keys = false,
                _ => {}
            }
        }
    });
    let Some(id) = ctx.memory(|memory| memory.focused()) else {
        return KeyboardFocus::Commands;
    };
    if ctx.text_edit_focused() {
        return KeyboardFocus::Text;
    }
    if let Some(response) = ctx.read_response(id).filter(|_| *is_by_keys) {
        ctx.layer_painter(response.layer_id).rect_stroke(
            response.interact_rect,
            RING_RADIUS,
            Stroke::new(RING_WIDTH, palette::ACCENT.color32()),
            StrokeKind::Outside,
        );
    }
    KeyboardFocus::Widget
}
