//! A tool from nothing but its mesh.

use super::*;
use crate::{ImportedMesh, MeshImport, MeshOwner, coil_findings, flipped_tool, new_tool_of_mesh};
use nalgebra::Vector3;
use trackwright_metal::shapes::cylinder;
use trackwright_simulation::{CancelToken, Mode, Pivot, run};

/// Cylinders along x as an OBJ file: radius, from where, how long.
fn rods(file: &Path, rods: &[(f64, f64, f64)]) {
    let mut text = String::new();
    let mut count = 0;
    for &(radius_mm, from_mm, length_mm) in rods {
        let mesh = cylinder(radius_mm, length_mm, 200).unwrap();
        for part in &mesh.parts {
            for p in &part.positions_mm {
                text += &format!("v {} {} {}\n", from_mm + length_mm / 2.0 + p.z, p.x, p.y);
            }
            for corners in &part.triangles {
                let [a, b, c] = corners.map(|corner| corner as usize + 1 + count);
                text += &format!("f {a} {b} {c}\n");
            }
            count += part.positions_mm.len();
        }
    }
    fs::write(file, text).unwrap();
}

fn read(file: &Path) -> ImportedMesh {
    let world = open_builtin("endoscope").unwrap();
    MeshImport::of_file(&world, MeshOwner::NewTool, file, None).unwrap().unwrap().read().unwrap()
}

fn new_design(mesh: &ImportedMesh, name: &str) -> World {
    let mut world = open_builtin("new-tool").unwrap();
    apply(&mut world, new_tool_of_mesh(mesh, name).unwrap());
    world
}

fn apply(world: &mut World, edits: Vec<Edit>) {
    for edit in edits {
        world.document.apply(edit).unwrap();
    }
    refresh_meshes(world).unwrap();
}

/// Tip, and direction from the proximal sensor to the distal one, tracker frame.
fn tip_and_shaft(world: &World) -> (Point3<f64>, Vector3<f64>) {
    let design = world.document.design();
    let tracker_from_tool = design.tracker_from_body(BodyRole::Tool).unwrap();
    let tool = &design.tool.body.rigid;
    let [distal, proximal] =
        [0, 1].map(|index| tracker_from_tool * tool.sensors[index].position_in_body);
    (tracker_from_tool * tool.judged_tip_in_body(), (distal - proximal).normalize())
}

#[test]
fn a_mesh_alone_becomes_a_tool_that_is_simulated() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("needle.obj");
    // A shaft whose far end is thin, and a hub; its own origin is somewhere behind.
    rods(&file, &[(8.0, 100.0, 40.0), (1.0, 140.0, 160.0)]);
    let world = new_design(&read(&file), "needle");
    let design = world.document.design();
    let tool = &design.tool.body.rigid;
    assert_eq!((design.name.as_str(), tool.name.as_str()), ("needle", "needle"));
    let tip = tool.tip_in_body.unwrap();
    assert!((tip - Point3::new(300.0, 0.0, 0.0)).norm() < 1e-6, "{tip}");
    assert_eq!(
        tool.sensors.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(),
        ["distal", "proximal"]
    );
    for (sensor, x_mm) in tool.sensors.iter().zip([260.0, 200.0]) {
        let off = sensor.position_in_body - Point3::new(x_mm, 0.0, 0.0);
        assert!(off.norm() < 1e-6, "{off}");
    }
    // Where the plain tool is, in the same place and direction.
    let plain = open_builtin("new-tool").unwrap();
    let ((tip, shaft), (plain_tip, plain_shaft)) = (tip_and_shaft(&world), tip_and_shaft(&plain));
    assert!((tip - plain_tip).norm() < 1e-9 && (shaft - plain_shaft).norm() < 1e-9);
    assert_eq!(design.motion.unwrap().pivot, Pivot::Tip);
    // Both coils are in the shaft, which is too thin for one across it.
    assert!(coil_findings(&world).is_empty(), "{:?}", coil_findings(&world));
    let scenario = resolve(design, &world.environment);
    let outcome = run(&scenario, &Mode::Motion, &CancelToken::default(), None).unwrap();
    assert_eq!((outcome.room_field.outside, outcome.room_field.out_of_volume), (0, 0));

    let mut world = world;
    let saved = folder.path().join("needle.design.ron");
    let written = names(&save_as(&mut world, &saved).unwrap());
    assert_eq!(written, ["needle.body.ron", "operating-table.env.ron", "needle.design.ron"]);
    let again = open_design(&saved).unwrap();
    assert_eq!(again.document.design().tool.body.mesh.as_ref().unwrap().file, "needle.obj");
    assert!(again.mesh(BodyRole::Tool).is_some());
}

#[test]
fn a_thick_shaft_has_a_coil_across_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("probe.obj");
    rods(&file, &[(6.0, -50.0, 200.0), (20.0, 150.0, 60.0)]);
    let world = new_design(&read(&file), "probe");
    let scenario = resolve(world.document.design(), &world.environment);
    let outcome = run(&scenario, &Mode::Single, &CancelToken::default(), None).unwrap();
    assert!(outcome.room_field.free_axis.is_none());
    assert!(coil_findings(&world).is_empty(), "{:?}", coil_findings(&world));
}

#[test]
fn a_flipped_tool_stays_and_its_mesh_turns() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("needle.obj");
    rods(&file, &[(8.0, 100.0, 40.0), (1.0, 140.0, 160.0)]);
    let mut world = new_design(&read(&file), "needle");
    let (tip, shaft) = tip_and_shaft(&world);
    let edits = flipped_tool(&world).unwrap();
    apply(&mut world, edits);
    let (flipped_tip, flipped_shaft) = tip_and_shaft(&world);
    assert!((flipped_tip - tip).norm() < 1e-9 && (flipped_shaft - shaft).norm() < 1e-9);
    let tip_in_body = world.document.design().tool.body.rigid.tip_in_body.unwrap();
    assert!((tip_in_body - Point3::new(100.0, 0.0, 0.0)).norm() < 1e-6, "{tip_in_body}");
    let plain = open_builtin("new-tool").unwrap();
    assert_eq!(flipped_tool(&plain), None, "there is no mesh");
}
