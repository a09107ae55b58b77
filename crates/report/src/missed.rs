//! Where the error comes from: of a study that misses bounds, and of the worst trial.

use trackwright_design::BodyRole;
use trackwright_result::{Section, Table, data};
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
    fn lines(&self) -> impl Iterator<Item = String> {
        self.kinds.iter().flat_map(|of| self.sources.words(*of, " "))
    }

    fn section(&self) -> Section {
        let kinds = self.kinds.iter().map(|&of| {
            let (name, unit) = match of {
                ErrorOf::Position => ("tip_error", "mm"),
                ErrorOf::Angle => ("angle_error", "deg"),
            };
            let sensors = Table::of("sensors", &self.sources.sensors)
                .data("body", |sensor| body_key(sensor.body))
                .data("sensor", |sensor| sensor.name.clone())
                .data("part", |sensor| sensor.part(of))
                .data(format!("rms_without_{unit}"), |sensor| sensor.rms_without(of));
            Section::of([
                data(format!("rms_{unit}"), self.sources.rms(of)),
                data("worst", self.sources.worst(of).map(worst_section)),
            ])
            .with(sensors.done())
            .named(name)
        });
        Section::of([data("trials", self.sources.trials)]).with_all(kinds).named("error_sources")
    }
}

/// `error_sources` where a bound is missed, and `worst_contributions`, whatever the verdict.
pub(super) fn sources_section(
    role: BodyRole,
    (scenario, mode): (&Scenario, &Mode),
    figures: &RoomFieldFigures,
    missed: Option<&Missed>,
) -> Section {
    let worst = trial_pose(scenario, mode, figures.worst.trial);
    let sources = worst.map(|trial| trial_sources(scenario, trial)).unwrap_or_default();
    let contributions = Table::of("worst_contributions", &sources)
        .data("body", |source| body_key(body_name(role, source.body)))
        .data("sensor", |source| source.name.clone())
        .data("along_tip_error_mm", |source| source.along_tip_error_mm);
    Section::default()
        .with(contributions.done())
        .with_all(missed.map(Missed::section))
        .with_all(missed.into_iter().flat_map(Missed::lines))
        .below(0)
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

fn worst_section(worst: &WorstTrials) -> Section {
    let range = |span: &AxisSpan| {
        let unit = if span.axis.starts_with('r') { "deg" } else { "mm" };
        let end = |end: &str, at: f64| data(format!("{end}_{unit}"), at);
        Section::of([data("axis", span.axis), end("from", span.from), end("to", span.to)])
    };
    let ranges: Vec<Section> = worst.ranges.iter().map(range).collect();
    Section::of([
        data("trials", worst.trials),
        data("within", worst.within),
        data("ranges", ranges),
    ])
}
