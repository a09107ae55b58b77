//! Lets the window sleep: no frame is drawn while nothing changes.

use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy_egui::{EguiInput, EguiPreUpdateSet, egui};

/// Drops the input that is none.
///
/// bevy_egui tells egui the state of the modifier keys every frame. egui asks for a repaint
/// whenever it is told anything, and that repaint tells it the state of the modifier keys again:
/// the window would never come to rest.
pub struct WakePlugin;

impl Plugin for WakePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            PreUpdate,
            drop_repeated_modifiers
                .after(EguiPreUpdateSet::ProcessInput)
                .before(EguiPreUpdateSet::BeginPass),
        );
    }
}

fn drop_repeated_modifiers(
    mut inputs: Query<(Entity, &mut EguiInput)>,
    mut last: Local<HashMap<Entity, egui::Modifiers>>,
) {
    for (entity, mut input) in &mut inputs {
        let last = last.entry(entity).or_default();
        input.events.retain(|event| match event {
            egui::Event::ModifiersChanged(modifiers) => {
                let is_new = modifiers != last;
                *last = *modifiers;
                is_new
            }
            _ => true,
        });
    }
}
