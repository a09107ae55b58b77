//! Where the tool is and where the tracker reports it, for what is drawn from there.

use nalgebra::{Point3, Vector3};
use trackwright_design::{BodyRole, Design};
use trackwright_geometry::magnification::{Ghost, magnified_ghost};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::PoseDetail;

/// The tool's poses in the tracker frame and its tip.
#[derive(Clone, Copy, Debug)]
pub struct ToolErrors {
    pub tracker_from_tool: Pose,
    pub tracker_from_tool_reported: Pose,
    pub tip_in_tool: Point3<f64>,
}

impl ToolErrors {
    /// Of a result: the reported pose is relative to where the CRF truly is, as the surgeon sees it.
    pub fn of(design: &Design, detail: &PoseDetail) -> Self {
        let tracker_from_crf =
            design.tracker_from_body(BodyRole::Crf).unwrap_or_else(Pose::identity);
        Self {
            tracker_from_tool: tracker_from_crf * detail.trial.crf_from_tool,
            tracker_from_tool_reported: tracker_from_crf * detail.trial.crf_from_tool_simulated,
            tip_in_tool: design.tool.body.rigid.judged_tip_in_body(),
        }
    }

    /// Where the tip is.
    pub fn tip_mm(&self) -> Point3<f64> {
        self.tracker_from_tool * self.tip_in_tool
    }

    /// From the tip to where the tracker reports it.
    pub fn error_mm(&self) -> Vector3<f64> {
        self.tracker_from_tool_reported * self.tip_in_tool - self.tip_mm()
    }

    /// The tool as the tracker reports it, magnified.
    pub fn ghost(&self, times: f64) -> Ghost {
        magnified_ghost(
            &self.tracker_from_tool,
            &self.tracker_from_tool_reported,
            &self.tip_in_tool,
            times,
        )
    }
}
