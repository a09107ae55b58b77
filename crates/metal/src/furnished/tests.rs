use super::*;
use crate::setup::{DEFAULT_TRIANGLES, ObjectMaterial};
use trackwright_field::FieldPoint;
use trackwright_field::generator::Generator;
use trackwright_field::inverse::{InverseState, undistort};
use trackwright_field::random_models::{Seeded, random_model, room};
use trackwright_field::samples::PoseError;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_geometry::pose::Pose;

fn plate(name: &str, at: Pose) -> MetalObject {
    MetalObject {
        name: name.to_owned(),
        shape: ObjectShape::Cuboid { size_mm: Vector3::new(150.0, 150.0, 15.0) },
        material: ObjectMaterial::Named("aluminium"),
        tracker_from_object: at,
        most_triangles: 300,
        tolerance: MaterialTolerance::default(),
    }
}

fn sphere(name: &str, radius_mm: f64, at: Pose) -> MetalObject {
    let shape = ObjectShape::Sphere { radius_mm };
    MetalObject { shape, most_triangles: DEFAULT_TRIANGLES, ..plate(name, at) }
}

fn metal(objects: Vec<MetalObject>) -> RoomMetal {
    RoomMetal { objects, ..RoomMetal::empty(Generator::planar_nine()) }
}

fn ideal() -> Arc<Environment> {
    let volume = Volume::AuroraCube;
    let model = DistortionModel::zero(volume.bounds(), MapKind::Distortion);
    Arc::new(Environment { volume: Some(volume), ..Environment::of_model("ideal", model) })
}

fn furnish(bare: &Arc<Environment>, metal: &RoomMetal) -> Furnished {
    Furnisher::default().furnish(bare, metal, &Task::default()).unwrap()
}

fn poses(bounds: &Bounds, count: usize) -> Vec<(Point3<f64>, Unit<Vector3<f64>>)> {
    let mut seeded = Seeded::new(11);
    let one = |_| (seeded.position(bounds, 0.0), Unit::new_normalize(seeded.normal_vector()));
    (0..count).map(one).collect()
}

fn error_mm(
    environment: &Environment,
    (p, axis): &(Point3<f64>, Unit<Vector3<f64>>),
) -> Vector3<f64> {
    let read = environment.model.evaluate(p, axis, OutsidePolicy::Clamp);
    assert!(read.is_inside);
    read.error.position_mm
}

#[test]
fn harmonics_stand_for_metal_outside_the_box() {
    let bare = ideal();
    let room = metal(vec![plate("plate", Pose::translation(0.0, -900.0, -300.0))]);
    let furnished = furnish(&bare, &room);
    let evaluation = &furnished.report.evaluation;
    assert!(matches!(evaluation, MetalEvaluation::Harmonic { .. }), "{evaluation:?}");
    let [largest_mm, error_mm] = differences_mm(&furnished, 500);
    assert!(largest_mm < TOLERANCE_MM && error_mm > 5.0 * TOLERANCE_MM, "{largest_mm} {error_mm}");
}

#[test]
fn cells_are_harmonic_where_metal_is_far() {
    let room = metal(vec![plate("plate", Pose::translation(0.0, -400.0, -300.0))]);
    let furnished = furnish(&ideal(), &room);
    let MetalEvaluation::Cells(cells) = &furnished.report.evaluation else {
        panic!("{:?}", furnished.report.evaluation)
    };
    let [largest_mm, error_mm] = differences_mm(&furnished, 600);
    let counts = cells.counts();
    assert!(
        largest_mm < TOLERANCE_MM && error_mm > 300.0 * TOLERANCE_MM,
        "{largest_mm} {error_mm}"
    );
    assert_eq!(counts.harmonic_poses + counts.direct_poses, 600);
    assert!(counts.harmonic_poses > 5 * counts.direct_poses, "{counts:?}");
}

/// The largest difference from the metal itself, and the largest error.
fn differences_mm(furnished: &Furnished, count: usize) -> [f64; 2] {
    let solved = furnished.room.as_ref().unwrap();
    let mut largest = [0.0_f64; 2];
    for pose in poses(furnished.environment.model.bounds(), count) {
        let exact_mm = solved.read_axis(&pose.0, &pose.1).unwrap().position_mm - pose.0;
        let difference_mm = (error_mm(&furnished.environment, &pose) - exact_mm).norm();
        largest = [largest[0].max(difference_mm), largest[1].max(exact_mm.norm())];
    }
    largest
}

#[test]
fn metal_in_the_box_is_evaluated_itself() {
    let bare = ideal();
    let room = metal(vec![sphere("ball", 30.0, Pose::translation(150.0, 0.0, -300.0))]);
    let furnished = furnish(&bare, &room);
    let (solved, z) = (furnished.room.clone().unwrap(), Vector3::z_axis());
    let beside = Point3::new(95.0, 0.0, -300.0);
    let exact_mm = solved.read_axis(&beside, &z).unwrap().position_mm - beside;
    assert_eq!(error_mm(&furnished.environment, &(beside, z)), exact_mm);
    // A sensor in the metal reads nothing: no number, and outside.
    let within = Point3::new(150.0, 10.0, -300.0);
    let read = furnished.environment.model.evaluate(&within, &z, OutsidePolicy::Clamp);
    assert!(!read.is_inside);
}

#[test]
fn metal_adds_to_the_errors_of_a_measured_room() {
    let measured = random_model(3, DirectionSet::Six, Weighting::Area, [2.0, 0.01], 3);
    let bare = Arc::new(Environment::of_model("measured", measured));
    let objects = vec![sphere("ball", 60.0, Pose::translation(0.0, -420.0, -300.0))];
    let both = furnish(&bare, &metal(objects.clone()));
    assert!(both.report.is_added_to_errors);
    let zero = DistortionModel::zero(room(), MapKind::Distortion);
    let alone = furnish(&Arc::new(Environment::of_model("ideal", zero)), &metal(objects));
    for pose in poses(&room(), 50) {
        let sum = error_mm(&bare, &pose) + error_mm(&alone.environment, &pose);
        assert!((error_mm(&both.environment, &pose) - sum).norm() < 1e-12);
    }
}

#[test]
fn a_harmonic_room_is_disturbed_together_with_metal() {
    // A room that is itself a sphere, as harmonics; the other sphere is far enough for no exchange.
    let near = sphere("near", 80.0, Pose::translation(0.0, -900.0, -300.0));
    let far = sphere("far", 60.0, Pose::translation(0.0, 480.0, -300.0));
    let one = furnish(&ideal(), &metal(vec![near.clone()]));
    let two = furnish(&one.environment, &metal(vec![far.clone()]));
    assert!(!two.report.is_added_to_errors);
    let both = furnish(&ideal(), &metal(vec![near, far]));
    for pose in poses(ideal().model.bounds(), 50) {
        let apart = error_mm(&two.environment, &pose) - error_mm(&both.environment, &pose);
        assert!(apart.norm() < 3.0 * TOLERANCE_MM, "{apart}");
    }
}

#[test]
fn what_was_moved_is_as_if_solved_anew() {
    let bare = ideal();
    let mut furnisher = Furnisher::default();
    let at = |x: f64| {
        let moved = plate("a", Pose::translation(x, -480.0, -300.0));
        metal(vec![moved, plate("b", Pose::translation(0.0, 500.0, -300.0))])
    };
    furnisher.furnish(&bare, &at(0.0), &Task::default()).unwrap();
    // With two meshes each.
    assert_eq!((furnisher.shapes.len(), furnisher.bodies.len()), (2, 2));
    let moved = furnisher.furnish(&bare, &at(100.0), &Task::default()).unwrap();
    let anew = furnish(&bare, &at(100.0));
    for pose in poses(bare.model.bounds(), 50) {
        assert_eq!(error_mm(&moved.environment, &pose), error_mm(&anew.environment, &pose));
    }
}

#[test]
fn problems_name_the_objects() {
    let bare = ideal();
    let error = |objects| {
        let made = Furnisher::default().furnish(&bare, &metal(objects), &Task::default());
        made.unwrap_err().to_string()
    };
    let at = |x: f64, z: f64| Pose::translation(x, 0.0, z);
    assert_eq!(
        error(vec![plate("plate", at(0.0, -300.0))]),
        "plate is in the middle of the measurement volume"
    );
    assert_eq!(error(vec![plate("plate", at(-120.0, 0.0))]), "plate cuts coil 2 of the generator");
    let pair = [("a", 500.0), ("b", 560.0)].map(|(name, x)| sphere(name, 50.0, at(x, -300.0)));
    assert_eq!(error(pair.to_vec()), "a and b touch or cut each other");
}

#[test]
fn no_metal_leaves_the_room_as_it_is() {
    let bare = ideal();
    let furnished = furnish(&bare, &metal(Vec::new()));
    assert!(Arc::ptr_eq(&furnished.environment, &bare));
    assert!(matches!(furnished.report.evaluation, MetalEvaluation::None));
}

#[test]
fn cancelled_work_is_no_room() {
    let task = Task::default();
    task.cancel.cancel();
    let room = metal(vec![sphere("ball", 60.0, Pose::translation(0.0, -420.0, -300.0))]);
    let made = Furnisher::default().furnish(&ideal(), &room, &task);
    assert!(matches!(made, Err(FurnishError::Cancelled(_))));
}

#[test]
fn the_stated_error_is_that_of_the_triangles() {
    let of = |triangles: usize| {
        let object = plate("plate", Pose::translation(0.0, -380.0, -300.0));
        furnish(&ideal(), &metal(vec![MetalObject { most_triangles: triangles, ..object }]))
    };
    let places: Vec<Point3<f64>> =
        poses(ideal().model.bounds(), 60).into_iter().map(|(p, _)| p).collect();
    let fields = |furnished: &Furnished| furnished.room.as_ref().unwrap().disturbances(&places);
    let at: Vec<FieldPoint> =
        places.iter().map(|p| FieldPoint::of_pose(&Pose::translation(p.x, p.y, p.z))).collect();
    let errors = |furnished: &Furnished| -> Vec<PoseError> {
        let model = &furnished.environment.model;
        at.iter()
            .map(|at| model.evaluate(&at.position_mm, &at.axis, OutsidePolicy::Clamp).error)
            .collect()
    };
    let finest = of(1200);
    let (fine, fine_errors) = (fields(&finest), errors(&finest));
    for triangles in [48, 100, 200] {
        let found = of(triangles);
        let (mut wrong, mut whole) = (0.0, 0.0);
        for (own, fine) in fields(&found).into_iter().zip(&fine) {
            for (own, fine) in own.unwrap().iter().zip(fine.as_ref().unwrap()) {
                wrong += (own - fine).norm_squared();
                whole += fine.norm_squared();
            }
        }
        let (stated, error) = (found.report.solution_error, f64::sqrt(wrong / whole));
        assert!((0.5..4.0).contains(&(stated / error)), "{triangles}: {stated} {error}");
        // The same of what a tracker reads.
        let own = errors(&found);
        let metal = found.environment.metal.as_ref().unwrap();
        let sum =
            |errors: &[PoseError]| errors.iter().map(|e| e.position_mm.norm_squared()).sum::<f64>();
        let off: f64 = own
            .iter()
            .zip(&fine_errors)
            .map(|(a, b)| (a.position_mm - b.position_mm).norm_squared())
            .sum();
        let ratio = (sum(&metal.solution_errors(&own, &at)) / off).sqrt();
        assert!((0.5..4.0).contains(&ratio), "{triangles}: {ratio}");
    }
}

/// Poses over the box, and as many within 40 mm of a place.
fn poses_near(bounds: &Bounds, near_mm: &Point3<f64>, count: usize) -> Vec<Pose> {
    let around = Vector3::repeat(40.0);
    let near = Bounds { min_mm: near_mm - around, max_mm: near_mm + around };
    let mut seeded = Seeded::new(5);
    let all = (0..count).map(|k| seeded.pose(if k % 2 == 0 { bounds } else { &near }, 0.0));
    all.collect()
}

#[test]
fn no_pose_near_metal_is_answered_wrongly() {
    let place = Point3::new(90.0, 40.0, -260.0);
    let pose = Pose::translation(place.x, place.y, place.z);
    let rod = ObjectShape::Cylinder { radius_mm: 6.0, length_mm: 120.0 };
    let rod = MetalObject { shape: rod, most_triangles: 150, ..plate("rod", pose) };
    let added = random_model(2, DirectionSet::Fourteen, Weighting::Gnomonic, [1.0, 0.005], 3);
    let measured = Environment {
        volume: Some(Volume::AuroraCube),
        ..Environment::of_model("measured", added)
    };
    for bare in [ideal(), Arc::new(measured)] {
        let furnished = furnish(&bare, &metal(vec![rod.clone()]));
        let model = &furnished.environment.model;
        let all = poses_near(model.bounds(), &place, 400);
        let read = |pose: Pose| {
            let (reading, is_inside) = model.distort(&pose, OutsidePolicy::Clamp);
            is_inside.then_some((pose, reading))
        };
        let (poses, readings): (Vec<_>, Vec<_>) = all.into_iter().filter_map(read).unzip();
        let found = undistort(model, &readings, OutsidePolicy::Clamp, &Task::default()).unwrap();
        let mut converged = 0;
        for (pose, found) in poses.iter().zip(&found) {
            assert!(found.state != InverseState::NoReading, "{pose} is not in metal");
            if found.state == InverseState::Converged && found.is_inside {
                converged += 1;
                let off_mm =
                    (found.pose.unwrap().translation.vector - pose.translation.vector).norm();
                assert!(off_mm < 1e-3, "{off_mm} mm off at {pose}");
            }
        }
        assert!(converged >= poses.len() * 9 / 10, "{converged} of {}", poses.len());
    }
}

#[test]
fn a_reading_in_metal_is_named() {
    let shape = ObjectShape::Cuboid { size_mm: Vector3::new(120.0, 120.0, 120.0) };
    let block = MetalObject { shape, ..plate("block", Pose::translation(150.0, 0.0, -300.0)) };
    let model = furnish(&ideal(), &metal(vec![block])).environment.model.clone();
    let readings =
        [[150.0, 0.0, -300.0], [153.3, 7.1, -305.7]].map(|[x, y, z]| Pose::translation(x, y, z));
    let found = undistort(&model, &readings, OutsidePolicy::Clamp, &Task::default()).unwrap();
    for found in found {
        assert_eq!((found.state, found.pose), (InverseState::NoReading, None));
    }
}
