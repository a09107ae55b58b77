//! Writes the log of the study that is shown, in the background.

use crate::document::file_names::file_folder;
use crate::document::requests::{FileRequest, OpenWorld};
use crate::document::state::Notice;
use crate::document::trials::TrialChoice;
use crate::runner::jobs::Job;
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use crate::widgets::basic::counted;
use crate::workspaces::study::dialog::StudyDialog;
use crate::workspaces::study::state::StudyRequest;
use bevy::prelude::*;
use std::path::{Path, PathBuf};
use trackwright_project::{Files, LogError};
use trackwright_simulation::{StudyError, Trial, trial_count};

/// The log that is being written, if any.
#[derive(Resource, Default)]
pub struct LogJob(Option<Writing>);

struct Writing {
    /// Its answer is how many trials were written.
    job: Job<Result<usize, LogError>>,
    file: PathBuf,
}

impl LogJob {
    /// How far it is, from 0 to 1; `None` where none is written.
    pub fn part(&self) -> Option<f64> {
        self.0.as_ref().map(|writing| writing.job.progress())
    }
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<LogJob>().add_systems(
        Update,
        (
            answer.run_if(on_message::<FileRequest>),
            cancel.run_if(on_message::<StudyRequest>),
            receive.run_if(is_writing),
        )
            .chain()
            .in_set(EditorSystems::Solve),
    );
}

fn is_writing(job: Res<LogJob>) -> bool {
    job.0.is_some()
}

fn answer(
    mut requests: MessageReader<FileRequest>,
    world: Option<Res<OpenWorld>>,
    choice: Res<TrialChoice>,
    waker: Res<Waker>,
    mut job: ResMut<LogJob>,
    mut dialogs: ResMut<Dialogs>,
) {
    let Some(world) = world else {
        requests.clear();
        return;
    };
    for request in requests.read() {
        match request {
            FileRequest::ShowWriteLog => {
                let folder = file_folder(&world.0);
                dialogs.show(StudyDialog::write_log(folder, &log_name(&world.0)));
            }
            FileRequest::WriteLog(path) if job.0.is_none() => {
                job.0 = Some(start(&world.0, &choice, path, &waker));
            }
            _ => {}
        }
    }
}

/// `pointer-on-head.log.csv` for `pointer-on-head.design.ron`.
fn log_name(world: &trackwright_project::World) -> String {
    let name = crate::document::file_names::default_file_name(&world.document);
    let stem = name.strip_suffix(crate::document::file_names::DESIGN_EXTENSION).unwrap_or(&name);
    format!("{stem}.log.csv")
}

fn start(
    world: &trackwright_project::World,
    choice: &TrialChoice,
    file: &Path,
    waker: &Waker,
) -> Writing {
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    let mode = choice.mode(&scenario);
    let trials = trial_count(&scenario, &mode).unwrap_or(1).max(1);
    let (output, files) = (file.to_owned(), Files::except_design(world));
    let job = Job::start("log", waker, move |task| {
        let mut done = 0;
        let mut visit = |_: &Trial| {
            done += 1;
            // Writing stops by the token itself, and reports it.
            let _ = task.step(done, trials);
        };
        let output = files.output(&output)?;
        let outcome =
            trackwright_project::write_log(&output, &scenario, &mode, &task.cancel, &mut visit)?;
        Ok(outcome.room_field.trials)
    });
    Writing { job, file: file.to_owned() }
}

fn cancel(mut requests: MessageReader<StudyRequest>, job: Res<LogJob>) {
    if requests.read().any(|r| *r == StudyRequest::CancelLog)
        && let Some(writing) = &job.0
    {
        writing.job.cancel();
    }
}

fn receive(mut job: ResMut<LogJob>, mut notice: ResMut<Notice>, mut dialogs: ResMut<Dialogs>) {
    let answer = job.0.as_ref().and_then(|writing| writing.job.answer());
    let Some((answer, writing)) = answer.and_then(|answer| Some((answer, job.0.take()?))) else {
        return;
    };
    const NOT_WRITTEN: &str = "The log cannot be written";
    match answer {
        Ok(Ok(trials)) => {
            let rows = counted(trials, "trial", "trials");
            *notice = Notice::Done(format!("Wrote {rows} to {}", writing.file.display()));
        }
        Ok(Err(LogError::Study(StudyError::Cancelled))) => {
            *notice = Notice::Done("The log was not written: cancelled".to_owned());
        }
        Ok(Err(error)) => dialogs.show(ErrorDialog::new(NOT_WRITTEN, &error)),
        Err(lost) => dialogs.show(ErrorDialog::new(NOT_WRITTEN, &lost)),
    }
}
