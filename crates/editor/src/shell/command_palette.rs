//! Commands found by name, and the sheet of all keys.

use crate::palette;
use crate::palette::ThemedColor;
use crate::schedule::UiSystems;
use crate::shell::commands::{Availability, Command, CommandRegistry, Group, RunCommand};
use crate::shell::mouse::{MouseAction, MouseActions};
use crate::shell::requests::Requests;
use crate::widgets::basic::{quiet_ui, section_ui};
use crate::widgets::theme;
use crate::widgets::tooltip::Explain;
use bevy::input::keyboard::Key as PressedKey;
use bevy::prelude::*;
use bevy_egui::egui::{
    self, Align, Align2, Context, Grid, Id, Key, Layout, Modifiers, Response, RichText, ScrollArea,
    TextEdit, Ui, vec2,
};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

const WIDTH: f32 = 520.0;
const LIST_HEIGHT: f32 = 380.0;
const ROW_HEIGHT: f32 = 24.0;

/// Below the top bar, where the eye is anyway.
const DROP: f32 = 72.0;

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<CommandPages>()
        .init_resource::<MouseActions>()
        .add_systems(EguiPrimaryContextPass, pages.run_if(is_open).in_set(UiSystems::Dialogs));
}

fn is_open(pages: Res<CommandPages>) -> bool {
    pages.is_any_open()
}

fn pages(
    mut contexts: EguiContexts,
    mut pages: ResMut<CommandPages>,
    commands: Res<CommandRegistry>,
    mouse: Res<MouseActions>,
    available: Availability,
    mut requests: Requests<RunCommand>,
) -> Result {
    // Writing to the resource would mark it as changed in every frame.
    let pages = pages.bypass_change_detection();
    let situation = available.situation();
    let is_available = |command: &Command| situation.allows(command);
    let chosen =
        command_pages_ui(contexts.ctx_mut()?, pages, commands.all(), &mouse.0, is_available);
    requests.write_all(chosen.map(RunCommand));
    Ok(())
}

/// The palette and the sheet, of which one at most is open.
#[derive(Resource, Default)]
pub struct CommandPages {
    open: Option<Page>,
    /// What is searched for.
    text: String,
    /// Which of what was found Enter takes.
    chosen: usize,
    wants_focus: bool,
    /// Whether Enter was pressed before the field could have it.
    is_entered: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Page {
    Palette,
    Shortcuts,
}

impl CommandPages {
    pub fn show_palette(&mut self) {
        self.show(Page::Palette);
    }

    pub fn show_shortcuts(&mut self) {
        self.show(Page::Shortcuts);
    }

    /// What is searched for.
    pub fn text(&self) -> &str {
        &self.text
    }

    pub fn is_any_open(&self) -> bool {
        self.open.is_some()
    }

    /// Takes a key that was pressed after the one that opened the page, and before its field could have it.
    pub fn type_key(&mut self, key: &PressedKey) {
        if self.open.is_none() {
            return;
        }
        match key {
            PressedKey::Character(typed) => self.text.push_str(typed),
            PressedKey::Space => self.text.push(' '),
            PressedKey::Backspace => drop(self.text.pop()),
            PressedKey::Enter => self.is_entered = true,
            PressedKey::Escape => self.close(),
            _ => {}
        }
    }

    fn show(&mut self, page: Page) {
        *self = Self { open: Some(page), wants_focus: true, ..Self::default() };
    }

    fn close(&mut self) {
        *self = Self::default();
    }
}

/// The commands whose name, group or purpose has every word that is searched for, those first
/// whose name begins with it.
pub fn found<'a>(commands: &'a [Command], text: &str) -> Vec<&'a Command> {
    let text = text.to_lowercase();
    let words: Vec<&str> = text.split_whitespace().collect();
    let mut found: Vec<_> = commands
        .iter()
        .filter(|info| {
            let keys: String = info.keys.iter().map(|keys| format!(" {keys}")).collect();
            let all = format!("{} {} {}{keys}", info.name, info.group.name, info.about);
            let all = all.to_lowercase();
            words.iter().all(|word| all.contains(word))
        })
        .collect();
    let rank = |info: &Command| {
        let name = info.name.to_lowercase();
        if name.starts_with(text.trim()) {
            0
        } else if words.iter().all(|word| name.contains(word)) {
            1
        } else {
            2
        }
    };
    found.sort_by_key(|info| rank(info));
    found
}

/// Draws whichever page is open; the command that was chosen.
pub fn command_pages_ui(
    ctx: &Context,
    pages: &mut CommandPages,
    commands: &[Command],
    mouse: &[MouseAction],
    is_available: impl Fn(&Command) -> bool,
) -> Option<&'static str> {
    let page = pages.open?;
    let title = match page {
        Page::Palette => "All commands",
        Page::Shortcuts => "Keyboard and mouse",
    };
    let mut chosen = None;
    let area =
        egui::Modal::default_area(Id::new(title)).anchor(Align2::CENTER_TOP, vec2(0.0, DROP));
    let modal = egui::Modal::new(Id::new(title))
        .area(area)
        .backdrop_color(palette::SHADOW.color32_alpha(110))
        .show(ctx, |ui| {
            ui.set_width(WIDTH);
            match page {
                Page::Palette => chosen = palette_ui(ui, pages, commands, &is_available),
                Page::Shortcuts => shortcuts_ui(ui, pages, commands, mouse),
            }
        });
    if modal.should_close() || chosen.is_some() {
        pages.close();
    }
    chosen
}

fn search_ui(ui: &mut Ui, pages: &mut CommandPages, hint: &str) -> Response {
    let before = pages.text.clone();
    let field =
        ui.add(TextEdit::singleline(&mut pages.text).desired_width(f32::INFINITY).hint_text(hint));
    field.widget_info(|| {
        egui::WidgetInfo::labeled(egui::WidgetType::TextEdit, ui.is_enabled(), "search")
    });
    if pages.wants_focus {
        field.request_focus();
        pages.wants_focus = false;
    }
    if pages.text != before {
        pages.chosen = 0;
    }
    field
}

fn palette_ui(
    ui: &mut Ui,
    pages: &mut CommandPages,
    commands: &[Command],
    is_available: &impl Fn(&Command) -> bool,
) -> Option<&'static str> {
    // Before the field sees them: a single line has no use for them.
    let (up, down) = ui.input_mut(|input| {
        let mut pressed = |key| input.count_and_consume_key(Modifiers::NONE, key);
        (pressed(Key::ArrowUp), pressed(Key::ArrowDown))
    });
    let field = search_ui(ui, pages, "name of a command");
    let is_entered = std::mem::take(&mut pages.is_entered)
        || (field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)));
    let commands = found(commands, &pages.text);
    let last = commands.len().saturating_sub(1);
    pages.chosen = (pages.chosen + down).saturating_sub(up).min(last);
    let mut answer = None;
    ui.add_space(6.0);
    ScrollArea::vertical().max_height(LIST_HEIGHT).auto_shrink([false, true]).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        if commands.is_empty() {
            quiet_ui(ui, "no command has all of these words");
        }
        for (index, info) in commands.iter().enumerate() {
            let is_chosen = index == pages.chosen;
            let row = command_row_ui(ui, info, is_chosen, is_available(info));
            if is_chosen && (up > 0 || down > 0) {
                row.scroll_to_me(None);
            }
            if row.clicked() || (is_chosen && is_entered) {
                answer = Some(*info);
            }
        }
    });
    answer.filter(|command| is_available(command)).map(|command| command.name)
}

fn command_row_ui(ui: &mut Ui, info: &Command, is_chosen: bool, is_available: bool) -> Response {
    let color = match is_available {
        true => palette::TEXT,
        false => palette::TEXT_QUIET,
    };
    let button =
        egui::Button::selectable(is_chosen, RichText::new(info.name).color(color.color32()))
            .min_size(vec2(ui.available_width(), ROW_HEIGHT))
            .shortcut_text(info.shown_keys());
    ui.add(button).explained(info.about)
}

fn shortcuts_ui(
    ui: &mut Ui,
    pages: &mut CommandPages,
    commands: &[Command],
    mouse: &[MouseAction],
) {
    search_ui(ui, pages, "key, gesture or command");
    ui.add_space(6.0);
    let commands = found(commands, &pages.text);
    ScrollArea::vertical().max_height(LIST_HEIGHT).auto_shrink([false, true]).show(ui, |ui| {
        let mut groups: Vec<Group> = commands.iter().map(|info| info.group).collect();
        groups.sort();
        groups.dedup();
        for group in groups {
            let with_keys: Vec<_> = commands
                .iter()
                .filter(|info| info.group == group && !info.keys.is_empty())
                .collect();
            if with_keys.is_empty() {
                continue;
            }
            section_ui(ui, group.name);
            Grid::new(("shortcuts", group.name))
                .num_columns(2)
                .spacing([18.0, 4.0])
                .min_col_width(120.0)
                .show(ui, |ui| {
                    for info in with_keys {
                        keys_ui(ui, info);
                        ui.label(info.name).on_hover_text(info.about);
                        ui.end_row();
                    }
                });
        }
        mouse_ui(ui, mouse, &pages.text);
    });
    ui.add_space(6.0);
    ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
        quiet_ui(ui, "Esc closes");
    });
}

/// What the mouse does, as far as it has the words that are searched for.
fn mouse_ui(ui: &mut Ui, mouse: &[MouseAction], text: &str) {
    let text = text.to_lowercase();
    let is_found = |action: &&MouseAction| {
        let all = format!("mouse {} {}", action.gesture, action.effect).to_lowercase();
        text.split_whitespace().all(|word| all.contains(word))
    };
    let found: Vec<&MouseAction> = mouse.iter().filter(is_found).collect();
    if found.is_empty() {
        return;
    }
    section_ui(ui, "Mouse in the scene");
    for action in found {
        ui.label(RichText::new(action.gesture).color(palette::TEXT_STRONG.color32()));
        ui.indent(action.gesture, |ui| quiet_ui(ui, action.effect));
    }
}

fn keys_ui(ui: &mut Ui, info: &Command) {
    let keys: Vec<String> = info.keys.iter().map(ToString::to_string).collect();
    let text = RichText::new(keys.join(", ")).font(theme::body_font());
    ui.label(text.color(palette::TEXT_STRONG.color32()));
}
