//! Rooms with metal on the command line: what is simulated and how, how far an object must be, and rooms
//! that cannot be.

use crate::support::golden::{list, number};
use crate::support::program::Scratch;
use serde_json::Value;
use trackwright_field::generator::Generator;

/// A plate beside the volume, in a room of nothing else. The lines of the built-in coils are those that the
/// program writes.
fn room(generator: &Generator, objects: &str) -> String {
    let generator = trackwright_formats::generator::write(generator);
    let parts = generator.split_once("version: 1,").unwrap().1;
    format!(
        "(version: 1, name: \"plate\", volume: AuroraCube, metal: (generator: ({parts}, \
         frequency: 10000, objects: [{objects}]))"
    )
}

const PLATE: &str = "(name: \"plate\", shape: Cuboid(size: (200, 200, 10)), triangles: 400, \
                     material: Named(\"aluminium\"), \
                     pose: (position: (300, 0, -300), rotation: (0.7, 0, 0.7, 0))),";

/// The built-in design, in the room `room.env.ron` with these objects.
fn scratch_with(objects: &str) -> Scratch {
    let scratch = Scratch::new();
    scratch.copy_to_own_room("pointer-on-head");
    scratch.write("room.env.ron", room(&Generator::planar_nine(), objects));
    scratch
}

#[test]
fn explain_states_how_metal_is_evaluated() {
    let scratch = scratch_with(PLATE);
    let words = [
        "metal: plate: ",
        " triangles, its currents, at a skin depth of 0.82 mm",
        "by harmonic functions in ",
        "0.01 mm",
    ];
    let explain = "simulate a.design.ron --mode motion --explain";
    scratch.notes_with(explain, &words);
    let scratch = scratch_with(&PLATE.replace("(300,", "(1100,"));
    scratch.notes_with(explain, &["metal: all poses by harmonic functions of degree "]);
}

#[test]
fn other_commands_know_rooms_with_metal() {
    let scratch = scratch_with(PLATE);
    scratch.write("poses.csv", "x,y,z,qw,qx,qy,qz\n100,0,-300,1,0,0,0\n0,0,-300,1,0,0,0\n");
    scratch.succeed("distort room.env.ron poses.csv -o out.csv");
    let table = scratch.table("out.csv");
    let moved_mm = |row: usize, x: f64| (table.number(row, "x") - x).abs();
    assert!(moved_mm(0, 100.0) > 0.1 && moved_mm(0, 100.0) > moved_mm(1, 0.0));
    scratch.succeed("compensate room.env.ron out.csv -o back.csv");
    let back = scratch.table("back.csv");
    assert!((back.number(0, "x") - 100.0).abs() < 1e-3, "{}", back.number(0, "x"));
}

/// The pointer's three sensors, its tip at (0, 0, −250) mm, and a plate of steel 304 of 200 by 200 by 1 mm.
fn beside_plate(position: &str, rotation: &str) -> Scratch {
    let scratch = Scratch::new();
    let plate = format!(
        "(name: \"plate\", shape: Cuboid(size: (200, 200, 1)), material: Named(\"steel-304\"), \
         pose: (position: {position}, rotation: {rotation})),"
    );
    scratch.write("room.env.ron", room(&Generator::planar_nine(), &plate));
    let sensor = |name: &str, position: &str, axis: &str| {
        format!("(name: \"{name}\", kind: FiveDof, position: {position}, axis: {axis}),")
    };
    let sensors = [
        sensor("shaft", "(0, 0, 72)", "(0, 0, 1)"),
        sensor("grip", "(0, 0, 112)", "(0.8660254037844386, 0, 0.5)"),
        sensor("housing", "(0, 5, 148)", "(0, 0.5, 0.8660254037844386)"),
    ];
    let body =
        format!("(version: 1, name: \"Pointer\", tip: (0, 0, 0), sensors: [{}])", sensors.concat());
    scratch.write("pointer.body.ron", body);
    let design = "(version: 1, name: \"pointer\", environment: \"room.env.ron\", tool: (body: \
                  \"pointer.body.ron\", pose: (position: (0, 0, -250), rotation: (0, 0, 1, 0))), motion: (), \
                  orientation_weight: 100, requirement: (position_max: 1))";
    scratch.write("a.design.ron", design);
    scratch
}

/// Tip errors by a program of its own: currents of a thin sheet on a grid, with the inductances of bars of current
/// (Hoer and Love 1965), a reading by least squares of nine signals, and a fit of frames by singular values. It
/// converges to 0.01 %; its square that no flux enters has the known moment of 0.4548 L³.
#[test]
fn a_plate_errs_as_an_independent_sheet() {
    let error_mm = |position: &str, rotation: &str| {
        let found = beside_plate(position, rotation).json("simulate a.design.ron --mode single");
        list(&found, "error_mm").iter().map(|v| number(v).powi(2)).sum::<f64>().sqrt()
    };
    let upright = "(0.7071067811865476, 0, 0.7071067811865476, 0)";
    let beside = error_mm("(120, 0, -300)", upright);
    assert!((beside / 9.444 - 1.0).abs() < 0.005, "{beside}");
    let oblique = error_mm("(115, 70, -340)", "(0.8, 0.25, 0.45, 0.15)");
    assert!((oblique / 6.650 - 1.0).abs() < 0.005, "{oblique}");
    // 1 mm at 212.3 mm from its surface to the tip: safe 0.5 % farther away, and not 0.5 % nearer.
    let [nearer, farther] = [0.995, 1.005].map(|by| {
        let x_mm = 212.335 * by + 0.5;
        error_mm(&format!("({x_mm}, 0, -300)"), upright)
    });
    assert!(nearer > 1.0 && farther < 1.0, "{nearer} {farther}");
}

#[test]
fn the_distance_of_an_object_is_found() {
    let scratch = scratch_with(PLATE);
    let found = scratch.json("metal distance a.design.ron --direction 1,0,0 --chart out.svg");
    assert_eq!(found["object"], "plate");
    let from = &found["holds_from"];
    let places = list(&found, "places");
    let moved = |place: &Value| number(&place["moved_mm"]);
    assert!(places.is_sorted_by(|a, b| moved(a) < moved(b)));
    // From beside the tip outwards.
    assert!(moved(&places[0]) < -250.0, "{}", places[0]);
    for place in places {
        let holds = moved(place) >= number(&from["moved_mm"]);
        assert_eq!(place["verdict"] == "met", holds, "{place}");
        let high_mm = &place["figures"]["position_mm"]["rms"]["high"];
        assert!(!holds || number(high_mm) <= 1.0, "{place}");
    }
    let words = ["plate moved along (1.000, 0.000, 0.000)", "the requirement holds from "];
    scratch.succeed_with("metal distance a.design.ron --direction 1,0,0", &words);
    assert!(scratch.read("out.svg").contains("distance from plate to the tip, mm"));
}

#[test]
fn impossible_rooms_are_one_clear_error() {
    let simulate = "simulate a.design.ron --mode single";
    for (from, to, words) in [
        ("(300, 0, -300)", "(0, 0, -300)", "plate is in the middle of the measurement volume"),
        ("(300, 0, -300)", "(-120, -60, 0)", "plate cuts coil"),
        ("aluminium", "cheese", "found the material \"cheese\", expected aluminium, copper"),
        ("200, 200, 10", "200, NaN, 10", "plate: depth is NaN mm"),
        ("triangles: 400", "triangles: 1000000", "plate: 1000000 triangles, expected 48 to"),
    ] {
        let objects = PLATE.replace(from, to);
        assert_ne!(objects, PLATE, "{from}");
        scratch_with(&objects).fail_with(simulate, &[words]);
    }
    let open = PLATE.replace("Cuboid(size: (200, 200, 10))", "Mesh(file: \"open.obj\")");
    let scratch = scratch_with(&open);
    scratch.write("open.obj", "v 0 0 0\nv 90 0 0\nv 0 90 0\nv 0 0 90\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
    scratch.fail_with(simulate, &["plate: ", "open"]);
    let still = scratch_with(PLATE);
    still.replace("room.env.ron", "frequency: 10000", "frequency: 0");
    let words = ["plate: frequency is 0 Hz", "a conductor needs a frequency above 0"];
    still.fail_with(simulate, &words);
    let mut few = Generator::planar_nine();
    few.coils.truncate(4);
    still.write("room.env.ron", room(&few, PLATE));
    still.fail_with(simulate, &["coils is 4, expected 5 to 32 coils"]);
}

#[test]
fn bad_arguments_of_distance_are_refused() {
    let scratch = scratch_with(PLATE);
    let distance = "metal distance a.design.ron";
    scratch.refused(format!("{distance} --direction 0,0,0"), &["three numbers"]);
    scratch.fail_with(format!("{distance} --object spoon"), &["\"spoon\", expected one of plate"]);
    let words = ["-1 mm, expected a length above zero"];
    scratch.fail_with(format!("{distance} --farthest -1"), &words);
    let words = ["found a room without metal, expected an object to move"];
    scratch.fail_with("metal distance designs/pointer-on-head.design.ron", &words);
}
