//! Looks at the session once a frame, and keeps it in the design's room.

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::shown::{LivePoses, ShownDesign};
use crate::document::state::{Notice, WorldGeneration};
use crate::shell::window::Workspace;
use crate::viewport::troubles::BodyTroubles;
use crate::workspaces::live::state::{LiveState, RoomKey, take_poses};
use bevy::prelude::*;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// What is shown follows the session; while nothing is shown nothing of it is looked at but whether
/// its recording failed, which is reported in every workspace.
pub(crate) fn follow_session(
    mut state: ResMut<LiveState>,
    mut poses: ResMut<LivePoses>,
    mut notice: ResMut<Notice>,
    workspace: Res<Workspace>,
) {
    if let Some(why) = state.collector.take_failure() {
        *notice = Notice::Refused(format!("Nothing more is recorded: {why}"));
    }
    let is_shown = workspace.shows_live;
    state.is_shown.store(is_shown, Ordering::Relaxed);
    if !is_shown {
        return;
    }
    let Some(session) = &state.session else { return };
    let seen = session.state();
    if take_poses(poses.bypass_change_detection(), Some(&seen)) {
        poses.set_changed();
    }
    // Written every time: what is shown of it are counts, which change with every sample.
    state.seen = Some(seen);
    if let Some(collected) = state.collector.newer_than(state.collected.as_ref()) {
        state.collected = collected;
    }
}

/// Of live bodies; those of a design stand where they are meant to.
pub(crate) fn keep_troubles(
    state: Res<LiveState>,
    shown: Option<Res<ShownDesign>>,
    troubles: Option<ResMut<BodyTroubles>>,
) {
    let Some(mut troubles) = troubles else { return };
    let shown = shown.filter(|shown| shown.live.is_some());
    let now = shown.map_or_else(Vec::new, |shown| state.troubles(&shown.design));
    troubles.set_if_neq(BodyTroubles(now));
}

/// Another design, room or choice of tools is compensated by once no drag is under way.
pub(crate) fn keep_room(
    mut state: ResMut<LiveState>,
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
        assigned: state.assigned.clone(),
    };
    if state.in_room.as_ref() == Some(&key) {
        return;
    }
    let scenario = trackwright_project::resolve(world.0.document.design(), &world.0.environment);
    let room = state.room(&scenario);
    if let Some(session) = &state.session {
        session.set_room(Some(room));
    }
    state.in_room = Some(key);
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_calibration::coverage::CoveragePlan;
    use trackwright_geometry::pose::Pose;
    use trackwright_openigtlink::session::SessionEvent;

    #[test]
    fn a_failed_recording_is_reported_once_and_stops() {
        let mut app = App::new();
        app.init_resource::<LiveState>()
            .init_resource::<LivePoses>()
            .init_resource::<Notice>()
            .init_resource::<Workspace>()
            .add_systems(Update, follow_session);
        let collector = app.world().resource::<LiveState>().collector.clone();
        let world = trackwright_project::open_builtin("pointer-on-head").unwrap();
        let plan = CoveragePlan::of(&world.environment);
        collector.begin(plan);
        let measured = SessionEvent::Measured { tool: "Wand".to_owned(), pose: Pose::identity() };
        collector.receive(&measured);
        let samples = || {
            let collected = collector.newer_than(None).flatten();
            collected.map(|collected| collected.summary.samples)
        };
        assert_eq!(samples(), Some(1));
        let why = "disk full".to_owned();
        collector.receive(&SessionEvent::NotRecorded { why });
        collector.receive(&measured);
        assert_eq!(samples(), Some(1));

        app.update();
        let notice = std::mem::take(&mut *app.world_mut().resource_mut::<Notice>());
        let expected = Notice::Refused("Nothing more is recorded: disk full".to_owned());
        assert_eq!(notice, expected);
        app.update();
        assert_eq!(*app.world().resource::<Notice>(), Notice::Nothing);

        // A recording begun anew goes on from where the other one was.
        collector.begin(plan);
        collector.receive(&measured);
        assert_eq!(samples(), Some(2));
    }
}
