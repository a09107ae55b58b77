//! The virtual plate against what its rooms are made of.

use super::evaluation::{EvaluationError, evaluate};
use super::plate::{Plate, PlateError, PlateReading, SensorKind, Site, SiteAt};
use super::readings::{SamplingSettings, simulate_readings};
use super::rods::{RodSettings, rod_readings};
use super::table::{ALL, Measure, ProtocolRow, Statistics};
use nalgebra::{Matrix3, Point3, UnitQuaternion, Vector3};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use trackwright_field::environment::Jitter;
use trackwright_field::generator::Generator;
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, Environment};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::pose_from_parts;
use trackwright_geometry::rotation::exp_vector;
use trackwright_geometry::volume::Volume;
use trackwright_metal::material::NAMED_MATERIALS;
use trackwright_task::Task;

fn bounds() -> Bounds {
    Volume::AuroraCube.bounds()
}

/// A room whose position error is a linear map of the position, without errors of rotation.
fn linear_room(error: Matrix3<f64>) -> Environment {
    let bounds = bounds();
    // Values at the corners, which the polynomial of order 1 takes: i, then j, then k.
    let coefficients = (0..8).map(|corner| {
        let at = |k: usize, bit: usize| match corner & bit {
            0 => bounds.min_mm[k],
            _ => bounds.max_mm[k],
        };
        let off = error * Vector3::new(at(0, 4), at(1, 2), at(2, 1));
        [off.x, off.y, off.z, 0.0, 0.0, 0.0]
    });
    let model = DistortionModel::of_position(1, bounds, coefficients.collect()).unwrap();
    Environment::of_model("linear", model)
}

fn empty_room() -> Environment {
    Environment::of_model("empty", DistortionModel::zero(bounds(), MapKind::Distortion))
}

fn rows_in(room: &Environment) -> Vec<ProtocolRow> {
    let plate = Plate::fitted(room).unwrap();
    let settings = SamplingSettings::default();
    let readings = simulate_readings(room, room.jitter.as_ref(), &plate, &[], &settings).unwrap();
    evaluate(&readings, SensorKind::FiveDof).unwrap()
}

fn row(rows: &[ProtocolRow], measure: &Measure, condition: &str) -> Statistics {
    let found = rows.iter().find(|row| row.measure == *measure && row.condition == condition);
    found.unwrap_or_else(|| panic!("no {measure:?} {condition}: {rows:?}")).statistics
}

#[test]
fn a_room_scaled_by_two_percent_errs_by_one_mm() {
    let rows = rows_in(&linear_room(Matrix3::identity() * 0.02));
    for (length_mm, count) in [(50_u32, 3 * (9 * 9 + 8 * 10)), (100, 3 * (9 * 8 + 7 * 10))] {
        let found = row(&rows, &Measure::Distance(length_mm), ALL);
        let expected = 0.02 * f64::from(length_mm);
        assert_eq!(found.count, count);
        for value in [found.mean, found.rms, found.min, found.max] {
            assert!((value - expected).abs() < 1e-9, "{found:?}");
        }
        assert!(found.std < 1e-9, "{found:?}");
    }
    // One axis alone.
    let along_y = Matrix3::from_diagonal(&Vector3::new(0.0, -0.01, 0.0));
    let rows = rows_in(&linear_room(along_y));
    for (condition, expected) in [("along x", 0.0), ("along y", -0.5)] {
        let found = row(&rows, &Measure::Distance(50), condition);
        assert!((found.mean - expected).abs() < 1e-9 && found.std < 1e-9, "{found:?}");
    }
    for level in ["level 0", "level 2"] {
        let found = row(&rows, &Measure::Distance(50), level);
        assert!((found.mean + 0.5 * 80.0 / 161.0).abs() < 1e-9, "{found:?}");
    }
}

#[test]
fn a_rotation_of_space_keeps_distances() {
    let turn = exp_vector(&Vector3::new(0.02, -0.03, 0.05)).to_rotation_matrix();
    let rows = rows_in(&linear_room(turn.matrix() - Matrix3::identity()));
    for length_mm in [50, 100, 150, 200] {
        let found = row(&rows, &Measure::Distance(length_mm), ALL);
        assert!(found.rms < 1e-10 && found.max < 1e-10, "{found:?}");
    }
    // The sensor's own axes are as they are in truth.
    let turns = row(&rows, &Measure::Rotation, ALL);
    assert!(turns.count == 3 * 32 && turns.rms < 1e-10, "{turns:?}");
    assert!(rows.iter().all(|row| row.measure != Measure::Jitter), "one reading has no jitter");
}

#[test]
fn jitter_is_within_its_chi_square_bounds() {
    let mut room = empty_room();
    let (sigma_mm, sigma_rad) = (0.08, 0.002);
    room.jitter = Some(Jitter::uniform(sigma_mm, sigma_rad));
    let rows = rows_in(&room);
    let jitter = row(&rows, &Measure::Jitter, ALL);
    assert_eq!(jitter.count, 3 * (90 + 32));
    let freedom = (3 * 149 * jitter.count) as f64;
    let chi_square = freedom * (jitter.rms * jitter.rms / 3.0) / (sigma_mm * sigma_mm);
    let law = ChiSquared::new(freedom).unwrap();
    let [low, high] = [1e-4, 1.0 - 1e-4].map(|p| law.inverse_cdf(p));
    assert!((low..high).contains(&chi_square), "{chi_square} {low} {high}");
    // A difference of two means along a line: σ √(2/150), its square within its own bounds.
    let distance = row(&rows, &Measure::Distance(50), ALL);
    let expected_mm = sigma_mm * (2.0_f64 / 150.0).sqrt();
    // Pairs that share a hole depend on each other: at worst half of them count.
    assert!((distance.rms / expected_mm - 1.0).abs() < 4.0 / (distance.count as f64).sqrt());
    let turns = row(&rows, &Measure::Rotation, ALL);
    let expected_deg = (sigma_rad * (2.0_f64 / 150.0).sqrt()).to_degrees();
    assert!((turns.rms / expected_deg - 1.0).abs() < 4.0 / (turns.count as f64).sqrt());
}

#[test]
fn turns_are_those_of_the_sensor() {
    // Every second position of the disc is 0.3° too far.
    let disc = |sensor: SensorKind, is_upright: bool| {
        let site = |step: u32| Site::plain(0, SiteAt::Disc { angle_deg: 7.5 * f64::from(step) });
        let holes = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(row, column)| PlateReading {
            site: Site::plain(0, SiteAt::Hole { row, column }),
            tracker_from_sensor: pose_from_parts(
                Vector3::new(column as f64 * 50.0, row as f64 * 50.0, 0.0),
                UnitQuaternion::identity(),
            ),
        });
        let turns = (0..48_u32).map(|step| {
            let deg = 7.5 * f64::from(step) + if step % 2 == 1 { 0.3 } else { 0.0 };
            let turn = exp_vector(&(Vector3::z() * deg.to_radians()));
            let mount = match is_upright {
                true => UnitQuaternion::identity(),
                false => exp_vector(&(Vector3::y() * std::f64::consts::FRAC_PI_2)),
            };
            let tracker_from_sensor = pose_from_parts(Vector3::zeros(), turn * mount);
            PlateReading { site: site(step), tracker_from_sensor }
        });
        let readings: Vec<_> = holes.into_iter().chain(turns).collect();
        evaluate(&readings, sensor)
    };
    for (sensor, is_upright) in
        [(SensorKind::FiveDof, false), (SensorKind::SixDof, false), (SensorKind::SixDof, true)]
    {
        let found = row(&disc(sensor, is_upright).unwrap(), &Measure::Rotation, ALL);
        assert_eq!(found.count, 48);
        assert!((found.max - 0.3).abs() < 1e-9 && (found.min + 0.3).abs() < 1e-9, "{found:?}");
        assert!(found.mean.abs() < 1e-9, "{found:?}");
    }
    let error = disc(SensorKind::FiveDof, true).unwrap_err();
    let words = "the sensor's axis turns by 0.00° a step of the disc, expected 7.50°";
    assert!(error.to_string().starts_with(words), "{error}");
}

#[test]
fn plates_fit_into_small_rooms() {
    let plate = Plate::fitted(&empty_room()).unwrap();
    assert_eq!((plate.rows, plate.columns, plate.levels, plate.level_mm), (9, 10, 3, 100.0));
    let room = |size_mm: Vector3<f64>| {
        let middle = Point3::new(0.0, 0.0, -200.0);
        let box_mm = Bounds { min_mm: middle - size_mm / 2.0, max_mm: middle + size_mm / 2.0 };
        Environment::of_model("small", DistortionModel::zero(box_mm, MapKind::Distortion))
    };
    let small = Plate::fitted(&room(Vector3::new(310.0, 260.0, 150.0))).unwrap();
    assert_eq!((small.rows, small.columns, small.level_mm), (6, 7, 70.0));
    let error = Plate::fitted(&room(Vector3::new(60.0, 60.0, 60.0))).unwrap_err();
    assert!(matches!(error, PlateError::NoneFits { .. }), "{error}");
    for volume in [Volume::AuroraDome, Volume::AuroraTabletop] {
        let mut round = Environment::of_model(
            "round",
            DistortionModel::zero(volume.bounds(), MapKind::Distortion),
        );
        round.volume = Some(volume);
        assert!(Plate::fitted(&round).is_ok());
    }
}

#[test]
fn plates_that_cannot_be_are_refused() {
    let room = empty_room();
    let good = Plate::fitted(&room).unwrap();
    let mut shifted = good;
    shifted.tracker_from_plate.translation.vector.x += 40.0;
    let mut nowhere = good;
    nowhere.tracker_from_plate.translation.vector.y = f64::NAN;
    for (plate, expected) in [
        (
            shifted,
            "level 0, row 0, column 9 is at (265.0, -200.0, -400.0) mm, outside the room's box",
        ),
        (nowhere, "the pose of the plate is not finite"),
        (Plate { rows: 1, ..good }, "rows are 1, expected 2 to 200"),
        (Plate { levels: 0, ..good }, "levels are 0, expected 1 to 200"),
        (Plate { steps: 2, ..good }, "steps of the disc are 2, expected 3 to 200"),
        (Plate { level_mm: f64::NAN, ..good }, "distance of levels is NaN mm"),
    ] {
        let settings = SamplingSettings::default();
        let error = simulate_readings(&room, None, &plate, &[], &settings).unwrap_err();
        assert!(error.to_string().starts_with(expected), "{error}");
    }
    for samples in [0, 10_001] {
        let settings = SamplingSettings { samples, seed: 1 };
        let error = simulate_readings(&room, None, &good, &[], &settings).unwrap_err();
        assert!(error.to_string().contains("expected 1 to 10000"), "{error}");
    }
}

#[test]
fn readings_that_are_no_plate_are_refused() {
    let reading = |row: usize, column: usize| PlateReading {
        site: Site::plain(0, SiteAt::Hole { row, column }),
        tracker_from_sensor: pose_from_parts(Vector3::zeros(), UnitQuaternion::identity()),
    };
    let apart = [reading(0, 0), reading(0, 2), reading(5, 5), reading(5, 6), reading(9, 9)];
    for (readings, found) in [(&[][..], 0), (&apart, 2)] {
        let error = evaluate(readings, SensorKind::FiveDof).unwrap_err();
        assert_eq!(error, EvaluationError::TooFewHoles { found });
    }
}

/// Deviations beside rods at 20 mm, largest and mean, in the middle of the cube.
fn rods_at_20_mm(keys: &[&str]) -> Vec<Statistics> {
    let room = empty_room();
    let plate = Plate::fitted(&room).unwrap();
    let materials =
        keys.iter().map(|key| *NAMED_MATERIALS.iter().find(|named| named.key == *key).unwrap());
    let settings = RodSettings {
        distances_mm: vec![20.0],
        triangles: 150,
        ..RodSettings::of(materials.collect())
    };
    let rods = rod_readings(
        &plate,
        &Generator::planar_nine(),
        SensorKind::FiveDof,
        &settings,
        &Task::default(),
    )
    .unwrap();
    assert_eq!((rods.in_generator, rods.without_pose), (0, 0));
    let sampling = SamplingSettings::default();
    let readings = simulate_readings(&room, None, &plate, &rods.readings, &sampling).unwrap();
    let rows = evaluate(&readings, SensorKind::FiveDof).unwrap();
    let of = |key: &&str| row(&rows, &Measure::Rod((*key).to_owned()), "20 mm");
    keys.iter().map(of).collect()
}

#[test]
fn rods_are_ranked_as_the_paper_has_them() {
    let found = rods_at_20_mm(&["steel-416", "aluminium", "bronze", "steel-303"]);
    assert!(found.iter().all(|of| of.count == 15));
    let [steel_416, aluminium, bronze, steel_303] = [0, 1, 2, 3].map(|k| found[k].max);
    assert!(steel_416 > 4.0 * aluminium, "{found:?}");
    assert!(aluminium > bronze && bronze > 2.0 * steel_303, "{found:?}");
    // On average too.
    assert!(found.is_sorted_by(|a, b| a.mean > b.mean), "{found:?}");
}

#[test]
fn a_rod_without_a_reading_beside_it_is_refused() {
    let room = empty_room();
    let plate = Plate::fitted(&room).unwrap();
    let material = NAMED_MATERIALS.iter().find(|named| named.key == "copper").unwrap();
    let settings =
        RodSettings { distances_mm: vec![50.0], triangles: 60, ..RodSettings::of(vec![*material]) };
    let generator = Generator::planar_nine();
    let rods =
        rod_readings(&plate, &generator, SensorKind::SixDof, &settings, &Task::default()).unwrap();
    let sampling = SamplingSettings::default();
    let mut readings = simulate_readings(&room, None, &plate, &rods.readings, &sampling).unwrap();
    let disc = SiteAt::Disc { angle_deg: 0.0 };
    readings.retain(|reading| reading.site != Site::plain(1, disc));
    let error = evaluate(&readings, SensorKind::SixDof).unwrap_err();
    assert_eq!(
        error.to_string(),
        "level 1, disc at 0°: found readings beside a rod of copper and none without it, expected both"
    );
    // A plate without a disc has the reading without the rod all the same.
    let plate = Plate { steps: 0, ..plate };
    let readings = simulate_readings(&room, None, &plate, &rods.readings, &sampling).unwrap();
    assert!(evaluate(&readings, SensorKind::SixDof).is_ok());
    for (diameter_mm, length_mm) in [(0.5, 100.0), (10.0, 2000.0), (f64::NAN, 100.0)] {
        let settings = RodSettings { diameter_mm, length_mm, ..settings.clone() };
        let error =
            rod_readings(&plate, &generator, SensorKind::FiveDof, &settings, &Task::default())
                .unwrap_err();
        assert!(error.to_string().contains("expected at most 1000 mm"), "{error}");
    }
    for wrong in [0.0, f64::NAN, 1e4] {
        let settings = RodSettings { distances_mm: vec![wrong], ..settings.clone() };
        let error =
            rod_readings(&plate, &generator, SensorKind::FiveDof, &settings, &Task::default())
                .unwrap_err();
        assert!(error.to_string().starts_with("distance of a rod is "), "{error}");
    }
}
