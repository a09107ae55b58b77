//! Keeps the baseline with the design: in a file beside the design's, from where it is pinned again when
//! the design is opened.
//!
//! Only a session that keeps its work on the disk does so: pictures and videos leave nothing there.

use crate::document::autosave::RecoveryFolder;
use crate::document::requests::OpenWorld;
use crate::document::state::WorldGeneration;
use crate::schedule::EditorSystems;
use crate::shell::dialogs::{Dialogs, ErrorDialog};
use crate::workspaces::decide::state::{DecideState, Pinned};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use std::path::PathBuf;
use std::sync::Arc;
use trackwright_design::Origin;
use trackwright_geometry::placeholder::placeholder;
use trackwright_project::KeptBaseline;

/// Which baseline is beside which design's file; `None` before anything was opened or kept.
#[derive(Resource, Default)]
struct Kept(Option<(PathBuf, Option<u64>)>);

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Kept>().add_systems(
        Update,
        (
            read.run_if(resource_changed::<WorldGeneration>),
            // What a thread read is pinned without a mark of change.
            keep,
        )
            .chain()
            .run_if(resource_exists::<RecoveryFolder>)
            .run_if(resource_exists::<OpenWorld>.and_then(resource_exists::<WorldGeneration>))
            .in_set(EditorSystems::Solve),
    );
}

/// A design was opened: what it was held against is pinned again. One without a baseline of its own is
/// held against what is pinned.
fn read(
    mut state: ResMut<DecideState>,
    mut kept: ResMut<Kept>,
    mut dialogs: ResMut<Dialogs>,
    world: Res<OpenWorld>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let Origin::File(file) = world.0.document.origin() else {
        kept.0 = None;
        return;
    };
    match trackwright_project::read_baseline(file) {
        Ok(Some(baseline)) => {
            state.serial += 1;
            state.pinning = None;
            state.pinned = Some(pinned(baseline, state.serial));
            redraw.write(RequestRedraw);
        }
        Ok(None) => {}
        Err(error) => dialogs.show(ErrorDialog::new("The baseline cannot be read", &error)),
    }
    // What is pinned now is not written beside a design that was only opened.
    kept.0 = Some((file.clone(), state.pinned.as_ref().map(|pinned| pinned.serial)));
}

fn pinned(baseline: KeptBaseline, serial: u64) -> Pinned {
    let KeptBaseline { design, source, tool_mesh } = baseline;
    let body = &design.tool.body.rigid;
    let sensors: Vec<_> = body.sensors.iter().map(|s| s.position_in_body).collect();
    let tip = body.judged_tip_in_body();
    let tool_mesh = tool_mesh.unwrap_or_else(|| Arc::new(placeholder(&tip, &sensors)));
    Pinned {
        is_gone: source.as_ref().is_some_and(|file| !file.exists()),
        tool_mesh: Some(tool_mesh),
        design: Arc::new(design),
        file: source,
        serial,
    }
}

/// Another baseline was pinned or unpinned, or the design was saved elsewhere.
fn keep(
    state: Res<DecideState>,
    mut kept: ResMut<Kept>,
    mut dialogs: ResMut<Dialogs>,
    world: Res<OpenWorld>,
) {
    let Origin::File(file) = world.0.document.origin() else { return };
    let serial = state.pinned.as_ref().map(|pinned| pinned.serial);
    let before = kept.0.as_ref().filter(|(kept_file, _)| kept_file == file);
    if before.is_some_and(|(_, kept_serial)| *kept_serial == serial) {
        return;
    }
    let done = match &state.pinned {
        Some(pinned) => {
            trackwright_project::write_baseline(file, &pinned.design, pinned.file.as_deref())
        }
        None if before.is_some() => trackwright_project::remove_baseline(file),
        // A design that was just saved for the first time.
        None => Ok(()),
    };
    kept.0 = Some((file.clone(), serial));
    if let Err(error) = done {
        dialogs.show(ErrorDialog::new("The baseline cannot be kept", &error));
    }
}
