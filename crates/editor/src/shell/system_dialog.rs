//! The system's own file dialog, for whoever has places and bookmarks there: opened by a thread
//! of its own, its choice handed to the dialog that asked for it.

use crate::runner::job::{Ended, Job};
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::Dialogs;
use crate::shell::dialogs::file_dialog::{SystemChoice, Wish};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::path::PathBuf;

/// Answers dialogs whose [`SystemChoice`] is asked for, in [`EditorSystems::Input`].
pub struct SystemDialogPlugin;

/// The dialog that is open outside of the window, if any. One that nobody waits for any more is
/// left to the person to close.
#[derive(Resource, Default)]
struct Outside(Option<Job<Option<PathBuf>>>);

impl Plugin for SystemDialogPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Outside>()
            .init_resource::<Dialogs>()
            .init_resource::<Waker>()
            .add_message::<RequestRedraw>()
            .add_systems(Update, follow.run_if(is_any_open).in_set(EditorSystems::Input));
    }
}

fn is_any_open(dialogs: Res<Dialogs>, outside: Res<Outside>) -> bool {
    dialogs.current.is_some() || outside.0.is_some()
}

fn follow(
    mut dialogs: ResMut<Dialogs>,
    mut outside: ResMut<Outside>,
    waker: Res<Waker>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    // Writing to the resource would mark it as changed in every frame.
    let current = &mut dialogs.bypass_change_detection().current;
    let wish = current.as_mut().and_then(|dialog| dialog.wish());
    let Some(wish) = wish.filter(|wish| *wish.choice != SystemChoice::Ours) else {
        outside.0 = None;
        return;
    };
    if *wish.choice == SystemChoice::Asked {
        *wish.choice = match start(&wish, &waker) {
            Ok(job) => {
                outside.0 = Some(job);
                SystemChoice::Open
            }
            Err(error) => SystemChoice::Nothing(format!("cannot start a thread: {error}")),
        };
        redraw.write(RequestRedraw);
        return;
    }
    let ended = outside.0.as_mut().and_then(|job| job.hear());
    let Some(ended) = ended else { return };
    outside.0 = None;
    *wish.choice = match ended {
        Ended::Done(Some(path)) => SystemChoice::Chosen(path),
        Ended::Done(None) => SystemChoice::Nothing(NOTHING.to_owned()),
        Ended::Lost => SystemChoice::Nothing(LOST.to_owned()),
    };
    redraw.write(RequestRedraw);
}

/// The system does not tell one from the other.
const NOTHING: &str = "the system dialog was closed without a choice, or this system has none";
const LOST: &str = "this system's dialog ended badly";

fn start(wish: &Wish, waker: &Waker) -> std::io::Result<Job<Option<PathBuf>>> {
    let extensions: Vec<String> =
        wish.kind.extensions().iter().map(|end| end.trim_start_matches('.').to_owned()).collect();
    let dialog = rfd::FileDialog::new()
        .set_title(wish.title)
        .set_directory(&wish.folder)
        .set_file_name(&wish.name)
        .add_filter(wish.kind.note(), &extensions);
    let is_saving = wish.is_saving;
    Job::start("system dialog", waker, move |_| match is_saving {
        true => dialog.save_file(),
        false => dialog.pick_file(),
    })
}
