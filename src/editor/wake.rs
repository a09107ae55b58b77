//! Lets the window sleep: no frame is drawn while nothing changes, and none is left out that is
//! needed.

use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::{EguiInput, EguiPostUpdateSet, EguiPreUpdateSet, EguiRenderOutput, egui};

/// Drops the input that is none, and asks for the frame that shows new letters.
///
/// bevy_egui tells egui the state of the modifier keys every frame. egui asks for a repaint
/// whenever it is told anything, and that repaint tells it the state of the modifier keys again:
/// the window would never come to rest.
///
/// The other way round, letters that were never drawn before reach the graphics adapter a frame
/// late; without another frame they stay missing until the next input.
pub struct WakePlugin;

impl Plugin for WakePlugin {
    fn build(&self, app: &mut App) {
        app.add_message::<RequestRedraw>()
            .add_systems(
                PreUpdate,
                drop_repeated_modifiers
                    .after(EguiPreUpdateSet::ProcessInput)
                    .before(EguiPreUpdateSet::BeginPass),
            )
            .add_systems(
                PostUpdate,
                show_new_letters
                    .after(EguiPostUpdateSet::ProcessOutput)
                    .before(EguiPostUpdateSet::PostProcessOutput),
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

fn show_new_letters(outputs: Query<&EguiRenderOutput>, mut redraws: MessageWriter<RequestRedraw>) {
    if outputs.iter().any(|o| !o.textures_delta.set.is_empty()) {
        redraws.write(RequestRedraw);
    }
}
