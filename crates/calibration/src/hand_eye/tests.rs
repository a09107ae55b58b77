//! Known frames found again, with noise and without, and motions that do not determine them.

use super::*;
use trackwright_field::random_models::Seeded;
use trackwright_geometry::pose::{distances, pose_from_parts};
use trackwright_geometry::rotation::exp_vector;

/// A room as it is: a reference a metre away, sensors some centimetres from the body's origin.
struct Truth {
    y: Pose,
    x: Vec<Pose>,
}

impl Truth {
    fn new(noise: &mut Seeded, sensors: usize) -> Self {
        Self {
            y: noise.pose_within(800.0),
            x: (0..sensors).map(|_| noise.pose_within(25.0)).collect(),
        }
    }

    /// Readings of all sensors at poses of the body.
    fn read(&self, bodies: &[Pose], mut each: impl FnMut(Pose) -> Pose) -> Vec<PairedReading> {
        let mut readings = Vec::new();
        for (pose, body) in bodies.iter().enumerate() {
            for (sensor, x) in self.x.iter().enumerate() {
                readings.push(PairedReading {
                    pose,
                    sensor,
                    reference_from_body: *body,
                    tracker_from_sensor: each(self.y * body * x),
                    noise: ReadingNoise::default(),
                });
            }
        }
        readings
    }
}

/// Poses of a hand: some decimetres, turns of some 60°.
fn bodies(noise: &mut Seeded, count: usize) -> Vec<Pose> {
    let one = |_| {
        let at = Vector3::new(0.0, 0.0, -1000.0) + noise.normal_vector() * 100.0;
        pose_from_parts(at, exp_vector(&(noise.normal_vector() * 0.6)))
    };
    (0..count).map(one).collect()
}

#[test]
fn exact_readings_give_exact_frames() {
    for seed in 0..10 {
        let mut noise = Seeded::new(seed);
        let truth = Truth::new(&mut noise, 1 + seed as usize % 4);
        let readings = truth.read(&bodies(&mut noise, 12), |pose| pose);
        for loss in [Loss::Huber, Loss::Cauchy, Loss::Tukey] {
            let settings = HandEyeSettings { loss, ..HandEyeSettings::default() };
            let found = hand_eye(&readings, truth.x.len(), &settings).unwrap();
            let (mm, rad) = distances(&found.tracker_from_reference, &truth.y);
            assert!(mm < 1e-9 && rad < 1e-12, "{seed}: {mm} {rad}");
            for (found, x) in found.body_from_sensor.iter().zip(&truth.x) {
                let (mm, rad) = distances(found, x);
                assert!(mm < 1e-9 && rad < 1e-12, "{seed}: {mm} {rad}");
            }
        }
    }
}

#[test]
fn slopes_are_those_of_finite_differences() {
    let mut noise = Seeded::new(1);
    let truth = Truth::new(&mut noise, 2);
    let frames = solve::Frames { y: truth.y, x: truth.x.clone() };
    let h = 1e-6;
    for reading in
        truth.read(&bodies(&mut noise, 3), |pose| Seeded::new(9).around(&pose, 30.0, 0.8))
    {
        let slopes = frames.slopes(&reading, &frames.residual(&reading));
        for column in 0..12 {
            let at = |step: f64| {
                let mut moved = frames.clone();
                let pose = match column / 6 {
                    0 => &mut moved.y,
                    _ => &mut moved.x[reading.sensor],
                };
                let mut change = Vector3::zeros();
                change[column % 3] = step;
                match column % 6 / 3 {
                    0 => pose.rotation = exp_vector(&change) * pose.rotation,
                    _ => pose.translation.vector += change,
                }
                whitened(&moved.residual(&reading), &Spread { position_mm: 1.0, angle_rad: 1.0 })
            };
            let slope = (at(h) - at(-h)) / (2.0 * h);
            // Round-off of a metre over the step is 1e-7, of the formula h².
            let error = (slope - slopes.column(column)).norm();
            assert!(error < 1e-6 * (1.0 + slope.norm()), "{column}: {error}");
        }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// What the unknowns are off by, frame by frame.
fn errors(found: &HandEye, truth: &Truth) -> Vec<[f64; 6]> {
    std::iter::once((&found.tracker_from_reference, &truth.y))
        .chain(found.body_from_sensor.iter().zip(&truth.x))
        .map(|(found, truth)| {
            let turn = log_quaternion(&(found.rotation * truth.rotation.inverse()));
            let shift = found.translation.vector - truth.translation.vector;
            [turn.x, turn.y, turn.z, shift.x, shift.y, shift.z]
        })
        .collect()
}

/// The squares of the same, over their variances.
fn squares(found: &HandEye, truth: &Truth) -> Vec<f64> {
    let variances = found.covariance.diagonal();
    let errors = errors(found, truth).concat();
    let errors = errors.iter().zip(variances.iter());
    errors.map(|(e, v)| e * e / v).collect()
}

#[test]
fn errors_match_the_covariance_for_normal_noise() {
    let (mut alone, mut of_frames) = (Vec::new(), Vec::new());
    for seed in 0..60 {
        let mut noise = Seeded::new(100 + seed);
        let truth = Truth::new(&mut noise, 2);
        let bodies = bodies(&mut noise, 80);
        let readings = truth.read(&bodies, |pose| noise.around(&pose, 0.5, 0.01));
        let found = hand_eye(&readings, 2, &HandEyeSettings::default()).unwrap();
        for scale in &found.scales {
            // Medians of 80 lengths are within 4 × 8 % of the truth.
            assert!((scale.position_mm / 0.5 - 1.0).abs() < 0.32, "{scale:?}");
            assert!((scale.angle_rad / 0.01 - 1.0).abs() < 0.32, "{scale:?}");
        }
        alone.extend(squares(&found, &truth));
        // A turn of the reference a metre away is a shift of some millimetres: its numbers depend on
        // each other so closely that variances alone would be wrong along most directions.
        let covariances =
            [found.reference_covariance(), found.sensor_covariance(0), found.sensor_covariance(1)];
        of_frames.extend(errors(&found, &truth).into_iter().zip(covariances).map(
            |(error, covariance)| {
                let error = nalgebra::Vector6::from(error);
                error.dot(&covariance.cholesky().unwrap().solve(&error)) / 6.0
            },
        ));
    }
    // A square over its variance has mean 1 and variance 2. Over 60 repeats with 18 unknowns, of which
    // at least three are independent, the mean is known to √(2 / 180) = 0.11; a variance from 80 poses
    // is itself 2 to 3 % low on average.
    let mean_of = mean(&alone);
    assert!((mean_of - 1.03).abs() < 0.33, "{mean_of}");
    // Of six numbers at once the mean is known to √(2 / 6 / 60) = 0.075 by one frame alone; the inverse
    // of a covariance from 80 poses is 80 / 73 of what it should be on average (Wishart), beside the 3 %
    // of above.
    let mean_of = mean(&of_frames);
    assert!((mean_of - 1.13).abs() < 0.25, "{mean_of}");
}

#[test]
fn shared_errors_of_a_pose_are_in_the_covariance() {
    let all = (0..60).flat_map(|seed| {
        let mut noise = Seeded::new(300 + seed);
        let truth = Truth::new(&mut noise, 3);
        let bodies = bodies(&mut noise, 80);
        let mut readings = truth.read(&bodies, |pose| pose);
        for of_pose in readings.chunks_mut(3) {
            let shift = noise.normal_vector() * 2.0;
            for reading in of_pose {
                reading.tracker_from_sensor.translation.vector += shift;
                let read = reading.tracker_from_sensor;
                reading.tracker_from_sensor = noise.around(&read, 0.05, 0.01);
            }
        }
        let found = hand_eye(&readings, 3, &HandEyeSettings::default()).unwrap();
        squares(&found, &truth)
    });
    let mean = mean(&all.collect::<Vec<_>>());
    // As above; a covariance that took the three for independent would be three times too small in
    // what depends on the shifts.
    assert!((mean - 1.03).abs() < 0.33, "{mean}");
}

#[test]
fn intervals_hold_for_errors_that_neighbours_share() {
    for correlation in [0.0, 0.6, 0.9] {
        let (mut within, mut all) = (0_u32, 0_u32);
        for seed in 0..60 {
            let mut noise = Seeded::new(900 + seed);
            let truth = Truth::new(&mut noise, 2);
            // A hand's path, a pose a second: two minutes of it.
            let bodies: Vec<Pose> = (0..120)
                .map(|second| {
                    let wave = |period: f64, phase: f64| {
                        (std::f64::consts::TAU * f64::from(second) / period + phase).sin()
                    };
                    let at = Vector3::new(wave(9.1, 0.0), wave(7.3, 2.0), wave(12.7, 0.5)) * 80.0;
                    let turn = Vector3::new(wave(11.3, 1.0), wave(6.1, 0.3), wave(8.3, 2.0)) * 0.5;
                    pose_from_parts(at - Vector3::z() * 1000.0, exp_vector(&turn))
                })
                .collect();
            let mut readings = truth.read(&bodies, |pose| pose);
            let shifts = noise.autocorrelated(120, correlation);
            let turns = noise.autocorrelated(120, correlation);
            for reading in &mut readings {
                let read = &mut reading.tracker_from_sensor;
                read.translation.vector += shifts[reading.pose];
                read.rotation = exp_vector(&(turns[reading.pose] * 0.01)) * read.rotation;
                *read = noise.around(read, 0.1, 0.002);
            }
            let found = hand_eye(&readings, 2, &HandEyeSettings::default()).unwrap();
            let student = found.effective_size.student_975().unwrap();
            for square in squares(&found, &truth) {
                all += 1;
                within += u32::from(square < student * student);
            }
        }
        // Of 18 numbers of a run some six are independent: four standard deviations of a part of 360.
        let part = f64::from(within) / f64::from(all);
        assert!(part > 0.95 - 0.046, "{correlation}: {part}");
    }
}

#[test]
fn known_noise_weights_readings() {
    let (mut weighted, mut plain) = (0.0, 0.0);
    for seed in 0..20 {
        let mut noise = Seeded::new(500 + seed);
        let truth = Truth::new(&mut noise, 1);
        let bodies = bodies(&mut noise, 40);
        let mut is_poor = false;
        let mut readings = truth.read(&bodies, |pose| {
            is_poor = !is_poor;
            let factor = if is_poor { 10.0 } else { 1.0 };
            noise.around(&pose, 0.1 * factor, 0.002 * factor)
        });
        let scale = Some(Spread::default());
        for (k, reading) in readings.iter_mut().enumerate() {
            let factor = if k % 2 == 0 { 10.0 } else { 1.0 };
            reading.noise.tracker = Spread { position_mm: 0.1 * factor, angle_rad: 0.002 * factor };
        }
        let error = |scale, readings: &[PairedReading]| {
            let settings = HandEyeSettings { scale, ..HandEyeSettings::default() };
            let found = hand_eye(readings, 1, &settings).unwrap();
            distances(&found.body_from_sensor[0], &truth.x[0]).0
        };
        weighted += error(scale, &readings).powi(2);
        for reading in &mut readings {
            reading.noise = ReadingNoise::default();
        }
        let alike = Some(Spread { position_mm: 100.0, angle_rad: 2.0 });
        plain += error(alike, &readings).powi(2);
    }
    // Variances: 1 / (20 + 20 / 100) against (20 + 20 × 100) / 40²: 25 times, of which half is left
    // for chance.
    assert!(plain > 12.0 * weighted, "{plain} {weighted}");
}

#[test]
fn a_third_of_wrong_readings_hardly_moves_the_answer() {
    let mut noise = Seeded::new(7);
    let truth = Truth::new(&mut noise, 2);
    let bodies = bodies(&mut noise, 60);
    let good = truth.read(&bodies, |pose| noise.around(&pose, 0.2, 0.005));
    let mut spoilt = good.clone();
    for reading in spoilt.iter_mut().step_by(3) {
        reading.tracker_from_sensor = noise.pose_within(300.0);
    }
    let clean = hand_eye(&good, 2, &HandEyeSettings::default()).unwrap();
    for loss in [Loss::Cauchy, Loss::Tukey, Loss::Huber] {
        let settings = HandEyeSettings { loss, ..HandEyeSettings::default() };
        let found = hand_eye(&spoilt, 2, &settings).unwrap();
        let (mm, rad) = distances(&found.body_from_sensor[0], &clean.body_from_sensor[0]);
        // Standard errors of the clean answer are 0.03 mm and 0.6 mrad. Huber's loss bounds what a
        // reading pulls but does not end it: a third of them pull by one to two scales.
        let allowed = if loss == Loss::Huber { 0.5 } else { 0.15 };
        assert!(mm < allowed && rad < 0.02 * allowed, "{loss:?}: {mm} {rad}");
    }
}

#[test]
fn the_answer_moves_with_the_frames() {
    let mut noise = Seeded::new(8);
    let truth = Truth::new(&mut noise, 2);
    let bodies = bodies(&mut noise, 30);
    let readings = truth.read(&bodies, |pose| noise.around(&pose, 1.0, 0.02));
    let [tracker, reference, body] = [0; 3].map(|_| noise.pose_within(500.0));
    let moved: Vec<_> = readings
        .iter()
        .map(|r| PairedReading {
            reference_from_body: reference * r.reference_from_body * body,
            tracker_from_sensor: tracker * r.tracker_from_sensor,
            ..*r
        })
        .collect();
    let settings = HandEyeSettings::default();
    let [a, b] = [&readings, &moved].map(|r| hand_eye(r, 2, &settings).unwrap());
    let y = tracker * a.tracker_from_reference * reference.inverse();
    let (mm, rad) = distances(&b.tracker_from_reference, &y);
    // Scales are taken until they stay to 1e-6 of themselves.
    assert!(mm < 1e-4 && rad < 1e-7, "{mm} {rad}");
    for (a_x, b_x) in a.body_from_sensor.iter().zip(&b.body_from_sensor) {
        let (mm, rad) = distances(b_x, &(body.inverse() * a_x));
        assert!(mm < 1e-4 && rad < 1e-7, "{mm} {rad}");
    }
}

#[test]
fn insufficient_motions_are_refused() {
    let mut noise = Seeded::new(10);
    let truth = Truth::new(&mut noise, 1);
    let settings = HandEyeSettings::default();
    let refused = |bodies: &[Pose]| {
        let readings = truth.read(bodies, |pose| pose);
        hand_eye(&readings, 1, &settings).unwrap_err()
    };
    let few = refused(&bodies(&mut noise, 9));
    assert_eq!(few, HandEyeError::TooFewPoses { found: 9, needed: 10 });
    // Shifted anywhere, never turned.
    let start = noise.pose_within(300.0);
    let shifted: Vec<_> = (0..20)
        .map(|_| Pose::from(nalgebra::Translation3::from(noise.normal_vector() * 100.0)) * start)
        .collect();
    let error = refused(&shifted);
    assert!(matches!(error, HandEyeError::NoRotation { largest_deg } if largest_deg < 1e-6));
    assert!(error.to_string().contains("hardly turned"), "{error}");
    // In one plane, turned about its normal; the third axis of the body.
    let planar: Vec<_> = (0..20)
        .map(|i| {
            let turn = exp_vector(&(Vector3::z() * f64::from(i) * 0.1));
            let in_plane =
                Vector3::new(noise.normal_vector().x, noise.normal_vector().x, 0.0) * 100.0;
            start * pose_from_parts(in_plane, turn)
        })
        .collect();
    match refused(&planar) {
        HandEyeError::OneAxis { axis_in_body, axis_in_reference, found_deg, .. } => {
            assert!((axis_in_body - Vector3::z()).norm() < 1e-7, "{axis_in_body}");
            let expected = start.rotation * Vector3::z();
            assert!((axis_in_reference - expected).norm() < 1e-7);
            assert!(found_deg < 1e-4, "{found_deg}");
        }
        other => panic!("{other}"),
    }
    let mut readings = truth.read(&bodies(&mut noise, 20), |pose| pose);
    readings[3].tracker_from_sensor.translation.vector.x = f64::NAN;
    assert_eq!(hand_eye(&readings, 1, &settings), Err(HandEyeError::NoAnswer));
    assert!(matches!(
        hand_eye(&readings, 2, &settings),
        Err(HandEyeError::SensorTooFew { sensor: 1, found: 0, .. })
    ));
}
