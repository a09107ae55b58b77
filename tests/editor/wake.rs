//! The window can sleep.

use bevy::prelude::*;
use bevy_egui::{EguiInput, egui};
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
