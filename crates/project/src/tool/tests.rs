//! Designs whose bodies are makers' files: what Save leaves alone and what it writes instead.

use super::super::recovery::{Recovery, Snapshot, leftovers};
use super::super::{
    FileChange, World, accept_changes, changes, open_builtin, open_design, save, save_as,
    save_with_copies, shared_bodies,
};
use super::*;
use nalgebra::{Point3, Vector3};
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;
use trackwright_design::{BodyRole, Edit};
use trackwright_formats::tool_definition::{DefinitionFormat, from_body};
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_simulation::body::{RigidBody, Sensor, SensorOrientation};

const PROBE: &str = "roms/probe.rom";

/// The image of two coils.
fn probe() -> Vec<u8> {
    let coil = |name: &str, x, axis| Sensor {
        name: name.to_owned(),
        position_in_body: Point3::new(x, 0.0, 40.0),
        orientation: SensorOrientation::FiveDof(axis),
        coil: None,
    };
    let body = BodyFile {
        rigid: RigidBody {
            name: "probe".to_owned(),
            tip_in_body: None,
            sensors: vec![
                coil("coil 1", -2.0, Vector3::z_axis()),
                coil("coil 2", 2.0, Vector3::x_axis()),
            ],
        },
        mesh: None,
        definition: None,
    };
    let conversion = from_body(&body, DefinitionFormat::Rom).unwrap();
    conversion.definition.write().into_owned()
}

/// A design in a folder whose tool, and CRF if it has one, are the maker's file in another folder.
fn world(builtin: &str) -> (TempDir, PathBuf, World) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.design.ron");
    let saved = &mut open_builtin(builtin).unwrap();
    save_as(saved, &file).unwrap();
    fs::create_dir(folder.path().join("roms")).unwrap();
    fs::write(folder.path().join(PROBE), probe()).unwrap();
    let mut text = fs::read_to_string(&file).unwrap();
    for (_, body) in saved.document.design().bodies() {
        text = text.replace(&body.reference, PROBE);
    }
    fs::write(&file, text).unwrap();
    let world = open_design(&file).unwrap();
    (folder, file, world)
}

fn reference(world: &World, role: BodyRole) -> &str {
    &world.document.design().body(role).unwrap().reference
}

fn shift(world: &mut World, body: BodyRole) {
    let mut sensor = world.document.design().body(body).unwrap().rigid.sensors[0].clone();
    sensor.position_in_body.y += 1.0;
    let edit = Edit::SetSensor { body, index: 0, sensor };
    assert!(world.document.apply(edit).unwrap());
}

fn written(report: &super::super::SaveReport) -> Vec<String> {
    let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
    report.written.iter().map(name).collect()
}

#[test]
fn a_makers_file_is_never_written_over_and_a_changed_body_goes_beside_the_design() {
    let (folder, file, mut world) = world("endoscope");
    world.document.apply(Edit::SetName("b".into())).unwrap();
    assert_eq!(written(&save(&mut world).unwrap()), ["a.design.ron"]);
    assert_eq!(reference(&world, BodyRole::Tool), PROBE);
    // Of another design, and not this one's to write over.
    fs::write(folder.path().join("probe.body.ron"), "mine").unwrap();
    shift(&mut world, BodyRole::Tool);
    assert_eq!(shared_bodies(&world), []);
    let report = save(&mut world).unwrap();
    assert_eq!(written(&report), ["probe-2.body.ron", "a.design.ron"]);
    assert_eq!(fs::read(folder.path().join("probe.body.ron")).unwrap(), b"mine");
    assert_eq!(fs::read(folder.path().join(PROBE)).unwrap(), probe());
    assert!(!world.document.is_dirty());
    assert_eq!(changes(&world), []);
    assert_eq!(written(&save(&mut world).unwrap()), [""; 0]);
    let again = open_design(&file).unwrap();
    assert_eq!(again.document.design(), world.document.design());
    // Undo leads to the body as it was, in the new file: there all that the maker's file said is.
    assert!(world.document.undo().is_some());
    assert_eq!(written(&save(&mut world).unwrap()), ["probe-2.body.ron"]);
    let body = read_tool(&folder.path().join("probe-2.body.ron"), OnMismatch::Refuse).unwrap();
    assert_eq!(body.kind, None);
    let conversion = from_body(&body.body, DefinitionFormat::Rom).unwrap();
    assert_eq!(*conversion.definition.write(), probe());
}

#[test]
fn a_mesh_that_was_given_to_a_makers_tool_is_still_reached_after_the_body_moved() {
    let (folder, file, mut world) = world("endoscope");
    fs::write(folder.path().join("m.stl"), "solid s\nendsolid s\n").unwrap();
    for file in ["../m.stl", "/nowhere/m.stl", "../m.stl"] {
        let edit = Edit::SetMesh { body: BodyRole::Tool, mesh: Some(MeshReference::new(file)) };
        world.document.apply(edit).unwrap();
    }
    save(&mut world).unwrap();
    let mesh = |world: &World| world.document.design().tool.body.mesh.clone().unwrap().file;
    assert_eq!(mesh(&open_design(&file).unwrap()), "m.stl");
    // In every state.
    world.document.undo();
    assert_eq!(mesh(&world), "/nowhere/m.stl");
    world.document.undo();
    assert_eq!(mesh(&world), "m.stl");
}

#[test]
fn one_makers_file_in_two_roles_becomes_as_many_bodies_as_changed() {
    let (folder, _, mut world) = world("pointer-on-head");
    shift(&mut world, BodyRole::Tool);
    let report = save_with_copies(&mut world).unwrap();
    assert_eq!(written(&report), ["probe.body.ron", "a.design.ron"]);
    assert_eq!(reference(&world, BodyRole::Tool), "probe.body.ron");
    assert_eq!(reference(&world, BodyRole::Crf), PROBE);
    shift(&mut world, BodyRole::Crf);
    shift(&mut world, BodyRole::Crf);
    let report = save(&mut world).unwrap();
    assert_eq!(written(&report), ["probe-2.body.ron", "a.design.ron"]);
    assert_eq!(fs::read(folder.path().join(PROBE)).unwrap(), probe());
}

#[test]
fn save_as_leaves_a_makers_file_where_it_is_until_its_body_changed() {
    let (folder, _, mut world) = world("endoscope");
    let deep = folder.path().join("deep");
    fs::create_dir(&deep).unwrap();
    let report = save_as(&mut world, &deep.join("b.design.ron")).unwrap();
    assert_eq!(written(&report), ["b.design.ron"]);
    assert_eq!(reference(&world, BodyRole::Tool), "../roms/probe.rom");
    shift(&mut world, BodyRole::Tool);
    let report = save_as(&mut world, &folder.path().join("roms/c.design.ron")).unwrap();
    assert_eq!(written(&report), ["probe.body.ron", "c.design.ron"]);
    assert_eq!(reference(&world, BodyRole::Tool), "probe.body.ron");
    assert_eq!(fs::read(folder.path().join(PROBE)).unwrap(), probe());
}

#[test]
fn what_a_crash_left_of_a_makers_tool_is_saved_beside_the_design_too() {
    let (folder, file, mut world) = world("endoscope");
    shift(&mut world, BodyRole::Tool);
    let state = folder.path().join("state");
    let mut recovery = Recovery::start(&state).unwrap();
    assert!(recovery.write(&Snapshot::of(&world)).unwrap());
    drop(recovery);
    // Somebody else's file by now, and gone later: neither is a reason to write over it.
    let mut other = probe();
    other.push(0);
    fs::write(folder.path().join(PROBE), &other).unwrap();
    let leftover = leftovers(&state).unwrap().remove(0);
    let mut recovered = leftover.open().unwrap();
    assert_eq!(recovered.document.design(), world.document.design());
    let changed = changes(&recovered);
    assert_eq!(changed.len(), 1);
    assert_eq!(changed[0].change, FileChange::Content);
    save(&mut recovered).unwrap();
    assert_eq!(fs::read(folder.path().join(PROBE)).unwrap(), other);
    assert_eq!(reference(&recovered, BodyRole::Tool), "probe.body.ron");
    let again = open_design(&file).unwrap();
    assert_eq!(again.document.design(), world_after(&world, "probe.body.ron").document.design());
    // The first session goes on after all, and was told of what the second one wrote.
    fs::remove_file(folder.path().join(PROBE)).unwrap();
    accept_changes(&mut world);
    save(&mut world).unwrap();
    assert!(!folder.path().join(PROBE).exists());
    assert_eq!(reference(&world, BodyRole::Tool), "probe-2.body.ron");
}

/// The same world whose tool is in another file.
fn world_after(world: &World, reference: &str) -> World {
    let mut after = world.clone();
    let origin = after.document.origin().clone();
    after.document.relocate(origin, |design| {
        design.tool.body.reference = reference.to_owned();
    });
    after
}
