//! What is written over the 3D view: labels, legends, warnings on the spot, the drag's number.
//!
//! Painted with egui, so that the window and offscreen pictures show the same.

pub mod keys;
pub mod labels;
pub mod legend;
pub mod marks;
pub mod ruler;
pub mod summary;

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::selection::{Hovered, Selected, Selection};
use crate::document::shown::ShownDesign;
use crate::layers::ColorBars;
use crate::layers::color_bar::{ColorBar, ColorScale, ShownMagnification};
use crate::layers::probe::Probe;
use crate::palette;
use crate::runner::results::Results;
use crate::shell::layout::UiSystems;
use crate::shell::window::{DragReadout, Presentation, ViewportRect, Workspace};
use crate::viewport::camera::OrbitRig;
use crate::viewport::gizmo::CurrentGizmo;
use crate::viewport::overlay::keys::{LegendKey, Swatch};
use crate::workspaces::decide::desk::DecideDesk;
use crate::workspaces::live::desk::LiveDesk;
use crate::workspaces::present::panels::StageCover;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui::{self, LayerId, Painter, pos2, vec2};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use nalgebra::Point3;
use trackwright_design::Things;
use trackwright_design::view::Layers;
use trackwright_design::{BodyRole, Design, Document};
use trackwright_field::Environment;
use trackwright_geometry::gizmo::{Eye, Gizmo};
use trackwright_geometry::orbit::OrbitCamera;
use trackwright_simulation::{Expected, Figures, PoseDetail, Requirement};

/// Paints over the 3D view, in [`UiSystems::Overlay`].
pub struct OverlayPlugin;

impl Plugin for OverlayPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Selection>()
            .init_resource::<Hovered>()
            .init_resource::<Results>()
            .init_resource::<DragReadout>()
            .init_resource::<Probe>()
            .init_resource::<Presentation>()
            .init_resource::<Workspace>()
            .init_resource::<StageCover>()
            .add_systems(EguiPrimaryContextPass, draw.in_set(UiSystems::Overlay));
    }
}

/// Everything that the overlay depends on.
pub struct OverlayView<'a> {
    /// The 3D view in egui's points.
    pub rect: egui::Rect,
    pub camera: OrbitCamera,
    pub design: &'a Design,
    pub environment: &'a Environment,
    pub layers: Layers,
    /// What has no names in the scene; what is wrong with it is said all the same.
    pub hidden: &'a Things,
    pub pose: Option<&'a PoseDetail>,
    pub figures: Option<&'a Figures>,
    /// What is to be expected of them, once that is known.
    pub expected: Option<&'a Expected>,
    pub selected: Option<Selected>,
    pub hovered: Option<Selected>,
    pub magnification: Option<ShownMagnification>,
    /// From the bottom up.
    pub color_bars: Vec<ColorBar>,
    /// What hatchings and surfaces mean.
    pub keys: Vec<LegendKey>,
    /// Whether the tip's scatter is known and drawn.
    pub has_scatter: bool,
    /// The handles of what is selected, for the letters of their axes.
    pub gizmo: Option<Gizmo>,
    /// Text and its place while something is dragged, or of what is under the pointer.
    pub readout: Option<(egui::Pos2, &'a str)>,
    /// What keeps a body from standing where it is now.
    pub body_troubles: Vec<(BodyRole, String)>,
    /// Without panels the picture has to say the result itself.
    pub has_summary: bool,
    /// For people who do not design the tool: nothing that has to be explained.
    pub is_plain: bool,
    /// Whether a pinned design is drawn beside this one.
    pub has_baseline: bool,
    /// Where something is written already.
    pub covered: &'a [egui::Rect],
}

impl OverlayView<'_> {
    /// From where it is seen.
    pub fn eye(&self) -> Eye {
        let size = self.rect.size();
        Eye {
            camera: self.camera,
            view_px: [f64::from(size.x.max(1.0)), f64::from(size.y.max(1.0))],
        }
    }

    /// Where a point of the tracker frame is on the screen.
    pub fn project(&self, point_mm: &Point3<f64>) -> Option<egui::Pos2> {
        let [x, y] = self.camera.project(point_mm, self.eye().view_px)?;
        Some(self.rect.min + vec2(x as f32, y as f32))
    }
}

/// Paints everything.
pub fn paint(painter: &Painter, view: &OverlayView) {
    let mut covered = legend::paint(painter, view);
    covered.extend(view.covered);
    if view.has_summary {
        covered.push(summary::paint(painter, view));
    }
    marks::paint(painter, view, &covered);
}

/// What the scene decided, where there is a scene.
#[derive(SystemParam)]
struct Scene<'w> {
    rig: Option<Res<'w, OrbitRig>>,
    rect: Option<Res<'w, ViewportRect>>,
    shown: Option<Res<'w, ShownDesign>>,
    magnification: Option<Res<'w, ShownMagnification>>,
    color_scale: Option<Res<'w, ColorScale>>,
    color_bars: Option<Res<'w, ColorBars>>,
    gizmo: Option<Res<'w, CurrentGizmo>>,
    drag: Option<Res<'w, ActiveDrag>>,
    readout: Res<'w, DragReadout>,
    probe: Res<'w, Probe>,
    selection: Res<'w, Selection>,
    hovered: Res<'w, Hovered>,
    presentation: Res<'w, Presentation>,
    workspace: Res<'w, Workspace>,
    decide: Option<Res<'w, DecideDesk>>,
    cover: Res<'w, StageCover>,
    live: Option<Res<'w, LiveDesk>>,
}

impl Scene<'_> {
    /// Of live bodies; those of a design stand where they are meant to.
    fn body_troubles(&self) -> Vec<(BodyRole, String)> {
        let shown = self.shown.as_ref().filter(|shown| shown.live.is_some());
        match (&self.live, shown) {
            (Some(live), Some(shown)) => live.troubles(&shown.design),
            _ => Vec::new(),
        }
    }

    /// The handles that are drawn: none beside the one that is held.
    fn handles(&self) -> Option<Gizmo> {
        let is_dragging = self.drag.as_ref().is_some_and(|drag| drag.0);
        let shown = self.gizmo.as_ref().filter(|_| !is_dragging)?.0?;
        Some(shown.gizmo)
    }
}

/// The slice's below those of the layers.
fn color_bars(
    scene: &Scene,
    results: &Results,
    layers: Layers,
    requirement: Option<Requirement>,
) -> Vec<ColorBar> {
    let slice = results.slice.as_ref().filter(|_| layers.slice);
    let of_slice = slice.zip(scene.color_scale.as_deref()).map(|(slice, scale)| {
        let quantity = slice.value.quantity;
        ColorBar {
            label: quantity.label().to_owned(),
            unit: quantity.unit(),
            map: scale.map,
            min: 0.0,
            max: scale.max_mm,
            largest: slice.value.max,
            decimals: quantity.decimals(),
            limit: requirement.and_then(|of| quantity.limit(&of)),
        }
    });
    let of_layers = scene.color_bars.iter().flat_map(|bars| bars.all().cloned());
    of_slice.into_iter().chain(of_layers).collect()
}

/// Whether what a region comes to in words is that there is none.
fn is_none(text: &str) -> bool {
    text.starts_with("no ")
}

fn legend_keys(scene: &Scene, results: &Results, document: &Document) -> Vec<LegendKey> {
    let layers = document.view().layers;
    let mut keys = match scene.color_scale.as_deref().filter(|_| layers.slice) {
        Some(scale) => keys::of_slice(results, scale),
        None => Vec::new(),
    };
    if *scene.workspace == Workspace::Present && layers.tip_error {
        let requirement = document.design().requirement.as_ref();
        let limit = requirement.and_then(Requirement::single_position_mm);
        keys.extend(limit.map(|(_, limit_mm)| keys::of_limit(limit_mm)));
    }
    let Some(bars) = &scene.color_bars else {
        return keys;
    };
    for (text, color) in [(&bars.support, palette::SUPPORT), (&bars.region, palette::MET)] {
        // Why there is none is for whoever makes the slide: its panel says so.
        let is_told = |text: &&String| *scene.workspace != Workspace::Present || !is_none(text);
        keys.extend(text.iter().filter(is_told).map(|text| LegendKey {
            swatch: match is_none(text) {
                true => Swatch::Nothing,
                false => Swatch::Surface(color),
            },
            text: text.clone(),
        }));
    }
    keys
}

fn draw(
    mut contexts: EguiContexts,
    world: Option<Res<OpenWorld>>,
    results: Res<Results>,
    scene: Scene,
) -> Result {
    let (Some(world), Some(rig), Some(rect)) = (world, &scene.rig, &scene.rect) else {
        return Ok(());
    };
    let ctx = contexts.ctx_mut()?;
    let scale = 1.0 / ctx.zoom_factor();
    let place = |at: Vec2| pos2(at.x * scale, at.y * scale);
    let rect = egui::Rect::from_min_max(place(rect.min), place(rect.min + rect.size));
    let document = &world.0.document;
    let view = OverlayView {
        rect,
        camera: rig.camera,
        design: match &scene.shown {
            Some(shown) => &shown.design,
            None => document.design(),
        },
        environment: &world.0.environment,
        layers: document.view().layers,
        hidden: &document.view().hidden,
        pose: results.pose.as_ref().map(|p| &p.value),
        figures: results.study.as_ref().map(|s| &s.value.figures),
        expected: results.expected_of_study(),
        selected: scene.selection.primary(),
        hovered: scene.hovered.0,
        magnification: scene.magnification.as_deref().copied(),
        color_bars: color_bars(
            &scene,
            &results,
            document.view().layers,
            document.design().requirement,
        ),
        keys: legend_keys(&scene, &results, document),
        has_scatter: matches!(&results.scatter, Some(Ok(_))),
        gizmo: scene.handles(),
        readout: scene
            .readout
            .0
            .as_ref()
            .or(scene.probe.0.as_ref())
            .map(|readout| (place(readout.at), readout.text.as_str())),
        body_troubles: scene.body_troubles(),
        has_summary: !scene.presentation.panels,
        is_plain: *scene.workspace == Workspace::Present,
        has_baseline: *scene.workspace == Workspace::Decide
            && scene.decide.is_some_and(|desk| desk.pinned.is_some()),
        covered: &scene.cover.0,
    };
    let painter = ctx.layer_painter(LayerId::background()).with_clip_rect(rect);
    paint(&painter, &view);
    Ok(())
}
