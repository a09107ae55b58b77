//! Files that are shown by other programs: a page by the browser, a folder by the file manager.

use crate::runner::jobs::Job;
use crate::runner::wake::Waker;
use crate::schedule::request_then_receive;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Opens what [`OpenOutside`] names, by a thread that waits for it: the window does not.
pub struct OpenOutsidePlugin;

/// Requests that a file or folder is opened by the program that this system has for it.
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub struct OpenOutside(pub PathBuf);

/// The program that opens files by their kind.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct Opener(pub PathBuf);

impl Default for Opener {
    fn default() -> Self {
        Self(PathBuf::from(match std::env::consts::OS {
            "macos" => "open",
            "windows" => "explorer",
            _ => "xdg-open",
        }))
    }
}

/// A file that is being opened. One that follows it takes its place; what was started goes on.
#[derive(Resource, Default)]
pub struct OpenJob(Option<(PathBuf, Job<Result<(), OpenError>>)>);

impl OpenJob {
    pub fn is_opening(&self) -> bool {
        self.0.is_some()
    }
}

/// Why a file was not opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    #[error("found no such file or folder any more")]
    Gone,
    #[error("{} cannot be started: {cause}", opener.display())]
    Start { opener: PathBuf, cause: std::io::Error },
    #[error("{} ended with {status}", opener.display())]
    Refused { opener: PathBuf, status: std::process::ExitStatus },
}

impl Plugin for OpenOutsidePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Opener>()
            .init_resource::<OpenJob>()
            .add_message::<OpenOutside>()
            .add_systems(
                Update,
                request_then_receive(
                    answer.run_if(on_message::<OpenOutside>),
                    receive.run_if(|job: Res<OpenJob>| job.is_opening()),
                ),
            );
    }
}

fn answer(
    mut requests: MessageReader<OpenOutside>,
    opener: Res<Opener>,
    mut job: ResMut<OpenJob>,
    waker: Res<Waker>,
) {
    for OpenOutside(file) in requests.read() {
        let (to_open, opener) = (file.clone(), opener.0.clone());
        let work = Job::start("open", &waker, move |_| open(&opener, &to_open));
        job.0 = Some((file.clone(), work));
    }
}

fn open(opener: &Path, file: &Path) -> Result<(), OpenError> {
    if !file.exists() {
        return Err(OpenError::Gone);
    }
    let silent = Command::new(opener)
        .arg(file)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let opener = opener.to_owned();
    match silent {
        Ok(status) if status.success() => Ok(()),
        // It reports 1 whatever it does.
        Ok(_) if opener == Path::new("explorer") => Ok(()),
        Ok(status) => Err(OpenError::Refused { opener, status }),
        Err(cause) => Err(OpenError::Start { opener, cause }),
    }
}

fn receive(
    mut job: ResMut<OpenJob>,
    mut dialogs: ResMut<Dialogs>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let opening = job.bypass_change_detection().0.as_ref();
    let Some(answer) = opening.and_then(|(_, job)| job.answer()) else {
        return;
    };
    let Some((file, _)) = job.0.take() else { return };
    let why = match answer {
        Ok(Ok(())) => return,
        Ok(Err(error)) => error.to_string(),
        Err(lost) => lost.to_string(),
    };
    let text = format!("{}: {why}. It can be opened by hand from there.", file.display());
    dialogs.show(ErrorDialog { title: "The file cannot be shown".to_owned(), text });
    redraw.write(RequestRedraw);
}
