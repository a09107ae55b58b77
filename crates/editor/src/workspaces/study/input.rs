//! Input data: a table of poses that is dropped onto the window or chosen in a dialog.

use crate::document::drops::is_table;
use crate::document::file_names::file_folder;
use crate::document::requests::{FileRequest, OpenWorld};
use crate::document::state::Notice;
use crate::document::trials::TrialChoice;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use crate::widgets::basic::counted;
use crate::workspaces::study::dialog::StudyDialog;
use crate::workspaces::study::state::is_study_shown;
use bevy::prelude::*;
use bevy::window::{FileDragAndDrop, RequestRedraw};
use trackwright_calibration::doubts::of_input;
use trackwright_project::{Files, file_name, resolve};

pub(crate) fn plugin(app: &mut App) {
    app.add_message::<FileDragAndDrop>().add_systems(
        Update,
        (
            read_dropped
                .run_if(on_message::<FileDragAndDrop>.and_then(is_study_shown))
                .in_set(EditorSystems::Input),
            answer.run_if(on_message::<FileRequest>).in_set(EditorSystems::Edit),
        ),
    );
}

fn read_dropped(
    mut dropped: MessageReader<FileDragAndDrop>,
    mut files: MessageWriter<FileRequest>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    for event in dropped.read() {
        if let FileDragAndDrop::DroppedFile { path_buf, .. } = event
            && is_table(path_buf)
        {
            files.write(FileRequest::ReadInput(path_buf.clone()));
            redraw.write(RequestRedraw);
        }
    }
}

fn answer(
    mut requests: MessageReader<FileRequest>,
    world: Option<Res<OpenWorld>>,
    mut choice: ResMut<TrialChoice>,
    mut dialogs: ResMut<Dialogs>,
    mut notice: ResMut<Notice>,
) {
    let Some(world) = world else {
        requests.clear();
        return;
    };
    for request in requests.read() {
        match request {
            FileRequest::ShowReadInput => {
                dialogs.show(StudyDialog::read_input(file_folder(&world.0)));
            }
            FileRequest::ReadInput(path) => {
                let world = &world.0;
                let scenario = resolve(world.document.design(), &world.environment);
                let mut suspected = String::new();
                let read = Files::default().read_input(path, scenario.crf.is_some());
                let taken = read.and_then(|found| {
                    let found = found.and(|trials| of_input(trials, &scenario));
                    found.take(false, |_, suspicion| suspected += &format!("; {suspicion}"))
                });
                match taken {
                    Ok(trials) => {
                        let name = file_name(path);
                        let rows = counted(trials.len(), "pose", "poses");
                        *notice = Notice::Done(format!("Read {rows} from {name}{suspected}"));
                        choice.take_input(name, trials.into());
                    }
                    Err(error) => {
                        dialogs.show(ErrorDialog::new("The input data cannot be read", &error));
                    }
                }
            }
            _ => {}
        }
    }
}
