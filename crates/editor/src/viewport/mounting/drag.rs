//! Drags over a body: a brush that adds boxes to a patch, and a forbidden box between two points. A
//! click does the same at one point.

use crate::document::requests::{ActiveDrag, EditRequest};
use crate::document::selection::Selection;
use crate::viewport::camera::Sight;
use crate::viewport::camera_gestures::Gesture;
use crate::viewport::mounting::state::{MountingState, MountingTarget};
use crate::viewport::scene_drag::{self, SceneDrag};
use crate::viewport::surfaces::Surfaces;
use crate::viewport::tool::SceneTool;
use crate::widgets::basic::{counted, decimal, with_unit};
use bevy::ecs::system::SystemParam;
use bevy::picking::events::{Click, Pointer};
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use nalgebra::Point3;
use std::sync::Arc;
use trackwright_design::{BodyRole, Edit};
use trackwright_geometry::box_union::{box_between, stroke};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::surface::{Surface, SurfacePoint};
use trackwright_simulation::{Mounting, MountingRegion};

/// A stroke of the brush, or a box that is drawn.
pub struct HeldMounting {
    body: BodyRole,
    tool: SceneTool,
    tracker_from_body: Pose,
    surface: Arc<Surface>,
    /// Where the drag began, body frame.
    start_mm: Point3<f64>,
    /// Where the brush is.
    last_mm: Point3<f64>,
    edge_mm: f64,
    /// The patch that is painted.
    patch: Option<usize>,
    mounting: Mounting,
}

/// What a drag reads.
#[derive(SystemParam)]
pub struct Grip<'w> {
    sight: Sight<'w>,
    tool: Res<'w, SceneTool>,
    state: Res<'w, MountingState>,
    surfaces: Res<'w, Surfaces>,
}

pub(super) fn plugin(app: &mut App) {
    app.add_plugins(scene_drag::plugin::<MountingTarget>).add_observer(on_click);
}

impl Grip<'_> {
    /// The nearest point of a surface under a place in the window, body frame.
    fn hit(&self, surface: &Surface, tracker_from_body: &Pose, at: Vec2) -> Option<SurfacePoint> {
        let ray = self.sight.ray(at)?;
        surface.cast(&ray.transformed_by(&tracker_from_body.inverse()))
    }

    fn held(&self, body: BodyRole, at: Vec2) -> Option<HeldMounting> {
        let tool = *self.tool;
        if !matches!(tool, SceneTool::PaintPatch | SceneTool::DrawBox) {
            return None;
        }
        let design = self.sight.design()?;
        let tracker_from_body = design.tracker_from_body(body)?;
        let surface = Arc::clone(self.surfaces.of(body)?);
        let start_mm = self.hit(&surface, &tracker_from_body, at)?.position_mm;
        let mounting = design.body(body)?.mounting.clone();
        Some(HeldMounting {
            body,
            tool,
            tracker_from_body,
            surface,
            start_mm,
            last_mm: start_mm,
            edge_mm: self.state.brush_mm,
            patch: mounting.patch_to_paint(self.state.patch),
            mounting,
        })
    }
}

impl HeldMounting {
    /// The edit with the pointer over a point, and the text beside the pointer.
    fn reach(&mut self, at_mm: Point3<f64>) -> (Edit, String) {
        let (mounting, text) = match self.tool {
            SceneTool::DrawBox => {
                let mut mounting = self.mounting.clone();
                let drawn = box_between(&self.start_mm, &at_mm, self.edge_mm);
                mounting.keep_out.push(drawn);
                let [x, y, z] = [0, 1, 2].map(|k| decimal(drawn.size_mm()[k], 1));
                (mounting, with_unit(&format!("{x} × {y} × {z}"), "mm"))
            }
            _ => {
                let cubes = stroke(&self.last_mm, &at_mm, self.edge_mm);
                let patch = self.mounting.paint(self.patch, cubes);
                self.patch = Some(patch);
                let boxes = match &self.mounting.regions[patch] {
                    MountingRegion::Surface { boxes, .. } => boxes.len(),
                    _ => 0,
                };
                (self.mounting.clone(), counted(boxes, "box", "boxes"))
            }
        };
        self.last_mm = at_mm;
        (Edit::SetMounting { body: self.body, mounting: Box::new(mounting) }, text)
    }

    fn name(&self) -> String {
        match self.tool {
            SceneTool::DrawBox => format!("Draw forbidden box of the {}", self.body),
            _ => format!("Paint mounting patch of the {}", self.body),
        }
    }
}

impl SceneDrag for MountingTarget {
    type Held = HeldMounting;
    type Grip = Grip<'static>;

    fn take(&self, grip: &Grip, _: &Selection, at: Vec2) -> Option<HeldMounting> {
        grip.held(self.0, at)
    }

    fn label(held: &HeldMounting) -> String {
        held.name()
    }

    fn edit(held: &mut HeldMounting, grip: &Grip, at: Vec2) -> Option<(Edit, String)> {
        // Beside the body the brush stays where it is.
        let hit = grip.hit(&held.surface, &held.tracker_from_body, at)?;
        Some(held.reach(hit.position_mm))
    }
}

/// A press that hardly moves is a stroke of one box.
fn on_click(
    mut click: On<Pointer<Click>>,
    targets: Query<&MountingTarget>,
    grip: Grip,
    (active, camera): (Res<ActiveDrag>, Option<Res<Gesture>>),
    mut edits: MessageWriter<EditRequest>,
) {
    let Ok(target) = targets.get(click.entity) else {
        return;
    };
    let has_turned = camera.is_some_and(|camera| camera.has_moved());
    if click.button != PointerButton::Primary || active.0 || has_turned {
        return;
    }
    let Some(mut held) = grip.held(target.0, click.pointer_location.position) else {
        return;
    };
    click.propagate(false);
    let (edit, _) = held.reach(held.start_mm);
    edits.write(EditRequest::Begin(held.name()));
    edits.write(EditRequest::Apply(edit));
    edits.write(EditRequest::Commit);
}
