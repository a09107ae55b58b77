//! What is wrong with a mesh or a size is reported on the command line as it is in the window.

use crate::support::program::Scratch;
use std::fmt::Write;

/// A design whose tool has the mesh and, where it is not 1, sensors so many times as far out.
fn design(scratch: &Scratch, stl: &str, scale: f64) -> String {
    scratch.copy_design_with_room("golden/pointer-on-head", "--order 1 --directions 6");
    scratch.write("d/tool.stl", stl);
    let text = scratch.read("d/tool.body.ron");
    let text = text.replace("name: \"Tool\",", "name: \"Tool\",\n    mesh: \"tool.stl\",");
    let far = format!("position: (-6.0, 5.0, {:?})", 120.0 * scale);
    let moved = text.replace("position: (-6.0, 5.0, 120.0)", &far);
    assert!(scale == 1.0 || moved != text);
    scratch.write("d/tool.body.ron", moved);
    scratch.arg("d/pointer-on-head.design.ron")
}

/// The first sides of a tetrahedron of a size, facing outward.
fn tetrahedron(size_mm: f64, sides: usize) -> String {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut text = "solid tool\n".to_owned();
    for side in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].iter().take(sides) {
        text += "facet normal 0 0 0\nouter loop\n";
        for corner in side.map(|k: usize| corners[k].map(|v| v * size_mm)) {
            writeln!(text, "vertex {} {} {}", corner[0], corner[1], corner[2]).unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid tool\n"
}

#[test]
fn mesh_problems_are_reported_where_drawn() {
    for (stl, problem) in [
        (tetrahedron(20_000.0, 4), "20000 mm long: is the file in"),
        (tetrahedron(100.0, 3), "Open: 3 edges have a triangle on one side only"),
    ] {
        let scratch = Scratch::new();
        let design = design(&scratch, &stl, 1.0);
        let words = [&*format!("warning: the tool's mesh: {problem}")];
        scratch.notes_with(format!("export scene {design} -o scene.glb --layers none"), &words);
        scratch.notes_with(format!("report {design} -o r.html --mode single"), &words);
    }
}

#[test]
fn a_tool_of_twenty_metres_is_reported() {
    let scratch = Scratch::new();
    let design = design(&scratch, &tetrahedron(100.0, 4), 200.0);
    let expected = "24000 mm long, expected at most 1500 mm: are its coordinates in µm?";
    for args in [
        format!("simulate {design} --mode single"),
        format!("export tips {design} -o tips.csv --mode single"),
        format!("tolerances {design}"),
        "convert d/tool.body.ron tool.ini".to_owned(),
    ] {
        scratch.notes_with(&args, &["warning: ", expected]);
    }
}
