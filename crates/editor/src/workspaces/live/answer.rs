//! Carries out the requests of the workspace's panels.

use crate::document::file_names::file_folder;
use crate::document::requests::OpenWorld;
use crate::document::shown::LivePoses;
use crate::document::state::Notice;
use crate::runner::wake::Waker;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use crate::workspaces::live::dialog::RecordDialog;
use crate::workspaces::live::requests::LiveRequest;
use crate::workspaces::live::state::{LiveState, take_poses};
use bevy::prelude::*;
use std::path::Path;
use trackwright_calibration::coverage::CoveragePlan;
use trackwright_openigtlink::client::server_address;

pub(crate) fn answer(
    mut requests: MessageReader<LiveRequest>,
    world: Option<Res<OpenWorld>>,
    waker: Res<Waker>,
    mut state: ResMut<LiveState>,
    mut poses: ResMut<LivePoses>,
    mut dialogs: ResMut<Dialogs>,
    mut notice: ResMut<Notice>,
) {
    let Some(world) = world else {
        requests.clear();
        return;
    };
    for request in requests.read() {
        match request {
            LiveRequest::SetServer(server) => server.trim().clone_into(&mut state.server),
            LiveRequest::SetPort(port) => state.port = *port,
            LiveRequest::Connect => connect(&world.0, &waker, &mut state),
            LiveRequest::Disconnect => {
                state.disconnect();
                take_poses(&mut poses, None);
            }
            LiveRequest::Assign(tool, Some(role)) => {
                state.assigned.insert(tool.clone(), *role);
            }
            LiveRequest::Assign(tool, None) => {
                state.assigned.remove(tool);
            }
            LiveRequest::ShowRecord => {
                let folder = file_folder(&world.0);
                let name = free_name(&folder);
                dialogs.show(RecordDialog::new(folder, &name));
            }
            LiveRequest::Record(file) => match record(&world.0, &mut state, file) {
                Ok(()) => {
                    *notice = Notice::Done(format!("Recording in {}", file.display()));
                }
                Err(problem) => {
                    dialogs.show(ErrorDialog {
                        title: "Nothing can be recorded".to_owned(),
                        text: problem,
                    });
                }
            },
            LiveRequest::StopRecording => {
                if let Some(session) = &state.session {
                    // Without a file there is none that cannot be begun.
                    let _ = session.record(None);
                }
                state.collector.pause();
            }
            LiveRequest::StartOver => state.collector.start_over(),
        }
    }
}

fn connect(world: &trackwright_project::World, waker: &Waker, state: &mut LiveState) {
    if state.is_connected() {
        return;
    }
    if let Err(expected) = server_address(&state.server) {
        state.problem = Some(format!("{} is no server's address: {expected}", state.server));
        return;
    }
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    if let Err(error) = state.connect(&scenario, waker) {
        state.problem = Some(error.to_string());
    }
}

fn record(
    world: &trackwright_project::World,
    state: &mut LiveState,
    file: &Path,
) -> Result<(), String> {
    let Some(session) = &state.session else {
        return Err("No tracker is connected: connect to its server first".to_owned());
    };
    session.record(Some(file)).map_err(|error| error.to_string())?;
    state.collect(CoveragePlan::of(&world.environment));
    Ok(())
}

/// `recording-1.csv`, or with the first number that no file has: a recording is never written over.
fn free_name(folder: &Path) -> String {
    (1_u32..)
        .map(|number| format!("recording-{number}.csv"))
        .find(|name| !folder.join(name).exists())
        .unwrap_or_default()
}
