//! Rooms without distortion, recorded by made-up trackers: what was put in comes out.

use super::*;
use nalgebra::UnitQuaternion;
use trackwright_field::random_models::Seeded;
use trackwright_geometry::pose::{distances, pose_from_parts};
use trackwright_geometry::rotation::exp_vector;
use trackwright_simulation::recording::Recording;
use trackwright_simulation::recording::{ToolTrack, TrackSample};

const JITTER: Spread = Spread { position_mm: 0.1, angle_rad: 0.002 };

struct Room {
    noise: Seeded,
    y: Pose,
    x: Vec<Pose>,
}

impl Room {
    fn new(seed: u64, sensors: usize) -> Self {
        let mut noise = Seeded::new(seed);
        Self {
            y: noise.pose_within(700.0),
            x: (0..sensors).map(|_| noise.pose_within(25.0)).collect(),
            noise,
        }
    }

    fn sample(&mut self, frame: u64, pose: &Pose) -> TrackSample {
        let read = self.noise.around(pose, JITTER.position_mm, JITTER.angle_rad);
        TrackSample { frame: Some(frame), time_s: None, pose: Ok(read) }
    }

    /// Recordings of a body: poses at seconds, by an Aurora that began later and by a Polaris.
    fn record(&mut self, length_s: f64, later_s: f64, body: impl Fn(f64) -> Pose) -> RecordedPair {
        let mut tools = Vec::new();
        for (k, x) in self.x.clone().into_iter().enumerate() {
            let samples = (0..(40.0 * length_s) as u64)
                .map(|i| (i, body(later_s + i as f64 / 40.0)))
                .map(|(i, body)| self.sample(1000 + 8 * i, &(self.y * body * x)))
                .collect();
            tools.push(ToolTrack { name: format!("Port {k}"), samples });
        }
        let samples = (0..(20.0 * length_s) as u64)
            .map(|i| self.sample(50 + 3 * i, &body(i as f64 / 20.0)))
            .collect();
        let body = ToolTrack { name: "body".to_owned(), samples };
        RecordedPair { tracker: Recording { tools }, reference: Recording { tools: vec![body] } }
    }

    fn still(&mut self) -> RecordedPair {
        let at = Vector3::new(0.0, 0.0, -1000.0) + self.noise.normal_vector() * 100.0;
        let body = pose_from_parts(at, exp_vector(&(self.noise.normal_vector() * 0.6)));
        self.record(1.0, 0.0, |_| body)
    }

    fn stills(&mut self, count: usize) -> Vec<RecordedPair> {
        (0..count).map(|_| self.still()).collect()
    }

    fn path(&mut self, later_s: f64) -> RecordedPair {
        self.path_from(later_s, 0.0, UnitQuaternion::identity())
    }

    /// A part of the same motion that begins later, by a body that is held otherwise.
    fn path_from(
        &mut self,
        later_s: f64,
        start_s: f64,
        turned: UnitQuaternion<f64>,
    ) -> RecordedPair {
        self.record(20.0, later_s, |time_s| {
            let time_s = start_s + time_s;
            let wave = |hz: f64, phase: f64| (std::f64::consts::TAU * hz * time_s + phase).sin();
            let at = Vector3::new(
                60.0 * wave(0.21, 0.0),
                50.0 * wave(0.17, 2.0),
                -1000.0 + 40.0 * wave(0.37, 0.5),
            );
            let turn =
                Vector3::new(0.5 * wave(0.13, 1.0), 0.4 * wave(0.31, 0.3), 0.3 * wave(0.19, 2.0));
            pose_from_parts(at, exp_vector(&turn) * turned)
        })
    }
}

fn found(pairs: &[RecordedPair]) -> Result<Characterisation, CharacterisationError> {
    characterise(pairs, &CharacterisationSettings::default(), &Task::default())
}

#[test]
fn still_poses_give_the_frames() {
    let mut room = Room::new(1, 3);
    let pairs = room.stills(30);
    let found = found(&pairs).unwrap();
    assert_eq!((found.readings.len(), found.pairs.len()), (90, 30));
    for (k, x) in room.x.iter().enumerate() {
        let (mm, rad) = distances(&found.hand_eye.body_from_sensor[k], x);
        let error = found.hand_eye.sensor_error(k);
        // Four standard errors along the worst direction, of three.
        assert!(mm < 4.0 * 3.0_f64.sqrt() * error.position_mm, "{mm} {error:?}");
        assert!(rad < 4.0 * 3.0_f64.sqrt() * error.angle_rad, "{rad} {error:?}");
        // 40 readings of the sensor and 20 of the reference, over 30 poses: some hundredths.
        assert!(error.position_mm < 0.05, "{error:?}");
    }
    for reading in &found.readings {
        // Means of 40 and 20 samples, the reference's turn over a lever of some 40 mm: 0.04 mm.
        assert!(reading.error.position_mm < 0.25, "{reading:?}");
    }
    assert_eq!(found.distances.len(), 3);
    let apart = room.x[0].translation.vector - room.x[2].translation.vector;
    let check = &found.distances[1];
    assert_eq!(check.sensors, [0, 2]);
    assert!((check.check.distance_mm.mean - apart.norm()).abs() < 0.05);
}

#[test]
fn paths_give_the_frames_that_still_poses_give() {
    let mut room = Room::new(2, 2);
    let pairs = [room.path(0.731), room.path(-0.2)];
    let found = found(&pairs).unwrap();
    for (pair, later_s) in found.pairs.iter().zip([0.731, -0.2]) {
        let Ok(PairOutcome::Path(path)) = &pair.outcome else { panic!("{pair:?}") };
        // A straight line between samples 50 ms apart leaves a path of 40 mm and 0.37 Hz by 0.07 mm,
        // the same way before and after a turn, so that it moves no offset.
        assert!(
            (path.offset_s - later_s).abs() < 5.0 * path.offset_std_error_s.max(2e-4),
            "{path:?}"
        );
        assert!(path.offset_std_error_s < 2e-3, "{path:?}");
        assert!(path.after.position_mm < 0.4, "{path:?}");
        assert!(path.before.position_mm > 5.0 * path.after.position_mm);
        assert_eq!(path.faults, Default::default());
    }
    for (k, x) in room.x.iter().enumerate() {
        let (mm, rad) = distances(&found.hand_eye.body_from_sensor[k], x);
        assert!(mm < 0.1 && rad < 2e-3, "{mm} {rad}");
    }
    // A second of a path counts as one pose.
    let last = found.readings.iter().map(|r| r.pose).max();
    assert_eq!(last, Some(39));
}

#[test]
fn what_paths_differ_by_is_in_the_standard_errors() {
    const RUNS: u64 = 6;
    let (mut off_mm2, mut stated_mm2) = (0.0, 0.0);
    for seed in 0..RUNS {
        let mut room = Room::new(60 + seed, 1);
        // The field of each place shifts a whole path alike.
        let pairs: Vec<RecordedPair> = (0..6)
            .map(|k| {
                let (shift, turned) =
                    (room.noise.normal_vector(), exp_vector(&(room.noise.normal_vector() * 0.5)));
                let mut pair = room.path_from(0.3, 40.0 * f64::from(k), turned);
                for sample in &mut pair.tracker.tools[0].samples {
                    if let Ok(pose) = &mut sample.pose {
                        pose.translation.vector += shift;
                    }
                }
                pair
            })
            .collect();
        let found = found(&pairs).unwrap();
        assert_eq!(found.recordings.as_ref().unwrap().groups, 6);
        let (mm, _) = distances(&found.hand_eye.body_from_sensor[0], &room.x[0]);
        let stated = found.sensor_error(0);
        assert!(stated.position_mm >= found.hand_eye.sensor_error(0).position_mm);
        off_mm2 += mm * mm;
        stated_mm2 += stated.position_mm.powi(2);
    }
    // Three components of at most the worst one's variance each, and at least one: of six runs a
    // variance is known to √(2/6), of five degrees of freedom each to less.
    let ratio = off_mm2 / stated_mm2;
    assert!((0.3..4.5).contains(&ratio), "{ratio}");
}

#[test]
fn mismatched_pairs_are_left_out() {
    let mut room = Room::new(3, 2);
    let mut pairs = room.stills(20);
    let clean = found(&pairs).unwrap();
    let mut wrong = room.still();
    wrong.reference = room.still().reference;
    pairs.insert(4, wrong);
    let mut blind = room.still();
    for sample in &mut blind.reference.tools[0].samples {
        sample.pose = Err(Unusable::Missing);
    }
    pairs.push(blind);
    // One sensor is not seen in one pose.
    for sample in &mut pairs[0].tracker.tools[1].samples {
        sample.pose = Err(Unusable::State("Bad Fit".to_owned()));
    }
    let found = found(&pairs).unwrap();
    assert_eq!(found.pairs[4].outcome, Err(PairProblem::AllTooFar));
    assert_eq!(found.pairs[4].too_far, 2);
    assert_eq!(found.pairs[21].outcome, Err(PairProblem::NoReference));
    assert_eq!(found.pairs[0].unusable.values().sum::<usize>(), 40);
    assert_eq!(found.readings.len(), 39);
    let (mm, rad) =
        distances(&found.hand_eye.body_from_sensor[0], &clean.hand_eye.body_from_sensor[0]);
    assert!(mm < 0.02 && rad < 5e-4, "{mm} {rad}");
}

#[test]
fn recordings_that_give_no_room_state_why() {
    let mut room = Room::new(4, 1);
    let pairs = room.stills(12);
    let with = |change: fn(&mut CharacterisationSettings)| {
        let mut settings = CharacterisationSettings::default();
        change(&mut settings);
        characterise(&pairs, &settings, &Task::default()).unwrap_err()
    };
    let error = with(|s| s.sensors = vec!["Port 7".to_owned()]);
    assert!(error.to_string().contains("\"Port 7\""), "{error}");
    let error = with(|s| s.reference_tool = Some("other".to_owned()));
    assert!(matches!(error, CharacterisationError::ReferenceTool { pair: 0, .. }));
    let error = with(|s| s.kind = Some(PairKind::Path));
    assert!(matches!(
        error,
        CharacterisationError::NoPairs { pairs: 12, first: PairProblem::Alignment(_) }
    ));
    let error = with(|s| s.hand_eye.min_poses = 13);
    assert_eq!(error, HandEyeError::TooFewPoses { found: 12, needed: 13 }.into());
    let moved = room.path(0.0);
    let settings = CharacterisationSettings {
        kind: Some(PairKind::Still),
        ..CharacterisationSettings::default()
    };
    let error = characterise(&[moved], &settings, &Task::default()).unwrap_err();
    assert!(matches!(error, CharacterisationError::NoPairs { first: PairProblem::Moved, .. }));
    // A 5-DOF sensor's quaternion has no turn about z.
    let mut five = room.stills(12);
    for sample in five.iter_mut().flat_map(|p| &mut p.tracker.tools[0].samples) {
        let turn = exp_vector(&Vector3::new(0.3, 0.4, 0.0));
        sample.pose = sample.pose.clone().map(|p| pose_from_parts(p.translation.vector, turn));
    }
    let error = found(&five).unwrap_err().to_string();
    assert!(error.contains("a 5-DOF sensor"), "{error}");
    assert!(matches!(
        found(&[]),
        Err(CharacterisationError::HandEye(HandEyeError::TooFewPoses { found: 0, .. }))
    ));
}

#[test]
fn held_out_pairs_do_not_change_the_frames() {
    let mut room = Room::new(12, 2);
    let pairs = room.stills(36);
    let held = HeldOut { part: 1, of: 3 };
    let settings =
        CharacterisationSettings { held_out: Some(held), ..CharacterisationSettings::default() };
    let found = characterise(&pairs, &settings, &Task::default()).unwrap();
    let others: Vec<_> = (0..36).filter(|pair| pair % 3 != 1).collect();
    let rest: Vec<RecordedPair> = others.iter().map(|pair| pairs[*pair].clone()).collect();
    let alone = characterise(&rest, &CharacterisationSettings::default(), &Task::default());
    let alone = alone.unwrap();
    assert_eq!(found.hand_eye, alone.hand_eye);
    assert_eq!(found.readings.len(), alone.readings.len());
    assert!(alone.held_out.is_empty());
    let mut of_pairs: Vec<usize> = found.held_out.iter().map(|r| r.pair).collect();
    of_pairs.dedup();
    assert_eq!(of_pairs, (0..12).map(|k| 3 * k + 1).collect::<Vec<_>>());
    assert!(found.readings.iter().all(|r| others.contains(&r.pair)));
    // A room without distortion: jitter of means, and what the frames are off by.
    assert!(found.held_out.iter().all(|r| r.error.position_mm < 0.5));
}
