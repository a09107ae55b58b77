//! This program in a process of its own, on a copy of the open design: what it writes there is what the
//! command line writes, and the window stays as it is. One file is written at a time, and can be
//! cancelled.
//!
//! The copy is the design as it is, saved or not, in a folder that lives as long as the work.

use crate::document::file_names::default_file_name;
use crate::document::requests::FileRequest;
use crate::document::state::Notice;
use crate::runner::jobs::Job;
use crate::runner::process::run_process;
use crate::runner::wake::Waker;
use crate::schedule::request_then_receive;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use bevy::app::AppExit;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use trackwright_project::{StoreError, World as StoreWorld, file_name};
use trackwright_task::{Cancelled, Task};

/// Writes files for the plugins that request it by [`OwnProgramWriter`], and cancels on
/// [`FileRequest::CancelWriting`].
pub struct OwnProgramPlugin;

/// The program that is started: this one.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct OwnProgram(pub PathBuf);

impl Default for OwnProgram {
    fn default() -> Self {
        // Without a path, starting it reports the error.
        Self(std::env::current_exe().unwrap_or_default())
    }
}

/// A file that is to be written, and what is stated about it.
#[derive(Clone, Debug)]
pub struct FileTask {
    pub file: PathBuf,
    /// The notice once it is written.
    pub written: String,
    /// The title of the dialog that states why it is not.
    pub failed: &'static str,
    /// What follows once it is written.
    pub follow: fn(&mut Commands, PathBuf),
}

/// The file that is being written.
#[derive(Resource, Default)]
pub struct WriteJob(Option<(FileTask, Job<Result<(), OwnProgramError>>)>);

impl WriteJob {
    pub fn is_writing(&self) -> bool {
        self.0.is_some()
    }

    /// Its name.
    pub fn file_name(&self) -> Option<String> {
        self.0.as_ref().map(|(task, _)| file_name(&task.file))
    }
}

/// What the program is started with, but for the file that it writes.
pub type Arguments = Result<Vec<OsString>, StoreError>;

/// Why a process wrote nothing.
#[derive(Debug, thiserror::Error)]
pub enum OwnProgramError {
    #[error(transparent)]
    Copy(#[from] StoreError),
    #[error("the program cannot be started: {0}")]
    Start(#[from] io::Error),
    /// In the words of the command line.
    #[error("{0}")]
    Program(String),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl Plugin for OwnProgramPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<OwnProgram>()
            .init_resource::<WriteJob>()
            .add_systems(
                Update,
                request_then_receive(
                    cancel.run_if(on_message::<FileRequest>),
                    receive.run_if(|job: Res<WriteJob>| job.is_writing()),
                ),
            )
            .add_systems(Last, end.run_if(on_message::<AppExit>));
    }
}

/// Starts the program.
#[derive(SystemParam)]
pub struct OwnProgramWriter<'w> {
    program: Res<'w, OwnProgram>,
    job: ResMut<'w, WriteJob>,
    waker: Res<'w, Waker>,
    pub notice: ResMut<'w, Notice>,
}

impl OwnProgramWriter<'_> {
    /// Writes a file by a command, whose arguments are made from the copy of the design, which has
    /// been opened, and its file. What is there already is replaced: the person was shown that it is.
    pub fn write(
        &mut self,
        open: &StoreWorld,
        task: FileTask,
        arguments: impl FnOnce(&StoreWorld, &Path) -> Arguments + Send + 'static,
    ) {
        if let Some(file) = self.job.file_name() {
            *self.notice = Notice::Refused(format!("{file} is being written"));
            return;
        }
        let (program, open, file) = (self.program.0.clone(), open.clone(), task.file.clone());
        let job = Job::start("own program", &self.waker, move |task| {
            write_by(&program, open, &file, arguments, task)
        });
        self.job.0 = Some((task, job));
        // The status bar states what is written.
        self.notice.set_if_neq(Notice::Nothing);
    }
}

fn write_by(
    program: &Path,
    mut world: StoreWorld,
    file: &Path,
    arguments: impl FnOnce(&StoreWorld, &Path) -> Arguments,
    task: &Task,
) -> Result<(), OwnProgramError> {
    let folder = tempfile::tempdir()?;
    let copy = folder.path().join(default_file_name(&world.document));
    trackwright_project::save_as(&mut world, &copy)?;
    let arguments = arguments(&world, &copy)?;
    task.step(0, 1)?;
    let mut command = Command::new(program);
    command.args(arguments).arg("--output").arg(file);
    command.args(file.exists().then_some("--overwrite"));
    let ended = run_process(&mut command, &task.cancel)?;
    if ended.status.success() {
        return Ok(());
    }
    if task.cancel.is_cancelled() {
        trackwright_project::remove_interrupted(file);
        return Err(Cancelled.into());
    }
    let words = ended.complaint.trim().trim_start_matches("error: ");
    Err(OwnProgramError::Program(words.to_owned()))
}

fn cancel(mut requests: MessageReader<FileRequest>, job: Res<WriteJob>) {
    if requests.read().any(|request| *request == FileRequest::CancelWriting)
        && let Some((_, job)) = &job.0
    {
        job.cancel();
    }
}

/// The window closes: nothing is left half written.
fn end(mut job: ResMut<WriteJob>) {
    if let Some((_, mut job)) = job.0.take() {
        job.cancel();
        job.finish();
    }
}

fn receive(
    mut job: ResMut<WriteJob>,
    mut commands: Commands,
    mut dialogs: ResMut<Dialogs>,
    mut notice: ResMut<Notice>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let running = job.bypass_change_detection().0.as_ref();
    let Some(answer) = running.and_then(|(_, job)| job.answer()) else {
        return;
    };
    let Some((task, _)) = job.0.take() else { return };
    redraw.write(RequestRedraw);
    match answer {
        Ok(Ok(())) => {
            *notice = Notice::Done(task.written);
            (task.follow)(&mut commands, task.file);
        }
        Ok(Err(OwnProgramError::Cancelled(_))) => {
            *notice = Notice::Done(format!("Cancelled writing {}", file_name(&task.file)));
        }
        Ok(Err(error)) => dialogs.show(ErrorDialog::new(task.failed, &error)),
        Err(lost) => dialogs.show(ErrorDialog::new(task.failed, &lost)),
    }
}
