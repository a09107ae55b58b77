//! Mistakes about units, frames, rows and quaternions are seen in every table, and none where there is
//! none.

use crate::rooms::tracker::{Random, Room};
use crate::support::data::{own, third_party};
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};
use std::path::{Path, PathBuf};
use trackwright_calibration::calibration_object;
use trackwright_calibration::characterisation::{
    CharacterisationSettings, RecordedPair, characterise,
};
use trackwright_calibration::doubts::{self, Mistake as M, PairedDoubts, PoseFrame, Suspicion};
use trackwright_field::OutsidePolicy;
use trackwright_field::samples::{Measurement, MeasurementContent, MeasurementSet};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::rotation::{exp_vector, log_quaternion};
use trackwright_project::Files;
use trackwright_task::Task;

/// Thirty poses at least, so that a mistake can be distinguished from the field.
type Table = (String, MeasurementSet);

fn repository_tables() -> Vec<Table> {
    let built_in = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/environments/data");
    let files = [
        own("room-a/room-a-fit.csv"),
        own("room-a/room-a-holdout.csv"),
        built_in.join("cube-fit.csv"),
        built_in.join("cube-holdout.csv"),
    ];
    let mut tables: Vec<Table> = files
        .iter()
        .map(|file| (name(file), Files::default().read_measurements(file).unwrap()))
        .collect();
    for seed in 0..4 {
        let room = Room::new(seed, seed % 2 == 1);
        tables.push((format!("simulated room {seed}"), simulated(&room, seed)));
    }
    tables.push(("whole rotations in the built-in room".to_owned(), six_dof()));
    tables
}

fn name(file: &Path) -> String {
    file.file_name().unwrap().to_string_lossy().into_owned()
}

fn turned_onto(axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&Vector3::z(), axis).unwrap_or_default()
}

fn simulated(room: &Room, seed: u64) -> MeasurementSet {
    let mut random = Random::new(seed);
    let each = (0..300).filter_map(|_| {
        let sensor = (room.position(&mut random), random.direction());
        let reading = room.measure(&sensor, &mut random)?;
        Some(Measurement {
            tracker_from_ideal: pose_from_parts(sensor.0, turned_onto(&sensor.1)),
            tracker_from_measured: pose_from_parts(reading.0, turned_onto(&reading.1)),
        })
    });
    MeasurementSet { measurements: each.collect(), content: MeasurementContent::FiveDof }
}

fn six_dof() -> MeasurementSet {
    let world = trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN).unwrap();
    let mut random = Random::new(9);
    let each = (0..200).map(|_| {
        let at = Vector3::new(
            random.range(-200.0, 200.0),
            random.range(-200.0, 200.0),
            random.range(-500.0, -100.0),
        );
        let ideal = pose_from_parts(at, canonical(exp_vector(&(1.5 * random.normal()))));
        let (measured, _) = world.environment.model.distort(&ideal, OutsidePolicy::Clamp);
        Measurement {
            tracker_from_ideal: ideal,
            tracker_from_measured: pose_from_parts(
                measured.translation.vector,
                canonical(measured.rotation),
            ),
        }
    });
    MeasurementSet { measurements: each.collect(), content: MeasurementContent::SixDof }
}

/// The quaternion of a rotation that files have.
fn canonical(q: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    if q.w < 0.0 { Unit::new_unchecked(-q.into_inner()) } else { q }
}

/// Sets of the course, positions alone.
fn course_tables() -> Vec<Table> {
    let Some(folder) = third_party("jhu-cis") else {
        return Vec::new();
    };
    let mut bodies: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|file| name(file).ends_with("-calbody.txt"))
        .collect();
    bodies.sort();
    let table = |file: &PathBuf| {
        let readings = file.with_file_name(name(file).replace("calbody", "calreadings"));
        let body = Files::default().read_calbody(file).unwrap();
        let frames = Files::default().read_calreadings(&readings).unwrap();
        let set = calibration_object::measurements(&body, &frames).unwrap();
        (name(&readings), set)
    };
    bodies.iter().map(table).collect()
}

/// A real Aurora beside a Polaris: still poses, and four paths.
fn real_tables() -> Vec<Table> {
    let Some(folder) = third_party("aurora-polaris") else {
        return Vec::new();
    };
    let files = |folder: &Path, first: &str| {
        let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|file| name(file).starts_with(first))
            .collect();
        files.sort();
        files
    };
    let read = |file: &PathBuf| {
        let found = Files::default().read_recording(file).unwrap();
        assert_eq!(found.suspicions, [], "{}", file.display());
        found.as_it_stands()
    };
    let table = |title: &str, em: &[PathBuf], reference: &[PathBuf]| {
        let pairs: Vec<RecordedPair> = em
            .iter()
            .zip(reference)
            .map(|(em, reference)| RecordedPair { tracker: read(em), reference: read(reference) })
            .collect();
        let settings = CharacterisationSettings::default();
        let found = characterise(&pairs, &settings, &Task::default()).unwrap();
        let each = found.readings.iter().map(|reading| reading.measurement);
        let each = each.map(|m| Measurement {
            tracker_from_ideal: written(&m.tracker_from_ideal),
            tracker_from_measured: written(&m.tracker_from_measured),
        });
        let set =
            MeasurementSet { measurements: each.collect(), content: MeasurementContent::SixDof };
        (title.to_owned(), set)
    };
    [("still poses", "static"), ("paths", "paths")]
        .map(|(title, part)| {
            let part = folder.join(part);
            table(title, &files(&part, "EM"), &files(&part, "OT"))
        })
        .into()
}

fn written(pose: &Pose) -> Pose {
    pose_from_parts(pose.translation.vector, canonical(pose.rotation))
}

fn all_tables() -> Vec<Table> {
    [repository_tables(), course_tables(), real_tables()].concat()
}

/// Its name, how it is made, and which suspicion is of it.
type Mistake = (&'static str, fn(&[Measurement]) -> Vec<Measurement>, fn(&Suspicion) -> bool);

fn both(rows: &[Measurement], change: impl Fn(&Pose) -> Pose) -> Vec<Measurement> {
    let ideal =
        |m: &Measurement| Measurement { tracker_from_ideal: change(&m.tracker_from_ideal), ..*m };
    measured(&rows.iter().map(ideal).collect::<Vec<_>>(), change)
}

fn measured(rows: &[Measurement], change: impl Fn(&Pose) -> Pose) -> Vec<Measurement> {
    let each = rows
        .iter()
        .map(|m| Measurement { tracker_from_measured: change(&m.tracker_from_measured), ..*m });
    each.collect()
}

fn scaled(pose: &Pose, factor: f64) -> Pose {
    pose_from_parts(pose.translation.vector * factor, pose.rotation)
}

fn placed(pose: &Pose, at: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Pose {
    pose_from_parts(at(pose.translation.vector), pose.rotation)
}

fn numbers(pose: &Pose, order: impl Fn([f64; 4]) -> [f64; 4]) -> Pose {
    let q = pose.rotation.quaternion();
    let [w, x, y, z] = order([q.w, q.i, q.j, q.k]);
    let rotation = Unit::new_unchecked(Quaternion::new(w, x, y, z));
    pose_from_parts(pose.translation.vector, rotation)
}

/// Another room's frame.
fn moved(pose: &Pose) -> Pose {
    let other_from_tracker = pose_from_parts(
        Vector3::new(120.0, -40.0, -1500.0),
        exp_vector(&Vector3::new(0.4, 0.9, -0.3)),
    );
    other_from_tracker * pose
}

/// Angles in degrees that a program took for radians.
fn in_degrees(pose: &Pose) -> Pose {
    let vector = log_quaternion(&pose.rotation).map(f64::to_degrees);
    pose_from_parts(pose.translation.vector, canonical(exp_vector(&vector)))
}

fn late(rows: &[Measurement], ideal: usize, measured: usize) -> Vec<Measurement> {
    let each = rows[ideal..].iter().zip(&rows[measured..]);
    each.map(|(ideal, measured)| Measurement {
        tracker_from_ideal: ideal.tracker_from_ideal,
        tracker_from_measured: measured.tracker_from_measured,
    })
    .collect()
}

/// Every fortieth reading is off.
fn outliers(rows: &[Measurement], by: f64) -> Vec<Measurement> {
    let mut rows = rows.to_vec();
    for m in rows.iter_mut().skip(7).step_by(40) {
        m.tracker_from_measured.translation.vector.y += by;
    }
    rows
}

fn is_frame(suspicion: &Suspicion) -> bool {
    let frames = |m: &M| matches!(m, M::Axes(_) | M::Mirrored | M::Frame { .. });
    matches!(suspicion, Suspicion::Mistake { mistake, part: None, .. } if frames(mistake))
}

fn is_part(suspicion: &Suspicion) -> bool {
    matches!(suspicion, Suspicion::Mistake { part: Some(_), .. })
}

fn is_of_quaternions(suspicion: &Suspicion) -> bool {
    matches!(suspicion, Suspicion::Mistake { mistake: M::Quaternions(..), part: None, .. })
}

const MISTAKES: [Mistake; 12] = [
    (
        "metres",
        |rows| both(rows, |p| scaled(p, 1e-3)),
        |s| matches!(s, Suspicion::Metres { .. }) && s.is_beyond_doubt(),
    ),
    (
        "measured in metres",
        |rows| measured(rows, |p| scaled(p, 1e-3)),
        |s| matches!(s, Suspicion::Scale { .. }) && s.is_beyond_doubt(),
    ),
    (
        "inches",
        |rows| both(rows, |p| scaled(p, 1.0 / 25.4)),
        |s| matches!(s, Suspicion::InchesOrCentimetres { .. }),
    ),
    (
        "measured in inches",
        |rows| measured(rows, |p| scaled(p, 1.0 / 25.4)),
        |s| matches!(s, Suspicion::Scale { .. }) && s.is_beyond_doubt(),
    ),
    (
        "mirrored in z",
        |rows| measured(rows, |p| placed(p, |p| Vector3::new(p.x, p.y, -p.z))),
        |s| is_frame(s) && s.is_beyond_doubt(),
    ),
    (
        "left-handed",
        |rows| {
            measured(rows, |p| {
                let p = placed(p, |p| Vector3::new(p.x, p.y, -p.z));
                numbers(&p, |[w, x, y, z]| [w, -x, -y, z])
            })
        },
        |s| is_frame(s) && s.is_beyond_doubt(),
    ),
    (
        "x and y swapped",
        |rows| measured(rows, |p| placed(p, |p| Vector3::new(p.y, p.x, p.z))),
        is_frame,
    ),
    (
        "in another frame",
        |rows| measured(rows, moved),
        |s| is_frame(s) && s.is_of_frames() && s.is_beyond_doubt(),
    ),
    (
        "measured a row late",
        |rows| late(rows, 0, 1),
        |s| matches!(s, Suspicion::RowShift { rows: -1, .. }),
    ),
    (
        "measured a row early",
        |rows| late(rows, 1, 0),
        |s| matches!(s, Suspicion::RowShift { rows: 1, .. }),
    ),
    (
        "outliers of 1e6 mm",
        |rows| outliers(rows, 1e6 + 1e3),
        |s| matches!(s, Suspicion::TooFar { .. }),
    ),
    (
        "outliers of 300 mm",
        |rows| outliers(rows, 300.0),
        // All of them are off by the same.
        |s| matches!(s, Suspicion::Outliers { .. }) || is_part(s),
    ),
];

/// Of quaternions, which a table of positions has none of.
const MISTAKES_OF_ROTATIONS: [Mistake; 4] = [
    (
        "measured in degrees",
        |rows| measured(rows, in_degrees),
        |s| matches!(s, Suspicion::Orientations { .. }),
    ),
    (
        "measured xyzw",
        |rows| measured(rows, |p| numbers(p, |[w, x, y, z]| [x, y, z, w])),
        is_of_quaternions,
    ),
    (
        "xyzw",
        |rows| both(rows, |p| numbers(p, |[w, x, y, z]| [x, y, z, w])),
        |s| is_of_quaternions(s) || matches!(s, Suspicion::ScalarLast { .. }),
    ),
    (
        "measured inverted, as by another hand",
        |rows| measured(rows, |p| numbers(p, |[w, x, y, z]| [w, -x, -y, -z])),
        is_of_quaternions,
    ),
];

fn suspicions(rows: &[Measurement], content: MeasurementContent) -> Vec<Suspicion> {
    PairedDoubts::of(rows, content, PoseFrame::Tracker)
}

#[test]
#[expect(clippy::print_stderr, reason = "the counts are for the docs")]
fn every_mistake_is_seen_in_every_table() {
    let tables = all_tables();
    let mut problems = Vec::new();
    let mut tried = 0;
    for (name, set) in &tables {
        for suspicion in suspicions(&set.measurements, set.content) {
            problems.push(format!("{name}, which is good: {suspicion}"));
        }
        let of_rotations = match set.content {
            MeasurementContent::PositionOnly => &[][..],
            _ => &MISTAKES_OF_ROTATIONS[..],
        };
        for (mistake, make, is_it) in MISTAKES.iter().chain(of_rotations) {
            tried += 1;
            let found = suspicions(&make(&set.measurements), set.content);
            if !found.iter().any(is_it) {
                let doubts: Vec<_> = found.iter().map(ToString::to_string).collect();
                problems.push(format!("{name}, {mistake}: {doubts:?}"));
            }
        }
    }
    eprintln!(
        "{} tables, {} mistakes, {tried} of them made: {} missed or false",
        tables.len(),
        MISTAKES.len() + MISTAKES_OF_ROTATIONS.len(),
        problems.len()
    );
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn few_rows_and_rows_at_one_place_are_left_alone() {
    let (_, set) = repository_tables().remove(0);
    let three = measured(&set.measurements[..3], moved);
    assert_eq!(suspicions(&three, set.content), []);
    let mut random = Random::new(3);
    let at_rest: Vec<Measurement> = (0..200)
        .map(|_| {
            let mut m = set.measurements[0];
            m.tracker_from_measured.translation.vector += 0.1 * random.normal();
            m
        })
        .collect();
    assert_eq!(suspicions(&at_rest, set.content), []);
}

#[test]
fn a_long_table_is_judged_by_rows_from_all_of_it() {
    let (_, set) = repository_tables().remove(2);
    let long: Vec<Measurement> = set.measurements.iter().cycle().take(100_000).copied().collect();
    assert_eq!(suspicions(&long, set.content), []);
    let found = suspicions(&late(&long, 0, 1), set.content);
    assert!(matches!(found[..], [Suspicion::RowShift { rows: -1, .. }]), "{found:?}");
    let mut off = long;
    off[90_001].tracker_from_measured.translation.vector.x += 400.0;
    let found = suspicions(&off, set.content);
    assert!(
        matches!(found[..], [Suspicion::Outliers { count: 1, first_row: 90_002, .. }]),
        "{found:?}"
    );
}

#[test]
fn outliers_begin_at_the_gap_before_them() {
    let (_, set) = repository_tables().remove(2);
    let mut rows = set.measurements;
    for k in 0..10 {
        rows[17 * k + 3].tracker_from_measured.translation.vector.x += 45.0 + 6.0 * k as f64;
    }
    let found = suspicions(&rows, set.content);
    let [Suspicion::Outliers { count: 10, first_row: 4, limit, .. }] = found[..] else {
        panic!("{found:?}");
    };
    assert!((24.0..45.0).contains(&limit), "{limit}");
}

#[test]
fn poses_by_themselves_show_units_and_the_scalar() {
    let (mut good, mut seen) = (0, 0);
    for (name, set) in all_tables() {
        let poses: Vec<Pose> = set.measurements.iter().map(|m| m.tracker_from_measured).collect();
        let found = |poses: &[Pose]| doubts::with_written_quaternions(poses, PoseFrame::Tracker);
        assert_eq!(found(&poses), [], "{name}");
        good += 1;
        let changed = |change: &dyn Fn(&Pose) -> Pose| -> Vec<Suspicion> {
            found(&poses.iter().map(change).collect::<Vec<_>>())
        };
        let metres = changed(&|p| scaled(p, 1e-3));
        assert!(
            matches!(metres[..], [Suspicion::Metres { is_certain: true, .. }]),
            "{name}: {metres:?}"
        );
        let inches = changed(&|p| scaled(p, 1.0 / 25.4));
        assert!(
            matches!(inches[..], [Suspicion::InchesOrCentimetres { .. }]),
            "{name}: {inches:?}"
        );
        let far = changed(&|p| scaled(p, 1e6));
        assert!(matches!(far[..], [Suspicion::TooFar { .. }]), "{name}: {far:?}");
        seen += 3;
        if set.content != MeasurementContent::PositionOnly {
            let last = changed(&|p| numbers(p, |[w, x, y, z]| [x, y, z, w]));
            assert!(matches!(last[..], [Suspicion::ScalarLast { .. }]), "{name}: {last:?}");
            seen += 1;
        }
    }
    assert!(good >= 9 && seen >= 36, "{good} {seen}");
}
