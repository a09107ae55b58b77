//! Opening, saving and sharing files in a folder of the test's own.

use super::write::write_bytes;
use super::*;
use nalgebra::Point3;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use trackwright_design::{BodyRole, Edit, Origin};
use trackwright_geometry::mesh_reference::{MeshReference, MeshUnit};

/// A folder with `design.design.ron` and all that belongs to it.
fn saved_world(builtin: &str) -> (TempDir, World) {
    let folder = tempfile::tempdir().unwrap();
    let mut world = open_builtin(builtin).unwrap();
    save_as(&mut world, &folder.path().join("design.design.ron")).unwrap();
    (folder, world)
}

fn move_sensor(world: &mut World, body: BodyRole, z_mm: f64) {
    let mut sensor = world.document.design().body(body).unwrap().rigid.sensors[0].clone();
    sensor.position_in_body = Point3::new(0.0, 0.0, z_mm);
    let edit = Edit::SetSensor { body, index: 0, sensor };
    assert!(world.document.apply(edit).unwrap());
}

fn mesh_file(world: &World) -> Option<&str> {
    let mesh = world.document.design().tool.body.mesh.as_ref();
    mesh.map(|mesh| mesh.file.as_str())
}

fn names(report: &SaveReport) -> Vec<String> {
    let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
    report.written.iter().map(name).collect()
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_built_in_design_is_saved_with_everything_it_refers_to() {
    let (folder, world) = saved_world("pointer-on-head");
    assert_eq!(
        files(folder.path()),
        [
            "design.design.ron",
            "head-crf.body.ron",
            "head-crf.glb",
            "operating-table.env.ron",
            "pointer.body.ron",
            "pointer.glb",
        ]
    );
    assert!(!world.document.is_dirty());
    let again = open_design(&folder.path().join("design.design.ron")).unwrap();
    assert_eq!(again.document.design(), world.document.design());
    assert_eq!(again.environment, world.environment);
    assert_eq!(again.mesh(BodyRole::Tool), world.mesh(BodyRole::Tool));
    let embedded = open_builtin("pointer-on-head").unwrap();
    assert_eq!(again.document.design().tool.body.rigid, embedded.document.design().tool.body.rigid);
    assert!(matches!(again.document.origin(), Origin::File(_)));
}

#[test]
fn a_built_in_design_is_read_only() {
    let mut world = open_builtin("endoscope").unwrap();
    let error = save(&mut world).unwrap_err().to_string();
    assert!(error.starts_with("the built-in design endoscope is read-only"), "{error}");
    let error = open_builtin("spoon").unwrap_err().to_string();
    assert!(error.contains("expected one of pointer-on-head, "), "{error}");
}

#[test]
fn save_writes_only_what_changed_and_undo_brings_back_the_bytes() {
    let (folder, mut world) = saved_world("pointer-on-head");
    assert_eq!(save(&mut world).unwrap(), SaveReport::default());
    let body_file = folder.path().join("pointer.body.ron");
    let before = fs::read(&body_file).unwrap();
    move_sensor(&mut world, BodyRole::Tool, 80.0);
    assert_eq!(names(&save(&mut world).unwrap()), ["pointer.body.ron"]);
    assert_ne!(fs::read(&body_file).unwrap(), before);
    assert!(!world.document.is_dirty());
    world.document.undo();
    assert!(world.document.is_dirty());
    assert_eq!(names(&save(&mut world).unwrap()), ["pointer.body.ron"]);
    assert_eq!(fs::read(&body_file).unwrap(), before);
    world.document.apply(Edit::SetName("Other".into())).unwrap();
    move_sensor(&mut world, BodyRole::Crf, -3.0);
    let report = save(&mut world).unwrap();
    assert_eq!(names(&report), ["head-crf.body.ron", "design.design.ron"]);
}

#[test]
fn a_file_with_comments_keeps_its_bytes_while_its_content_is_the_same() {
    let (folder, _) = saved_world("endoscope");
    let body_file = folder.path().join("endoscope.body.ron");
    let text = format!("// mine\n{}", fs::read_to_string(&body_file).unwrap());
    fs::write(&body_file, &text).unwrap();
    let mut world = open_design(&folder.path().join("design.design.ron")).unwrap();
    world.document.apply(Edit::SetName("Other".into())).unwrap();
    assert_eq!(names(&save(&mut world).unwrap()), ["design.design.ron"]);
    assert_eq!(fs::read_to_string(&body_file).unwrap(), text);
}

#[test]
fn save_as_elsewhere_refers_to_what_stays_and_copies_what_changed() {
    let (folder, mut world) = saved_world("pointer-on-head");
    let body_file = folder.path().join("pointer.body.ron");
    let before = fs::read(&body_file).unwrap();
    move_sensor(&mut world, BodyRole::Tool, 80.0);
    let elsewhere = folder.path().join("deep/down");
    fs::create_dir_all(&elsewhere).unwrap();
    let file = elsewhere.join("copy.design.ron");
    let report = save_as(&mut world, &file).unwrap();
    assert_eq!(names(&report), ["pointer.body.ron", "copy.design.ron"]);
    assert_eq!(fs::read(&body_file).unwrap(), before);
    let design = world.document.design();
    assert_eq!(design.tool.body.reference, "pointer.body.ron");
    assert_eq!(mesh_file(&world), Some("../../pointer.glb"));
    assert_eq!(design.crf.as_ref().unwrap().body.reference, "../../head-crf.body.ron");
    assert_eq!(design.environment, "../../operating-table.env.ron");
    let again = open_design(&file).unwrap();
    assert_eq!(again.document.design(), design);
    // Undo after moving does not lead back to the old files.
    world.document.undo();
    save(&mut world).unwrap();
    assert_eq!(fs::read(&body_file).unwrap(), before);
    assert_eq!(world.document.origin(), &Origin::File(file));
}

#[test]
fn save_as_never_overwrites_another_body_nor_its_own() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("pointer.body.ron"), "mine").unwrap();
    let mut world = open_builtin("pointer-on-head").unwrap();
    save_as(&mut world, &folder.path().join("a.design.ron")).unwrap();
    assert_eq!(fs::read(folder.path().join("pointer.body.ron")).unwrap(), b"mine");
    assert_eq!(world.document.design().tool.body.reference, "pointer-2.body.ron");
    let own = folder.path().join("pointer-2.body.ron");
    let error = save_as(&mut world, &own).unwrap_err();
    assert!(matches!(error, StoreError::InUse { .. }), "{error}");
}

#[test]
fn a_failed_save_as_leaves_the_document_where_it_was() {
    let (folder, mut world) = saved_world("endoscope");
    let origin = world.document.origin().clone();
    let error = save_as(&mut world, &folder.path().join("no/such/x.design.ron")).unwrap_err();
    assert!(error.to_string().contains("cannot be written"), "{error}");
    assert_eq!(world.document.origin(), &origin);
}

#[test]
fn designs_that_share_a_changed_body_are_named_and_can_be_spared() {
    let (folder, mut world) = saved_world("pointer-on-head");
    let design = folder.path().join("design.design.ron");
    let other = folder.path().join("other.design.ron");
    fs::copy(&design, &other).unwrap();
    fs::write(folder.path().join("broken.design.ron"), "(").unwrap();
    assert_eq!(shared_bodies(&world), []);
    move_sensor(&mut world, BodyRole::Tool, 80.0);
    let shared = shared_bodies(&world);
    assert_eq!(shared.len(), 1);
    assert_eq!((shared[0].role, &shared[0].designs), (BodyRole::Tool, &vec![other]));
    let before = fs::read(folder.path().join("pointer.body.ron")).unwrap();
    let report = save_with_copies(&mut world).unwrap();
    assert_eq!(names(&report), ["pointer-2.body.ron", "design.design.ron"]);
    assert_eq!(fs::read(folder.path().join("pointer.body.ron")).unwrap(), before);
    let again = open_design(&design).unwrap();
    assert_eq!(again.document.design(), world.document.design());
    assert!(!world.document.is_dirty());
    assert_eq!(shared_bodies(&world), []);
}

#[test]
fn one_body_in_two_roles_cannot_be_saved_as_two() {
    let (folder, _) = saved_world("pointer-on-head");
    let file = folder.path().join("design.design.ron");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace("head-crf.body", "./pointer.body")).unwrap();
    let mut world = open_design(&file).unwrap();
    move_sensor(&mut world, BodyRole::Tool, 80.0);
    let error = save(&mut world).unwrap_err();
    assert!(matches!(error, StoreError::BodiesDiffer { .. }), "{error}");
    move_sensor(&mut world, BodyRole::Crf, 80.0);
    assert_eq!(names(&save(&mut world).unwrap()), ["pointer.body.ron"]);
}

#[test]
fn another_environment_is_read_when_the_design_refers_to_it() {
    let (folder, mut world) = saved_world("endoscope");
    assert!(!refresh_environment(&mut world).unwrap());
    let mut ideal = (*world.environment).clone();
    ideal.name = "Ideal".to_owned();
    let files = Files::default();
    let output = files.output(&folder.path().join("ideal.env.ron"));
    output.unwrap().write_environment(&ideal).unwrap();
    let edit = Edit::SetEnvironment("ideal.env.ron".into());
    world.document.apply(edit).unwrap();
    assert!(refresh_environment(&mut world).unwrap());
    assert_eq!(world.environment.name, "Ideal");
    world.document.undo();
    assert!(refresh_environment(&mut world).unwrap());
    let edit = Edit::SetEnvironment("nowhere.env.ron".into());
    world.document.apply(edit).unwrap();
    let error = refresh_environment(&mut world).unwrap_err().to_string();
    assert!(error.ends_with("found no such file or folder, expected an environment"), "{error}");
    assert_eq!(world.environment.name, "Operating table");
}

#[test]
fn every_file_that_cannot_be_used_is_named() {
    let (folder, _) = saved_world("pointer-on-head");
    let design = folder.path().join("design.design.ron");
    for (name, content, part) in [
        ("head-crf.body.ron", Some(&b"(version: 2)"[..]), "version is 2, expected 1"),
        ("pointer.body.ron", Some(b"\xff"), "line 1, column 1: found a byte that is not UTF-8"),
        ("operating-table.env.ron", None, "found no such file or folder, expected an environment"),
        ("operating-table.env.ron", Some(b""), "line 1, column 1: found the end of the file"),
        ("design.design.ron", Some(b"(version: 1,"), "line 1, column 13: found"),
    ] {
        let file = folder.path().join(name);
        let before = fs::read(&file).unwrap();
        match content {
            Some(content) => fs::write(&file, content).unwrap(),
            None => fs::remove_file(&file).unwrap(),
        }
        let error = open_design(&design).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: ", file.display())), "{error}");
        assert!(error.contains(part), "{error}");
        assert_eq!(error.matches("expected").count(), 1, "{error}");
        fs::write(&file, before).unwrap();
    }
    let error = open_design(folder.path()).unwrap_err().to_string();
    assert!(error.ends_with("found a folder, expected a design"), "{error}");
}

#[test]
fn an_interrupted_write_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.csv");
    fs::write(&file, "old").unwrap();
    let files_of_command = Files::default();
    let output = files_of_command.output(&file).unwrap();
    let error = output
        .write(|out| {
            out.write_all(&[b'x'; 100_000])?;
            Err(io::Error::other("the pen broke"))
        })
        .unwrap_err()
        .to_string();
    assert!(error.ends_with("cannot be written: the pen broke"), "{error}");
    assert_eq!(fs::read(&file).unwrap(), b"old");
    assert_eq!(files(folder.path()), ["x.csv"]);
}

#[cfg(unix)]
#[test]
fn a_new_file_has_the_mode_of_any_other_and_an_old_one_keeps_its_own() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    let write = |path: &Path| write_bytes(path, b"new").unwrap();
    let (plain, new) = (folder.path().join("plain"), folder.path().join("new"));
    fs::write(&plain, "").unwrap();
    write(&new);
    assert_eq!(mode(&new), mode(&plain));
    fs::set_permissions(&plain, fs::Permissions::from_mode(0o640)).unwrap();
    let link = folder.path().join("link");
    symlink(&plain, &link).unwrap();
    write(&link);
    assert_eq!(mode(&plain), 0o640);
    assert_eq!(fs::read(&plain).unwrap(), b"new");
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
}

#[test]
fn the_orientation_weight_is_the_designs_else_the_environments() {
    let mut world = open_builtin("pointer-on-head").unwrap();
    let weight =
        |world: &World| resolve(world.document.design(), &world.environment).orientation_weight_mm;
    assert_eq!(weight(&world), 100.0);
    let edit = Edit::SetOrientationWeight(Some(30.0));
    world.document.apply(edit).unwrap();
    assert_eq!(weight(&world), 30.0);
}

#[test]
fn a_design_opens_without_a_mesh_that_cannot_be_used_and_says_why() {
    let (folder, _) = saved_world("pointer-on-head");
    let design = folder.path().join("design.design.ron");
    let file = folder.path().join("pointer.glb");
    let before = fs::read(&file).unwrap();
    for (content, part, z_mm) in [
        (None, "found no such file or folder, expected a mesh", 80.0),
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
fn another_mesh_is_read_when_the_body_refers_to_it_and_the_old_one_when_that_is_undone() {
    let (folder, mut world) = saved_world("pointer-on-head");
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
    let again = open_design(&folder.path().join("design.design.ron")).unwrap();
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
    let (folder, mut world) = saved_world("pointer-on-head");
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
fn a_mesh_given_to_a_built_in_design_stays_where_it_is_when_that_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("hook.obj");
    fs::write(&file, HOOK).unwrap();
    let mut world = open_builtin("pointer-on-head").unwrap();
    let reference = mesh_reference_to(&world, BodyRole::Tool, &file).unwrap();
    set_mesh(&mut world, Some(MeshReference::new(reference.clone())));
    assert_eq!(length_mm(&world), Some(7.0));
    save_as(&mut world, &folder.path().join("a.design.ron")).unwrap();
    assert_eq!(mesh_file(&world), Some(reference.as_str()));
    assert_eq!(length_mm(&open_design(&folder.path().join("a.design.ron")).unwrap()), Some(7.0));
    // One that is not there is no reason not to save.
    let mut world = open_builtin("pointer-on-head").unwrap();
    set_mesh(&mut world, Some(MeshReference::new("nowhere.stl")));
    save_as(&mut world, &folder.path().join("b.design.ron")).unwrap();
    assert_eq!(mesh_file(&world), Some("nowhere.stl"));
}

#[test]
fn numbers_alone_need_no_mesh() {
    let (folder, _) = saved_world("pointer-on-head");
    fs::remove_file(folder.path().join("pointer.glb")).unwrap();
    let design = folder.path().join("design.design.ron");
    let world = open_design_without_meshes(&design).unwrap();
    assert!(world.mesh(BodyRole::Crf).is_none() && world.mesh_problems().is_empty());
    assert_eq!(world.document.design(), open_design(&design).unwrap().document.design());
}
