//! The metal of a room through the command line.

use crate::support::golden::{list, number, numbers};
use crate::support::metal_table::{AT_MM, RADIUS_MM, metal_table, table_beside};
use crate::support::program::{Scratch, assert_has};
use nalgebra::{Point3, Vector3};
use trackwright_field::OutsidePolicy;

#[test]
fn a_sphere_of_aluminium_is_found() {
    let scratch = Scratch::new();
    scratch.write("room.csv", metal_table(150, true));
    let find = "metal find room.csv --generator planar-nine --folds 3 --most 2";
    let found = scratch.json(find);
    assert_eq!(found["verdict"], "found", "{found}");
    let [body] = list(&found, "bodies") else { panic!("{found}") };
    assert_eq!((&body["kind"], &body["is_determined"]), (&"conductor".into(), &true.into()));
    let center_mm = numbers::<3>(&body["center_mm"]);
    for k in 0..3 {
        let [low, high] = numbers(&body["center_within95_mm"][k]);
        assert!(low < center_mm[k] && center_mm[k] < high, "{body}");
        assert!((center_mm[k] - AT_MM[k]).abs() < 5.0 && high - low < 20.0, "{body}");
    }
    // The skin of 0.8 mm makes it a little smaller.
    let radius_mm = number(&body["radius_mm"]);
    assert!((0.95 * RADIUS_MM..1.02 * RADIUS_MM).contains(&radius_mm), "{body}");
    let held_out = list(&found, "held_out");
    let names: Vec<&str> = held_out.iter().map(|model| model["model"].as_str().unwrap()).collect();
    assert_eq!(names, ["none", "bodies", "harmonic", "bernstein"]);
    let rms: Vec<f64> = held_out.iter().map(|model| number(&model["position_rms_mm"])).collect();
    // For the others 100 rows are too few.
    assert!([0, 2, 3].iter().all(|&other| rms[1] < 0.5 * rms[other]), "{found}");
    let text = scratch.succeed(format!("{find} --no-comparison -o found.env.ron"));
    // The room of what was found has the errors that were measured.
    let room = scratch.environment("found.env.ron");
    let at = Point3::new(120.0, 40.0, -210.0);
    let axis = Vector3::z_axis();
    let read = room.model.evaluate(&at, &axis, OutsidePolicy::Clamp);
    assert!(read.is_inside && read.error.position_mm.norm() > 1.0, "{read:?}");
    let words = ["found 1 body", "1  conductor, like a sphere of", "mm (95 %)", "a component"];
    assert_has(&text, &words, "the text");
    assert!(!text.contains("held out"), "{text}");
}

#[test]
fn what_is_not_determined_has_no_numbers() {
    let scratch = Scratch::new();
    scratch.write("far.csv", table_beside(150, Some([470.0, 40.0, -210.0])));
    let find = "metal find far.csv --generator planar-nine --folds 3 --most 1 --no-comparison";
    let found = scratch.json(find);
    assert_ne!(found["verdict"], "found", "{found}");
    for body in list(&found, "bodies") {
        let numbers = ["center_mm", "center_within95_mm", "half_length_mm", "radius_within95_mm"];
        assert!(numbers.iter().all(|key| body[*key].is_null()), "{body}");
        assert!(body["doubt"].is_string(), "{body}");
    }
    let text = scratch.succeed(find);
    assert!(!text.contains('±'), "{text}");
}

#[test]
fn an_empty_room_has_no_metal() {
    let scratch = Scratch::new();
    scratch.write("empty.csv", metal_table(60, false));
    let find = "metal find empty.csv --generator planar-nine --no-comparison";
    scratch.succeed_with(find, &["nothing found"]);
    scratch.notes_with(format!("{find} -o a.env.ron"), &["no body is determined"]);
    assert!(!scratch.has("a.env.ron"));
    let found = scratch.json(find);
    assert_eq!(found["verdict"], "nothing_found");
    assert!(list(&found, "bodies").is_empty(), "{found}");
}

#[test]
fn tables_and_generators_that_serve_no_search() {
    let scratch = Scratch::new();
    scratch.write("few.csv", metal_table(19, true));
    scratch.fail_with("metal find few.csv", &["found no --generator, expected planar-nine"]);
    scratch.fail_with("metal find few.csv --generator learn", &["found \"learn\""]);
    scratch.fail_with("metal find few.csv --generator none.generator.ron", &["none.generator.ron"]);
    let find = "metal find few.csv --generator planar-nine";
    scratch.fail_with(find, &["few.csv: 19 measurements, expected at least 20"]);
    let more = format!("{find} --most 4");
    scratch.fail_with(more, &["few.csv: 4 bodies requested, expected 1 to 3"]);
    let text = scratch.read("few.csv");
    let positions = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        [0, 1, 2, 7, 8, 9].map(|k| cells[k]).join(",")
    };
    let rows: Vec<String> = text.lines().map(positions).collect();
    scratch.write("positions.csv", rows.join("\n"));
    let find = "metal find positions.csv --generator planar-nine --as-is";
    scratch.fail_with(find, &["the measurements have no orientations"]);
}
