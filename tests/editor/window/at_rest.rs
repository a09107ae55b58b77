//! While nothing changes, nothing is drawn and nothing is computed.

use super::harness::Window;
use super::places::{in_inspector, middle_of_view};
use crate::copied::Copied;
use crate::support::program::processor_seconds;
use std::time::Duration;

/// How long the window is watched.
const WATCHED: Duration = Duration::from_secs(10);

#[track_caller]
fn assert_rests(window: &mut Window) {
    let before = processor_seconds(window.pid());
    let line = window.next_line(WATCHED);
    let used = processor_seconds(window.pid()) - before;
    assert_eq!(line, None, "something was drawn or computed");
    assert!(used < 0.01 * WATCHED.as_secs_f64(), "{used} s of processor time");
}

#[test]
#[ignore = "long: watched for ten seconds"]
fn long_rest_over_the_scene_draws_no_frame() {
    let copy = Copied::new("pointer-on-head");
    let mut window = Window::open(&copy.design);
    window.point_at(middle_of_view());
    assert_rests(&mut window);
}

#[test]
#[ignore = "long: watched for ten seconds"]
fn long_rest_in_a_text_field_draws_no_frame() {
    let copy = Copied::new("pointer-on-head");
    let world = trackwright_project::open_design(&copy.design).unwrap();
    let mut window = Window::open(&copy.design);
    window.click(in_inspector(&world, None, "name"));
    assert_rests(&mut window);
    // The field had the keys all along.
    window.key("ctrl+a");
    window.write("Renamed");
    window.key("Return");
    assert_eq!(window.document("dirty"), "true");
    window.key("ctrl+s");
    let world = trackwright_project::open_design(&copy.design).unwrap();
    assert_eq!(world.document.design().name, "Renamed");
}
