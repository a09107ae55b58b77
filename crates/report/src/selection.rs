//! A selection in words and as a table: the same for the command line and the editor.

use trackwright_field::selection::places::Places;
use trackwright_field::selection::sensors::SensorSpread;
use trackwright_field::selection::{self, Candidate, HoldOutBy, Scored, Scores, Selection};
use trackwright_result::with_separators;

/// One line of the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SelectionRow {
    pub is_chosen: bool,
    pub cells: Vec<String>,
}

/// "order 3, 42 orientations, ridge 1e-3".
pub fn candidate_text(candidate: &Candidate) -> String {
    if candidate.order == 0 {
        return "order 0, no correction".to_owned();
    }
    let plural = if candidate.directions.len() == 1 { "" } else { "s" };
    let ridge = match candidate.ridge {
        0.0 => "no ridge".to_owned(),
        ridge => format!("ridge {}", ridge_text(ridge)),
    };
    format!(
        "order {}, {} orientation{plural}, {ridge}",
        candidate.order,
        candidate.directions.len(),
    )
}

/// A ridge with two digits, "3.2e-5".
pub fn ridge_text(ridge: f64) -> String {
    let text = format!("{ridge:.1e}");
    text.replace(".0e", "e")
}

/// Probability that an interval of sensors' spread holds.
pub const SENSOR_INTERVAL: f64 = 0.95;

/// Why the choice is what it is, in one sentence; `by` is what groups rows, if anything does.
pub fn reason(selection: &Selection, by: Option<&str>, folds: usize) -> String {
    let (best, least) = (selection.best(), selection.least());
    let rms = best.deciding().position_rms_mm;
    let how = hold_out_text(selection, selection.decided_by, by)
        .unwrap_or_else(|| format!("{folds} folds"));
    let is_least_of_all = selection
        .table
        .iter()
        .all(|row| row.deciding().position_rms_mm >= least.deciding().position_rms_mm);
    let instead_of = selection.instead_of.and_then(|i| selection.table.get(i));
    let why = match instead_of {
        Some(other) => format!(
            "as good within the noise of the folds as {} ({}) and better in angle",
            scores_text(other.deciding()),
            candidate_text(&other.candidate),
        ),
        None if selection.best == selection.least => match is_least_of_all {
            true => "the least of all".to_owned(),
            false => "the least of all that the rows determine".to_owned(),
        },
        None => format!(
            "the smallest within {:.0} % of the least, {:.4} mm ({})",
            selection::TOLERANCE * 100.0,
            least.deciding().position_rms_mm,
            candidate_text(&least.candidate),
        ),
    };
    let mut reason = format!(
        "chosen: {}; {rms:.4} mm RMS held out in {how}, {why}",
        candidate_text(&best.candidate)
    );
    for caution in cautions(selection) {
        reason.push_str("; ");
        reason.push_str(&caution);
    }
    reason
}

/// What is wrong with the chosen model.
fn cautions(selection: &Selection) -> Vec<String> {
    let best = selection.best();
    let mut cautions = Vec::new();
    if best.is_under_sampled() {
        cautions.push(format!(
            "most of its orientations ({} of {}) have fewer places than coefficients",
            best.under_sampled,
            best.candidate.directions.len()
        ));
    } else if !best.is_determined {
        cautions.push("it has at least as many coefficients as places to fit them to".to_owned());
    }
    let uncorrected = selection.table.iter().find(|row| row.candidate.order == 0);
    let angles =
        (best.deciding().angle_rms_rad, uncorrected.and_then(|row| row.deciding().angle_rms_rad));
    if let (Some(after), Some(before)) = angles
        && after > before * (1.0 + selection::TOLERANCE)
    {
        cautions.push(format!(
            "its angles are worse than without correction, {:.2}° against {:.2}°",
            after.to_degrees(),
            before.to_degrees()
        ));
    }
    cautions
}

/// "5 folds over 91 groups by column pose"; `None` where rows were not held out so.
pub fn hold_out_text(selection: &Selection, by: HoldOutBy, groups: Option<&str>) -> Option<String> {
    let found = selection.hold_outs.iter().find(|h| h.by == by)?;
    let (folds, count) = (found.folds, with_separators(found.count));
    Some(match (by, groups) {
        (HoldOutBy::Rows, _) => format!("{folds} folds of rows"),
        (HoldOutBy::Groups, Some(name)) => format!("{folds} folds over {count} groups by {name}"),
        (HoldOutBy::Groups, None) => format!("{folds} folds over {count} groups"),
        (HoldOutBy::Sensors, _) => format!("{folds} folds over {count} sensors"),
    })
}

/// The chosen model in each hold-out, a line each; none where there is only one.
pub fn hold_out_lines(selection: &Selection, groups: Option<&str>) -> Vec<String> {
    let best: &Scored = selection.best();
    if selection.hold_outs.len() < 2 {
        return Vec::new();
    }
    let line = |by: HoldOutBy| {
        let scores = best.held_out_by(by)?;
        let how = hold_out_text(selection, by, groups)?;
        let decides = if by == selection.decided_by { "; this decides" } else { "" };
        Some(format!("held out by {}: {} ({how}{decides})", hold_out_name(by), scores_text(scores)))
    };
    let hold_outs = selection.hold_outs.iter();
    hold_outs.filter_map(|h| line(h.by)).collect()
}

/// "rows", "groups", "sensors".
pub fn hold_out_name(by: HoldOutBy) -> &'static str {
    match by {
        HoldOutBy::Rows => "rows",
        HoldOutBy::Groups => "groups",
        HoldOutBy::Sensors => "sensors",
    }
}

/// "1.2000 mm, 0.50° RMS".
fn scores_text(scores: &Scores) -> String {
    let angle = scores
        .angle_rms_rad
        .map_or_else(String::new, |angle| format!(", {:.2}°", angle.to_degrees()));
    format!("{:.4} mm{angle} RMS", scores.position_rms_mm)
}

/// What sensors differ by among themselves.
pub fn sensors_line(spread: &SensorSpread) -> String {
    let [x, y, z] = spread.position_std_dev_mm();
    let [low, high] = spread.position_interval_mm(SENSOR_INTERVAL);
    let angle = spread
        .angle_rms_rad()
        .map_or_else(String::new, |angle| format!(" and by {:.2}°", angle.to_degrees()));
    format!(
        "sensors: {} differ among themselves by {x:.2}, {y:.2}, {z:.2} mm along x, y, z{angle} ({:.2} mm RMS, 95 % {low:.2} to {high:.2}; {} degrees of freedom)",
        spread.sensors,
        spread.position_rms_mm(),
        spread.degrees_of_freedom
    )
}

/// Which readings were taken for one, and why.
pub fn grouped_line(places: &Places) -> String {
    format!(
        "grouped: {} places found from the data: readings within {:.2} mm, residuals change over {:.0} mm, and readings of a place have {:.0} % of their variance in common",
        with_separators(places.count),
        places.width_mm,
        places.correlation_length_mm,
        100.0 * places.dependence
    )
}

/// The table's head.
pub fn head(selection: &Selection) -> Vec<&'static str> {
    let mut head =
        vec!["order", "orientations", "coefficients ", "RMS, no ridge", "best ridge", "RMS", "max"];
    if has_angles(selection) {
        head.push("angle RMS");
    }
    head.extend(others(selection).map(|by| match by {
        HoldOutBy::Rows => "RMS by row",
        HoldOutBy::Groups => "RMS by group",
        HoldOutBy::Sensors => "RMS by sensor",
    }));
    head
}

/// One line a system, with the ridge that serves it best.
pub fn rows(selection: &Selection) -> Vec<SelectionRow> {
    let mm = |value: f64| format!("{value:.4} mm");
    let row = |i: usize| {
        let row = &selection.table[i];
        let without_ridge = selection.table.iter().find(|other| {
            let (a, b) = (&other.candidate, &row.candidate);
            (a.order, a.directions, a.ridge) == (b.order, b.directions, 0.0)
        });
        let mut cells = vec![
            row.candidate.order.to_string(),
            row.candidate.directions.len().to_string(),
            format!(
                "{}{}",
                with_separators(row.candidate.coefficients()),
                match (row.is_determined, row.is_under_sampled()) {
                    (false, _) => "†",
                    (true, true) => "‡",
                    (true, false) => " ",
                }
            ),
            without_ridge.map_or_else(|| "–".to_owned(), |r| mm(r.deciding().position_rms_mm)),
            ridge_text(row.candidate.ridge).replace("0e0", "0"),
            mm(row.deciding().position_rms_mm),
            format!("{:.3} mm", row.deciding().position_max_mm),
        ];
        if let Some(angle) = row.deciding().angle_rms_rad {
            cells.push(format!("{:.4} °", angle.to_degrees()));
        }
        let scores = others(selection).filter_map(|by| row.held_out_by(by));
        cells.extend(scores.map(|scores| mm(scores.position_rms_mm)));
        SelectionRow { is_chosen: i == selection.best, cells }
    };
    selection.best_of_each_system().into_iter().map(row).collect()
}

/// What a reader of the table has to know.
pub fn notes(selection: &Selection) -> Vec<String> {
    let mut notes = Vec::new();
    if selection.table.iter().any(|row| !row.is_determined) {
        notes.push(
            "† at least as many coefficients as places to fit an orientation to: not to be chosen"
                .to_owned(),
        );
    }
    if selection.table.iter().any(|row| row.is_determined && row.is_under_sampled()) {
        notes.push(
            "‡ most orientations have fewer places than coefficients: not to be chosen".to_owned(),
        );
    }
    if !selection.left_out.is_empty() {
        notes.push(format!(
            "{} joint models have at least as many coefficients as there are rows, and were left out",
            selection.left_out.len()
        ));
    }
    notes
}

/// The hold-outs that do not decide.
fn others(selection: &Selection) -> impl Iterator<Item = HoldOutBy> {
    let hold_outs = selection.hold_outs.iter().map(|h| h.by);
    hold_outs.filter(|by| *by != selection.decided_by)
}

fn has_angles(selection: &Selection) -> bool {
    selection.best().deciding().angle_rms_rad.is_some()
}
