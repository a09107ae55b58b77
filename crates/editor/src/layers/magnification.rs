//! The one magnification of errors, decided once and shown in the legend.

use crate::document::requests::{ActiveDrag, OpenWorld};
use crate::document::shown::ShownDesign;
use crate::runner::results::Results;
use crate::schedule::EditorSystems;
use crate::viewport::camera::OrbitRig;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use nalgebra::Point3;
use trackwright_design::view::{Layers, Magnification};
use trackwright_design::{BodyRole, Design};
use trackwright_geometry::magnification::{Ghost, automatic_magnification, magnified_ghost};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::PoseDetail;

/// The magnification of errors, ghost and vectors as drawn.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct ShownMagnification {
    pub times: f64,
    /// The ghost's turn would be too large and is drawn smaller.
    pub is_capped: bool,
}

/// Keeps [`ShownMagnification`]; never changes an automatic one during a drag.
pub struct MagnifyPlugin;

impl Plugin for MagnifyPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(ShownMagnification { times: 1.0, is_capped: false }).add_systems(
            Update,
            decide
                .run_if(resource_exists::<OpenWorld>.and_then(resource_exists::<ShownDesign>))
                .in_set(EditorSystems::Sample),
        );
    }
}

/// The tool's poses in the tracker frame and its tip, for the glyphs that start there.
#[derive(Clone, Copy, Debug)]
pub struct ToolErrors {
    pub tracker_from_tool: Pose,
    pub tracker_from_tool_reported: Pose,
    pub tip_in_tool: Point3<f64>,
}

impl ToolErrors {
    /// Of a result: the reported pose is relative to where the CRF truly is, as the surgeon
    /// sees it.
    pub fn of(design: &Design, detail: &PoseDetail) -> Option<Self> {
        let tracker_from_crf =
            design.tracker_from_body(BodyRole::Crf).unwrap_or_else(Pose::identity);
        Some(Self {
            tracker_from_tool: tracker_from_crf * detail.trial.crf_from_tool,
            tracker_from_tool_reported: tracker_from_crf * detail.trial.crf_from_tool_simulated,
            tip_in_tool: design.body(BodyRole::Tool)?.rigid.judged_tip_in_body(),
        })
    }

    pub fn tip_mm(&self) -> Point3<f64> {
        self.tracker_from_tool * self.tip_in_tool
    }

    pub fn ghost(&self, times: f64) -> Ghost {
        magnified_ghost(
            &self.tracker_from_tool,
            &self.tracker_from_tool_reported,
            &self.tip_in_tool,
            times,
        )
    }
}

/// What magnified errors are drawn from.
#[derive(SystemParam)]
pub struct ShownErrors<'w> {
    pub world: Res<'w, OpenWorld>,
    pub shown: Res<'w, ShownDesign>,
    pub results: Res<'w, Results>,
    pub magnification: Res<'w, ShownMagnification>,
    pub rig: Res<'w, OrbitRig>,
}

impl ShownErrors<'_> {
    pub fn layers(&self) -> Layers {
        self.world.0.document.view().layers
    }

    pub fn times(&self) -> f64 {
        self.magnification.times
    }

    /// At the pose that is shown; `None` while nothing is known.
    pub fn pose(&self) -> Option<&PoseDetail> {
        self.results.pose.as_ref().map(|pose| &pose.value)
    }

    pub fn tool(&self) -> Option<ToolErrors> {
        ToolErrors::of(&self.shown.design, self.pose()?)
    }
}

fn decide(
    world: Res<OpenWorld>,
    design: Res<ShownDesign>,
    results: Res<Results>,
    rig: Res<OrbitRig>,
    drag: Res<ActiveDrag>,
    mut shown: ResMut<ShownMagnification>,
) {
    if !(world.is_changed()
        || design.is_changed()
        || results.is_changed()
        || rig.is_changed()
        || drag.is_changed())
    {
        return;
    }
    let Some(errors) =
        results.pose.as_ref().and_then(|pose| ToolErrors::of(&design.design, &pose.value))
    else {
        return;
    };
    let times = match world.0.document.view().magnification {
        Magnification::Times(times) => times,
        Magnification::Auto if drag.0 => shown.times,
        Magnification::Auto => {
            let error = errors.tracker_from_tool_reported * errors.tip_in_tool - errors.tip_mm();
            let (own_mm, height_px) = (error.norm(), rig.view_px[1]);
            let is_one_of_many = design.trial.is_some() || design.live.is_some();
            match &results.study {
                // One for all trials, so that their arrows can be compared, and for all that a
                // tracker reports, so that they grow with the error alone: that of the worst one,
                // as if it were where the camera looks.
                Some(study) if is_one_of_many => {
                    let worst_mm = study.value.figures.worst.position_mm.max(own_mm);
                    let height_mm = rig.mm_per_px(&rig.camera.focus_mm) * height_px;
                    automatic_magnification(worst_mm, height_mm)
                }
                _ => {
                    let height_mm = rig.mm_per_px(&errors.tip_mm()) * height_px;
                    automatic_magnification(own_mm, height_mm)
                }
            }
        }
    };
    shown.set_if_neq(ShownMagnification { times, is_capped: errors.ghost(times).is_capped });
}
