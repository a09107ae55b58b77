//! The Present workspace as the shell registers it, the requests to it, and which slide it shows.

use crate::shell::keys::Keys;
use crate::shell::window::Workspace;
use bevy::prelude::*;
use trackwright_design::SlideFigure;

pub const WORKSPACE: Workspace = Workspace {
    name: "Present",
    order: 5,
    command: "Present",
    about: "Slides for people who do not design the tool; once more goes back",
    keys: &[Keys::plain("f5"), Keys::control("6")],
    shows_trials: true,
    is_presentation: true,
    ..Workspace::VIEWED
};

/// A request while slides are shown.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum PresentRequest {
    /// So many slides on, or back.
    Step(isize),
    /// From 0.
    Show(usize),
    /// Begins or ends writing on slides.
    ToggleEditing,
    /// Back to where it was begun.
    Leave,
    /// A slide like the shown one, looked at as it is now, after it.
    Add,
    Remove,
    /// The shown slide so many places on, or back.
    Move(isize),
    /// What is written on a slide: its number is that of the slide on which the writing began, since
    /// the click that ends it may lead to another one.
    SetTitle {
        slide: usize,
        title: String,
    },
    SetCaption {
        slide: usize,
        caption: String,
    },
    /// Whether the shown slide has a figure.
    SetFigure(SlideFigure, bool),
    /// The shown slide is looked at as it is now.
    KeepView,
    /// As the slide has it, after one has looked around.
    BackToView,
}

impl PresentRequest {
    /// Whether it is what was written on a slide.
    pub(crate) fn is_writing(&self) -> bool {
        matches!(self, Self::SetTitle { .. } | Self::SetCaption { .. })
    }
}

/// Which slide is shown, and whether it is written on.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Presenter {
    /// From 0; no more than there are.
    pub slide: usize,
    pub is_editing: bool,
    /// Where it goes back to.
    pub(crate) from: Workspace,
}

/// What the person is at, as a run condition.
pub fn is_presenting(workspace: Res<Workspace>) -> bool {
    *workspace == WORKSPACE
}
