//! What `procedure` prints.

use crate::cli::expected;
use crate::cli::output::columns;
use serde_json::{Value, json};
use trackwright_design::{BodyRole, Decision, Design, Procedure};
use trackwright_formats::printable::printable;
use trackwright_procedure::{
    BuiltStatus, Change, DecisionBasis, Row, State, Step, StepStatus, StudiesStatus, headline,
};
use trackwright_simulation::BoundVerdict;
use trackwright_simulation::expected::{judged, requirement_figures};
use trackwright_simulation::own_study::study_notes;
use trackwright_simulation::requirement::Requirement;
use trackwright_simulation::{ErrorOf, Metric};

pub(super) fn as_json(design: &str, procedure: &Procedure, found: &StepStatus) -> Value {
    let steps = Step::ALL.into_iter().map(|step| {
        let mut value = match step {
            Step::Crf => studies_as_json(&found.crf),
            Step::Tool => studies_as_json(&found.tool),
            Step::Built => built_as_json(&found.built),
        };
        value["step"] = json!(step.key());
        value["state"] = json!(found.state(step));
        value["decision"] = json!(procedure.decision(step).map(decision_as_json));
        let changes = found.changes(step).iter().map(change_as_json);
        value["changes"] = changes.collect();
        value
    });
    json!({ "design": design, "steps": steps.collect::<Vec<_>>() })
}

fn studies_as_json(found: &StudiesStatus) -> Value {
    json!({
        "requirement": found.requirement,
        "rows": found.rows.iter().map(row_as_json).collect::<Vec<_>>(),
    })
}

fn row_as_json(row: &Row) -> Value {
    let mut value = json!({
        "environment": row.room.name,
        "environment_file": row.room.file,
        "for_now": row.is_for_now,
        "target": row.target,
        "no_figures": row.studied.as_ref().err().map(ToString::to_string),
    });
    let Ok(studied) = &row.studied else {
        return value;
    };
    let figures = &studied.figures;
    value["trials"] = json!(figures.trials);
    value["outside"] = json!(figures.outside);
    value["out_of_volume"] = json!(figures.out_of_volume);
    value["without_field"] = json!(studied.without_field);
    value["position_mm"] = json!(figures.position_mm);
    value["angle_deg"] = json!(figures.angle_deg);
    value["worst"] = json!(figures.worst);
    value["requirement"] = json!(requirement_figures(figures));
    if let Some(expected) = &studied.expected {
        expected::add_json(&mut value, expected, &judged(figures, Some(expected)));
    }
    value
}

fn built_as_json(found: &BuiltStatus) -> Value {
    match &found.recording {
        None => json!({ "recording": null }),
        Some(Err(why)) => json!({ "recording": null, "no_figures": why }),
        Some(Ok(recording)) => json!({
            "recording": recording.found.recording.to_string(),
            "environment": recording.found.room.name,
            "environment_file": recording.found.room.file,
            "figures": recording.summary,
        }),
    }
}

fn decision_as_json(decision: &Decision) -> Value {
    json!({ "date": decision.date.to_string(), "note": decision.note })
}

fn change_as_json(change: &Change) -> Value {
    let mut value = json!({ "what": change.what, "words": change.to_string() });
    value["environment_file"] = json!(change.room.as_ref().map(|room| &room.file));
    value["target"] = json!(change.target);
    value
}

pub(super) fn as_text(design: &Design, found: &StepStatus) -> String {
    let mut lines = vec![printable(&design.name).into_owned()];
    for step in Step::ALL {
        lines.push(String::new());
        let what = match step {
            Step::Crf => design.body(BodyRole::Crf).map(|body| &body.rigid.name),
            Step::Tool | Step::Built => Some(&design.tool.body.rigid.name),
        };
        let title = match (step, what) {
            (Step::Crf, Some(name)) => format!("The CRF alone, {name}"),
            (Step::Crf, None) => "The CRF alone".to_owned(),
            (Step::Tool, name) => match design.crf {
                Some(_) => format!("The tool in the CRF, {}", name.map_or("", String::as_str)),
                None => format!("The tool, {}", name.map_or("", String::as_str)),
            },
            (Step::Built, _) => "The built tool".to_owned(),
        };
        lines.push(format!("{}. {}: {}", step.number(), printable(&title), headline(found, step)));
        match step {
            Step::Crf => lines.extend(studies(&found.crf, true)),
            Step::Tool => lines.extend(studies(&found.tool, false)),
            Step::Built => lines.extend(built(&found.built)),
        }
        if let Some(decision) = design.procedure.decision(step) {
            lines.extend(decided(decision, found.changes(step)));
        }
    }
    lines.join("\n")
}

fn studies(found: &StudiesStatus, has_targets: bool) -> Vec<String> {
    if found.state == State::DoesNotApply {
        return Vec::new();
    }
    let has_targets = has_targets && found.rows.iter().any(|row| row.target.is_some());
    let mut head = vec!["room"];
    if has_targets {
        head.push("judged at");
    }
    let left = head.len();
    let mut head: Vec<String> = head.into_iter().map(str::to_owned).collect();
    head.extend(Metric::decided().map(|m| format!("{} {}", m.summary.short(), m.unit())));
    head.push("required".to_owned());
    let figures = head.len() - left;
    let mut table = vec![head];
    for row in &found.rows {
        let mut cells = vec![room_name(row)];
        if has_targets {
            cells.push(row.target.clone().unwrap_or_default());
        }
        match &row.studied {
            Err(_) => cells.extend((0..figures).map(|_| "–".to_owned())),
            Ok(studied) => {
                let value = |metric| studied.figures.value(metric);
                cells.extend(Metric::decided().map(|metric| format!("{:.4}", value(metric))));
                let verdict = row.verdict().map_or("–", BoundVerdict::label);
                cells.push(verdict.to_owned());
            }
        }
        table.push(cells);
    }
    let mut lines: Vec<String> =
        columns(&table, left).into_iter().map(|line| format!("   {line}")).collect();
    for row in &found.rows {
        let notes = match &row.studied {
            Err(why) => vec![format!("no figures: {why}")],
            Ok(studied) => {
                let expected = studied.expected.iter().flat_map(expected::rows);
                let expected =
                    expected.map(|(label, value, unit)| format!("{label} {value} {unit}"));
                let notes = study_notes(&studied.figures, studied.without_field);
                expected.chain(notes).collect()
            }
        };
        let at = row.target.as_ref().map_or_else(String::new, |target| format!(", {target}"));
        lines.extend(notes.into_iter().map(|note| format!("   {}{at}: {note}", room_name(row))));
    }
    lines.push(format!("   {}", required(found.requirement.as_ref())));
    lines
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

fn built(found: &BuiltStatus) -> Vec<String> {
    let lines = match &found.recording {
        None => return Vec::new(),
        Some(Err(why)) => vec![format!("no figures: {why}")],
        Some(Ok(recording)) => {
            let of = &recording.found;
            let rms = Metric::TIP_RMS.label();
            vec![
                format!("{}, in {}", of.recording, of.room.name),
                format!(
                    "{} of {} poses; {rms}: measured {:.3} mm, predicted {:.3} mm, measured − predicted {:.3} mm",
                    of.used, of.poses, of.measured_rms_mm, of.predicted_rms_mm, of.residual_rms_mm
                ),
                of.statement.clone(),
            ]
        }
    };
    lines.into_iter().map(|line| format!("   {line}")).collect()
}

fn decided(decision: &Decision, changes: &[Change]) -> Vec<String> {
    let mut lines = vec![match decision.note.trim() {
        "" => format!("   decided on {}", decision.date),
        note => format!("   decided on {}: {note}", decision.date),
    }];
    if let DecisionBasis::Recording(recording) = &decision.basis {
        lines.push(format!("   on {}", recording.recording));
    }
    lines.extend(changes.iter().map(|change| format!("   since then: {change}")));
    lines
}
