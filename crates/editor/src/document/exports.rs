//! Files for 3D Slicer, ParaView and other programs, written by this program in a process of its own.

use crate::document::dialog::DesignDialog;
use crate::document::own_program::{Arguments, FileTask, OwnProgramWriter};
use crate::document::report::folder_and_stem;
use crate::document::requests::{Export, FileRequest, OpenWorld};
use crate::schedule::EditorSystems;
use crate::shell::dialogs::Dialogs;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::ffi::OsString;
use std::path::Path;
use trackwright_project::{RoomSource, World as StoreWorld, file_name};

/// Writes such a file on [`FileRequest::Export`], with
/// [`OwnProgramPlugin`](crate::document::own_program::OwnProgramPlugin).
pub struct ExportsPlugin;

impl Plugin for ExportsPlugin {
    fn build(&self, app: &mut App) {
        let answer = answer.run_if(on_message::<FileRequest>);
        app.add_systems(Update, answer.in_set(EditorSystems::Solve));
    }
}

fn answer(
    mut requests: MessageReader<FileRequest>,
    world: Option<Res<OpenWorld>>,
    mut writer: OwnProgramWriter,
    mut dialogs: ResMut<Dialogs>,
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
            FileRequest::Export(export, file) => {
                let task = FileTask {
                    file: file.clone(),
                    written: format!("Exported {}", file_name(file)),
                    failed: "The file cannot be exported",
                    follow: |_, _| {},
                };
                let export = *export;
                writer.write(&world.0, task, move |world, copy| arguments(export, world, copy));
            }
            _ => continue,
        }
        redraw.write(RequestRedraw);
    }
}

/// The command that exports a copy of the design, or the copy's room.
fn arguments(export: Export, world: &StoreWorld, copy: &Path) -> Arguments {
    let of: OsString = match (export, trackwright_project::own_room(world)?) {
        // A copy on the disk is in a room on the disk.
        (Export::Field, RoomSource::File(room)) => room.into(),
        (Export::Field, RoomSource::BuiltIn(room)) => room.into(),
        (Export::Tips | Export::Scene, _) => copy.into(),
    };
    Ok(vec!["export".into(), export.name().into(), of])
}
