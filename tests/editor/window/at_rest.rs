//! While nothing changes, nothing is drawn and nothing is computed.

use super::harness::Window;
use super::places::{in_inspector, middle_of_view};
use crate::copied::Copied;
use std::time::Duration;

/// How long the window is watched.
const WATCHED: Duration = Duration::from_secs(10);

/// Ticks of processor time a second, on Linux everywhere.
const TICKS_A_SECOND: u64 = 100;

/// User and system time of a process and all its threads, in ticks.
fn processor_ticks(pid: u32) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    // The name in parentheses may contain anything; fields are counted from behind it.
    let fields: Vec<&str> = stat[stat.rfind(')').unwrap() + 1..].split_whitespace().collect();
    [11, 12].map(|k| fields[k].parse::<u64>().unwrap()).iter().sum()
}

#[track_caller]
fn assert_rests(window: &mut Window) {
    let before = processor_ticks(window.pid());
    let line = window.next_line(WATCHED);
    let ticks = processor_ticks(window.pid()) - before;
    assert_eq!(line, None, "something was drawn or computed");
    let all = WATCHED.as_secs() * TICKS_A_SECOND;
    assert!(ticks * 100 < all, "{ticks} ticks of processor time of {all}");
}

#[test]
fn with_the_pointer_at_rest_over_the_scene_no_frame_is_drawn() {
    let copy = Copied::new("pointer-on-head");
    let mut window = Window::open(&copy.design);
    window.point_at(middle_of_view());
    assert_rests(&mut window);
}

#[test]
fn with_a_text_field_focused_no_frame_is_drawn() {
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
