//! Files for 3D Slicer, ParaView and other programs, written by this program in a process of its own.

use crate::document::dialog::DesignDialog;
use crate::document::own_program::{OwnProgram, OwnProgramError, write_by};
use crate::document::report::folder_and_stem;
use crate::document::requests::{Export, FileRequest, OpenWorld};
use crate::document::state::Notice;
use crate::runner::jobs::Job;
use crate::runner::wake::Waker;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use trackwright_project::{RoomSource, StoreError, World as StoreWorld};
use trackwright_task::Task;

/// Writes such a file on [`FileRequest::Export`].
pub struct ExportsPlugin;

/// A file that is being written.
#[derive(Resource, Default)]
pub struct ExportJob(Option<(PathBuf, Job<Result<String, OwnProgramError>>)>);

impl ExportJob {
    pub fn is_writing(&self) -> bool {
        self.0.is_some()
    }
}

fn is_writing(job: Res<ExportJob>) -> bool {
    job.is_writing()
}

impl Plugin for ExportsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ExportJob>().init_resource::<OwnProgram>().add_systems(
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
    (mut writing, program): (ResMut<ExportJob>, Res<OwnProgram>),
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
            FileRequest::ShowExport(export) => {
                let (folder, stem) = folder_and_stem(&world.0);
                dialogs.show(DesignDialog::export(folder, &stem, *export));
            }
            FileRequest::Export(..) if writing.is_writing() => {
                *notice = Notice::Refused("another file is being exported".to_owned());
            }
            FileRequest::Export(export, file) => {
                let (export, to) = (*export, file.clone());
                let (open, program) = (world.0.clone(), program.0.clone());
                let job = Job::start("export", &waker, move |_: &Task| {
                    write_by(&program, open, &to, |world, copy| arguments(export, world, copy))
                });
                writing.0 = Some((file.clone(), job));
                *notice = Notice::Done(format!("Writing {}…", file.display()));
            }
            _ => continue,
        }
        redraw.write(RequestRedraw);
    }
}

/// The command that exports a copy of the design, or the copy's room.
fn arguments(export: Export, world: &StoreWorld, copy: &Path) -> Result<Vec<OsString>, StoreError> {
    let of: OsString = match (export, trackwright_project::own_room(world)?) {
        // A copy on the disk is in a room on the disk.
        (Export::Field, RoomSource::File(room)) => room.into(),
        (Export::Field, RoomSource::BuiltIn(room)) => room.into(),
        (Export::Tips | Export::Scene, _) => copy.into(),
    };
    Ok(vec!["export".into(), export.name().into(), of])
}

fn receive(
    mut writing: ResMut<ExportJob>,
    mut dialogs: ResMut<Dialogs>,
    mut notice: ResMut<Notice>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let job = writing.bypass_change_detection().0.as_ref();
    let Some(answer) = job.and_then(|(_, job)| job.answer()) else {
        return;
    };
    let Some((file, _)) = writing.0.take() else { return };
    redraw.write(RequestRedraw);
    let why = match answer {
        Ok(Ok(_)) => {
            *notice = Notice::Done(format!("Exported {}", file.display()));
            return;
        }
        Ok(Err(error)) => error.to_string(),
        Err(lost) => lost.to_string(),
    };
    notice.set_if_neq(Notice::Nothing);
    dialogs.show(ErrorDialog { title: "The file cannot be exported".to_owned(), text: why });
}
