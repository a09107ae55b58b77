//! What is written over the 3D view: labels, legends, warnings on the spot, the drag's number.
//!
//! Painted with egui, so that the window and offscreen pictures show the same.

mod color_bar;
pub mod corners;
mod keys;
pub mod labels;
pub mod legend;
pub mod marks;
pub mod ruler;
pub mod summary;

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::selection::{Hovered, Selected, Selection};
use crate::document::shown::ShownDesign;
use crate::layers::legend::Legends;
use crate::layers::legend_entries::LegendEntries;
use crate::layers::magnification::ShownMagnification;
use crate::layers::probe::Probe;
use crate::layers::registry::{AddLayer, LayerInfo, LayerRegistry};
use crate::runner::results::Results;
use crate::schedule::UiSystems;
use crate::shell::window::{
    DragReadout, LegendFolded, Presentation, SceneCover, SceneLabel, SceneLabels, ViewportRect,
    Workspace,
};
use crate::viewport::camera::OrbitRig;
use crate::viewport::coil_fit::{CoilFindings, ShownFindings};
use crate::viewport::gizmo::CurrentGizmo;
use crate::viewport::troubles::BodyTroubles;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui::{self, LayerId, Painter, pos2, vec2};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use nalgebra::Point3;
use trackwright_design::Things;
use trackwright_design::view::{Layer, Layers};
use trackwright_design::{BodyRole, Design};
use trackwright_field::Environment;
use trackwright_geometry::gizmo::{Eye, Gizmo};
use trackwright_geometry::orbit::OrbitCamera;
use trackwright_simulation::{PoseDetail, Study};

const LABELS: LayerInfo = LayerInfo::new(&Layer::LABELS);

/// Paints over the 3D view, in [`UiSystems::Overlay`].
pub struct OverlayPlugin;

impl Plugin for OverlayPlugin {
    fn build(&self, app: &mut App) {
        app.add_layer(LABELS)
            .init_resource::<BodyTroubles>()
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
    /// What has no names in the scene; what is wrong with it is labelled all the same.
    pub hidden: &'a Things,
    pub pose: Option<&'a PoseDetail>,
    /// Coils that do not fit.
    pub coils: ShownFindings<'a>,
    pub study: Option<&'a Study>,
    pub selected: Option<Selected>,
    pub hovered: Option<Selected>,
    pub magnification: Option<ShownMagnification>,
    /// What the legend names.
    pub legend: LegendEntries,
    /// Whether the legend has a title that folds it.
    pub can_fold: bool,
    /// Whether a person folded it or unfolded it.
    pub is_folded: Option<bool>,
    /// The handles of what is selected, for the letters of their axes.
    pub gizmo: Option<Gizmo>,
    /// Text and its place while something is dragged, or of what is under the pointer.
    pub readout: Option<(egui::Pos2, &'a str)>,
    /// What the shown workspace names.
    pub labels: &'a [SceneLabel],
    /// What keeps a body from standing where it is now.
    pub body_troubles: &'a [(BodyRole, String)],
    /// Without panels the picture has to state the result itself.
    pub has_summary: bool,
    /// For people who do not design the tool: nothing that has to be explained.
    pub is_plain: bool,
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

/// Paints everything; the legend's title, where it has one.
pub fn paint(painter: &Painter, view: &OverlayView) -> Option<legend::Title> {
    let legend::Painted { mut covered, title } = legend::paint(painter, view);
    covered.extend(view.covered);
    if view.has_summary {
        covered.push(summary::paint(painter, view));
    }
    marks::paint(painter, view, &covered);
    title
}

/// What the scene decided, where there is a scene.
#[derive(SystemParam)]
struct Scene<'w> {
    rig: Option<Res<'w, OrbitRig>>,
    rect: Option<Res<'w, ViewportRect>>,
    shown: Option<Res<'w, ShownDesign>>,
    magnification: Option<Res<'w, ShownMagnification>>,
    legends: Res<'w, Legends>,
    registry: Res<'w, LayerRegistry>,
    gizmo: Option<Res<'w, CurrentGizmo>>,
    drag: Option<Res<'w, ActiveDrag>>,
    readout: Res<'w, DragReadout>,
    probe: Option<Res<'w, Probe>>,
    selection: Res<'w, Selection>,
    hovered: Res<'w, Hovered>,
    presentation: Res<'w, Presentation>,
    workspace: Res<'w, Workspace>,
    covered: Res<'w, SceneCover>,
    labels: Res<'w, SceneLabels>,
    folded: Res<'w, LegendFolded>,
    troubles: Res<'w, BodyTroubles>,
    coils: Option<Res<'w, CoilFindings>>,
}

impl Scene<'_> {
    /// The handles that are drawn: none beside the one that is held.
    fn handles(&self) -> Option<Gizmo> {
        let is_dragging = self.drag.as_ref().is_some_and(|drag| drag.0);
        let shown = self.gizmo.as_ref().filter(|_| !is_dragging)?.0?;
        Some(shown.gizmo)
    }
}

fn draw(
    mut contexts: EguiContexts,
    world: Option<Res<OpenWorld>>,
    results: Res<Results>,
    scene: Scene,
    mut commands: Commands,
) -> Result {
    let (Some(world), Some(rig), Some(rect)) = (world, &scene.rig, &scene.rect) else {
        return Ok(());
    };
    let ctx = contexts.ctx_mut()?;
    let scale = 1.0 / ctx.zoom_factor();
    let place = |at: Vec2| pos2(at.x * scale, at.y * scale);
    let rect = egui::Rect::from_min_max(place(rect.min), place(rect.min + rect.size));
    let document = &world.0.document;
    let is_plain = scene.workspace.is_presentation;
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
        coils: ShownFindings::new(scene.coils.as_deref()),
        study: results.study.as_ref().map(|study| &study.value),
        selected: scene.selection.primary(),
        hovered: scene.hovered.0,
        magnification: scene.magnification.as_deref().copied(),
        legend: LegendEntries::new(
            &world.0,
            &scene.registry.layers,
            &scene.legends,
            // Bodies and sensors need no entry in a picture without panels.
            is_plain || !scene.presentation.panels,
        ),
        // An audience clicks on nothing, and a picture without panels is as large as it was wanted.
        can_fold: scene.presentation.panels && !is_plain,
        is_folded: scene.folded.0,
        gizmo: scene.handles(),
        readout: scene
            .readout
            .0
            .as_ref()
            .or(scene.probe.as_ref().and_then(|probe| probe.0.as_ref()))
            .map(|readout| (place(readout.at), readout.text.as_str())),
        labels: &scene.labels.0,
        body_troubles: &scene.troubles.0,
        has_summary: !scene.presentation.panels,
        is_plain,
        covered: &scene.covered.0,
    };
    let painter = ctx.layer_painter(LayerId::background()).with_clip_rect(rect);
    let title = paint(&painter, &view);
    let Some(title) = title else { return Ok(()) };
    legend::entries_ui(ctx, &title);
    if legend::title_ui(ctx, &title) {
        commands.insert_resource(LegendFolded(title.after_click));
    }
    Ok(())
}
