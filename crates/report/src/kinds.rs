//! Kinds of models in words: the same for the command line, Python and the editor.

use super::room::harmonic_model_text;
use super::selection::{candidate_text, hold_out_name, reason};
use trackwright_calibration::kind_choice::{Decided, KindChoice, KindScored};
use trackwright_calibration::room_model::{GeneratorChoice, RoomModel};
use trackwright_field::selection::HoldOutBy;
use trackwright_field::selection::scoring::HeldOutScores;

/// A kind and the best model of it: "harmonic, generator planar-nine, degree 6".
pub fn kind_text(kind: &KindScored) -> String {
    match (&kind.model, &kind.candidate) {
        (RoomModel::Harmonic(order), _) => {
            // Degree and ridge were chosen.
            harmonic_model_text(order.generator.name(), &order.settings(0))
        }
        (_, Some(candidate)) if candidate.order == 0 => "no correction".to_owned(),
        (_, Some(candidate)) => format!("{}, {}", kind.name(), candidate_text(candidate)),
        (_, None) => kind.name().to_owned(),
    }
}

/// One line a kind, best first, in every hold-out; the chosen one is marked. Then why it was chosen.
pub fn kind_lines(choice: &KindChoice, groups: Option<&str>) -> Vec<String> {
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
            lines.push(format!("{mark} {} {}", held_out_figures(scores), kind_text(kind)));
        }
    }
    for (kind, why) in &choice.left_out {
        lines.push(format!("{kind} is left out: {why}"));
    }
    lines.push(kind_reason(choice));
    lines
}

/// Why a model is what it is, where anything was chosen.
pub fn decided_reason(decided: &Decided) -> Option<String> {
    match (&decided.kinds, &decided.chosen) {
        (Some(kinds), _) => Some(kind_reason(kinds)),
        (None, Some(chosen)) => {
            Some(reason(&chosen.selection, chosen.by.as_deref(), chosen.tried.folds))
        }
        (None, None) => None,
    }
}

/// What was chosen, by how much, and what may do better, in one sentence.
pub fn kind_reason(choice: &KindChoice) -> String {
    let best = choice.best();
    let left = |kind: &KindScored| format!("{:.4} mm", kind.deciding().overall.position_rms_mm);
    let least = &choice.kinds[0];
    // Kinds are in the order of what they leave.
    let other = match choice.best {
        0 => choice.kinds.get(1),
        _ => Some(least),
    };
    let other = other.map_or_else(String::new, |other| match choice.best {
        0 => format!(", the next best is {} with {}", kind_text(other), left(other)),
        _ => format!(
            ", as good within the noise of the folds as {} with {}, and simpler",
            kind_text(other),
            left(other)
        ),
    });
    let better = match &best.model {
        RoomModel::Harmonic(order) => match order.generator {
            GeneratorChoice::Known(_) => "more measurements may do better",
            GeneratorChoice::Learned(_) => {
                "the maker's generator (a file for --generator) or more measurements may do better"
            }
        },
        _ if best.candidate.is_some_and(|c| c.order == 0) => {
            "more measurements, or the tracker's generator (a file for --generator), may do better"
        }
        _ => "the tracker's generator (a file for --generator) or more measurements may do better",
    };
    format!("chosen: {}: {} RMS held out{other}; {better}", kind_text(best), left(best))
}

fn held_out_figures(scores: &HeldOutScores) -> String {
    let angle = scores
        .overall
        .angle_rms_rad
        .map_or_else(String::new, |a| format!("  {:>8.4}°", a.to_degrees()));
    format!("{:>9.4} mm{angle}  ", scores.overall.position_rms_mm)
}
