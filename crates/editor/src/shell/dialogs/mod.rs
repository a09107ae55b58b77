//! Dialogs: questions, choices of files and errors that stand before everything else.
//!
//! Whoever opens a dialog has a type for it ([`Dialog`]) and gets the answer as a message of its
//! own.

pub mod file_dialog;
pub mod folder;

use crate::palette;
use crate::palette::ThemedColor;
use crate::schedule::UiSystems;
use crate::shell::dialogs::file_dialog::FileDialog;
use crate::widgets::basic::main_button;
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use bevy_egui::egui::{self, Align, Id, Label, Layout, RichText, Ui};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use std::any::Any;
use std::fmt::Debug;
use std::path::Path;

/// Width of all dialogs.
const WIDTH: f32 = 520.0;

/// A dialog and what was typed into it so far.
pub trait Dialog: Debug + Send + Sync + Sized + 'static {
    /// What its owner receives once it is answered.
    type Request: Message;

    /// What the dialog is about, in a few words; one with another name is another dialog.
    fn name(&self) -> &'static str;

    /// Draws the dialog.
    fn ui(&mut self, ui: &mut Ui) -> Option<DialogAnswer<Self>>;

    /// Where it chooses a file.
    fn files(&mut self) -> Option<&mut FileDialog> {
        None
    }

    /// The name, and an error's text.
    fn description(&self) -> String {
        self.name().to_owned()
    }
}

/// What a dialog came to.
#[derive(Clone, Debug, PartialEq)]
pub enum DialogAnswer<D: Dialog> {
    Close,
    Request(D::Request),
    Become(D),
}

/// The dialog that is open, if any.
#[derive(Resource, Default)]
pub struct Dialogs {
    pub current: Option<Box<dyn OpenDialog>>,
}

impl Dialogs {
    pub fn show(&mut self, dialog: impl Dialog) {
        self.current = Some(Box::new(dialog));
    }

    /// The dialog that is open, if it is one of these.
    pub fn get<D: Dialog>(&self) -> Option<&D> {
        self.current.as_ref()?.as_any().downcast_ref()
    }
}

/// A dialog of any owner.
pub trait OpenDialog: Debug + Send + Sync {
    fn name(&self) -> &'static str;
    fn files(&mut self) -> Option<&mut FileDialog>;
    fn description(&self) -> String;
    fn as_any(&self) -> &dyn Any;
    fn draw(&mut self, ui: &mut Ui) -> Option<Outcome>;
}

/// What becomes of a dialog, whoever owns it.
pub enum Outcome {
    Close,
    Become(Box<dyn OpenDialog>),
    Request(Box<dyn FnOnce(&mut Commands)>),
}

impl<D: Dialog> OpenDialog for D {
    fn name(&self) -> &'static str {
        Dialog::name(self)
    }

    fn files(&mut self) -> Option<&mut FileDialog> {
        Dialog::files(self)
    }

    fn description(&self) -> String {
        Dialog::description(self)
    }

    fn as_any(&self) -> &dyn Any {
        self
    }

    fn draw(&mut self, ui: &mut Ui) -> Option<Outcome> {
        Some(match self.ui(ui)? {
            DialogAnswer::Close => Outcome::Close,
            DialogAnswer::Become(dialog) => Outcome::Become(Box::new(dialog)),
            DialogAnswer::Request(request) => {
                Outcome::Request(Box::new(move |commands: &mut Commands| {
                    commands.write_message(request);
                }))
            }
        })
    }
}

/// What could not be done, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ErrorDialog {
    pub title: String,
    pub text: String,
}

/// There is nothing to request.
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub enum NoRequest {}

impl ErrorDialog {
    /// What went wrong, in the words of the command line.
    pub fn new(title: &str, error: &dyn std::error::Error) -> Self {
        let mut text = error.to_string();
        let mut source = error.source();
        while let Some(cause) = source {
            let cause_text = cause.to_string();
            // A transparent cause is in the text already.
            if !text.contains(&cause_text) {
                text = format!("{text}: {cause_text}");
            }
            source = cause.source();
        }
        Self { title: title.to_owned(), text }
    }
}

impl Dialog for ErrorDialog {
    type Request = NoRequest;

    fn name(&self) -> &'static str {
        "error"
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<DialogAnswer<Self>> {
        title_ui(ui, &self.title);
        ui.add(Label::new(self.text.as_str()).wrap().selectable(true));
        buttons_ui(ui, &[("OK", DialogAnswer::Close)])
    }

    fn description(&self) -> String {
        format!("error {}: {}", self.title, self.text)
    }
}

/// Owns the dialog that is open.
pub struct DialogsPlugin;

impl Plugin for DialogsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Dialogs>();
    }
}

pub(crate) fn plugin(app: &mut App) {
    app.add_systems(EguiPrimaryContextPass, draw.in_set(UiSystems::Dialogs));
}

fn draw(
    mut contexts: EguiContexts,
    mut dialogs: ResMut<Dialogs>,
    mut commands: Commands,
) -> Result {
    let ctx = contexts.ctx_mut()?;
    // Writing to the resource would mark it as changed in every frame.
    let open = dialogs.bypass_change_detection();
    let Some(dialog) = &mut open.current else {
        return Ok(());
    };
    let Some(outcome) = dialog_ui(ctx, dialog.as_mut()) else { return Ok(()) };
    commands.write_message(RequestRedraw);
    open.current = match outcome {
        Outcome::Close => None,
        Outcome::Become(dialog) => Some(dialog),
        Outcome::Request(write) => {
            write(&mut commands);
            None
        }
    };
    Ok(())
}

/// Draws a dialog before everything else; Escape and a click beside it close it.
pub fn dialog_ui(ctx: &egui::Context, dialog: &mut dyn OpenDialog) -> Option<Outcome> {
    // egui keeps the size of what it has seen: a short question is no list of files.
    let modal = egui::Modal::new(Id::new(("dialog", dialog.name())))
        .backdrop_color(palette::SHADOW.color32_alpha(140))
        .show(ctx, |ui| dialog.draw(ui));
    let is_closed = modal.should_close();
    modal.inner.or(is_closed.then_some(Outcome::Close))
}

/// The heading, which makes the dialog as wide as all are.
pub fn title_ui(ui: &mut Ui, title: &str) {
    ui.set_width(WIDTH);
    ui.label(RichText::new(title).strong().color(palette::TEXT_STRONG.color32()));
    ui.add_space(6.0);
}

pub fn text_ui(ui: &mut Ui, text: impl Into<String>) {
    ui.add(Label::new(text.into()).wrap());
}

/// Buttons at the right, the first the one that Enter presses, which stands out.
pub fn buttons_ui<A: Clone>(ui: &mut Ui, buttons: &[(&str, A)]) -> Option<A> {
    let mut answer = None;
    ui.add_space(12.0);
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        for (index, (text, then)) in buttons.iter().enumerate().rev() {
            let is_default = index == 0;
            let response = match is_default {
                true => ui.add(main_button(text)),
                false => ui.button(*text),
            };
            if is_default && ui.memory(|m| m.focused().is_none()) {
                response.request_focus();
            }
            if response.clicked() {
                answer = Some(then.clone());
            }
        }
    });
    answer
}

/// Confirms that a file is written over.
pub fn overwrite_ui<D: Dialog<Request: Clone> + Clone>(
    ui: &mut Ui,
    file: &Path,
    then: D::Request,
) -> Option<DialogAnswer<D>> {
    title_ui(ui, "Replace the file?");
    text_ui(ui, format!("{} exists already", file.display()));
    let replace = ("Replace", DialogAnswer::Request(then));
    buttons_ui(ui, &[replace, ("Cancel", DialogAnswer::Close)])
}
