//! Panels and dialogs by themselves: drawn and used without a window.

use bevy_egui::egui;
use egui_kittest::Harness;
use std::cell::RefCell;
use std::rc::Rc;
use trackwright_editor::shell::dialogs::{Dialog, DialogAnswer, OpenDialog, Outcome, dialog_ui};

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
