//! Distances of a metal object, as a result.

use serde_json::json;
use trackwright_result::{Section, Table, data};
use trackwright_simulation::metal_distance::{MetalDistances, MetalPlace};
use trackwright_simulation::{Metric, Scenario, Verdict};

/// From how far away an object lets a design meet its requirement; `name` is the object's.
pub fn section(name: &str, scenario: &Scenario, found: &MetalDistances) -> Section {
    let d = found.direction;
    let has_requirement = scenario.requirement.is_some();
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
    let table = table.number("", requirement, 0, |place| place.verdict.map_or("", Verdict::label));
    Section::of([
        data("object", name),
        data("direction", [d.x, d.y, d.z]),
        data("holds_from", found.holds_from),
        data("places", found.places.iter().map(place_data).collect::<Vec<_>>()),
    ])
    .with(format!("{name} moved along ({:.3}, {:.3}, {:.3}) of the tracker frame", d.x, d.y, d.z))
    .with(table.done())
    .with(found.statement(name, has_requirement))
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
    Section::of_fields(&place.gap).with(data("verdict", place.verdict)).with_all(figures)
}
