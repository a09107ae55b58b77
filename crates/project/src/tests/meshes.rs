//! Meshes of bodies and of the anatomy: read, missed, cached, and found again.

use super::*;
use std::sync::Arc;
use trackwright_design::{Anatomy, AnatomyEdit, AnatomyFrame, ProcedureEdit};
use trackwright_geometry::mesh_reference::{MeshReference, MeshUnit};
use trackwright_geometry::pose::Pose;

#[test]
fn a_design_opens_without_an_unusable_mesh() {
    let (folder, _) = saved_world();
    let design = folder.path().join("a.design.ron");
    let file = folder.path().join("pointer.glb");
    let before = fs::read(&file).unwrap();
    for (content, part, z_mm) in [
        (None, "File not found, expected a mesh", 80.0),
        (Some(&b"glTF"[..]), "found no glTF", 81.0),
        (Some(b""), "found no glTF", 82.0),
    ] {
        match content {
            Some(content) => fs::write(&file, content).unwrap(),
            None => fs::remove_file(&file).unwrap(),
        }
        let mut world = open_design(&design).unwrap();
        assert!(world.mesh(BodyRole::Tool).is_none() && world.mesh(BodyRole::Crf).is_some());
        let [problem] = &world.mesh_problems()[..] else { panic!("{:?}", world.mesh_problems()) };
        assert_eq!(problem.whose, BodyRole::Tool.into());
        assert_eq!(problem.reference.file, "pointer.glb");
        let message = problem.to_string();
        let start = format!("the tool's mesh is missing: {}: ", file.display());
        assert!(message.starts_with(&start), "{message}");
        assert!(message.contains(part), "{message}");
        assert_eq!(message.matches("expected").count(), 1, "{message}");
        // What was missed is still referred to, from elsewhere too.
        move_sensor(&mut world, BodyRole::Tool, z_mm);
        assert_eq!(names(&save(&mut world).unwrap()), ["pointer.body.ron"]);
        assert_eq!(mesh_file(&world), Some("pointer.glb"));
        move_sensor(&mut world, BodyRole::Tool, 90.0);
        fs::create_dir_all(folder.path().join("down")).unwrap();
        save_as(&mut world, &folder.path().join("down/copy.design.ron")).unwrap();
        assert_eq!(mesh_file(&world), Some("../pointer.glb"));
        assert!(!refresh_meshes(&mut world).unwrap());
        assert_eq!(world.mesh_problems().len(), 1);
        fs::write(&file, &before).unwrap();
        assert!(reload_meshes(&mut world).unwrap());
        assert!(world.mesh(BodyRole::Tool).is_some() && world.mesh_problems().is_empty());
        assert!(!reload_meshes(&mut world).unwrap());
    }
}

/// Sets the tool's mesh and reads it; whether another one is shown then.
fn set_mesh(world: &mut World, mesh: Option<MeshReference>) -> bool {
    let body = BodyRole::Tool;
    world.document.apply(Edit::SetMesh { body, mesh }).unwrap();
    refresh_meshes(world).unwrap()
}

fn length_mm(world: &World) -> Option<f64> {
    let bounds = world.mesh(BodyRole::Tool)?.body_bounds()?;
    Some(bounds.size_mm().amax())
}

const HOOK: &str = "v 0 0 0\nv 0 0 7\nv 1 0 0\nf 1 2 3\n";

#[test]
fn another_mesh_is_read_and_undone() {
    let (folder, mut world) = saved_world();
    let before = length_mm(&world);
    assert!(!refresh_meshes(&mut world).unwrap());
    fs::create_dir_all(folder.path().join("cad")).unwrap();
    let file = folder.path().join("cad/hook.obj");
    fs::write(&file, HOOK).unwrap();
    let hook = MeshReference::new(mesh_reference_to(&world, BodyRole::Tool, &file).unwrap());
    assert_eq!(hook.file, "cad/hook.obj");
    assert!(set_mesh(&mut world, Some(hook.clone())));
    assert_eq!(length_mm(&world), Some(7.0));
    let in_inches = MeshReference { unit: Some(MeshUnit::Inch), ..hook.clone() };
    assert!(set_mesh(&mut world, Some(in_inches)));
    assert_eq!(length_mm(&world), Some(7.0 * 25.4));
    assert_eq!(names(&save(&mut world).unwrap()), ["pointer.body.ron"]);
    let text = fs::read_to_string(folder.path().join("pointer.body.ron")).unwrap();
    assert!(text.contains("    mesh: \"cad/hook.obj\",\n    mesh_unit: Inch,\n"), "{text}");
    let again = open_design(&folder.path().join("a.design.ron")).unwrap();
    assert_eq!(again.document.design(), world.document.design());
    assert_eq!(length_mm(&again), length_mm(&world));
    assert!(set_mesh(&mut world, None));
    assert_eq!(length_mm(&world), None);
    assert!(world.mesh_problems().is_empty());
    for expected in [Some(7.0 * 25.4), Some(7.0), before] {
        assert_eq!(world.document.undo().as_deref(), Some("Change tool's mesh"));
        assert!(refresh_meshes(&mut world).unwrap());
        assert_eq!(length_mm(&world), expected);
    }
    assert!(set_mesh(&mut world, Some(MeshReference::new("nowhere.stl"))));
    assert_eq!(world.mesh_problems().len(), 1);
    world.document.undo();
    assert!(refresh_meshes(&mut world).unwrap());
    assert!(world.mesh_problems().is_empty());
}

#[test]
fn past_meshes_are_found_again_after_the_design_moved() {
    let (folder, mut world) = saved_world();
    let before = length_mm(&world);
    fs::write(folder.path().join("hook.obj"), HOOK).unwrap();
    set_mesh(&mut world, Some(MeshReference::new("hook.obj")));
    fs::create_dir_all(folder.path().join("down")).unwrap();
    save_as(&mut world, &folder.path().join("down/copy.design.ron")).unwrap();
    assert_eq!(mesh_file(&world), Some("../hook.obj"));
    assert!(!refresh_meshes(&mut world).unwrap());
    world.document.undo();
    assert_eq!(mesh_file(&world), Some("../pointer.glb"));
    assert!(refresh_meshes(&mut world).unwrap());
    assert_eq!(length_mm(&world), before);
}

#[test]
fn a_built_in_designs_mesh_is_saved_relative() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("hook.obj");
    fs::write(&file, HOOK).unwrap();
    let mut world = open_builtin("pointer-on-head").unwrap();
    let reference = mesh_reference_to(&world, BodyRole::Tool, &file).unwrap();
    set_mesh(&mut world, Some(MeshReference::new(reference.clone())));
    assert_eq!(length_mm(&world), Some(7.0));
    set_mesh(&mut world, None);
    world.document.undo();
    refresh_meshes(&mut world).unwrap();
    save_as(&mut world, &folder.path().join("a.design.ron")).unwrap();
    assert_eq!(mesh_file(&world), Some("hook.obj"));
    assert!(!refresh_meshes(&mut world).unwrap());
    assert_eq!(length_mm(&open_design(&folder.path().join("a.design.ron")).unwrap()), Some(7.0));
    // One that is not there is no reason not to save.
    let mut world = open_builtin("pointer-on-head").unwrap();
    set_mesh(&mut world, Some(MeshReference::new("nowhere.stl")));
    save_as(&mut world, &folder.path().join("b.design.ron")).unwrap();
    assert_eq!(mesh_file(&world), Some("nowhere.stl"));
}

#[test]
fn every_path_is_relative_after_the_first_save() {
    let (folder, _) = saved_world();
    let at = |name: &str| folder.path().join(name);
    for name in ["mine", "other"] {
        fs::create_dir(at(name)).unwrap();
    }
    fs::write(at("mine/hook.obj"), HOOK).unwrap();
    for name in ["ward.env.ron", "attic.env.ron"] {
        fs::copy(at("operating-table.env.ron"), at(name)).unwrap();
    }
    let mut world = open_builtin("pointer-on-head").unwrap();
    let mesh = mesh_reference_to(&world, BodyRole::Tool, &at("mine/hook.obj")).unwrap();
    let room = |world: &World, name: &str| reference_to_file(world, &at(name)).unwrap();
    let (ward, attic) = (room(&world, "ward.env.ron"), room(&world, "attic.env.ron"));
    for whole in [&mesh, &ward, &attic] {
        assert!(Path::new(whole).is_absolute(), "the built-in world is on no disk: {whole}");
    }
    set_mesh(&mut world, Some(MeshReference::new(mesh.clone())));
    add(&mut world, anatomy("hook", &mesh));
    world.document.apply(Edit::SetEnvironment { file: ward, metal: None }).unwrap();
    let add_room = Edit::Procedure(ProcedureEdit::AddRoom(attic));
    world.document.apply(add_room).unwrap();
    refresh_environment(&mut world).unwrap();
    let paths = |world: &World| {
        let design = world.document.design();
        let anatomy = design.anatomy[0].mesh.file.clone();
        let further = design.procedure.further_rooms[0].clone();
        [design.tool.body.mesh.clone().unwrap().file, anatomy, design.environment.clone(), further]
    };
    save_as(&mut world, &at("mine/a.design.ron")).unwrap();
    assert_eq!(paths(&world), ["hook.obj", "hook.obj", "../ward.env.ron", "../attic.env.ron"]);
    // Elsewhere they are computed anew, and all are found once the folder itself has moved.
    save_as(&mut world, &at("other/b.design.ron")).unwrap();
    let expected = ["hook.obj", "../mine/hook.obj", "../ward.env.ron", "../attic.env.ron"];
    assert_eq!(paths(&world), expected);
    assert_eq!(world.document.design().tool.body.reference, "../mine/pointer.body.ron");
    let moved = tempfile::tempdir().unwrap();
    let moved = moved.path().join("project");
    fs::rename(folder.path(), &moved).unwrap();
    for name in ["mine/a.design.ron", "other/b.design.ron"] {
        let opened = open_design(&moved.join(name)).unwrap();
        assert!(opened.mesh_problems().is_empty(), "{:?}", opened.mesh_problems());
        assert_eq!(further_rooms(&opened).unwrap().len(), 1);
        assert!(further_rooms(&opened).unwrap()[0].read().is_ok());
    }
}

fn give(world: &mut World, reference: &MeshReference) {
    let edit = Edit::SetMesh { body: BodyRole::Tool, mesh: Some(reference.clone()) };
    world.document.apply(edit).unwrap();
    refresh_meshes(world).unwrap();
}

#[test]
fn a_cached_mesh_is_read_again_only_if_changed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tool.obj");
    fs::write(&file, tetrahedron(100.0)).unwrap();
    let mut world = open_builtin("pointer-on-head").unwrap();
    let own = Arc::clone(world.mesh(BodyRole::Tool).unwrap());
    let wanted = MeshImport::of_file(&world, BodyRole::Tool, &file, None).unwrap();
    let read = wanted.unwrap().read().unwrap();
    world.keep_mesh(read.clone());
    give(&mut world, &read.request.reference);
    assert!(Arc::ptr_eq(world.mesh(BodyRole::Tool).unwrap(), &read.surface));
    let report = world.mesh_report(BodyRole::Tool).unwrap();
    assert!(Arc::ptr_eq(&report, &read.report));
    // Undo and redo find what was there.
    world.document.undo();
    refresh_meshes(&mut world).unwrap();
    assert_eq!(world.mesh(BodyRole::Tool), Some(&own));
    world.document.redo();
    refresh_meshes(&mut world).unwrap();
    assert!(Arc::ptr_eq(world.mesh(BodyRole::Tool).unwrap(), &read.surface));
    world.document.undo();
    refresh_meshes(&mut world).unwrap();
    fs::write(&file, tetrahedron(80.0)).unwrap();
    world.document.redo();
    refresh_meshes(&mut world).unwrap();
    let size = world.mesh_report(BodyRole::Tool).unwrap().bounds.unwrap();
    assert_eq!(size.size_mm().x, 80.0);
    // Read once more, after its program wrote it anew, it is the body's without an edit.
    fs::write(&file, tetrahedron(60.0)).unwrap();
    let again = read.request.read().unwrap();
    assert!(world.keep_mesh(again));
    let size = world.mesh_report(BodyRole::Tool).unwrap().bounds.unwrap();
    assert_eq!(size.size_mm().x, 60.0);
    assert!(crate::changes(&world).is_empty());
}

#[test]
fn another_unit_of_the_same_file_is_another_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tool.obj");
    fs::write(&file, tetrahedron(10.0)).unwrap();
    let mut world = open_builtin("pointer-on-head").unwrap();
    let wanted = MeshImport::of_file(&world, BodyRole::Tool, &file, None).unwrap();
    let wanted = wanted.unwrap();
    for (unit, size_mm) in [(MeshUnit::Millimetre, 10.0), (MeshUnit::Inch, 254.0)] {
        let read = wanted.with_unit(unit).read().unwrap();
        world.keep_mesh(read.clone());
        give(&mut world, &read.request.reference);
        let bounds = world.mesh_report(BodyRole::Tool).unwrap().bounds.unwrap();
        assert_eq!(bounds.size_mm().amax(), size_mm);
    }
    let again = MeshImport::in_unit(&world, BodyRole::Tool, None).unwrap();
    assert_eq!(again.unwrap().reference.unit, None);
}

fn anatomy(name: &str, file: &str) -> Anatomy {
    Anatomy {
        name: name.to_owned(),
        mesh: MeshReference::new(file),
        on: AnatomyFrame::Crf,
        frame_from_mesh: Pose::identity(),
        color: None,
        crf_patch: Vec::new(),
    }
}

fn add(world: &mut World, anatomy: Anatomy) {
    let edit = Edit::Anatomy(AnatomyEdit::Add(Box::new(anatomy)));
    world.document.apply(edit).unwrap();
    refresh_meshes(world).unwrap();
}

/// The pointer's design on the disk, with a head beside it in another folder.
fn world_with_head() -> (TempDir, World) {
    let (folder, mut world) = saved_world();
    let scans = folder.path().join("scans");
    fs::create_dir(&scans).unwrap();
    fs::write(scans.join("head.obj"), tetrahedron(100.0)).unwrap();
    add(&mut world, anatomy("head", "scans/head.obj"));
    (folder, world)
}

fn size_mm(world: &World, index: usize) -> Option<f64> {
    let mesh = world.anatomy_mesh(&world.document.design().anatomy[index].mesh)?;
    Some(mesh.body_bounds()?.size_mm().amax())
}

#[test]
fn anatomy_is_read_again_after_edits_and_undo() {
    let (folder, mut world) = world_with_head();
    assert_eq!(size_mm(&world, 0), Some(100.0));
    save(&mut world).unwrap();
    let opened = open_design(&folder.path().join("a.design.ron")).unwrap();
    assert_eq!(opened.document.design(), world.document.design());
    assert_eq!(size_mm(&opened, 0), Some(100.0));
    // Another unit of the same file is another mesh; where it is is none.
    let mut inch = anatomy("inch", "scans/head.obj");
    inch.mesh.unit = Some(MeshUnit::Inch);
    inch.frame_from_mesh = Pose::translation(0.0, 0.0, 5.0);
    add(&mut world, inch);
    let head = Arc::clone(world.anatomy_mesh(&MeshReference::new("scans/head.obj")).unwrap());
    assert_eq!(size_mm(&world, 1), Some(2540.0));
    let remove = Edit::Anatomy(AnatomyEdit::Remove { index: 0 });
    world.document.apply(remove).unwrap();
    refresh_meshes(&mut world).unwrap();
    assert_eq!(size_mm(&world, 0), Some(2540.0));
    world.document.undo();
    refresh_meshes(&mut world).unwrap();
    assert_eq!((size_mm(&world, 0), size_mm(&world, 1)), (Some(100.0), Some(2540.0)));
    assert_eq!(world.anatomy_mesh(&MeshReference::new("scans/head.obj")), Some(&head));
}

#[test]
fn unreadable_anatomy_is_named() {
    let (folder, mut world) = world_with_head();
    add(&mut world, anatomy("face", "scans/face.stl"));
    fs::write(folder.path().join("scans/broken.stl"), "no mesh").unwrap();
    add(&mut world, anatomy("broken", "scans/broken.stl"));
    let named_problems = |world: &World| -> Vec<(MeshOwner, String)> {
        let problems = world.mesh_problems().into_iter();
        let described = |p: MeshProblem| (p.whose, p.to_string());
        problems.map(described).collect()
    };
    save(&mut world).unwrap();
    let opened = open_design(&folder.path().join("a.design.ron")).unwrap();
    for world in [&world, &opened] {
        let [(face, missing), (broken, unreadable)] = &named_problems(world)[..] else {
            panic!("{:?}", named_problems(world));
        };
        assert_eq!(*face, MeshOwner::Anatomy(Some(1)));
        assert!(missing.starts_with("the anatomy \"face\" is missing: "), "{missing}");
        assert!(missing.contains("face.stl"), "{missing}");
        assert_eq!(*broken, MeshOwner::Anatomy(Some(2)));
        assert!(unreadable.contains("broken.stl"), "{unreadable}");
        assert_eq!(size_mm(world, 0), Some(100.0));
    }
    fs::write(folder.path().join("scans/face.stl"), "solid face\nendsolid face\n").unwrap();
    fs::write(folder.path().join("scans/broken.stl"), tetrahedron(1.0)).unwrap();
    assert!(reload_meshes(&mut world).unwrap());
    fs::copy(folder.path().join("scans/head.obj"), folder.path().join("scans/face.obj")).unwrap();
    let found = Edit::Anatomy(AnatomyEdit::Set {
        index: 1,
        anatomy: Box::new(anatomy("face", "scans/face.obj")),
    });
    world.document.apply(found).unwrap();
    assert!(refresh_meshes(&mut world).unwrap());
    assert_eq!(size_mm(&world, 1), Some(100.0));
    assert_eq!(named_problems(&world).len(), 1);
}

#[test]
fn an_imported_mesh_is_not_read_twice() {
    let (folder, mut world) = world_with_head();
    let file = folder.path().join("scans/face.obj");
    fs::write(&file, tetrahedron(7.0)).unwrap();
    let wanted = MeshImport::of_file(&world, MeshOwner::Anatomy(None), &file, None);
    let wanted = wanted.unwrap().unwrap();
    assert_eq!(wanted.reference.file, "scans/face.obj");
    let read = wanted.read().unwrap();
    assert!(!world.keep_mesh(read.clone()));
    add(&mut world, anatomy("face", &wanted.reference.file));
    assert!(Arc::ptr_eq(world.anatomy_mesh(&wanted.reference).unwrap(), &read.surface));
    fs::write(&file, tetrahedron(8.0)).unwrap();
    assert!(world.keep_mesh(wanted.read().unwrap()));
    assert_eq!(size_mm(&world, 1), Some(8.0));
    assert!(changes(&world).is_empty());
}

#[test]
fn a_moved_design_finds_its_anatomy() {
    let (folder, mut world) = world_with_head();
    let far = folder.path().join("far");
    fs::create_dir(&far).unwrap();
    let whole = folder.path().join("scans/head.obj");
    add(&mut world, anatomy("whole", &whole.to_string_lossy()));
    let remove = Edit::Anatomy(AnatomyEdit::Remove { index: 0 });
    world.document.apply(remove).unwrap();
    world.document.undo();
    refresh_meshes(&mut world).unwrap();
    save_as(&mut world, &far.join("b.design.ron")).unwrap();
    let file =
        |world: &World, index: usize| world.document.design().anatomy[index].mesh.file.clone();
    assert_eq!(file(&world, 0), "../scans/head.obj");
    assert_eq!(file(&world, 1), "../scans/head.obj");
    assert_eq!((size_mm(&world, 0), size_mm(&world, 1)), (Some(100.0), Some(100.0)));
    assert!(!refresh_meshes(&mut world).unwrap());
    let opened = open_design(&far.join("b.design.ron")).unwrap();
    assert_eq!(size_mm(&opened, 0), Some(100.0));
    world.document.undo();
    refresh_meshes(&mut world).unwrap();
    assert_eq!(size_mm(&world, 0), Some(100.0));
    assert!(world.mesh_problems().is_empty());
}

/// A tetrahedron, and comments that make its file a large one.
fn large_tetrahedron(size: f64) -> String {
    tetrahedron(size) + &"# nothing\n".repeat(200_000)
}

#[test]
fn a_window_does_not_wait_for_large_meshes() {
    let (folder, mut world) = saved_world();
    let at = |name: &str| folder.path().join(name);
    for name in ["tool.obj", "head.obj"] {
        fs::write(at(name), large_tetrahedron(80.0)).unwrap();
    }
    set_mesh(&mut world, Some(MeshReference::new("tool.obj")));
    for name in ["head", "again"] {
        add(&mut world, anatomy(name, "head.obj"));
    }
    save(&mut world).unwrap();
    let mut opened = open_design_to_show(&at("a.design.ron")).unwrap();
    // The small one is there, and none of the others is missed.
    assert!(opened.mesh(BodyRole::Crf).is_some() && opened.mesh(BodyRole::Tool).is_none());
    assert!(opened.mesh_problems().is_empty() && opened.mesh_doubts().is_empty());
    let awaited = opened.awaited_meshes();
    let whose: Vec<MeshOwner> = awaited.iter().map(|it| it.whose).collect();
    let [head, again] = [0, 1].map(|index| MeshOwner::Anatomy(Some(index)));
    assert_eq!(whose, [BodyRole::Tool.into(), head, again]);
    // An edit of something else reads nothing.
    opened.document.apply(Edit::SetName("Other".into())).unwrap();
    assert!(!refresh_meshes(&mut opened).unwrap());
    assert_eq!(opened.awaited_meshes(), awaited);
    assert!(opened.keep_mesh(awaited[0].read().unwrap()));
    assert_eq!(length_mm(&opened), Some(80.0));
    // Two of the anatomy are one file.
    fs::remove_file(at("head.obj")).unwrap();
    let error = awaited[1].read().unwrap_err();
    assert!(opened.miss_mesh(&awaited[1], error));
    assert_eq!((opened.awaited_meshes().len(), opened.mesh_problems().len()), (0, 2));
    let late = StoreError::NoBodyFormat { file: at("head.obj") };
    assert!(!opened.miss_mesh(&awaited[1], late), "it is not awaited any more");
    opened.document.undo();
    assert!(!opened.document.is_dirty());
}

#[test]
fn a_mesh_that_somebody_else_rewrites_is_reported() {
    let (folder, world) = world_with_head();
    assert_eq!(changes(&world), []);
    fs::write(folder.path().join("scans/head.obj"), "").unwrap();
    let [changed] = &changes(&world)[..] else {
        panic!("{:?}", changes(&world));
    };
    assert_eq!(changed.part, WatchedPart::Anatomy);
    assert_eq!(changed.change, FileChange::Content);
}
