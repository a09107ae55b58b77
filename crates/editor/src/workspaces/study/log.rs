//! Writes the log of the study that is shown, in the background.

use crate::document::apply::{Notice, file_folder};
use crate::document::requests::{FileRequest, OpenWorld};
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::{Dialog, Dialogs};
use crate::widgets::basic::counted;
use crate::workspaces::study::desk::{StudyDesk, StudyRequest};
use bevy::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, channel};
use trackwright_project::{Files, LogError};
use trackwright_simulation::{CancelToken, StudyError, trial_count};

/// Steps of the bar that shows how far the log is; each costs a frame.
const STEPS: usize = 100;

/// The log that is being written, if any.
#[derive(Resource, Default)]
pub struct LogJob {
    writing: Option<Writing>,
}

struct Writing {
    cancel: CancelToken,
    told: Mutex<Receiver<Told>>,
    file: PathBuf,
    part: f64,
}

/// What the writing thread tells.
enum Told {
    Part(f64),
    Written { trials: usize },
    Failed(LogError),
}

impl LogJob {
    /// How far it is, from 0 to 1; `None` where none is written.
    pub fn part(&self) -> Option<f64> {
        self.writing.as_ref().map(|writing| writing.part)
    }
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<LogJob>()
        .init_resource::<StudyDesk>()
        .init_resource::<Dialogs>()
        .init_resource::<Notice>()
        .init_resource::<Waker>()
        .add_message::<FileRequest>()
        .add_message::<StudyRequest>()
        .add_systems(
            Update,
            (
                answer.run_if(on_message::<FileRequest>),
                cancel.run_if(on_message::<StudyRequest>),
                hear.run_if(is_writing),
            )
                .chain()
                .in_set(EditorSystems::Solve),
        );
}

fn is_writing(job: Res<LogJob>) -> bool {
    job.writing.is_some()
}

fn answer(
    mut requests: MessageReader<FileRequest>,
    world: Option<Res<OpenWorld>>,
    desk: Res<StudyDesk>,
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
                dialogs.show(Dialog::write_log(folder, &log_name(&world.0)));
            }
            FileRequest::WriteLog(path) if job.writing.is_none() => {
                match start(&world.0, &desk, path, &waker) {
                    Ok(writing) => job.writing = Some(writing),
                    Err(error) => {
                        dialogs.show(Dialog::error("The log cannot be written", &error));
                    }
                }
            }
            _ => {}
        }
    }
}

/// `pointer-on-head.log.csv` for `pointer-on-head.design.ron`.
fn log_name(world: &trackwright_project::World) -> String {
    let name = crate::document::apply::default_file_name(world.document.origin());
    let stem = name.strip_suffix(crate::document::apply::DESIGN_EXTENSION).unwrap_or(&name);
    format!("{stem}.log.csv")
}

fn start(
    world: &trackwright_project::World,
    desk: &StudyDesk,
    path: &Path,
    waker: &Waker,
) -> std::io::Result<Writing> {
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    let mode = desk.mode(&scenario);
    let trials = trial_count(&scenario, &mode).unwrap_or(1).max(1);
    let (sender, told) = channel();
    let cancel = CancelToken::default();
    let writing = Writing {
        cancel: cancel.clone(),
        told: Mutex::new(told),
        file: path.to_owned(),
        part: 0.0,
    };
    let (file, waker) = (path.to_owned(), waker.clone());
    let files = Files::beside(world);
    std::thread::Builder::new().name("log".into()).spawn(move || {
        let tell = |what| {
            // The window may have been closed.
            if sender.send(what).is_ok() {
                waker.wake();
            }
        };
        let each = trials.div_ceil(STEPS);
        let mut done = 0_usize;
        let mut visit = |_: &trackwright_simulation::Trial| {
            done += 1;
            if done.is_multiple_of(each) {
                tell(Told::Part(done as f64 / trials as f64));
            }
        };
        let written = files.output(&file).map_err(LogError::from).and_then(|output| {
            trackwright_project::write_log(&output, &scenario, &mode, &cancel, &mut visit)
        });
        tell(match written {
            Ok(outcome) => Told::Written { trials: outcome.figures.trials },
            Err(error) => Told::Failed(error),
        });
    })?;
    Ok(writing)
}

fn cancel(mut requests: MessageReader<StudyRequest>, job: Res<LogJob>) {
    if requests.read().any(|r| *r == StudyRequest::CancelLog)
        && let Some(writing) = &job.writing
    {
        writing.cancel.cancel();
    }
}

fn hear(mut job: ResMut<LogJob>, mut notice: ResMut<Notice>, mut dialogs: ResMut<Dialogs>) {
    let Some(writing) = &mut job.bypass_change_detection().writing else {
        return;
    };
    let told: Vec<Told> = match writing.told.get_mut() {
        Ok(told) => told.try_iter().collect(),
        Err(_) => return,
    };
    for told in told {
        match told {
            Told::Part(part) => {
                if let Some(writing) = &mut job.writing {
                    writing.part = part;
                }
            }
            Told::Written { trials } => {
                let Some(writing) = job.writing.take() else {
                    return;
                };
                let rows = counted(trials, "trial", "trials");
                let file = writing.file.display();
                *notice = Notice::Done(format!("Wrote {rows} to {file}"));
            }
            Told::Failed(LogError::Study(StudyError::Cancelled)) => {
                job.writing = None;
                *notice = Notice::Done("The log was not written: cancelled".to_owned());
            }
            Told::Failed(error) => {
                job.writing = None;
                dialogs.show(Dialog::error("The log cannot be written", &error));
            }
        }
    }
}
