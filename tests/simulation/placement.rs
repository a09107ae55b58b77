//! Places against the study itself with the sensor moved there.

use crate::support::studies::on_threads;
use nalgebra::{Point3, Vector3};
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::surface::{Ray, Surface, SurfacePoint};
use trackwright_simulation::placement::*;
use trackwright_simulation::work::Work;
use trackwright_simulation::{
    CancelToken, Metric, Mode, Motion, Scenario, SensorOrientation, StudyError, expected, run,
};
use trackwright_task::Task;

fn built_in(name: &str, body: PlacedBody) -> (Scenario, Vec<SurfacePoint>) {
    let world = trackwright_project::open_builtin(name).unwrap();
    let role = match body {
        PlacedBody::Tool => BodyRole::Tool,
        PlacedBody::Crf => BodyRole::Crf,
    };
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    (scenario, vertices(world.mesh(role).unwrap()))
}

fn plan(body: PlacedBody, rule: AxisRule, candidates: &[SurfacePoint]) -> PlacementPlan {
    let (candidates, depth) = (candidates.into(), CoilDepth::Surface);
    PlacementPlan { body, sensor: 1, rule, candidates, depth, surface: None }
}

/// All pictures of a placement, the last one its outcome.
fn pictures(scenario: &Scenario, plan: &PlacementPlan) -> Vec<PlacementOutcome> {
    let mut pictures = Vec::new();
    let mut keep = |picture: &PlacementOutcome| pictures.push(picture.clone());
    let outcome = place(scenario, plan, &Task::default(), &mut keep).unwrap();
    assert_eq!(pictures.last(), Some(&outcome));
    pictures
}

fn placed(scenario: &Scenario, plan: &PlacementPlan) -> PlacementOutcome {
    place(scenario, plan, &Task::default(), &mut |_| {}).unwrap()
}

/// The design with the sensor moved to a place.
fn moved(scenario: &Scenario, plan: &PlacementPlan, at: &SurfacePoint) -> Scenario {
    let mut moved = scenario.clone();
    let body = match plan.body {
        PlacedBody::Tool => &mut moved.tool,
        PlacedBody::Crf => &mut moved.crf.as_mut().unwrap().body,
    };
    body.sensors[plan.sensor] = plan.rule.placed(&body.sensors[plan.sensor], at);
    moved
}

/// The study with the sensor moved to a place.
fn studied_mm(scenario: &Scenario, plan: &PlacementPlan, at: &SurfacePoint) -> Option<f64> {
    let mode = if scenario.motion.is_some() { Mode::Motion } else { Mode::Single };
    let outcome = run(&moved(scenario, plan, at), &mode, &CancelToken::default(), None);
    outcome.ok().map(|o| o.room_field.position_mm.rms())
}

/// A place has the figure of the study with the sensor moved there, but for the order of a sum of
/// thousands of squares.
#[track_caller]
fn assert_studied(scenario: &Scenario, plan: &PlacementPlan, at: &SurfacePoint, place: &Placement) {
    let studied = studied_mm(scenario, plan, at).unwrap();
    let found = place.tip_rms_mm.unwrap();
    assert!((found - studied).abs() < 1e-12 * studied, "{plan:?}: {found} {studied}");
}

#[test]
fn a_full_placement_is_a_study_with_the_sensor_moved() {
    for name in ["pointer-on-head", "shaver-on-head"] {
        for body in [PlacedBody::Tool, PlacedBody::Crf] {
            let (scenario, all) = built_in(name, body);
            let some: Vec<_> = all.iter().step_by(all.len() / 20).copied().collect();
            for rule in [AxisRule::Keep, AxisRule::Normal, AxisRule::Tangent] {
                let plan = plan(body, rule, &some);
                let outcome = placed(&scenario, &plan);
                assert_eq!((outcome.full, outcome.trials), (some.len(), 3375));
                assert!(outcome.is_final && some.len() >= 20);
                for (at, place) in some.iter().zip(&outcome.places) {
                    assert_studied(&scenario, &plan, at, place);
                }
            }
        }
    }
}

#[test]
fn marker_placement_is_the_same_under_every_axis_rule() {
    let (mut scenario, all) = built_in("pointer-on-head", PlacedBody::Tool);
    for sensor in &mut scenario.tool.sensors {
        sensor.orientation = SensorOrientation::Marker;
    }
    // Two would leave a turn free.
    let mut third = scenario.tool.sensors[0].clone();
    third.position_in_body += Vector3::new(20.0, 5.0, 30.0);
    scenario.tool.sensors.push(third);
    let some: Vec<_> = all.iter().step_by(all.len() / 5).copied().collect();
    let keep = placed(&scenario, &plan(PlacedBody::Tool, AxisRule::Keep, &some));
    for rule in [AxisRule::Normal, AxisRule::Tangent] {
        let plan = plan(PlacedBody::Tool, rule, &some);
        assert_eq!(placed(&scenario, &plan).places, keep.places);
        for (at, place) in some.iter().zip(&keep.places) {
            assert_studied(&scenario, &plan, at, place);
        }
    }
}

/// A sensor of a built-in tool imagined below every vertex, and the tool's mesh for that.
fn imagined(name: &str, sensor: usize, depth: CoilDepth) -> (Scenario, PlacementPlan, SurfaceMesh) {
    let world = trackwright_project::open_builtin(name).unwrap();
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    let mesh = world.mesh(BodyRole::Tool).unwrap();
    let mesh = placement_mesh(mesh).unwrap_or_else(|| SurfaceMesh::clone(mesh));
    let candidates = depth.places(&mesh, &scenario.tool.sensors[sensor].position_in_body).into();
    let (body, rule) = (PlacedBody::Tool, AxisRule::Keep);
    (scenario, PlacementPlan { body, sensor, rule, candidates, depth, surface: None }, mesh)
}

#[test]
fn in_the_bore_the_map_shows_the_figure() {
    // Of each sensor of the pointer, beside which side of the body it is.
    for (sensor, out) in [(0, -Vector3::y_axis()), (1, -Vector3::y_axis()), (2, Vector3::y_axis())]
    {
        let off = |depth: CoilDepth| {
            let (scenario, plan, mesh) = imagined("pointer-on-head", sensor, depth);
            let outcome = placed(&scenario, &plan);
            // What is painted on the body there.
            let at = scenario.tool.sensors[sensor].position_in_body;
            let surface = Surface::new(&mesh).unwrap();
            let ray = Ray { origin_mm: at + out.into_inner() * 50.0, direction: -out };
            let hit = surface.hit(&ray).unwrap();
            let shown_mm = outcome.between(hit.corners, hit.weights).unwrap();
            let corners = hit.corners.into_iter().zip(hit.weights);
            let own_mm: f64 = corners
                .map(|(corner, weight)| outcome.places[corner].tip_rms_mm.unwrap() * weight)
                .sum();
            let figure = expected(&scenario, &Mode::Motion, &CancelToken::default()).unwrap();
            let part = |shown_mm: f64, is_mm: f64| (shown_mm - is_mm).abs() / is_mm;
            let own = part(own_mm, figure.own_of(Metric::TIP_RMS));
            (own, part(shown_mm, figure.of(Metric::TIP_RMS).0))
        };
        let (own, shown) = off(CoilDepth::Own);
        // A sensor that moves by half a millimetre changes its own figure by a thousandth, and the
        // expected one, a mean over some drawn fields, by two hundredths.
        assert!(own < 0.01 && shown < 0.04, "{sensor}: {own} {shown}");
        if sensor == 2 {
            let (_, on_surface) = off(CoilDepth::Surface);
            assert!(on_surface > 2.0 * shown, "{on_surface}: three millimetres above the sensor");
        }
    }
}

#[test]
fn the_best_place_is_a_study_with_the_sensor_there() {
    for (name, depth) in [("pointer-on-head", CoilDepth::Own), ("endoscope", CoilDepth::Surface)] {
        let (mut scenario, plan, _) = imagined(name, 1, depth);
        let outcome = placed(&scenario, &plan);
        let best = outcome.best.clone().unwrap();
        assert_eq!(best.placement, outcome.places[best.candidate]);
        assert!(best.placement.basis == Basis::Full && !best.placement.is_outside);
        let own = scenario.tool.sensors[1].clone();
        let at = &plan.candidates[best.candidate];
        assert_eq!(best.sensor, plan.rule.placed(&own, at));
        scenario.tool.sensors[1] = best.sensor;
        let cancel = CancelToken::default();
        let own_mm =
            run(&scenario, &Mode::Motion, &cancel, None).unwrap().room_field.position_mm.rms();
        let promised_mm = best.placement.tip_rms_mm.unwrap();
        assert!((own_mm - promised_mm).abs() < 1e-12 * own_mm, "{own_mm} {promised_mm}");
        let (figure_mm, ends_mm) =
            expected(&scenario, &Mode::Motion, &cancel).unwrap().of(Metric::TIP_RMS);
        let promised = best.placement.expected.unwrap();
        assert_eq!((figure_mm, ends_mm), (promised.rms_mm, promised.interval_mm));
        // No place that the map shows as better was left out.
        let least = outcome.range_mm().unwrap()[0];
        assert!(figure_mm <= least * 1.05, "{figure_mm} {least}");
    }
}

#[test]
fn values_between_vertices_are_linear_on_the_triangle() {
    let world = trackwright_project::open_builtin("pointer-on-head").unwrap();
    let mesh = world.mesh(BodyRole::Tool).unwrap();
    let surface = Surface::new(mesh).unwrap();
    // A field that is linear in space is its own interpolation on every triangle.
    let linear = |p: &Point3<f64>| 100.0 + 0.3 * p.x - 0.2 * p.y + 0.01 * p.z;
    let mut outcome = PlacementOutcome {
        places: vertices(mesh)
            .iter()
            .map(|vertex| Placement {
                tip_rms_mm: Some(linear(&vertex.position_mm)),
                basis: Basis::Full,
                expected: None,
                is_outside: false,
            })
            .collect(),
        full: 0,
        trials: 1,
        best: None,
        fits_nowhere: false,
        is_final: true,
        work: Work::default(),
    };
    let mut hits = 0;
    for (i, vertex) in vertices(mesh).iter().enumerate().step_by(97) {
        // From outside, a little beside the vertex.
        let beside = Vector3::new(0.11, 0.07, 0.13) * (i % 3) as f64;
        let ray = Ray {
            origin_mm: vertex.position_mm + vertex.normal.into_inner() * 30.0 + beside,
            direction: -vertex.normal,
        };
        let (Some(hit), Some(point)) = (surface.hit(&ray), surface.cast(&ray)) else { continue };
        let value = outcome.between(hit.corners, hit.weights).unwrap();
        assert!((value - linear(&point.position_mm)).abs() < 1e-9, "{value}");
        assert!((ray.at(hit.distance_mm) - point.position_mm).norm() < 1e-9);
        hits += 1;
    }
    assert!(hits > 50, "{hits}");
    outcome.places[0].tip_rms_mm = None;
    assert_eq!(outcome.between([0, 1, 2], [0.2, 0.3, 0.5]), None);
    assert!(outcome.between([0, 1, 2], [0.0, 0.5, 0.5]).is_some());
}

#[test]
fn approximate_placements_state_their_error() {
    let (scenario, all) = built_in("shaver-on-head", PlacedBody::Tool);
    // Where the axis stays, values are smooth along the surface; where it follows the normal, some
    // vertices hardly determine the tool's roll, and trials swing far at some of the poses.
    for (rule, half, most) in [(AxisRule::Keep, 0.001, 0.005), (AxisRule::Normal, 0.02, 0.15)] {
        let plan = plan(PlacedBody::Tool, rule, &all);
        // The last one adds expected values.
        let [first, _, _, outcome] = &pictures(&scenario, &plan)[..] else { panic!("four") };
        assert!(outcome.is_final && !first.is_final && first.full < outcome.full);
        let is_full = |i: &usize| outcome.places[*i].basis == Basis::Full;
        let (full, between): (Vec<usize>, Vec<usize>) = (0..all.len()).partition(is_full);
        let (mut offs, mut beyond) = (Vec::new(), 0);
        for &i in between.iter().step_by(between.len() / 24) {
            let studied = studied_mm(&scenario, &plan, &all[i]).unwrap();
            let off = (outcome.places[i].tip_rms_mm.unwrap() - studied).abs();
            let Basis::Approximate { error_mm } = outcome.places[i].basis else {
                unreachable!();
            };
            beyond += usize::from(off > error_mm);
            offs.push(off / studied);
        }
        offs.sort_by(f64::total_cmp);
        let (median, worst) = (offs[offs.len() / 2], offs[offs.len() - 1]);
        assert!(median < half && worst < most, "{rule:?}: {median} {worst}");
        assert!(beyond <= 2, "{rule:?}: {beyond} of {}", offs.len());
        // Full ones among many are the study too.
        for &i in full.iter().step_by(full.len() / 4) {
            assert_studied(&scenario, &plan, &all[i], &outcome.places[i]);
        }
    }
}

#[test]
fn what_does_not_change_is_computed_once() {
    let (scenario, all) = built_in("pointer-on-head", PlacedBody::Tool);
    let still = Scenario { motion: None, ..scenario.clone() };
    let some = &all[..50];
    let different: std::collections::HashSet<_> =
        some.iter().map(|at| at.position_mm.coords.map(f64::to_bits)).collect();
    let (n, tool) = (different.len() as u64, scenario.tool.sensors.len() as u64);
    let crf = scenario.crf.as_ref().unwrap().body.sensors.len() as u64;
    let work = placed(&still, &plan(PlacedBody::Tool, AxisRule::Keep, some)).work;
    // Once for all poses and once for the few.
    assert_eq!(work.placement_evaluations, n + 2 * (tool - 1 + crf));
    assert_eq!(work.reading_reuses, n * (tool - 1));
    assert_eq!((work.study_evaluations, work.frame_fits), (0, n + 2));
    let work = placed(&scenario, &plan(PlacedBody::Crf, AxisRule::Keep, some)).work;
    assert_eq!(work.reading_reuses, n * (crf - 1));
    // The tool at 3,375 and 64 poses and at the design's own; the CRF three times.
    let once = (3375 + 64 + 2) * tool + 2 * 3 * crf;
    assert_eq!(work.placement_evaluations, n + once);
}

#[test]
fn without_distortion_no_place_has_an_error() {
    for body in [PlacedBody::Tool, PlacedBody::Crf] {
        let (mut scenario, all) = built_in("shaver-on-head", body);
        let environment = Arc::make_mut(&mut scenario.environment);
        let (bounds, map) = (*environment.model.bounds(), environment.model.map());
        environment.model = DistortionModel::zero(bounds, map);
        environment.process = None;
        let outcome = placed(&scenario, &plan(body, AxisRule::Normal, &all[..100]));
        // Round-off of coordinates of some hundred mm.
        assert!(outcome.range_mm().unwrap()[1] < 1e-11);
    }
}

#[test]
fn placements_outside_are_marked_or_have_no_value() {
    for body in [PlacedBody::Tool, PlacedBody::Crf] {
        let (clamped, all) = built_in("pointer-on-head", body);
        let far = |y: f64| SurfacePoint { position_mm: Point3::new(0.0, y, 0.0), ..all[0] };
        let some = [all[0], far(2e3), far(f64::NAN)];
        let plan = plan(body, AxisRule::Keep, &some);
        let places = placed(&clamped, &plan).places;
        assert!(!places[0].is_outside && places[1].is_outside && places[2].is_outside);
        assert!(places[1].tip_rms_mm.unwrap() > places[0].tip_rms_mm.unwrap());
        assert_eq!(places[2].tip_rms_mm, None);
        let rejecting = Scenario { outside: OutsidePolicy::Reject, ..clamped.clone() };
        let places = placed(&rejecting, &plan).places;
        assert_eq!(places[1].tip_rms_mm, None);
        assert_eq!(studied_mm(&rejecting, &plan, &some[1]), None);
        assert_studied(&rejecting, &plan, &some[0], &places[0]);
    }
}

#[test]
fn places_hang_on_no_number_of_threads() {
    let (scenario, all) = built_in("shaver-on-head", PlacedBody::Tool);
    // Few enough for little time; the first picture is mixed from 24 of them.
    let some: Vec<_> = all.iter().step_by(all.len() / 150).copied().collect();
    for body in [PlacedBody::Tool, PlacedBody::Crf] {
        let plan = plan(body, AxisRule::Tangent, &some);
        let on = |threads| on_threads(threads, || pictures(&scenario, &plan));
        assert_eq!(on(1), on(3));
    }
}

#[test]
fn a_place_that_nobody_wants_any_more_is_given_up() {
    let (scenario, all) = built_in("shaver-on-head", PlacedBody::Tool);
    let task = Task::default();
    let mut pictures = 0;
    let plan = plan(PlacedBody::Tool, AxisRule::Keep, &all);
    let stopped = place(&scenario, &plan, &task, &mut |_| {
        pictures += 1;
        task.cancel.cancel();
    });
    let cancelled = PlacementError::Study(StudyError::Cancelled);
    assert_eq!((stopped, pictures), (Err(cancelled), 1));
}

#[test]
fn a_sensor_that_is_not_there_is_named() {
    let (scenario, all) = built_in("pointer-on-head", PlacedBody::Tool);
    let mut wrong = plan(PlacedBody::Tool, AxisRule::Keep, &all[..1]);
    wrong.sensor = 17;
    let error = place(&scenario, &wrong, &Task::default(), &mut |_| {}).unwrap_err();
    assert!(error.to_string().starts_with("sensor 17 of "), "{error}");
    let alone = Scenario { crf: None, ..scenario };
    let of_crf = plan(PlacedBody::Crf, AxisRule::Keep, &all[..1]);
    let error = place(&alone, &of_crf, &Task::default(), &mut |_| {}).unwrap_err();
    assert_eq!(error, PlacementError::NoCrf);
}

#[test]
fn a_long_motion_is_sampled_and_reported_as_such() {
    let (scenario, all) = built_in("pointer-on-head", PlacedBody::Tool);
    let mut motion = scenario.motion.unwrap();
    for axis in [&mut motion.x, &mut motion.y, &mut motion.rx] {
        let range = axis.as_mut().unwrap();
        range.step = (range.max - range.min) / 11.0;
    }
    let long = Scenario { motion: Some(Motion { z: None, ..motion }), ..scenario };
    let some: Vec<_> = all.iter().step_by(all.len() / 4).copied().collect();
    let plan = plan(PlacedBody::Tool, AxisRule::Keep, &some);
    let outcome = placed(&long, &plan);
    assert_eq!(outcome.trials, 12 * 12 * 12 * 25);
    // Whole studies look for the best place alone.
    assert!(outcome.full <= 8, "{}", outcome.full);
    for (at, place) in some.iter().zip(&outcome.places) {
        let studied = studied_mm(&long, &plan, at).unwrap();
        let off = (place.tip_rms_mm.unwrap() - studied).abs();
        let error_mm = match place.basis {
            Basis::Approximate { error_mm } => error_mm,
            // One of those that were looked at as the best.
            Basis::Full => 1e-9,
        };
        // Few nodes do not see where the field bends, at the edges of spherical triangles.
        assert!(off <= error_mm, "{off} {error_mm} {studied}");
        assert!(off < 0.005 * studied, "{off} {studied}");
    }
}

#[test]
fn expected_places_are_near_the_expected_study() {
    let world = trackwright_project::open_builtin("pointer-on-head").unwrap();
    assert!(world.environment.process.is_some());
    for (body, rule) in [
        (PlacedBody::Tool, AxisRule::Keep),
        (PlacedBody::Tool, AxisRule::Normal),
        (PlacedBody::Crf, AxisRule::Keep),
    ] {
        let (scenario, all) = built_in("pointer-on-head", body);
        let plan = plan(body, rule, &all);
        let pictures = pictures(&scenario, &plan);
        let [.., own, last] = &pictures[..] else { panic!("at least two") };
        assert!(!own.is_final && own.places.iter().all(|place| place.expected.is_none()));
        let (mut off, mut ends) = (Vec::new(), Vec::new());
        for at in (0..all.len()).step_by(all.len() / 12) {
            let place = &last.places[at];
            assert_eq!(place.tip_rms_mm, own.places[at].tip_rms_mm);
            let moved = moved(&scenario, &plan, &all[at]);
            let study = expected(&moved, &Mode::Motion, &CancelToken::default()).unwrap();
            let rms_mm = study.of(Metric::TIP_RMS).0;
            let interval_mm = study.continued[Metric::TIP_RMS.index()];
            let found = place.expected.unwrap();
            off.push((found.rms_mm / rms_mm - 1.0).abs());
            for (end, expected) in found.interval_mm.iter().zip(interval_mm) {
                ends.push((end / expected).ln().abs());
            }
            assert!(found.interval_mm[0] <= found.rms_mm && found.rms_mm <= found.interval_mm[1]);
        }
        off.sort_unstable_by(f64::total_cmp);
        assert!(off[off.len() / 2] < 0.12 && off[off.len() - 1] < 0.2, "{off:?}");
        // Nine of ten within a factor of 1.5, half of them within 1.25.
        ends.sort_unstable_by(f64::total_cmp);
        let [half, most] = [ends[ends.len() / 2], ends[ends.len() * 9 / 10]];
        assert!(half < 1.25_f64.ln() && most < 1.5_f64.ln(), "{ends:?}");
    }
}
