//! The top of the page: what was found, in words and in a few large figures, and the requirement.

use super::{Report, ReportedStudy};
use maud::{Markup, html};
use trackwright_simulation::{Figure, JudgedBound, Verdict};

/// Title and what the page is of.
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

/// The study in words and large figures.
pub fn section(report: &Report) -> Markup {
    let study = report.study;
    let requirement = study.study.figures.requirement.as_ref();
    let bounds = requirement.map_or(&[][..], |requirement| &requirement.bounds);
    let verdict = requirement.map(|requirement| requirement.verdict);
    let large = study.study.figures.bounded().filter(|figure| figure.metric.is_large());
    html! {
        section id="summary" {
            p class="headline" { (study.words.headline) "." }
            p class=(verdict_class(verdict)) { (verdict_mark(verdict)) (study.words.verdict) }
            (reasons(study, bounds))
            @if study.study.room_field.trials > 1 {
                div class="large" { @for figure in large { (large_figure(figure)) } }
            }
            @if let Some(worst) = &study.words.worst { p { (worst) } }
            @if !study.words.cautions.is_empty() {
                ul class="cautions" { @for caution in &study.words.cautions { li { (caution) } } }
            }
            (bounds_table(bounds))
        }
    }
}

/// Why the requirement is missed, of the first bound that is.
fn reasons(study: &ReportedStudy, bounds: &[JudgedBound]) -> Markup {
    let missed = bounds.iter().find(|bound| bound.verdict == Verdict::Missed);
    let words = missed.zip(study.sources.as_ref());
    let words = words.map(|(bound, sources)| sources.words(bound.metric.of, "\u{2009}"));
    html! {
        @if let Some(words) = words {
            ul class="reasons" { @for reason in &words { li { (reason) "." } } }
        }
    }
}

fn large_figure(figure: &Figure) -> Markup {
    let unit = figure.metric.unit();
    html! {
        div class="figure" {
            span class="value" { (figure.value_text(2)) span class="unit" { "\u{2009}" (unit) } }
            @if let Some(interval) = figure.interval_text(2) {
                span class="label" { (format!("95\u{2009}%: {interval}\u{2009}{unit}")) }
            }
            span class="label" { (figure.metric.label()) }
        }
    }
}

fn verdict_class(verdict: Option<Verdict>) -> &'static str {
    match verdict {
        Some(Verdict::Met) => "verdict met",
        Some(Verdict::Missed) => "verdict missed",
        Some(Verdict::CannotTell) => "verdict open",
        None => "verdict",
    }
}

fn verdict_mark(verdict: Option<Verdict>) -> &'static str {
    match verdict {
        Some(Verdict::Met) => "✓ ",
        Some(Verdict::Missed) => "✗ ",
        Some(Verdict::CannotTell) => "? ",
        None => "",
    }
}

fn bounds_table(bounds: &[JudgedBound]) -> Markup {
    html! {
        @if !bounds.is_empty() {
            h3 { "Requirement" }
            table class="data" {
                thead {
                    tr {
                        th { "figure" } th { "value" } th { "95\u{2009}%" } th { "required" } th { "margin" } th {}
                    }
                }
                tbody {
                    @for bound in bounds {
                        @let unit = bound.metric.unit();
                        @let figure = bound.figure.as_ref();
                        tr {
                            td { (bound.metric.label()) }
                            td { (figure.map_or_else(|| "–".to_owned(), |f| f.amount(4, "\u{2009}"))) }
                            td { (figure.and_then(|f| f.interval_text(4)).unwrap_or_else(|| "–".to_owned())) }
                            td { "≤ " (format!("{}\u{2009}{unit}", bound.limit)) }
                            td {
                                @if let Some(figure) = figure {
                                    (format!("{:+.4}\u{2009}{unit}", bound.limit - figure.value).replace('-', "−"))
                                }
                            }
                            td class=(verdict_class(Some(bound.verdict))) {
                                (verdict_mark(Some(bound.verdict))) (bound.label())
                            }
                        }
                    }
                }
            }
        }
    }
}
