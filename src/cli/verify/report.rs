//! What `verify` prints.

use super::super::{expected, output};
use nalgebra::Point3;
use serde_json::{Value, json};
use trackwright_calibration::agreement::{Agreement, Compared, Interval, Summary};
use trackwright_calibration::built_tool::BodySource;
use trackwright_calibration::pivot::Pivot;
use trackwright_field::environment::OrientationWeight;
use trackwright_simulation::Statistics;
use trackwright_simulation::figures::with_separators;

/// What is known of the recording besides its poses.
pub(super) struct Recorded {
    /// `None` of a pivoted tool.
    pub source: Option<BodySource>,
    pub rows_left_out: usize,
    pub crf_rows_left_out: usize,
    /// Moments of the tool at which the CRF was not recorded.
    pub without_crf: usize,
    /// Moments of the CRF at which the tool was not.
    pub without_tool: usize,
    pub has_crf: bool,
    pub orientation_weight: OrientationWeight,
    /// The tip as the recording has it, and as the design does.
    pub pivot: Option<(Pivot, Point3<f64>)>,
}

pub(super) fn as_json(recorded: &Recorded, found: &Agreement) -> Value {
    let mut value = json!(found.summary);
    if let Some(expected) = &found.expected {
        expected::add_json(&mut value, expected, &[]);
    }
    value["frame"] = json!(if recorded.has_crf { "crf" } else { "tracker" });
    value["rows_left_out"] = json!(recorded.rows_left_out);
    value["crf_rows_left_out"] = json!(recorded.crf_rows_left_out);
    value["without_crf"] = json!(recorded.without_crf);
    value["without_tool"] = json!(recorded.without_tool);
    if let Some(BodySource::Sensors { count, misfit_rms_mm }) = recorded.source {
        value["sensors"] = json!({"count": count, "misfit_rms_mm": misfit_rms_mm});
    }
    if let Some((pivot, designed)) = &recorded.pivot {
        let point = |at: &Point3<f64>| json!([at.x, at.y, at.z]);
        value["tip"] = json!({
            "recorded": point(&pivot.tip_in_tool),
            "designed": point(designed),
            "distance_mm": (pivot.tip_in_tool - designed).norm(),
            "std_error_mm": pivot.tip_std_error_mm,
        });
    }
    value
}

pub(super) fn as_text(recorded: &Recorded, found: &Agreement) -> String {
    let summary = &found.summary;
    let mut rows = vec![row("recorded poses", with_separators(summary.poses), "")];
    rows.push(row("  compared", with_separators(summary.used), ""));
    rows.push(row("  with a sensor outside the room's box", with_separators(summary.outside), ""));
    if let Some(count) = summary.unsupported {
        rows.push(row("  on poorly supported field", with_separators(count), ""));
    }
    if recorded.without_crf > 0 {
        let count = with_separators(recorded.without_crf);
        rows.push(row("  left out, the CRF not recorded", count, ""));
    }
    if recorded.without_tool > 0 {
        let count = with_separators(recorded.without_tool);
        rows.push(row("  of the CRF alone, left out", count, ""));
    }
    let rows_left_out = recorded.rows_left_out + recorded.crf_rows_left_out;
    if rows_left_out > 0 {
        let count = with_separators(rows_left_out);
        rows.push(row("  rows of the tables not used", count, ""));
    }
    rows.push(row("  worth independent poses", format!("{:.1}", summary.effective), ""));
    if let Some(BodySource::Sensors { misfit_rms_mm, .. }) = recorded.source {
        rows.push(row("sensors from their places in the design, RMS", mm(misfit_rms_mm), "mm"));
    }
    if let Some((pivot, designed)) = &recorded.pivot {
        rows.push(row(
            "recorded tip from that of the design",
            mm((pivot.tip_in_tool - designed).norm()),
            "mm",
        ));
    }
    let mut text = output::aligned(&rows);
    text.push_str("\n\n");
    text.push_str(&side_by_side("tip error, mm", &summary.position_mm));
    if let Some(angle) = &summary.angle_deg {
        text.push('\n');
        text.push_str(&side_by_side("angle error, °", angle));
    }
    text.push_str("\n\n");
    let mut rows = figures(summary);
    rows.extend(found.expected.iter().flat_map(expected::rows));
    text.push_str(&output::aligned(&rows));
    text.push_str("\n\n");
    text.push_str(&summary.statement);
    for assumption in assumptions(recorded) {
        text.push('\n');
        text.push_str(&assumption);
    }
    text
}

fn row(label: &str, value: String, unit: &str) -> (String, String, String) {
    (label.to_owned(), value, unit.to_owned())
}

fn mm(value: f64) -> String {
    format!("{value:.3}")
}

/// The three distributions below each other.
fn side_by_side(what: &str, found: &Compared) -> String {
    let line = |name: &str, cells: [String; 5]| {
        let cells: Vec<String> = cells.iter().map(|c| format!("{c:>8}")).collect();
        format!("{name:<24}{}", cells.join(""))
    };
    let head = ["RMS", "mean", "median", "p95", "max"].map(str::to_owned);
    let of = |s: &Statistics| [s.rms(), s.mean(), s.median(), s.p95(), s.max()].map(mm);
    [
        line(what, head),
        line("  measured", of(&found.measured)),
        line("  predicted", of(&found.predicted)),
        line("  measured − predicted", of(&found.residual)),
    ]
    .join("\n")
}

fn figures(summary: &Summary) -> Vec<(String, String, String)> {
    let mut rows = Vec::new();
    let percent = |i: &Interval| interval(i, 100.0, 1);
    let found = &summary.position_mm;
    let mut push = |label: &str, value: Option<String>, unit: &str| {
        rows.extend(value.map(|value| row(label, value, unit)));
    };
    push("explained of the squared tip error", found.explained.as_ref().map(percent), "%");
    push(
        "  of its change from pose to pose",
        found.explained_of_variation.as_ref().map(percent),
        "%",
    );
    push(
        "  of the squared angle error",
        summary.angle_deg.as_ref().and_then(|a| a.explained.as_ref().map(percent)),
        "%",
    );
    push("predictions fit best times", found.slope.as_ref().map(|i| interval(i, 1.0, 2)), "");
    if let Some(bias) = &found.bias {
        let mean = bias.mean;
        let half = bias.half_width;
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let around = half.map_or_else(String::new, |h| format!(" ± {:.3}", h[k]));
            push(&format!("mean difference {axis}"), Some(format!("{:.3}{around}", mean[k])), "mm");
        }
        push(
            "  chance of so much without a bias",
            bias.p.map(|p| if p < 1e-4 { "< 0.0001".to_owned() } else { format!("{p:.4}") }),
            "",
        );
    }
    if let Some(limits) = &found.lengths {
        push("measured minus predicted length, mean", Some(interval(&limits.bias, 1.0, 3)), "mm");
        push("  lower limit of agreement", Some(interval(&limits.lower, 1.0, 3)), "mm");
        push("  upper limit of agreement", Some(interval(&limits.upper, 1.0, 3)), "mm");
    }
    if let Some(noise) = &summary.noise {
        push("uncertainty that the room states, RMS", Some(mm(noise.rms_mm)), "mm");
        let accepted = noise.accepted.map_or_else(String::new, |[low, high]| {
            format!(" (nothing else: {low:.2} to {high:.2})")
        });
        push(
            "  squared difference in its units",
            Some(format!("{:.2}{accepted}", noise.normalised)),
            "",
        );
    }
    push("misfit of the room's model at the tip, RMS", summary.room_misfit_rms_mm.map(mm), "mm");
    rows
}

fn interval(found: &Interval, times: f64, digits: usize) -> String {
    let shown = |value: f64| format!("{:.digits$}", times * value);
    match found.low.zip(found.high) {
        Some((low, high)) => format!("{} ({} to {})", shown(found.value), shown(low), shown(high)),
        None => shown(found.value),
    }
}

/// What the figures depend on that the recording does not say.
fn assumptions(recorded: &Recorded) -> Vec<String> {
    let weight_mm = recorded.orientation_weight.value_mm;
    let is_whole = !matches!(recorded.source, Some(BodySource::Sensors { .. }));
    let mut said = Vec::new();
    if is_whole {
        said.push(format!(
            "Assumed: the tracker computes the tool's pose from its sensors by a least-squares fit, an axis weighing \
             {weight_mm:.0} mm, with the sensors where the design has them."
        ));
    }
    if recorded.pivot.is_some() {
        said.push(
            "What a pivot calibration takes up, a shift and the tip's place on the tool, is out of both; true poses are \
             those that would read as recorded."
                .to_owned(),
        );
    }
    said
}
