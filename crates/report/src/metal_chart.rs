//! A design's error against how far a metal object is.

use super::plot::{Axis, Chart, Scale, Series, SeriesStyle};
use trackwright_simulation::Scenario;
use trackwright_simulation::metal_distance::MetalDistances;
use trackwright_simulation::metric::Metric;

/// Errors whose ratio is above this are on a logarithmic axis.
const WIDE: f64 = 30.0;

/// The tip's RMS and 95th percentile against the distance from the object to the tip, with the
/// requirement's bound of a length, and where the requirement begins to hold.
pub fn chart(design: &str, object: &str, scenario: &Scenario, found: &MetalDistances) -> Chart {
    let line = |metric: Metric| {
        let points = found.places.iter().filter_map(|place| {
            let figure = place.figures.as_ref().ok()?.get(metric)?;
            Some((place.gap.from_tip_mm, figure.value))
        });
        Series::new(metric.label(), SeriesStyle::Line, points.collect())
    };
    let mut series = vec![line(Metric::TIP_RMS), line(Metric::TIP_P95)];
    let bounds = scenario.requirement.iter().flat_map(|requirement| requirement.bounds());
    for (metric, bound) in bounds.filter(|(metric, _)| metric.unit() == Metric::TIP_RMS.unit()) {
        let name = format!("limit of {}", metric.label());
        series.push(Series::new(name, SeriesStyle::Bound, vec![(0.0, bound)]));
    }
    if let Some(gap) = found.holds_from {
        let at = found.places.iter().find(|place| place.gap == gap);
        let figures = at.and_then(|place| place.figures.as_ref().ok());
        let figure = figures.and_then(|figures| figures.get(Metric::TIP_RMS));
        let point = figure.map(|figure| (gap.from_tip_mm, figure.value));
        let name = format!("holds from {:.0} mm", gap.from_tip_mm);
        series.push(Series::new(name, SeriesStyle::Marked, point.into_iter().collect()));
    }
    // Few decades have too few labels.
    let values = || series.iter().flat_map(|series| &series.points).map(|(_, y_mm)| *y_mm);
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
    let scale = if most > WIDE * least { Scale::Logarithmic } else { Scale::Linear };
    Chart {
        title: format!("{design}: error against the distance of {object}"),
        x: Axis::linear(format!("distance from {object} to the tip, mm")),
        y: Axis { label: "tip error, mm".to_owned(), scale },
        series,
    }
}
