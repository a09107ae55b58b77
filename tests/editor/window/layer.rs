//! A layer that is off costs nothing, one that is turned on its own points and no more.

use super::harness::Window;
use super::places::{in_inspector, in_outliner, tool_sensor};
use crate::copied::Copied;
use trackwright_editor::runner::solve::slice_plan;

#[test]
fn a_slice_is_evaluated_only_while_on() {
    let copy = Copied::new("pointer-on-head");
    let world = trackwright_project::open_design(&copy.design).unwrap();
    let plan = slice_plan(&world.environment, &world.document.view().slice);
    let points = (plan.counts[0] * plan.counts[1]) as u64;
    let switch = in_outliner(&world, "Error slice");
    let mut window = Window::open(&copy.design);
    assert_eq!(window.counter("slice_evaluations"), points);

    window.click(switch);
    assert_eq!(window.document("dirty"), "true");
    let (selected, _) = tool_sensor(&world, "shaft");
    window.click(in_outliner(&world, "shaft"));
    window.click(in_inspector(&world, Some(selected), "position z in mm"));
    window.write("80");
    let studies = window.counter("studies");
    window.key("Return");
    assert_eq!(window.counter("studies"), studies + 1);
    assert_eq!(window.counter("slice_evaluations"), points, "while it is off");

    let evaluations = window.counter("study_evaluations");
    window.click(switch);
    window.wait_for("a second slice", |lines| {
        lines.iter().any(|line| line.starts_with("counters ") && line.contains(" slices=2 "))
    });
    assert_eq!(window.counter("slice_evaluations"), 2 * points);
    assert_eq!(window.counter("study_evaluations"), evaluations, "a view is no edit");
}
