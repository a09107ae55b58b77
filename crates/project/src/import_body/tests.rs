//! Bodies from elsewhere: what becomes of their files, and of the ones that were there.

use super::super::recovery::{Recovery, Snapshot, leftovers};
use super::super::tool::read_tool;
use super::super::{
    changes, open_builtin, open_design, refresh_meshes, save, save_as, shared_bodies,
};
use super::*;
use nalgebra::{Point3, Vector3};
use std::fs;
use tempfile::TempDir;
use trackwright_design::Edit;
use trackwright_formats::tool_definition::{DefinitionFormat, ToolDefinition, from_body};
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_simulation::body::{RigidBody, Sensor, SensorOrientation};

/// An image of two coils, after which a byte stands that is none of its own.
fn image() -> Vec<u8> {
    let coil = |name: &str, x, axis| Sensor {
        name: name.to_owned(),
        position_in_body: Point3::new(x, 0.0, 40.0),
        orientation: SensorOrientation::FiveDof(axis),
        coil: None,
    };
    let body = BodyFile {
        rigid: RigidBody {
            name: "8700339".to_owned(),
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
    [&conversion.definition.write()[..], &[7]].concat()
}

/// A design in a folder, and in another folder a maker's file of the name that the tool's has.
fn saved() -> (TempDir, World, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let mut world = open_builtin("pointer-on-head").unwrap();
    save_as(&mut world, &folder.path().join("a.design.ron")).unwrap();
    fs::create_dir(folder.path().join("roms")).unwrap();
    let rom = folder.path().join("roms/pointer.rom");
    fs::write(&rom, image()).unwrap();
    (folder, world, rom)
}

fn take(world: &mut World, role: BodyRole, file: &Path) -> bool {
    let wanted = BodyImport::of_file(world, role, file, OnMismatch::Refuse);
    let taken = wanted.unwrap().unwrap().read().unwrap();
    world.keep_body(&taken);
    let is_changed =
        world.document.apply(Edit::SetBody { body: role, content: Box::new(taken.body) });
    refresh_meshes(world).unwrap();
    is_changed.unwrap()
}

fn tool(world: &World) -> &DesignBody {
    &world.document.design().tool.body
}

fn written(world: &mut World) -> Vec<String> {
    save(world).unwrap().written.iter().map(|f| file_name(f)).collect()
}

#[test]
fn a_makers_file_is_saved_beside_the_design_and_undo_leads_to_the_files_that_were_there() {
    let (folder, _, rom) = saved();
    let at = |name: &str| folder.path().join(name);
    // As a person would write it: Save has no reason to put it in order.
    let by_hand = format!("// by hand\n{}", fs::read_to_string(at("pointer.body.ron")).unwrap());
    fs::write(at("pointer.body.ron"), &by_hand).unwrap();
    let mut world = open_design(&at("a.design.ron")).unwrap();
    let before = world.document.shared_design();
    assert!(take(&mut world, BodyRole::Tool, &rom));
    assert_eq!(tool(&world).reference, "pointer-2.body.ron");
    assert!(world.mesh(BodyRole::Tool).is_none() && world.mesh_problems().is_empty());
    assert_eq!(shared_bodies(&world), []);
    assert_eq!(written(&mut world), ["pointer-2.body.ron", "a.design.ron"]);
    assert_eq!(fs::read(&rom).unwrap(), image());
    let body = read_tool(&at("pointer-2.body.ron"), OnMismatch::Refuse).unwrap();
    let again = from_body(&body.body, DefinitionFormat::Rom).unwrap();
    assert_eq!(*again.definition.write(), image());
    let opened = open_design(&at("a.design.ron")).unwrap();
    assert_eq!(opened.document.design(), world.document.design());
    // It is there already.
    assert!(!take(&mut world, BodyRole::Tool, &rom));
    assert!(world.document.undo().is_some());
    assert_eq!(world.document.design(), &*before);
    assert_eq!(written(&mut world), ["a.design.ron"]);
    assert_eq!(fs::read_to_string(at("pointer.body.ron")).unwrap(), by_hand);
    world.document.redo();
    assert_eq!(written(&mut world), ["a.design.ron"]);
    assert_eq!(changes(&world), []);
}

#[test]
fn a_file_that_took_the_name_meanwhile_is_not_written_over() {
    let (folder, mut world, rom) = saved();
    take(&mut world, BodyRole::Tool, &rom);
    let theirs = folder.path().join("pointer-2.body.ron");
    fs::write(&theirs, "theirs").unwrap();
    assert_eq!(written(&mut world), ["pointer-2-2.body.ron", "a.design.ron"]);
    assert_eq!(fs::read_to_string(theirs).unwrap(), "theirs");
    // The state before refers to what it did.
    world.document.undo();
    assert_eq!(tool(&world).reference, "pointer.body.ron");
    assert_eq!(written(&mut world), ["a.design.ron"]);
}

#[test]
fn a_body_file_of_the_designs_folder_is_used_where_it_is_and_one_of_another_folder_is_copied() {
    let (folder, mut world, _) = saved();
    let at = |name: &str| folder.path().join(name);
    let mesh = at("roms/other.obj");
    fs::write(&mesh, "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        .unwrap();
    let text = "(version: 1, name: \"other\", mesh: \"other.obj\", sensors: [(name: \"a\", kind: Marker, position: (1, 2, 3))])";
    fs::write(at("roms/other.body.ron"), text).unwrap();
    take(&mut world, BodyRole::Tool, &at("roms/other.body.ron"));
    assert_eq!(tool(&world).reference, "other.body.ron");
    assert_eq!(tool(&world).mesh, Some(MeshReference::new("roms/other.obj")));
    assert!(world.mesh(BodyRole::Tool).is_some());
    assert_eq!(written(&mut world), ["other.body.ron", "a.design.ron"]);
    assert_eq!(fs::read_to_string(at("roms/other.body.ron")).unwrap(), text);

    fs::write(at("near.body.ron"), text).unwrap();
    take(&mut world, BodyRole::Tool, &at("near.body.ron"));
    assert_eq!(tool(&world).reference, "near.body.ron");
    assert_eq!(written(&mut world), ["a.design.ron"]);
    assert_eq!(fs::read_to_string(at("near.body.ron")).unwrap(), text);
    // As both bodies it is two files, which may come to differ.
    take(&mut world, BodyRole::Crf, &at("near.body.ron"));
    assert_eq!(written(&mut world), ["near-2.body.ron", "a.design.ron"]);
}

#[test]
fn a_crash_keeps_a_body_that_was_taken_in() {
    let (folder, mut world, rom) = saved();
    take(&mut world, BodyRole::Tool, &rom);
    let state = folder.path().join("state");
    let mut recovery = Recovery::start(&state).unwrap();
    assert!(recovery.write(&Snapshot::of(&world)).unwrap());
    drop(recovery);
    fs::remove_file(&rom).unwrap();
    let leftover = leftovers(&state).unwrap().remove(0);
    let mut recovered = leftover.open().unwrap();
    assert_eq!(recovered.document.design(), world.document.design());
    assert_eq!(written(&mut recovered), ["pointer-2.body.ron", "a.design.ron"]);
}

#[test]
fn saved_elsewhere_every_state_leads_to_its_own_file() {
    let (folder, mut world, rom) = saved();
    take(&mut world, BodyRole::Tool, &rom);
    world.document.undo();
    fs::create_dir(folder.path().join("deep")).unwrap();
    save_as(&mut world, &folder.path().join("deep/b.design.ron")).unwrap();
    assert_eq!(tool(&world).reference, "../pointer.body.ron");
    world.document.redo();
    // Nothing has held it yet, and now it is saved beside this design.
    assert_eq!(tool(&world).reference, "pointer-2.body.ron");
    assert_eq!(written(&mut world), ["pointer-2.body.ron", "b.design.ron"]);
    assert!(folder.path().join("deep/pointer-2.body.ron").exists());
    assert!(!folder.path().join("pointer-2.body.ron").exists());
    world.document.undo();
    assert_eq!(written(&mut world), ["b.design.ron"]);

    // A design of the program's own has no files to lead to.
    let mut world = open_builtin("endoscope").unwrap();
    take(&mut world, BodyRole::Tool, &rom);
    assert_eq!(tool(&world).reference, "pointer.body.ron");
    let built_in = folder.path().join("built-in");
    fs::create_dir(&built_in).unwrap();
    save_as(&mut world, &built_in.join("c.design.ron")).unwrap();
    let opened = open_design(&built_in.join("c.design.ron")).unwrap();
    assert_eq!(opened.document.design(), world.document.design());
    assert!(opened.document.design().tool.body.definition.is_some());
}

#[test]
fn a_sum_that_does_not_match_is_refused_until_it_is_wanted_and_then_kept() {
    let (_folder, world, rom) = saved();
    let mut bytes = image();
    bytes[60] ^= 1;
    fs::write(&rom, &bytes).unwrap();
    let wanted = |on_mismatch| {
        let wanted = BodyImport::of_file(&world, BodyRole::Tool, &rom, on_mismatch);
        wanted.unwrap().unwrap().read()
    };
    assert!(wanted(OnMismatch::Refuse).unwrap_err().is_checksum());
    let taken = wanted(OnMismatch::Accept).unwrap();
    let definition = taken.body.definition.unwrap();
    assert_eq!(definition.bytes, bytes);
    assert!(
        ToolDefinition::carried(Some(&definition))
            .unwrap()
            .doubt()
            .unwrap()
            .contains("checksum is ")
    );
    fs::write(&rom, &bytes[..100]).unwrap();
    let error = wanted(OnMismatch::Accept).unwrap_err();
    assert!(!error.is_checksum() && error.to_string().contains("pointer.rom: length is 100 bytes"));
}
