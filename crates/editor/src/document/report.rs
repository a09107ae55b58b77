//! The report of the open design, made by this program in a process of its own: pictures are painted
//! there, and the window stays as it is.
//!
//! What is reported is the design as it is, saved or not: a copy of it in a folder that lives as long as
//! the work.

use crate::document::dialog::DesignDialog;
use crate::document::file_names::{DESIGN_EXTENSION, default_file_name};
use crate::document::requests::{FileRequest, OpenWorld};
use crate::document::state::Notice;
use crate::runner::jobs::Job;
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use trackwright_design::Origin;
use trackwright_task::Task;

/// Writes a report on [`FileRequest::WriteReport`].
pub struct ReportPlugin;

/// A report that is being made.
#[derive(Resource, Default)]
pub struct ReportJob(Option<Job<Result<String, ReportError>>>);

/// The program that makes reports: this one.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct ReportProgram(pub PathBuf);

impl Default for ReportProgram {
    fn default() -> Self {
        // Without a path, starting it reports the error.
        Self(std::env::current_exe().unwrap_or_default())
    }
}

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    #[error(transparent)]
    Copy(#[from] trackwright_project::StoreError),
    #[error("the report cannot be begun: {0}")]
    Start(std::io::Error),
    /// In the words of the command line.
    #[error("{0}")]
    Program(String),
}

impl ReportJob {
    pub fn is_writing(&self) -> bool {
        self.0.is_some()
    }
}

fn is_writing(job: Res<ReportJob>) -> bool {
    job.is_writing()
}

impl Plugin for ReportPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ReportJob>().init_resource::<ReportProgram>().add_systems(
            Update,
            (
                answer.run_if(on_message::<FileRequest>).in_set(EditorSystems::Solve),
                receive.run_if(is_writing).in_set(EditorSystems::Solve),
            ),
        );
    }
}

fn answer(
    mut requests: MessageReader<FileRequest>,
    world: Option<Res<OpenWorld>>,
    (mut writing, program): (ResMut<ReportJob>, Res<ReportProgram>),
    mut dialogs: ResMut<Dialogs>,
    mut notice: ResMut<Notice>,
    waker: Res<Waker>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let Some(world) = world else {
        requests.clear();
        return;
    };
    for request in requests.read() {
        match request {
            FileRequest::ShowWriteReport => {
                let (folder, name) = default_folder_and_name(&world.0);
                dialogs.show(DesignDialog::write_report(folder, &name));
            }
            FileRequest::WriteReport(_) if writing.is_writing() => {
                *notice = Notice::Refused("another report is being written".to_owned());
            }
            FileRequest::WriteReport(file) => {
                let (file, open) = (file.clone(), world.0.clone());
                let program = program.0.clone();
                let work = move |_: &Task| write(open, &file, &program);
                writing.0 = Some(Job::start("report", &waker, work));
                *notice = Notice::Done("Writing the report…".to_owned());
            }
            _ => continue,
        }
        redraw.write(RequestRedraw);
    }
}

fn receive(
    mut writing: ResMut<ReportJob>,
    mut dialogs: ResMut<Dialogs>,
    mut notice: ResMut<Notice>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let answer = (writing.bypass_change_detection().0.as_ref()).and_then(Job::answer);
    let Some(answer) = answer else { return };
    writing.0 = None;
    redraw.write(RequestRedraw);
    let why = match answer {
        Ok(Ok(report)) => {
            *notice = Notice::Done(format!("Wrote {report}"));
            return;
        }
        Ok(Err(error)) => error.to_string(),
        Err(lost) => lost.to_string(),
    };
    notice.set_if_neq(Notice::Nothing);
    dialogs.show(ErrorDialog { title: "The report cannot be written".to_owned(), text: why });
}

/// Beside the design, under its name.
fn default_folder_and_name(world: &trackwright_project::World) -> (PathBuf, String) {
    let origin = world.document.origin();
    let folder = match origin {
        Origin::File(file) => file.parent().filter(|f| !f.as_os_str().is_empty()),
        _ => None,
    };
    let name = default_file_name(origin);
    let stem = name.strip_suffix(DESIGN_EXTENSION).unwrap_or(&name);
    (folder.map_or_else(|| PathBuf::from("."), Path::to_path_buf), format!("{stem}.html"))
}

/// The command line's output about the page.
fn write(
    mut world: trackwright_project::World,
    file: &Path,
    program: &Path,
) -> Result<String, ReportError> {
    let folder = tempfile::tempdir().map_err(ReportError::Start)?;
    let copy = folder.path().join(default_file_name(world.document.origin()));
    trackwright_project::save_as(&mut world, &copy)?;
    let output = Command::new(program)
        .arg("report")
        .arg(&copy)
        .arg("--output")
        .arg(file)
        .stdin(Stdio::null())
        .output()
        .map_err(ReportError::Start)?;
    let [result, complaint] = [output.stdout, output.stderr]
        .map(|bytes| String::from_utf8_lossy(&bytes).trim().to_owned());
    match output.status.success() {
        true => Ok(result),
        false => Err(ReportError::Program(complaint.trim_start_matches("error: ").to_owned())),
    }
}
