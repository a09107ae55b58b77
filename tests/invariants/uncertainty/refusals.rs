//! What has no uncertainty, and why.

use super::{built_in, with_jitter};
use crate::support::studies::cancelled;
use trackwright_field::OutsidePolicy;
use trackwright_field::environment::Jitter;
use trackwright_simulation::Scenario;
use trackwright_simulation::uncertainty::{
    UncertaintyError, first_order, monte_carlo, over_motion,
};
use trackwright_task::{Cancelled, Task};

#[test]
fn no_jitter_is_no_scatter() {
    let tip = first_order(&with_jitter(&built_in(1.0), Some(Jitter::uniform(0.0, 0.0)))).unwrap();
    assert_eq!((tip.rms_mm, tip.rotation_rms_rad), (0.0, 0.0));
    assert_eq!(tip.total_rms_mm, tip.bias_mm.norm());
    assert_eq!(tip.ellipsoid.lengths_mm(), [0.0; 3]);
}

#[test]
fn what_cannot_be_computed_is_refused_with_a_reason() {
    let scenario = built_in(1.0);
    let jittering = |mm: f64| with_jitter(&scenario, Some(Jitter::uniform(mm, 0.0)));
    let mut bare = scenario.clone();
    bare.tool.sensors.clear();
    let mut outside = scenario.clone();
    outside.crf_from_tool.translation.vector.x += 1e4;
    assert!(first_order(&outside).is_ok());
    outside.outside = OutsidePolicy::Reject;
    for (scenario, words) in [
        (with_jitter(&scenario, None), "states no jitter"),
        (jittering(-1.0), "jitter.position_mm is -1"),
        (jittering(1e200), "expected a length of at most 1e6 mm"),
        (bare, "has no sensors"),
        (outside, "outside the model's box"),
    ] {
        let message = first_order(&scenario).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
        let sampled = monte_carlo(&scenario, 100, 0, &Task::default()).unwrap_err();
        assert_eq!(sampled.to_string(), message);
    }
    let task = Task::default();
    assert_eq!(monte_carlo(&scenario, 3, 0, &task), Err(UncertaintyError::Samples { found: 3 }));
    let stopped = UncertaintyError::Cancelled(Cancelled);
    assert_eq!(monte_carlo(&scenario, 1000, 0, &cancelled()), Err(stopped.clone()));
    assert_eq!(over_motion(&scenario, &cancelled()), Err(stopped));
    let still = Scenario { motion: None, ..scenario };
    assert_eq!(over_motion(&still, &Task::default()), Err(UncertaintyError::NoMotion));
}
