//! A design in its room as a scenario: plain data, every default decided.

use crate::design::Design;
use crate::field::{Environment, OutsidePolicy};
use crate::study::{Scenario, ScenarioCrf};
use std::sync::Arc;

/// The scenario of a design. The orientation weight is the design's, else the environment's.
pub fn resolve(design: &Design, environment: &Arc<Environment>) -> Scenario {
    Scenario {
        environment: Arc::clone(environment),
        tool: design.tool.body.rigid.clone(),
        crf: design.crf.as_ref().map(|crf| ScenarioCrf {
            body: crf.body.rigid.clone(),
            tracker_from_crf: crf.tracker_from_crf,
        }),
        crf_from_tool: design.tool.crf_from_tool,
        motion: design.motion,
        orientation_weight_mm: design
            .orientation_weight_mm
            .unwrap_or_else(|| environment.orientation_weight_mm()),
        requirement: design.requirement,
        outside: OutsidePolicy::default(),
    }
}
