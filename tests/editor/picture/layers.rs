//! What each layer adds to a picture, and that pictures are the same each time.

use super::{render, render_file};
use crate::copied::Copied;
use crate::pixels::{Picture, is_error_vector, is_ghost};
use trackwright_editor::palette;
use trackwright_editor::palette::ThemedColor;

const SIZE: &str = "480x320";

/// How many pixels are like this.
fn count(picture: &Picture, is_wanted: impl Fn([u8; 3]) -> bool) -> usize {
    picture.all(is_wanted).len()
}

#[test]
fn the_same_design_gives_the_same_bytes_twice() {
    let copy = Copied::new("shaver-on-head");
    let [first, second] = [0, 1].map(|_| std::fs::read(render_file(&copy, SIZE, &[])).unwrap());
    assert!(first == second);
}

#[test]
fn each_layer_draws_only_itself() {
    let copy = Copied::new("pointer-on-head");
    let layers = |list: &str| render(&copy, SIZE, &["--layers", list]);
    let none = layers("none");
    let more = |picture: &Picture, is_wanted: fn([u8; 3]) -> bool| {
        count(picture, is_wanted).saturating_sub(count(&none, is_wanted))
    };
    // A tool of 150 mm is about 100 pixels long and 5 wide here, an arrow as long and thinner.
    // Edges of other things come near these colours in a few pixels.
    let (ghost, vectors) = (layers("ghost"), layers("sensor-errors,tip-error"));
    assert!(more(&ghost, is_ghost) > 150, "{}", more(&ghost, is_ghost));
    assert!(more(&ghost, is_error_vector) < 20);
    assert!(more(&vectors, is_error_vector) > 80);
    assert!(more(&vectors, is_ghost) < 20);
    // The edges of the volume cross the whole picture.
    let volume = layers("volume");
    assert!(volume.differences(&none) > 400, "{}", volume.differences(&none));
}

/// Every layer, and how many pixels of this picture it changes at least: far less than the things
/// it draws cover, far more than edges that are smoothed otherwise.
const LEAST_CHANGED: [(&str, usize); 14] = [
    ("volume", 400),
    ("generator", 400),
    ("grid", 400),
    ("anatomy", 2000),
    ("sensor-errors", 40),
    ("tip-error", 40),
    ("ghost", 150),
    ("motion", 100),
    ("slice", 5000),
    ("arrows", 2000),
    ("placement", 100),
    ("region", 1000),
    ("support", 1000),
    ("labels", 200),
];

#[test]
fn every_layer_is_seen() {
    let copy = Copied::new("pointer-on-head");
    let layers = |list: &str| {
        let more = ["--layers", list, "--select", "tool/shaft"];
        render(&copy, SIZE, &more)
    };
    let none = layers("none");
    let missing: Vec<String> = LEAST_CHANGED
        .into_iter()
        .filter_map(|(name, least)| {
            let changed = layers(name).differences(&none);
            (changed < least).then(|| format!("{name}: {changed}"))
        })
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn the_windows_panels_are_drawn_when_requested() {
    let copy = Copied::new("endoscope");
    let size = "960x600";
    let panel = |picture: &Picture| count(picture, |color| color == palette::PANEL.srgb());
    let bare = render(&copy, size, &["--layers", "none"]);
    let window = render(&copy, size, &["--layers", "none", "--window"]);
    // Two panels and two bars cover more than half of this picture; text is on a part of it.
    assert!(panel(&window) > 960 * 600 / 3, "{}", panel(&window));
    assert!(panel(&bare) < 960 * 600 / 100, "{}", panel(&bare));
}
