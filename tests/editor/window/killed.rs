//! A program that is killed loses nothing that was on the screen a few seconds before.

use super::harness::{Turn, Window};
use super::places::{in_inspector, in_outliner, tool_sensor};
use crate::copied::Copied;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::path::Path;
use std::time::{Duration, Instant};
use trackwright_design::BodyRole;
use trackwright_project::World;

/// How many programs are killed, and how many of them run side by side: each spends most of its
/// time waiting for a hand.
const KILLS: u64 = 20;
const SIDE_BY_SIDE: u64 = 3;

/// An edit that was shown so long ago has to be in the recovery file.
const PROMISED: Duration = Duration::from_secs(10);

/// So often a place is typed before the field is taken to be deaf.
const ATTEMPTS: u32 = 10;

/// A stream of edits lasts longer than what is promised, and by so much more at most.
const LONGER: Duration = Duration::from_secs(6);

/// An edit reaches the disk within this: some kills are before, some within and some after that.
const MIDST: Duration = Duration::from_secs(1);

/// Where the coordinate begins that identifies the last edit, and its step: never again where
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
    fn open(turn: &Turn, copy: &Copied, state: &Path) -> Self {
        let world = trackwright_project::open_design(&copy.design).unwrap();
        let (selected, _) = tool_sensor(&world, "shaft");
        let mut window = Window::open_beside(turn, &copy.design, state);
        window.click(in_outliner(&world, "shaft"));
        Self {
            window,
            field: in_inspector(&world, Some(selected), "position z in mm"),
            shown: Vec::new(),
        }
    }

    /// Types the next place, millimetres.
    fn begin(&mut self) -> f64 {
        let z_mm = FIRST_MM + STEP_MM * self.shown.len() as f64;
        self.window.click(self.field);
        self.window.write(&format!("{z_mm}"));
        self.window.xdotool(&["key", "Return"]);
        z_mm
    }

    /// Types the next place; it counts once the window has drawn it. On a busy machine a field may
    /// not have received the click before the digits come: whoever sees that types them again.
    fn edit(&mut self) {
        let before = self.window.document("revision").to_owned();
        for _ in 0..ATTEMPTS {
            let z_mm = self.begin();
            if self.window.is_edited(&before, PROMISED / 2) {
                self.shown.push((Instant::now(), z_mm));
                return;
            }
        }
        panic!("the field takes nothing of what is typed");
    }
}

fn z_mm(world: &World) -> f64 {
    let body = world.document.design().body(BodyRole::Tool).unwrap();
    let shaft = body.rigid.sensors.iter().find(|s| s.name == "shaft");
    shaft.unwrap().position_in_body.z
}

fn recovered(state: &Path) -> Option<World> {
    let left = trackwright_project::leftovers(&state.join("recovery")).unwrap();
    assert!(left.len() <= 1, "{left:?}");
    left.first().map(|leftover| leftover.open().unwrap())
}

/// Edits until a moment that the seed chooses, and kills the program there. Where the shaft's sensor
/// was on the screen ten seconds before.
fn promised_mm(turn: &Turn, copy: &Copied, state: &Path, seed: u64) -> f64 {
    let mut stream = Stream::open(turn, copy, state);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let [longer, midst] = [LONGER, MIDST].map(|most| {
        let part = f64::from(random.next_u32()) / f64::from(u32::MAX);
        most.mul_f64(part)
    });
    stream.edit();
    let end = Instant::now() + PROMISED + longer;
    while Instant::now() < end {
        stream.edit();
    }
    stream.begin();
    let moment = Instant::now() + midst;
    let Stream { mut window, shown, .. } = stream;
    while window.next_line(moment - Instant::now()).is_some() {}
    // The window's end is a kill.
    drop(window);
    let killed = Instant::now();
    let promised = shown.iter().rev().find(|(at, _)| killed - *at >= PROMISED);
    promised.expect("an edit that was shown so long ago").1
}

#[test]
#[ignore = "long: twenty kills"]
fn long_kills_lose_at_most_ten_seconds() {
    let turn = Turn::wait();
    std::thread::scope(|scope| {
        for first in 0..SIDE_BY_SIDE {
            let turn = &turn;
            scope.spawn(move || {
                for seed in (first..KILLS).step_by(SIDE_BY_SIDE as usize) {
                    let copy = Copied::new("pointer-on-head");
                    let state = tempfile::tempdir().unwrap();
                    let promised_mm = promised_mm(turn, &copy, state.path(), seed);
                    let world = recovered(state.path()).expect("a recovery file");
                    assert!(z_mm(&world) >= promised_mm - 1e-9, "seed {seed}");
                    assert!(world.document.is_dirty());
                }
            });
        }
    });
}

#[test]
#[ignore = "long: edits for ten seconds"]
fn long_kill_without_a_recovery_file_loses_all() {
    let copy = Copied::new("pointer-on-head");
    let state = tempfile::tempdir().unwrap();
    let folder = state.path().join("recovery");
    // No folder can be made there: autosave is off.
    std::fs::write(&folder, "").unwrap();
    promised_mm(&Turn::wait(), &copy, state.path(), 0);
    std::fs::remove_file(&folder).unwrap();
    assert!(recovered(state.path()).is_none());
}

#[test]
fn the_next_start_offers_what_was_lost() {
    let copy = Copied::new("pointer-on-head");
    let state = tempfile::tempdir().unwrap();
    let turn = Turn::wait();
    let mut stream = Stream::open(&turn, &copy, state.path());
    stream.edit();
    // Until the file is there: it is written a moment after the last edit.
    let start = Instant::now();
    while recovered_files(state.path()) == 0 {
        assert!(start.elapsed() < PROMISED, "no recovery file");
        stream.window.listen(Duration::from_millis(100));
    }
    let figures = stream.window.figures();
    drop(stream);

    let mut window = Window::open_beside(&turn, &copy.design, state.path());
    assert_eq!(window.last("dialog"), Some("recover"));
    window.key("Return");
    assert_eq!(window.last("dialog"), Some("none"));
    // What was lost is in the document a frame or more after its dialog has closed.
    let start = Instant::now();
    while window.document("dirty") != "true" {
        assert!(start.elapsed() < PROMISED, "nothing is recovered");
        window.listen(Duration::from_millis(100));
    }
    assert_eq!(window.figures(), figures);
    window.key("ctrl+s");
    assert_eq!(window.document("dirty"), "false");
    let saved = trackwright_project::open_design(&copy.design).unwrap();
    assert!((z_mm(&saved) - FIRST_MM).abs() < 1e-9);
}

fn recovered_files(state: &Path) -> usize {
    let Ok(entries) = std::fs::read_dir(state.join("recovery")) else {
        return 0;
    };
    let names = entries.map(|entry| entry.unwrap().file_name());
    names.filter(|name| name.to_string_lossy().ends_with(".recovery.ron")).count()
}
