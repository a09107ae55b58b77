//! The scene of a design, as readers of others see it.

use crate::support::golden::{list, number, point};
use crate::support::peers::{node, python};
use crate::support::program::{Scratch, json_of};
use nalgebra::{Point3, Vector3};
use serde_json::Value;
use trackwright_design::BodyRole;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::color::{linear, linear_from_srgb};
use trackwright_scene::palette::{Ground, SENSOR, of_part};

/// Writes the scene of a built-in design.
fn export(scratch: &Scratch, design: &str, more: &str) -> String {
    let file = scratch.arg(&format!("{design}{}.glb", more.replace(' ', "")));
    scratch.succeed_with(format!("export scene {design} -o {file} {more}"), &["errors × "]);
    file
}

/// Surfaces as trimesh reads them.
fn read(file: &str) -> Vec<Value> {
    let found = json_of(python("read_glb.py").arg(file));
    found.as_array().unwrap().clone()
}

/// From the tracker's mm to glTF's metres: up is -z, the front is y.
fn gltf(at: Point3<f64>) -> Point3<f64> {
    Point3::new(at.x, -at.z, at.y) / 1000.0
}

#[test]
fn the_validator_accepts_every_built_in_design() {
    let scratch = Scratch::new();
    for design in trackwright_project::builtin_names() {
        // Placements and regions take seconds each: one design has them for all. Another has metal to solve for.
        let layers = match design {
            "endoscope" => "all",
            _ => "anatomy,arrows,ghost,slice,support,tip-scatter,volume",
        };
        let layers = format!("--layers {layers}");
        let all = ["", &layers, "--layers none --light"];
        let scenes = if design == "operating-theatre" { &all[1..2] } else { &all[..] };
        for more in scenes {
            let file = export(&scratch, design, more);
            let report = json_of(node("validate_glb.js").arg(&file));
            let issues = &report["issues"];
            assert_eq!(issues["numErrors"], 0, "{design} {more:?}: {issues}");
            assert_eq!(issues["numWarnings"], 0, "{design} {more:?}: {issues}");
            assert_eq!(report["info"]["version"], "2.0");
            // With a viewer beside it, it has to be light enough to mail.
            let bytes = std::fs::metadata(&file).unwrap().len();
            assert!(bytes < 6_000_000, "{design} {more:?}: {bytes}");
        }
    }
}

#[test]
fn trimesh_finds_bodies_where_the_design_has_them() {
    let scratch = Scratch::new();
    let found = read(&export(&scratch, "pointer-on-head", ""));
    let world = trackwright_project::open_builtin("pointer-on-head").unwrap();
    let design = world.document.design();
    for role in BodyRole::ALL {
        let pose = design.tracker_from_body(role).unwrap();
        for part in &world.mesh(role).unwrap().parts {
            let named = |surface: &&Value| surface["name"] == *part.name;
            let surface = found.iter().find(named).unwrap();
            let corners = part.positions_mm.iter().map(|p| gltf(pose * p));
            let expected = Bounds::around(corners).unwrap();
            for (key, expected) in [("min", expected.min_mm), ("max", expected.max_mm)] {
                // Metres: 1e-6 is a thousandth of a millimetre.
                let off: Vector3<f64> = point(&surface[key]) - expected;
                assert!(off.amax() < 1e-6, "{}: {off}", part.name);
            }
            assert_eq!(surface["triangles"], part.triangles.len());
            if !part.is_anatomy() {
                let [r, g, b, _] = part.base_color.map(f64::from);
                let color = of_part(role, [r, g, b], Ground::Dark).map(linear_from_srgb);
                is_color(&surface["base_color"], color, &part.name);
            }
        }
    }
    let coils: Vec<_> = (found.iter())
        .filter(|surface| surface["name"].as_str().unwrap().starts_with("coil"))
        .collect();
    let sensors = design.bodies().map(|(_, body)| body.rigid.sensors.len());
    assert_eq!(coils.len(), sensors.sum::<usize>());
    for coil in coils {
        is_color(&coil["base_color"], linear(SENSOR.on(Ground::Dark)), "coil");
    }
}

/// A reader may round a factor to eight bits.
fn is_color(found: &Value, expected: [f64; 3], name: &str) {
    for (k, expected) in expected.into_iter().enumerate() {
        let found = number(&found[k]);
        assert!((found - expected).abs() <= 1.0 / 255.0, "{name}: {found} for {expected}");
    }
}

#[test]
fn trimesh_reads_the_colors_of_the_slice() {
    let scratch = Scratch::new();
    let found = read(&export(&scratch, "shaver-on-head", "--layers slice"));
    let world = trackwright_project::open_builtin("shaver-on-head").unwrap();
    let view = &world.document.view().slice;
    let slice = found.iter().find(|s| s["name"] == "slice, position error");
    let slice = slice.unwrap();
    let (corners, colors) = (list(slice, "corners"), list(slice, "colors"));
    // The map spans the range that the file states.
    let model = &world.environment.model;
    let axis = nalgebra::Unit::new_normalize(Vector3::from(view.sensor_axis));
    let errors: Vec<f64> = (corners.iter())
        .map(|at| {
            let at = point(at) * 1000.0;
            let in_tracker = Point3::new(at.x, at.z, -at.y);
            let policy = trackwright_field::OutsidePolicy::Clamp;
            model.evaluate(&in_tracker, &axis, policy).error.position_mm.norm()
        })
        .collect();
    assert!(errors.len() > 100);
    // Wherever the error is larger, viridis is not darker: its light rises throughout.
    let light = |color: &Value| {
        let [r, g, b] = [0, 1, 2].map(|k| number(&color[k]));
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let mut order: Vec<usize> = (0..errors.len()).collect();
    order.sort_by(|a, b| errors[*a].total_cmp(&errors[*b]));
    for pair in order.windows(2) {
        let [low, high] = [pair[0], pair[1]].map(|k| light(&colors[k]));
        assert!(high > low - 0.01, "{low} then {high}");
    }
    let (first, last) = (order[0], order[order.len() - 1]);
    assert!(light(&colors[last]) > light(&colors[first]) + 0.2);
}

#[test]
fn a_scene_that_cannot_be_is_refused_in_one_line() {
    let scratch = Scratch::new();
    for (args, words) in [
        ("endoscope -o scene.gltf", "expected a name that ends with .glb"),
        ("endoscope -o scene.glb --layers sliec", "no layer sliec"),
        (
            "endoscope -o scene.glb --sensor crf/left",
            "no sensor is named crf/left, expected one of tool/",
        ),
        ("not-there.design.ron -o scene.glb", "not-there.design.ron"),
    ] {
        scratch.refused(format!("export scene {args}"), &[words]);
    }
    assert!(!scratch.has("scene.glb"));
}
