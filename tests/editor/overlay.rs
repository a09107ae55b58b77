//! What is written over pictures.

use super::app::environment;
use trackwright_editor::viewport::overlay::legend::caption;
use trackwright_field::environment::{HoldoutProvenance, Provenance};
use trackwright_field::fit::{FitMethod, Residuals};

#[test]
fn every_picture_states_the_source_of_its_figures() {
    let mut room = environment();
    assert_eq!(caption(&room), "Predicted in room Test room, an ideal room; not for clinical use");
    let residuals = |position_rms_mm| Residuals { position_rms_mm, angle_rms_rad: None };
    room.provenance = Some(Provenance {
        data: "cube-fit.csv".into(),
        samples: 2304,
        method: FitMethod::PerDirection,
        ridge: 0.0,
        train_before: residuals(2.5),
        train_after: residuals(1.2),
        holdout: Some(HoldoutProvenance {
            data: "cube-holdout.csv".into(),
            samples: 900,
            before: residuals(2.48),
            after: residuals(1.34),
        }),
    });
    assert_eq!(
        caption(&room),
        "Predicted in room Test room, 2,304 samples. Model error on unseen data: \
         1.34\u{2009}mm RMS; not for clinical use"
    );
}
