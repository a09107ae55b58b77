//! A design in a room of the Johns Hopkins calibration sets opens in the window.

use super::harness::{Window, simulated};
use crate::support::jhu_cis::import;
use crate::support::program::{Scratch, succeed};

#[test]
fn room_e_opens_with_the_figures_of_simulate() {
    let scratch = Scratch::new();
    let Some(table) = import(&scratch, "e") else { return };
    scratch.copy_own("room-e", "room-e");
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
