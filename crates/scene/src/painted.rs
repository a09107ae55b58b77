//! What range the colours of placements span.

use trackwright_simulation::PlacementOutcome;
use trackwright_simulation::placement::Placement;
use trackwright_simulation::statistics::percentile;

/// The least and the greatest value that has a colour of its own: the end is `wanted_mm`, else the
/// 95th percentile, as one bad end of a shaft must not take all colours. `None` without any value.
pub fn placement_range(found: &PlacementOutcome, wanted_mm: Option<f64>) -> Option<[f64; 2]> {
    let [min, max] = found.range_mm()?;
    let end = wanted_mm.or_else(|| upper(found)).unwrap_or(max);
    // A range that ends below all values begins at zero, as every other.
    Some([if min < end { min } else { 0.0 }, end])
}

fn upper(found: &PlacementOutcome) -> Option<f64> {
    let mut values: Vec<f64> = found.places.iter().filter_map(Placement::shown_mm).collect();
    (!values.is_empty()).then(|| percentile(&mut values, 0.95))
}
