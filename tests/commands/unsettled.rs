//! What a study leaves open is no requirement met: a rotation that sensors do not determine, and trials
//! that were left out, in every command that gives a verdict.

use super::optimize::forget_measurements;
use crate::support::golden::{list, number};
use crate::support::peers::sweep_rows;
use crate::support::program::Scratch;

const DESIGN: &str = "d/pointer-on-head.design.ron";
const ONE_SENSOR: &str = "d/one-sensor.design.ron";

/// The worked design with bounds that any figure keeps, and the same with a CRF of one 5-DOF sensor. Some
/// of their trials are outside the room.
fn designs_partly_outside(fit: &str) -> Scratch {
    let scratch = Scratch::new();
    let size = format!("--order 2 --directions 14 {fit}");
    scratch.copy_design_with_room("golden/pointer-on-head", &size);
    let required = "requirement: (position_rms: 60.0, angle_max: 90.0), orientation_weight";
    let design = scratch.read(DESIGN).replacen("orientation_weight", required, 1);
    scratch.write(DESIGN, &design);
    let one_sensor = design.replacen("crf.body.ron", "one-sensor.body.ron", 1);
    scratch.write(ONE_SENSOR, one_sensor);
    let body = "(version: 1, name: \"CRF\", tip: (0, 0, 0), sensors: [
        (name: \"s0\", kind: FiveDof, position: (-25, 0, 0), axis: (1, 0, 0))])";
    scratch.write("d/one-sensor.body.ron", body);
    scratch
}

/// The same with all trials inside.
fn designs(fit: &str) -> Scratch {
    let scratch = designs_partly_outside(fit);
    for design in [DESIGN, ONE_SENSOR] {
        for (from, to) in [
            ("position: (0, 20, 30)", "position: (0, 20, -40)"),
            ("(min: -60.0, max: 60.0, step: 60.0)", "(min: -20.0, max: 20.0, step: 20.0)"),
        ] {
            scratch.replace(design, from, to);
        }
    }
    scratch
}

#[test]
fn an_undetermined_rotation_meets_no_requirement() {
    for is_measured in [true, false] {
        let scratch = designs("");
        if !is_measured {
            forget_measurements(&scratch, "d/room.env.ron");
        }
        let (whole, one) = (DESIGN, ONE_SENSOR);
        let simulated = scratch.json(format!("simulate {whole} --mode motion"));
        assert_eq!(simulated["requirement"]["verdict"], "met", "{simulated}");

        let simulated = scratch.json(format!("simulate {one} --mode motion"));
        let requirement = &simulated["requirement"];
        let why = "the CRF's rotation is not determined";
        assert_eq!(requirement["verdict"], "cannot_tell", "{requirement}");
        for check in list(requirement, "checks") {
            assert_eq!((&check["verdict"], &check["reason"]), (&"cannot_tell".into(), &why.into()));
        }
        let open = &simulated["free_axis"];
        assert_eq!(open["body"], "crf");
        // The tip is 25 mm and more from the line of the sensor's axis.
        assert!(number(&open["reach_mm"]) > 25.0, "{open}");
        let words = scratch.succeed(format!("simulate {one} --mode motion"));
        let line = format!("requirement position_rms: cannot tell: {why}; ");
        assert!(words.contains(&line), "{words}");
        assert!(
            words.contains("figures take the true one, and a wrong one puts the tip"),
            "{words}"
        );

        let compared = scratch.json(format!("compare {whole} {one}"));
        let row = &compared["rows"][1];
        assert_eq!(row["requirement"], *requirement, "{row}");
        let differences = row["against_baseline"]["position_mm"].as_object().unwrap();
        assert!(differences.values().all(|d| d["verdict"] == "unsettled"), "{row}");

        let procedure = scratch.json(format!("procedure {one}"));
        let tool = list(&procedure, "steps").iter().find(|step| step["step"] == "tool").unwrap();
        assert_eq!(tool["state"], "cannot_tell");

        let sheet = scratch.json(format!("tolerances {one}"));
        let none = sheet["no_tolerances"].as_str().unwrap();
        assert!(none.contains("the CRF's rotation is not determined"), "{none}");

        scratch.succeed(format!("report {one} -o page.html"));
        let page = scratch.read("page.html");
        assert!(page.contains("It is undetermined, because the CRF"), "no such verdict");
        assert!(!page.contains("The requirement is met"));
    }
}

#[test]
fn rows_of_sweeps_have_the_verdicts_of_simulate() {
    let scratch = designs("");
    let plan = format!(r#"(version: 1, designs: ["{DESIGN}", "{ONE_SENSOR}"], motions: [Motion])"#);
    scratch.write("plan.sweep.ron", plan);
    scratch.succeed("sweep plan.sweep.ron -o out");
    let rows = sweep_rows(&scratch.path("out"));
    for (row, design) in rows.iter().zip([DESIGN, ONE_SENSOR]) {
        let simulated = scratch.json(format!("simulate {design} --mode motion"));
        assert_eq!(row["verdict"], simulated["requirement"]["verdict"], "{design}");
    }
}

#[test]
fn one_statement_names_what_is_assumed() {
    let scratch = designs("--no-support");
    let one = ONE_SENSOR;
    let words = scratch.succeed(format!("simulate {one} --mode motion"));
    let statement = words.lines().find(|line| line.contains("sensors do not determine"));
    let statement = statement.unwrap().trim_start_matches("the CRF").to_owned();
    assert!(statement.contains("its rotation about the CRF's x axis; "), "{statement}");
    let lines = [
        format!("tolerances {one}"),
        format!("procedure {one}"),
        format!("compare {one} {DESIGN}"),
    ];
    assert_stated(&scratch, one, &lines, &statement);
}

/// A report and other commands state a sentence.
fn assert_stated(scratch: &Scratch, design: &str, lines: &[String], statement: &str) {
    scratch.succeed(format!("report {design} -o page.html"));
    let page = scratch.read("page.html").replace("&#x27;", "'").replace("&#39;", "'");
    assert!(page.contains(statement), "the report does not state {statement:?}: {page}");
    for line in lines {
        scratch.succeed_with(line, &[statement]);
    }
}

/// The worked design without a CRF and its tool's body, whose sensors are given.
fn with_tool(body: &str) -> Scratch {
    let scratch = Scratch::new();
    let size = "--order 1 --directions 6 --no-support";
    scratch.copy_design_with_room("golden/pointer-no-crf", size);
    scratch.write("d/tool.body.ron", body);
    scratch
}

const NO_CRF: &str = "d/pointer-no-crf.design.ron";

/// Every command that shows a study states a sentence.
fn assert_stated_everywhere(scratch: &Scratch, statement: &str) {
    let lines = [format!("simulate {NO_CRF} --mode single"), format!("tolerances {NO_CRF}")];
    assert_stated(scratch, NO_CRF, &lines, statement.trim_start_matches("the "));
}

#[test]
fn a_barely_determined_rotation_is_stated() {
    // Two sensors in a needle, 3 degrees apart.
    let scratch = with_tool(
        "(version: 1, name: \"needle\", tip: (0, 0, 120), sensors: [
        (name: \"s0\", kind: FiveDof, position: (0, 0, 20), axis: (0, 0, 1)),
        (name: \"s1\", kind: FiveDof, position: (0, 0, 60), axis: (0.0523, 0, 0.9986))])",
    );
    let simulated = scratch.json(format!("simulate {NO_CRF} --mode single"));
    let weak = &simulated["barely_determined"];
    assert_eq!(weak["body"], "tool");
    let turn = weak["turn_per_tilt"].as_f64().unwrap();
    assert!((20.0..28.0).contains(&turn), "{weak}");
    assert!(simulated.get("free_axis").is_none());
    let words = scratch.succeed(format!("simulate {NO_CRF} --mode single"));
    let statement = words.lines().find(|line| line.contains("is barely determined")).unwrap();
    let cost = format!("1° of tilt in its sensors turns it by {turn:.0}°");
    assert!(statement.ends_with(&cost), "{statement}");
    assert_stated_everywhere(&scratch, statement);
    // Parallel ones do not determine it at all, and square ones do.
    let body = scratch.read("d/tool.body.ron");
    for (axis, is_free) in [("(0, 0, 1)", true), ("(1, 0, 0)", false)] {
        scratch.write("d/tool.body.ron", body.replace("(0.0523, 0, 0.9986)", axis));
        let simulated = scratch.json(format!("simulate {NO_CRF} --mode single"));
        assert!(simulated.get("barely_determined").is_none(), "{axis}: {simulated}");
        assert_eq!(simulated.get("free_axis").is_some(), is_free, "{axis}");
    }
}

#[test]
fn coils_that_do_not_fit_are_stated() {
    let coil = "coil: (diameter: 0.8, length: 9.0)";
    let body = format!(
        "(version: 1, name: \"needle\", mesh: \"needle.obj\", tip: (0, 0, 0), sensors: [
        (name: \"s0\", kind: FiveDof, position: (0, 0, 50), axis: (0, 0, 1), {coil}),
        (name: \"s1\", kind: FiveDof, position: (0, 0, 52), axis: (1, 0, 0), {coil})])"
    );
    let scratch = with_tool(&body);
    // 2 mm square and 100 mm long.
    let mut needle = String::new();
    for corner in 0..8 {
        let side = |bit: u32| if corner >> bit & 1 == 1 { 1 } else { -1 };
        let z = if corner >> 2 & 1 == 1 { 100 } else { 0 };
        needle += &format!("v {} {} {z}\n", side(0), side(1));
    }
    needle += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    scratch.write("d/needle.obj", needle);
    let simulated = scratch.json(format!("simulate {NO_CRF} --mode single"));
    let coils = simulated["coils"].as_array().unwrap();
    assert_eq!(coils.len(), 3, "{simulated}");
    assert_eq!((&coils[0]["sensor"], &coils[0]["overlaps"]["other"]), (&"s0".into(), &"s1".into()));
    assert_eq!((&coils[1]["body"], &coils[1]["sensor"]), (&"tool".into(), &"s1".into()));
    let out_mm = coils[1]["sticks_out"]["by_mm"].as_f64().unwrap();
    assert!((3.5..3.6).contains(&out_mm), "{simulated}");
    let statement =
        "the coil of the tool's sensor s1 does not fit: it sticks out of the body by 3.5 mm";
    assert_stated_everywhere(&scratch, statement);
    let statement = "the coil of the tool's sensor s0 overlaps with that of s1 by 0.8 mm";
    assert_stated_everywhere(&scratch, statement);
    let sheet = scratch.json(format!("tolerances {NO_CRF}"));
    assert_eq!(sheet["coils"], simulated["coils"]);
    // Along the needle and apart they fit.
    let fits = body.replace("52), axis: (1, 0, 0)", "70), axis: (0, 0, 1)");
    scratch.write("d/tool.body.ron", fits);
    let simulated = scratch.json(format!("simulate {NO_CRF} --mode single"));
    assert!(simulated.get("coils").is_none(), "{simulated}");
}

#[test]
fn trials_left_out_meet_no_requirement() {
    let scratch = designs_partly_outside("");
    let simulate = format!("simulate {DESIGN} --mode motion");
    let simulated = scratch.json(format!("{simulate} --outside reject"));
    let left_out = simulated["rejected"].as_u64().unwrap();
    assert!(left_out > 100 && simulated["trials"] == 405, "{simulated}");
    let why = format!("{left_out} of 405 trials were left out");
    let requirement = &simulated["requirement"];
    assert_eq!(requirement["verdict"], "cannot_tell", "{requirement}");
    assert_eq!(requirement["reason"], *why, "{requirement}");
    let compare = format!("compare {DESIGN} {ONE_SENSOR}");
    for args in [simulate, compare, format!("tolerances {DESIGN}")] {
        scratch.succeed_with(format!("{args} --outside reject"), &[&why]);
    }
}

#[test]
fn a_rotation_about_the_tips_own_axis_settles() {
    let scratch = Scratch::new();
    scratch.copy_design_with_room("golden/pointer-no-crf", "--order 1 --directions 6");
    let needle = "(version: 1, name: \"needle\", tip: (0, 0, 120), sensors: [
        (name: \"s0\", kind: FiveDof, position: (0, 0, 20), axis: (0, 0, 1))])";
    scratch.write("d/tool.body.ron", needle);
    let design = scratch.read(NO_CRF);
    let end = design.rfind(')').unwrap();
    let requirement = "requirement: (position_rms: 60.0),";
    scratch.write(NO_CRF, format!("{}    {requirement}\n)\n", &design[..end]));
    // Inside the room.
    let lifted = "(min: -100.0, max: 60.0, step: 40.0)";
    scratch.replace(NO_CRF, "(min: -180.0, max: 100.0, step: 70.0)", lifted);
    let simulated = scratch.json(format!("simulate {NO_CRF} --mode motion"));
    assert_eq!(simulated["free_axis"]["body"], "tool");
    assert_eq!(simulated["requirement"]["verdict"], "met", "{simulated}");
}
