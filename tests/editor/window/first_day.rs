//! The first day of somebody new: a needle from an STL file becomes a design with a room, a baseline,
//! a slide and a report. No coordinate is typed, and each figure is that of the command line.

use super::harness::{Turn, Window, simulated};
use super::screen::SIZE;
use crate::copied::Copied;
use crate::support::program::{json, succeed, text};
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;
use trackwright_result::with_separators;
use trackwright_simulation::SensorOrientation;
use trackwright_simulation::figures::trial_number;

/// Where the needle's point is once the view is framed.
const POINT_ON_SCREEN: [f64; 2] = [690.0, 92.0];

/// Left of it the scene is free of the legend.
const LEGEND_LEFT: usize = 880;

const MOST_CLICKS: usize = 35;

/// A rod along z with its hub at the origin and a point at its other end.
fn needle_stl() -> String {
    const SIDES: usize = 24;
    const RADIUS_MM: f64 = 1.0;
    let ring = |z: f64| -> Vec<[f64; 3]> {
        let turn = |k: usize| std::f64::consts::TAU * k as f64 / SIDES as f64;
        let at = |k| [RADIUS_MM * f64::cos(turn(k)), RADIUS_MM * f64::sin(turn(k)), z];
        (0..SIDES).map(at).collect()
    };
    let (hub, front) = (ring(0.0), ring(144.0));
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
        facet([[0.0, 0.0, 150.0], front[k], front[next]]);
        facet([front[k], hub[k], hub[next]]);
        facet([front[k], hub[next], front[next]]);
        facet([[0.0; 3], hub[next], hub[k]]);
    }
    text + "endsolid needle\n"
}

/// Names a file in the dialog that is open, and ends it.
fn choose(window: &mut Window, file: &Path) {
    window.key("ctrl+a");
    window.write(&file.display().to_string());
    window.key("Return");
}

/// Saves, and holds the window's figures against those of the command line.
#[track_caller]
fn save_and_check(window: &mut Window, design: &Path) {
    window.key("ctrl+s");
    assert_eq!(window.document("dirty"), "false");
    assert_eq!(window.figures(), simulated(design));
}

/// Clicks the mark of the best place when it is there.
#[track_caller]
fn click_best_place(window: &mut Window) {
    for _ in 0..60 {
        let picture = window.picture();
        let marks = picture.blobs(is_mark);
        let mark = marks.iter().map(|mark| mark.center()).find(|[x, _]| *x < LEGEND_LEFT as f64);
        if let Some(at) = mark {
            window.click(at);
            return;
        }
    }
    panic!("no best place is marked");
}

/// The mark's green, which is between that of the slice's handle and the yellow of sensors.
fn is_mark(pixel: [u8; 3]) -> bool {
    let [r, g, b] = pixel.map(i32::from);
    g > 200 && g - r > 40 && g - b > 120
}

/// A row of the comparison as the command line has it: baseline, this, difference, judgement.
fn compared(of: &Value, quantity: &str, figure: &str) -> [String; 4] {
    let value = |row: usize| {
        let known = &of["rows"][row]["figures"][quantity][figure];
        known["value"].as_f64().unwrap()
    };
    let difference = &of["rows"][1]["against_baseline"][quantity][figure];
    let change = format!("{:+.3}", difference["difference"].as_f64().unwrap());
    // Its name in files is older than its words.
    let verdict = match difference["verdict"].as_str().unwrap() {
        "not_told" => "not significant",
        other => other,
    };
    let [baseline, this] = [0, 1].map(|row| format!("{:.3}", value(row)));
    [baseline, this, change.replace('-', "−"), verdict.to_owned()]
}

/// What each figure of a slide is about.
const ON_SLIDE: [&str; 3] =
    ["of the positions are within", "typical error at the tip", "largest error at the tip"];

/// Holds a slide's figures against those of the command line; the part of the positions is in its report.
#[track_caller]
fn check_slide([within, typical, largest]: &[String; 3], study: &Value, report: &str) {
    for (shown, words, summary) in [(typical, ON_SLIDE[1], "median"), (largest, ON_SLIDE[2], "max")]
    {
        let mm = |value: &Value| format!("{:.2}", value.as_f64().expect("millimetres"));
        let figure = &study["figures"]["position_mm"][summary];
        let [value, low, high] = ["value", "low", "high"].map(|end| mm(&figure[end]));
        assert_eq!(*shown, format!("{value} mm {words}, 95 %: {low} to {high} mm"));
    }
    let (part, limit_and_interval) = within.split_once(ON_SLIDE[0]).expect("a part");
    let part = part.trim_end_matches([' ', '✔', '✖', '?']);
    let interval = limit_and_interval.strip_prefix(" 1.50 mm, 95 %: ").expect("its interval");
    let trials = with_separators(study["trials"].as_u64().unwrap() as usize);
    let stated = match part {
        "100 %" => format!("all {trials} positions"),
        "0 %" => format!("none of the {trials} positions"),
        part => {
            let part = part.replace("> ", "more than ").replace("< ", "less than ");
            format!("{part} of the positions")
        }
    };
    let stated = format!("{stated} within 1.5 mm (95 %: {interval})");
    let report = report.replace('\u{2009}', " ").replace("&gt;", ">").replace("&lt;", "<");
    assert!(report.contains(&stated), "the report does not have: {stated}");
}

#[test]
#[ignore = "long: a day of work, four minutes"]
fn long_the_first_day_needs_no_coordinate() {
    assert_eq!(SIZE, [1440, 900]);
    let copy = Copied::new("pointer-on-head");
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    std::fs::write(file("needle.stl"), needle_stl()).unwrap();
    for (table, name) in [("cube-fit.csv", "fit.csv"), ("cube-holdout.csv", "holdout.csv")] {
        let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/environments/data");
        std::fs::copy(own.join(table), file(name)).unwrap();
    }
    let state = tempfile::tempdir().unwrap();
    let turn = Turn::wait();
    let mut window = Window::open_with_controls(&turn, &copy.design, state.path());

    // The needle.
    window.key("ctrl+n");
    window.click_control("Tool and CRF");
    let plain = window.figures();
    window.run_command("Load mesh");
    choose(&mut window, &file("needle.stl"));
    window.wait_for("the mesh", |lines| {
        lines.iter().any(|line| line.contains("undo=Change tool's mesh"))
    });
    window.settle();
    assert_eq!(window.figures(), plain, "a mesh changes no figure");

    // Its tip at its point.
    window.key("f");
    window.key("t");
    window.click(POINT_ON_SCREEN);
    assert_eq!(window.document("undo"), "Move tool tip");

    // Two sensors in its bore: a coil across a needle of 2 mm sticks out of it.
    window.click_control("back");
    window.run_command("Axis along the shaft");
    assert_eq!(window.document("undo"), "Align sensor back");
    window.key("ctrl+s");
    let design = file("needle.design.ron");
    choose(&mut window, &design);
    save_and_check(&mut window, &design);
    let body = std::fs::read_to_string(file("tool.body.ron")).unwrap();
    assert!(body.contains("mesh: \"needle.stl\""), "beside the mesh: {body}");

    // What it has to be.
    window.click_control("Untitled");
    window.click_control("tip error RMS at most");
    window.write("1.5");
    window.key("Return");

    // The best place of one sensor, from the map.
    window.click_control("front");
    window.run_command("Sensor placement");
    click_best_place(&mut window);
    assert_eq!(window.document("undo"), "Move sensor front");
    save_and_check(&mut window, &design);

    // The room from two tables.
    window.click_control("Field");
    window.click_control("Open measurements…");
    choose(&mut window, &file("fit.csv"));
    window.wait_for_control("fit.csv");
    window.click_control("Open held-out…");
    choose(&mut window, &file("holdout.csv"));
    window.wait_for_control("holdout.csv");
    window.click_control("Select and fit");
    window.wait_for_control("Use in this design…");
    let own = tempfile::tempdir().unwrap();
    let room = own.path().join("fit.env.ron");
    let [table, holdout, room_file] = [file("fit.csv"), file("holdout.csv"), room.clone()];
    let fitted =
        succeed(&["fit", &text(&table), "--holdout", &text(&holdout), "-o", &text(&room_file)]);
    let row = window.row("position RMS");
    for (line, shown) in [("trained position RMS", &row[..2]), ("held out position RMS", &row[2..])]
    {
        let printed = fitted.lines().find_map(|own| own.strip_prefix(line)).expect("a figure");
        let printed: Vec<String> = printed
            .split_whitespace()
            .filter_map(|word| word.parse::<f64>().ok())
            .map(|mm| format!("{mm:.2} mm"))
            .collect();
        let shown: Vec<String> = shown.iter().map(|text| text.replace('\u{2009}', " ")).collect();
        assert_eq!(shown, printed, "{line}");
    }
    window.click_control("Use in this design…");
    window.key("Return");
    window.wait_for("the room", |lines| lines.iter().any(|line| line.contains("undo=Use room")));
    save_and_check(&mut window, &design);
    let both = [room, file("fit.env.ron")].map(|room| std::fs::read(room).unwrap());
    assert!(both[0] == both[1], "the room is the command line's to the byte");

    // The worst trial.
    window.click_control("Study");
    window.click_control("Worst");
    let worst = &json(&["simulate", &text(&design), "--mode", "motion"])["worst"];
    let number = trial_number(worst["trial"].as_u64().unwrap() as usize);
    window.wait_for_control(&format!("Trial {number} in the CRF"));
    let shown = window.row("tip error");
    let worst_mm = worst["position_mm"].as_f64().unwrap();
    assert_eq!(shown.last().unwrap().replace('\u{2009}', " "), format!("{worst_mm:.2} mm"));

    // A baseline, the best place of the other sensor, and what it is better by.
    window.click_control("Decide");
    window.click_control("Pin this state");
    let pinned = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), pinned.path().join(entry.file_name())).unwrap();
    }
    window.click_control("Design");
    window.click_control("back");
    click_best_place(&mut window);
    assert_eq!(window.document("undo"), "Move sensor back");
    window.click_control("Decide");
    save_and_check(&mut window, &design);
    let compare = json(&[
        "compare",
        &text(&pinned.path().join("needle.design.ron")),
        &text(&design),
        "--environment",
        &text(&file("fit.env.ron")),
    ]);
    for (label, quantity, figure) in [
        ("tip RMS, mm", "position_mm", "rms"),
        ("tip 95 %, mm", "position_mm", "p95"),
        ("tip max, mm", "position_mm", "max"),
        ("angle RMS, °", "angle_deg", "rms"),
        ("angle max, °", "angle_deg", "max"),
    ] {
        assert_eq!(window.row(label)[..4], compared(&compare, quantity, figure), "{label}");
    }

    // A slide and a report.
    window.click_control("Present");
    let on_slide = ON_SLIDE.map(|words| window.name_with(words));
    window.key("e");
    window.click_control("Keep this view");
    window.key("e");
    window.key("Escape");
    save_and_check(&mut window, &design);
    window.run_command("Report");
    window.key("Return");
    window.wait_for("the report", |_| file("needle.html").exists());
    let page = std::fs::read_to_string(file("needle.html")).unwrap();
    let by_command = own.path().join("needle.html");
    succeed(&["report", &text(&design), "-o", &text(&by_command)]);
    assert!(page == std::fs::read_to_string(by_command).unwrap(), "the command line's report");
    check_slide(&on_slide, &json(&["simulate", &text(&design), "--mode", "motion"]), &page);

    let saved = trackwright_project::open_design(&design).unwrap();
    let needle = saved.document.design();
    assert_eq!(needle.slides.len(), 1);
    assert_eq!(trackwright_project::coil_findings(&saved), [], "all coils fit");
    let body = &needle.tool.body.rigid;
    assert_eq!(body.tip_in_body.unwrap().coords.as_slice(), [0.0, 0.0, 150.0]);
    for sensor in &body.sensors {
        let SensorOrientation::FiveDof(axis) = sensor.orientation else { panic!("{sensor:?}") };
        assert_eq!(axis.z, 1.0, "along the shaft");
        let off_mm = sensor.position_in_body.coords.xy().norm();
        assert!(off_mm < 0.01, "in the bore: {off_mm}");
    }
    assert!(window.clicks() <= MOST_CLICKS, "{} clicks", window.clicks());
    window.close();
}
