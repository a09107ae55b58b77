//! Known bodies found again in simulated measurements.

use super::*;
use crate::body::{MetalBody, MetalShape};
use crate::material::Material;
use crate::room::{MetalRoom, PlacedBody};
use nalgebra::{Point3, Vector3};
use std::sync::Arc;
use trackwright_field::generator::Generator;
use trackwright_field::random_models::Seeded;
use trackwright_field::samples::{Measurement, MeasurementContent, MeasurementSet};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::{Pose, pose_from_array, pose_from_parts};
use trackwright_geometry::rotation::axis_rotation;
use trackwright_geometry::rotation::exp_vector;
use trackwright_task::Task;

/// A tracker like an Aurora.
pub(super) const POSITION_NOISE_MM: f64 = 0.2;
pub(super) const ROTATION_NOISE_RAD: f64 = 0.2 * std::f64::consts::PI / 180.0;

/// At 10 kHz.
struct Ball {
    material: &'static str,
    radius_mm: f64,
    center_mm: [f64; 3],
}

const ALUMINIUM: Ball =
    Ball { material: "aluminium", radius_mm: 45.0, center_mm: [210.0, 40.0, -190.0] };
const FERRITE: Ball =
    Ball { material: "ferrite", radius_mm: 30.0, center_mm: [-190.0, -90.0, -260.0] };

impl Ball {
    fn placed(&self) -> PlacedBody {
        let material = Material::named(self.material).unwrap();
        let shape = MetalShape::Sphere { radius_mm: self.radius_mm };
        let [x, y, z] = self.center_mm;
        PlacedBody {
            body: Arc::new(MetalBody::new(shape, material, 1e4, &Task::default()).unwrap()),
            tracker_from_body: Pose::translation(x, y, z),
        }
    }

    /// `f a³`.
    fn strength_mm3(&self) -> f64 {
        let material = Material::named(self.material).unwrap();
        let factor = crate::sphere::sphere_factor(self.radius_mm, &material, 1e4).unwrap();
        factor.re * self.radius_mm.powi(3)
    }
}

/// Positions of a volume of 300 mm.
fn volume() -> Bounds {
    Bounds::from(([-150.0, -150.0, -400.0], [150.0, 150.0, -100.0]))
}

fn measured(
    balls: &[Ball],
    count: usize,
    content: MeasurementContent,
    seed: u64,
) -> MeasurementSet {
    let placed = balls.iter().map(Ball::placed).collect();
    let room = MetalRoom::new(Generator::planar_nine(), None, placed, &Task::default()).unwrap();
    readings(&room, count, content, seed)
}

/// What a tracker with noise reads in a room, at random poses.
pub(super) fn readings(
    room: &MetalRoom,
    count: usize,
    content: MeasurementContent,
    seed: u64,
) -> MeasurementSet {
    let mut seeded = Seeded::new(seed);
    let mut one = || loop {
        let pose = seeded.pose(&volume(), 0.0);
        let p = Point3::from(pose.translation.vector);
        let read = match content {
            MeasurementContent::SixDof => match room.read_pose(&pose) {
                Ok(read) => read.tracker_from_sensor,
                Err(_) => continue,
            },
            _ => match room.read_axis(&p, &(pose.rotation * Vector3::z_axis())) {
                Ok(read) => {
                    let axis = pose.rotation * Vector3::z_axis();
                    let turn = exp_vector(&axis_rotation(&axis, &read.axis).vector_rad);
                    pose_from_parts(read.position_mm.coords, turn * pose.rotation)
                }
                Err(_) => continue,
            },
        };
        let measured = seeded.around(&read, POSITION_NOISE_MM, ROTATION_NOISE_RAD);
        return Measurement { tracker_from_ideal: pose, tracker_from_measured: measured };
    };
    MeasurementSet { measurements: (0..count).map(|_| one()).collect(), content }
}

pub(super) fn identified(set: &MeasurementSet) -> Identification {
    let settings = IdentifySettings::default();
    identify(&Task::default(), &Generator::planar_nine(), set, &settings).unwrap()
}

/// Squared distance of a found middle in its standard deviations: χ² of three degrees of freedom.
fn deviations2(body: &FoundBody, ball: &Ball) -> f64 {
    let off = body.source.center_mm - Point3::from(ball.center_mm);
    off.dot(&(known(body).center_cov_mm2.try_inverse().unwrap() * off))
}

/// What is known of a body that is determined.
fn known(body: &FoundBody) -> &KnownBody {
    body.known.as_ref().unwrap()
}

fn off_mm(body: &FoundBody, ball: &Ball) -> f64 {
    (body.source.center_mm - Point3::from(ball.center_mm)).norm()
}

#[test]
fn two_spheres_are_found_within_20_mm() {
    let set = measured(&[ALUMINIUM, FERRITE], 1000, MeasurementContent::FiveDof, 1);
    let found = identified(&set);
    assert_eq!(found.verdict, Verdict::Found, "{found:?}");
    assert!((found.noise.position_mm / POSITION_NOISE_MM - 1.0).abs() < 0.1);
    assert!((found.noise.rotation_rad / ROTATION_NOISE_RAD - 1.0).abs() < 0.1);
    assert!(!found.is_misfit() && found.model == SourceModel::Spheres);
    let [conductor, magnetic] = &found.bodies[..] else { panic!("two bodies: {found:?}") };
    let kinds = [MetalKind::Conductor, MetalKind::Ferromagnetic];
    for ((body, ball), kind) in [(conductor, ALUMINIUM), (magnetic, FERRITE)].into_iter().zip(kinds)
    {
        assert_eq!((body.kind, body.doubt()), (kind, None));
        assert!(off_mm(body, &ball) < 20.0);
        // Of 1,000 draws one is beyond 16.3. Aluminium at 10 kHz is not without skin: 1 %.
        assert!(deviations2(body, &ball) < 16.3, "{body:?}");
        assert!((body.source.strength_mm3 / ball.strength_mm3() - 1.0).abs() < 0.02, "{body:?}");
        assert!(known(body).half_length_mm < 2.0, "{body:?}");
    }
}

#[test]
fn without_metal_nothing_is_found() {
    for (seed, count) in [(3, 300), (4, 60)] {
        let found = identified(&measured(&[], count, MeasurementContent::FiveDof, seed));
        assert_eq!(found.verdict, Verdict::NothingFound, "{found:?}");
        assert!(found.bodies.is_empty() && found.unexplained == 0.0);
    }
}

#[test]
fn a_sphere_too_far_away_is_not_determined() {
    let far =
        |x: f64| Ball { material: "aluminium", radius_mm: 60.0, center_mm: [x, 100.0, -300.0] };
    let found = |x: f64| identified(&measured(&[far(x)], 500, MeasurementContent::FiveDof, 1));
    let near = found(330.0);
    assert_eq!(near.verdict, Verdict::Found, "{near:?}");
    assert!(deviations2(&near.bodies[0], &far(330.0)) < 16.3);
    let unknown = found(520.0);
    assert_eq!(unknown.verdict, Verdict::CannotTell, "{unknown:?}");
    assert!(matches!(unknown.bodies[0].known, Err(BodyDoubt::Position { .. })), "{unknown:?}");
    let none = found(1500.0);
    assert_eq!(none.verdict, Verdict::NothingFound, "{none:?}");
}

#[test]
fn sensors_with_three_axes_find_it_too() {
    let found = identified(&measured(&[FERRITE], 200, MeasurementContent::SixDof, 5));
    let [body] = &found.bodies[..] else { panic!("{found:?}") };
    assert_eq!((found.verdict, body.kind), (Verdict::Found, MetalKind::Ferromagnetic));
    assert!(deviations2(body, &FERRITE) < 16.3 && off_mm(body, &FERRITE) < 20.0, "{body:?}");
}

#[test]
fn a_few_wrong_measurements_do_no_harm() {
    let mut set = measured(&[ALUMINIUM], 300, MeasurementContent::FiveDof, 6);
    for m in set.measurements.iter_mut().step_by(50) {
        m.tracker_from_measured.translation.vector.x += 30.0;
    }
    let found = identified(&set);
    let [body] = &found.bodies[..] else { panic!("{found:?}") };
    assert!(found.down_weighted >= 6 && body.known.is_ok(), "{found:?}");
    assert!(deviations2(body, &ALUMINIUM) < 16.3 && off_mm(body, &ALUMINIUM) < 20.0, "{body:?}");
}

/// How many of 95 % intervals contain the true values: of x, y, z and the strength of each ball, of so
/// many seeds, with the number of bodies given.
fn covered(balls: &[Ball], count: usize, seeds: std::ops::Range<u64>) -> (usize, usize) {
    let task = Task::default();
    let (mut inside, mut all) = (0, 0);
    for seed in seeds {
        let set = measured(balls, count, MeasurementContent::FiveDof, seed);
        let noise = Noise { position_mm: POSITION_NOISE_MM, rotation_rad: ROTATION_NOISE_RAD };
        let rows = rows::Rows::new(&task, &Generator::planar_nine(), &set).unwrap();
        let rows = rows.over_noise(&noise);
        let found = held_out::Found::new(&task, &rows, balls.len(), None).unwrap();
        let best = &found.compact[balls.len()];
        let bodies = found_body::found_bodies(&rows, &best[0], &[], false);
        for ball in balls {
            let nearest =
                |a: &&FoundBody, b: &&FoundBody| off_mm(a, ball).total_cmp(&off_mm(b, ball));
            let body = bodies.iter().min_by(nearest).unwrap();
            let Ok(known) = &body.known else { continue };
            let places = (0..3).map(|k| known.center_mm[k].contains(ball.center_mm[k]));
            let strength = known.strength_mm3.contains(ball.strength_mm3());
            inside += places.chain([strength]).filter(|is_in| *is_in).count();
            all += 4;
        }
    }
    (inside, all)
}

#[test]
fn intervals_contain_the_true_values() {
    let far = Ball { material: "ferrite", radius_mm: 35.0, center_mm: [230.0, -90.0, -260.0] };
    let (inside, all) = covered(&[far], 150, 0..16);
    // 95 % of 64 are 61, with a standard deviation of 1.7; a body's four are not independent.
    assert!(inside >= 55, "{inside} of {all}");
}

#[test]
#[ignore = "some minutes"]
fn long_intervals_hold_in_95_of_100() {
    let far = Ball { material: "ferrite", radius_mm: 40.0, center_mm: [270.0, -90.0, -260.0] };
    let below = Ball { material: "aluminium", radius_mm: 60.0, center_mm: [40.0, -60.0, -560.0] };
    for balls in [vec![ALUMINIUM, FERRITE], vec![far], vec![below, FERRITE]] {
        let (inside, all) = covered(&balls, 400, 100..150);
        let expected = 0.95 * all as f64;
        let std_dev = (all as f64 * 0.95 * 0.05).sqrt();
        // Four values of a body are drawn together.
        assert!((inside as f64 - expected).abs() < 6.0 * std_dev, "{inside} of {all}");
    }
}

#[test]
#[ignore = "some minutes"]
fn long_noise_is_seldom_taken_for_metal() {
    let found = |seed: u64| identified(&measured(&[], 200, MeasurementContent::FiveDof, seed));
    let verdicts: Vec<Verdict> = (200..260).map(|seed| found(seed).verdict).collect();
    let count = |verdict| verdicts.iter().filter(|v| **v == verdict).count();
    assert!(count(Verdict::NothingFound) >= 55, "{verdicts:?}");
    assert_eq!(count(Verdict::Found), 0);
}

/// A table of a room with two metal bodies, made with the nine dipoles and noise of 5·10⁻⁵ of the signals.
#[test]
#[ignore = "a minute"]
fn long_two_bodies_explain_room_a() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/room-a/room-a-fit.csv");
    let text = std::fs::read_to_string(file).unwrap();
    let measurement = |line: &str| {
        let n: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let pose = |k: usize| pose_from_array(std::array::from_fn(|i| n[k + i])).unwrap();
        Measurement { tracker_from_ideal: pose(0), tracker_from_measured: pose(7) }
    };
    let measurements = text.lines().skip(1).take(400).map(measurement).collect();
    let found = identified(&MeasurementSet { measurements, content: MeasurementContent::FiveDof });
    let kinds: Vec<MetalKind> = found.determined().map(|body| body.kind).collect();
    assert_eq!(kinds, [MetalKind::Conductor, MetalKind::Ferromagnetic], "{found:?}");
    assert!(found.unexplained < 0.02, "{found:?}");
}

#[test]
fn dipole_slopes_are_differences() {
    let set = measured(&[FERRITE], 20, MeasurementContent::SixDof, 7);
    let task = Task::default();
    let rows = rows::Rows::new(&task, &Generator::anser(), &set).unwrap();
    let sources = [
        Source { center_mm: Point3::new(-190.0, -90.0, -260.0), strength_mm3: 3e4 },
        Source { center_mm: Point3::new(40.0, 230.0, -300.0), strength_mm3: -2e4 },
    ];
    let model = SourceModel::Dipoles;
    let slopes = model.slopes(&rows, &sources).unwrap();
    for unknown in 0..8 {
        let h = if unknown % 4 < 3 { 1e-2 } else { 1e-5 };
        let moved = |h: f64| {
            let mut step = [0.0; 4];
            step[unknown % 4] = h;
            let mut sources = sources;
            sources[unknown / 4] = sources[unknown / 4].moved(&step);
            model.explained(&rows, &sources).unwrap()
        };
        let (plus, minus) = (moved(h), moved(-h));
        let scale = slopes.column(unknown).norm();
        for (row, (plus, minus)) in plus.iter().zip(&minus).enumerate() {
            let difference = (plus - minus) / (2.0 * h);
            assert!((difference - slopes[(row, unknown)]).abs() < 1e-6 * scale);
        }
    }
}

#[test]
fn bodies_that_cannot_be_explain_nothing() {
    let set = measured(&[FERRITE], 20, MeasurementContent::FiveDof, 10);
    let rows = rows::Rows::new(&Task::default(), &Generator::planar_nine(), &set).unwrap();
    let source = |x: f64, z: f64, strength_mm3: f64| Source {
        center_mm: Point3::new(x, 0.0, z),
        strength_mm3,
    };
    let one = source(250.0, -200.0, 27e3);
    let is_possible = |sources: &[Source]| {
        [SourceModel::Dipoles, SourceModel::Spheres]
            .map(|model| model.explained(&rows, sources).is_some())
    };
    assert_eq!(is_possible(&[one, source(315.0, -200.0, -13e3)]), [true; 2]);
    // In one another, at one place with opposite strengths, at a coil, without a number.
    for other in [
        source(300.0, -200.0, -13e3),
        source(250.0, -200.0, -13e3),
        source(125.0, -15.0, -13.0),
        source(250.0, 6e3, 27e3),
        source(250.0, 200.0, f64::NAN),
    ] {
        assert_eq!(is_possible(&[one, other]), [false; 2], "{other:?}");
    }
}

#[test]
fn bodies_leave_less_held_out_than_other_models() {
    let set = measured(&[ALUMINIUM, FERRITE], 250, MeasurementContent::FiveDof, 8);
    let (task, generator) = (Task::default(), Generator::planar_nine());
    let settings = IdentifySettings { folds: 3, ..IdentifySettings::default() };
    let found = identify(&task, &generator, &set, &settings).unwrap();
    let compared = compare::compare(&task, &generator, &set, &settings, &found).unwrap();
    let rms = |k: usize| compared[k].scores.overall.position_rms_mm;
    assert_eq!(compared[0].model, compare::ComparedModel::None);
    assert_eq!(compared[1].model, compare::ComparedModel::Bodies);
    assert!(matches!(compared[2].model, compare::ComparedModel::Harmonic { .. }));
    assert!(matches!(compared[3].model, compare::ComparedModel::PerDirection(_)));
    // Bodies leave the noise, √3 of a component; harmonics and polynomials lack measurements.
    assert!(rms(1) < 1.1 * 3.0_f64.sqrt() * POSITION_NOISE_MM, "{compared:?}");
    assert!(rms(1) < rms(2) && rms(2) < rms(3) && rms(3) < rms(0), "{compared:?}");
}

#[test]
fn tables_that_cannot_be_used_are_refused() {
    let (task, generator) = (Task::default(), Generator::planar_nine());
    let set = measured(&[], 30, MeasurementContent::FiveDof, 9);
    let error = |set: &MeasurementSet, settings: IdentifySettings| {
        identify(&task, &generator, set, &settings).unwrap_err().to_string()
    };
    let refused = |change: &dyn Fn(&mut MeasurementSet), message: &str| {
        let mut changed = set.clone();
        change(&mut changed);
        assert_eq!(error(&changed, IdentifySettings::default()), message);
    };
    refused(&|set| set.measurements.truncate(19), "19 measurements, expected at least 20");
    refused(&|set| set.measurements.clear(), "0 measurements, expected at least 20");
    refused(
        &|set| set.measurements[7].tracker_from_measured.translation.vector.y = f64::NAN,
        "measurement 7 (counted from 0) has a number that is not finite",
    );
    refused(
        &|set| set.content = MeasurementContent::PositionOnly,
        "the measurements have no orientations; the fields that a sensor measures depend on its axis",
    );
    refused(
        &|set| {
            for m in &mut set.measurements {
                m.tracker_from_measured = m.tracker_from_ideal;
            }
        },
        "the measured poses are the true ones: there is no disturbance and no noise",
    );
    let most = IdentifySettings { most: 4, ..IdentifySettings::default() };
    assert_eq!(error(&set, most), "4 bodies requested, expected 1 to 3");
    let folds = IdentifySettings { folds: 1, ..IdentifySettings::default() };
    assert_eq!(error(&set, folds), "folds are 1, expected 2 up to the number of measurements");
    let few = Generator { coils: generator.coils[..4].to_vec(), ..generator.clone() };
    let refused = identify(&task, &few, &set, &IdentifySettings::default());
    assert!(matches!(refused, Err(IdentifyError::Generator(_))), "{refused:?}");
    let task = Task::default();
    task.cancel.cancel();
    let cancelled = identify(&task, &generator, &set, &IdentifySettings::default());
    assert!(matches!(cancelled, Err(IdentifyError::Cancelled(_))), "{cancelled:?}");
}
