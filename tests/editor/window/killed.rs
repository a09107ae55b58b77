//! A program that is killed loses nothing that was on the screen a few seconds before.

use super::harness::Window;
use super::places::{in_inspector, in_outliner, tool_sensor};
use crate::editor::copied::Copied;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::path::Path;
use std::time::{Duration, Instant};
use trackwright::design::BodyRole;
use trackwright::store::{self, World};

/// How many times a program is killed: in each run few, and as many as this variable says where
/// somebody wants to be surer.
const KILLS_VARIABLE: &str = "TRACKWRIGHT_KILLS";
const KILLS: u64 = 3;

/// An edit that was shown so long ago has to be in the recovery file.
const PROMISED: Duration = Duration::from_secs(10);

/// A stream of edits lasts longer than what is promised, and by so much more at most.
const LONGER: Duration = Duration::from_secs(6);

/// Where the coordinate begins that tells which edit was the last, and its step: never again where
/// the file has it, since a design that is as it was saved needs no recovery.
const FIRST_MM: f64 = 73.0;
const STEP_MM: f64 = 0.5;

/// A stream of edits and when each was on the screen.
struct Stream {
    window: Window,
    field: [f64; 2],
    shown: Vec<(Instant, f64)>,
}

impl Stream {
    fn open(copy: &Copied, state: &Path) -> Self {
        let world = store::open_design(&copy.design).unwrap();
        let (selected, _) = tool_sensor(&world, "shaft");
        let mut window = Window::open_with_state(&copy.design, state);
        window.click(in_outliner(&world, "shaft"));
        Self {
            window,
            field: in_inspector(&world, Some(selected), "position z in mm"),
            shown: Vec::new(),
        }
    }

    fn edit(&mut self) {
        let z_mm = FIRST_MM + STEP_MM * self.shown.len() as f64;
        self.window.click(self.field);
        self.window.write(&format!("{z_mm}"));
        self.window.key("Return");
        self.shown.push((Instant::now(), z_mm));
    }
}

fn z_mm(world: &World) -> f64 {
    let body = world.document.design().body(BodyRole::Tool).unwrap();
    let shaft = body.rigid.sensors.iter().find(|s| s.name == "shaft");
    shaft.unwrap().position_in_body.z
}

fn recovered(state: &Path) -> Option<World> {
    let left = store::leftovers(&state.join("recovery")).unwrap();
    assert!(left.len() <= 1, "{left:?}");
    left.first().map(|leftover| leftover.open().unwrap())
}

#[test]
fn every_edit_that_was_on_the_screen_ten_seconds_before_a_kill_is_recovered() {
    let kills = std::env::var(KILLS_VARIABLE)
        .ok()
        .map_or(KILLS, |count| count.parse().unwrap());
    for seed in 0..kills {
        let copy = Copied::new("pointer-on-head");
        let state = tempfile::tempdir().unwrap();
        let mut stream = Stream::open(&copy, state.path());
        let part = ChaCha8Rng::seed_from_u64(seed).next_u32() as f64 / f64::from(u32::MAX);
        stream.edit();
        let end = Instant::now() + PROMISED + LONGER.mul_f64(part);
        while Instant::now() < end {
            stream.edit();
        }
        let Stream { window, shown, .. } = stream;
        // The window's end is a kill.
        drop(window);
        let killed = Instant::now();
        let promised = shown.iter().rev().find(|(at, _)| killed - *at >= PROMISED);
        let (_, promised_mm) = promised.expect("an edit that was shown so long ago");
        let world = recovered(state.path()).expect("a recovery file");
        assert!(z_mm(&world) >= *promised_mm - 1e-9, "seed {seed}");
        assert!(world.document.is_dirty());
    }
}

#[test]
fn the_next_start_offers_what_was_lost_and_shows_its_figures() {
    let copy = Copied::new("pointer-on-head");
    let state = tempfile::tempdir().unwrap();
    let mut stream = Stream::open(&copy, state.path());
    stream.edit();
    // Until the file is there: it is written a moment after the last edit.
    let start = Instant::now();
    while recovered_files(state.path()) == 0 {
        assert!(start.elapsed() < PROMISED, "no recovery file");
        stream.window.listen(Duration::from_millis(100));
    }
    let figures = stream.window.figures();
    drop(stream);

    let mut window = Window::open_with_state(&copy.design, state.path());
    assert_eq!(window.last("dialog"), Some("recover"));
    window.key("Return");
    assert_eq!(window.last("dialog"), Some("none"));
    assert_eq!(window.document("dirty"), "true");
    assert_eq!(window.figures(), figures);
    window.key("ctrl+s");
    assert_eq!(window.document("dirty"), "false");
    let saved = store::open_design(&copy.design).unwrap();
    assert!((z_mm(&saved) - FIRST_MM).abs() < 1e-9);
}

fn recovered_files(state: &Path) -> usize {
    let Ok(entries) = std::fs::read_dir(state.join("recovery")) else {
        return 0;
    };
    let names = entries.map(|entry| entry.unwrap().file_name());
    names
        .filter(|name| name.to_string_lossy().ends_with(".recovery.ron"))
        .count()
}
