//! The report of the open design, made by this program in a process of its own, since pictures are
//! painted there; and shown in the browser.

use crate::document::dialog::DesignDialog;
use crate::document::file_names::{DESIGN_EXTENSION, default_file_name};
use crate::document::open_outside::OpenOutside;
use crate::document::own_program::{OwnProgram, OwnProgramError, write_by};
use crate::document::requests::{FileRequest, OpenWorld};
use crate::document::state::Notice;
use crate::runner::jobs::Job;
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::path::{Path, PathBuf};
use trackwright_design::Origin;
use trackwright_task::Task;

/// Writes a report on [`FileRequest::WriteReport`].
pub struct ReportPlugin;

/// A report that is being made, and its file.
#[derive(Resource, Default)]
pub struct ReportJob(Option<(PathBuf, Job<Result<String, OwnProgramError>>)>);

/// The report that was written last.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct LastReport(pub Option<PathBuf>);

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
        app.init_resource::<ReportJob>()
            .init_resource::<LastReport>()
            .init_resource::<OwnProgram>()
            .add_message::<OpenOutside>()
            .add_systems(
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
    (mut writing, program, last): (ResMut<ReportJob>, Res<OwnProgram>, Res<LastReport>),
    mut dialogs: ResMut<Dialogs>,
    mut notice: ResMut<Notice>,
    waker: Res<Waker>,
    (mut outside, mut redraw): (MessageWriter<OpenOutside>, MessageWriter<RequestRedraw>),
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
                let (to, open, program) = (file.clone(), world.0.clone(), program.0.clone());
                let job = Job::start("report", &waker, move |_: &Task| {
                    write_by(&program, open, &to, |_, copy| Ok(vec!["report".into(), copy.into()]))
                });
                writing.0 = Some((file.clone(), job));
                *notice = Notice::Done("Writing the report…".to_owned());
            }
            FileRequest::OpenReport => match &last.0 {
                Some(report) => {
                    outside.write(OpenOutside(report.clone()));
                }
                None => *notice = Notice::Refused(NO_REPORT.to_owned()),
            },
            _ => continue,
        }
        redraw.write(RequestRedraw);
    }
}

const NO_REPORT: &str = "no report was written since the program was started: File › Report…";

fn receive(
    (mut writing, mut last): (ResMut<ReportJob>, ResMut<LastReport>),
    mut dialogs: ResMut<Dialogs>,
    mut notice: ResMut<Notice>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let job = writing.bypass_change_detection().0.as_ref();
    let Some(answer) = job.and_then(|(_, job)| job.answer()) else {
        return;
    };
    let file = writing.0.take().map(|(file, _)| file);
    redraw.write(RequestRedraw);
    let why = match answer {
        Ok(Ok(report)) => {
            *notice = Notice::Done(format!("Wrote {report}; File › Open report shows it"));
            last.0 = file;
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
    let (folder, stem) = folder_and_stem(world);
    (folder, format!("{stem}.html"))
}

/// The design's folder, and its file's name without the ending.
pub(crate) fn folder_and_stem(world: &trackwright_project::World) -> (PathBuf, String) {
    let origin = world.document.origin();
    let folder = match origin {
        Origin::File(file) => file.parent().filter(|f| !f.as_os_str().is_empty()),
        _ => None,
    };
    let name = default_file_name(&world.document);
    let stem = name.strip_suffix(DESIGN_EXTENSION).unwrap_or(&name);
    (folder.map_or_else(|| PathBuf::from("."), Path::to_path_buf), stem.to_owned())
}
