//! A manufacturing sheet in words and tables: what a workshop reads, the same everywhere.

use crate::text_table;
use std::iter;
use trackwright_result::with_separators;
use trackwright_simulation::ErrorOf;
use trackwright_simulation::Metric;
use trackwright_simulation::Verdict;
use trackwright_simulation::coil_statements;
use trackwright_simulation::figures::capitalised;
use trackwright_simulation::requirement::Check;
use trackwright_simulation::tolerance::{
    BuiltBody, BuiltCheck, ManufacturingSheet, NoTolerance, SheetBody, SheetSensor, Tolerance,
    Tolerances, stated_decimals,
};

/// Of all deviations that are allowed at once, those nearest to missing the requirement.
pub const WORST_ALLOWED: &str = "Worst allowed combination";

/// Further from an axis than this a direction is not described as along it.
const ALONG_DEG: f64 = 30.0;

/// Below this a point is at the origin, mm: a tenth of what coordinates are printed with.
const AT_ORIGIN_MM: f64 = 1e-4;

/// What a body is called.
pub fn role_name(role: BuiltBody) -> &'static str {
    match role {
        BuiltBody::Tool => "tool",
        BuiltBody::Crf => "CRF",
    }
}

/// The body's frame: origin and axes, a sentence each.
pub fn frame_words(body: &SheetBody) -> Vec<String> {
    let mut words = vec![
        "Body frame: right-handed, in mm; the frame of the body's file and of its mesh.".to_owned(),
    ];
    let tip = body.tip_in_body_mm;
    let is_at_origin = tip.is_some_and(|tip| length(tip) < AT_ORIGIN_MM);
    words.push(match (tip, body.role) {
        (Some(_), _) if is_at_origin => "Origin: the tip.".to_owned(),
        (Some([x, y, z]), _) => format!("Origin: the tip is at ({x:.3}, {y:.3}, {z:.3})."),
        (None, BuiltBody::Tool) => {
            "Origin: the body states no tip, so that its origin is judged as the tip.".to_owned()
        }
        (None, BuiltBody::Crf) => {
            "Origin: where the body's file has it; a CRF has no tip.".to_owned()
        }
    });
    if let Some(centroid) = body.centroid_in_body_mm {
        let from = tip.unwrap_or_default();
        let to = std::array::from_fn(|k| centroid[k] - from[k]);
        let [x, y, z] = centroid;
        let start = match tip {
            Some(_) => "tip",
            None => "origin",
        };
        words.push(format!(
            "Axes: the middle of the sensors is at ({x:.3}, {y:.3}, {z:.3}){}.",
            along(to).map_or_else(String::new, |(axis, off_deg)| format!(
                ", {:.3} mm from the {start} in the direction {axis}, {off_deg:.1}° off it",
                length(to)
            ))
        ));
    }
    words
}

/// The axis of the frame that a vector is nearest to, and the angle between them in degrees.
fn along(vector: [f64; 3]) -> Option<(&'static str, f64)> {
    let names = [["+x", "−x"], ["+y", "−y"], ["+z", "−z"]];
    let k = (0..3).max_by(|&a, &b| vector[a].abs().total_cmp(&vector[b].abs()))?;
    let across = vector[(k + 1) % 3].hypot(vector[(k + 2) % 3]);
    let off_deg = across.atan2(vector[k].abs()).to_degrees();
    let is_along = length(vector) > AT_ORIGIN_MM && off_deg < ALONG_DEG;
    is_along.then(|| (names[k][usize::from(vector[k] < 0.0)], off_deg))
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

/// What a bound is called in a sheet.
fn bound_label(metric: Metric) -> String {
    format!("{} {}", metric.of.key(), metric.summary.label())
}

/// The unit as it follows a number.
fn unit_after(metric: Metric) -> &'static str {
    match metric.of {
        ErrorOf::Position => " mm",
        ErrorOf::Angle => "°",
    }
}

/// A figure against its bound: "position RMS 0.980 of 1 mm".
fn check_words(check: &Check) -> String {
    let (name, unit) = (bound_label(check.metric), unit_after(check.metric));
    format!("{name} {:.4} of {}{unit}", check.value, check.limit)
}

/// Several of them, as a list.
pub(crate) fn checks_words(checks: &[Check]) -> String {
    let words: Vec<String> = checks.iter().map(check_words).collect();
    words.join(", ")
}

/// The number that is stated, or a dash.
pub fn tolerance_value(tolerance: &Tolerance) -> String {
    match tolerance.within().map(|within| within.value) {
        Some(value) => format!("{value:.0$}", stated_decimals(value)),
        None => "–".to_owned(),
    }
}

/// What limits a tolerance, or why there is none.
pub fn tolerance_words(tolerance: &Tolerance) -> String {
    match tolerance {
        Tolerance::None { none: NoTolerance::NoAxis } => "a marker has no axis".to_owned(),
        Tolerance::None { none: NoTolerance::NothingLeft } => {
            "the requirement leaves less than 0.001".to_owned()
        }
        Tolerance::Within(within) => match &within.limited_by {
            Some(check) => check_words(check),
            None => "no bound reached so far; not looked further".to_owned(),
        },
    }
}

/// What a check by drawn tools found, a sentence each.
pub fn built_check_words(check: &BuiltCheck) -> Vec<String> {
    let draws = with_separators(check.draws);
    let found = match check.holds() {
        true => format!("all {draws} drawn tools meet the requirement"),
        false => {
            format!("{} of {draws} drawn tools meet the requirement", with_separators(check.met))
        }
    };
    vec![
        format!(
            "Check: {found}; every sensor off at random within what is stated for all at once, seed {}",
            check.seed
        ),
        format!("  largest of any of them: {}", checks_words(&check.worst)),
    ]
}

/// The requirement as drawn as far as the room decides it, a sentence each; tolerances are found in the
/// room's own field.
pub fn requirement_words(sheet: &ManufacturingSheet) -> Vec<String> {
    let Some(requirement) = &sheet.requirement else {
        return Vec::new();
    };
    let each = requirement.bounds.iter();
    let each = each.map(|bound| format!("{} {}", bound_label(bound.metric), bound.words(4, " ")));
    let mut words = vec![format!("as drawn: {}", each.collect::<Vec<_>>().join("; "))];
    let what = match requirement.verdict {
        Verdict::Met => return words,
        Verdict::CannotTell => "it is not decided whether the requirement is met as drawn",
        Verdict::Missed => "the requirement is missed as drawn",
    };
    words.push(format!(
        "{what}: the tolerances hold in the room's own field, and only as far as that does"
    ));
    words
}

/// The sheet as text.
pub fn sheet_text(sheet: &ManufacturingSheet) -> String {
    let mut lines = requirement_words(sheet);
    if !sheet.as_drawn.is_empty() {
        lines.push(format!(
            "in the room's own field: {}, over {}",
            checks_words(&sheet.as_drawn),
            poses(sheet)
        ));
    }
    for body in &sheet.bodies {
        lines.push(String::new());
        lines.extend(geometry(body));
    }
    lines.push(String::new());
    match &sheet.no_tolerances {
        Some(reason) => lines.push(format!("No tolerances: {reason}")),
        None => lines.extend(tolerances(sheet)),
    }
    lines.extend(caution_words(sheet).iter().map(|words| format!("Note: {words}.")));
    lines.join("\n")
}

/// What has to be known before anything is built: rotations that sensors do not determine, or barely,
/// and coils that do not fit; each a sentence without a full stop.
pub fn caution_words(sheet: &ManufacturingSheet) -> Vec<String> {
    let mut words: Vec<String> = sheet.free_axis.iter().map(|free| free.statement()).collect();
    if let Some(weak) = &sheet.barely_determined {
        words.push(weak.statement());
    } else if sheet.poorly_determined {
        words.push("a rotation is poorly determined: the least error decides it".to_owned());
    }
    words.extend(coil_statements(&sheet.coils));
    words
}

fn poses(sheet: &ManufacturingSheet) -> String {
    match sheet.study_poses {
        1 => "the design's one pose".to_owned(),
        poses => format!("{} poses of its range of motion", with_separators(poses)),
    }
}

fn geometry(body: &SheetBody) -> Vec<String> {
    let mut lines = vec![format!("{} {:?}", capitalised(role_name(body.role)), body.name)];
    lines.extend(frame_words(body));
    let three = |v: [f64; 3], decimals: usize| v.map(|c| format!("{:.decimals$}", c + 0.0));
    let empty = || [const { String::new() }; 3];
    let has_tip = body.sensors.iter().any(|s| s.position_from_tip_mm.is_some());
    let mut head = vec!["sensor", "kind", "coil mm", "x mm", "y mm", "z mm"];
    if has_tip {
        head.extend(["from tip x", "y", "z", "distance"]);
    }
    let rows = body.sensors.iter().map(|s| {
        let coil =
            s.coil.map_or_else(String::new, |c| format!("⌀ {} × {}", c.diameter_mm, c.length_mm));
        let mut row = vec![s.name.clone(), s.kind.to_owned(), coil];
        row.extend(three(s.position_in_body_mm, 3));
        if has_tip {
            row.extend(s.position_from_tip_mm.map_or_else(empty, |v| three(v, 3)));
            row.extend(s.distance_from_tip_mm.map(|d| format!("{d:.3}")));
        }
        row
    });
    lines.extend(table(&head, rows));
    let with_axis: Vec<&SheetSensor> = body.sensors.iter().filter(|s| s.axis.is_some()).collect();
    if !with_axis.is_empty() {
        lines.push(
            "Axes of the sensors: unit vectors; the angle from the body's z, and about it from x towards y."
                .to_owned(),
        );
        let head = ["axis of", "x", "y", "z", "from z °", "about z °", "rotation w x y z"];
        let rows = with_axis.into_iter().filter_map(|s| {
            let axis = s.axis?;
            let mut row = vec![s.name.clone()];
            row.extend(three(axis.direction, 6));
            row.push(format!("{:.2}", axis.polar_deg));
            let azimuth = axis.azimuth_deg.map(|a| format!("{:.2}", a + 0.0));
            row.push(azimuth.unwrap_or_else(|| "–".to_owned()));
            let rotation = s.rotation.map(|q| q.map(|c| format!("{c:.6}")).join(" "));
            row.push(rotation.unwrap_or_default());
            Some(row)
        });
        lines.extend(table(&head, rows));
    }
    if !body.pairs.is_empty() {
        let head = ["between sensors", "distance mm", "axes °"];
        let rows = body.pairs.iter().filter_map(|pair| {
            let (a, b) = (body.sensors.get(pair.a)?, body.sensors.get(pair.b)?);
            let angle = pair.angle_deg.map(|deg| format!("{deg:.2}"));
            Some(vec![
                format!("{} – {}", a.name, b.name),
                format!("{:.3}", pair.distance_mm),
                angle.unwrap_or_else(|| "–".to_owned()),
            ])
        });
        lines.extend(table(&head, rows));
    }
    lines
}

fn tolerances(sheet: &ManufacturingSheet) -> Vec<String> {
    let mut lines = vec![
        "Tolerances: how far a sensor may be from where it is drawn, in any direction, and how far its \
         axis may be tilted to any side (a 6-DOF sensor turned about any axis), before the requirement is missed."
            .to_owned(),
    ];
    if sheet.poses < sheet.study_poses {
        lines.push(format!(
            "Looked for at {} of the study's {} poses, evenly spread over them.",
            with_separators(sheet.poses),
            with_separators(sheet.study_poses)
        ));
    }
    let cells = |tolerances: &Tolerances| -> Vec<String> {
        let (p, a) = (&tolerances.position_mm, &tolerances.angle_deg);
        vec![tolerance_value(p), tolerance_value(a), tolerance_words(p), tolerance_words(a)]
    };
    let head = |what| [what, "position mm", "angle °", "position limited by", "angle limited by"];
    let rows = sheet.bodies.iter().filter_map(|body| {
        let together = body.together.as_ref()?;
        let mut row = vec![format!("{}, every sensor", role_name(body.role))];
        row.extend(cells(together).into_iter().take(2));
        Some(row)
    });
    lines.extend(table(&head("all sensors of all bodies at once")[..3], rows));
    if !sheet.together_worst.is_empty() {
        lines.push(format!("  {WORST_ALLOWED}: {}", checks_words(&sheet.together_worst)));
    }
    let sensors = sheet.bodies.iter().flat_map(|body| body.sensors.iter().map(move |s| (body, s)));
    let rows = sensors.filter_map(|(body, sensor)| {
        let mut row = vec![format!("{}, {}", role_name(body.role), sensor.name)];
        row.extend(cells(sensor.alone.as_ref()?));
        Some(row)
    });
    lines.extend(table(&head("one sensor alone, one of the two"), rows));
    lines
}

/// Columns of numbers to the right, of words to the left.
fn table(head: &[&str], rows: impl Iterator<Item = Vec<String>>) -> Vec<String> {
    let head = head.iter().map(|&cell| cell.to_owned()).collect();
    let rows: Vec<_> = iter::once(head).chain(rows).collect();
    let is_number = |c: &String| c.is_empty() || c == "–" || c.parse::<f64>().is_ok();
    let is_right = |k: usize| rows.iter().skip(1).filter_map(|row| row.get(k)).all(is_number);
    text_table::lines(&rows, is_right).into_iter().map(|line| format!("  {line}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_words_name_tip_and_sensor_direction() {
        let body = |tip, centroid| SheetBody {
            role: BuiltBody::Tool,
            name: "t".into(),
            tip_in_body_mm: tip,
            centroid_in_body_mm: Some(centroid),
            sensors: Vec::new(),
            pairs: Vec::new(),
            together: None,
        };
        let words = frame_words(&body(Some([0.0; 3]), [0.0, 2.0, -100.0])).join(" ");
        assert!(words.contains("Origin: the tip."), "{words}");
        assert!(
            words.contains("100.020 mm from the tip in the direction −z, 1.1° off it"),
            "{words}"
        );
        let words = frame_words(&body(Some([1.0, 0.0, 0.0]), [1.0, 50.0, 50.0])).join(" ");
        assert!(words.contains("the tip is at (1.000, 0.000, 0.000)"), "{words}");
        assert!(!words.contains("direction"), "{words}");
        let words = frame_words(&body(None, [0.0; 3])).join(" ");
        assert!(words.contains("states no tip"), "{words}");
    }
}
