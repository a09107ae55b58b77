//! Opening, saving and sharing files in a folder of the test's own, and what other tests share.

mod crf_patch;
mod import_body;
mod meshes;
mod metal;
mod mounting;
mod new_tool;
mod recovery;
mod tool;

use super::write::write_bytes;
use super::*;
use nalgebra::{Point3, Vector3};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use trackwright_design::{BodyRole, Edit, Origin};
use trackwright_formats::BodyFile;
use trackwright_formats::tool_definition::{DefinitionFormat, from_body};
use trackwright_simulation::body::{RigidBody, Sensor};
use trackwright_simulation::mounting::Mounting;

/// A folder with `a.design.ron` and all that belongs to it.
pub fn saved_world() -> (TempDir, World) {
    saved_design("pointer-on-head")
}

fn saved_design(builtin: &str) -> (TempDir, World) {
    let folder = tempfile::tempdir().unwrap();
    let mut world = open_builtin(builtin).unwrap();
    save_as(&mut world, &folder.path().join("a.design.ron")).unwrap();
    (folder, world)
}

/// The names of a folder's files, in order.
pub fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<_> = entries.map(name).collect();
    names.sort();
    names
}

/// A tetrahedron of this size, as OBJ.
fn tetrahedron(size: f64) -> String {
    format!(
        "v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nv 0 0 {size}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
}

/// A maker's file: the image of two coils.
fn rom(name: &str) -> Vec<u8> {
    let coil = |name: &str, x, axis| Sensor::five_dof(name, Point3::new(x, 0.0, 40.0), axis);
    let sensors =
        vec![coil("coil 1", -2.0, Vector3::z_axis()), coil("coil 2", 2.0, Vector3::x_axis())];
    let rigid = RigidBody { name: name.to_owned(), tip_in_body: None, sensors };
    let body = BodyFile { rigid, mesh: None, definition: None, mounting: Mounting::default() };
    let conversion = from_body(&body, DefinitionFormat::Rom).unwrap();
    conversion.definition.write().into_owned()
}

/// What a session leaves that writes and ends without a word.
fn crashed(state: &Path, world: &World) -> Leftover {
    let mut recovery = Recovery::start(state).unwrap();
    assert!(recovery.write(&Snapshot::of(world)).unwrap());
    drop(recovery);
    let mut found = leftovers(state).unwrap();
    assert_eq!(found.len(), 1);
    found.remove(0)
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

#[test]
fn a_built_in_design_is_saved_with_its_parts() {
    let (folder, world) = saved_world();
    assert_eq!(
        files(folder.path()),
        [
            "a.design.ron",
            "head-crf.body.ron",
            "head-crf.glb",
            "operating-table.env.ron",
            "pointer.body.ron",
            "pointer.glb",
        ]
    );
    assert!(!world.document.is_dirty());
    let again = open_design(&folder.path().join("a.design.ron")).unwrap();
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
fn save_writes_only_what_changed() {
    let (folder, mut world) = saved_world();
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
    assert_eq!(names(&report), ["head-crf.body.ron", "a.design.ron"]);
}

#[test]
fn a_file_with_comments_keeps_its_bytes() {
    let (folder, _) = saved_design("endoscope");
    let body_file = folder.path().join("endoscope.body.ron");
    let text = format!("// mine\n{}", fs::read_to_string(&body_file).unwrap());
    fs::write(&body_file, &text).unwrap();
    let mut world = open_design(&folder.path().join("a.design.ron")).unwrap();
    world.document.apply(Edit::SetName("Other".into())).unwrap();
    assert_eq!(names(&save(&mut world).unwrap()), ["a.design.ron"]);
    assert_eq!(fs::read_to_string(&body_file).unwrap(), text);
}

#[test]
fn save_as_copies_only_what_changed() {
    let (folder, mut world) = saved_world();
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
    let (folder, mut world) = saved_design("endoscope");
    let origin = world.document.origin().clone();
    let error = save_as(&mut world, &folder.path().join("no/such/x.design.ron")).unwrap_err();
    assert!(error.to_string().contains("cannot be written"), "{error}");
    assert_eq!(world.document.origin(), &origin);
}

#[test]
fn designs_that_share_a_changed_body_are_named() {
    let (folder, mut world) = saved_world();
    let design = folder.path().join("a.design.ron");
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
    assert_eq!(names(&report), ["pointer-2.body.ron", "a.design.ron"]);
    assert_eq!(fs::read(folder.path().join("pointer.body.ron")).unwrap(), before);
    let again = open_design(&design).unwrap();
    assert_eq!(again.document.design(), world.document.design());
    assert!(!world.document.is_dirty());
    assert_eq!(shared_bodies(&world), []);
}

#[test]
fn one_body_in_two_roles_cannot_be_saved_as_two() {
    let (folder, _) = saved_world();
    let file = folder.path().join("a.design.ron");
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
fn another_environment_is_read_after_its_edit() {
    let (folder, mut world) = saved_design("endoscope");
    assert!(!refresh_environment(&mut world).unwrap());
    let mut ideal = (*world.environment).clone();
    ideal.name = "Ideal".to_owned();
    let files = Files::default();
    let output = files.output(&folder.path().join("ideal.env.ron"));
    output.unwrap().write_environment(&ideal).unwrap();
    let edit = Edit::SetEnvironment { file: "ideal.env.ron".into(), metal: None };
    world.document.apply(edit).unwrap();
    assert!(refresh_environment(&mut world).unwrap());
    assert_eq!(world.environment.name, "Ideal");
    world.document.undo();
    assert!(refresh_environment(&mut world).unwrap());
    let edit = Edit::SetEnvironment { file: "nowhere.env.ron".into(), metal: None };
    world.document.apply(edit).unwrap();
    let error = refresh_environment(&mut world).unwrap_err().to_string();
    assert!(error.ends_with("File not found, expected an environment"), "{error}");
    assert_eq!(world.environment.name, "Operating table");
}

#[test]
fn every_file_that_cannot_be_used_is_named() {
    let (folder, _) = saved_world();
    let design = folder.path().join("a.design.ron");
    for (name, content, part) in [
        ("head-crf.body.ron", Some(&b"(version: 2)"[..]), "version is 2, expected 1"),
        ("pointer.body.ron", Some(b"\xff"), "line 1, column 1: found a byte that is not UTF-8"),
        ("operating-table.env.ron", None, "File not found, expected an environment"),
        ("operating-table.env.ron", Some(b""), "line 1, column 1: found the end of the file"),
        ("a.design.ron", Some(b"(version: 1,"), "line 1, column 13: found"),
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
fn an_interrupted_write_leaves_the_old_file() {
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
fn files_keep_their_modes() {
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
fn the_designs_orientation_weight_comes_first() {
    let mut world = open_builtin("pointer-on-head").unwrap();
    let weight =
        |world: &World| resolve(world.document.design(), &world.environment).orientation_weight_mm;
    assert_eq!(weight(&world), 100.0);
    let edit = Edit::SetOrientationWeight(Some(30.0));
    world.document.apply(edit).unwrap();
    assert_eq!(weight(&world), 30.0);
}

#[test]
fn numbers_alone_need_no_mesh() {
    let (folder, _) = saved_world();
    fs::remove_file(folder.path().join("pointer.glb")).unwrap();
    let design = folder.path().join("a.design.ron");
    let world = open_design_without_meshes(&design).unwrap();
    assert!(world.mesh(BodyRole::Crf).is_none() && world.mesh_problems().is_empty());
    assert_eq!(world.document.design(), open_design(&design).unwrap().document.design());
}
