//! The built tool against its design, pose by pose: length of the measured tip error, of the predicted
//! one, and of the difference of the two vectors.

use super::plot::{Axis, Chart, Series, SeriesStyle};
use trackwright_calibration::agreement::{Agreement, AgreementRow};

/// Poses beyond which points hide each other: of more, the worst of neighbours stands for them.
const MOST_POINTS: usize = 300;

/// Three series over the number of the pose; `design` names what was built. Only poses that count are
/// drawn.
pub fn chart(design: &str, found: &Agreement) -> Chart {
    let used: Vec<(usize, &AgreementRow)> =
        found.rows.iter().enumerate().filter(|(_, row)| row.is_used).collect();
    let each = used.len().div_ceil(MOST_POINTS).max(1);
    let chosen: Vec<(usize, &AgreementRow)> = used
        .chunks(each)
        .filter_map(|some| {
            let length = |(_, row): &&(usize, &AgreementRow)| row.measured_mm.norm();
            some.iter().max_by(|a, b| length(a).total_cmp(&length(b))).copied()
        })
        .collect();
    let series = |name: &str, style, length: fn(&AgreementRow) -> f64| {
        let points = chosen.iter().map(|(index, row)| (*index as f64, length(row)));
        Series::new(name, style, points.collect())
    };
    let label = match each {
        1 => "recorded pose".to_owned(),
        _ => format!("recorded pose; of each {each} the one with the largest measured error"),
    };
    Chart {
        title: format!("{design}: tip error of the built tool"),
        x: Axis::linear(label),
        y: Axis::linear("tip error, mm"),
        series: vec![
            series("measured", SeriesStyle::Points, |r| r.measured_mm.norm()),
            series("predicted", SeriesStyle::Points, |r| r.predicted_mm.norm()),
            series("difference", SeriesStyle::Line, |r| r.residual_mm().norm()),
        ],
    }
}
