//! Draws a sweep's rows: only those in view, of only the columns in view.

use crate::palette::{self, ThemedColor};
use crate::widgets::basic::{count, counted, decimal, quiet_ui, warning_ui};
use crate::widgets::theme;
use crate::widgets::tooltip::{Explain, button_ui};
use crate::workspaces::decide::sweep_table::state::{OpenSweep, SweepTableRequest};
use bevy_egui::egui::{
    self, Align, Align2, Color32, Id, Key, Layout, Painter, Rect, RichText, ScrollArea, Sense,
    Shape, Stroke, Ui, WidgetInfo, WidgetType, pos2, vec2,
};
use std::ops::Range;
use trackwright_formats::printable::printable;
use trackwright_sweep::{Cell, Column, Direction, PROBLEM};

const ROW_HEIGHT: f32 = 20.0;
const HEAD_HEIGHT: f32 = 24.0;
const PADDING: f32 = 8.0;
/// Of the triangle in the head of the column that rows are sorted by.
const MARK: f32 = 14.0;
const TEXT_WIDTH: f32 = 190.0;
const PROBLEM_WIDTH: f32 = 420.0;
const NUMBER_WIDTHS: [f32; 2] = [84.0, 260.0];
/// Longest name that a head shows whole; of others the end, in which they differ.
const MOST_CHARS: usize = 34;

/// Draws the table; `standing` is the row that the open design has.
pub fn sweep_table_ui(
    ui: &mut Ui,
    open: &OpenSweep,
    standing: Option<u64>,
) -> Vec<SweepTableRequest> {
    let mut requests = Vec::new();
    ui.add_space(4.0);
    head_ui(ui, open, standing, &mut requests);
    if open.is_outdated() {
        warning_ui(
            ui,
            "Files of the plan, or the program, changed since these rows were computed: a row that is shown may \
             have other figures",
        );
    }
    ui.add_space(4.0);
    let heads = Heads::of(ui, &open.columns);
    let order = (open.serial, open.orders);
    let id = Id::new("order of the sweep's rows");
    let is_new = ui.data(|data| data.get_temp::<(u64, u64)>(id) != Some(order));
    let mut area = ScrollArea::both().id_salt("rows of the sweep").auto_shrink(false);
    if is_new {
        ui.data_mut(|data| data.insert_temp(id, order));
        area = area.vertical_scroll_offset(0.0);
    }
    area.show_viewport(ui, |ui, viewport| {
        RowsInView::new(ui, open, &heads, viewport).ui(ui, &mut requests);
    });
    let is_over = ui.rect_contains_pointer(ui.min_rect());
    if standing.is_some() && is_over && ui.input(|input| input.key_pressed(Key::Escape)) {
        requests.push(SweepTableRequest::TakeBack);
    }
    requests
}

fn head_ui(
    ui: &mut Ui,
    open: &OpenSweep,
    standing: Option<u64>,
    requests: &mut Vec<SweepTableRequest>,
) {
    ui.horizontal(|ui| {
        ui.label(RichText::new("Sweep").strong().color(palette::TEXT_STRONG.color32()));
        ui.label(printable(&open.name).into_owned());
        quiet_ui(ui, size_words(open.rows, open.table.planned()));
        match (open.awaited_row, open.awaited_sorting, standing) {
            (Some(row), _, _) => quiet_ui(ui, format!("opening row {row}…")),
            (None, Some(_), _) => quiet_ui(ui, "sorting…"),
            (None, None, Some(row)) => quiet_ui(ui, format!("row {row} is in the scene")),
            (None, None, None) => quiet_ui(ui, "click a row to see its design"),
        };
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add_space(4.0);
            if button_ui(ui, "Close", "Closes the sweep; the design stays as it is").clicked() {
                requests.push(SweepTableRequest::Close);
            }
            let button = ui.add_enabled(standing.is_some(), egui::Button::new("Take back"));
            let button =
                button.explained("The design as it was before rows of the sweep were shown");
            if button.clicked() {
                requests.push(SweepTableRequest::TakeBack);
            }
            let button =
                ui.add_enabled(open.selected.is_some(), egui::Button::new("Open as design"));
            let button =
                button.explained("Opens the chosen row as a document of its own, not saved yet");
            if let (true, Some(row)) = (button.clicked(), open.selected) {
                requests.push(SweepTableRequest::OpenAsDesign(row));
            }
        });
    });
}

/// `1,000 of 20,000 rows` of a sweep that is not complete.
pub fn size_words(rows: u64, planned: u64) -> String {
    match rows < planned {
        true => format!("{} of {} rows", count(rows as usize), count(planned as usize)),
        false => counted(rows as usize, "row", "rows"),
    }
}

/// A cell as the table shows it.
pub fn cell_text(cell: &Cell) -> String {
    match cell {
        Cell::Nothing => String::new(),
        Cell::Text(text) => printable(text).into_owned(),
        Cell::Number(value) if value.fract() == 0.0 && value.abs() < 1e15 => decimal(*value, 0),
        Cell::Number(value) if value.abs() < 1e-3 || value.abs() >= 1e9 => {
            format!("{value:.3e}").replace('-', "\u{2212}")
        }
        Cell::Number(value) => decimal(*value, 3),
    }
}

/// `…sensors[0].position.z, mm`.
pub fn head_text(column: &Column) -> String {
    let name = &column.name;
    let chars = name.chars().count();
    let name = match chars > MOST_CHARS {
        false => name.clone(),
        true => {
            let end: String = name.chars().skip(chars + 1 - MOST_CHARS).collect();
            format!("…{}", end.trim_start_matches('.'))
        }
    };
    match column.unit.as_str() {
        "" => name,
        unit => format!("{name}, {unit}"),
    }
}

/// The columns' heads and where each column is.
struct Heads {
    texts: Vec<String>,
    /// The left sides, and the right one of the last.
    sides: Vec<f32>,
}

impl Heads {
    fn of(ui: &Ui, columns: &[Column]) -> Self {
        let texts: Vec<String> = columns.iter().map(head_text).collect();
        let mut sides = vec![0.0];
        let mut right = 0.0;
        for (column, text) in columns.iter().zip(&texts) {
            let font = theme::label_font();
            let galley = ui.painter().layout_no_wrap(text.clone(), font, Color32::WHITE);
            let width = galley.size().x + 2.0 * PADDING + MARK;
            right += match (column.name == PROBLEM, column.is_number) {
                (true, _) => PROBLEM_WIDTH,
                (false, true) => width.clamp(NUMBER_WIDTHS[0], NUMBER_WIDTHS[1]),
                (false, false) if column.is_text => width.max(TEXT_WIDTH),
                (false, false) => width,
            };
            sides.push(right);
        }
        Self { texts, sides }
    }

    fn width(&self) -> f32 {
        self.sides.last().copied().unwrap_or_default()
    }
}

/// What the viewport shows of the table.
struct RowsInView<'a> {
    open: &'a OpenSweep,
    heads: &'a Heads,
    /// The table's own left side on the screen.
    left: f32,
    /// Of what is seen of it.
    seen: Rect,
    first: u64,
    /// How far the first row is above the head's lower side: places of a million rows are beyond what a
    /// screen coordinate resolves.
    above: f32,
}

impl<'a> RowsInView<'a> {
    fn new(ui: &mut Ui, open: &'a OpenSweep, heads: &'a Heads, viewport: Rect) -> Self {
        let height = HEAD_HEIGHT as f64 + open.rows as f64 * f64::from(ROW_HEIGHT);
        ui.set_min_size(vec2(heads.width(), height as f32));
        let corner = ui.max_rect().min + viewport.min.to_vec2();
        let row = f64::from(ROW_HEIGHT);
        let first = (f64::from(viewport.min.y.max(0.0)) / row).floor();
        Self {
            open,
            heads,
            left: ui.max_rect().left(),
            seen: Rect::from_min_size(corner, viewport.size()),
            first: first as u64,
            above: (f64::from(viewport.min.y) - first * row) as f32,
        }
    }

    /// The rows' places.
    fn places(&self) -> Range<u64> {
        let height = (self.seen.height() - HEAD_HEIGHT + self.above).max(0.0);
        let end = self.first + (height / ROW_HEIGHT).ceil() as u64;
        self.first.min(self.open.rows)..end.min(self.open.rows)
    }

    /// The columns that are in view.
    fn columns(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.open.columns.len()).filter(|column| {
            let [left, right] = [0, 1].map(|side| self.left + self.heads.sides[column + side]);
            right >= self.seen.left() && left <= self.seen.right()
        })
    }

    fn ui(&self, ui: &mut Ui, requests: &mut Vec<SweepTableRequest>) {
        let places = self.places();
        if !self.open.page.has(&places) {
            requests.push(SweepTableRequest::View(places.clone()));
        }
        let below_head = Rect::from_min_max(
            pos2(self.seen.left(), self.seen.top() + HEAD_HEIGHT),
            self.seen.max,
        );
        let painter = ui.painter().with_clip_rect(ui.clip_rect().intersect(below_head));
        for place in places {
            let down = (place - self.first) as f32 * ROW_HEIGHT - self.above;
            let top = below_head.top() + down;
            let rect = Rect::from_min_size(
                pos2(self.seen.left(), top),
                vec2(self.seen.width(), ROW_HEIGHT),
            );
            self.row_ui(ui, &painter, (place, rect.intersect(below_head)), top, requests);
        }
        self.heads_ui(ui, requests);
    }

    fn row_ui(
        &self,
        ui: &Ui,
        painter: &Painter,
        (place, rect): (u64, Rect),
        top: f32,
        requests: &mut Vec<SweepTableRequest>,
    ) {
        let response = ui.interact(rect, ui.id().with(("row", place)), Sense::click());
        let Some(number) = self.open.row_number(place) else {
            let at = pos2(rect.left() + PADDING, top + ROW_HEIGHT / 2.0);
            let color = palette::TEXT_QUIET.color32();
            painter.text(at, Align2::LEFT_CENTER, "…", theme::body_font(), color);
            return;
        };
        let problem = self.open.problem(place);
        let is_selected = self.open.selected == Some(number);
        response.widget_info(|| {
            let name = format!("row {number}");
            WidgetInfo::selected(WidgetType::SelectableLabel, true, is_selected, name)
        });
        let fill = match (is_selected, response.hovered(), place.is_multiple_of(2)) {
            (true, _, _) => Some(ui.visuals().selection.bg_fill),
            (false, true, _) => Some(palette::WIDGET_HOVERED.color32()),
            (false, false, true) => Some(palette::WIDGET.color32_alpha(70)),
            (false, false, false) => None,
        };
        if let Some(fill) = fill {
            painter.rect_filled(rect, 0.0, fill);
        }
        let color = match problem {
            Some(_) => palette::ERROR.color32(),
            None => palette::TEXT.color32(),
        };
        for column in self.columns() {
            let Some(cell) = self.open.page.cell(column, place) else { continue };
            let text = cell_text(cell);
            if text.is_empty() {
                continue;
            }
            let inner = self.cell_rect(column, top, ROW_HEIGHT);
            let own = painter.with_clip_rect(painter.clip_rect().intersect(inner));
            let (at, align) = match self.open.columns[column].is_number {
                true => (inner.right_center(), Align2::RIGHT_CENTER),
                false => (inner.left_center(), Align2::LEFT_CENTER),
            };
            own.text(at, align, text, theme::body_font(), color);
        }
        let response = response.explained(match problem {
            Some(problem) => format!("Row {number} has no figures: {problem}"),
            None => format!("Gives the open design the numbers of row {number}"),
        });
        if response.clicked() {
            requests.push(SweepTableRequest::ShowRow(number));
        }
    }

    fn cell_rect(&self, column: usize, top: f32, height: f32) -> Rect {
        let [left, right] = [0, 1].map(|side| self.left + self.heads.sides[column + side]);
        Rect::from_min_max(pos2(left + PADDING, top), pos2(right - PADDING, top + height))
    }

    /// Over the rows, whose first one may be half above.
    fn heads_ui(&self, ui: &Ui, requests: &mut Vec<SweepTableRequest>) {
        let head = Rect::from_min_size(self.seen.min, vec2(self.seen.width(), HEAD_HEIGHT));
        let painter = ui.painter().with_clip_rect(ui.clip_rect().intersect(head));
        painter.rect_filled(head, 0.0, palette::PANEL.color32());
        let line = Stroke::new(1.0, palette::LINE.color32());
        painter.line_segment([head.left_bottom(), head.right_bottom()], line);
        let sorting = self.open.awaited_sorting.unwrap_or(self.open.sorting);
        for column in self.columns() {
            let inner = self.cell_rect(column, head.top(), HEAD_HEIGHT);
            let rect = inner.expand2(vec2(PADDING, 0.0)).intersect(head);
            let response = ui.interact(rect, ui.id().with(("head", column)), Sense::click());
            let own = &self.open.columns[column];
            response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, &own.name));
            let sorted = sorting.filter(|sorting| sorting.column == column);
            let color = match response.hovered() || sorted.is_some() {
                true => palette::TEXT_STRONG.color32(),
                false => palette::TEXT_QUIET.color32(),
            };
            let cell = painter.with_clip_rect(painter.clip_rect().intersect(rect));
            let mut right = inner.right();
            if let Some(sorted) = sorted {
                triangle(&cell, pos2(right - 4.0, inner.center().y), sorted.direction, color);
                right -= MARK;
            }
            let (at, align) = match own.is_number {
                true => (pos2(right, inner.center().y), Align2::RIGHT_CENTER),
                false => (inner.left_center(), Align2::LEFT_CENTER),
            };
            cell.text(at, align, &self.heads.texts[column], theme::label_font(), color);
            let unit = match own.unit.as_str() {
                "" => String::new(),
                unit => format!(" in {unit}"),
            };
            let about = match own.about {
                "" => String::new(),
                about => format!("{about}\n"),
            };
            let sorts = "Sorts the rows by it; once more the other way";
            if response.explained(format!("{}{unit}\n{about}{sorts}", own.name)).clicked() {
                requests.push(SweepTableRequest::SortBy(column));
            }
        }
    }
}

/// Points up where the smallest is first.
fn triangle(painter: &Painter, at: egui::Pos2, direction: Direction, color: Color32) {
    let up = match direction {
        Direction::Ascending => -3.0,
        Direction::Descending => 3.0,
    };
    let points = vec![at + vec2(0.0, up), at + vec2(4.0, -up), at + vec2(-4.0, -up)];
    painter.add(Shape::convex_polygon(points, color, Stroke::NONE));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_the_digits_that_are_read() {
        let text = |value| cell_text(&Cell::Number(value));
        for (value, expected) in [
            (0.0, "0"),
            (12.0, "12"),
            (-0.49162, "\u{2212}0.492"),
            (1234.5678, "1234.568"),
            (0.000_012_34, "1.234e\u{2212}5"),
            (1.5e12, "1500000000000"),
        ] {
            assert_eq!(text(value), expected);
        }
        assert_eq!(cell_text(&Cell::Nothing), "");
    }

    #[test]
    fn long_heads_keep_their_end_and_the_unit() {
        let column = |name: &str, unit: &str| Column {
            name: name.to_owned(),
            unit: unit.to_owned(),
            about: "",
            is_number: true,
            is_text: false,
        };
        assert_eq!(head_text(&column("position_rms", "mm")), "position_rms, mm");
        assert_eq!(head_text(&column("trials", "")), "trials");
        let long = head_text(&column("tool.body.sensors[\"shaft\"].position.z", "mm"));
        assert_eq!(long, "…body.sensors[\"shaft\"].position.z, mm");
        assert_eq!(size_words(1_000, 20_000), "1,000 of 20,000 rows");
        assert_eq!(size_words(1, 1), "1 row");
    }
}
