//! Deciding as a person does it: a state is pinned, a reason is typed, a step is decided and saved.

use super::harness::Window;
use super::screen::SIZE;
use crate::copied::Copied;
use trackwright_design::Decision;
use trackwright_procedure::DecisionBasis;
use trackwright_simulation::Metric;

/// Where the workspace has them in a window of [`SIZE`] with the built-in pointer.
const PIN_THIS_STATE: [f64; 2] = [1135.0, 112.0];
const REASON_OF_THE_TOOL: [f64; 2] = [150.0, 422.0];
const DECIDE_ON_THE_TOOL: [f64; 2] = [33.0, 447.0];

fn decided(copy: &Copied) -> Option<Decision> {
    let world = trackwright_project::open_design(&copy.design).unwrap();
    world.document.design().procedure.tool.clone()
}

#[test]
fn a_decision_with_its_reason_is_saved() {
    let copy = Copied::new("pointer-on-head");
    let mut window = Window::open(&copy.design);
    window.key("ctrl+5");
    let nothing_pinned = window.picture();
    window.click(PIN_THIS_STATE);
    let pinned = window.picture();
    // Five figures of both, their differences, and the baseline in the scene.
    let most = usize::from(SIZE[0]) * usize::from(SIZE[1]);
    assert!(pinned.differences(&nothing_pinned) > most / 100);
    assert_eq!(window.document("dirty"), "false", "a baseline is no edit");

    window.click(REASON_OF_THE_TOOL);
    window.write("for the first trial");
    window.click(DECIDE_ON_THE_TOOL);
    assert_eq!(window.document("dirty"), "true");
    window.key("ctrl+s");
    let decision = decided(&copy).expect("a decision in the file");
    assert_eq!(decision.note, "for the first trial");
    let DecisionBasis::Studies(studies) = &decision.basis else {
        panic!("{decision:?}");
    };
    let rms_mm = studies.rows[0].figures.as_ref().unwrap().values.get(Metric::TIP_RMS).unwrap();
    let shown = window.figures();
    let rms = shown.iter().find(|(label, _)| label == "tip error RMS");
    let rms = &rms.expect("figures").1;
    assert!(rms.contains(&format!("{rms_mm:.4}")), "{rms} {rms_mm}");

    window.key("ctrl+z");
    window.key("ctrl+s");
    assert!(decided(&copy).is_none(), "taken back");
    window.close();
}
