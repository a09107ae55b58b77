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
        self.undo.push(Step {
            label,
            state: before,
        });
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

    /// Every remembered state, to be changed where files moved.
    pub(super) fn states_mut(&mut self) -> impl Iterator<Item = &mut Arc<Design>> {
        self.undo
            .iter_mut()
            .chain(&mut self.redo)
            .map(|step| &mut step.state)
    }
}

fn swap_step(
    from: &mut Vec<Step>,
    to: &mut Vec<Step>,
    present: &mut Arc<Design>,
) -> Option<String> {
    let step = from.pop()?;
    let left = std::mem::replace(present, step.state);
    to.push(Step {
        label: step.label.clone(),
        state: left,
    });
    Some(step.label)
}
