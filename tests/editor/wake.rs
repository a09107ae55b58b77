//! The window can sleep.

use bevy::prelude::*;
use bevy_egui::{EguiInput, egui};
use std::time::Instant;
use trackwright_editor::runner::wake::WakePlugin;
use trackwright_editor::schedule::SchedulePlugin;

fn event_count(app: &App, entity: Entity) -> usize {
    app.world().get::<EguiInput>(entity).unwrap().events.len()
}

#[test]
fn modifiers_that_stay_the_same_are_reported_once() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SchedulePlugin, WakePlugin));
    let entity = app.world_mut().spawn(EguiInput::default()).id();
    let mut report = |modifiers, expected| {
        let mut input = app.world_mut().get_mut::<EguiInput>(entity).unwrap();
        input.events = vec![egui::Event::ModifiersChanged(modifiers)];
        app.update();
        assert_eq!(event_count(&app, entity), expected, "{modifiers:?}");
    };
    report(egui::Modifiers::SHIFT, 1);
    report(egui::Modifiers::SHIFT, 0);
    report(egui::Modifiers::NONE, 1);
    report(egui::Modifiers::NONE, 0);
}

/// A press and a release that are a moment apart are a click, however long the window rested.
#[test]
fn egui_reads_the_time_of_the_clock() {
    let start = Instant::now();
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SchedulePlugin, WakePlugin));
    let entity = app.world_mut().spawn(EguiInput::default()).id();
    let mut frame = || {
        // As the renderer left it: the time of a frame long ago.
        app.world_mut().get_mut::<EguiInput>(entity).unwrap().time = Some(-1000.0);
        app.update();
        app.world().get::<EguiInput>(entity).unwrap().time.unwrap()
    };
    let (press_s, release_s) = (frame(), frame());
    assert!(0.0 <= press_s && press_s <= release_s, "{press_s} {release_s}");
    assert!(release_s <= start.elapsed().as_secs_f64(), "{release_s}");
}
