//! A characterisation as a result, and what lifts its refusals.

use super::super::hand_eye::HandEyeError;
use super::super::pose_stream::{Clock, ClockFaults};
use super::super::rigid_check::Range;
use super::super::still_pose::Spread;
use super::{Characterisation, CharacterisationError, PairOutcome, PairProblem, PathReport};
use nalgebra::{Dim, Matrix, RawStorage};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use trackwright_geometry::pose::{Pose, pose_to_array};
use trackwright_result::{Columns, Refusal, Remedy, Section, Table, data, with_separators};
use trackwright_simulation::Statistics;

/// What rows and columns of the covariances are of, for each frame: a small rotation vector in the
/// axes of the frame that is led to, by which the rotation is turned, and a shift.
const PARAMETERS: [&str; 6] =
    ["rotation_x_rad", "rotation_y_rad", "rotation_z_rad", "x_mm", "y_mm", "z_mm"];

/// What was left out: of what, how many, why.
struct LeftOut {
    of: &'static str,
    count: usize,
    reason: String,
}

/// A sensor with the errors of its readings: mm, degrees.
struct SensorErrors {
    index: usize,
    readings: usize,
    errors: Option<[Statistics; 2]>,
}

/// Where something is.
struct NamedPose {
    name: String,
    pose: Pose,
    std_error: Spread,
}

impl Characterisation {
    /// Pairs that are not used, and why.
    pub fn rejected(&self) -> impl Iterator<Item = (usize, &PairProblem)> {
        let problems = self.pairs.iter().enumerate();
        problems.filter_map(|(pair, report)| Some((pair, report.outcome.as_ref().err()?)))
    }

    /// All that was found, but for the readings.
    pub fn section(&self) -> Section {
        let names = short_names(&self.sensors);
        let paths: Vec<_> = self.paths().collect();
        let rejected = self.rejected().count();
        let hand_eye = &self.hand_eye;
        let (pairs, readings) = (self.pairs.len(), self.readings.len());
        let motion = &hand_eye.motion;
        let [largest_deg, least_deg] =
            [motion.largest_rad, motion.least_turn_rad].map(f64::to_degrees);
        let left_out = self.left_out();
        let head = Section::of([
            data("pairs", pairs),
            data("rejected", rejected),
            data("readings", readings),
            data("held_out", self.held_out.len()),
            data("turn_deg", BTreeMap::from([("largest", largest_deg), ("least", least_deg)])),
            data("tracker_from_reference.pose", pose_to_array(&hand_eye.tracker_from_reference)),
            data("tracker_from_reference.std_error", self.reference_error()),
            data("tracker_from_reference.covariance", rows(&hand_eye.reference_covariance())),
            data("covariance.frames", self.frames()),
            data("covariance.parameters", PARAMETERS),
            data("covariance.matrix", rows(&hand_eye.covariance)),
            data("poses", hand_eye.poses),
            data("effective", hand_eye.effective_size.effective),
            data("degrees_of_freedom", hand_eye.effective_size.freedom),
            data("recordings", &self.recordings),
        ])
        .with(format!(
            "pairs: {}, of which still poses: {}, paths: {}, not used: {rejected}; readings: {}",
            with_separators(pairs),
            with_separators(pairs - paths.len() - rejected),
            paths.len(),
            with_separators(readings),
        ))
        .with(format!(
            "turned by up to {largest_deg:.1}° from the first pose, {least_deg:.1}° RMS about the axis turned about least"
        ))
        .with_all(left_out.iter().map(|LeftOut { of, count, reason }| {
            format!("left out: {} {of}: {reason}", with_separators(*count))
        }))
        .with_all([Table::of("left_out", &left_out)
            .data("of", |left| left.of)
            .data("count", |left| left.count)
            .data("reason", |left| left.reason.clone())
            .done()]);
        let tables = [
            self.sensor_table(&names),
            self.place_table(&names),
            self.distance_table(&names),
            path_table(&paths),
        ];
        head.with_all(tables)
    }

    /// Paths, by the number of their pair.
    fn paths(&self) -> impl Iterator<Item = (usize, &PathReport)> {
        let pairs = self.pairs.iter().enumerate();
        pairs.filter_map(|(pair, report)| match &report.outcome {
            Ok(PairOutcome::Path(path)) => Some((pair, path)),
            _ => None,
        })
    }

    fn left_out(&self) -> Vec<LeftOut> {
        let mut pairs: BTreeMap<String, usize> = BTreeMap::new();
        for (_, problem) in self.rejected() {
            *pairs.entry(problem.to_string()).or_default() += 1;
        }
        let mut samples: BTreeMap<String, usize> = BTreeMap::new();
        let mut faults = ClockFaults::default();
        let mut too_far = 0;
        for pair in &self.pairs {
            too_far += pair.too_far;
            for (reason, count) in &pair.unusable {
                *samples.entry(reason.to_string()).or_default() += count;
            }
            if let Ok(PairOutcome::Still(still)) = &pair.outcome {
                let outliers = still.sensors.iter().map(|(_, pose)| pose.outliers);
                let all = outliers.sum::<usize>() + still.reference.outliers;
                *samples.entry("far from the others of its still pose".to_owned()).or_default() +=
                    all;
            }
        }
        for (_, path) in self.paths() {
            faults.add(&path.faults);
        }
        let of_clocks = [
            ("has no time", faults.without_time),
            ("its time is that of the one before", faults.repeated),
            ("out of order", faults.out_of_order),
            ("beyond a clock's jump back", faults.beyond_jump),
        ];
        let of_clocks = of_clocks.map(|(reason, count)| (reason.to_owned(), count));
        let too_far = [("too far from where it should be".to_owned(), too_far)];
        let of = |of| move |(reason, count)| LeftOut { of, count, reason };
        pairs
            .into_iter()
            .map(of("pairs"))
            .chain(samples.into_iter().chain(of_clocks).map(of("samples")))
            .chain(too_far.into_iter().map(of("readings")))
            .filter(|left| left.count > 0)
            .collect()
    }

    /// Those whose errors the covariance is of, together: they are not independent.
    fn frames(&self) -> Vec<&str> {
        let names = self.sensors.iter().map(String::as_str);
        std::iter::once("tracker_from_reference").chain(names).collect()
    }

    fn errors(&self, index: usize) -> SensorErrors {
        let of = |value: fn(&Spread) -> f64| {
            let readings = self.readings.iter().filter(|r| r.sensor == index);
            Statistics::of(&mut readings.map(|r| value(&r.error)).collect::<Vec<_>>())
        };
        SensorErrors {
            index,
            readings: self.readings.iter().filter(|r| r.sensor == index).count(),
            errors: of(|e| e.position_mm).zip(of(|e| e.angle_rad.to_degrees())).map(Into::into),
        }
    }

    fn sensor_table(&self, names: &[String]) -> Section {
        let sensors: Vec<SensorErrors> =
            (0..self.sensors.len()).map(|sensor| self.errors(sensor)).collect();
        let hand_eye = &self.hand_eye;
        let mut table = Table::of("sensors", &sensors)
            .text("", "error", |s| names[s.index].clone())
            .data("name", |s| self.sensors[s.index].clone())
            .number("readings", "readings", 0, |s| s.readings);
        for (kind, [key, rms]) in
            [["position_mm", "mm: rms"], ["angle_deg", "deg: rms"]].into_iter().enumerate()
        {
            let labels = [rms, "median", "p95", "max"];
            let names = ["rms", "median", "p95", "max"];
            for (k, (name, label)) in names.into_iter().zip(labels).enumerate() {
                table = table.number(format!("{key}.{name}"), label, 2, move |s| {
                    let errors = &s.errors.as_ref()?[kind];
                    Some([errors.rms(), errors.median(), errors.p95(), errors.max()][k])
                });
            }
        }
        let table = table
            .data("body_from_sensor", |s| pose_to_array(&hand_eye.body_from_sensor[s.index]))
            .data("std_error", |s| self.sensor_error(s.index))
            .data("covariance", |s| rows(&hand_eye.sensor_covariance(s.index)))
            .data("scale", |s| hand_eye.scales[s.index]);
        Section::default().with(table.done())
    }

    fn place_table(&self, names: &[String]) -> Section {
        let hand_eye = &self.hand_eye;
        let reference = NamedPose {
            name: "tracker from reference".to_owned(),
            pose: hand_eye.tracker_from_reference,
            std_error: self.reference_error(),
        };
        let sensors = names.iter().enumerate().map(|(sensor, name)| NamedPose {
            name: format!("body from {name}"),
            pose: hand_eye.body_from_sensor[sensor],
            std_error: self.sensor_error(sensor),
        });
        let places: Vec<NamedPose> = std::iter::once(reference).chain(sensors).collect();
        let mut table = Table::of("", &places).text("", "place", |place| place.name.clone());
        for (k, label) in ["x", "y", "z mm", "qw", "qx", "qy", "qz"].into_iter().enumerate() {
            let decimals = if k < 3 { 2 } else { 4 };
            table = table.number("", label, decimals, move |place| pose_to_array(&place.pose)[k]);
        }
        let table = table
            .number("", "± mm", 2, |place| place.std_error.position_mm)
            .number("", "± deg", 2, |place| place.std_error.angle_rad.to_degrees())
            .done();
        let size = &hand_eye.effective_size;
        Section::default()
            .with(table)
            .with(format!(
                "±: standard error along the worst direction, of the reference in the middle of the readings; {} \
                 poses are equivalent to {:.1} independent ones",
                with_separators(hand_eye.poses),
                size.effective
            ))
            .with(match (size.student_975(), &self.recordings) {
                (_, Some(errors)) => format!(
                    "and, where that is larger, by what {} recordings differ by, each left out in turn",
                    errors.groups
                ),
                (Some(student), None) => format!(
                    "95 % intervals are ± {student:.2} standard errors; distortion that all poses have in common is in \
                     no figure"
                ),
                (None, None) => {
                    "too few are independent for an interval: ± is a lower bound".to_owned()
                }
            })
    }

    fn distance_table(&self, names: &[String]) -> Section {
        let distances = &self.distances;
        let table = Table::of("distances", distances)
            .text("", "distance", |d| {
                let [a, b] = d.sensors.map(|sensor| names[sensor].as_str());
                format!("{a} to {b}")
            })
            .data("a", |d| self.sensors[d.sensors[0]].clone())
            .data("b", |d| self.sensors[d.sensors[1]].clone())
            .number("moments", "moments", 0, |d| d.check.moments);
        let table = range_columns(table, ["", "mm: mean"], |d| (d.check.distance_mm, 1.0));
        let degrees = 1.0_f64.to_degrees();
        let table =
            range_columns(table, ["angle_deg.", "deg: mean"], |d| (d.check.angle_rad, degrees));
        Section::default().with(table.done())
    }
}

/// Mean, deviation and ends of a range, times a unit.
fn range_columns<'a, T>(
    mut table: Columns<'a, T>,
    [key, mean]: [&str; 2],
    range: impl Fn(&T) -> (Range, f64),
) -> Columns<'a, T> {
    let labels = [mean, "std", "min", "max"];
    for (k, (name, label)) in ["mean", "std", "min", "max"].into_iter().zip(labels).enumerate() {
        table = table.number(format!("{key}{name}"), label.to_owned(), 2, |item| {
            let (range, unit) = range(item);
            [range.mean, range.std, range.min, range.max][k] * unit
        });
    }
    table
}

fn path_table(paths: &[(usize, &PathReport)]) -> Section {
    let clocks: BTreeSet<String> = paths
        .iter()
        .map(|(_, path)| {
            let [em, reference] = path.clocks.map(|clock| clock_name(&clock));
            format!("clocks: EM tracker by {em}, reference by {reference}")
        })
        .collect();
    let table = Table::of("paths", paths)
        .text("", "path", |(pair, _)| format!("pair {pair}"))
        .data("pair", |(pair, _)| *pair)
        .number("offset_s", "offset s", 4, |(_, path)| path.offset_s)
        .data("std_error_s", |(_, path)| path.offset_std_error_s)
        .number("", "±", 4, |(_, path)| match path.offset_effective_size.freedom {
            Some(_) => format!("{:.4}", path.offset_std_error_s),
            // Too short to determine how far its seconds depend on each other.
            None => format!("≥ {:.4}", path.offset_std_error_s),
        })
        .data("effective", |(_, path)| path.offset_effective_size.effective)
        .data("degrees_of_freedom", |(_, path)| path.offset_effective_size.freedom)
        .data("offset_by_speeds_s", |(_, path)| path.alignment.offset_s)
        .number("drift_s", "drift", 3, |(_, path)| path.alignment.drift_s)
        .number("correlation", "correlation", 3, |(_, path)| path.alignment.correlation)
        .data("clocks", |(_, path)| path.clocks.map(|clock| clock_name(&clock)))
        .number("before.position_mm", "mm: before", 2, |(_, path)| path.before.position_mm)
        .number("after.position_mm", "after", 2, |(_, path)| path.after.position_mm)
        .number("before.angle_deg", "deg: before", 2, |(_, path)| {
            path.before.angle_rad.to_degrees()
        })
        .number("after.angle_deg", "after", 2, |(_, path)| path.after.angle_rad.to_degrees())
        .done();
    let offset = "offset: what the reference's time is ahead, each from its first good sample; drift: of the second \
                  half against the first";
    let lines = clocks.into_iter().chain((!paths.is_empty()).then(|| offset.to_owned()));
    Section::default().with(table).with_all(lines)
}

fn rows<R: Dim, C: Dim, S: RawStorage<f64, R, C>>(
    matrix: &Matrix<f64, R, C, S>,
) -> impl Serialize + use<R, C, S> {
    let row = |i| (0..matrix.ncols()).map(|j| matrix[(i, j)]).collect();
    (0..matrix.nrows()).map(row).collect::<Vec<Vec<f64>>>()
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
    let distinct: BTreeSet<&String> = short.iter().collect();
    if distinct.len() == names.len() { short } else { names.to_vec() }
}

impl Refusal for CharacterisationError {
    fn remedy(&self) -> Option<Remedy> {
        match self {
            Self::HandEye(
                HandEyeError::TooFewPoses { needed, .. }
                | HandEyeError::SensorTooFew { needed, .. },
            ) if *needed > 3 => Some(Remedy::new(
                "min_poses",
                "a still recording counts as one pose and a path as one a second, and {} accepts fewer, 3 at least",
            )),
            Self::HandEye(error) => error.remedy(),
            Self::AllTooFar { .. } => {
                Some(Remedy::new("max_error_mm", "{} and --max-error-deg accept more"))
            }
            _ => None,
        }
    }
}
