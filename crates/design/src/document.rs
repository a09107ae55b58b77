//! The open document: a design, its view, its history, and what of it is saved.

use super::content::Design;
use super::edit::Edit;
use super::edit_error::EditError;
use super::history::{History, HistoryList};
use super::view::View;
use std::path::PathBuf;
use std::sync::Arc;

/// Where a document came from and where Save puts it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Part of the program, read-only.
    BuiltIn(&'static str),
    File(PathBuf),
}

/// A design that is open. Every change goes through [`Document::apply`].
///
/// Edits between [`begin`](Self::begin) and [`commit`](Self::commit) are one undo step; an edit
/// outside is a step of its own. A step that changes nothing in the end leaves no trace.
///
/// ```
/// use trackwright_design::{Design, DesignBody, Document, Edit, Origin, View};
///
/// let body = DesignBody::of_file("probe.body.ron".to_owned());
/// let design = Design::of_tool("probe", "room.env.ron", body);
/// let mut document = Document::new(design, View::default(), Origin::BuiltIn("probe"));
/// document.begin("Drag");
/// for weight_mm in [10.0, 20.0, 30.0] {
///     document.apply(Edit::SetOrientationWeight(Some(weight_mm)))?;
/// }
/// assert!(document.commit());
/// assert_eq!(document.undo().as_deref(), Some("Drag"));
/// assert_eq!(document.design().orientation_weight_mm, None);
/// # Ok::<(), trackwright_design::EditError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Document {
    design: Arc<Design>,
    view: View,
    /// Shown in the place of its own view while it is presented.
    presented: Option<View>,
    origin: Origin,
    revision: u64,
    history: History,
    step: Option<OpenStep>,
    /// `None` where it is not known what the files hold.
    saved: Option<Saved>,
}

/// A step that has begun.
#[derive(Clone, Debug)]
struct OpenStep {
    label: String,
    before: Arc<Design>,
}

/// What the files hold.
#[derive(Clone, Debug)]
struct Saved {
    design: Arc<Design>,
    view: View,
}

impl Document {
    /// A document as it was just read.
    pub fn new(design: Design, view: View, origin: Origin) -> Self {
        let design = Arc::new(design);
        Self {
            saved: Some(Saved { design: Arc::clone(&design), view: view.clone() }),
            design,
            view,
            presented: None,
            origin,
            revision: 0,
            history: History::default(),
            step: None,
        }
    }

    /// A document as a session left it that ended without saving; `saved` is what the files hold,
    /// `None` where that is unknown: everything then counts as changed.
    pub fn recovered(
        design: Design,
        view: View,
        origin: Origin,
        saved: Option<(Design, View)>,
    ) -> Self {
        let mut document = Self::new(design, view, origin);
        document.saved = saved.map(|(design, view)| Saved { design: Arc::new(design), view });
        document
    }

    pub fn design(&self) -> &Design {
        &self.design
    }

    /// The design to hand to another thread.
    pub fn shared_design(&self) -> Arc<Design> {
        Arc::clone(&self.design)
    }

    /// How it is looked at: its own view, or a presented one.
    pub fn view(&self) -> &View {
        self.presented.as_ref().unwrap_or(&self.view)
    }

    /// The view that is saved with it, whatever is presented.
    pub fn own_view(&self) -> &View {
        &self.view
    }

    /// Changes how it is looked at, which is no undo step; whether anything changed. While a view
    /// is presented it is that one which changes.
    pub fn set_view(&mut self, view: View) -> bool {
        let is_changed = *self.view() != view;
        *self.presented.as_mut().unwrap_or(&mut self.view) = view;
        is_changed
    }

    /// Looks at it by another view from now on, which is never saved; `None` goes back to its own.
    pub fn present(&mut self, view: Option<View>) {
        self.presented = view;
    }

    /// Grows with every change of the design, undo and cancel included; never repeats.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// States that what the design is judged in is another one: figures of the revision before are old.
    pub fn room_has_changed(&mut self) {
        self.revision += 1;
    }

    pub fn origin(&self) -> &Origin {
        &self.origin
    }

    /// Applies an edit; whether anything changed.
    ///
    /// # Errors
    /// See [`EditError`]; the document is then as it was.
    pub fn apply(&mut self, edit: Edit) -> Result<bool, EditError> {
        let label = self.step.is_none().then(|| edit.label_for(&self.design));
        let mut after = Design::clone(&self.design);
        edit.apply_to(&mut after)?;
        if after == *self.design {
            return Ok(false);
        }
        let before = self.replace(Arc::new(after));
        if let Some(label) = label {
            self.history.push(label, before);
        }
        Ok(true)
    }

    /// Begins a step; one that is still open is committed first.
    pub fn begin(&mut self, label: impl Into<String>) {
        self.commit();
        self.step = Some(OpenStep { label: label.into(), before: Arc::clone(&self.design) });
    }

    /// Ends the open step; whether it changed anything.
    pub fn commit(&mut self) -> bool {
        let Some(step) = self.step.take() else {
            return false;
        };
        let is_changed = *step.before != *self.design;
        if is_changed {
            self.history.push(step.label, step.before);
        } else {
            // Equal is not yet identical: the state before a step without effect is kept.
            self.design = step.before;
        }
        is_changed
    }

    /// Takes the open step back; whether that changed anything.
    pub fn cancel(&mut self) -> bool {
        let Some(step) = self.step.take() else {
            return false;
        };
        let is_changed = *step.before != *self.design;
        if is_changed {
            self.replace(step.before);
        } else {
            self.design = step.before;
        }
        is_changed
    }

    pub fn is_in_step(&self) -> bool {
        self.step.is_some()
    }

    /// Takes the last step back and names it; `None` without one, or while a step is open.
    pub fn undo(&mut self) -> Option<String> {
        if self.step.is_some() {
            return None;
        }
        let label = self.history.undo(&mut self.design)?;
        self.revision += 1;
        Some(label)
    }

    /// Does the last step that was undone again; `None` without one, or while a step is open.
    pub fn redo(&mut self) -> Option<String> {
        if self.step.is_some() {
            return None;
        }
        let label = self.history.redo(&mut self.design)?;
        self.revision += 1;
        Some(label)
    }

    pub fn undo_label(&self) -> Option<&str> {
        self.history.undo_label()
    }

    pub fn redo_label(&self) -> Option<&str> {
        self.history.redo_label()
    }

    /// Every state that undo and redo can reach. A step that is open is not listed: the present is
    /// then still the state that it began from, or an edit of it.
    pub fn history(&self) -> HistoryList<'_> {
        self.history.list(&self.design, |state| self.is_saved(state))
    }

    /// Undoes or redoes as many steps as lead to a state of [`Self::history`], as one change.
    /// Whether anything changed: not while a step is open, nor where there is no such state.
    pub fn jump_to(&mut self, state: usize) -> bool {
        let has_moved = self.step.is_none() && self.history.jump_to(state, &mut self.design);
        self.revision += u64::from(has_moved);
        has_moved
    }

    /// Whether design or view differ from what the files hold. Where the camera is does not count; it is saved
    /// with the rest.
    pub fn is_dirty(&self) -> bool {
        let saved = self.saved.as_ref();
        let is_view_saved = saved.is_some_and(|saved| {
            saved.view == self.view
                || saved.view == View { camera: saved.view.camera, ..self.view.clone() }
        });
        !(is_view_saved && self.is_saved(&self.design))
    }

    /// Whether the files hold this design.
    fn is_saved(&self, design: &Arc<Design>) -> bool {
        self.saved
            .as_ref()
            .is_some_and(|saved| Arc::ptr_eq(design, &saved.design) || *design == saved.design)
    }

    /// The design and view that the files hold, where that is known.
    pub fn saved(&self) -> Option<(&Design, &View)> {
        self.saved.as_ref().map(|saved| (&*saved.design, &saved.view))
    }

    /// States that the files now hold the present design and view.
    pub fn mark_saved(&mut self) {
        self.saved = Some(Saved { design: Arc::clone(&self.design), view: self.view.clone() });
    }

    /// Moves the document to another place: `rewrite` gives each state, past ones too, the
    /// references that hold there, so that undo never brings back ones that lead elsewhere.
    pub fn relocate(&mut self, origin: Origin, rewrite: impl Fn(&mut Design)) {
        self.origin = origin;
        let states = self
            .history
            .states_mut()
            .chain(self.step.as_mut().map(|step| &mut step.before))
            .chain(self.saved.as_mut().map(|saved| &mut saved.design))
            .chain([&mut self.design]);
        for state in states {
            let mut moved = Design::clone(state);
            rewrite(&mut moved);
            if moved != **state {
                *state = Arc::new(moved);
            }
        }
        self.revision += 1;
    }

    /// Puts a design in the place of the present one, which is returned.
    fn replace(&mut self, design: Arc<Design>) -> Arc<Design> {
        self.revision += 1;
        std::mem::replace(&mut self.design, design)
    }
}
