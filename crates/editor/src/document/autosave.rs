//! Nothing lost: what is unsaved is kept in a recovery file, written in the background, and
//! what a crash left over is offered at the next start.

use crate::document::dialog::DesignDialog;
use crate::document::requests::OpenWorld;
use crate::document::state::Notice;
use crate::runner::jobs::{JobInfo, Runner};
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::Dialogs;
use bevy::app::AppExit;
use bevy::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use trackwright_project::{Leftover, Recovery, Snapshot, StoreError, leftovers};
use trackwright_task::Task;

/// After an edit the file is written once there was none for so long…
const QUIET: Duration = Duration::from_millis(400);

/// …but never later than this: a drag goes on for minutes.
const LATEST: Duration = Duration::from_secs(3);

/// Where recovery files are. Insert before the plugins; without it nothing is kept, as in
/// pictures.
#[derive(Resource, Clone, Debug)]
pub struct RecoveryFolder(pub PathBuf);

/// Keeps [`Recovery`] up to date with the open document.
pub struct AutosavePlugin;

/// What crashed sessions left, the newest first; each is this process's while it is held. Those
/// that were opened stand apart: they go once this session has a file of its own.
#[derive(Resource, Default)]
pub struct Leftovers(pub Vec<Leftover>, pub Vec<Leftover>);

/// Writes in the background.
#[derive(Resource)]
pub struct Autosave {
    /// Its answers are problems.
    runner: Runner<(), String>,
    recovery: Arc<Mutex<Recovery>>,
    /// What goes once a file of this session is written.
    replaced: Arc<Mutex<Vec<Leftover>>>,
    waker: Waker,
    /// The problem that was reported last: each is reported once.
    problem: String,
    /// Generation, revision and dirtiness that were handed over last.
    kept: Option<(u64, u64, bool)>,
}

impl Plugin for AutosavePlugin {
    fn build(&self, app: &mut App) {
        let Some(RecoveryFolder(folder)) = app.world().get_resource::<RecoveryFolder>().cloned()
        else {
            return;
        };
        match start(&folder, app.world_mut().get_resource_or_init::<Waker>().clone()) {
            Ok((autosave, leftovers)) => {
                app.insert_resource(autosave)
                    .insert_resource(Leftovers(leftovers, Vec::new()))
                    .add_systems(Startup, offer)
                    .add_systems(
                        Update,
                        (keep.run_if(resource_exists_and_changed::<OpenWorld>), receive)
                            .chain()
                            .after(EditorSystems::Edit),
                    )
                    .add_systems(Last, finish.run_if(on_message::<AppExit>));
            }
            Err(error) => {
                app.insert_resource(Notice::Refused(not_kept(&error)));
            }
        }
    }
}

/// What happened and what to do.
fn not_kept(cause: &dyn std::fmt::Display) -> String {
    format!("Unsaved changes are not kept for a crash, so save often: {cause}")
}

fn start(folder: &Path, waker: Waker) -> Result<(Autosave, Vec<Leftover>), StoreError> {
    let left = leftovers(folder)?;
    let autosave = Autosave {
        // A file that is written changes nothing that is shown.
        runner: Runner::new("autosave", Waker::silent()),
        recovery: Arc::new(Mutex::new(Recovery::start(folder)?)),
        replaced: Arc::default(),
        waker,
        problem: String::new(),
        kept: None,
    };
    Ok((autosave, left))
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Autosave {
    fn submit(
        &mut self,
        info: JobInfo,
        write: impl FnOnce(&mut Recovery) -> Result<(), StoreError> + Send + 'static,
    ) {
        let (recovery, waker) = (Arc::clone(&self.recovery), self.waker.clone());
        let work = move |_: &Task, report: &mut dyn FnMut(String)| {
            let problem = write(&mut lock(&recovery)).err();
            report(problem.as_ref().map(ToString::to_string).unwrap_or_default());
            if problem.is_some() {
                waker.wake();
            }
            None
        };
        self.runner.submit(info, (), Box::new(work));
    }

    fn keep(&mut self, snapshot: Snapshot, replaced: Vec<Leftover>) {
        let info = JobInfo { quiet: QUIET, longest_wait: LATEST, ..JobInfo::default() };
        let goes = Arc::clone(&self.replaced);
        self.submit(info, move |recovery| {
            // Those that are recovered later are not in this snapshot.
            let goes = std::mem::take(&mut *lock(&goes));
            recovery.write(&snapshot)?;
            goes.into_iter().try_for_each(Leftover::discard)
        });
        lock(&self.replaced).extend(replaced);
    }

    /// Everything is saved, or was given up.
    fn clear(&mut self) {
        lock(&self.replaced).clear();
        self.submit(JobInfo::default(), Recovery::clear);
    }
}

/// However the program ends, short of being killed: no dialog appears, and nothing is lost.
impl Drop for Autosave {
    fn drop(&mut self) {
        self.runner.finish();
    }
}

fn keep(
    world: Res<OpenWorld>,
    generation: Res<crate::document::state::WorldGeneration>,
    mut autosave: ResMut<Autosave>,
    mut leftovers: ResMut<Leftovers>,
) {
    let document = &world.0.document;
    let now = (generation.0, document.revision(), document.is_dirty());
    // A view that moves is kept with the next edit: turning a camera loses nobody's work.
    if autosave.kept == Some(now) {
        return;
    }
    match document.is_dirty() {
        true => autosave.keep(Snapshot::of(&world.0), std::mem::take(&mut leftovers.1)),
        false => autosave.clear(),
    }
    autosave.kept = Some(now);
}

fn receive(mut autosave: ResMut<Autosave>, mut notice: ResMut<Notice>) {
    for answer in autosave.runner.answers() {
        let problem = answer.value.unwrap_or_else(|lost| lost.to_string());
        if !problem.is_empty() && problem != autosave.problem {
            *notice = Notice::Refused(not_kept(&problem));
        }
        autosave.problem = problem;
    }
}

fn offer(leftovers: Res<Leftovers>, mut dialogs: ResMut<Dialogs>) {
    if let Some(dialog) = DesignDialog::recover(&leftovers.0) {
        dialogs.show(dialog);
    }
}

/// The window closes after its dialog was answered: nothing is left to recover.
fn finish(mut exits: MessageReader<AppExit>, mut autosave: ResMut<Autosave>) {
    let is_clean = exits.read().any(AppExit::is_success);
    if is_clean {
        autosave.clear();
    }
    autosave.runner.finish();
}
