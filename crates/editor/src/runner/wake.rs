//! Lets the window sleep: no frame is drawn while nothing changes, and none is left out that is
//! needed.

use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy::winit::{EventLoopProxyWrapper, WinitUserEvent};
use bevy_egui::{EguiInput, EguiPostUpdateSet, EguiPreUpdateSet, EguiRenderOutput, egui};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// How a thread in the background requests the frame that shows what it found; does nothing where
/// frames are driven by hand.
#[derive(Resource, Clone)]
pub struct Waker(Arc<OnceLock<Box<dyn Fn() + Send + Sync>>>);

impl Waker {
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        let waker = Self::silent();
        waker.wake_with(wake);
        waker
    }

    /// Wakes nothing as yet.
    pub fn silent() -> Self {
        Self(Arc::default())
    }

    /// Names what is woken, for all clones; only the first name counts.
    pub fn wake_with(&self, wake: impl Fn() + Send + Sync + 'static) {
        // A second one would wake the same loop once more.
        let _ = self.0.set(Box::new(wake));
    }

    pub fn wake(&self) {
        if let Some(wake) = self.0.get() {
            wake();
        }
    }
}

impl FromWorld for Waker {
    /// Wakes the window's event loop, where there is one.
    fn from_world(world: &mut World) -> Self {
        match world.get_resource::<EventLoopProxyWrapper>() {
            None => Self::silent(),
            Some(proxy) => {
                let proxy = (**proxy).clone();
                Self::new(move || {
                    // The loop is gone only when the window is.
                    let _ = proxy.send_event(WinitUserEvent::WakeUp);
                })
            }
        }
    }
}

/// Drops the input that is none, and requests the frame that shows new letters.
///
/// bevy_egui sends egui the state of the modifier keys every frame. egui requests a repaint
/// whenever it receives input, and that repaint sends the state of the modifier keys again: the
/// window would never come to rest.
///
/// egui reads the time from the renderer, which keeps that of its last frame. After a rest the frame
/// of a press would have the time of that frame, and the release, one frame later, that of the clock:
/// every click would be taken for a long hold, until the pointer moves.
///
/// The other way round, letters that were never drawn before reach the graphics adapter a frame
/// late; without another frame they stay missing until the next input.
pub struct WakePlugin;

impl Plugin for WakePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            PreUpdate,
            (drop_repeated_modifiers, keep_time)
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

/// Gives egui the time of the clock, in seconds since the first frame.
fn keep_time(mut inputs: Query<&mut EguiInput>, mut first: Local<Option<Instant>>) {
    let elapsed = first.get_or_insert_with(Instant::now).elapsed();
    for mut input in &mut inputs {
        input.time = Some(elapsed.as_secs_f64());
    }
}

fn show_new_letters(outputs: Query<&EguiRenderOutput>, mut redraws: MessageWriter<RequestRedraw>) {
    if outputs.iter().any(|o| !o.textures_delta.set.is_empty()) {
        redraws.write(RequestRedraw);
    }
}
