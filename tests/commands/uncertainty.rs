//! `simulate --uncertainty` and the jitter that `fit` writes.

use crate::support::close::assert_close;
use crate::support::golden::{number, vector};
use crate::support::program::Scratch;
use serde_json::Value;

const DESIGN: &str = "d/pointer-on-head.design.ron";
const JITTER: &str = "--jitter-position-mm 0.5 --jitter-angle-deg 0.3";

/// The worked design in a room that states its jitter where `jitter` does.
fn room(jitter: &str) -> Scratch {
    let scratch = Scratch::new();
    let fit = format!("--order 1 --directions 6 {jitter}");
    scratch.copy_design_with_room("golden/pointer-on-head", &fit);
    scratch
}

fn single(scratch: &Scratch, more: &str) -> Value {
    scratch.json(format!("simulate {DESIGN} --mode single {more}"))
}

#[test]
fn both_uncertainty_methods_agree() {
    let scratch = room(JITTER);
    let more = "--uncertainty first-order,monte-carlo --samples 20000 --seed 5";
    let found = single(&scratch, more);
    let u = &found["uncertainty"];
    assert_eq!(u["jitter"]["source"], "environment");
    assert_close("angle", number(&u["jitter"]["angle_deg"]), 0.3, 1e-15, 0.0);
    assert_eq!(u["orientation_weight_source"], "design");
    assert_eq!(number(&u["orientation_weight_mm"]), 100.0);
    assert_eq!(u["first_order"]["check"]["holds"], true);
    // Four standard errors of the sampling, and what the check states about the next order.
    let next = number(&u["first_order"]["check"]["relative_difference"]);
    let off = number(&u["agreement"]["relative_difference"]).abs();
    let std_error =
        number(&u["monte_carlo"]["rms_std_error_mm"]) / number(&u["monte_carlo"]["rms_mm"]);
    assert!(off < 4.0 * std_error + 2.0 * next && off < 0.02, "{off}");
    // The shift is that of the simulation, and the ellipsoid stands about the simulated tip.
    assert_eq!(u["first_order"]["bias_check"]["simulated_mm"], found["error_mm"]);
    let first_order = &u["first_order"];
    let [center, tip, error] =
        [&first_order["ellipsoid_95"]["center_mm"], &first_order["tip_mm"], &found["error_mm"]]
            .map(vector);
    assert!((center - tip - error).amax() < 1e-12);
    let words = [
        "jitter 0.5000 mm and 0.3000 ° an axis, from the environment",
        "orientation weight 100.0000 mm, design",
        "first order holds for the scatter",
        "Monte Carlo",
        "ellipsoid",
    ];
    scratch.succeed_with(format!("simulate {DESIGN} --mode single {more}"), &words);
}

#[test]
fn the_weight_follows_jitter_unless_given() {
    let scratch = room(JITTER);
    let before = scratch.read(DESIGN);
    let lines: Vec<_> = before.lines().filter(|l| !l.contains("orientation_weight")).collect();
    assert_eq!(lines.len() + 1, before.lines().count());
    scratch.write(DESIGN, lines.join("\n"));
    let derived = single(&scratch, "--uncertainty first-order");
    let u = &derived["uncertainty"];
    assert_eq!(u["orientation_weight_source"], "derived from jitter");
    let weight = |position_mm: f64, angle_deg: f64| position_mm / angle_deg.to_radians();
    assert_close("weight", number(&u["orientation_weight_mm"]), weight(0.5, 0.3), 1e-14, 0.0);
    assert!(u["monte_carlo"].is_null() && u["agreement"].is_null());
    let jitter = "--jitter-position-mm 0.1 --jitter-angle-deg 0.2 --jitter-growth-mm 400";
    let stated = single(&scratch, &format!("--uncertainty first-order {jitter}"));
    let u = &stated["uncertainty"];
    assert_eq!(u["jitter"]["source"], "command line");
    assert_eq!(number(&u["jitter"]["growth"]["distance_mm"]), 400.0);
    assert_eq!(number(&u["jitter"]["growth"]["position_exponent"]), 4.0);
    assert_close("weight", number(&u["orientation_weight_mm"]), weight(0.1, 0.2), 1e-14, 0.0);
}

#[test]
fn the_growth_of_fit_is_read_by_simulate() {
    let scratch = room(&format!("{JITTER} --jitter-growth-mm 150"));
    let [read, stated, flat] = ["", &format!("--jitter-growth-mm 150 {JITTER}"), JITTER]
        .map(|more| single(&scratch, &format!("--uncertainty first-order {more}")));
    let [a, b] = [&read, &stated].map(|v| &v["uncertainty"]["first_order"]);
    assert_eq!(a, b);
    let flat = number(&flat["uncertainty"]["first_order"]["rms_mm"]);
    assert!(number(&a["rms_mm"]) > 1.1 * flat, "{a} {flat}");
}

#[test]
fn scatter_and_error_add_in_squares() {
    let scratch = room(JITTER);
    let simulate = format!("simulate {DESIGN} --mode motion");
    assert!(scratch.json(&simulate)["uncertainty"].is_null());
    let found = scratch.json(format!("{simulate} --uncertainty first-order"));
    let over = &found["uncertainty"]["first_order"];
    assert_eq!(over["trials"], found["trials"]);
    let expected =
        number(&over["rms_mm"]["rms"]).hypot(number(&found["room_field"]["position_mm"]["rms"]));
    assert_close("total", number(&over["total_rms_mm"]), expected, 1e-14, 0.0);
}

#[test]
fn unusable_options_are_refused_with_the_remedy() {
    let scratch = room("");
    for (args, words) in [
        (
            "single --uncertainty first-order",
            &["\"room\" states no jitter", "--jitter-position-mm"][..],
        ),
        ("motion --uncertainty monte-carlo JITTER", &["--mode single", "first-order"]),
        ("single JITTER", &["needs --uncertainty"]),
        (
            "single --uncertainty first-order --samples 9 JITTER",
            &["needs --uncertainty monte-carlo"],
        ),
        ("single --uncertainty monte-carlo --samples 3 JITTER", &["3 samples, expected 10 to"]),
        ("single --uncertainty monte-carlo --samples 99999999999 JITTER", &["to 10000000"]),
        (
            "single --jitter-position-mm -1",
            &["--jitter-position-mm", "-1", "expected zero or more"],
        ),
        ("single --jitter-angle-deg inf", &["--jitter-angle-deg", "inf", "expected zero or more"]),
        ("single --jitter-growth-mm 0", &["--jitter-growth-mm", "expected a length above zero"]),
        ("single --jitter-position-mm 1", &["--jitter-angle-deg"]),
    ] {
        let args = args.replace("JITTER", JITTER);
        scratch.refused(format!("simulate {DESIGN} --mode {args}"), words);
    }
}
