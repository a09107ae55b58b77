//! A design in its room as a scenario: plain data, every default decided.

use nalgebra::Point3;
use std::sync::Arc;
use trackwright_design::Design;
use trackwright_field::{Environment, OutsidePolicy};
pub use trackwright_simulation::scenario::CrfScenario;
use trackwright_simulation::{Scenario, ScenarioCrf};

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

/// The CRF of a design alone against the tracker (Fischer & Taylor 2005, section 4.1, step 2): once
/// for each of its targets, or once at its tip or origin where it has none; nothing without a CRF.
pub fn resolve_crf(design: &Design, environment: &Arc<Environment>) -> Vec<CrfScenario> {
    let Some(crf) = &design.crf else {
        return Vec::new();
    };
    let whole = resolve(design, environment);
    let judged_at = |target: Option<String>, at: Point3<f64>| {
        let mut body = crf.body.rigid.clone();
        body.tip_in_body = Some(at);
        CrfScenario {
            target,
            scenario: Scenario {
                tool: body,
                crf: None,
                crf_from_tool: crf.tracker_from_crf,
                motion: crf.motion,
                requirement: crf.requirement,
                ..whole.clone()
            },
        }
    };
    if crf.targets.is_empty() {
        return vec![judged_at(None, crf.body.rigid.judged_tip_in_body())];
    }
    let targets = crf.targets.iter();
    targets.map(|target| judged_at(Some(target.name.clone()), target.position_in_crf)).collect()
}
