//! Regions whose shape follows from the field, and the study itself at lattice points.

use crate::support::studies::{
    body, built_in, cancelled, in_polynomial_room, on_threads, one_direction, room, sensor, study,
    tool_alone,
};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;
use trackwright_field::{Environment, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_geometry::volume::Volume;
use trackwright_simulation::usable_region::*;
use trackwright_simulation::{
    CancelToken, InputTrial, Metric, Mode, Requirement, Scenario, SensorOrientation, StudyError,
    expected,
};
use trackwright_task::Task;

const SIZE_MM: f64 = 200.0;

/// From the tip to the one sensor.
const ARM_MM: [f64; 3] = [10.0, -20.0, 30.0];

/// A tool with one 6-DOF sensor in a room that shifts and does not turn, so that its tip error is
/// the sensor's position error; at most `limit_mm` of it is good enough.
fn scenario(order: usize, shift_x_mm: Vec<f64>, limit_mm: f64) -> Scenario {
    let bounds = Bounds::from(([0.0; 3], [SIZE_MM; 3]));
    let coefficients = shift_x_mm.iter().map(|x| [*x, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let model = one_direction(order, bounds, coefficients.collect());
    let inner = Bounds {
        // Far enough from the box's faces for the sensor to be in it too.
        min_mm: bounds.min_mm + Vector3::repeat(30.0),
        max_mm: bounds.max_mm - Vector3::repeat(30.0),
    };
    let room = Environment { volume: Some(Volume::Box(inner)), ..room(model) };
    let sensor = sensor(ARM_MM, SensorOrientation::SixDof(UnitQuaternion::identity()));
    Scenario {
        requirement: Some(Requirement::at_most([(Metric::TIP_RMS, limit_mm)])),
        ..tool_alone(room, body(vec![sensor], None), Pose::identity())
    }
}

/// 4 mm at x = 200 mm, none at 0.
fn slope(limit_mm: f64) -> Scenario {
    let translations_mm = (0..8).map(|i| 4.0 * f64::from(i / 4)).collect();
    scenario(1, translations_mm, limit_mm)
}

fn region(scenario: &Scenario, counts: [usize; 3]) -> UsableRegion {
    usable_region(scenario, counts, RegionBasis::OwnField, &Task::default()).unwrap()
}

#[test]
fn a_linear_error_bounds_the_region_by_a_plane() {
    let region = region(&slope(1.9), [6, 5, 4]);
    // The sensor at 95 mm, the tip 10 mm before it; the volume begins at 30 mm and is 140 mm long.
    assert!(region.surface.triangles.len() >= 2 * 4 * 3);
    for (p, n) in region.surface.positions_mm.iter().zip(&region.surface.normals) {
        assert!((p.x - 85.0).abs() < 1e-9, "{p}");
        assert!((n - Vector3::x()).norm() < 1e-9);
    }
    assert!((region.fraction - 55.0 / 140.0).abs() < 1e-10);
    assert!((region.volume_cm3 - 5.5 * 14.0 * 14.0).abs() < 1e-7);
    assert_eq!((region.orientations, region.all_orientations), (1, 1));
    assert_eq!(region.work.region_evaluations, 6 * 5 * 4 + 1);
    assert!(region.is_inside.iter().all(|inside| *inside));
}

#[test]
fn a_quadratic_error_gives_an_ellipsoidal_region() {
    // 4 f (x - 1/2)² in Bernstein form of order 2 is f, -f, f.
    let steep = [8.0, 6.0, 5.0];
    let ends = [1.0, -1.0, 1.0];
    let translations_mm = (0..27).map(|i| {
        let at = [i / 9, i / 3 % 3, i % 3];
        (0..3).map(|k| steep[k] * ends[at[k]]).sum::<f64>()
    });
    let limit = 0.5;
    let counts = [25, 29, 22];
    let region = region(&scenario(2, translations_mm.collect(), limit), counts);
    let center = Point3::new(100.0, 100.0, 100.0) - Vector3::from(ARM_MM);
    // mm of error a mm² along each axis.
    let curvature = steep.map(|f| 4.0 * f / (SIZE_MM * SIZE_MM));
    let error = |p: &Point3<f64>| -> f64 {
        let squares = (p - center).map(|d| d * d);
        (0..3).map(|k| curvature[k] * squares[k]).sum()
    };
    // Between lattice points the share is too large by at most this.
    let most: f64 =
        (0..3).map(|k| curvature[k] * (140.0 / (counts[k] - 1) as f64).powi(2) / 4.0).sum();
    assert!(most < 0.1 * limit);
    for p in &region.surface.positions_mm {
        let error = error(p);
        assert!((limit - most..=limit + 1e-9).contains(&error), "{error}");
    }
    let ellipsoid_cm3 = |level: f64| {
        let axes: f64 = curvature.iter().map(|c| (level / c).sqrt()).product();
        4.0 / 3.0 * PI * axes / 1e3
    };
    let bounds = ellipsoid_cm3(limit - most)..ellipsoid_cm3(limit);
    assert!(bounds.contains(&region.volume_cm3), "{bounds:?}");
}

#[test]
fn a_full_or_empty_region_has_no_surface() {
    let everywhere = region(&slope(4.1), [3, 3, 3]);
    assert!(everywhere.surface.triangles.is_empty());
    assert_eq!(everywhere.fraction, 1.0);
    assert!((everywhere.volume_cm3 - 14.0_f64.powi(3)).abs() < 1e-9);
    let nowhere = region(&slope(0.1), [3, 3, 3]);
    assert!(nowhere.surface.triangles.is_empty());
    assert_eq!((nowhere.fraction, nowhere.volume_cm3), (0.0, 0.0));
}

#[test]
fn each_point_equals_a_study_with_the_tip_there() {
    let scenario = built_in("shaver-on-head");
    let region = region(&scenario, [5, 4, 5]);
    assert_eq!((region.orientations, region.all_orientations), (27, 125));
    let grid = scenario.motion_grid().unwrap().unwrap();
    let tip_in_tool = scenario.tool.judged_tip_in_body().coords;
    let tracker_from_crf = scenario.crf.as_ref().unwrap().tracker_from_crf;
    // The first, third and last of the five angles about each axis.
    let tool_rotations: Vec<_> = (0..125)
        .filter(|i| [i / 25, i / 5 % 5, i % 5].iter().all(|angle| angle % 2 == 0))
        .map(|i| grid.pose(i).rotation)
        .collect();
    for place in [0, 37, 62, 99] {
        let tip = tracker_from_crf.inverse() * region.share.point_mm(region.share.index(place));
        let trials: Vec<_> = tool_rotations
            .iter()
            .map(|rotation| {
                InputTrial::at(Pose::from_parts(
                    (tip.coords - rotation * tip_in_tool).into(),
                    *rotation,
                ))
            })
            .collect();
        let outcome = study(&scenario, &Mode::Input(trials.into()));
        let found = &outcome.room_field;
        let requirement = scenario.requirement.unwrap();
        let checks = requirement.checks(&found.position_mm, &found.angle_deg).into_iter();
        let share = checks.map(|c| c.value / c.limit).fold(0.0, f64::max);
        let found = region.share.values[place];
        assert!((found - share).abs() < 1e-11 * share, "{found} {share}");
        assert_eq!(region.is_inside[place], outcome.room_field.outside == 0);
    }
}

#[test]
fn regions_are_cancellable_and_independent_of_threads() {
    let scenario = built_in("pointer-on-head");
    let on = |threads| on_threads(threads, || region(&scenario, [9, 8, 7]));
    assert_eq!(on(1), on(3));
    let stopped = usable_region(&scenario, [9, 8, 7], RegionBasis::OwnField, &cancelled());
    assert_eq!(stopped, Err(RegionError::Study(StudyError::Cancelled)));
}

#[test]
fn where_all_trials_are_left_out_nothing_is_usable() {
    let mut scenario = slope(4.1);
    scenario.outside = OutsidePolicy::Reject;
    let environment = Arc::make_mut(&mut scenario.environment);
    environment.volume = Some(Volume::Box(Bounds::from(([0.0; 3], [SIZE_MM; 3]))));
    let region = region(&scenario, [21, 21, 21]);
    // The sensor is in the box for tips up to 190 mm along x, from 20 mm along y, up to 170 mm
    // along z: all of them planes of the lattice.
    assert!((region.volume_cm3 - 19.0 * 18.0 * 17.0).abs() < 1e-6);
    assert!(region.share.values.iter().any(|share| share.is_infinite()));
}

/// The room of [`scenario`] with another box, so that a tracker's own volume fits into it.
fn large(min_mm: [f64; 3], max_mm: [f64; 3], volume: Volume, limit_mm: f64) -> Scenario {
    let mut scenario = slope(limit_mm);
    let environment = Arc::make_mut(&mut scenario.environment);
    let (order, old) = (environment.model.order(), environment.model.coefficients().to_vec());
    environment.model = one_direction(order, Bounds::from((min_mm, max_mm)), old);
    environment.volume = Some(volume);
    scenario
}

#[test]
fn region_fractions_are_those_of_the_dome_volume() {
    // The error grows from 0 to 4 mm along x; with the tip at x = 0 the sensor is in the middle.
    let [min, max] = [[-590.0, -600.0, -700.0], [610.0, 600.0, 0.0]];
    let dome = |limit_mm| large(min, max, Volume::AuroraDome, limit_mm);
    let half = region(&dome(2.0), [25, 25, 25]);
    // The lattice's tetrahedra are not those of its mirror image, so its dome is not quite even.
    assert!((half.fraction - 0.5).abs() < 5e-4, "{}", half.fraction);
    let whole_cm3 = Volume::AuroraDome.volume_mm3() / 1e3;
    assert!((half.volume_cm3 - half.fraction * whole_cm3).abs() < 1e-9 * whole_cm3);
    let dome_itself = Volume::AuroraDome.excess_mm().unwrap();
    for p in &half.surface.positions_mm {
        assert!(p.x.abs() < 1e-9, "{p}");
        // Between lattice points 40 mm apart the dome's chords lie within it.
        assert!(dome_itself(p) < 1e-9, "{p}");
    }
    let cut = Bounds::around(half.surface.positions_mm.iter().copied()).unwrap();
    assert!(cut.max_mm.y > 478.0 && cut.min_mm.y < -478.0, "{cut:?}");
    // Points that no cell of the dome has are not evaluated.
    assert!(half.work.region_evaluations < 15 * 25 * 25 * 25 / 16);
    let all = region(&dome(4.1), [7, 6, 5]);
    assert_eq!(all.fraction, 1.0);
    assert!((all.volume_cm3 - whole_cm3).abs() < 1e-9 * whole_cm3);
    assert!(all.surface.triangles.is_empty());
}

#[test]
fn without_a_requirement_there_is_no_region() {
    let mut scenario = slope(1.0);
    let none = usable_region(&scenario, [1, 3, 3], RegionBasis::Interval, &Task::default());
    assert_eq!(none, Err(RegionError::Counts { counts: [1, 3, 3] }));
    for requirement in [None, Some(Requirement::default())] {
        scenario.requirement = requirement;
        let none = usable_region(&scenario, [3, 3, 3], RegionBasis::Interval, &Task::default());
        assert_eq!(none, Err(RegionError::NoRequirement));
    }
}

#[test]
fn intervals_leave_less_than_the_rooms_own_field() {
    let mut scenario = in_polynomial_room("shaver-on-head");
    scenario.requirement =
        Some(Requirement::at_most([(Metric::TIP_RMS, 1.0), (Metric::ANGLE_RMS, 1.0)]));
    let counts = [9, 9, 9];
    let own = region(&scenario, counts);
    let both = usable_region(&scenario, counts, RegionBasis::Interval, &Task::default()).unwrap();
    assert_eq!(own.share, both.share);
    assert_eq!((own.interval_points, both.interval_points), (0, 125));
    assert!(both.fraction < own.fraction, "{} {}", both.fraction, own.fraction);
    let upper = both.upper_share.unwrap();
    let pairs = || upper.values.iter().zip(&own.share.values);
    assert!(pairs().all(|(upper, own)| upper >= own));
    // Between the points of the coarse lattice, against intervals that are found there.
    let tool_rotations = rotations(&scenario).unwrap().0;
    let crf_from_tracker = scenario.crf.as_ref().unwrap().tracker_from_crf.inverse();
    let with_tip_at = |tip: &Point3<f64>, rotation: &UnitQuaternion<f64>| {
        let arm = rotation * scenario.tool.tip_in_body.unwrap().coords;
        pose_from_parts((crf_from_tracker * tip).coords - arm, *rotation)
    };
    let mut off: Vec<f64> = [101, 193, 331, 373, 415, 529, 613]
        .into_iter()
        .map(|place| {
            let index = upper.index(place);
            assert!(index.iter().any(|i| i % 2 == 1));
            let tip = upper.point_mm(index);
            let trials =
                tool_rotations.iter().map(|rotation| InputTrial::at(with_tip_at(&tip, rotation)));
            let mode = Mode::Input(trials.collect());
            let found = expected(&scenario, &mode, &CancelToken::default()).unwrap();
            let upper_of = |metric: Metric| (found.continued[metric.index()][1], 1.0);
            let share = [upper_of(Metric::TIP_RMS), upper_of(Metric::ANGLE_RMS)];
            (upper.values[place] / share_of(share.into_iter()) - 1.0).abs()
        })
        .collect();
    off.sort_unstable_by(f64::total_cmp);
    assert!(off[3] < 0.12 && off[6] < 0.3, "{off:?}");
}

#[test]
fn without_measurements_a_region_uses_its_own_field() {
    let scenario = slope(1.9);
    let basis = RegionBasis::Interval;
    let found = usable_region(&scenario, [6, 5, 4], basis, &Task::default()).unwrap();
    assert_eq!(found, region(&scenario, [6, 5, 4]));
}
