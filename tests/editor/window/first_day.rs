//! The first design of somebody new: a needle from an STL file, its coils along the shaft, saved
//! beside the mesh. No coordinate is typed.

use super::harness::{Turn, Window, simulated};
use crate::copied::Copied;
use std::fmt::Write;

/// A pointed rod along z, its tip at the origin.
fn needle_stl() -> String {
    const SIDES: usize = 24;
    const RADIUS_MM: f64 = 1.0;
    let ring = |z: f64| -> Vec<[f64; 3]> {
        let turn = |k: usize| std::f64::consts::TAU * k as f64 / SIDES as f64;
        let at = |k| [RADIUS_MM * f64::cos(turn(k)), RADIUS_MM * f64::sin(turn(k)), z];
        (0..SIDES).map(at).collect()
    };
    let (front, back) = (ring(6.0), ring(150.0));
    let mut text = "solid needle\n".to_owned();
    let mut facet = |corners: [[f64; 3]; 3]| {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in corners {
            writeln!(text, "vertex {x} {y} {z}").unwrap();
        }
        text += "endloop\nendfacet\n";
    };
    for k in 0..SIDES {
        let next = (k + 1) % SIDES;
        facet([[0.0; 3], front[next], front[k]]);
        facet([front[k], front[next], back[next]]);
        facet([front[k], back[next], back[k]]);
        facet([[0.0, 0.0, 150.0], back[k], back[next]]);
    }
    text + "endsolid needle\n"
}

#[test]
fn a_needle_from_an_stl_is_designed_and_saved() {
    let copy = Copied::new("pointer-on-head");
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("needle.stl");
    std::fs::write(&mesh, needle_stl()).unwrap();
    let state = tempfile::tempdir().unwrap();
    let turn = Turn::wait();
    let mut window = Window::open_with_controls(&turn, &copy.design, state.path());

    window.key("ctrl+n");
    window.click_control("Tool and CRF");
    let plain = window.figures();
    window.run_command("Load mesh");
    window.write(&mesh.display().to_string());
    window.key("Return");
    window.wait_for("the mesh", |lines| {
        lines.iter().any(|line| line.contains("undo=Change tool's mesh"))
    });
    window.settle();
    assert_eq!(window.figures(), plain, "a mesh changes no figure");

    // A coil across a needle of 2 mm sticks out of it.
    window.click_control("back");
    window.run_command("Axis along the shaft");
    assert_eq!(window.document("undo"), "Align sensor back");
    assert_ne!(window.figures(), plain);

    window.key("ctrl+s");
    let design = folder.path().join("needle.design.ron");
    window.write(&design.display().to_string());
    window.key("Return");
    assert_eq!(window.document("dirty"), "false");
    assert_eq!(window.figures(), simulated(&design));
    let body = std::fs::read_to_string(folder.path().join("tool.body.ron")).unwrap();
    assert!(body.contains("mesh: \"needle.stl\""), "beside the mesh: {body}");
    let saved = trackwright_project::open_design(&design).unwrap();
    let axes = saved.document.design().tool.body.rigid.sensors.iter().map(|sensor| {
        use trackwright_simulation::SensorOrientation::FiveDof;
        let FiveDof(axis) = sensor.orientation else { panic!("{sensor:?}") };
        axis.z
    });
    assert_eq!(axes.collect::<Vec<_>>(), [1.0, 1.0]);
    window.close();
}
