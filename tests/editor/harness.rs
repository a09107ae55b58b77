//! Panels and dialogs by themselves: drawn and used without a window.

use bevy::app::App;
use bevy_egui::egui;
use bevy_egui::egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::NodeT;
use std::cell::RefCell;
use std::rc::Rc;
use trackwright_editor::shell::dialogs::{Dialog, DialogAnswer, OpenDialog, Outcome, dialog_ui};
use trackwright_editor::shell::registry::Panels;
use trackwright_editor::shell::window::Workspace;

/// What a panel requested in all its frames.
pub type Requests<T> = Rc<RefCell<Vec<T>>>;

/// A panel of a size, and what it requests.
pub fn panel<'a, R: IntoIterator + 'a>(
    size: [f32; 2],
    mut panel: impl FnMut(&mut egui::Ui) -> R + 'a,
) -> (Harness<'a>, Requests<R::Item>) {
    let requests = Requests::default();
    let sink = Rc::clone(&requests);
    let harness = Harness::builder().with_size(egui::Vec2::from(size)).build_ui(move |ui| {
        trackwright_editor::widgets::theme::apply(ui.ctx());
        sink.borrow_mut().extend(panel(ui));
    });
    (harness, requests)
}

/// What a panel requests while it is used.
pub fn use_panel<R: IntoIterator>(
    size: [f32; 2],
    panel: impl FnMut(&mut egui::Ui) -> R,
    act: impl FnOnce(&mut Harness),
) -> Vec<R::Item> {
    let (mut harness, requests) = self::panel(size, panel);
    harness.run_steps(2);
    act(&mut harness);
    harness.run_steps(3);
    drop(harness);
    requests.take()
}

/// Checks that no widget or label of a panel lies over another, or beyond its sides.
pub fn assert_nothing_overlaps(harness: &Harness, width: f32, least_count: usize) {
    let is_widget = |role| {
        matches!(
            role,
            Role::Button | Role::CheckBox | Role::SpinButton | Role::ComboBox | Role::Label
        )
    };
    let nodes = harness.root().children_recursive();
    let seen: Vec<(String, egui::Rect)> = nodes
        .filter(|node| is_widget(node.accesskit_node().role()))
        .map(|node| (node.accesskit_node().label().unwrap_or_default(), node.rect()))
        .collect();
    assert!(seen.len() > least_count, "{seen:?}");
    for (k, (name, rect)) in seen.iter().enumerate() {
        assert!(rect.left() >= 0.0 && rect.right() <= width, "{name}: {rect:?}");
        for (other, beside) in &seen[k + 1..] {
            let common = rect.intersect(*beside).shrink(0.5);
            assert!(!common.is_positive(), "{name} {rect:?}, {other} {beside:?}");
        }
    }
}

/// The first answer of a dialog while it is used.
pub fn use_dialog<D: Dialog>(
    mut dialog: D,
    act: impl FnOnce(&mut Harness),
) -> Option<DialogAnswer<D>> {
    use_panel([620.0, 500.0], |ui| dialog.ui(ui), act).into_iter().next()
}

/// What becomes of a dialog that stands before everything else while it is used.
pub fn use_open_dialog(
    dialog: &mut dyn OpenDialog,
    act: impl FnOnce(&mut Harness),
) -> Option<Outcome> {
    use_panel([620.0, 500.0], |ui| dialog_ui(ui.ctx(), dialog), act).into_iter().next()
}

/// All panels of a workspace, one below the other, drawn twice; and what is done at the end of each pass.
pub fn workspace_panels<'a>(
    app: &'a mut App,
    workspace: Workspace,
    mut at_end: impl FnMut(&egui::Context) + 'a,
) -> Harness<'a> {
    *app.world_mut().resource_mut::<Workspace>() = workspace;
    app.update();
    let mut panels = app.world().resource::<Panels>().0.to_vec();
    panels.retain(|own| own.info.workspace == workspace.name);
    let world = app.world_mut();
    let mut harness = Harness::builder().with_size(egui::vec2(420.0, 4000.0)).build_ui(move |ui| {
        for panel in &panels {
            // One whose optional neighbours are absent draws nothing.
            let _ = world.run_system_with(panel.system, ui);
        }
        at_end(ui.ctx());
    });
    harness.run_steps(2);
    harness
}

/// Whether a widget of this role can be used.
pub fn is_usable(role: Role) -> bool {
    matches!(role, Role::Button | Role::CheckBox | Role::SpinButton | Role::ComboBox | Role::Slider)
}
