//! The system's own file dialog, for whoever has places and bookmarks there: opened by a thread
//! of its own, its choice handed to the dialog that requested it.

use crate::runner::jobs::Job;
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::Dialogs;
use crate::shell::dialogs::file_dialog::{FileDialog, SystemChoice};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::path::PathBuf;

/// Answers dialogs whose [`SystemChoice`] is requested, in [`EditorSystems::Input`].
pub struct SystemDialogPlugin;

/// The dialog that is open outside of the window, if any. One that nobody waits for any more is
/// left to the person to close.
#[derive(Resource, Default)]
struct Outside(Option<Job<Option<Vec<PathBuf>>>>);

impl Plugin for SystemDialogPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Outside>()
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
    let wish = current.as_mut().and_then(|dialog| dialog.files());
    let Some(wish) = wish.filter(|wish| wish.system != SystemChoice::Ours) else {
        outside.0 = None;
        return;
    };
    if wish.system == SystemChoice::Requested {
        outside.0 = Some(start(wish, &waker));
        wish.system = SystemChoice::Open;
        redraw.write(RequestRedraw);
        return;
    }
    let Some(answer) = outside.0.as_ref().and_then(Job::answer) else {
        return;
    };
    outside.0 = None;
    wish.system = match answer {
        Ok(Some(paths)) => SystemChoice::ChosenSeveral(paths),
        Ok(None) => SystemChoice::Nothing(NOTHING.to_owned()),
        Err(lost) => SystemChoice::Nothing(format!("this system's dialog: {lost}")),
    };
    redraw.write(RequestRedraw);
}

/// The system does not distinguish the two.
const NOTHING: &str = "the system dialog was closed without a choice, or this system has none";

fn start(wish: &FileDialog, waker: &Waker) -> Job<Option<Vec<PathBuf>>> {
    let extensions: Vec<String> =
        wish.kind.extensions().iter().map(|end| end.trim_start_matches('.').to_owned()).collect();
    let dialog = rfd::FileDialog::new()
        .set_title(&wish.title)
        .set_directory(&wish.folder)
        .set_file_name(wish.name())
        .add_filter(wish.kind.note(), &extensions);
    let (is_saving, takes_several) = (wish.is_saving, wish.takes_several);
    Job::start("system dialog", waker, move |_| match (is_saving, takes_several) {
        (true, _) => dialog.save_file().map(|file| vec![file]),
        (false, true) => dialog.pick_files(),
        (false, false) => dialog.pick_file().map(|file| vec![file]),
    })
}
