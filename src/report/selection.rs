//! A selection in words and as a table: the command line and the editor say the same.

use crate::field::selection::{self, Candidate, Selection};
use crate::study::figures::with_separators;

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
    let plural = if candidate.directions.len() == 1 {
        ""
    } else {
        "s"
    };
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

/// Why the choice is what it is, in one sentence; `by` says what groups rows, if anything does.
pub fn reason(selection: &Selection, by: Option<&str>, folds: usize) -> String {
    let (best, least) = (selection.best(), selection.least());
    let rms = best.deciding().position_rms_mm;
    let how = match (by, selection.groups) {
        (Some(by), Some(count)) => {
            format!(
                "{folds} folds over {} groups by {by}",
                with_separators(count)
            )
        }
        _ => format!("{folds} folds"),
    };
    let is_least_of_all = selection
        .table
        .iter()
        .all(|row| row.deciding().position_rms_mm >= least.deciding().position_rms_mm);
    let why = if selection.best == selection.least {
        match is_least_of_all {
            true => "the least of all".to_owned(),
            false => "the least of all that the rows determine".to_owned(),
        }
    } else {
        format!(
            "the smallest within {:.0} % of the least, {:.4} mm ({})",
            selection::TOLERANCE * 100.0,
            least.deciding().position_rms_mm,
            candidate_text(&least.candidate),
        )
    };
    format!(
        "chosen: {}; {rms:.4} mm RMS held out in {how}, {why}",
        candidate_text(&best.candidate)
    )
}

/// The table's head.
pub fn head(selection: &Selection) -> Vec<&'static str> {
    let mut head = vec![
        "order",
        "orientations",
        "coefficients ",
        "RMS, no ridge",
        "best ridge",
        "RMS",
        "max",
    ];
    if has_angles(selection) {
        head.push("angle RMS");
    }
    if selection.groups.is_some() {
        head.push("RMS by row");
    }
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
                if row.is_determined { " " } else { "†" }
            ),
            without_ridge.map_or_else(|| "–".to_owned(), |r| mm(r.deciding().position_rms_mm)),
            ridge_text(row.candidate.ridge).replace("0e0", "0"),
            mm(row.deciding().position_rms_mm),
            format!("{:.3} mm", row.deciding().position_max_mm),
        ];
        if let Some(angle) = row.deciding().angle_rms_rad {
            cells.push(format!("{:.4} °", angle.to_degrees()));
        }
        if selection.groups.is_some() {
            cells.push(mm(row.by_row.position_rms_mm));
        }
        SelectionRow {
            is_chosen: i == selection.best,
            cells,
        }
    };
    selection
        .best_of_each_system()
        .into_iter()
        .map(row)
        .collect()
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
    if !selection.left_out.is_empty() {
        notes.push(format!(
            "{} joint models have at least as many coefficients as there are rows, and were left out",
            selection.left_out.len()
        ));
    }
    notes
}

fn has_angles(selection: &Selection) -> bool {
    selection.best().by_row.angle_rms_rad.is_some()
}
