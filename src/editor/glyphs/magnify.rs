//! The one magnification of errors, decided once and shown in the legend.

use crate::design::BodyRole;
use crate::design::view::{Layers, Magnification};
use crate::editor::camera::OrbitRig;
use crate::editor::state::{ActiveDrag, EditorSystems, OpenWorld, Results, ShownMagnification};
use crate::geometry::magnification::{Ghost, automatic_magnification, magnified_ghost};
use crate::geometry::pose::Pose;
use crate::study::PoseDetail;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use nalgebra::Point3;

/// Keeps [`ShownMagnification`]; never changes an automatic one during a drag.
pub struct MagnifyPlugin;

impl Plugin for MagnifyPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(ShownMagnification {
            times: 1.0,
            is_capped: false,
        })
        .add_systems(
            Update,
            decide
                .run_if(resource_exists::<OpenWorld>)
                .in_set(EditorSystems::Sample),
        );
    }
}

/// The tool's poses in the tracker frame and its tip, for the glyphs that start there.
#[derive(Clone, Copy, Debug)]
pub struct ToolErrors {
    pub tracker_from_tool: Pose,
    pub tracker_from_tool_believed: Pose,
    pub tip_in_tool: Point3<f64>,
}

impl ToolErrors {
    /// Of a result: the believed pose is relative to where the CRF truly is, as the surgeon
    /// sees it.
    pub fn of(world: &OpenWorld, detail: &PoseDetail) -> Option<Self> {
        let design = world.0.document.design();
        let tracker_from_crf = design
            .tracker_from_body(BodyRole::Crf)
            .unwrap_or_else(Pose::identity);
        Some(Self {
            tracker_from_tool: tracker_from_crf * detail.trial.crf_from_tool,
            tracker_from_tool_believed: tracker_from_crf * detail.trial.crf_from_tool_simulated,
            tip_in_tool: design.body(BodyRole::Tool)?.rigid.judged_tip_in_body(),
        })
    }

    pub fn tip_mm(&self) -> Point3<f64> {
        self.tracker_from_tool * self.tip_in_tool
    }

    pub fn ghost(&self, times: f64) -> Ghost {
        magnified_ghost(
            &self.tracker_from_tool,
            &self.tracker_from_tool_believed,
            &self.tip_in_tool,
            times,
        )
    }
}

/// What magnified errors are drawn from.
#[derive(SystemParam)]
pub struct ShownErrors<'w> {
    pub world: Res<'w, OpenWorld>,
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

    /// At the design's own pose; `None` while nothing is known.
    pub fn pose(&self) -> Option<&PoseDetail> {
        self.results.pose.as_ref().map(|pose| &pose.value)
    }

    pub fn tool(&self) -> Option<ToolErrors> {
        ToolErrors::of(&self.world, self.pose()?)
    }
}

fn decide(
    world: Res<OpenWorld>,
    results: Res<Results>,
    rig: Res<OrbitRig>,
    drag: Res<ActiveDrag>,
    mut shown: ResMut<ShownMagnification>,
) {
    if !(world.is_changed() || results.is_changed() || rig.is_changed() || drag.is_changed()) {
        return;
    }
    let Some(errors) = results
        .pose
        .as_ref()
        .and_then(|pose| ToolErrors::of(&world, &pose.value))
    else {
        return;
    };
    let times = match world.0.document.view().magnification {
        Magnification::Times(times) => times,
        Magnification::Auto if drag.0 => shown.times,
        Magnification::Auto => {
            let error = errors.tracker_from_tool_believed * errors.tip_in_tool - errors.tip_mm();
            let height_mm = rig.mm_per_px(&errors.tip_mm()) * rig.view_px[1];
            automatic_magnification(error.norm(), height_mm)
        }
    };
    shown.set_if_neq(ShownMagnification {
        times,
        is_capped: errors.ghost(times).is_capped,
    });
}
