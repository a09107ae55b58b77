//! Keeps the list of rooms while the workspace is shown: read anew when what it depends on changes.

use crate::document::requests::OpenWorld;
use crate::document::state::WorldGeneration;
use crate::runner::jobs::Job;
use crate::runner::wake::Waker;
use crate::workspaces::field::state::FieldState;
use bevy::prelude::*;
use std::path::PathBuf;
use trackwright_design::Origin;
use trackwright_project::{RoomSource, builtin_rooms, list_rooms, own_room, rooms_of_folder};

/// What the list was read for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ListKey {
    generation: u64,
    /// The design's reference to its room.
    reference: String,
    origin: Origin,
    recent: Vec<RoomSource>,
}

pub(crate) fn keep_list(
    mut state: ResMut<FieldState>,
    world: Option<Res<OpenWorld>>,
    generation: Res<WorldGeneration>,
    waker: Res<Waker>,
    mut listed: Local<Option<ListKey>>,
) {
    let Some(world) = world else { return };
    let document = &world.0.document;
    let design = document.design();
    // Looked at in every frame, so nothing is copied before something changed.
    let is_listed = listed.as_ref().is_some_and(|key| {
        key.generation == generation.0
            && key.reference == design.environment
            && key.origin == *document.origin()
            && key.recent == state.recent
    });
    if is_listed {
        return;
    }
    *listed = Some(ListKey {
        generation: generation.0,
        reference: design.environment.clone(),
        origin: document.origin().clone(),
        recent: state.recent.clone(),
    });
    let own = own_room(&world.0).ok();
    let places = places(&world.0, own.as_ref(), &state.recent);
    state.own = own;
    state.counts.listings += 1;
    state.listing = Some(Job::start("rooms", &waker, move |task| {
        // Folders are read here too: some are slow.
        let places = places.into_iter().flat_map(Places::all).collect();
        list_rooms(places, task)
    }));
}

/// Where rooms are looked for.
enum Places {
    Room(RoomSource),
    Folder(PathBuf),
}

impl Places {
    fn all(self) -> Vec<RoomSource> {
        match self {
            Self::Room(place) => vec![place],
            Self::Folder(folder) => rooms_of_folder(&folder),
        }
    }
}

/// The design's own room, those used lately, those of the folders of design and room, the built-in
/// ones.
fn places(
    world: &trackwright_project::World,
    own: Option<&RoomSource>,
    recent: &[RoomSource],
) -> Vec<Places> {
    let mut folders = Vec::new();
    if let Origin::File(file) = world.document.origin() {
        folders.extend(file.parent().map(|folder| match folder.as_os_str().is_empty() {
            true => PathBuf::from("."),
            false => folder.to_path_buf(),
        }));
    }
    if let Some(RoomSource::File(file)) = own {
        folders.extend(file.parent().map(PathBuf::from));
    }
    let own = own.cloned().map(Places::Room);
    own.into_iter()
        .chain(recent.iter().cloned().map(Places::Room))
        .chain(folders.into_iter().map(Places::Folder))
        .chain(builtin_rooms().map(Places::Room))
        .collect()
}
