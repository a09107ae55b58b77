//! The top of the page: what was found, in words and in a few large figures, and the requirement.

use super::{Report, ReportedStudy};
use maud::{Markup, html};
use trackwright_simulation::expected::{JudgedBound, judged, verdict_of};
use trackwright_simulation::{BoundVerdict, Expected, METRICS, Metric};

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
    let mut bounds = judged(&study.figures, study.expected.as_ref());
    bounds.retain(|bound| study.scenario.judges(&study.mode, bound.metric));
    let verdict = verdict_of(&bounds);
    html! {
        section id="summary" {
            p class="headline" { (study.words.headline) "." }
            p class=(verdict_class(verdict)) { (verdict_mark(verdict)) (study.words.verdict) }
            (reasons(study, &bounds))
            @if study.figures.trials > 1 {
                div class="large" {
                    @match &study.expected {
                        None => { @for figure in own_figures(study) { (figure) } },
                        Some(expected) => { @for figure in expected_figures(expected) { (figure) } },
                    }
                }
            }
            @if let Some(worst) = &study.words.worst { p { (worst) } }
            @if !study.words.cautions.is_empty() {
                ul class="cautions" { @for caution in &study.words.cautions { li { (caution) } } }
            }
            (requirement(&bounds))
        }
    }
}

/// Why the requirement is missed, of the first bound that is.
fn reasons(study: &ReportedStudy, bounds: &[JudgedBound]) -> Markup {
    let missed = bounds.iter().find(|bound| bound.verdict == BoundVerdict::Missed);
    let words = missed.zip(study.sources.as_ref());
    let words = words.map(|(bound, sources)| sources.words(bound.metric.of, "\u{2009}"));
    html! {
        @if let Some(words) = words {
            ul class="reasons" { @for reason in &words { li { (reason) "." } } }
        }
    }
}

/// Those of the room's own field, with two of their decimals; the table has them all.
fn own_figures(study: &ReportedStudy) -> Vec<Markup> {
    let large = METRICS.into_iter().filter(|metric| metric.is_large());
    let each = large.map(|metric| {
        let value = format!("{:.2}", study.figures.value(metric));
        large_figure(&value, metric.unit(), metric.label(), None)
    });
    each.collect()
}

/// Those that are to be expected, each above its interval.
fn expected_figures(expected: &Expected) -> Vec<Markup> {
    let each = Metric::bounded().filter(|metric| metric.is_large()).map(|metric| {
        let (value, interval) = expected.of(metric);
        let label = format!("expected {}", metric.label());
        large_figure(&format!("{value:.2}"), metric.unit(), &label, Some(interval))
    });
    each.collect()
}

fn large_figure(value: &str, unit: &str, label: &str, interval: Option<[f64; 2]>) -> Markup {
    html! {
        div class="figure" {
            span class="value" { (value) span class="unit" { "\u{2009}" (unit) } }
            @if let Some([low, high]) = interval {
                span class="label" { (format!("95\u{2009}%: {low:.2} to {high:.2}\u{2009}{unit}")) }
            }
            span class="label" { (label) }
        }
    }
}

fn verdict_class(verdict: Option<BoundVerdict>) -> &'static str {
    match verdict {
        Some(BoundVerdict::Met) => "verdict met",
        Some(BoundVerdict::Missed) => "verdict missed",
        Some(BoundVerdict::CannotTell) => "verdict open",
        None => "verdict",
    }
}

fn verdict_mark(verdict: Option<BoundVerdict>) -> &'static str {
    match verdict {
        Some(BoundVerdict::Met) => "✓ ",
        Some(BoundVerdict::Missed) => "✗ ",
        Some(BoundVerdict::CannotTell) => "? ",
        None => "",
    }
}

fn requirement(bounds: &[JudgedBound]) -> Markup {
    let has_intervals = bounds.iter().any(|bound| bound.interval.is_some());
    html! {
        @if !bounds.is_empty() {
            h3 { "Requirement" }
            table class="data" {
                thead {
                    tr {
                        th { "figure" }
                        th { (if has_intervals { "expected" } else { "found" }) }
                        @if has_intervals { th { "95\u{2009}%" } }
                        th { "required" } th { "margin" } th {}
                    }
                }
                tbody {
                    @for bound in bounds {
                        @let unit = bound.metric.unit();
                        tr {
                            td { (bound.metric.label()) }
                            td { (format!("{:.4}\u{2009}{unit}", bound.value)) }
                            @if has_intervals {
                                td {
                                    @if let Some([low, high]) = bound.interval {
                                        (format!("{low:.4} to {high:.4}\u{2009}{unit}"))
                                    }
                                }
                            }
                            td { "≤ " (format!("{}\u{2009}{unit}", bound.limit)) }
                            td { (format!("{:+.4}\u{2009}{unit}", bound.limit - bound.value).replace('-', "−")) }
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
