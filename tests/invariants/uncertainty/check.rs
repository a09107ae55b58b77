//! Where the first order holds, and where the program reports that it does not.

use super::{alone, body, five, jitter, sampled};
use trackwright_simulation::Scenario;
use trackwright_simulation::uncertainty::{check_first_order, first_order};

/// A tool of some size whose positions alone count.
fn short(size_mm: f64) -> Scenario {
    let tool = body(
        vec![
            five([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
            five([size_mm, 0.0, 0.0], [0.0, 1.0, 0.0]),
            five([0.0, size_mm, 0.25 * size_mm], [1.0, 0.0, 0.0]),
        ],
        [0.0, 0.0, -100.0],
    );
    alone(tool, 0.0, jitter())
}

#[test]
fn the_check_reports_where_first_order_fails() {
    let scenario = short(2.5);
    let formula = first_order(&scenario).unwrap();
    let check = check_first_order(&scenario, &formula).unwrap().unwrap();
    assert!(!check.holds, "{check:?}");
    let sample = sampled(&scenario);
    // About the tip without jitter, as the check has it.
    let truth = sample.rms_mm.value.hypot(sample.mean_error_mm.norm());
    let off = |v: f64| (v - truth).abs();
    assert!(off(formula.rms_mm) > 0.05 * truth, "{truth}");
    assert!(
        off(check.next_order_rms_mm) < 0.2 * off(formula.rms_mm),
        "{check:?} {truth} {}",
        formula.rms_mm
    );
}

#[test]
fn first_order_holds_for_large_tools_only() {
    // Half a millimetre of jitter turns 12 mm by some 0.08 rad, and small ones any way at all.
    let holds = |size_mm| {
        let scenario = short(size_mm);
        let formula = first_order(&scenario).unwrap();
        check_first_order(&scenario, &formula).unwrap().unwrap().holds
    };
    for size_mm in [12.0, 50.0, 300.0] {
        assert!(holds(size_mm), "{size_mm} mm");
    }
    let mut size_mm = 3.0;
    while size_mm > 0.02 {
        assert!(!holds(size_mm), "{size_mm} mm");
        size_mm *= 0.97;
    }
}

#[test]
fn with_too_many_sensors_the_check_is_left_out() {
    let sensors =
        (0..21).map(|k| five([f64::from(k), f64::from(k * k), 0.0], [0.0, 0.0, 1.0])).collect();
    let scenario = alone(body(sensors, [0.0; 3]), 60.0, jitter());
    let formula = first_order(&scenario).unwrap();
    assert_eq!(check_first_order(&scenario, &formula), Ok(None));
}
