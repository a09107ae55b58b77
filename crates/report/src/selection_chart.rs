//! The paper's Fig. 3: what is left of held-out measurements against order and angular resolution.

use super::plot::{Axis, Chart, Series, SeriesStyle};
use super::selection::{candidate_text, hold_out_name};
use trackwright_field::selection::{HoldOutBy, Scored, Selection};
use trackwright_geometry::directions::DirectionSet;

/// Highest RMS that is drawn, in multiples of that without correction: a model that doubles the
/// error needs no finer comparison, and some are a thousandfold off.
const TOP: f64 = 2.0;

/// A line for each set of orientations without ridge, one for the chosen set with its best ridges,
/// and the choice; `data` names the measurements.
pub fn chart(data: &str, selection: &Selection) -> Chart {
    let best = selection.best();
    let uncorrected = selection.table.iter().find(|row| row.candidate.order == 0);
    let reference = uncorrected.unwrap_or(best).deciding().position_rms_mm;
    let top_mm = TOP * reference.max(best.deciding().position_rms_mm);
    // A line ends where it leaves the chart: what comes after cannot be joined to it.
    let line = |rows: &mut dyn Iterator<Item = &Scored>| -> Vec<(f64, f64)> {
        rows.map(point).take_while(|&(_, rms)| rms <= top_mm).collect()
    };
    let mut series = Vec::new();
    let mut push = |name: String, points: Vec<(f64, f64)>, style| {
        if points.len() > 1 || style == SeriesStyle::Marked {
            series.push(Series::new(name, style, points));
        }
    };
    let is_of = |row: &Scored, set: DirectionSet| {
        row.candidate.order == 0 || row.candidate.directions == set
    };
    for set in DirectionSet::ALL {
        let mut plain =
            selection.table.iter().filter(|row| row.candidate.ridge == 0.0 && is_of(row, set));
        push(set_text(set), line(&mut plain), SeriesStyle::Line);
    }
    let set = best.candidate.directions;
    if best.candidate.ridge > 0.0 {
        let mut ridged = selection
            .best_of_each_system()
            .into_iter()
            .map(|i| &selection.table[i])
            .filter(|row| is_of(row, set));
        push(format!("{}, best ridge", set_text(set)), line(&mut ridged), SeriesStyle::Line);
    }
    push(candidate_text(&best.candidate), vec![point(best)], SeriesStyle::Marked);
    Chart {
        title: format!(
            "{data}: residual on held-out {}",
            match selection.decided_by {
                HoldOutBy::Rows => "measurements",
                by => hold_out_name(by),
            }
        ),
        x: Axis::linear("order of the polynomials; 0 is no correction"),
        y: Axis::linear(format!("position RMS, mm (lines end above {top_mm:.1})")),
        series,
    }
}

fn point(row: &Scored) -> (f64, f64) {
    (row.candidate.order as f64, row.deciding().position_rms_mm)
}

fn set_text(set: DirectionSet) -> String {
    match set.len() {
        1 => "1 orientation".to_owned(),
        count => format!("{count} orientations"),
    }
}
