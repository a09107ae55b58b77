//! Metal in a design's room: solved, saved, recovered.

use super::*;
use crate::open_builtin_without_meshes;
use std::collections::BTreeMap;
use std::sync::Arc;
use trackwright_design::{Edit, MetalEdit};
use trackwright_field::OutsidePolicy;
use trackwright_field::generator::Generator;
use trackwright_field::inverse::{InverseState, undistort};
use trackwright_field::random_models::Seeded;
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, Environment};
use trackwright_formats::environment;
use trackwright_geometry::mesh_reference::{MeshReference, MeshUnit};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::volume::Volume;
use trackwright_metal::furnished::MetalEvaluation;
use trackwright_metal::new_object::NewShape;
use trackwright_metal::setup::{
    MaterialTolerance, MetalObject, ObjectMaterial, ObjectMesh, ObjectShape, RoomMetal,
};
use trackwright_simulation::{CancelToken, Mode, run};
use trackwright_task::Task;

fn ball(name: &str, y_mm: f64) -> MetalObject {
    MetalObject {
        name: name.to_owned(),
        shape: ObjectShape::Sphere { radius_mm: 60.0 },
        material: ObjectMaterial::Named("aluminium"),
        tracker_from_object: Pose::translation(0.0, y_mm, -300.0),
        most_triangles: 300,
        tolerance: MaterialTolerance::default(),
    }
}

fn metal(objects: Vec<MetalObject>) -> Arc<RoomMetal> {
    Arc::new(RoomMetal { objects, ..RoomMetal::empty(Generator::planar_nine()) })
}

fn apply(world: &mut World, edit: MetalEdit) {
    assert!(world.document.apply(Edit::Metal(edit)).unwrap());
}

/// The tip's error at the design's pose.
fn tip_mm(world: &World) -> f64 {
    let scenario = resolve(world.document.design(), &world.environment);
    let outcome = run(&scenario, &Mode::Single, &CancelToken::default(), None).unwrap();
    outcome.room_field.position_mm.rms()
}

/// `a.design.ron` in a room of nothing but metal, whose ball is a mesh in a file.
fn metal_world() -> (TempDir, World) {
    let (folder, _) = saved_world();
    let mesh = Arc::new(trackwright_metal::shapes::sphere(60.0, 2).unwrap());
    let part = &mesh.parts[0];
    let vertex = |p: &Point3<f64>| format!("v {} {} {}\n", p.x / 10.0, p.y / 10.0, p.z / 10.0);
    let face = |[a, b, c]: &[u32; 3]| format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    let vertices: String = part.positions_mm.iter().map(vertex).collect();
    let faces: String = part.triangles.iter().map(face).collect();
    fs::write(folder.path().join("ball.obj"), vertices + &faces).unwrap();
    let reference = MeshReference { file: "ball.obj".to_owned(), unit: Some(MeshUnit::Centimetre) };
    let object = MetalObject {
        shape: ObjectShape::Mesh(ObjectMesh { reference, surface: mesh }),
        ..ball("ball", -420.0)
    };
    let volume = Volume::AuroraCube;
    let model = DistortionModel::zero(volume.bounds(), MapKind::Distortion);
    let room = Environment { volume: Some(volume), ..Environment::of_model("ideal", model) };
    let text = environment::write(&room, Some(&metal(vec![object])));
    fs::write(folder.path().join("metal.env.ron"), text).unwrap();
    let file = folder.path().join("a.design.ron");
    let design = fs::read_to_string(&file).unwrap();
    fs::write(&file, design.replace("operating-table.env.ron", "metal.env.ron")).unwrap();
    let world = open_design(&file).unwrap();
    (folder, world)
}

#[test]
fn a_room_of_metal_disturbs_the_design() {
    let (_folder, mut world) = metal_world();
    let far_mm = tip_mm(&world);
    assert!(far_mm > 0.01, "{far_mm}");
    let report = world.metal_report().unwrap();
    assert!((200..=300).contains(&report.objects[0].triangles), "{:?}", report.objects);
    let nearer = Pose::translation(0.0, -330.0, -300.0);
    apply(&mut world, MetalEdit::SetPose { index: 0, tracker_from_object: nearer });
    assert!(refresh_metal(&mut world).unwrap() && !refresh_metal(&mut world).unwrap());
    assert!(tip_mm(&world) > 1.5 * far_mm, "{}", tip_mm(&world));
    world.document.undo();
    assert!(refresh_metal(&mut world).unwrap());
    assert_eq!(tip_mm(&world), far_mm);
    apply(&mut world, MetalEdit::Replace(None));
    assert!(refresh_metal(&mut world).unwrap());
    assert!(tip_mm(&world) < 1e-9);
    assert!(world.metal_report().is_none());
}

#[test]
fn metal_is_saved_into_its_own_room() {
    let (folder, mut world) = metal_world();
    let before = files(folder.path());
    apply(&mut world, MetalEdit::SetFrequency(4e3));
    assert_eq!(names(&save(&mut world).unwrap()), ["metal.env.ron"]);
    assert_eq!(files(folder.path()), before);
    let again = open_design(&folder.path().join("a.design.ron")).unwrap();
    assert_eq!(again.document.design(), world.document.design());
    assert_eq!(again.document.design().room_metal.as_ref().unwrap().frequency_hz, 4e3);
    assert_eq!(names(&save(&mut world).unwrap()), [""; 0]);
}

#[test]
fn a_measured_room_is_never_written_over() {
    let (folder, mut world) = saved_world();
    let measured = folder.path().join("operating-table.env.ron");
    let bytes = fs::read(&measured).unwrap();
    let without_mm = tip_mm(&world);
    apply(&mut world, MetalEdit::Replace(Some(metal(vec![ball("ball", -420.0)]))));
    refresh_metal(&mut world).unwrap();
    // The room is of the same coils, so that their signals are added.
    assert!(!world.metal_report().unwrap().is_added_to_errors);
    let with_mm = tip_mm(&world);
    assert_ne!(with_mm, without_mm);
    let written = names(&save(&mut world).unwrap());
    assert_eq!(written, ["operating-table-with-metal.env.ron", "a.design.ron"]);
    assert_eq!(fs::read(&measured).unwrap(), bytes);
    assert!(!refresh_environment(&mut world).unwrap() && !refresh_metal(&mut world).unwrap());
    let again = open_design(&folder.path().join("a.design.ron")).unwrap();
    assert_eq!(again.document.design(), world.document.design());
    assert_eq!(tip_mm(&again), with_mm);
    // Undo leads to the room that was measured.
    world.document.undo();
    assert_eq!(world.document.design().environment, "operating-table.env.ron");
    refresh_environment(&mut world).unwrap();
    refresh_metal(&mut world).unwrap();
    assert_eq!(tip_mm(&world), without_mm);
    // From there on metal is saved in a file of its own again, and the former one stays.
    apply(&mut world, MetalEdit::Replace(Some(metal(vec![ball("ball", 420.0)]))));
    let written = names(&save(&mut world).unwrap());
    assert_eq!(written, ["operating-table-with-metal-2.env.ron", "a.design.ron"]);
}

#[test]
fn a_room_of_two_designs_stays_that_of_the_other() {
    let (folder, mut world) = metal_world();
    let file = folder.path().join("a.design.ron");
    fs::copy(&file, folder.path().join("b.design.ron")).unwrap();
    let bytes = fs::read(folder.path().join("metal.env.ron")).unwrap();
    apply(&mut world, MetalEdit::SetFrequency(4e3));
    let written = names(&save(&mut world).unwrap());
    assert_eq!(written, ["metal-with-metal.env.ron", "a.design.ron"]);
    assert_eq!(fs::read(folder.path().join("metal.env.ron")).unwrap(), bytes);
}

#[test]
fn save_as_takes_changed_metal_along() {
    let (folder, mut world) = metal_world();
    let elsewhere = folder.path().join("elsewhere");
    fs::create_dir(&elsewhere).unwrap();
    apply(&mut world, MetalEdit::SetFrequency(4e3));
    let file = elsewhere.join("b.design.ron");
    assert_eq!(names(&save_as(&mut world, &file).unwrap()), ["metal.env.ron", "b.design.ron"]);
    let again = open_design(&file).unwrap();
    assert_eq!(again.document.design(), world.document.design());
    let metal = again.document.design().room_metal.as_ref().unwrap();
    assert_eq!(metal.mesh_files().collect::<Vec<_>>(), ["../ball.obj"]);
    // What was changed before is unchanged in the old place.
    let old = open_design(&folder.path().join("a.design.ron")).unwrap();
    assert_eq!(old.document.design().room_metal.as_ref().unwrap().frequency_hz, 10e3);
}

#[test]
fn metal_is_recovered() {
    let (_folder, mut world) = metal_world();
    let state = tempfile::tempdir().unwrap();
    apply(&mut world, MetalEdit::Add(Box::new(ball("other", 450.0))));
    refresh_metal(&mut world).unwrap();
    let found = crashed(state.path(), &world).open().unwrap();
    assert_eq!(found.document.design(), world.document.design());
    assert!(found.document.is_dirty());
    assert_eq!(tip_mm(&found), tip_mm(&world));
}

#[test]
fn impossible_metal_is_a_problem_and_no_figure() {
    let (folder, mut world) = metal_world();
    let before = Arc::clone(&world.environment);
    apply(&mut world, MetalEdit::Add(Box::new(ball("other", -430.0))));
    let error = refresh_metal(&mut world).unwrap_err().to_string();
    assert!(error.ends_with("ball and other touch or cut each other"), "{error}");
    assert!(world.metal_problem().is_some() && Arc::ptr_eq(&world.environment, &before));
    // It is not tried again and again, and it can be saved and recovered.
    assert!(!refresh_metal(&mut world).unwrap());
    let state = tempfile::tempdir().unwrap();
    let recovered = crashed(state.path(), &world).open().unwrap();
    assert!(recovered.metal_problem().is_some());
    save(&mut world).unwrap();
    let error = open_design(&folder.path().join("a.design.ron")).unwrap_err().to_string();
    assert!(error.contains("metal.env.ron: ball and other touch"), "{error}");
    world.document.undo();
    assert!(refresh_metal(&mut world).unwrap());
    assert!(world.metal_problem().is_none());
}

#[test]
fn metal_of_a_missing_mesh_is_an_error() {
    let (folder, _world) = metal_world();
    fs::remove_file(folder.path().join("ball.obj")).unwrap();
    let error = open_design(&folder.path().join("a.design.ron")).unwrap_err().to_string();
    assert!(error.contains("ball.obj"), "{error}");
}

#[test]
fn a_whole_room_far_from_metal_is_harmonic() {
    let (_folder, mut world) = metal_world();
    let far = Pose::translation(0.0, -1000.0, -300.0);
    apply(&mut world, MetalEdit::SetPose { index: 0, tracker_from_object: far });
    refresh_metal(&mut world).unwrap();
    let evaluation = &world.metal_report().unwrap().evaluation;
    assert!(matches!(evaluation, MetalEvaluation::Harmonic { .. }), "{evaluation:?}");
}

#[test]
fn added_metal_is_beside_the_volume() {
    let (_folder, mut world) = saved_world();
    assert_eq!(world.generator(), Some(&Generator::planar_nine()));
    let edit = world.added_metal(NewShape::Sphere.shape(), "sphere");
    assert!(world.document.apply(edit).unwrap());
    // The next one is beside the first, of the same coils.
    let edit = world.added_metal(NewShape::Sphere.shape(), "sphere");
    assert!(matches!(&edit, Edit::Metal(MetalEdit::Add(object)) if object.name == "sphere 2"));
    world.document.apply(edit).unwrap();
    assert!(refresh_metal(&mut world).unwrap());
    assert!(world.metal_problem().is_none());
}

#[test]
fn a_mesh_of_metal_is_referred_to_from_its_room() {
    let (folder, world) = metal_world();
    let mesh = folder.path().join("ball.obj");
    let import = MeshImport::of_file(&world, MeshOwner::NewMetal, &mesh, None).unwrap().unwrap();
    assert_eq!(import.reference, MeshReference::new("ball.obj"));
    assert_eq!(import.file(), mesh);
    let read = import.read().unwrap();
    let triangles = |mesh: &trackwright_geometry::mesh::SurfaceMesh| mesh.parts[0].triangles.len();
    assert_eq!(triangles(&read.surface), 320);
}

/// 5,000 poses of the built-in theatre, distorted and put back.
#[test]
#[ignore = "minutes: the theatre is solved for"]
fn long_round_trips_in_the_theatre_come_back() {
    let world = open_builtin_without_meshes("operating-theatre").unwrap();
    let model = &world.environment.model;
    let mut seeded = Seeded::new(5);
    let read = std::iter::repeat_with(|| seeded.pose(model.bounds(), 0.0)).filter_map(|pose| {
        let (reading, is_inside) = model.distort(&pose, OutsidePolicy::Clamp);
        is_inside.then_some((pose, reading))
    });
    let (poses, readings): (Vec<_>, Vec<_>) = read.take(5000).unzip();
    let found = undistort(model, &readings, OutsidePolicy::Clamp, &Task::default()).unwrap();
    // Right ones by state, and wrong ones.
    let mut tally: BTreeMap<(bool, &str), usize> = BTreeMap::new();
    for (pose, found) in poses.iter().zip(&found) {
        let off_mm = |p: Pose| (p.translation.vector - pose.translation.vector).norm();
        let is_right = found.pose.is_some_and(|found| off_mm(found) < 1e-3);
        let state = match found.state {
            InverseState::Converged if found.is_inside => "sure",
            InverseState::Converged => "outside",
            InverseState::Ambiguous(_) => "ambiguous",
            InverseState::NoReading => "in metal",
            _ => "no answer",
        };
        *tally.entry((is_right, state)).or_default() += 1;
    }
    let count = |key: (bool, &'static str)| tally.get(&key).copied().unwrap_or(0);
    // A sensor may be drawn within a tenth of a millimetre of metal.
    assert!(count((false, "sure")) == 0 && count((false, "in metal")) <= 2, "{tally:?}");
    assert!(count((true, "sure")) > 4950 && count((true, "in metal")) == 0, "{tally:?}");
}
