//! A manufacturing sheet in words and tables: what a workshop reads, the same everywhere.

use trackwright_result::{Columns, Section, Table, with_separators};
use trackwright_simulation::ErrorOf;
use trackwright_simulation::Metric;
use trackwright_simulation::Verdict;
use trackwright_simulation::coil_statements;
use trackwright_simulation::figures::capitalised;
use trackwright_simulation::requirement::Check;
use trackwright_simulation::tolerance::{
    BuiltBody, BuiltCheck, ManufacturingSheet, NoTolerance, SheetBody, Tolerance, Tolerances,
    stated_decimals,
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
/// room's model alone.
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
        "{what}: the tolerances are those of the room's model alone, and hold as far as it does"
    ));
    words
}

/// The sheet as a result.
pub fn sheet_section(sheet: &ManufacturingSheet) -> Section {
    let mut lines = requirement_words(sheet);
    if !sheet.as_drawn.is_empty() {
        lines.push(format!(
            "by the room's model alone: {}, over {}",
            checks_words(&sheet.as_drawn),
            poses(sheet)
        ));
    }
    let tolerances = match &sheet.no_tolerances {
        Some(reason) => Section::default().with(format!("No tolerances: {reason}")),
        None => tolerances(sheet),
    };
    Section::of_fields(sheet)
        .with_all(lines)
        .with_all(sheet.bodies.iter().map(geometry))
        .with(tolerances)
        .with_all(caution_words(sheet).iter().map(|words| format!("Note: {words}.")))
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

/// A column for each of three components.
fn three<'a, T>(
    table: Columns<'a, T>,
    labels: [&'static str; 3],
    decimals: usize,
    of: impl Fn(&T) -> Option<[f64; 3]>,
) -> Columns<'a, T> {
    // Plus zero makes of -0 a 0.
    (0..3).zip(labels).fold(table, |table, (k, label)| {
        table.number("", label, decimals, |item| of(item).map(|v| v[k] + 0.0))
    })
}

fn geometry(body: &SheetBody) -> Section {
    let sensors = &body.sensors;
    let table = Table::of("", sensors)
        .text("", "sensor", |s| s.name.clone())
        .text("", "kind", |s| s.kind)
        .text("", "coil mm", |s| {
            s.coil.map_or_else(String::new, |c| format!("⌀ {} × {}", c.diameter_mm, c.length_mm))
        });
    let mut table = three(table, ["x mm", "y mm", "z mm"], 3, |s| Some(s.position_in_body_mm));
    if sensors.iter().any(|s| s.position_from_tip_mm.is_some()) {
        table = three(table, ["from tip x", "y", "z"], 3, |s| s.position_from_tip_mm).number(
            "",
            "distance",
            3,
            |s| s.distance_from_tip_mm,
        );
    }
    let with_axis: Vec<_> = sensors.iter().filter_map(|s| Some((s, s.axis?))).collect();
    let about = "Axes of the sensors: unit vectors; the angle from the body's z, and about it from x towards y.";
    let has_rotation = with_axis.iter().any(|(s, _)| s.rotation.is_some());
    let axes = Table::of("", &with_axis).text("", "axis of", |(s, _)| s.name.clone());
    let axes = three(axes, ["x", "y", "z"], 6, |(_, axis)| Some(axis.direction))
        .number("", "from z °", 2, |(_, axis)| axis.polar_deg)
        .number("", "about z °", 2, |(_, axis)| axis.azimuth_deg.map(|deg| deg + 0.0))
        .number("", if has_rotation { "rotation w x y z" } else { "" }, 6, |(s, _)| s.rotation);
    let pairs: Vec<_> = (body.pairs.iter())
        .filter_map(|pair| Some((pair, sensors.get(pair.a)?, sensors.get(pair.b)?)))
        .collect();
    let pairs = Table::of("", &pairs)
        .text("", "between sensors", |(_, a, b)| format!("{} – {}", a.name, b.name))
        .number("", "distance mm", 3, |(pair, ..)| pair.distance_mm)
        .number("", "axes °", 2, |(pair, ..)| pair.angle_deg);
    Section::default()
        .with(format!("{} {:?}", capitalised(role_name(body.role)), body.name))
        .with_all(frame_words(body))
        .with(table.done())
        .with_all((!with_axis.is_empty()).then(|| about.to_owned()))
        .with_all([axes.done(), pairs.done()])
}

/// Whose they are, and the tolerances.
type Named<'a> = (String, &'a Tolerances);

fn stated<'t, 'a>(of: &'static str, rows: &'t [Named<'a>]) -> Columns<'t, Named<'a>> {
    Table::of("", rows)
        .text("", of, |(name, _)| name.clone())
        .number("", "position mm", 0, |(_, of)| tolerance_value(&of.position_mm))
        .number("", "angle °", 0, |(_, of)| tolerance_value(&of.angle_deg))
}

fn tolerances(sheet: &ManufacturingSheet) -> Section {
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
    let together = sheet.bodies.iter().filter_map(|body| {
        Some((format!("{}, every sensor", role_name(body.role)), body.together.as_ref()?))
    });
    let sensors = sheet.bodies.iter().flat_map(|body| body.sensors.iter().map(move |s| (body, s)));
    let alone = sensors.filter_map(|(body, sensor)| {
        Some((format!("{}, {}", role_name(body.role), sensor.name), sensor.alone.as_ref()?))
    });
    let worst = || format!("{WORST_ALLOWED}: {}", checks_words(&sheet.together_worst));
    let (together, alone): (Vec<_>, Vec<_>) = (together.collect(), alone.collect());
    let alone = stated("one sensor alone, one of the two", &alone)
        .text("", "position limited by", |(_, of)| tolerance_words(&of.position_mm))
        .text("", "angle limited by", |(_, of)| tolerance_words(&of.angle_deg));
    Section::default()
        .with_all(lines)
        .with(stated("all sensors of all bodies at once", &together).done())
        .with_all((!sheet.together_worst.is_empty()).then(worst))
        .with(alone.done())
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
