//! Drags over a body or anatomy: a brush that adds boxes to a patch or takes them out of it; over a
//! body also a forbidden box between two points. A click does the same at one point.

use crate::document::requests::EditRequest;
use crate::document::selection::Selection;
use crate::viewport::camera::Sight;
use crate::viewport::fine_pointer::DragKeys;
use crate::viewport::mounting::state::{
    MountingOwner, MountingState, MountingTarget, TargetClicks,
};
use crate::viewport::scene_drag::{self, SceneDrag};
use crate::viewport::surfaces::Surfaces;
use crate::viewport::tool::SceneTool;
use crate::widgets::basic::{counted, decimal, with_unit};
use bevy::ecs::system::SystemParam;
use bevy::picking::events::{Click, Pointer};
use bevy::prelude::*;
use nalgebra::{Point3, Vector3};
use std::sync::Arc;
use trackwright_design::{AnatomyEdit, Edit};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::box_union::{box_between, stroke};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::surface::Surface;
use trackwright_simulation::{Mounting, MountingRegion};

/// How far beyond the body its surface is taken to be in it.
const MARGIN_MM: f64 = 1.0;

const NOTHING_LEFT: &str = "nothing left to erase";

/// What a drag does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stroke {
    Paint,
    Erase,
    Box,
}

/// A stroke of the brush, or a box that is drawn.
pub struct HeldMounting {
    owner: MountingOwner,
    /// What it is called in an undo step: `tool`, `anatomy head`.
    name: String,
    stroke: Stroke,
    tracker_from_body: Pose,
    surface: Arc<Surface>,
    /// Where the drag began, body frame.
    start_mm: Point3<f64>,
    /// Where the brush is.
    last_mm: Point3<f64>,
    edge_mm: f64,
    /// The patch that is painted or erased.
    patch: Option<usize>,
    /// Whether nothing is left to be erased.
    is_spent: bool,
    /// A box around the body, with its surface inside.
    whole: Bounds,
    /// Of anatomy its patch is the only region.
    mounting: Mounting,
}

/// What a drag is over, as it is when that begins.
struct Under {
    name: String,
    tracker_from_body: Pose,
    surface: Arc<Surface>,
    bounds: Bounds,
    mounting: Mounting,
}

/// What a drag reads.
#[derive(SystemParam)]
pub struct Grip<'w> {
    sight: Sight<'w>,
    tool: Res<'w, SceneTool>,
    state: Res<'w, MountingState>,
    surfaces: Res<'w, Surfaces>,
    keys: DragKeys<'w>,
}

pub(super) fn plugin(app: &mut App) {
    app.add_plugins(scene_drag::plugin::<MountingTarget>).add_observer(on_click);
}

impl Grip<'_> {
    /// What a drag that begins now does.
    fn stroke(&self) -> Option<Stroke> {
        match *self.tool {
            SceneTool::PaintPatch if self.keys.is_off() => Some(Stroke::Erase),
            SceneTool::PaintPatch => Some(Stroke::Paint),
            SceneTool::ErasePatch => Some(Stroke::Erase),
            SceneTool::DrawBox => Some(Stroke::Box),
            _ => None,
        }
    }

    fn under(&self, owner: MountingOwner) -> Option<Under> {
        let design = self.sight.design()?;
        let world = &self.sight.world.as_ref()?.0;
        Some(match owner {
            MountingOwner::Body(body) => Under {
                name: body.to_string(),
                tracker_from_body: design.tracker_from_body(body)?,
                surface: Arc::clone(self.surfaces.of(body)?),
                bounds: world.mesh(body)?.body_bounds()?,
                mounting: design.body(body)?.mounting.clone(),
            },
            MountingOwner::Anatomy(index) => {
                let anatomy = design.anatomy.get(index)?;
                let mesh = world.anatomy_mesh(&anatomy.mesh)?;
                let mut mounting = Mounting::default();
                if !anatomy.crf_patch.is_empty() {
                    mounting.paint(None, anatomy.crf_patch.iter().copied());
                }
                Under {
                    name: format!("anatomy {}", anatomy.name),
                    tracker_from_body: anatomy.tracker_from_mesh(design),
                    surface: Arc::clone(self.surfaces.of_anatomy(mesh)?),
                    bounds: mesh.body_bounds()?,
                    mounting,
                }
            }
        })
    }

    fn held(&self, owner: MountingOwner, at: Vec2) -> Option<HeldMounting> {
        let stroke = self.stroke()?;
        let Under { name, tracker_from_body, surface, bounds, mounting } = self.under(owner)?;
        let start_mm = self.sight.hit(&surface, &tracker_from_body, at)?.position_mm;
        let margin = Vector3::repeat(MARGIN_MM);
        Some(HeldMounting {
            owner,
            name,
            stroke,
            tracker_from_body,
            surface,
            start_mm,
            last_mm: start_mm,
            edge_mm: self.state.brush_mm,
            patch: mounting.patch_to_paint(self.state.patch),
            // A body that states nothing is whole, anatomy that states nothing has no patch.
            is_spent: mounting.regions.is_empty() && owner.body().is_none(),
            whole: Bounds { min_mm: bounds.min_mm - margin, max_mm: bounds.max_mm + margin },
            mounting,
        })
    }
}

impl HeldMounting {
    /// The edit with the pointer over a point, and the text beside the pointer.
    fn reach(&mut self, at_mm: Point3<f64>) -> (Edit, String) {
        let cubes = stroke(&self.last_mm, &at_mm, self.edge_mm);
        let (mounting, text) = match self.stroke {
            Stroke::Box => {
                let mut mounting = self.mounting.clone();
                let drawn = box_between(&self.start_mm, &at_mm, self.edge_mm);
                mounting.keep_out.push(drawn);
                (mounting, size_text(&drawn))
            }
            Stroke::Paint => {
                self.patch = Some(self.mounting.paint(self.patch, cubes));
                (self.mounting.clone(), self.boxes_text())
            }
            Stroke::Erase => {
                if !self.is_spent {
                    self.patch = self.mounting.erase(self.patch, cubes, &self.whole);
                    self.is_spent = self.patch.is_none();
                }
                (self.mounting.clone(), self.boxes_text())
            }
        };
        self.last_mm = at_mm;
        (self.edit(mounting), text)
    }

    fn edit(&self, mounting: Mounting) -> Edit {
        match self.owner {
            MountingOwner::Body(body) => Edit::SetMounting { body, mounting: Box::new(mounting) },
            MountingOwner::Anatomy(index) => {
                let boxes = match mounting.regions.into_iter().next() {
                    Some(MountingRegion::Surface { boxes, .. }) => boxes,
                    _ => Vec::new(),
                };
                Edit::Anatomy(AnatomyEdit::SetCrfPatch { index, boxes })
            }
        }
    }

    /// What the patch consists of.
    fn boxes_text(&self) -> String {
        match self.patch.and_then(|patch| self.mounting.regions.get(patch)) {
            Some(MountingRegion::Surface { boxes, .. }) => counted(boxes.len(), "box", "boxes"),
            _ => NOTHING_LEFT.to_owned(),
        }
    }

    fn name(&self) -> String {
        let name = &self.name;
        match (self.stroke, self.owner) {
            (Stroke::Paint, MountingOwner::Body(_)) => {
                format!("Paint mounting patch of the {name}")
            }
            (Stroke::Erase, MountingOwner::Body(_)) => {
                format!("Erase mounting patch of the {name}")
            }
            (Stroke::Paint, MountingOwner::Anatomy(_)) => format!("Paint CRF patch of {name}"),
            (Stroke::Erase, MountingOwner::Anatomy(_)) => format!("Erase CRF patch of {name}"),
            (Stroke::Box, _) => format!("Draw forbidden box of the {name}"),
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
        let hit = grip.sight.hit(&held.surface, &held.tracker_from_body, at)?;
        Some(held.reach(hit.position_mm))
    }
}

/// `25.0 × 10.0 × 10.0 mm`.
pub(super) fn size_text(bounds: &Bounds) -> String {
    let [x, y, z] = [0, 1, 2].map(|k| decimal(bounds.size_mm()[k], 1));
    with_unit(&format!("{x} × {y} × {z}"), "mm")
}

/// A press that hardly moves is a stroke of one box.
fn on_click(
    mut click: On<Pointer<Click>>,
    clicks: TargetClicks,
    grip: Grip,
    mut edits: MessageWriter<EditRequest>,
) {
    let at = click.pointer_location.position;
    let held = clicks.owner(&click).and_then(|owner| grip.held(owner, at));
    if let Some(mut held) = held {
        click.propagate(false);
        let (edit, _) = held.reach(held.start_mm);
        edits.write_batch(EditRequest::step(held.name(), [edit]));
    }
}
