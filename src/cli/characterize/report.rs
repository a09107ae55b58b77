//! The report of a characterisation, for a person and for a program.

use nalgebra::{Dim, Matrix, RawStorage};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use trackwright_calibration::characterisation::{
    Characterisation, PairOutcome, PairProblem, PathReport,
};
use trackwright_calibration::pose_stream::{Clock, ClockFaults};
use trackwright_calibration::rigid_check::Range;
use trackwright_calibration::still_pose::Spread;
use trackwright_geometry::pose::{Pose, pose_to_array};
use trackwright_report::text_table::columns;
use trackwright_simulation::Statistics;
use trackwright_simulation::figures::with_separators;

/// Pairs that are not used, and why.
pub fn rejected(found: &Characterisation) -> impl Iterator<Item = (usize, &PairProblem)> {
    let problems = found.pairs.iter().enumerate();
    problems.filter_map(|(pair, report)| Some((pair, report.outcome.as_ref().err()?)))
}

/// Paths, by the number of their pair.
fn paths(found: &Characterisation) -> impl Iterator<Item = (usize, &PathReport)> {
    let pairs = found.pairs.iter().enumerate();
    pairs.filter_map(|(pair, report)| match &report.outcome {
        Ok(PairOutcome::Path(path)) => Some((pair, path)),
        _ => None,
    })
}

/// What is left out: of what, how many, why.
fn left_out(found: &Characterisation) -> Vec<(&'static str, usize, String)> {
    let mut pairs: BTreeMap<String, usize> = BTreeMap::new();
    for (_, problem) in rejected(found) {
        *pairs.entry(problem.to_string()).or_default() += 1;
    }
    let mut samples: BTreeMap<String, usize> = BTreeMap::new();
    let mut faults = ClockFaults::default();
    let mut too_far = 0;
    for pair in &found.pairs {
        too_far += pair.too_far;
        for (reason, count) in &pair.unusable {
            *samples.entry(reason.to_string()).or_default() += count;
        }
        if let Ok(PairOutcome::Still(still)) = &pair.outcome {
            let outliers = still.sensors.iter().map(|(_, pose)| pose.outliers);
            let all = outliers.sum::<usize>() + still.reference.outliers;
            *samples.entry("far from the others of its still pose".to_owned()).or_default() += all;
        }
    }
    for (_, path) in paths(found) {
        faults.add(&path.faults);
    }
    let of_clocks = [
        ("has no time", faults.without_time),
        ("its time is that of the one before", faults.repeated),
        ("out of order", faults.out_of_order),
        ("beyond a clock's jump back", faults.beyond_jump),
    ];
    let samples = samples.into_iter().map(|(reason, count)| (count, reason));
    let of_clocks = of_clocks.map(|(reason, count)| (count, reason.to_owned()));
    pairs
        .into_iter()
        .map(|(reason, count)| ("pairs", count, reason))
        .chain(samples.chain(of_clocks).map(|(n, r)| ("samples", n, r)))
        .chain([("readings", too_far, "too far from where it should be".to_owned())])
        .filter(|(_, count, _)| *count > 0)
        .collect()
}

/// Errors of a sensor's readings: mm, degrees.
fn errors(found: &Characterisation, sensor: usize) -> Option<[Statistics; 2]> {
    let of = |value: fn(&Spread) -> f64| {
        let readings = found.readings.iter().filter(|r| r.sensor == sensor);
        Statistics::of(&mut readings.map(|r| value(&r.error)).collect::<Vec<_>>())
    };
    Some([of(|e| e.position_mm)?, of(|e| e.angle_rad.to_degrees())?])
}

/// What rows and columns of the covariances are of, for each frame: a small rotation vector in the
/// axes of the frame that is led to, by which the rotation is turned, and a shift.
const PARAMETERS: [&str; 6] =
    ["rotation_x_rad", "rotation_y_rad", "rotation_z_rad", "x_mm", "y_mm", "z_mm"];

fn rows<R: Dim, C: Dim, S: RawStorage<f64, R, C>>(matrix: &Matrix<f64, R, C, S>) -> Vec<Vec<f64>> {
    let row = |i| (0..matrix.ncols()).map(|j| matrix[(i, j)]).collect();
    (0..matrix.nrows()).map(row).collect()
}

/// Of all frames together: what they are off by is not independent.
fn covariance(found: &Characterisation) -> Value {
    let names = found.sensors.iter().map(String::as_str);
    let frames: Vec<&str> = std::iter::once("tracker_from_reference").chain(names).collect();
    json!({
        "frames": frames,
        "parameters": PARAMETERS,
        "matrix": rows(&found.hand_eye.covariance),
    })
}

pub fn as_json(found: &Characterisation) -> Value {
    let of_errors = |s: &Statistics| json!({"rms": s.rms(), "median": s.median(), "p95": s.p95(), "max": s.max()});
    let spread =
        |s: &Spread| json!({"position_mm": s.position_mm, "angle_deg": s.angle_rad.to_degrees()});
    let sensors: Vec<Value> = found
        .sensors
        .iter()
        .enumerate()
        .map(|(sensor, name)| {
            let [mm, deg] = match errors(found, sensor) {
                Some(both) => both.map(|s| of_errors(&s)),
                None => [Value::Null, Value::Null],
            };
            json!({
                "name": name,
                "readings": found.readings.iter().filter(|r| r.sensor == sensor).count(),
                "position_mm": mm,
                "angle_deg": deg,
                "body_from_sensor": pose_to_array(&found.hand_eye.body_from_sensor[sensor]),
                "std_error": spread(&found.sensor_error(sensor)),
                "covariance": rows(&found.hand_eye.sensor_covariance(sensor)),
                "scale": spread(&found.hand_eye.scales[sensor]),
            })
        })
        .collect();
    let range = |r: &Range, unit: f64| json!({"mean": r.mean * unit, "std": r.std * unit, "min": r.min * unit, "max": r.max * unit});
    let distances = found.distances.iter().map(|distance| {
        let mut value = range(&distance.check.distance_mm, 1.0);
        value["a"] = json!(found.sensors[distance.sensors[0]]);
        value["b"] = json!(found.sensors[distance.sensors[1]]);
        value["moments"] = json!(distance.check.moments);
        value["angle_deg"] = range(&distance.check.angle_rad, 1.0_f64.to_degrees());
        value
    });
    let left_out = left_out(found);
    json!({
        "pairs": found.pairs.len(),
        "rejected": rejected(found).count(),
        "readings": found.readings.len(),
        "held_out": found.held_out.len(),
        "left_out": left_out
            .iter()
            .map(|(of, count, reason)| json!({"of": of, "count": count, "reason": reason}))
            .collect::<Vec<_>>(),
        "sensors": sensors,
        "tracker_from_reference": {
            "pose": pose_to_array(&found.hand_eye.tracker_from_reference),
            "std_error": spread(&found.reference_error()),
            "covariance": rows(&found.hand_eye.reference_covariance()),
        },
        "covariance": covariance(found),
        "poses": found.hand_eye.poses,
        "effective": found.hand_eye.effective_size.effective,
        "degrees_of_freedom": found.hand_eye.effective_size.freedom,
        "recordings": found.recordings.as_ref().map(|errors| json!({
            "groups": errors.groups,
            "tracker_from_reference": spread(&errors.reference),
            "sensors": errors.sensors.iter().map(spread).collect::<Vec<_>>(),
        })),
        "turn_deg": {
            "largest": found.hand_eye.motion.largest_rad.to_degrees(),
            "least": found.hand_eye.motion.least_turn_rad.to_degrees(),
        },
        "distances": distances.collect::<Vec<_>>(),
        "paths": paths(found)
            .map(|(pair, path)| json!({
                "pair": pair,
                "offset_s": path.offset_s,
                "std_error_s": path.offset_std_error_s,
                "effective": path.offset_effective_size.effective,
                "degrees_of_freedom": path.offset_effective_size.freedom,
                "offset_by_speeds_s": path.alignment.offset_s,
                "correlation": path.alignment.correlation,
                "drift_s": path.alignment.drift_s,
                "clocks": path.clocks.map(|clock| clock_name(&clock)),
                "before": spread(&path.before),
                "after": spread(&path.after),
            }))
            .collect::<Vec<_>>(),
    })
}

fn clock_name(clock: &Clock) -> String {
    match clock {
        Clock::Times => "times".to_owned(),
        Clock::Frames { ticks_per_s } => format!("frames at {ticks_per_s} Hz"),
    }
}

/// What stands before the colon of all names, where that distinguishes them: ports are long.
fn short_names(names: &[String]) -> Vec<String> {
    let short: Vec<String> =
        names.iter().map(|name| name.split(':').next().unwrap_or(name).trim().to_owned()).collect();
    let distinct: std::collections::BTreeSet<&String> = short.iter().collect();
    if distinct.len() == names.len() { short } else { names.to_vec() }
}

pub fn as_text(found: &Characterisation) -> String {
    let path_count = paths(found).count();
    let rejected_count = rejected(found).count();
    let names = short_names(&found.sensors);
    let mut lines = vec![
        format!(
            "pairs: {}, of which still poses: {}, paths: {path_count}, not used: {rejected_count}; readings: {}",
            with_separators(found.pairs.len()),
            with_separators(found.pairs.len() - path_count - rejected_count),
            with_separators(found.readings.len()),
        ),
        format!(
            "turned by up to {:.1}° from the first pose, {:.1}° RMS about the axis turned about least",
            found.hand_eye.motion.largest_rad.to_degrees(),
            found.hand_eye.motion.least_turn_rad.to_degrees(),
        ),
    ];
    for (of, count, reason) in left_out(found) {
        lines.push(format!("left out: {} {of}: {reason}", with_separators(count)));
    }
    lines.push(String::new());
    lines.extend(sensor_table(found, &names));
    lines.push(String::new());
    lines.extend(place_table(found, &names));
    if !found.distances.is_empty() {
        lines.push(String::new());
        lines.extend(distance_table(found, &names));
    }
    if path_count > 0 {
        lines.push(String::new());
        lines.extend(path_table(found));
    }
    lines.join("\n")
}

fn sensor_table(found: &Characterisation, names: &[String]) -> Vec<String> {
    let mut rows = vec![
        [
            "error", "readings", "mm: rms", "median", "p95", "max", "deg: rms", "median", "p95",
            "max",
        ]
        .map(str::to_owned)
        .to_vec(),
    ];
    for (sensor, name) in names.iter().enumerate() {
        let count = found.readings.iter().filter(|r| r.sensor == sensor).count();
        let mut row = vec![name.clone(), with_separators(count)];
        for s in errors(found, sensor).iter().flatten() {
            row.extend([s.rms(), s.median(), s.p95(), s.max()].map(|v| format!("{v:.2}")));
        }
        rows.push(row);
    }
    columns(&rows, 1)
}

fn place_table(found: &Characterisation, names: &[String]) -> Vec<String> {
    let hand_eye = &found.hand_eye;
    let head = ["place", "x", "y", "z mm", "qw", "qx", "qy", "qz", "± mm", "± deg"];
    let row = |name: String, pose: &Pose, error: Spread| {
        let numbers = pose_to_array(pose);
        let digits = |k: usize| if k < 3 { 2 } else { 4 };
        let cells = numbers.iter().enumerate().map(|(k, v)| format!("{v:.*}", digits(k)));
        let errors =
            [format!("{:.2}", error.position_mm), format!("{:.2}", error.angle_rad.to_degrees())];
        std::iter::once(name).chain(cells).chain(errors).collect::<Vec<_>>()
    };
    let mut rows = vec![
        head.map(str::to_owned).to_vec(),
        row(
            "tracker from reference".to_owned(),
            &hand_eye.tracker_from_reference,
            found.reference_error(),
        ),
    ];
    for (sensor, name) in names.iter().enumerate() {
        rows.push(row(
            format!("body from {name}"),
            &hand_eye.body_from_sensor[sensor],
            found.sensor_error(sensor),
        ));
    }
    let mut lines = columns(&rows, 1);
    let size = &hand_eye.effective_size;
    lines.push(format!(
        "±: standard error along the worst direction, of the reference in the middle of the readings; {} poses are \
         equivalent to {:.1} independent ones",
        with_separators(hand_eye.poses),
        size.effective
    ));
    lines.push(match (size.student_975(), &found.recordings) {
        (_, Some(errors)) => format!(
            "and, where that is larger, by what {} recordings differ by, each left out in turn",
            errors.groups
        ),
        (Some(student), None) => format!(
            "95 % intervals are ± {student:.2} standard errors; distortion that all poses have in common is in no figure"
        ),
        (None, None) => "too few are independent for an interval: ± is a lower bound".to_owned(),
    });
    lines
}

fn distance_table(found: &Characterisation, names: &[String]) -> Vec<String> {
    let head =
        ["distance", "moments", "mm: mean", "std", "min", "max", "deg: mean", "std", "min", "max"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for distance in &found.distances {
        let [a, b] = distance.sensors.map(|sensor| names[sensor].as_str());
        let mut row = vec![format!("{a} to {b}"), with_separators(distance.check.moments)];
        let (mm, rad) = (&distance.check.distance_mm, &distance.check.angle_rad);
        let degrees = |v: f64| v.to_degrees();
        row.extend([mm.mean, mm.std, mm.min, mm.max].map(|v| format!("{v:.2}")));
        row.extend([rad.mean, rad.std, rad.min, rad.max].map(|v| format!("{:.2}", degrees(v))));
        rows.push(row);
    }
    columns(&rows, 1)
}

fn path_table(found: &Characterisation) -> Vec<String> {
    let head = [
        "path",
        "offset s",
        "±",
        "drift",
        "correlation",
        "mm: before",
        "after",
        "deg: before",
        "after",
    ];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    let mut clocks = Vec::new();
    for (pair, path) in paths(found) {
        let drift = path.alignment.drift_s;
        rows.push(vec![
            format!("pair {pair}"),
            format!("{:.4}", path.offset_s),
            match path.offset_effective_size.freedom {
                Some(_) => format!("{:.4}", path.offset_std_error_s),
                // Too short to determine how far its seconds depend on each other.
                None => format!("≥ {:.4}", path.offset_std_error_s),
            },
            drift.map_or_else(|| "–".to_owned(), |s| format!("{s:.3}")),
            format!("{:.3}", path.alignment.correlation),
            format!("{:.2}", path.before.position_mm),
            format!("{:.2}", path.after.position_mm),
            format!("{:.2}", path.before.angle_rad.to_degrees()),
            format!("{:.2}", path.after.angle_rad.to_degrees()),
        ]);
        let [em, reference] = path.clocks.map(|clock| clock_name(&clock));
        let line = format!("clocks: EM tracker by {em}, reference by {reference}");
        if !clocks.contains(&line) {
            clocks.push(line);
        }
    }
    let mut lines = columns(&rows, 1);
    lines.extend(clocks);
    lines.push(
        "offset: what the reference's time is ahead, each from its first good sample; drift: of the second half \
         against the first"
            .to_owned(),
    );
    lines
}
