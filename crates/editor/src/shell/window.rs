//! The window: the hole for the 3D view, the shown workspace, hints beside the pointer.

use crate::convert;
use crate::palette::Rgb;
use crate::shell::keys::Keys;
use crate::widgets::theme;
use bevy::prelude::*;
use bevy_egui::egui;
use nalgebra::Point3;
use std::collections::BTreeMap;

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

/// What the pointer can do now, where what it is over does not show that by itself: for the status
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

/// What the person is at: which panels stand around the 3D view, and what is done in it. As a
/// resource, the one that is shown.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Workspace {
    /// On its tab, and in the preferences. No two workspaces share one.
    pub name: &'static str,
    /// Among the tabs.
    pub order: u8,
    /// The command that shows it.
    pub command: &'static str,
    pub about: &'static str,
    pub keys: &'static [Keys],
    /// Whether a drag in the scene changes the design.
    pub edits_design: bool,
    /// Whether what is selected has handles that move and turn it.
    pub has_gizmo: bool,
    /// Whether the tool can stand where a trial has it.
    pub shows_trials: bool,
    /// Whether all trials are charted.
    pub charts_trials: bool,
    /// Whether bodies stand where a tracker has them.
    pub shows_live: bool,
    /// Whether a room's measurements are drawn.
    pub shows_samples: bool,
    /// Whether the design is shown beside a baseline.
    pub shows_baseline: bool,
    /// For people who do not design: no bars, no handles, only what is plain.
    pub is_presentation: bool,
    /// What it does with a table that is dropped, before the table's name.
    pub drop_verb: Option<&'static str>,
    /// Widths of the left and the right side until a person drags them.
    pub side_widths: [f32; 2],
}

impl Default for Workspace {
    fn default() -> Self {
        Self::NONE
    }
}

impl PartialEq for Workspace {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Workspace {}

impl Workspace {
    /// Before any is registered: a scene in which the design is edited, without panels.
    pub const NONE: Self = Self {
        name: "",
        order: 0,
        command: "",
        about: "",
        keys: &[],
        edits_design: true,
        has_gizmo: true,
        shows_trials: false,
        charts_trials: false,
        shows_live: false,
        shows_samples: false,
        shows_baseline: false,
        is_presentation: false,
        drop_verb: None,
        side_widths: [theme::LEFT_WIDTH, theme::RIGHT_WIDTH],
    };

    /// A workspace in which nothing is edited in the scene.
    pub const VIEWED: Self = Self { edits_design: false, has_gizmo: false, ..Self::NONE };
}

/// Which side panels are unfolded.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct PanelsShown {
    pub left: bool,
    pub right: bool,
    /// The list of steps, at the foot of the left panel.
    pub history: bool,
}

impl Default for PanelsShown {
    fn default() -> Self {
        Self { left: true, right: true, history: false }
    }
}

/// Widths of sides as a person dragged them, by the workspace's name and the side's.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct SideWidths(pub BTreeMap<String, f64>);

/// Whether a person folded the legend or unfolded it; `None` leaves it to the size of the view.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LegendFolded(pub Option<bool>);

/// Where panels cover the 3D view: labels of the scene stand elsewhere. In egui's points.
#[derive(Resource, Clone, Debug, Default)]
pub struct SceneCover(pub Vec<egui::Rect>);

/// What the shown workspace writes in the status line, before everything else.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct StatusNote(pub Option<String>);

/// What the shown workspace names in the scene.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct SceneLabels(pub Vec<SceneLabel>);

/// A name at a place of the tracker frame.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLabel {
    pub at_mm: Point3<f64>,
    pub text: String,
    pub color: Rgb,
}

/// Owns the shown workspace and the hints beside the pointer.
pub struct WindowStatePlugin;

impl Plugin for WindowStatePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<DragReadout>()
            .init_resource::<PointerHint>()
            .init_resource::<Presentation>()
            .init_resource::<Workspace>()
            .init_resource::<PanelsShown>()
            .init_resource::<SideWidths>()
            .init_resource::<LegendFolded>()
            .init_resource::<SceneCover>()
            .init_resource::<SceneLabels>()
            .init_resource::<StatusNote>();
    }
}
