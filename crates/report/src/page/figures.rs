//! Charts of the error, and the study's figures as the command line prints them.

use super::Report;
use crate::error_charts::charts;
use maud::{Markup, PreEscaped, html};
use trackwright_result::with_separators;
use trackwright_simulation::figures::{signed_offset, trial_number};
use trackwright_simulation::profile::MAX_PROFILED;
use trackwright_simulation::{figure_rows, trial_offsets, trial_pose};

/// Pixels of a chart: two stand side by side.
const CHART_PX: (u32, u32) = (500, 330);

/// Error over position and orientation, and how it is spread.
pub fn errors(report: &Report) -> Markup {
    let study = report.study;
    let drawn: Vec<String> = study
        .profile
        .iter()
        .flat_map(|profile| charts(profile, study.scenario.requirement.as_ref()))
        .map(|chart| chart.to_svg(CHART_PX))
        .collect();
    html! {
        section id="error" {
            h2 { "Error over position and orientation" }
            @if study.study.room_field.trials == 1 {
                p { "One position was looked at, so there is nothing to chart." }
            } @else if study.profile.is_none() {
                p { "More than " (with_separators(MAX_PROFILED)) " positions were visited: they are in the figures below, and not kept one by one for charts." }
            } @else {
                p { (what_charts_show(report)) }
                div class="charts" {
                    @for svg in &drawn { figure class="chart" { (PreEscaped(svg)) } }
                }
            }
        }
    }
}

/// How to read the charts of this mode.
fn what_charts_show(report: &Report) -> &'static str {
    let has_axes = report.study.profile.as_ref().is_some_and(|profile| !profile.axes.is_empty());
    match has_axes {
        true => {
            "The charts are of the room's model alone, without what the measurements leave open. Each \
             line follows one axis of the motion: every point is the RMS, or the largest, of the tip \
             errors of all positions that have that place or that turn in common."
        }
        false => {
            "The charts are of the room's model alone, without what the measurements leave open. Each \
             point is the tip error of one given pose."
        }
    }
}

/// What is known of the figures, and what it rests on.
fn known(report: &Report) -> Markup {
    let figures = &report.study.study.figures;
    let drawn = figures.drawn.map(|drawn| {
        format!(
            "Each figure is the mean over {} fields that the room leaves possible ({} measurements), at {} of the positions; 95\u{2009}%: the interval in which the figure lies.",
            drawn.draws, with_separators(drawn.rows), with_separators(drawn.trials)
        )
    });
    html! {
        table class="data known" {
            thead { tr { th {} th { "figure" } th {} th { "95\u{2009}%" } } }
            tbody {
                @for figure in figures.bounded() {
                    tr {
                        th scope="row" { (figure.metric.label()) }
                        td class="number" { (figure.value_text(4)) }
                        td class="unit" { (figure.metric.unit()) }
                        td class="number" { (figure.interval_text(4).unwrap_or_else(|| "–".to_owned())) }
                    }
                }
            }
        }
        p class="note" { "Basis: " (figures.basis.words()) "." }
        @if let Some(why) = &figures.no_interval { p class="note" { "No interval: " (why.to_string()) "." } }
        @if let Some(drawn) = drawn { p class="note" { (drawn) } }
    }
}

/// The figures, and those of the paper's simulation: labels, digits and units are those that `simulate`
/// prints.
pub fn table(report: &Report) -> Markup {
    let rows = figure_rows(&report.study.study.room_field);
    html! {
        section id="figures" {
            h2 { "Figures" }
            (known(report))
            (worst(report))
            h3 { "The paper's simulation: the room's model taken for its field" }
            table class="data figures" {
                tbody {
                    @for row in &rows {
                        tr {
                            th scope="row" { (row.label) }
                            td class="number" { (row.value_text()) }
                            td class="unit" { (row.unit) }
                        }
                    }
                }
            }
            p class="note" {
                "Tip error: distance between the tip where it is and where the tracker would show it, in the frame of the reference. "
                "Angle error: the turn between both. RMS: root of the mean of squares. Trials are counted from 1, as the rows of the log are below its head."
            }
        }
    }
}

/// Which trial is the worst, in the terms of the motion and of the CRF's frame.
fn worst(report: &Report) -> Markup {
    let study = report.study;
    let trial = study.study.room_field.worst.trial;
    let offsets = trial_offsets(&study.scenario, &study.mode, trial);
    let along = offsets
        .iter()
        .map(|(axis, value)| {
            let unit = if axis.starts_with('r') { "°" } else { "\u{2009}mm" };
            format!("{axis} {}{unit}", signed_offset(*value)).replace('-', "−")
        })
        .collect::<Vec<_>>()
        .join(", ");
    let tip = trial_pose(&study.scenario, &study.mode, trial)
        .map(|pose| pose.crf_from_tool * study.scenario.tool.judged_tip_in_body());
    let frame = report.reference();
    html! {
        @if study.study.room_field.trials > 1 {
            p {
                "The worst trial is number " (trial_number(trial)) " of " (with_separators(study.study.room_field.trials))
                @if !along.is_empty() { ", at " (along) " from the design's pose" }
                @if let Some(tip) = tip {
                    (format!("; its tip is at ({:.1}, {:.1}, {:.1}) mm in the {frame}'s frame", tip.x, tip.y, tip.z).replace('-', "−"))
                }
                "."
            }
        }
    }
}
