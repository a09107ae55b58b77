//! Where the error comes from, in JSON: of a study that misses bounds, and of the worst trial.

use crate::support::golden::{list, number};
use crate::support::program::Scratch;
use serde_json::Value;

const DESIGN: &str = "pointer.design.ron";

/// The built-in design on a CRF with other bounds.
fn design(requirement: &str) -> Scratch {
    let scratch = Scratch::new();
    let from = "requirement: (position_rms: 1.0, angle_rms: 0.5)";
    let to = format!("requirement: {requirement}");
    scratch.copy_built_in("pointer-on-head", DESIGN, from, &to);
    scratch
}

fn simulate(scratch: &Scratch) -> Value {
    scratch.json(format!("simulate {DESIGN} --mode motion"))
}

/// Of all sensors.
fn sum(sensors: &[Value], key: &str) -> f64 {
    sensors.iter().map(|sensor| number(&sensor[key])).sum()
}

#[test]
fn missed_bounds_have_their_sources_in_json() {
    let scratch = design("(position_rms: 0.0001, angle_rms: 0.0001)");
    let found = simulate(&scratch);
    let sources = &found["error_sources"];
    // The study has few trials: all of them are looked at.
    assert_eq!(sources["trials"], found["trials"]);
    for (kind, figures, unit) in
        [("tip_error", "position_mm", "mm"), ("angle_error", "angle_deg", "deg")]
    {
        let of = &sources[kind];
        let rms = number(&of[format!("rms_{unit}")]);
        let own = number(&found["room_field"][figures]["rms"]);
        assert!((rms - own).abs() < 1e-9 * own, "{kind}: {rms} {own}");
        let sensors = list(of, "sensors");
        assert!((sum(sensors, "part") - 1.0).abs() < 0.02, "{kind}: {sensors:?}");
        for sensor in sensors {
            assert!(sensor["body"] == "tool" || sensor["body"] == "crf", "{sensor}");
            assert!(sensor["sensor"].is_string(), "{sensor}");
            assert!(number(&sensor[format!("rms_without_{unit}")]) >= 0.0, "{sensor}");
        }
        let worst = &of["worst"];
        assert!(number(&worst["within"]) <= number(&worst["trials"]), "{worst}");
        for range in list(worst, "ranges") {
            let unit = if range["axis"].as_str().unwrap().starts_with('r') { "deg" } else { "mm" };
            let [from, to] =
                ["from", "to"].map(|end| number(&range[format!("{end}_{unit}").as_str()]));
            assert!(from <= to, "{range}");
        }
    }
    // The sensor that the text names carries most.
    let text = scratch.succeed(format!("simulate {DESIGN} --mode motion"));
    let sensors = list(&sources["tip_error"], "sensors");
    let largest =
        sensors.iter().max_by(|a, b| number(&a["part"]).total_cmp(&number(&b["part"]))).unwrap();
    let named = format!("Sensor {} of the ", largest["sensor"].as_str().unwrap());
    assert!(text.contains(&named), "{named}: {text}");
}

#[test]
fn only_missed_kinds_of_error_have_sources() {
    let met = simulate(&design("(position_rms: 1000.0, angle_rms: 179.0)"));
    assert!(met.get("error_sources").is_none(), "{met}");
    let one = simulate(&design("(position_rms: 1000.0, angle_rms: 0.0001)"));
    let sources = &one["error_sources"];
    assert!(sources.get("tip_error").is_none() && sources.get("angle_error").is_some(), "{one}");
}

#[test]
fn contributions_at_the_worst_trial_add_up() {
    let found = simulate(&design("(position_rms: 1000.0)"));
    let sensors = list(&found, "worst_contributions");
    let worst_mm = number(&found["worst"]["position_mm"]);
    let sum_mm = sum(sensors, "along_tip_error_mm");
    assert!(worst_mm > 0.2 && (sum_mm - worst_mm).abs() < 0.05 * worst_mm, "{sum_mm} {worst_mm}");
    assert!(sensors.iter().any(|sensor| sensor["body"] == "crf"), "{sensors:?}");
}

#[test]
fn sources_of_a_crf_alone_are_its_own_sensors() {
    let scratch = Scratch::new();
    let to = "requirement: (position_rms: 0.0001),\n        targets: [";
    scratch.copy_built_in("pointer-on-head", DESIGN, "targets: [", to);
    let line = format!("simulate {DESIGN} --body crf --mode single");
    let found = scratch.json(&line);
    for target in list(&found, "targets") {
        let missed = list(&target["error_sources"]["tip_error"], "sensors");
        for sensors in [list(target, "worst_contributions"), missed] {
            let are_own = sensors.iter().all(|sensor| sensor["body"] == "crf");
            assert!(are_own && !sensors.is_empty(), "{target}");
        }
    }
    scratch.succeed_with(&line, &["of the CRF carries"]);
}
