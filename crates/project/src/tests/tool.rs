//! Designs whose bodies are makers' files: what Save leaves alone and what it writes instead.

use super::*;
use crate::tool::read_tool;
use trackwright_formats::tool_definition::OnMismatch;
use trackwright_geometry::mesh_reference::MeshReference;

const PROBE: &str = "roms/probe.rom";

fn probe() -> Vec<u8> {
    rom("probe")
}

/// A design in a folder whose tool, and CRF if it has one, are the maker's file in another folder.
fn world(builtin: &str) -> (TempDir, PathBuf, World) {
    let (folder, saved) = saved_design(builtin);
    let file = folder.path().join("a.design.ron");
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

#[test]
fn a_makers_file_is_never_written_over() {
    let (folder, file, mut world) = world("endoscope");
    world.document.apply(Edit::SetName("b".into())).unwrap();
    assert_eq!(names(&save(&mut world).unwrap()), ["a.design.ron"]);
    assert_eq!(reference(&world, BodyRole::Tool), PROBE);
    // Of another design, and not this one's to write over.
    fs::write(folder.path().join("probe.body.ron"), "mine").unwrap();
    shift(&mut world, BodyRole::Tool);
    assert_eq!(shared_bodies(&world), []);
    let report = save(&mut world).unwrap();
    assert_eq!(names(&report), ["probe-2.body.ron", "a.design.ron"]);
    assert_eq!(fs::read(folder.path().join("probe.body.ron")).unwrap(), b"mine");
    assert_eq!(fs::read(folder.path().join(PROBE)).unwrap(), probe());
    assert!(!world.document.is_dirty());
    assert_eq!(changes(&world), []);
    assert_eq!(names(&save(&mut world).unwrap()), [""; 0]);
    let again = open_design(&file).unwrap();
    assert_eq!(again.document.design(), world.document.design());
    // Undo leads to the body as it was, in the new file: it has all that the maker's file held.
    assert!(world.document.undo().is_some());
    assert_eq!(names(&save(&mut world).unwrap()), ["probe-2.body.ron"]);
    let body = read_tool(&folder.path().join("probe-2.body.ron"), OnMismatch::Refuse).unwrap();
    assert_eq!(body.kind, None);
    let conversion = from_body(&body.body, DefinitionFormat::Rom).unwrap();
    assert_eq!(*conversion.definition.write(), probe());
}

#[test]
fn a_makers_tools_mesh_is_reached_after_a_move() {
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
fn one_file_in_two_roles_becomes_two_bodies() {
    let (folder, _, mut world) = world("pointer-on-head");
    shift(&mut world, BodyRole::Tool);
    let report = save_with_copies(&mut world).unwrap();
    assert_eq!(names(&report), ["probe.body.ron", "a.design.ron"]);
    assert_eq!(reference(&world, BodyRole::Tool), "probe.body.ron");
    assert_eq!(reference(&world, BodyRole::Crf), PROBE);
    shift(&mut world, BodyRole::Crf);
    shift(&mut world, BodyRole::Crf);
    let report = save(&mut world).unwrap();
    assert_eq!(names(&report), ["probe-2.body.ron", "a.design.ron"]);
    assert_eq!(fs::read(folder.path().join(PROBE)).unwrap(), probe());
}

#[test]
fn save_as_leaves_an_unchanged_makers_file() {
    let (folder, _, mut world) = world("endoscope");
    let deep = folder.path().join("deep");
    fs::create_dir(&deep).unwrap();
    let report = save_as(&mut world, &deep.join("b.design.ron")).unwrap();
    assert_eq!(names(&report), ["b.design.ron"]);
    assert_eq!(reference(&world, BodyRole::Tool), "../roms/probe.rom");
    shift(&mut world, BodyRole::Tool);
    let report = save_as(&mut world, &folder.path().join("roms/c.design.ron")).unwrap();
    assert_eq!(names(&report), ["probe.body.ron", "c.design.ron"]);
    assert_eq!(reference(&world, BodyRole::Tool), "probe.body.ron");
    assert_eq!(fs::read(folder.path().join(PROBE)).unwrap(), probe());
}

#[test]
fn a_recovered_makers_tool_is_saved_beside() {
    let (folder, file, mut world) = world("endoscope");
    shift(&mut world, BodyRole::Tool);
    let state = folder.path().join("state");
    let leftover = crashed(&state, &world);
    // Somebody else's file by now, and gone later: neither is a reason to write over it.
    let mut other = probe();
    other.push(0);
    fs::write(folder.path().join(PROBE), &other).unwrap();
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
    // The first session goes on after all, and was notified of what the second one wrote.
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
