//! Kinds of models beside each other: what each leaves of rows held out, and which is chosen.

use super::select::scores_json;
use serde_json::{Value, json};
use trackwright_calibration::kind_choice::{KindChoice, KindScored};
use trackwright_calibration::learning_curve::LearningPoint;
use trackwright_calibration::room_model::RoomModel;
use trackwright_field::selection::HoldOutBy;
use trackwright_field::selection::scoring::HeldOutScores;
use trackwright_report::selection::{candidate_text, hold_out_name};
use trackwright_simulation::figures::with_separators;

/// A kind and the best model of it.
pub(super) fn text(kind: &KindScored) -> String {
    match (&kind.model, &kind.candidate) {
        (RoomModel::Harmonic(order), _) => format!(
            "harmonic, generator {}, degree {}",
            order.generator.name(),
            order.degree.unwrap_or_default()
        ),
        (_, Some(candidate)) => format!("{}, {}", kind.name(), candidate_text(candidate)),
        (_, None) => kind.name().to_owned(),
    }
}

/// One line a kind, best first, in every hold-out; the chosen one is marked.
pub(super) fn lines(choice: &KindChoice, groups: Option<&str>) -> Vec<String> {
    let Some(first) = choice.kinds.first() else {
        return Vec::new();
    };
    let held_out: Vec<HoldOutBy> = first.scores.hold_outs.iter().map(|(by, _)| *by).collect();
    let mut lines = Vec::new();
    for by in held_out {
        let decides = if by == first.scores.decided_by { ", which decides" } else { "" };
        let groups = match (by, groups) {
            (HoldOutBy::Groups, Some(groups)) => format!(" by {groups}"),
            _ => String::new(),
        };
        lines.push(format!("held out {}{groups}{decides}:", hold_out_name(by)));
        for (place, kind) in choice.kinds.iter().enumerate() {
            let Some(scores) = kind.scores.held_out_by(by) else {
                continue;
            };
            let mark = if place == choice.best { '*' } else { ' ' };
            lines.push(format!("{mark} {} {}", figures(scores), text(kind)));
        }
    }
    for (kind, why) in &choice.left_out {
        lines.push(format!("{kind} is left out: {why}"));
    }
    lines
}

/// A line a number of measurements, a column a kind.
pub(super) fn curve_lines(points: &[LearningPoint]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for kind in points.iter().flat_map(|point| &point.choice.kinds) {
        if !names.contains(&kind.label()) {
            names.push(kind.label());
        }
    }
    names.sort_unstable();
    let cells = |first: &str, each: &dyn Fn(&str) -> String| {
        let rest: String = names
            .iter()
            .map(|name| format!("  {:>1$}", each(name), name.chars().count().max(10)))
            .collect();
        format!("{first:>12}{rest}")
    };
    let mut lines = vec![
        "position RMS of rows held out, mm, by number of measurements:".to_owned(),
        cells("measurements", &|name| name.to_owned()),
    ];
    for point in points {
        let rms = |name: &str| {
            let kind = point.choice.kinds.iter().find(|kind| kind.label() == name);
            kind.map_or_else(
                || "–".to_owned(),
                |kind| format!("{:.4}", kind.deciding().overall.position_rms_mm),
            )
        };
        lines.push(cells(&with_separators(point.rows), &rms));
    }
    lines
}

pub(super) fn curve_json(points: &[LearningPoint]) -> Value {
    let each = points.iter().map(|point| {
        let mut value = as_json(&point.choice);
        value["rows"] = json!(point.rows);
        value
    });
    Value::Array(each.collect())
}

fn figures(scores: &HeldOutScores) -> String {
    let angle = scores
        .overall
        .angle_rms_rad
        .map_or_else(String::new, |a| format!("  {:>8.4}°", a.to_degrees()));
    format!("{:>9.4} mm{angle}  ", scores.overall.position_rms_mm)
}

pub(super) fn as_json(choice: &KindChoice) -> Value {
    let kinds: Vec<Value> = choice
        .kinds
        .iter()
        .enumerate()
        .map(|(place, kind)| {
            let mut value = json!({
                "model": kind.name(),
                "is_chosen": place == choice.best,
                "cv": scores_json(&kind.deciding().overall),
            });
            for (by, scores) in &kind.scores.hold_outs {
                let key = match by {
                    HoldOutBy::Rows => "cv_by_row",
                    HoldOutBy::Groups => "cv_by_group",
                    HoldOutBy::Sensors => "cv_by_sensor",
                };
                value[key] = scores_json(&scores.overall);
            }
            if let Some(candidate) = &kind.candidate {
                value["order"] = json!(candidate.order);
                value["directions"] = json!(candidate.directions.len());
                value["ridge"] = json!(candidate.ridge);
            }
            if let RoomModel::Harmonic(order) = &kind.model {
                value["generator"] = json!(order.generator.name());
                value["degree"] = json!(order.degree);
            }
            value
        })
        .collect();
    let left_out: Vec<Value> =
        choice.left_out.iter().map(|(kind, why)| json!({"model": kind, "reason": why})).collect();
    json!({"kinds": kinds, "left_out": left_out})
}
