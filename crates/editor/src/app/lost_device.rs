//! A graphics adapter that fails: the program reports it and ends, and loses nothing.
//!
//! Everything that is drawn lives on the adapter. Instead of an empty window that still takes
//! edits, the next start offers what was not saved.

use bevy::app::AppExit;
use bevy::prelude::*;
use bevy::render::error_handler::{ErrorType, RenderError, RenderErrorHandler, RenderErrorPolicy};
use std::any::Any;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Ends the program when the adapter fails, and reports to [`Failure`] why.
pub struct LostDevicePlugin;

/// Why the program ended by itself, for whoever started it: kept beyond the app.
#[derive(Resource, Clone, Debug, Default)]
pub struct Failure {
    reason: Arc<Mutex<Option<String>>>,
    /// The last panic of a thread that renders.
    panic: Arc<Mutex<Option<String>>>,
}

impl Failure {
    /// The first thing that went wrong.
    pub fn reason(&self) -> Option<String> {
        locked(&self.reason).clone()
    }

    /// How the renderer ended, where it did without its own error handler.
    pub(crate) fn panic(&self) -> Option<String> {
        locked(&self.panic).clone()
    }

    fn report(&self, reason: String) {
        locked(&self.reason).get_or_insert(reason);
    }

    /// Keeps the panics of threads that render from now on.
    ///
    /// A device that goes away within a frame ends the thread that renders, and with it the frame:
    /// all that the app gets of that is an exit code.
    pub(crate) fn keep_panics(&self) {
        let panic = Arc::clone(&self.panic);
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            let is_renderer =
                std::thread::current().name().is_none_or(|name| name.starts_with(TASK_POOL));
            if is_renderer {
                *locked(&panic) = Some(panic_in_words(info.payload()));
            }
            before(info);
        }));
    }
}

/// What the threads are called that run systems; the thread that renders has no name.
const TASK_POOL: &str = "Compute Task Pool";

fn locked(text: &Mutex<Option<String>>) -> MutexGuard<'_, Option<String>> {
    text.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Plugin for LostDevicePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Failure>().insert_resource(RenderErrorHandler(end));
    }
}

/// What is unsaved is written when the app is dropped: see [`Autosave`](crate::document::autosave::Autosave).
fn end(error: &RenderError, main_world: &mut World, _: &mut World) -> RenderErrorPolicy {
    main_world.resource::<Failure>().report(words(error));
    main_world.write_message(AppExit::error());
    RenderErrorPolicy::StopRendering
}

fn words(error: &RenderError) -> String {
    let what = match error.ty {
        ErrorType::DeviceLost => "the graphics adapter was lost",
        ErrorType::OutOfMemory => "the graphics adapter has no memory left",
        ErrorType::Validation | ErrorType::Internal => "the graphics adapter refused to draw",
    };
    in_words(what, &error.description)
}

/// What panics of the renderer name, which is how an adapter that went away within a frame shows.
const OF_THE_ADAPTER: [&str; 3] = ["wgpu", "Validation Error", "device is lost"];

/// The message of a panic.
pub(crate) fn panic_in_words(panic: &(dyn Any + Send)) -> String {
    let text = panic
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or_default();
    let what = match OF_THE_ADAPTER.iter().any(|name| text.contains(name)) {
        true => "the graphics adapter failed",
        false => "the editor stopped at a fault of its own",
    };
    in_words(what, text)
}

fn in_words(what: &str, description: &str) -> String {
    let mut lines = description.lines().map(str::trim);
    match lines.find(|line| !line.is_empty()) {
        Some(why) => format!("{what} ({why})"),
        None => what.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app;
    use crate::document::autosave::RecoveryFolder;
    use crate::document::requests::{EditRequest, OpenWorld};
    use bevy::app::PluginsState;
    use bevy::render::renderer::RenderDevice;
    use trackwright_design::{BodyRole, Edit};

    /// A window's frames one after the other, of which the last has no adapter any more.
    fn lose_the_adapter(mut app: App) -> AppExit {
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
        app.update();
        let mut sensor = {
            let open = app.world().resource::<OpenWorld>();
            open.0.document.design().tool.body.rigid.sensors[0].clone()
        };
        sensor.position_in_body.z += 7.0;
        app.world_mut().write_message(EditRequest::Apply(Edit::SetSensor {
            body: BodyRole::Tool,
            index: 0,
            sensor,
        }));
        app.update();
        let device = app.world().resource::<RenderDevice>();
        device.wgpu_device().destroy();
        for _ in 0..20 {
            app.update();
            if let Some(exit) = app.should_exit() {
                return exit;
            }
        }
        panic!("it went on");
    }

    /// Bevy ends with a code and nothing else once its thread that renders has panicked.
    fn panic_within_a_frame(_: App) -> AppExit {
        let render = std::thread::spawn(|| panic!("wgpu error: the device is lost"));
        assert!(render.join().is_err());
        AppExit::error()
    }

    #[test]
    fn an_adapter_lost_within_a_frame_is_named() {
        let mut app = App::new();
        app.set_runner(panic_within_a_frame);
        let message = app::run(app).unwrap_err().to_string();
        let expected = "the graphics adapter failed (wgpu error: the device is lost)";
        assert!(message.starts_with(expected), "{message}");
        // Another end has its code.
        let mut app = App::new();
        app.set_runner(|_| AppExit::from_code(3));
        assert_eq!(app::run(app), Err(app::EditorError::Code(3)));
    }

    #[test]
    fn a_lost_adapter_saves_a_recovery_file_and_exits() {
        let folder = tempfile::tempdir().unwrap();
        let world = trackwright_project::open_builtin("pointer-on-head").unwrap();
        let before_mm = world.document.design().tool.body.rigid.sensors[0].position_in_body.z;
        let (mut app, _) = app::offscreen(world, UVec2::new(320, 240), true, |app| {
            app.insert_resource(RecoveryFolder(folder.path().to_owned()));
        });
        app.set_runner(lose_the_adapter);
        let error = app::run(app).unwrap_err();
        let message = error.to_string();
        assert!(message.starts_with("the graphics adapter"), "{message}");
        let left = trackwright_project::leftovers(folder.path()).unwrap();
        let world = left.first().expect("a recovery file").open().unwrap();
        let after_mm = world.document.design().tool.body.rigid.sensors[0].position_in_body.z;
        assert!((after_mm - before_mm - 7.0).abs() < 1e-12);
    }
}
