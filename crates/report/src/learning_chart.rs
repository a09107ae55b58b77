//! What each kind of model leaves of held-out measurements, against how many there are.

use super::plot::{Axis, Chart, Scale, Series, SeriesStyle};
use trackwright_calibration::learning_curve::LearningPoint;

/// A line a kind, both axes logarithmic; `data` names the measurements.
pub fn chart(data: &str, points: &[LearningPoint]) -> Chart {
    let mut series: Vec<Series> = Vec::new();
    for point in points {
        for kind in &point.choice.kinds {
            let at = (point.rows as f64, kind.deciding().overall.position_rms_mm);
            match series.iter_mut().find(|s| s.name == kind.label()) {
                Some(line) => line.points.push(at),
                None => series.push(Series::new(kind.label(), SeriesStyle::Line, vec![at])),
            }
        }
    }
    series.sort_by(|a, b| a.name.cmp(&b.name));
    let axis = |label: &str| Axis { label: label.to_owned(), scale: Scale::Logarithmic };
    Chart {
        title: format!("{data}: residual of held-out measurements by kind of model"),
        x: axis("measurements, four fifths of them fitted"),
        y: axis("position RMS, mm"),
        series,
    }
}
