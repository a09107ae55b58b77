//! The interface's style: set once, since a style set every frame requests the next frame.

use crate::palette::ThemedColor;
use crate::palette::{self, Theme};
use bevy_egui::egui::{
    self, Color32, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, Margin, Stroke,
    SurrenderFocusOn, TextStyle, Visuals, vec2,
};
use std::sync::Arc;

/// Height of the bar at the top, logical pixels.
pub const TOP_BAR_HEIGHT: f32 = 36.0;
/// Height of the status line.
pub const STATUS_BAR_HEIGHT: f32 = 22.0;
/// Height of the timeline of the Study workspace.
pub const TIMELINE_HEIGHT: f32 = 156.0;
/// The table of designs and rooms.
pub const TABLE_HEIGHT: f32 = 176.0;
/// The same before there is one.
pub const TABLE_HEAD_HEIGHT: f32 = 58.0;
/// Width of outliner and layers.
pub const LEFT_WIDTH: f32 = 240.0;
/// Width of inspector and result.
pub const RIGHT_WIDTH: f32 = 300.0;
/// Width of fit and figures in the Field workspace, where tables of numbers stand side by side.
pub const FIELD_WIDTH: f32 = 360.0;
/// From the edge of the left side to what is in it; of the right side.
pub const LEFT_MARGIN: i8 = 8;
pub const RIGHT_MARGIN: i8 = 12;
/// Height of a row that can be clicked.
pub const ROW_HEIGHT: f32 = 22.0;

const BODY_SIZE: f32 = 13.0;
const LABEL_SIZE: f32 = 11.0;
const FIGURE_SIZE: f32 = 28.0;
const CORNER: CornerRadius = CornerRadius::same(3);

/// Small, quiet text: units, captions, legends.
pub fn label_font() -> FontId {
    FontId::proportional(LABEL_SIZE)
}

/// Text of ordinary size.
pub fn body_font() -> FontId {
    FontId::proportional(BODY_SIZE)
}

/// The one large figure.
pub fn figure_font() -> FontId {
    FontId::proportional(FIGURE_SIZE)
}

/// Gives a context the program's style.
pub fn apply(ctx: &egui::Context) {
    ctx.set_theme(match Theme::now() {
        Theme::Dark => egui::Theme::Dark,
        Theme::Light => egui::Theme::Light,
    });
    ctx.set_fonts(fonts());
    ctx.all_styles_mut(|style| {
        style.text_styles = [
            (TextStyle::Small, label_font()),
            (TextStyle::Body, body_font()),
            (TextStyle::Button, body_font()),
            (TextStyle::Heading, figure_font()),
            (TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace)),
        ]
        .into();
        style.visuals = visuals();
        style.spacing.item_spacing = vec2(6.0, 4.0);
        style.spacing.button_padding = vec2(6.0, 2.0);
        style.spacing.interact_size = vec2(36.0, 20.0);
        style.spacing.menu_margin = Margin::same(6);
        style.spacing.window_margin = Margin::same(14);
        style.spacing.scroll = egui::style::ScrollStyle::thin();
        // A fading panel draws frames; a precision instrument answers at once.
        style.animation_time = 0.0;
        style.interaction.selectable_labels = false;
    });
    // A field is left when the button goes down elsewhere, not when it goes up: what was written is
    // in the design by then, and the same click does what it is for.
    ctx.options_mut(|options| {
        options.input_options.surrender_focus_on = SurrenderFocusOn::Presses;
    });
}

/// The program's own font before egui's, which have the signs that it lacks.
fn fonts() -> FontDefinitions {
    const ROBOTO: &[u8] = include_bytes!("../../../../assets/fonts/Roboto-Regular.ttf");
    let mut fonts = FontDefinitions::default();
    let name = "Roboto".to_owned();
    fonts.font_data.insert(name.clone(), Arc::new(FontData::from_static(ROBOTO)));
    fonts.families.entry(FontFamily::Proportional).or_default().insert(0, name);
    fonts
}

fn visuals() -> Visuals {
    let mut visuals = match Theme::now() {
        Theme::Dark => Visuals::dark(),
        Theme::Light => Visuals::light(),
    };
    visuals.override_text_color = None;
    visuals.weak_text_color = Some(palette::TEXT_QUIET.color32());
    visuals.panel_fill = palette::PANEL.color32();
    visuals.window_fill = palette::PANEL.color32();
    visuals.window_stroke = Stroke::new(1.0, palette::LINE.color32());
    visuals.window_corner_radius = CornerRadius::same(6);
    visuals.menu_corner_radius = CornerRadius::same(4);
    visuals.extreme_bg_color = palette::FIELD.color32();
    visuals.faint_bg_color = palette::WIDGET.color32();
    visuals.hyperlink_color = palette::ACCENT.color32();
    visuals.warn_fg_color = palette::MISSED.color32();
    visuals.error_fg_color = palette::ERROR.color32();
    visuals.selection.bg_fill = palette::ACCENT.color32_alpha(72);
    visuals.selection.stroke = Stroke::new(1.0, palette::TEXT_STRONG.color32());
    // A blinking cursor would wake the window twice a second.
    visuals.text_cursor.blink = false;
    let widgets = &mut visuals.widgets;
    for (state, fill, text) in [
        (&mut widgets.noninteractive, palette::PANEL, palette::TEXT),
        (&mut widgets.inactive, palette::WIDGET, palette::TEXT),
        (&mut widgets.hovered, palette::WIDGET_HOVERED, palette::TEXT_STRONG),
        (&mut widgets.active, palette::WIDGET_HOVERED, palette::TEXT_STRONG),
        (&mut widgets.open, palette::WIDGET, palette::TEXT_STRONG),
    ] {
        state.bg_fill = fill.color32();
        state.weak_bg_fill = fill.color32();
        state.bg_stroke = Stroke::NONE;
        state.fg_stroke = Stroke::new(1.0, text.color32());
        state.corner_radius = CORNER;
        state.expansion = 0.0;
    }
    visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, palette::LINE.color32());
    visuals.widgets.inactive.bg_stroke = Stroke::new(1.0, palette::LINE.color32());
    visuals.widgets.hovered.bg_stroke = Stroke::new(1.0, palette::TEXT_QUIET.color32());
    visuals.widgets.active.bg_stroke = Stroke::new(1.0, palette::ACCENT.color32());
    visuals
}

/// A frame without lines whose fill is the panel's.
pub fn panel_frame(margin: Margin) -> egui::Frame {
    egui::Frame::new().fill(palette::PANEL.color32()).inner_margin(margin)
}

/// The colour of a figure that is held against a requirement.
pub fn verdict_color(is_met: Option<bool>) -> Color32 {
    match is_met {
        Some(true) => palette::MET.color32(),
        Some(false) => palette::MISSED.color32(),
        None => palette::TEXT_STRONG.color32(),
    }
}
