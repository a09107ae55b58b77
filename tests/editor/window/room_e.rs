//! A design in a room of the Johns Hopkins calibration sets opens in the window.

use super::harness::{Window, simulated};
use crate::support::data::third_party;
use crate::support::program::{Scratch, succeed, text};

#[test]
fn a_design_in_the_room_of_case_e_opens_with_the_figures_of_simulate() {
    let Some(folder) = third_party("jhu-cis") else {
        return;
    };
    let scratch = Scratch::new();
    scratch.copy_own("room-e", "room-e");
    let file = |kind: &str| text(&folder.join(format!("pa2-debug-e-{kind}.txt")));
    let table = scratch.arg("e.csv");
    succeed(&[
        "import",
        "jhu-cis",
        &file("calbody"),
        &file("calreadings"),
        "-o",
        &table,
    ]);
    let env = scratch.arg("room-e/room-e.env.ron");
    succeed(&[
        "fit",
        &table,
        "-o",
        &env,
        "--directions",
        "1",
        "--order",
        "5",
        "--map",
        "correction",
    ]);
    let design = scratch.path("room-e/pointer.design.ron");
    let window = Window::open(&design);
    assert_eq!(window.figures(), simulated(&design));
}
