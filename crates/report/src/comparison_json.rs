//! Designs held against each other, as JSON.

use crate::figures_json::{merge, study_json};
use serde_json::{Map, Value, json};
use trackwright_formats::comparison_table::Names;
use trackwright_geometry::pose::pose_to_array;
use trackwright_simulation::ErrorOf;
use trackwright_simulation::comparison::{Comparison, Difference, Row, WorstPose};

/// A comparison as `compare --format json` prints it.
pub fn comparison_json(found: &Comparison, names: &Names) -> Value {
    let room = |number: usize| {
        json!({
            "name": Names::of(&names.rooms, number),
            "file": Names::of(&names.room_files, number),
            "uncertainty_unknown": found.rooms_unknown[number].map(|why| why.to_string()),
        })
    };
    let design = |number: usize| {
        json!({
            "name": Names::of(&names.designs, number),
            "file": Names::of(&names.design_files, number),
        })
    };
    json!({
        "baseline": Names::of(&names.designs, found.baseline),
        "designs": (0..names.designs.len()).map(design).collect::<Vec<_>>(),
        "environments": (0..names.rooms.len()).map(room).collect::<Vec<_>>(),
        "rows": found.rows.iter().map(|row| row_json(row, names)).collect::<Vec<_>>(),
    })
}

fn row_json(row: &Row, names: &Names) -> Value {
    let mut value = json!({
        "design": Names::of(&names.designs, row.design),
        "design_file": Names::of(&names.design_files, row.design),
        "environment": Names::of(&names.rooms, row.room),
        "environment_file": Names::of(&names.room_files, row.room),
        "no_figures": row.measured.as_ref().err().map(ToString::to_string),
    });
    let Ok(measured) = &row.measured else {
        return value;
    };
    merge(&mut value, study_json(&measured.study, None));
    value["worst"]["pose"] = json!(pose_to_array(&measured.worst_pose.crf_from_tool));
    value["worst"]["offsets"] = offsets_json(&measured.worst_pose);
    value["against_baseline"] = match &row.against_baseline {
        None => Value::Null,
        Some(against) => json!({
            "position_mm": differences_json(&against.differences, ErrorOf::Position),
            "angle_deg": differences_json(&against.differences, ErrorOf::Angle),
            "motion_differs": against.motion_differs,
            "requirement_differs": against.requirement_differs,
            "environment_differs": against.room_differs,
        }),
    };
    value
}

/// `x_mm`, `rz_deg`.
fn offsets_json(worst: &WorstPose) -> Value {
    let each = worst.offsets.iter();
    let named = each.map(|(axis, value)| {
        let unit = if axis.starts_with('r') { "deg" } else { "mm" };
        (format!("{axis}_{unit}"), json!(value))
    });
    Value::Object(named.collect())
}

/// Differences of one kind of error, by their summaries.
pub fn differences_json(differences: &[Difference], of: ErrorOf) -> Value {
    let each = differences.iter().filter(|d| d.metric.of == of);
    let named: Map<String, Value> =
        each.map(|d| (d.metric.summary.key().to_owned(), json!(d))).collect();
    Value::Object(named)
}
