//! The top of the page: what was found, in words and in a few large figures, and the requirement.

use super::Report;
use crate::report::words::bound_name;
use crate::study::requirement::Check;
use crate::study::{FigureRow, figure_rows};
use maud::{Markup, html};

/// The figures that are shown large, as their rows are labelled.
const LARGE: [&str; 4] = [
    "tip error RMS",
    "tip error 95th percentile",
    "tip error max",
    "angle error RMS",
];

pub fn head(report: &Report) -> Markup {
    let design = report.world.document.design();
    html! {
        header {
            p class="kicker" {
                "Design report"
                @if let Some(date) = &report.extras.date { " · " time datetime=(date) { (date) } }
            }
            h1 { (design.name) }
            p class="lead" { (design.tool.body.rigid.name)
                @match &design.crf {
                    Some(crf) => { " tracked against " (crf.body.rigid.name) },
                    None => " tracked without a reference on the patient",
                }
                " in " (report.world.environment.name)
            }
        }
    }
}

pub fn section(report: &Report) -> Markup {
    let study = report.study;
    let rows = figure_rows(&study.figures);
    let large = LARGE
        .iter()
        .filter_map(|label| rows.iter().find(|row| row.label == *label));
    html! {
        section id="summary" {
            p class="headline" { (study.words.headline) "." }
            p class=(verdict_class(study.figures.requirement_met())) {
                (verdict_mark(study.figures.requirement_met())) (study.words.verdict)
            }
            @if study.figures.trials > 1 {
                div class="large" { @for row in large { (large_figure(row)) } }
            }
            @if let Some(worst) = &study.words.worst { p { (worst) } }
            @if !study.words.cautions.is_empty() {
                ul class="cautions" { @for caution in &study.words.cautions { li { (caution) } } }
            }
            (requirement(&study.figures.checks))
        }
    }
}

/// A figure with two of its decimals; the table has them all.
fn large_figure(row: &FigureRow) -> Markup {
    let short = match row.value.split_once('.') {
        Some(_) => row
            .value
            .parse::<f64>()
            .map_or_else(|_| row.value.clone(), |value| format!("{value:.2}")),
        None => row.value.clone(),
    };
    html! {
        div class="figure" {
            span class="value" { (short) span class="unit" { "\u{2009}" (row.unit) } }
            span class="label" { (row.label) }
        }
    }
}

fn verdict_class(met: Option<bool>) -> &'static str {
    match met {
        Some(true) => "verdict met",
        Some(false) => "verdict missed",
        None => "verdict",
    }
}

fn verdict_mark(met: Option<bool>) -> &'static str {
    match met {
        Some(true) => "✓ ",
        Some(false) => "✗ ",
        None => "",
    }
}

fn requirement(checks: &[Check]) -> Markup {
    html! {
        @if !checks.is_empty() {
            h3 { "Requirement" }
            table class="data" {
                thead { tr { th { "figure" } th { "found" } th { "asked for" } th { "margin" } th {} } }
                tbody {
                    @for check in checks {
                        @let unit = if check.name.starts_with("angle") { "°" } else { "mm" };
                        tr {
                            td { (bound_name(check.name)) }
                            td { (format!("{:.4}\u{2009}{unit}", check.value)) }
                            td { "≤ " (format!("{}\u{2009}{unit}", check.limit)) }
                            td { (format!("{:+.4}\u{2009}{unit}", check.limit - check.value).replace('-', "−")) }
                            td class=(if check.met { "met" } else { "missed" }) { (if check.met { "✓ met" } else { "✗ missed" }) }
                        }
                    }
                }
            }
        }
    }
}
