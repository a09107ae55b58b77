//! What drags in the scene have in common: one undo step each, a readout beside the pointer, and
//! Escape that takes everything back.

use crate::document::requests::{ActiveDrag, EditRequest};
use crate::shell::window::{DragReadout, DragText};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use trackwright_design::Edit;

/// The course of a drag: `Begin`, an `Apply` for each move, then `Commit`, or `Cancel` on Escape.
#[derive(SystemParam)]
pub struct DragEdits<'w> {
    active: ResMut<'w, ActiveDrag>,
    readout: ResMut<'w, DragReadout>,
    edits: MessageWriter<'w, EditRequest>,
}

impl DragEdits<'_> {
    /// Whether the button is down on something that is dragged: also after Escape.
    pub fn is_active(&self) -> bool {
        self.active.0
    }

    /// Something is held, though it has not moved yet.
    pub fn take_hold(&mut self) {
        self.active.set_if_neq(ActiveDrag(true));
    }

    /// What is held moves: `label` is what undo calls it.
    pub fn begin(&mut self, label: String) {
        self.take_hold();
        self.edits.write(EditRequest::Begin(label));
    }

    pub fn apply(&mut self, edit: Edit, at: Vec2, text: String) {
        self.edits.write(EditRequest::Apply(edit));
        let readout = DragReadout(Some(DragText { at, text }));
        self.readout.set_if_neq(readout);
    }

    /// The button is up.
    pub fn end(&mut self, has_begun: bool) {
        if has_begun {
            self.edits.write(EditRequest::Commit);
        }
        self.active.set_if_neq(ActiveDrag(false));
        self.readout.set_if_neq(DragReadout(None));
    }

    /// Everything is as it was before the drag, which goes on without an effect.
    pub fn cancel(&mut self) {
        self.edits.write(EditRequest::Cancel);
        self.readout.set_if_neq(DragReadout(None));
    }
}
