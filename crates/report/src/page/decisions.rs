//! What was decided at each step of the design procedure, and on which figures.

use super::{Report, file_name, table_of};
use maud::{Markup, html};
use trackwright_design::Decision;
use trackwright_procedure::{DecidedRecording, DecidedRow, DecidedStudies, DecisionBasis, Step};
use trackwright_result::with_separators;
use trackwright_simulation::{Metric, Verdict};

/// Every decision with its figures.
pub fn section(report: &Report) -> Markup {
    let procedure = &report.world.document.design().procedure;
    let decisions: Vec<(Step, &Decision)> = procedure.decisions().collect();
    html! {
        @if !decisions.is_empty() {
            section id="decisions" {
                h2 { "Decisions" }
                p { "Figures as they were on the day of each decision. The design may have changed since." }
                @for (step, decision) in decisions { (decided(step, decision)) }
            }
        }
    }
}

fn decided(step: Step, decision: &Decision) -> Markup {
    let title = match step {
        Step::Crf => "The reference alone",
        Step::Tool => "The tool",
        Step::Built => "The built tool",
    };
    let date = decision.date.to_string();
    html! {
        h3 { (title) ", " time datetime=(date) { (date) } }
        @if !decision.note.trim().is_empty() { p { (decision.note) } }
        @match &decision.basis {
            DecisionBasis::Studies(studies) => { (of_studies(studies)) }
            DecisionBasis::Recording(recording) => { (of_recording(recording)) }
        }
    }
}

fn of_studies(studies: &DecidedStudies) -> Markup {
    let figures = Metric::bounded().map(|m| format!("{} {}", m.short_label(), m.unit()));
    let head = ["room", "judged at"].map(str::to_owned).into_iter().chain(figures);
    let head = head.chain(["trials", "required"].map(str::to_owned)).collect();
    let has_targets = studies.rows.iter().any(|row| row.target.is_some());
    let kept = |cells: Vec<String>| -> Vec<String> {
        let each = cells.into_iter().enumerate();
        let kept = each.filter(|(column, _)| has_targets || *column != 1);
        kept.map(|(_, cell)| cell).collect()
    };
    let rows: Vec<_> = studies.rows.iter().map(|row| kept(cells(row))).collect();
    html! {
        (table_of(&kept(head), &rows, "data"))
    }
}

fn cells(row: &DecidedRow) -> Vec<String> {
    let room = match row.room.name.trim() {
        "" => file_name(&row.room.file),
        name => name.to_owned(),
    };
    let mut cells = vec![room, row.target.clone().unwrap_or_default()];
    match &row.figures {
        Err(why) => {
            cells.push(format!("no figures: {why}"));
            cells.resize(4 + Metric::bounded().count(), String::new());
        }
        Ok(figures) => {
            let value = |metric| figures.values.get(metric);
            cells.extend(Metric::bounded().map(|metric| {
                value(metric).map_or_else(|| "–".to_owned(), |value| format!("{value:.4}"))
            }));
            cells.push(match figures.without_field {
                0 => with_separators(figures.trials),
                without => format!(
                    "{}, {} of them without field",
                    with_separators(figures.trials),
                    with_separators(without)
                ),
            });
            cells.push(figures.verdict.map_or("–", Verdict::label).to_owned());
        }
    }
    cells
}

fn of_recording(decided: &DecidedRecording) -> Markup {
    html! {
        p { (decided.statement) }
        p {
            (with_separators(decided.used)) " of " (with_separators(decided.poses)) " poses of "
            (file_name(&decided.recording.table)) " in " (decided.room.name)
            (format!(
                ": tip error measured {:.3}\u{2009}mm, predicted {:.3}\u{2009}mm, measured − predicted {:.3}\u{2009}mm RMS.",
                decided.measured_rms_mm, decided.predicted_rms_mm, decided.residual_rms_mm
            ))
        }
    }
}
