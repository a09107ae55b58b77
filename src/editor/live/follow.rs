//! Looks at the session once a frame, and keeps it in the design's room.

use super::desk::{LiveDesk, LivePoses, RoomKey};
use crate::editor::document::WorldGeneration;
use crate::editor::state::{ActiveDrag, OpenWorld, Workspace};
use crate::store;
use bevy::prelude::*;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// What is shown follows the session; while nothing is shown only what it says once a change comes
/// is looked at.
pub(super) fn look(
    mut desk: ResMut<LiveDesk>,
    mut poses: ResMut<LivePoses>,
    workspace: Res<Workspace>,
) {
    let is_shown = *workspace == Workspace::Live;
    desk.is_shown.store(is_shown, Ordering::Relaxed);
    if !is_shown {
        return;
    }
    let Some(session) = &desk.session else { return };
    let seen = session.state();
    if poses.bypass_change_detection().take(Some(&seen)) {
        poses.set_changed();
    }
    // Written every time: what is shown of it are counts, which change with every sample.
    desk.seen = Some(seen);
    if let Some(collected) = desk.collector.newer_than(desk.collected.as_ref()) {
        desk.collected = collected;
    }
}

/// Another design, room or choice of tools is compensated by once no drag is under way.
pub(super) fn keep_room(
    mut desk: ResMut<LiveDesk>,
    world: Option<Res<OpenWorld>>,
    generation: Res<WorldGeneration>,
    drag: Res<ActiveDrag>,
) {
    let Some(world) = world else { return };
    if drag.0 {
        return;
    }
    let key = RoomKey {
        generation: generation.0,
        revision: world.0.document.revision(),
        environment: Arc::clone(&world.0.environment),
        assigned: desk.assigned.clone(),
    };
    if desk.in_room.as_ref() == Some(&key) {
        return;
    }
    let scenario = store::resolve(world.0.document.design(), &world.0.environment);
    let room = desk.room(&scenario);
    if let Some(session) = &desk.session {
        session.set_room(Some(room));
    }
    desk.in_room = Some(key);
}
