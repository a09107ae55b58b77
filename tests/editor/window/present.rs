//! A presentation as a person gives it: keys turn slides, words are written on them, and the window
//! comes back as it was.

use super::harness::Window;
use super::screen::SIZE;
use crate::copied::Copied;
use trackwright_editor::widgets::theme;

/// Points of a stage's height, and where the title begins: see the stage's own layout.
const STAGE_POINTS: f64 = 560.0;
const TITLE_AT: [f64; 2] = [60.0, 40.0];

#[test]
fn slides_are_edited_presented_and_saved() {
    let copy = Copied::new("pointer-on-head");
    let slides = |copy: &Copied| {
        let world = trackwright_project::open_design(&copy.design).unwrap();
        world.document.design().slides.clone()
    };
    let before = slides(&copy);
    assert!(before.len() >= 3);
    let mut window = Window::open(&copy.design);
    let of_designer = window.picture();

    window.key("F5");
    let first = window.picture();
    window.key("Right");
    let second = window.picture();
    let most = usize::from(SIZE[0]) * usize::from(SIZE[1]);
    assert!(first.differences(&of_designer) > most / 10);
    assert!(second.differences(&first) > most / 50);
    window.key("Prior");
    assert_eq!(window.picture().differences(&first), 0);

    window.key("e");
    let zoom = f64::from(SIZE[1]) / STAGE_POINTS;
    let [x, y] = TITLE_AT;
    window.click([(f64::from(theme::LEFT_WIDTH) + x) * zoom, y * zoom]);
    window.key("ctrl+a");
    window.write("Ward 3");
    assert_eq!(window.document("dirty"), "false", "it is still being written");
    window.key("Return");
    assert_eq!(window.document("dirty"), "true");
    window.key("e");
    assert!(window.picture().differences(&first) > 100, "the title");
    window.key("ctrl+s");
    window.key("Escape");
    let after = slides(&copy);
    assert_eq!(after[0].title, "Ward 3");
    assert_eq!(after[0].view, before[0].view);
    assert_eq!(after[1..], before[1..]);
    // The scene is as it was; a line in the status bar states what was saved.
    let status_line = usize::from(SIZE[0]) * 24;
    assert!(window.picture().differences(&of_designer) < status_line);
    window.close();
}
