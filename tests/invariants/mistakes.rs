//! Mistakes of the person who makes a table, in all of it or a part, on one side or both: what is harmful is
//! refused or warned of, and named.
//!
//! A mistake is harmful where the room that is fitted to the table predicts errors that differ by more than 1 mm
//! or 1° from those of the right table's room, at more than a few poses of it, or where a design has another verdict.

use crate::rooms::tracker::{Random, Room};
use crate::rooms::{five_dof, measurement, others};
use crate::support::data::own;
use crate::support::studies::built_in;
use nalgebra::{Quaternion, Unit, Vector3};
use std::collections::BTreeMap;
use std::sync::Arc;
use trackwright_calibration::doubts::{PairedDoubts, PoseFrame, Suspicion};
use trackwright_calibration::room_fit::{RoomOrder, RoomTable, fit_room};
use trackwright_calibration::room_model::RoomModel;
use trackwright_field::OutsidePolicy;
use trackwright_field::fit::{FitSettings, fit};
use trackwright_field::samples::{MapKind, Measurement, MeasurementSet};
use trackwright_geometry::directions::DirectionSet;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::{exp_vector, log_quaternion};
use trackwright_project::Files;
use trackwright_simulation::{CancelToken, Mode, Scenario, Verdict, study};
use trackwright_task::Task;

const HARMFUL_MM: f64 = 1.0;
const HARMFUL_DEG: f64 = 1.0;

/// Where a silent mistake changes predictions by more than this, the verdict of a built-in design is looked at too.
const VERDICT_MM: f64 = 0.1;
const VERDICT_DEG: f64 = 0.1;
const DESIGN: &str = "pointer-on-head";

/// Part of the poses where more may change: a single row moves the prediction at itself by a part of its own error.
const FEW: f64 = 0.05;

/// Part of the named mistakes whose kind and side have to be right.
const RIGHTLY_NAMED: f64 = 0.95;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Ideal,
    Measured,
    Both,
}

/// The rows that are wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Extent {
    Whole,
    /// The first half, as where two files are joined.
    Half,
    EveryFourth,
    /// A tenth in one piece.
    Tenth,
    EveryHundredth,
    One,
}

const EXTENTS: [Extent; 6] = [
    Extent::Whole,
    Extent::Half,
    Extent::EveryFourth,
    Extent::Tenth,
    Extent::EveryHundredth,
    Extent::One,
];

impl Extent {
    fn has(self, row: usize, rows: usize) -> bool {
        match self {
            Self::Whole => true,
            Self::Half => row < rows / 2,
            Self::EveryFourth => row % 4 == 1,
            Self::Tenth => (rows / 3..rows / 3 + rows / 10).contains(&row),
            Self::EveryHundredth => row % 100 == 7,
            Self::One => row == rows / 3,
        }
    }
}

type Change = fn(&Pose) -> Pose;

/// What is done to rows.
#[derive(Clone, Copy)]
enum Made {
    /// Poses of a side.
    Poses(Change),
    /// Rows, whose sides it exchanges or makes the same.
    Rows(fn(&Measurement) -> Measurement),
    /// All of them have the numbers of one row.
    Repeated,
    /// One side is this many rows late.
    Late,
}

struct Kind {
    name: &'static str,
    made: Made,
    /// Words of a sentence that names the mistake.
    words: &'static [&'static str],
    /// Whether the numbers show which side is wrong.
    has_side: bool,
}

fn at(pose: &Pose, place: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Pose {
    pose_from_parts(place(pose.translation.vector), pose.rotation)
}

fn numbers(pose: &Pose, order: impl Fn([f64; 4]) -> [f64; 4]) -> Pose {
    let q = pose.rotation.quaternion();
    let [w, x, y, z] = order([q.w, q.i, q.j, q.k]);
    pose_from_parts(pose.translation.vector, Unit::new_unchecked(Quaternion::new(w, x, y, z)))
}

fn turned(pose: &Pose, vector_deg: [f64; 3]) -> Pose {
    let turn = exp_vector(&Vector3::from(vector_deg).map(f64::to_radians));
    pose_from_parts(pose.translation.vector, pose.rotation * turn)
}

fn along_axis(pose: &Pose, by_mm: f64) -> Pose {
    at(pose, |p| p + pose.rotation * Vector3::z() * by_mm)
}

fn exchanged(m: &Measurement) -> Measurement {
    Measurement {
        tracker_from_ideal: m.tracker_from_measured,
        tracker_from_measured: m.tracker_from_ideal,
    }
}

fn kinds() -> Vec<Kind> {
    let kind = |name, made, words, has_side| Kind { name, made, words, has_side };
    let of = |change: Change| Made::Poses(change);
    vec![
        kind("scale 0.98", of(|p| at(p, |v| v * 0.98)), &["times as far from the origin"], false),
        kind("scale 0.9", of(|p| at(p, |v| v * 0.9)), &["times as far from the origin"], false),
        kind("scale 1.3", of(|p| at(p, |v| v * 1.3)), &["times as far from the origin"], false),
        kind("5 mm along the axis", of(|p| along_axis(p, 5.0)), &["along the sensor's"], false),
        kind("10 mm along the axis", of(|p| along_axis(p, 10.0)), &["along the sensor's"], false),
        kind("50 mm along the axis", of(|p| along_axis(p, 50.0)), &["along the sensor's"], false),
        kind("30 mm aside", of(|p| at(p, |v| v + Vector3::x() * 30.0)), &["translation"], false),
        kind(
            "x reversed",
            of(|p| at(p, |v| Vector3::new(-v.x, v.y, v.z))),
            &["x is ideal −x"],
            false,
        ),
        kind(
            "z reversed",
            of(|p| at(p, |v| Vector3::new(v.x, v.y, -v.z))),
            &["z is ideal −z"],
            false,
        ),
        kind(
            "x and y exchanged",
            of(|p| at(p, |v| Vector3::new(v.y, v.x, v.z))),
            &["x is ideal y"],
            false,
        ),
        kind("axis reversed", of(|p| turned(p, [180.0, 0.0, 0.0])), &["is reversed"], false),
        kind(
            "order x, y, z, w",
            of(|p| numbers(p, |[w, x, y, z]| [x, y, z, w])),
            &["in the order x, y, z, w"],
            true,
        ),
        kind("inverted", of(|p| numbers(p, |[w, x, y, z]| [w, -x, -y, -z])), &["inverted"], false),
        kind(
            "axis off by 8°",
            of(|p| turned(p, [8.0, 0.0, 0.0])),
            &["turned by 8", "turned by 7."],
            false,
        ),
        kind("metres", of(|p| at(p, |v| v * 1e-3)), &["metres"], true),
        kind("a thousand times", of(|p| at(p, |v| v * 1e3)), &["metres", "micrometres"], true),
        kind("inches", of(|p| at(p, |v| v / 25.4)), &["inches"], true),
        kind("centimetres", of(|p| at(p, |v| v / 10.0)), &["centimetres"], true),
        kind("zeros", of(|_| Pose::identity()), &["are zero", "is zero"], true),
        kind(
            "degrees for radians",
            of(|p| {
                let vector = log_quaternion(&p.rotation).map(f64::to_degrees);
                pose_from_parts(p.translation.vector, exp_vector(&vector))
            }),
            &["angles in degrees"],
            false,
        ),
        kind(
            "another frame",
            of(|p| {
                let turn = exp_vector(&Vector3::new(0.4, 0.9, -0.3));
                pose_from_parts(Vector3::new(120.0, -40.0, -1500.0), turn) * p
            }),
            &["two frames", "translation"],
            false,
        ),
        kind(
            "a copy",
            Made::Rows(|m| Measurement { tracker_from_measured: m.tracker_from_ideal, ..*m }),
            &["the same numbers on both sides"],
            false,
        ),
        kind("sides exchanged", Made::Rows(exchanged), &["sides exchanged"], false),
        kind("one row many times", Made::Repeated, &["same numbers as another row"], false),
        kind("a row late", Made::Late, &["rows shifted", "row k"], false),
    ]
}

/// The rows with a mistake in them.
fn wrong(rows: &[Measurement], made: Made, side: Side, extent: Extent) -> Vec<Measurement> {
    let count = rows.len();
    let row = |k: usize| {
        let m = &rows[k];
        if !extent.has(k, count) {
            return *m;
        }
        let changed = |of: &dyn Fn(&Measurement) -> Measurement| {
            let new = of(m);
            Measurement {
                tracker_from_ideal: match side {
                    Side::Measured => m.tracker_from_ideal,
                    _ => new.tracker_from_ideal,
                },
                tracker_from_measured: match side {
                    Side::Ideal => m.tracker_from_measured,
                    _ => new.tracker_from_measured,
                },
            }
        };
        match made {
            Made::Poses(change) => changed(&|m| Measurement {
                tracker_from_ideal: change(&m.tracker_from_ideal),
                tracker_from_measured: change(&m.tracker_from_measured),
            }),
            Made::Rows(change) => change(m),
            Made::Repeated => rows[count / 3],
            Made::Late => changed(&|_| rows[k.saturating_sub(1)]),
        }
    };
    (0..count).map(row).collect()
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    Refused,
    Warned,
    Silent,
}

struct Case {
    kind: &'static str,
    side: Side,
    extent: Extent,
    outcome: Outcome,
    is_harmful: bool,
    changed: (f64, f64),
    is_named: bool,
    found: Vec<String>,
}

/// Predicted positions in mm and rotations in rad at the poses of a table.
fn predictions(rows: &MeasurementSet, poses: &[Measurement]) -> Option<Vec<Pose>> {
    let set = rows.samples(MapKind::Distortion);
    let fitted = fit(&set, &FitSettings::new(2, DirectionSet::Fourteen), None).ok()?;
    let each =
        poses.iter().map(|m| fitted.model.distort(&m.tracker_from_ideal, OutsidePolicy::Clamp).0);
    Some(each.collect())
}

/// The verdict of a built-in design in the room that is fitted to a table.
fn verdict(rows: &MeasurementSet) -> Option<Verdict> {
    let order = RoomOrder {
        name: "room",
        table: RoomTable { name: "room.csv", samples: &rows.samples(MapKind::Distortion) },
        held_out: None,
        model: &RoomModel::Bernstein { is_symmetric: false },
        settings: FitSettings::new(2, DirectionSet::Fourteen),
        bounds: None,
        volume: None,
        jitter: None,
        with_support: false,
        sensors: None,
        registration: None,
    };
    let environment = fit_room(&order, |_| Task::default()).ok()?.environment;
    let scenario = Scenario { environment: Arc::new(environment), ..built_in(DESIGN) };
    let found = study(&scenario, &Mode::Motion, &CancelToken::default(), None).ok()?;
    Some(found.figures.requirement?.verdict)
}

fn apart(a: &Pose, b: &Pose) -> (f64, f64) {
    let z = Vector3::z();
    (
        (a.translation.vector - b.translation.vector).norm(),
        (a.rotation * z).angle(&(b.rotation * z)).to_degrees(),
    )
}

fn suspicions(set: &MeasurementSet) -> Vec<Suspicion> {
    PairedDoubts::of(&set.measurements, set.content, PoseFrame::Tracker)
}

/// Whether this mistake leaves no trace, or is none.
fn is_invisible(kind: &str, side: Side, extent: Extent) -> bool {
    match (kind, side, extent) {
        ("x reversed" | "z reversed" | "x and y exchanged" | "inverted" | "axis reversed", Side::Both, _)
        | ("sides exchanged", _, Extent::Whole)
        // A tracker may as well be there, and read so.
        | ("another frame" | "scale 0.98" | "scale 0.9" | "scale 1.3", Side::Both, _)
        | ("5 mm along the axis" | "10 mm along the axis" | "50 mm along the axis", Side::Both, _)
        | ("30 mm aside" | "axis off by 8°" | "degrees for radians", Side::Both, _)
        | ("a row late", Side::Both, _) => true,
        _ => false,
    }
}

fn cases(set: &MeasurementSet) -> Vec<Case> {
    let right = predictions(set, &set.measurements).unwrap();
    let right_verdict = verdict(set);
    assert!(right_verdict.is_some());
    let mut all = Vec::new();
    for kind in kinds() {
        for side in [Side::Ideal, Side::Measured, Side::Both] {
            let has_sides = matches!(kind.made, Made::Poses(_) | Made::Late);
            if !has_sides && side != Side::Both {
                continue;
            }
            for extent in EXTENTS {
                let is_rest = matches!(kind.made, Made::Late)
                    && !matches!(extent, Extent::Whole | Extent::Half | Extent::Tenth);
                if is_rest || has_sides && is_invisible(kind.name, side, extent) {
                    continue;
                }
                if kind.name == "sides exchanged" && extent == Extent::Whole {
                    continue;
                }
                if matches!(kind.made, Made::Repeated) && extent == Extent::One {
                    continue;
                }
                let measurements = wrong(&set.measurements, kind.made, side, extent);
                let table = MeasurementSet { measurements, content: set.content };
                let found = suspicions(&table);
                let outcome = match found.iter().any(Suspicion::is_beyond_doubt) {
                    true => Outcome::Refused,
                    false if found.is_empty() => Outcome::Silent,
                    false => Outcome::Warned,
                };
                let changed = match predictions(&table, &set.measurements) {
                    None => (f64::INFINITY, f64::INFINITY),
                    Some(wrong) => {
                        let each: Vec<(f64, f64)> =
                            right.iter().zip(&wrong).map(|(a, b)| apart(a, b)).collect();
                        let beyond = |value: fn(&(f64, f64)) -> f64| {
                            let mut all: Vec<f64> = each.iter().map(value).collect();
                            all.sort_by(f64::total_cmp);
                            all[((1.0 - FEW) * all.len() as f64) as usize]
                        };
                        (beyond(|c| c.0), beyond(|c| c.1))
                    }
                };
                let found: Vec<String> = found.iter().map(ToString::to_string).collect();
                let other = match side {
                    Side::Ideal => "the measured side",
                    Side::Measured => "the ideal side",
                    Side::Both => "\0",
                };
                // A single row shows that it is wrong, and not always what is.
                let of_one: &[&str] = match extent {
                    Extent::One => &["1 row has more than", "no order, sign or frame"],
                    _ => &[],
                };
                let is_named = found.first().is_some_and(|text| {
                    kind.words.iter().chain(of_one).any(|word| text.contains(word))
                        && !(kind.has_side && text.contains(other))
                });
                all.push(Case {
                    kind: kind.name,
                    side,
                    extent,
                    outcome,
                    is_harmful: {
                        let is_large = !(changed.0 <= HARMFUL_MM && changed.1 <= HARMFUL_DEG);
                        let is_some = !(changed.0 <= VERDICT_MM && changed.1 <= VERDICT_DEG);
                        let is_looked_at = outcome == Outcome::Silent && !is_large && is_some;
                        is_large || is_looked_at && verdict(&table) != right_verdict
                    },
                    changed,
                    is_named,
                    found,
                });
            }
        }
    }
    all
}

/// Counts of the cases of a kind.
#[derive(Clone, Copy, Default)]
struct Counts {
    cases: usize,
    harmful: usize,
    refused: usize,
    warned: usize,
    silent: usize,
    harmful_silent: usize,
    named: usize,
}

impl Counts {
    fn add(&mut self, case: &Case) {
        let is = |outcome| usize::from(case.outcome == outcome);
        self.cases += 1;
        self.harmful += usize::from(case.is_harmful);
        self.refused += is(Outcome::Refused);
        self.warned += is(Outcome::Warned);
        self.silent += is(Outcome::Silent);
        self.harmful_silent += usize::from(case.is_harmful && case.outcome == Outcome::Silent);
        self.named += usize::from(case.is_named);
    }

    fn row(&self, kind: &str) -> String {
        let Self { cases, harmful, refused, warned, silent, harmful_silent, named } = self;
        format!(
            "| {kind} | {cases} | {harmful} | {refused} | {warned} | {silent} | {harmful_silent} | {named} |"
        )
    }
}

fn rooms() -> Vec<(&'static str, MeasurementSet)> {
    let own = Files::default().read_measurements(&own("room-a/room-a-fit.csv")).unwrap();
    // Wide coils, outliers, and errors of some millimetres.
    let (room, mut random) = (Room::new(105, true), Random::new(5));
    let each = (0..1000).filter_map(|_| {
        let sensor = (room.position(&mut random), random.direction());
        Some(measurement(&sensor, &room.measure(&sensor, &mut random)?))
    });
    vec![("room A", own), ("a simulated room", five_dof(each))]
}

/// With `--nocapture` it prints the table of docs/developing/mistakes-in-tables.md.
#[test]
#[expect(clippy::print_stderr, reason = "the counts are for the docs")]
fn harmful_mistakes_are_seen_and_named() {
    let rooms = rooms();
    let all: Vec<(&str, Vec<Case>)> = std::thread::scope(|scope| {
        let each: Vec<_> =
            rooms.iter().map(|(name, set)| (*name, scope.spawn(|| cases(set)))).collect();
        each.into_iter().map(|(name, cases)| (name, cases.join().unwrap())).collect()
    });
    let mut by_kind: BTreeMap<&str, Counts> = BTreeMap::new();
    let mut total = Counts::default();
    let mut wrong = Vec::new();
    for (room, case) in all.iter().flat_map(|(room, cases)| cases.iter().map(move |c| (room, c))) {
        by_kind.entry(case.kind).or_default().add(case);
        total.add(case);
        let Case { kind, side, extent, changed: (mm, deg), found, .. } = case;
        let is_silent = case.outcome == Outcome::Silent;
        if is_silent && case.is_harmful || !is_silent && !case.is_named {
            let title = format!("{room}: {kind}, {side:?}, {extent:?}, {mm:.2} mm {deg:.2}°");
            wrong.push(format!("{title}: {found:?}"));
        }
    }
    let wrong = wrong.join("\n");
    eprintln!(
        "| mistake | cases | harmful | refused | warned | silent | harmful, silent | named |"
    );
    for (kind, counts) in by_kind.iter().chain([(&"all", &total)]) {
        eprintln!("{}", counts.row(kind));
    }
    eprintln!("{wrong}");
    assert!(total.cases >= 600, "{}", total.cases);
    assert!(total.harmful_silent == 0, "{} silent\n{wrong}", total.harmful_silent);
    let named = total.named as f64 / (total.refused + total.warned) as f64;
    assert!(named >= RIGHTLY_NAMED, "{named:.3} named\n{wrong}");
}

#[test]
fn simulated_rooms_have_no_mistakes() {
    for seed in 0..24 {
        let (room, mut random) = (Room::new(seed, seed % 2 == 1), Random::new(seed + 1));
        let each = (0..1000).filter_map(|_| {
            let sensor = (room.position(&mut random), random.direction());
            Some(measurement(&sensor, &room.measure(&sensor, &mut random)?))
        });
        let found = suspicions(&five_dof(each));
        let is_outlier = |s: &Suspicion| matches!(s, Suspicion::Outliers { .. });
        assert!(found.iter().all(is_outlier), "room {seed}: {found:?}");
    }
}

#[test]
fn rooms_of_others_have_no_mistakes() {
    for seed in 0..36 {
        let made = others::made(seed);
        let mut found = suspicions(&made.table.measurements());
        // Rows of a path that are late are a mistake of these rooms' own.
        found.retain(|s| !(made.names[2] == "lag" && matches!(s, Suspicion::Lag { .. })));
        assert_eq!(found, [], "room {seed}, {:?}", made.names);
    }
}
