//! The window: the hole for the 3D view, the shown workspace, hints beside the pointer.

use crate::convert;
use bevy::prelude::*;

/// The hole between the panels, in logical pixels of the window: the 3D view.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct ViewportRect {
    pub min: Vec2,
    pub size: Vec2,
}

impl ViewportRect {
    /// Whether a place in the window is in the 3D view.
    pub fn contains(&self, at: Vec2) -> bool {
        Rect::from_corners(self.min, self.min + self.size).contains(at)
    }

    /// A place in the window as pixels of the 3D view.
    pub fn pixel(&self, at: Vec2) -> [f64; 2] {
        convert::pixel(at - self.min)
    }
}

/// The number next to the pointer while something is dragged.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct DragReadout(pub Option<DragText>);

/// A line of text at a place in the window, logical pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct DragText {
    pub at: Vec2,
    pub text: String,
}

/// What the pointer can do now, where what it is over does not say so by itself: for the status
/// line.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct PointerHint(pub Option<String>);

/// What is drawn: a window with panels, or an offscreen picture.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Presentation {
    pub panels: bool,
    pub window: bool,
}

impl Default for Presentation {
    fn default() -> Self {
        Self { panels: true, window: true }
    }
}

/// What the person is at: which panels stand around the 3D view.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Workspace {
    /// Bodies, sensors, the result.
    #[default]
    Design,
    /// The room: measurements, their fit, its quality.
    Field,
    /// Trials one by one: the motion, plots, the log.
    Study,
    /// A tracker over the network: its tools, a recording, where samples are missing.
    Live,
    /// The design beside a baseline, and designs and rooms in one table.
    Decide,
    /// What is shown to people who do not design it: slides, without panels.
    Present,
}

impl Workspace {
    pub const ALL: [Self; 6] =
        [Self::Design, Self::Field, Self::Study, Self::Live, Self::Decide, Self::Present];

    pub fn is_live(self) -> bool {
        self == Self::Live
    }

    /// Whether a hand in the scene changes the design.
    pub fn is_edited_in(self) -> bool {
        matches!(self, Self::Design | Self::Study | Self::Decide)
    }

    /// Whether the tool can stand where a trial has it.
    pub fn shows_trials(self) -> bool {
        matches!(self, Self::Study | Self::Present)
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Design => "Design",
            Self::Field => "Field",
            Self::Study => "Study",
            Self::Live => "Live",
            Self::Decide => "Decide",
            Self::Present => "Present",
        }
    }
}

/// Owns the shown workspace and the hints beside the pointer.
pub struct WindowStatePlugin;

impl Plugin for WindowStatePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<DragReadout>()
            .init_resource::<PointerHint>()
            .init_resource::<Presentation>()
            .init_resource::<Workspace>();
    }
}
