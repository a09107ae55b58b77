//! Undo and redo by whole states: what comes back is what was there, bit for bit.

use super::content::Design;
use std::sync::Arc;

/// Steps kept. A state shares everything that did not change, so that this costs little.
const MAX_STEPS: usize = 1000;

/// A state to go back to, and what led away from it.
#[derive(Clone, Debug)]
struct Step {
    label: String,
    state: Arc<Design>,
}

/// The steps of a document as a list, the oldest first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HistoryList<'a> {
    /// Every state that can be jumped to; never empty.
    pub states: Vec<HistoryState<'a>>,
    /// The state that the document is in, an index.
    pub present: usize,
}

/// One state of a document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HistoryState<'a> {
    /// The step that led here; `None` for the oldest state that is remembered.
    pub label: Option<&'a str>,
    /// Whether the files hold this design. The view is no part of a state.
    pub is_saved: bool,
}

/// The states before and after the present one.
#[derive(Clone, Debug, Default)]
pub(super) struct History {
    undo: Vec<Step>,
    redo: Vec<Step>,
}

impl History {
    /// Remembers what was before a step that is done; what had been undone is forgotten.
    pub(super) fn push(&mut self, label: String, before: Arc<Design>) {
        self.redo.clear();
        self.undo.push(Step { label, state: before });
        if self.undo.len() > MAX_STEPS {
            self.undo.remove(0);
        }
    }

    pub(super) fn undo(&mut self, present: &mut Arc<Design>) -> Option<String> {
        swap_step(&mut self.undo, &mut self.redo, present)
    }

    pub(super) fn redo(&mut self, present: &mut Arc<Design>) -> Option<String> {
        swap_step(&mut self.redo, &mut self.undo, present)
    }

    pub(super) fn undo_label(&self) -> Option<&str> {
        self.undo.last().map(|step| step.label.as_str())
    }

    pub(super) fn redo_label(&self) -> Option<&str> {
        self.redo.last().map(|step| step.label.as_str())
    }

    /// Steps that can be undone, and so the number of the present state.
    pub(super) fn present(&self) -> usize {
        self.undo.len()
    }

    /// The list, with what identifies a state that the files hold.
    pub(super) fn list<'a>(
        &'a self,
        present: &Arc<Design>,
        is_saved: impl Fn(&Arc<Design>) -> bool,
    ) -> HistoryList<'a> {
        let (undo, redo) = (self.undo.iter(), self.redo.iter().rev());
        // A step keeps the state on its far side as seen from the present: an undone step the one
        // that it leads to, any other the one that it led away from.
        let labels = undo.clone().chain(redo.clone()).map(|s| Some(&*s.label));
        let states = undo.map(|s| &s.state).chain([present]).chain(redo.map(|s| &s.state));
        HistoryList {
            states: std::iter::once(None)
                .chain(labels)
                .zip(states)
                .map(|(label, state)| HistoryState { label, is_saved: is_saved(state) })
                .collect(),
            present: self.present(),
        }
    }

    /// Undoes or redoes until the present state is the one of this number; whether it was not
    /// before and there is one.
    pub(super) fn jump_to(&mut self, state: usize, present: &mut Arc<Design>) -> bool {
        if state == self.present() || state > self.undo.len() + self.redo.len() {
            return false;
        }
        while self.undo.len() > state && self.undo(present).is_some() {}
        while self.undo.len() < state && self.redo(present).is_some() {}
        true
    }

    /// Every remembered state, to be changed where files moved.
    pub(super) fn states_mut(&mut self) -> impl Iterator<Item = &mut Arc<Design>> {
        self.undo.iter_mut().chain(&mut self.redo).map(|step| &mut step.state)
    }
}

fn swap_step(
    from: &mut Vec<Step>,
    to: &mut Vec<Step>,
    present: &mut Arc<Design>,
) -> Option<String> {
    let step = from.pop()?;
    let left = std::mem::replace(present, step.state);
    to.push(Step { label: step.label.clone(), state: left });
    Some(step.label)
}
