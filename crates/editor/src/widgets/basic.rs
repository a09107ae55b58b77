//! Widgets that several panels share: values with units, number fields, section heads, badges.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::theme;
use crate::widgets::tooltip::Explain;
use bevy_egui::egui::{
    self, Color32, DragValue, Id, Key, Pos2, Response, RichText, Sense, Shape, Stroke, StrokeKind,
    Ui, vec2,
};
use std::cell::RefCell;
use trackwright_formats::printable::printable;
use trackwright_formats::printable::printable_lines;
use trackwright_formats::typed_number::{self, NumberUnit};

/// Stands between a value and its unit.
pub const THIN_SPACE: char = '\u{2009}';
/// A true minus sign.
pub const MINUS: char = '\u{2212}';
/// The signs of a requirement that is met, and of one that is missed; egui's fonts have these two.
pub const MET_SIGN: char = '✔';
pub const MISSED_SIGN: char = '✖';
/// How a number is entered.
const ENTERING: &str = "Drag it, or click and type: a number, a sum, or one with a unit";
/// What a field shows that stands for values that differ.
pub const MIXED: &str = "mixed";
/// Width of the fields in rows of numbers.
pub const FIELD_WIDTH: f32 = 76.0;

/// `value` with so many decimals and a true minus sign; never a negative zero.
pub fn decimal(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| matches!(b, b'0' | b'.')) => rest.to_owned(),
        Some(rest) => format!("{MINUS}{rest}"),
        None => text,
    }
}

/// `0.49 mm`, `1.20°`: a thin space before the unit, none before a degree sign.
pub fn with_unit(value: &str, unit: &str) -> String {
    match unit {
        "" => value.to_owned(),
        "°" => format!("{value}°"),
        "deg" => format!("{value}°"),
        _ => format!("{value}{THIN_SPACE}{unit}"),
    }
}

/// A length in millimetres, two decimals.
pub fn length(value_mm: f64) -> String {
    with_unit(&decimal(value_mm, 2), "mm")
}

/// `3,375`.
pub fn count(value: usize) -> String {
    let digits = value.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A factor: `50`, `0.5`, `10,000`.
pub fn times(times: f64) -> String {
    if times >= 1.0 && times.fract() == 0.0 && times < 1e9 {
        count(times as usize)
    } else {
        format!("{times}")
    }
}

/// `1 trial`, `3,375 trials`.
pub fn counted(value: usize, one: &str, many: &str) -> String {
    format!("{} {}", count(value), if value == 1 { one } else { many })
}

/// A change with its sign: `−0.08`, `+0.31`. What rounds to nothing has none, `0.00`: a ± stands
/// before what a figure is uncertain by, and before nothing else.
pub fn signed(value: f64, decimals: usize) -> String {
    let text = decimal(value, decimals);
    match text.starts_with(MINUS) || is_zero(&text) {
        true => text,
        false => format!("+{text}"),
    }
}

/// Whether a decimal has no digit but zeros.
pub fn is_zero(text: &str) -> bool {
    text.bytes().all(|b| matches!(b, b'0' | b'.'))
}

/// What a number field takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NumberChange {
    /// The pointer began to drag the value: open an undo step.
    Begin,
    /// The value is now this.
    Set(f64),
    /// The pointer let go: close the undo step.
    Commit,
}

/// What a number field shows and allows.
#[derive(Clone, Copy, Debug)]
pub struct NumberField<'a> {
    /// For people who cannot see the field, and for tests.
    pub name: &'a str,
    /// What it is, in a sentence; empty where the name states it.
    pub about: &'a str,
    pub unit: &'static str,
    pub decimals: usize,
    /// Change of the value a pixel of dragging.
    pub speed: f64,
    pub min: f64,
    pub max: f64,
    pub width: f32,
}

impl<'a> NumberField<'a> {
    /// A length in millimetres.
    pub fn length(name: &'a str) -> Self {
        Self {
            name,
            about: "",
            unit: "mm",
            decimals: 2,
            speed: 0.1,
            min: -1e6,
            max: 1e6,
            width: FIELD_WIDTH,
        }
    }

    /// An angle in degrees.
    pub fn angle(name: &'a str) -> Self {
        Self { unit: "°", speed: 0.5, min: -360.0, max: 360.0, ..Self::length(name) }
    }

    /// A number without a unit.
    pub fn plain(name: &'a str) -> Self {
        Self { unit: "", decimals: 3, speed: 0.01, min: -1.0, max: 1.0, ..Self::length(name) }
    }

    /// With what it is, in a sentence.
    pub fn about(self, about: &'a str) -> Self {
        Self { about, ..self }
    }

    /// What it is, and how a number is entered.
    fn tooltip(&self) -> String {
        let about = if self.about.is_empty() { self.name } else { self.about };
        let mut letters = about.chars();
        let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
        format!("{first}{}. {ENTERING}", letters.as_str())
    }

    pub fn positive(self) -> Self {
        Self { min: 0.0, ..self }
    }

    pub fn width(self, width: f32) -> Self {
        Self { width, ..self }
    }

    /// What is typed without a unit is in this one.
    fn number_unit(&self) -> NumberUnit {
        match self.unit {
            "mm" => NumberUnit::Millimetre,
            "°" => NumberUnit::Degree,
            _ => NumberUnit::Plain,
        }
    }

    /// What is typed into the field, in its unit; why not, in words.
    fn read(&self, text: &str) -> Result<f64, String> {
        let value =
            typed_number::parse(text, self.number_unit()).map_err(|error| error.words(text))?;
        if (self.min..=self.max).contains(&value) {
            return Ok(value);
        }
        let bound = |value: f64| {
            // As many decimals as the bound has: whole ones, mostly.
            let text = value.to_string().replace('-', &MINUS.to_string());
            with_unit(&text, self.unit)
        };
        Err(format!(
            "found {}, expected {} to {}",
            with_unit(&decimal(value, self.decimals), self.unit),
            bound(self.min),
            bound(self.max)
        ))
    }
}

/// A number that can be typed or dragged. A typed number is one change; a drag is many between
/// a `Begin` and a `Commit`. A number left as it was shown is no change: the field shows fewer
/// digits than the value has.
///
/// What is typed may be an expression with units, see [`typed_number::parse`]. A text that is no
/// number leaves the value as it is; the reason is shown below the field until the next key or
/// click. Escape leaves the field with the value that it had.
///
/// `None` stands for values that differ: the field shows that, can be typed in and not dragged.
pub fn number_ui(
    ui: &mut Ui,
    field: &NumberField,
    value: impl Into<Option<f64>>,
) -> Vec<NumberChange> {
    let mut changes = Vec::new();
    let own: Option<f64> = value.into();
    // What is typed is another number than this one.
    let value = own.unwrap_or(f64::INFINITY);
    let mut edited = value;
    let decimals = field.decimals;
    let suffix = own.map_or_else(String::new, |_| with_unit("", field.unit));
    let speed = own.map_or(0.0, |_| field.speed);
    let refusal = RefCell::new(None);
    let text_of = move |value: f64| match value.is_finite() {
        true => decimal(value, decimals),
        false => MIXED.to_owned(),
    };
    let shown = text_of(value);
    let is_given_up = is_just_given_up(ui);
    let read = |text: &str| {
        if is_given_up || text.trim() == shown {
            return None;
        }
        let read = field.read(text);
        read.map_err(|why| *refusal.borrow_mut() = Some(why)).ok()
    };
    let response = ui
        .scope(|ui| {
            ui.spacing_mut().interact_size.x = field.width;
            ui.add_sized(
                vec2(field.width, ui.spacing().interact_size.y),
                DragValue::new(&mut edited)
                    .speed(speed)
                    .range(field.min..=field.max)
                    .clamp_existing_to_range(false)
                    .suffix(suffix)
                    .update_while_editing(false)
                    .max_decimals(decimals)
                    .custom_formatter(move |v, _| text_of(v))
                    .custom_parser(read),
            )
        })
        .inner;
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_label(field.name.to_owned());
    });
    let is_refused = refusal.borrow().is_some();
    let response = match response.has_focus() || is_refused {
        // The reason for a refusal stands there.
        true => response,
        false => response.explained(field.tooltip()),
    };
    if own.is_some() && response.drag_started() {
        changes.push(NumberChange::Begin);
    }
    if response.changed() && edited.is_finite() && edited != value {
        changes.push(NumberChange::Set(edited));
    }
    if own.is_some() && response.drag_stopped() {
        changes.push(NumberChange::Commit);
    }
    refusal_ui(ui, &response, refusal.into_inner());
    changes
}

/// A number that is part of no document: what it was set to.
pub fn typed_number_ui(ui: &mut Ui, field: &NumberField, value: f64) -> Option<f64> {
    let changes = number_ui(ui, field, value);
    changes.into_iter().rev().find_map(|change| match change {
        NumberChange::Set(value) => Some(value),
        NumberChange::Begin | NumberChange::Commit => None,
    })
}

/// Whether Escape was pressed in this pass or the one before. egui takes a field for left in both, and
/// reads in the second what was typed into it.
fn is_just_given_up(ui: &Ui) -> bool {
    let (id, now) = (Id::new("pass of the last Escape"), ui.ctx().cumulative_pass_nr());
    if ui.input(|input| input.key_pressed(Key::Escape)) {
        ui.data_mut(|data| data.insert_temp(id, now));
    }
    ui.data(|data| data.get_temp::<u64>(id)).is_some_and(|pass| pass + 1 >= now)
}

/// Shows why what was typed is no number, until the next key or click.
fn refusal_ui(ui: &Ui, response: &Response, new: Option<String>) {
    let id = response.id.with("refusal");
    let is_pressed = |event: &egui::Event| {
        matches!(
            event,
            egui::Event::Key { pressed: true, .. }
                | egui::Event::PointerButton { pressed: true, .. }
        )
    };
    if let Some(why) = new {
        ui.data_mut(|data| data.insert_temp(id, why));
    } else if ui.input(|input| input.events.iter().any(is_pressed)) {
        ui.data_mut(|data| data.remove::<String>(id));
    }
    let Some(why) = ui.data(|data| data.get_temp::<String>(id)) else {
        return;
    };
    let stroke = Stroke::new(1.0, palette::ERROR.color32());
    ui.painter().rect_stroke(response.rect, 3.0, stroke, StrokeKind::Inside);
    response.show_tooltip_text(why);
}

/// The head of a section: small, quiet, with a line above all but the first.
pub fn section_ui(ui: &mut Ui, title: &str) {
    ui.add_space(8.0);
    ui.label(
        RichText::new(printable(title))
            .font(theme::label_font())
            .color(palette::TEXT_QUIET.color32()),
    );
    ui.add_space(1.0);
}

/// Small, quiet text.
pub fn quiet_ui(ui: &mut Ui, text: impl Into<String>) -> Response {
    ui.label(
        RichText::new(printable_lines(&text.into()))
            .font(theme::label_font())
            .color(palette::TEXT_QUIET.color32()),
    )
}

/// A name in quiet letters and its value at the right end.
pub fn fact_ui(ui: &mut Ui, name: &str, value: &str) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(name).color(palette::TEXT_QUIET.color32()));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.add(egui::Label::new(printable(value)).truncate());
        });
    });
}

/// A button for the one thing that a section is about.
pub fn main_button(text: &str) -> egui::Button<'_> {
    egui::Button::new(RichText::new(text).color(palette::TEXT_STRONG.color32()))
        .fill(palette::ACCENT.color32_alpha(90))
        .min_size(vec2(0.0, 24.0))
}

/// A line that states the state of something, its colour how good that is.
pub fn state_ui(ui: &mut Ui, text: &str, color: palette::Rgb) {
    ui.add(egui::Label::new(RichText::new(text).color(color.color32())).wrap());
}

/// A warning in words, with a sign before it.
pub fn warning_ui(ui: &mut Ui, text: &str) -> Response {
    let color = palette::MISSED.color32();
    ui.add(
        egui::Label::new(RichText::new(format!("⚠ {}", printable_lines(text))).color(color)).wrap(),
    )
}

/// A name that may be long, with its first letters.
pub fn short_name(name: &str, most_chars: usize) -> String {
    let name = printable(name);
    match name.chars().count() > most_chars {
        false => name.into_owned(),
        true => {
            let kept: String = name.chars().take(most_chars - 1).collect();
            format!("{}…", kept.trim_end())
        }
    }
}

/// What a row of a list looks like.
#[derive(Clone, Debug, Default)]
pub struct Row<'a> {
    pub label: &'a str,
    /// Quiet text at the right end.
    pub note: &'a str,
    pub indent: usize,
    pub is_selected: bool,
    pub is_hovered: bool,
    /// A mark before the label.
    pub mark: Option<(Mark, Color32)>,
    pub note_color: Option<Color32>,
}

/// What stands before a row's label; drawn, since fonts differ in what they have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    Square,
    /// A marker.
    Ball,
    /// A sensor of one axis.
    Dot,
    /// A sensor of three axes.
    Ring,
    Diamond,
    OpenDiamond,
    Plus,
}

impl Mark {
    fn paint(self, painter: &egui::Painter, at: Pos2, color: Color32) {
        let stroke = Stroke::new(1.5, color);
        let diamond = |half: f32| {
            vec![
                at - vec2(0.0, half),
                at + vec2(half, 0.0),
                at + vec2(0.0, half),
                at - vec2(half, 0.0),
            ]
        };
        match self {
            Self::Square => {
                let rect = egui::Rect::from_center_size(at, vec2(9.0, 9.0));
                painter.rect_filled(rect, 2.0, color);
            }
            Self::Ball => {
                painter.circle_stroke(at, 4.0, stroke);
            }
            Self::Dot => {
                painter.circle_filled(at, 3.5, color);
            }
            Self::Ring => {
                painter.circle_filled(at, 1.5, color);
                painter.circle_stroke(at, 4.0, stroke);
            }
            Self::Diamond => {
                painter.add(Shape::convex_polygon(diamond(4.5), color, Stroke::NONE));
            }
            Self::OpenDiamond => {
                painter.add(Shape::closed_line(diamond(4.0), stroke));
            }
            Self::Plus => {
                for half in [vec2(3.5, 0.0), vec2(0.0, 3.5)] {
                    painter.line_segment([at - half, at + half], stroke);
                }
            }
        }
    }
}

const INDENT: f32 = 14.0;
const MARK_WIDTH: f32 = 16.0;
/// Between a row's name and its note.
const NOTE_GAP: f32 = 6.0;
/// The part of a row that its note may have however long the name is.
const LEAST_NOTE: f32 = 0.3;

/// A row that can be clicked, as wide as the panel. What has no room ends in an ellipsis, and a tooltip has
/// all of it.
pub fn row_ui(ui: &mut Ui, row: &Row) -> Response {
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width(), theme::ROW_HEIGHT), Sense::click());
    let label = printable(row.label);
    response.widget_info(|| {
        egui::WidgetInfo::selected(
            egui::WidgetType::SelectableLabel,
            ui.is_enabled(),
            row.is_selected,
            &label,
        )
    });
    if !ui.is_rect_visible(rect) {
        return response;
    }
    let fill = if row.is_selected {
        Some(ui.visuals().selection.bg_fill)
    } else if response.hovered() || row.is_hovered {
        Some(palette::WIDGET_HOVERED.color32())
    } else {
        None
    };
    if let Some(fill) = fill {
        ui.painter().rect_filled(rect, 3.0, fill);
    }
    let mut x = rect.left() + 6.0 + row.indent as f32 * INDENT;
    if let Some((mark, color)) = row.mark {
        let at = egui::pos2(x + MARK_WIDTH / 2.0 - 3.0, rect.center().y);
        mark.paint(ui.painter(), at, color);
        x += MARK_WIDTH;
    }
    let text_color = if row.is_selected { palette::TEXT_STRONG } else { palette::TEXT };
    let line = |text: String, font, color: Color32, width: f32| {
        let mut job = egui::text::LayoutJob::simple_singleline(text, font, color);
        job.wrap = egui::text::TextWrapping::truncate_at_width(width.max(8.0));
        ui.painter().layout_job(job)
    };
    let body = |width| line(label.to_string(), theme::body_font(), text_color.color32(), width);
    let room = rect.right() - 6.0 - x;
    // A name is shortened for a problem, not for what is noted beside it.
    let note_width = match row.note_color {
        Some(_) => room,
        None => (room - NOTE_GAP - body(f32::INFINITY).size().x).max(LEAST_NOTE * room),
    };
    let note_color = row.note_color.unwrap_or(palette::TEXT_QUIET.color32());
    let note = line(row.note.to_owned(), theme::label_font(), note_color, note_width);
    let note_left = rect.right() - 6.0 - note.size().x;
    let name = body(note_left - x - NOTE_GAP);
    let is_cut = name.elided || note.elided;
    let name_y = rect.center().y - name.size().y / 2.0;
    let note_y = rect.center().y - note.size().y / 2.0;
    ui.painter().galley(egui::pos2(x, name_y), name, text_color.color32());
    ui.painter().galley(egui::pos2(note_left, note_y), note, text_color.color32());
    match is_cut {
        true => response.on_hover_text(format!("{label} {}", row.note).trim_end()),
        false => response,
    }
}

/// A text at the right end of its cell.
pub fn right_text_ui(ui: &mut Ui, text: &str, color: Color32) -> Response {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.label(RichText::new(text).color(color))
    })
    .inner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_true_minus_signs_and_no_negative_zero() {
        assert_eq!(decimal(-1.234, 2), "−1.23");
        assert_eq!(decimal(-0.001, 2), "0.00");
        assert_eq!(signed(-0.08, 2), "−0.08");
        assert_eq!(signed(0.31, 2), "+0.31");
        assert_eq!(signed(0.001, 2), "0.00");
        assert_eq!(signed(-0.001, 2), "0.00");
    }

    #[test]
    fn units_follow_a_thin_space_and_degrees_none() {
        assert_eq!(length(0.49), "0.49\u{2009}mm");
        assert_eq!(with_unit("1.20", "°"), "1.20°");
    }

    #[test]
    fn counts_have_separators() {
        assert_eq!(count(7), "7");
        assert_eq!(count(3375), "3,375");
        assert_eq!(count(1_000_000), "1,000,000");
        assert_eq!(counted(1, "trial", "trials"), "1 trial");
    }

    #[test]
    fn number_fields_read_expressions_and_state_limits() {
        let length = NumberField::length("x");
        assert_eq!(length.read("−1,5 mm"), Ok(-1.5));
        assert_eq!(length.read("12.5+3"), Ok(15.5));
        assert_eq!(length.read("1 in"), Ok(25.4));
        assert!(length.read("12°").is_err());
        assert_eq!(length.read("a0"), Err("\"a0\" is not a number".to_owned()));
        assert_eq!(length.read(" twelve "), Err("\"twelve\" is not a number".to_owned()));
        let angle = NumberField::angle("rx");
        assert_eq!(angle.read(" 12.5° "), Ok(12.5));
        let turned = angle.read("0.2 rad").unwrap();
        assert!((turned - 0.2_f64.to_degrees()).abs() < 1e-12);
        assert_eq!(angle.read("361"), Err("found 361.00°, expected −360° to 360°".to_owned()));
        assert_eq!(NumberField::plain("axis x").read("3/5"), Ok(0.6));
    }
}
