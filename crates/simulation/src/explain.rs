//! What a study computed, what it used again, and what its scene spared it: in words, from counts.

use super::scenario::Scenario;
use super::study::Study;
use std::fmt;
use trackwright_result::with_separators;

/// What became of a piece of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deed {
    Computed,
    /// Computed once and used many times.
    Reused,
    /// Not needed by this scene, and not done.
    LeftOut,
}

impl fmt::Display for Deed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Computed => "computed",
            Self::Reused => "reused",
            Self::LeftOut => "left out",
        })
    }
}

/// One piece of work, for a person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Explained {
    pub deed: Deed,
    pub what: String,
}

impl fmt::Display for Explained {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<8}  {}", self.deed, self.what)
    }
}

/// Lists a study's work, computed first.
pub fn explain(scenario: &Scenario, study: &Study) -> Vec<Explained> {
    let (figures, work) = (&study.room_field, &study.work);
    let mut out = Vec::new();
    let mut add = |deed, what: String| out.push(Explained { deed, what });
    let tool_evaluations = work.study_evaluations - work.crf_evaluations;
    add(Deed::Computed, format!("{} for the tool", counted(tool_evaluations, "field evaluation")));
    if work.crf_trackings > 0 {
        add(
            Deed::Computed,
            format!("{} for the CRF", counted(work.crf_evaluations, "field evaluation")),
        );
    }
    if work.coefficient_blends > 0 {
        add(
            Deed::Computed,
            format!(
                "{} of the coefficients for one orientation",
                counted(work.coefficient_blends, "blend")
            ),
        );
    }
    add(Deed::Computed, counted(work.frame_fits, "frame fit"));
    if work.crf_reuses > 0 {
        add(
            Deed::Reused,
            format!(
                "the CRF, tracked {} for {}",
                times(work.crf_trackings),
                counted(work.crf_reuses, "trial")
            ),
        );
    }
    if work.blended_evaluations > 0 {
        add(
            Deed::Reused,
            format!(
                "coefficients blended once an orientation, in {}",
                counted(work.blended_evaluations, "field evaluation")
            ),
        );
    }
    if scenario.crf.is_none() {
        add(Deed::LeftOut, "the CRF: the design has none, errors are in the tracker frame".into());
    }
    if scenario.environment.model.is_zero() {
        add(Deed::LeftOut, "the polynomials: the room is without distortion".into());
    }
    if figures.free_axis.is_none() {
        add(
            Deed::LeftOut,
            "the part of the error that a free rotation cannot change: none is free".into(),
        );
    }
    if scenario.requirement.is_none() {
        add(Deed::LeftOut, "the check of a requirement: none is set".into());
    }
    if figures.rejected > 0 {
        add(
            Deed::LeftOut,
            format!(
                "{} outside the model's box, from the statistics",
                counted(figures.rejected as u64, "trial")
            ),
        );
    }
    match &study.figures.drawn {
        Some(drawn) => add(
            Deed::Computed,
            format!(
                "{} drawn fields at {} sensor poses of {} trials, given {} measurements",
                drawn.draws,
                with_separators(drawn.points),
                with_separators(drawn.trials),
                with_separators(drawn.rows)
            ),
        ),
        None => {
            add(Deed::LeftOut, "drawn fields: there is nothing to draw them from".to_owned());
        }
    }
    out
}

fn counted(count: u64, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {what}{plural}", with_separators(count as usize))
}

fn times(count: u64) -> String {
    match count {
        1 => "once".into(),
        _ => format!("{} times", with_separators(count as usize)),
    }
}
