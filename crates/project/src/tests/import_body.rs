//! Bodies from elsewhere: what becomes of their files, and of the ones that were there.

use super::*;
use crate::paths::file_name;
use crate::tool::read_tool;
use trackwright_design::{CrfPlacement, DesignBody};
use trackwright_formats::tool_definition::{OnMismatch, ToolDefinition};
use trackwright_geometry::mesh_reference::MeshReference;

/// An image of two coils, after which a byte follows that is none of its own.
fn image() -> Vec<u8> {
    [&rom("8700339")[..], &[7]].concat()
}

/// A design in a folder, and in another folder a maker's file of the name that the tool's has.
fn saved() -> (TempDir, World, PathBuf) {
    let (folder, world) = saved_world();
    fs::create_dir(folder.path().join("roms")).unwrap();
    let rom = folder.path().join("roms/pointer.rom");
    fs::write(&rom, image()).unwrap();
    (folder, world, rom)
}

fn take(world: &mut World, role: BodyRole, file: &Path) -> bool {
    let wanted = BodyImport::of_file(world, role, file, OnMismatch::Refuse);
    let taken = wanted.unwrap().read().unwrap();
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
fn an_imported_file_is_saved_beside_the_design() {
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
fn a_design_gains_a_crf_from_a_file() {
    let (folder, _) = saved_design("endoscope");
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("makers")).unwrap();
    fs::write(at("makers/head.obj"), tetrahedron(9.0)).unwrap();
    let text = "(version: 1, name: \"head\", mesh: \"head.obj\", sensors: [(name: \"a\", kind: Marker, position: (1, 2, 3))])";
    fs::write(at("makers/head.body.ron"), text).unwrap();
    let mut world = open_design(&at("a.design.ron")).unwrap();
    let wanted =
        BodyImport::of_file(&world, BodyRole::Crf, &at("makers/head.body.ron"), OnMismatch::Refuse);
    let taken = wanted.unwrap().read().unwrap();
    world.keep_body(&taken);
    let crf = CrfPlacement {
        body: taken.body,
        tracker_from_crf: world.document.design().pose_of_new_crf(),
        targets: Vec::new(),
        motion: None,
        requirement: None,
    };
    world.document.apply(Edit::AddCrf(Box::new(crf))).unwrap();
    refresh_meshes(&mut world).unwrap();
    assert!(world.mesh(BodyRole::Crf).is_some());
    assert_eq!(written(&mut world), ["head.body.ron", "a.design.ron"]);
    let opened = open_design(&at("a.design.ron")).unwrap();
    assert_eq!(opened.document.design(), world.document.design());
    assert!(opened.mesh(BodyRole::Crf).is_some());
    // Undone while the design is saved elsewhere, it leads to its own file when it is done again.
    world.document.undo();
    assert!(refresh_meshes(&mut world).unwrap());
    fs::create_dir(at("deep")).unwrap();
    save_as(&mut world, &at("deep/b.design.ron")).unwrap();
    world.document.redo();
    assert!(refresh_meshes(&mut world).unwrap());
    let crf = world.document.design().body(BodyRole::Crf).unwrap();
    assert_eq!(crf.reference, "../head.body.ron");
    assert!(world.mesh(BodyRole::Crf).is_some(), "{:?}", world.mesh_problems());
}

#[test]
fn a_file_that_took_the_name_is_not_replaced() {
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
fn body_files_of_other_folders_are_copied() {
    let (folder, mut world, _) = saved();
    let at = |name: &str| folder.path().join(name);
    let mesh = at("roms/other.obj");
    fs::write(&mesh, tetrahedron(9.0)).unwrap();
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
    let leftover = crashed(&state, &world);
    fs::remove_file(&rom).unwrap();
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
fn a_wrong_checksum_is_kept_on_request() {
    let (_folder, world, rom) = saved();
    let mut bytes = image();
    bytes[60] ^= 1;
    fs::write(&rom, &bytes).unwrap();
    let wanted = |on_mismatch| {
        let wanted = BodyImport::of_file(&world, BodyRole::Tool, &rom, on_mismatch);
        wanted.unwrap().read()
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
