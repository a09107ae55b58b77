//! Where a design stands in the design procedure, as a result.

use trackwright_design::{BodyRole, Decision, Design};
use trackwright_formats::printable::printable;
use trackwright_procedure::{
    BuiltStatus, Change, DecisionBasis, Row, State, Step, StepStatus, StudiesStatus, headline,
};
use trackwright_result::{Section, Table, data};
use trackwright_simulation::requirement::Requirement;
use trackwright_simulation::{ErrorOf, Figure, Metric, Verdict};

/// Where a design stands as `procedure` prints it.
pub fn procedure_section(design: &Design, found: &StepStatus) -> Section {
    let step = |step| step_section(design, found, step).named("steps[]");
    Section::of([data("design", &design.name)])
        .with(printable(&design.name).into_owned())
        .with_all(Step::ALL.map(step))
}

fn step_section(design: &Design, found: &StepStatus, step: Step) -> Section {
    let tool = &design.tool.body.rigid.name;
    let title = match (step, design.body(BodyRole::Crf)) {
        (Step::Crf, Some(body)) => format!("The CRF alone, {}", body.rigid.name),
        (Step::Crf, None) => "The CRF alone".to_owned(),
        (Step::Tool, Some(_)) => format!("The tool in the CRF, {tool}"),
        (Step::Tool, None) => format!("The tool, {tool}"),
        (Step::Built, _) => "The built tool".to_owned(),
    };
    let changes = found.changes(step);
    let decision = design.procedure.decision(step);
    let decided = decision.into_iter().flat_map(|decision| decided(decision, changes));
    let status = match step {
        Step::Crf => studies(&found.crf),
        Step::Tool => studies(&found.tool),
        Step::Built => built(&found.built),
    };
    let kept = decision.map(|decision| {
        Section::of([data("date", decision.date.to_string()), data("note", &decision.note)])
    });
    let list = Table::of("changes", changes)
        .data("what", |change| change.what.clone())
        .data("words", ToString::to_string)
        .data("environment_file", |change| change.room.as_ref().map(|room| room.file.clone()))
        .data("target", |change| change.target.clone());
    Section::of([
        data("step", step.key()),
        data("state", found.state(step)),
        data("decision", kept),
    ])
    .with(list.done())
    .with(format!("{}. {}: {}", step.number(), printable(&title), headline(found, step)))
    .with(status.with_all(decided).below(3))
}

fn studies(found: &StudiesStatus) -> Section {
    let rows: Vec<Section> = found.rows.iter().map(row_section).collect();
    let section = Section::of([data("requirement", found.requirement), data("rows", rows)]);
    if found.state == State::DoesNotApply {
        return section;
    }
    section
        .with(table(&found.rows))
        .with_all(found.rows.iter().flat_map(notes))
        .with(required(found.requirement.as_ref()))
}

/// A study, as programs read it.
fn row_section(row: &Row) -> Section {
    let no_figures = row.studied.as_ref().err().map(ToString::to_string);
    let study = row.studied.as_ref().ok().map(|study| study.section(None));
    Section::of([
        data("environment", &row.room.name),
        data("environment_file", &row.room.file),
        data("for_now", row.is_for_now),
        data("target", &row.target),
        data("no_figures", no_figures),
    ])
    .with_all(study)
}

/// A line a room, or a room and target.
fn table(rows: &[Row]) -> Table {
    let mut table = Table::of("", rows).text("", "room", room_name);
    if rows.iter().any(|row| row.target.is_some()) {
        table = table.text("", "judged at", |row| row.target.clone().unwrap_or_default());
    }
    for metric in Metric::decided() {
        let head = format!("{} {}", metric.summary.short(), metric.unit());
        table = table
            .number("", head, 4, |row| Some(row.studied.as_ref().ok()?.figures.get(metric)?.value));
    }
    table.number("", "required", 0, |row| row.verdict().map(Verdict::label)).done()
}

fn notes(row: &Row) -> Vec<String> {
    let notes = match &row.studied {
        Err(why) => vec![format!("no figures: {why}")],
        Ok(studied) => {
            let figures = studied.figures.bounded().map(Figure::statement);
            figures.chain(studied.figures.no_interval_statement()).chain(studied.notes()).collect()
        }
    };
    let at = row.target.as_ref().map_or_else(String::new, |target| format!(", {target}"));
    notes.into_iter().map(|note| format!("{}{at}: {note}", room_name(row))).collect()
}

fn room_name(row: &Row) -> String {
    let name = match row.room.name.trim() {
        "" => row.room.file.clone(),
        name => name.to_owned(),
    };
    match row.is_for_now {
        true => format!("{} (this once)", printable(&name)),
        false => printable(&name).into_owned(),
    }
}

fn required(requirement: Option<&Requirement>) -> String {
    let bounds = requirement.iter().flat_map(|r| r.bounds());
    let bounds: Vec<String> = bounds
        .map(|(metric, bound)| {
            let space = if metric.of == ErrorOf::Angle { "" } else { " " };
            format!("{} ≤ {bound}{space}{}", metric.name(), metric.unit())
        })
        .collect();
    match bounds.is_empty() {
        true => "nothing is required".to_owned(),
        false => format!("required: {}", bounds.join(", ")),
    }
}

fn built(found: &BuiltStatus) -> Section {
    let recording = match &found.recording {
        None => return Section::of([data("recording", ())]),
        Some(Err(why)) => {
            let rows = [data("recording", ()), data("no_figures", why)];
            return Section::of(rows).with(format!("no figures: {why}"));
        }
        Some(Ok(recording)) => recording,
    };
    let of = &recording.found;
    Section::of([
        data("recording", of.recording.to_string()),
        data("environment", &of.room.name),
        data("environment_file", &of.room.file),
        data("figures", recording.summary.section()),
    ])
    .with(format!("{}, in {}", of.recording, of.room.name))
    .with(format!(
        "{} of {} poses; {}: measured {:.3} mm, predicted {:.3} mm, measured − predicted {:.3} mm",
        of.used,
        of.poses,
        Metric::TIP_RMS.label(),
        of.measured_rms_mm,
        of.predicted_rms_mm,
        of.residual_rms_mm
    ))
    .with(of.statement.clone())
}

fn decided(decision: &Decision, changes: &[Change]) -> Vec<String> {
    let mut lines = vec![match decision.note.trim() {
        "" => format!("decided on {}", decision.date),
        note => format!("decided on {}: {note}", decision.date),
    }];
    if let DecisionBasis::Recording(recording) = &decision.basis {
        lines.push(format!("on {}", recording.recording));
    }
    lines.extend(changes.iter().map(|change| format!("since then: {change}")));
    lines
}
