//! Quadrature over a range of motion against the full grid.

use crate::support::studies::built_in;
use trackwright_simulation::pose_rule::*;
use trackwright_simulation::{AxisRange, Motion, Scenario};

#[test]
fn few_nodes_have_the_moments_of_all_values() {
    for count in [1, 2, 3, 5, 30] {
        for nodes in 1..=count.min(6) {
            let rule = gauss_nodes(count, nodes);
            let middle = (count as f64 - 1.0) / 2.0;
            let scale = middle.max(1.0);
            for power in 0..(2 * nodes as i32) {
                let of = |x: f64| ((x - middle) / scale).powi(power);
                let all = (0..count).map(|i| of(i as f64)).sum::<f64>() / count as f64;
                let few: f64 = rule.iter().map(|(x, w)| w * of(*x)).sum();
                assert!((all - few).abs() < 1e-13, "{count} {nodes} {power}: {all} {few}");
            }
        }
    }
}

#[test]
fn as_many_nodes_as_values_are_the_grid() {
    let range = |min: f64, step: f64| Some(AxisRange { min, max: min + 2.0 * step, step });
    let scenario = Scenario {
        motion: Some(Motion {
            y: range(-4.0, 4.0),
            rx: range(-10.0, 15.0),
            rz: range(5.0, 5.0),
            ..Motion::default()
        }),
        ..built_in("endoscope")
    };
    let grid = scenario.motion_grid().unwrap().unwrap();
    let (whole, gauss) = (PoseRule::whole(&grid), PoseRule::gauss(&scenario, 27).unwrap());
    assert_eq!((whole.run, gauss.run), (3, 3));
    assert_eq!(whole.poses.len(), 27);
    for (a, b) in whole.poses.iter().zip(&gauss.poses) {
        assert!((a.translation.vector - b.translation.vector).norm() < 1e-12);
        assert!(a.rotation.angle_to(&b.rotation) < 1e-7);
    }
    for weight in gauss.weights {
        assert!((weight - 1.0 / 27.0).abs() < 1e-14);
    }
    assert_eq!(PoseRule::gauss(&scenario, 26).unwrap().poses.len(), 8);
    assert_eq!(PoseRule::gauss(&scenario, 0).unwrap().poses.len(), 1);
}
