//! Nothing lost: what is unsaved is kept in a recovery file, written by a thread of its own, and
//! what a crash left over is offered at the next start.

use crate::document::apply::Notice;
use crate::document::requests::OpenWorld;
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::{Dialog, Dialogs};
use bevy::app::AppExit;
use bevy::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use trackwright_project::{Leftover, Recovery, Snapshot, StoreError, leftovers};

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

/// The thread that writes.
#[derive(Resource)]
pub struct Autosave {
    sender: Option<Sender<Word>>,
    problems: Mutex<Receiver<String>>,
    thread: Option<JoinHandle<()>>,
    /// Revision and dirtiness that were sent last.
    sent: Option<(u64, u64, bool)>,
}

/// What the thread is told.
enum Word {
    Keep(Box<Snapshot>, Vec<Leftover>),
    /// Everything is saved, or was given up.
    Clear,
}

impl Plugin for AutosavePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Leftovers>()
            .init_resource::<Notice>()
            .init_resource::<Dialogs>()
            .init_resource::<Waker>();
        let Some(RecoveryFolder(folder)) = app.world().get_resource::<RecoveryFolder>().cloned()
        else {
            return;
        };
        match start(&folder, app.world().resource::<Waker>().clone()) {
            Ok((autosave, leftovers)) => {
                app.insert_resource(autosave)
                    .insert_resource(Leftovers(leftovers, Vec::new()))
                    .add_systems(Startup, offer)
                    .add_systems(
                        Update,
                        (keep.run_if(resource_exists_and_changed::<OpenWorld>), hear)
                            .chain()
                            .after(EditorSystems::Edit),
                    )
                    .add_systems(Last, finish.run_if(on_message::<AppExit>));
            }
            Err(error) => {
                *app.world_mut().resource_mut::<Notice>() = refusal(&error);
            }
        }
    }
}

fn refusal(error: &StoreError) -> Notice {
    Notice::Refused(not_kept(error))
}

/// What happened and what to do.
fn not_kept(cause: &dyn std::fmt::Display) -> String {
    format!("Unsaved changes are not kept for a crash, so save often: {cause}")
}

fn start(folder: &Path, waker: Waker) -> Result<(Autosave, Vec<Leftover>), StoreError> {
    let left = leftovers(folder)?;
    let recovery = Recovery::start(folder)?;
    let (sender, words) = channel();
    let (report, problems) = channel();
    let thread = std::thread::Builder::new()
        .name("autosave".into())
        .spawn(move || write(recovery, &words, &report, &waker))
        .map_err(|cause| StoreError::Write { file: folder.to_owned(), cause })?;
    let autosave = Autosave {
        sender: Some(sender),
        problems: Mutex::new(problems),
        thread: Some(thread),
        sent: None,
    };
    Ok((autosave, left))
}

/// Until the window is gone. Ends without a word where nobody said [`Word::Clear`]: what is
/// unsaved then is what recovery is for.
fn write(mut recovery: Recovery, words: &Receiver<Word>, report: &Sender<String>, waker: &Waker) {
    let mut told = String::new();
    while let Ok(word) = words.recv() {
        let result = match newest(word, words) {
            Word::Keep(snapshot, replaced) => recovery
                .write(&snapshot)
                .and_then(|_| replaced.into_iter().try_for_each(Leftover::discard)),
            Word::Clear => recovery.clear(),
        };
        // The same problem is told once.
        let problem = result.err().map(|e| e.to_string()).unwrap_or_default();
        if !problem.is_empty() && problem != told && report.send(problem.clone()).is_ok() {
            waker.wake();
        }
        told = problem;
    }
}

/// The last word of a stream of them.
fn newest(first: Word, words: &Receiver<Word>) -> Word {
    let since = Instant::now();
    let mut word = first;
    loop {
        if matches!(word, Word::Clear) {
            return word;
        }
        let patience = QUIET.min(LATEST.saturating_sub(since.elapsed()));
        match words.recv_timeout(patience) {
            Ok(next) => word = after(word, next),
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => return word,
        }
    }
}

/// A later word takes an earlier one's place, but for what is to go once something is written.
fn after(earlier: Word, later: Word) -> Word {
    match (earlier, later) {
        (Word::Keep(_, mut replaced), Word::Keep(snapshot, more)) => {
            replaced.extend(more);
            Word::Keep(snapshot, replaced)
        }
        (_, later) => later,
    }
}

impl Autosave {
    fn tell(&self, word: Word) {
        if let Some(sender) = &self.sender {
            // A thread that is gone has said why.
            let _ = sender.send(word);
        }
    }

    /// Waits until what was told last is on the disk.
    fn end(&mut self) {
        self.sender = None;
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been reported by the panic hook.
            let _ = thread.join();
        }
    }
}

/// However the program ends, short of being killed: nobody is asked, and nothing is lost.
impl Drop for Autosave {
    fn drop(&mut self) {
        self.end();
    }
}

fn keep(
    world: Res<OpenWorld>,
    generation: Res<crate::document::apply::WorldGeneration>,
    mut autosave: ResMut<Autosave>,
    mut leftovers: ResMut<Leftovers>,
) {
    let document = &world.0.document;
    let now = (generation.0, document.revision(), document.is_dirty());
    let is_unsaved = document.is_dirty();
    // A view that moves is kept with the next edit: turning a camera loses nobody's work.
    if autosave.sent == Some(now) {
        return;
    }
    autosave.tell(match is_unsaved {
        true => Word::Keep(Box::new(Snapshot::of(&world.0)), std::mem::take(&mut leftovers.1)),
        false => Word::Clear,
    });
    autosave.sent = Some(now);
}

fn hear(autosave: Res<Autosave>, mut notice: ResMut<Notice>) {
    let problems = autosave.problems.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(problem) = problems.try_iter().last() {
        *notice = Notice::Refused(not_kept(&problem));
    }
}

fn offer(leftovers: Res<Leftovers>, mut dialogs: ResMut<Dialogs>) {
    if let Some(dialog) = Dialog::recover(&leftovers.0) {
        dialogs.show(dialog);
    }
}

/// The window closes, and whoever closed it was asked: nothing is left to recover.
fn finish(mut exits: MessageReader<AppExit>, mut autosave: ResMut<Autosave>) {
    let is_clean = exits.read().any(AppExit::is_success);
    if is_clean {
        autosave.tell(Word::Clear);
    }
    autosave.end();
}
