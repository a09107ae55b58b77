//! The report of the open design, made by this program in a process of its own, since pictures are
//! painted there; and shown in the browser.

use crate::document::dialog::DesignDialog;
use crate::document::file_names::{DESIGN_EXTENSION, default_file_name};
use crate::document::open_outside::OpenOutside;
use crate::document::own_program::{FileTask, OwnProgramWriter};
use crate::document::requests::{FileRequest, OpenWorld};
use crate::document::state::Notice;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::Dialogs;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::path::{Path, PathBuf};
use trackwright_design::Origin;
use trackwright_project::file_name;

/// Writes a report on [`FileRequest::WriteReport`], with
/// [`OwnProgramPlugin`](crate::document::own_program::OwnProgramPlugin).
pub struct ReportPlugin;

/// The report that was written last.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct LastReport(pub Option<PathBuf>);

impl Plugin for ReportPlugin {
    fn build(&self, app: &mut App) {
        let answer = answer.run_if(on_message::<FileRequest>);
        app.init_resource::<LastReport>()
            .add_message::<OpenOutside>()
            .add_systems(Update, answer.in_set(EditorSystems::Solve));
    }
}

fn answer(
    mut requests: MessageReader<FileRequest>,
    world: Option<Res<OpenWorld>>,
    (mut writer, last): (OwnProgramWriter, Res<LastReport>),
    mut dialogs: ResMut<Dialogs>,
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
            FileRequest::WriteReport(file) => {
                let task = FileTask {
                    file: file.clone(),
                    written: format!("Wrote {}; File › Open report shows it", file_name(file)),
                    failed: "The report cannot be written",
                    follow: |commands, file| commands.insert_resource(LastReport(Some(file))),
                };
                writer.write(&world.0, task, |_, copy| Ok(vec!["report".into(), copy.into()]));
            }
            FileRequest::OpenReport => match &last.0 {
                Some(report) => {
                    outside.write(OpenOutside(report.clone()));
                }
                None => *writer.notice = Notice::Refused(NO_REPORT.to_owned()),
            },
            _ => continue,
        }
        redraw.write(RequestRedraw);
    }
}

const NO_REPORT: &str = "no report was written since the program was started: File › Report…";

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
