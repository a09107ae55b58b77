//! A graphics adapter that fails: the program ends, says so, and loses nothing.
//!
//! Everything that is drawn lives on the adapter. Instead of an empty window that still takes
//! edits, the next start offers what was not saved.

use bevy::app::AppExit;
use bevy::prelude::*;
use bevy::render::error_handler::{ErrorType, RenderError, RenderErrorHandler, RenderErrorPolicy};
use std::sync::{Arc, Mutex, PoisonError};

/// Ends the program when the adapter fails, and tells [`Failure`] why.
pub struct LostDevicePlugin;

/// Why the program ended by itself, for whoever started it: kept beyond the app.
#[derive(Resource, Clone, Debug, Default)]
pub struct Failure(Arc<Mutex<Option<String>>>);

impl Failure {
    /// The first thing that went wrong.
    pub fn reason(&self) -> Option<String> {
        let reason = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        reason.clone()
    }

    fn tell(&self, reason: String) {
        let mut first = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        first.get_or_insert(reason);
    }
}

impl Plugin for LostDevicePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Failure>()
            .insert_resource(RenderErrorHandler(end));
    }
}

/// What is unsaved is written when the app is dropped: see [`Autosave`](super::autosave::Autosave).
fn end(error: &RenderError, main_world: &mut World, _: &mut World) -> RenderErrorPolicy {
    main_world.resource::<Failure>().tell(words(error));
    main_world.write_message(AppExit::error());
    RenderErrorPolicy::StopRendering
}

fn words(error: &RenderError) -> String {
    let what = match error.ty {
        ErrorType::DeviceLost => "the graphics adapter was lost",
        ErrorType::OutOfMemory => "the graphics adapter has no memory left",
        ErrorType::Validation | ErrorType::Internal => "the graphics adapter refused to draw",
    };
    let mut lines = error.description.lines().map(str::trim);
    match lines.find(|line| !line.is_empty()) {
        Some(why) => format!("{what} ({why})"),
        None => what.to_owned(),
    }
}
