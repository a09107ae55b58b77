//! The formula against sampling, and what sampling reports of itself.

use super::{
    SAMPLES, SIGMAS, alone, assert_agree, body, built_in, five, head, jitter, on_head, sampled,
    six, three_fives, with_jitter,
};
use crate::support::studies::on_threads;
use nalgebra::{Point3, Vector3};
use trackwright_field::environment::{Jitter, JitterGrowth};
use trackwright_simulation::uncertainty::{first_order, monte_carlo};
use trackwright_task::Task;

#[test]
fn sampling_agrees_with_the_first_order() {
    let of_weight = |weight_mm| alone(three_fives(), weight_mm, jitter());
    for weight_mm in [0.0, 10.0, 30.0, 100.0, 300.0, 1000.0] {
        assert_agree(&of_weight(weight_mm), &format!("w {weight_mm}"));
    }
    for weight_mm in [0.0, 95.0] {
        assert_agree(&on_head(of_weight(weight_mm), head()), &format!("w {weight_mm}, CRF"));
    }
    let single = vec![six([1.0, 2.0, 3.0], [0.1, 0.2, 0.3])];
    let mixed =
        vec![five([0.0, 0.0, 60.0], [0.0, 0.0, 1.0]), six([8.0, -3.0, 95.0], [0.4, -1.0, 2.0])];
    for (sensors, tip, what) in [(single, [0.0, 0.0, 90.0], "6 DOF"), (mixed, [0.0; 3], "mixed")] {
        let scenario = alone(body(sensors, tip), 95.0, jitter());
        assert_agree(&scenario, what);
        assert_agree(&on_head(scenario, head()), &format!("{what}, CRF"));
    }
    let grown = Jitter {
        growth: Some(JitterGrowth::dipole(300.0)),
        ..Jitter::uniform(0.1, 0.1_f64.to_radians())
    };
    assert_agree(&with_jitter(&built_in(1.0), Some(grown)), "growing jitter");
}

#[test]
fn samples_do_not_depend_on_threads() {
    let scenario = on_head(alone(three_fives(), 60.0, jitter()), head());
    let sample = || monte_carlo(&scenario, 5_000, 3, &Task::default()).unwrap();
    let on = |threads| on_threads(threads, sample);
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(7));
    let other_seed = monte_carlo(&scenario, 5_000, 4, &Task::default()).unwrap();
    assert_ne!(one.rms_mm.value, other_seed.rms_mm.value);
}

#[test]
fn percentiles_of_an_isotropic_scatter_are_maxwells() {
    // The tip at the middle of the sensors: its error is the mean of theirs, whatever the turn.
    let mut tool = three_fives();
    tool.tip_in_body = Some(Point3::new(10.0, 25.0 / 3.0, 50.0 / 3.0));
    let sample = sampled(&alone(tool, 60.0, jitter()));
    let sigma = 0.5 / 3.0_f64.sqrt();
    // The roots of chi-squared quantiles with three degrees of freedom, and the densities there.
    for (found, quantile, p) in [
        (sample.median_mm, 2.365_973_884_375_338, 0.5),
        (sample.p95_mm, 7.814_727_903_251_179, 0.95),
    ] {
        let y = f64::sqrt(quantile);
        let density = (2.0 / std::f64::consts::PI).sqrt() * y * y * (-0.5 * quantile).exp();
        let std_error = sigma * f64::sqrt(p * (1.0 - p) / SAMPLES as f64) / density;
        assert!((found.value - sigma * y).abs() < SIGMAS * std_error, "{found:?}");
        // From two order statistics, some hundred samples apart.
        assert!((found.std_error / std_error - 1.0).abs() < 0.3, "{found:?} {std_error}");
    }
    let rms = sample.rms_mm;
    assert!((rms.value - 0.5).abs() < SIGMAS * rms.std_error);
    let expected = 0.5 / (6.0 * SAMPLES as f64).sqrt();
    assert!((rms.std_error / expected - 1.0).abs() < 0.05, "{rms:?}");
}

#[test]
fn a_free_roll_leaves_part_of_the_uncertainty() {
    let pen = |axis| body(vec![five([0.0, 0.0, 0.0], axis)], [0.0, 0.0, -80.0]);
    for (axis, is_on_axis) in [([0.0, 0.0, 1.0], true), ([0.0, 0.6, 0.8], false)] {
        let scenario = alone(pen(axis), 100.0, jitter());
        let formula = assert_agree(&scenario, "pen");
        let part = formula.determined.unwrap();
        assert_eq!(part.free_axis.body, "tool");
        let free: Vector3<f64> = part.free_axis.axis_in_body.unwrap().into();
        assert!(free.cross(&Vector3::from(axis).normalize()).norm() < 1e-14);
        let determined = sampled(&scenario).determined_mm.unwrap();
        // Of at least two normal components.
        let std_error = part.rms_mm / (4.0 * SAMPLES as f64).sqrt();
        assert!(
            (determined.rms() - part.rms_mm).abs() < SIGMAS * std_error + 1e-3 * part.rms_mm,
            "{determined:?} {part:?}"
        );
        if is_on_axis {
            assert!((part.rms_mm - formula.rms_mm).abs() < 1e-13);
        } else {
            assert!(part.rms_mm < 0.95 * formula.rms_mm);
        }
    }
}

#[test]
fn a_free_rotation_of_the_crf_is_reported() {
    let bar = body(
        vec![five([-40.0, 0.0, 0.0], [1.0, 0.0, 0.0]), five([40.0, 0.0, 0.0], [1.0, 0.0, 0.0])],
        [0.0; 3],
    );
    let scenario = on_head(alone(three_fives(), 60.0, jitter()), bar);
    let part = first_order(&scenario).unwrap().determined.unwrap();
    assert_eq!(part.free_axis.body, "crf");
    let found = Vector3::from(part.free_axis.axis_in_body.unwrap());
    assert!(found.cross(&Vector3::x()).norm() < 1e-14);
    let determined = sampled(&scenario).determined_mm.unwrap();
    let std_error = part.rms_mm / (2.0 * SAMPLES as f64).sqrt();
    assert!((determined.rms() - part.rms_mm).abs() < SIGMAS * std_error + 1e-3 * part.rms_mm);
}
