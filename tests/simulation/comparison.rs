//! Trials drawn between those of the grid.
use crate::support::studies::default_design;
use trackwright_simulation::comparison::sampled::*;
use trackwright_simulation::{AxisRange, Motion, Scenario};

#[test]
fn every_part_covers_the_range_evenly_and_stays_in_it() {
    let scenario = Scenario {
        motion: Some(Motion {
            y: Some(AxisRange { min: -10.0, max: 30.0, step: 15.0 }),
            // A step of zero is one value, and so is a range without length.
            z: Some(AxisRange { min: 4.0, max: 9.0, step: 0.0 }),
            ..Motion::default()
        }),
        ..default_design()
    };
    let from = scenario.crf_from_tool.translation.vector;
    for part in range_trials(&scenario, 4, 64, 3) {
        let mut cells = [0; 16];
        for trial in &part {
            let by = trial.crf_from_tool.translation.vector - from;
            assert!((by.x, by.z) == (0.0, 4.0) || (by.z - 4.0).abs() < 1e-12);
            cells[((by.y + 10.0) / 40.0 * 16.0) as usize] += 1;
        }
        // Digital nets: the same number in each of 2^k equal cells.
        assert_eq!(cells, [4; 16]);
    }
    let still = Scenario { motion: None, ..scenario };
    assert!(range_trials(&still, 4, 64, 3).is_empty());
}
