//! Where the error comes from: of a study that misses bounds, and of the worst trial.

use serde_json::{Value, json};
use trackwright_design::BodyRole;
use trackwright_simulation::error_sources::{AxisSpan, WorstTrials};
use trackwright_simulation::{
    CancelToken, ErrorOf, ErrorSources, Mode, RoomFieldFigures, Scenario, Study, StudyError,
    Verdict, error_sources, trial_pose, trial_sources,
};

/// The sources of each kind of error that misses a bound.
#[derive(Clone, Debug)]
pub struct Missed {
    kinds: Vec<ErrorOf>,
    sources: ErrorSources,
}

impl Missed {
    /// `None` where no bound is missed: nothing is computed then. The study is that of this body.
    ///
    /// # Errors
    /// A study that cannot run.
    pub fn of(
        role: BodyRole,
        (scenario, mode): (&Scenario, &Mode),
        study: &Study,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, StudyError> {
        let bounds = study.figures.requirement.as_ref().map_or(&[][..], |r| &r.bounds);
        let is_missed = |of: &ErrorOf| {
            let mut missed = bounds.iter().filter(|bound| bound.verdict == Verdict::Missed);
            missed.any(|bound| bound.metric.of == *of)
        };
        let kinds: Vec<ErrorOf> = ErrorOf::ALL.into_iter().filter(is_missed).collect();
        if kinds.is_empty() {
            return Ok(None);
        }
        let mut sources = error_sources(scenario, mode, cancel)?;
        for sensor in &mut sources.sensors {
            sensor.body = body_name(role, sensor.body);
        }
        Ok(Some(Self { kinds, sources }))
    }

    /// Sentences without a full stop.
    pub fn lines(&self) -> impl Iterator<Item = String> {
        self.kinds.iter().flat_map(|of| self.sources.words(*of, " "))
    }

    fn as_json(&self) -> Value {
        let mut value = json!({"trials": self.sources.trials});
        for of in &self.kinds {
            let (name, unit) = match of {
                ErrorOf::Position => ("tip_error", "mm"),
                ErrorOf::Angle => ("angle_error", "deg"),
            };
            let sensors = self.sources.sensors.iter().map(|sensor| {
                let mut value = json!({
                    "body": body_key(sensor.body),
                    "sensor": sensor.name,
                    "part": sensor.part(*of),
                });
                value[format!("rms_without_{unit}")] = json!(sensor.rms_without(*of));
                value
            });
            let mut kind = json!({
                "sensors": sensors.collect::<Vec<_>>(),
                "worst": self.sources.worst(*of).map(worst_as_json),
            });
            kind[format!("rms_{unit}")] = json!(self.sources.rms(*of));
            value[name] = kind;
        }
        value
    }
}

/// `error_sources` where a bound is missed, and `worst_contributions`, whatever the verdict.
pub fn add_sources(
    value: &mut Value,
    role: BodyRole,
    (scenario, mode): (&Scenario, &Mode),
    figures: &RoomFieldFigures,
    missed: Option<&Missed>,
) {
    if let Some(missed) = missed {
        value["error_sources"] = missed.as_json();
    }
    let worst = trial_pose(scenario, mode, figures.worst.trial);
    let sources = worst.map(|trial| trial_sources(scenario, trial)).unwrap_or_default();
    let each = sources.iter().map(|source| {
        json!({
            "body": body_key(body_name(role, source.body)),
            "sensor": source.name,
            "along_tip_error_mm": source.along_tip_error_mm,
        })
    });
    value["worst_contributions"] = each.collect();
}

/// Alone, a CRF has the place of the tool in its scenario.
fn body_name(studied: BodyRole, body: &'static str) -> &'static str {
    match studied {
        BodyRole::Tool => body,
        BodyRole::Crf => "CRF",
    }
}

/// A body as other keys of `simulate` name it.
fn body_key(body: &str) -> &'static str {
    if body == "tool" { "tool" } else { "crf" }
}

fn worst_as_json(worst: &WorstTrials) -> Value {
    json!({
        "trials": worst.trials,
        "within": worst.within,
        "ranges": worst.ranges.iter().map(range_as_json).collect::<Vec<_>>(),
    })
}

fn range_as_json(span: &AxisSpan) -> Value {
    let unit = if span.axis.starts_with('r') { "deg" } else { "mm" };
    let mut value = json!({"axis": span.axis});
    for (end, at) in [("from", span.from), ("to", span.to)] {
        value[format!("{end}_{unit}")] = json!(at);
    }
    value
}
