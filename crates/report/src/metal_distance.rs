//! Distances of a metal object, as a result.

use serde_json::json;
use trackwright_result::{Section, Table, data};
use trackwright_simulation::metal_distance::{MetalDistances, MetalPlace};
use trackwright_simulation::{Metric, Scenario};

/// From how far away an object lets a design meet its requirement; `name` is the object's.
pub fn section(name: &str, scenario: &Scenario, found: &MetalDistances) -> Section {
    let d = found.direction;
    let has_requirement = scenario.requirement.is_some();
    let verdict = match (has_requirement, found.holds_from) {
        (false, _) => "the design has no requirement that could hold".to_owned(),
        (true, None) => "the requirement does not hold at any of these distances".to_owned(),
        (true, Some(gap)) if gap.moved_mm == 0.0 => {
            format!("the requirement holds with {name} where it is and farther away")
        }
        (true, Some(gap)) => format!(
            "the requirement holds from {:.0} mm away, {:.0} mm from {name} to the tip",
            gap.moved_mm, gap.from_tip_mm
        ),
    };
    let mut table = Table::of("", &found.places)
        .number("", "moved, mm", 1, |place| place.gap.moved_mm)
        .number("", "from the tip, mm", 1, |place| place.gap.from_tip_mm);
    for (k, metric) in shown_metrics(scenario).into_iter().enumerate() {
        let label = format!("{}, {}", metric.label(), metric.unit().trim());
        table = table.number("", label, 3, |place| match &place.figures {
            Ok(figures) => json!(figures.get(metric).map(|figure| figure.value)),
            Err(why) => json!(if k == 0 { why } else { "" }),
        });
    }
    let requirement = if has_requirement { "requirement" } else { "" };
    let table = table.number("", requirement, 0, |place| match (place.holds, &place.figures) {
        (Some(true), Ok(_)) => "holds",
        (Some(false), Ok(_)) => "fails",
        _ => "",
    });
    Section::of([
        data("object", name),
        data("direction", [d.x, d.y, d.z]),
        data("holds_from", found.holds_from),
        data("places", found.places.iter().map(place_data).collect::<Vec<_>>()),
    ])
    .with(format!("{name} moved along ({:.3}, {:.3}, {:.3}) of the tracker frame", d.x, d.y, d.z))
    .with(table.done())
    .with(verdict)
}

/// The figures that a requirement bounds, else those of position and angle.
fn shown_metrics(scenario: &Scenario) -> Vec<Metric> {
    let bounded: Vec<_> = scenario.requirement.iter().flat_map(|r| r.bounds()).collect();
    match bounded.is_empty() {
        true => vec![Metric::TIP_RMS, Metric::ANGLE_RMS],
        false => bounded.into_iter().map(|(metric, _)| metric).collect(),
    }
}

fn place_data(place: &MetalPlace) -> Section {
    let figures = match &place.figures {
        Ok(figures) => figures.rows(),
        Err(why) => vec![data("problem", why)],
    };
    Section::of_fields(&place.gap).with(data("holds", place.holds)).with_all(figures)
}
