//! The CRF on a patch of the patient: it follows the surface, and the best spot is found.

use super::cases::{crf_problem, room};
use crate::footing::{FootPose, Footing};
use crate::{CrfPatch, Moves, OptimizeError, PoseBounds, Problem, Settings, optimize};
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};
use trackwright_field::random_models::Seeded;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::solid::Solid;
use trackwright_geometry::surface::Surface;
use trackwright_simulation::{CancelToken, Metric, run};
use trackwright_task::Task;

const RADIUS_MM: f64 = 80.0;

/// Below the CRF's plate, the lower side of which touches it.
const CENTER_MM: [f64; 3] = [0.0, 0.0, -6.0 - RADIUS_MM];

fn head() -> SurfaceMesh {
    let Solid { positions_mm, normals, triangles } = Solid::sphere(RADIUS_MM);
    let name = "anatomy skin".to_owned();
    let part = MeshPart { name, positions_mm, normals, triangles, ..MeshPart::default() };
    SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
}

/// The head's frame is turned against the CRF's.
fn crf_from_head() -> Pose {
    let turn = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.9);
    Pose::from_parts(Translation3::from(Vector3::from(CENTER_MM)), turn)
}

/// The side of the head that the plate is on, 10 mm below the plate and above.
fn upper(crf_from_head: &Pose, reach_mm: f64) -> Bounds {
    let top = crf_from_head.inverse() * Point3::new(0.0, 0.0, -6.0);
    let reach = Vector3::repeat(reach_mm);
    Bounds { min_mm: top - reach, max_mm: top + reach }
}

fn bounds(shift_mm: f64, turn_deg: f64) -> PoseBounds {
    PoseBounds { shift_mm: Vector3::repeat(shift_mm), turn_deg }
}

fn patch(reach_mm: f64) -> CrfPatch {
    let pose = crf_from_head();
    CrfPatch::of_mesh("head", Some(&head()), &[upper(&pose, reach_mm)], pose)
}

/// A plate on a head that it may be moved over.
fn problem(seed: u64, patch: CrfPatch, bounds: PoseBounds) -> Problem {
    let mut problem = crf_problem(vec![room(seed)], seed);
    problem.moves = Moves { crf_pose: Some(bounds), ..Moves::default() };
    problem.crf_patches = vec![patch];
    problem
}

#[test]
fn the_crf_follows_the_surface() {
    let (patch, middle) = (patch(60.0), Point3::new(1.0, 2.0, -3.0));
    let footing = Footing::new(&patch, &middle, bounds(70.0, 15.0)).unwrap();
    let surface = Surface::new(&{
        let mut mesh = head();
        mesh.parts[0].name.clear();
        mesh
    })
    .unwrap();
    let pose = crf_from_head();
    let start = footing.start;
    let still = footing.crf_moved(&start);
    assert!(still.translation.vector.norm() < 1e-12 && still.rotation.angle() < 1e-12);
    let mut seeded = Seeded::new(31);
    let mut foot_pose = start;
    let mut allowed = 0;
    for _ in 0..300 {
        let way_mm = Vector3::from_fn(|_, _| 20.0 * seeded.normal());
        let next = footing.moved(&foot_pose, &way_mm, 5.0 * seeded.normal());
        assert!(next.turn_deg.abs() <= 15.0);
        if !footing.is_allowed(&next) {
            continue;
        }
        allowed += 1;
        foot_pose = next;
        let FootPose { foot, turn_deg } = next;
        let off_mm = (surface.closest(&foot.position_mm).position_mm - foot.position_mm).norm();
        assert!(off_mm < 1e-6, "{off_mm} mm off the surface");
        assert!(upper(&pose, 60.0).contains(&foot.position_mm), "{foot:?}");
        let moved = footing.crf_moved(&next);
        let [from, to] = [&start.foot, &foot].map(|own| pose * own.position_mm);
        let [normal, normal_now] = [&start.foot, &foot].map(|own| pose.rotation * own.normal);
        // The foot goes to the foot, the normal to the normal; all else keeps its distance.
        assert!((moved * from - to).norm() < 1e-9);
        assert!((moved.rotation * normal.into_inner() - *normal_now).norm() < 1e-12);
        let height =
            |at: &Point3<f64>, foot: &Point3<f64>, normal: &Vector3<f64>| (at - foot).dot(normal);
        let before_mm = height(&middle, &from, &normal);
        assert!((height(&(moved * middle), &to, &normal_now) - before_mm).abs() < 1e-9);
        // The smallest tilt, then the turn: together cos(θ/2) = cos(tilt/2) cos(turn/2).
        let tilt = normal.angle(&normal_now);
        let half = (tilt / 2.0).cos() * (turn_deg.to_radians() / 2.0).cos();
        assert!((moved.rotation.angle() - 2.0 * half.acos()).abs() < 1e-7);
    }
    assert!(allowed > 50, "{allowed}");
}

#[test]
fn a_crf_at_the_edge_of_the_patch_stands_on_it() {
    let middle = Point3::new(1.0, 2.0, -3.0);
    let of_start = patch(40.0);
    let footing = Footing::new(&of_start, &middle, bounds(1e6, 15.0)).unwrap();
    let mut seeded = Seeded::new(32);
    for _ in 0..100 {
        let direction = Vector3::from_fn(|_, _| seeded.normal()).normalize();
        let turn_deg = 10.0 * seeded.normal();
        // As far as the patch goes.
        let (mut within_mm, mut beyond_mm) = (0.0, 80.0);
        for _ in 0..40 {
            let way_mm = 0.5 * (within_mm + beyond_mm);
            let there = footing.moved(&footing.start, &(direction * way_mm), turn_deg);
            match footing.is_allowed(&there) {
                true => within_mm = way_mm,
                false => beyond_mm = way_mm,
            }
        }
        let edge = footing.moved(&footing.start, &(direction * within_mm), turn_deg);
        let crf_from_head = footing.crf_moved(&edge).inverse() * crf_from_head();
        let mut moved = of_start.clone();
        moved.crf_from_mesh = crf_from_head;
        let again = Footing::new(&moved, &middle, bounds(1e6, 15.0)).unwrap();
        let off_mm = (again.start.foot.position_mm - edge.foot.position_mm).norm();
        // It may be 2 mm beside the point below the CRF, which the facets put 1 mm beside the edge.
        assert!(off_mm < 3.0, "{off_mm}");
    }
}

#[test]
fn the_shift_bounds_how_far_the_foot_goes() {
    let patch = patch(60.0);
    let footing = Footing::new(&patch, &Point3::new(0.0, 0.0, -3.0), bounds(12.0, 0.0)).unwrap();
    let foot_poses = footing.spread_out();
    assert!(foot_poses.len() > 30, "{}", foot_poses.len());
    let turn = crf_from_head().rotation;
    for own in &foot_poses {
        let way_mm = turn * (own.foot.position_mm - footing.start.foot.position_mm);
        assert!(way_mm.amax() <= 12.0 && own.turn_deg == 0.0, "{way_mm}");
    }
    // They reach as far.
    let far_mm =
        foot_poses.iter().map(|own| (own.foot.position_mm - footing.start.foot.position_mm).norm());
    assert!(far_mm.fold(0.0, f64::max) > 10.0);
}

#[test]
fn the_best_spot_of_the_patch_is_found() {
    for seed in [41, 42, 43] {
        let problem = problem(seed, patch(60.0), bounds(1e6, 20.0));
        let settings = Settings { most_fits: 2_000_000, ..Settings::default() };
        let (enough, task) = (CancelToken::default(), Task::default());
        let found = optimize(&problem, &settings, &enough, &task, &mut |_| ()).unwrap();
        // Every foot_pose of a grid that is finer than that of the search, through a study of its own.
        let middle = Point3::new(0.0, 0.0, -3.0);
        let footing = Footing::new(&problem.crf_patches[0], &middle, bounds(1e6, 20.0)).unwrap();
        let mut foot_poses = footing.spread_out();
        let mut seeded = Seeded::new(seed);
        for k in 0..400 {
            let way_mm = Vector3::from_fn(|_, _| 15.0 * seeded.normal());
            let near = footing.moved(&foot_poses[k % 192], &way_mm, 10.0 * seeded.normal());
            foot_poses.push(near);
        }
        let figure = |own: &FootPose| {
            let mut scenario = problem.scenarios[0].clone();
            let moved = footing.crf_moved(own);
            let crf = scenario.crf.as_mut().unwrap();
            crf.tracker_from_crf *= moved;
            scenario.crf_from_tool = moved.inverse() * scenario.crf_from_tool;
            let outcome = run(&scenario, &problem.mode, &CancelToken::default(), None).unwrap();
            (outcome.room_field.outside == 0).then(|| outcome.room_field.value(Metric::TIP_RMS))
        };
        let allowed = foot_poses.iter().filter(|own| footing.is_allowed(own));
        let least = allowed.filter_map(figure).fold(f64::INFINITY, f64::min);
        let best = found.best.objective;
        assert!(best <= 1.01 * least, "{seed}: {best} mm, least {least} mm");
        assert!(best < 0.9 * found.start.objective, "{seed}: {best} of {}", found.start.objective);
        assert_eq!(found.certain_to_mm, None);
        // The tool stays where it is in the room.
        let in_room =
            |layout: &crate::Layout| layout.tracker_from_crf.unwrap() * layout.crf_from_tool;
        let apart = in_room(&found.start).inverse() * in_room(&found.best);
        assert!(apart.translation.vector.norm() < 1e-9 && apart.rotation.angle() < 1e-9);
    }
}

#[test]
fn what_is_no_patch_for_the_crf_is_one_error() {
    let pose = crf_from_head();
    let error = |patches: Vec<CrfPatch>| {
        let mut problem = problem(44, patch(60.0), bounds(20.0, 10.0));
        problem.crf_patches = patches;
        let (enough, task) = (CancelToken::default(), Task::default());
        optimize(&problem, &Settings::default(), &enough, &task, &mut |_| ()).unwrap_err()
    };
    let none = CrfPatch::of_mesh("head", None, &[upper(&pose, 9.0)], pose);
    let no_surface = OptimizeError::NoPatchSurface { anatomy: "head".to_owned() };
    assert_eq!(error(vec![none]), no_surface);
    let empty =
        CrfPatch::of_mesh("head", Some(&SurfaceMesh::default()), &[upper(&pose, 9.0)], pose);
    assert_eq!(error(vec![empty]), no_surface);
    // The box is 20 mm beside the head.
    let beside = Bounds::from(([RADIUS_MM + 20.0, -5.0, -5.0], [RADIUS_MM + 40.0, 5.0, 5.0]));
    let found = error(vec![CrfPatch::of_mesh("head", Some(&head()), &[beside], pose)]);
    let OptimizeError::EmptyPatch { off_mm, .. } = found else { panic!("{found}") };
    assert!((off_mm - 20.0).abs() < 1e-9, "{off_mm}");
    // The CRF is on the other side of the head.
    let other = Bounds { min_mm: upper(&pose, 9.0).min_mm * -1.0, max_mm: Point3::origin() };
    let other = Bounds {
        min_mm: other.min_mm - Vector3::repeat(20.0),
        max_mm: other.min_mm + Vector3::repeat(2.0),
    };
    let found = error(vec![CrfPatch::of_mesh("head", Some(&head()), &[other], pose)]);
    let OptimizeError::BesidePatch { off_mm, foot_mm, .. } = &found else { panic!("{found}") };
    let top = pose.inverse() * Point3::new(0.0, 0.0, -6.0);
    assert!((Point3::from(*foot_mm) - top).norm() < 1.0, "{foot_mm:?} {top}");
    assert!(*off_mm > 1.5 * RADIUS_MM, "{off_mm}");
    let several = OptimizeError::SeveralPatches { anatomy: vec!["head".to_owned(); 2] };
    assert_eq!(error(vec![patch(60.0), patch(50.0)]), several);
    // Where its pose stays nothing is stated about it.
    let mut still = problem(44, patch(60.0), bounds(20.0, 10.0));
    still.crf_patches = vec![patch(60.0), patch(50.0)];
    still.moves = Moves { crf: vec![0], ..Moves::default() };
    let settings = Settings { most_fits: 20_000, ..Settings::default() };
    let (enough, task) = (CancelToken::default(), Task::default());
    assert!(optimize(&still, &settings, &enough, &task, &mut |_| ()).is_ok());
}

#[test]
fn sensors_and_the_crf_move_together() {
    let mut problem = problem(45, patch(60.0), bounds(1e6, 20.0));
    let search = |problem: &Problem| {
        let settings = Settings { most_fits: 2_000_000, ..Settings::default() };
        let (enough, task) = (CancelToken::default(), Task::default());
        optimize(problem, &settings, &enough, &task, &mut |_| ()).unwrap()
    };
    let pose = search(&problem);
    problem.moves = Moves { crf: vec![0, 1, 2], ..problem.moves };
    let both = search(&problem);
    assert!(both.best.objective < pose.best.objective);
    assert!(both.best.crf_change(&both.start).is_some());
    assert!(both.best.crf != both.start.crf);
}
