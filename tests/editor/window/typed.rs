//! Numbers that are typed count as those that are dragged.

use super::harness::{Window, simulated};
use super::places::{in_inspector, in_outliner, tool_sensor};
use crate::copied::Copied;

#[test]
fn a_typed_number_gives_the_saved_figures() {
    let copy = Copied::new("pointer-on-head");
    let world = trackwright_project::open_design(&copy.design).unwrap();
    let (selected, _) = tool_sensor(&world, "shaft");
    let mut window = Window::open(&copy.design);
    let figures = window.figures();
    window.click(in_outliner(&world, "shaft"));
    window.click(in_inspector(&world, Some(selected), "position z in mm"));
    window.write("81.25");
    window.key("Return");
    assert_eq!(window.document("undo"), "Move sensor shaft");
    assert_ne!(window.figures(), figures);
    window.key("ctrl+s");
    assert_eq!(window.document("dirty"), "false");
    assert_eq!(window.figures(), simulated(&copy.design));

    let saved = trackwright_project::open_design(&copy.design).unwrap();
    let sensors = &saved.document.design().tool.body.rigid.sensors;
    let shaft = sensors.iter().find(|sensor| sensor.name == "shaft").unwrap();
    assert!((shaft.position_in_body.z - 81.25).abs() < 1e-9, "{shaft:?}");
}
