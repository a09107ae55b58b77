//! Kinds of models in words: the same for the command line, Python and the editor.

use super::room::harmonic_model_text;
use super::selection::{candidate_text, hold_out_name, reason};
use trackwright_calibration::kind_choice::{Decided, KindChoice, KindScored};
use trackwright_calibration::room_model::{GeneratorChoice, RoomModel};
use trackwright_field::selection::{HoldOutBy, Scores};
use trackwright_result::{Item, Table};

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

/// A table for each hold-out, best kind first and the chosen one marked. Then why it was chosen.
pub fn kind_items(choice: &KindChoice, groups: Option<&str>) -> Vec<Item> {
    let mut items: Vec<Item> = Vec::new();
    for (by, _) in choice.kinds.first().map_or(&[][..], |first| &first.scores.hold_outs) {
        let decides = if *by == choice.best().scores.decided_by { ", which decides" } else { "" };
        let groups = match (by, groups) {
            (HoldOutBy::Groups, Some(groups)) => format!(" by {groups}"),
            _ => String::new(),
        };
        let kinds = choice.kinds.iter().enumerate();
        let kinds: Vec<_> = kinds
            .filter_map(|(place, kind)| Some((place, kind, &kind.scores.held_out_by(*by)?.overall)))
            .collect();
        let mut table = Table::of("", &kinds)
            .text("", " ", |(place, ..)| if *place == choice.best { "*" } else { "" })
            .number("", "RMS, mm", 4, |(.., scores)| scores.position_rms_mm);
        if kinds.iter().any(|(.., scores)| scores.angle_rms_rad.is_some()) {
            let angle = |scores: &Scores| scores.angle_rms_rad.map(f64::to_degrees);
            table = table.number("", "RMS, °", 4, |(.., scores)| angle(scores));
        }
        let table = table.text("", "model", |(_, kind, _)| kind_text(kind));
        items.push(format!("held out {}{groups}{decides}:", hold_out_name(*by)).into());
        items.push(table.done().into());
    }
    let left_out = choice.left_out.iter();
    items.extend(left_out.map(|(kind, why)| format!("{kind} is left out: {why}").into()));
    items.push(kind_reason(choice).into());
    items
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
