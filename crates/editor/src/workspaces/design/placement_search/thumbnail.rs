//! Where a layout's sensors are, small: the outline of each body with a dot for each sensor.

use crate::palette::{self, ThemedColor};
use crate::widgets::theme;
use crate::workspaces::design::placement_search::state::{AnswerId, SearchResult};
use bevy_egui::egui::{
    self, Color32, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, pos2, vec2,
};
use trackwright_design::BodyRole;
use trackwright_optimization::Layout;
use trackwright_report::drawing::BodyOutline;
use trackwright_simulation::RigidBody;

const HEIGHT: f32 = 46.0;
/// Part of a row that the outlines take.
const OUTLINES_PART: f32 = 0.66;
const MARGIN: f32 = 7.0;
const GAP: f32 = 8.0;
const DOT_RADIUS: f32 = 3.2;

/// A body of a layout.
pub fn body_of(layout: &Layout, role: BodyRole) -> Option<&RigidBody> {
    match role {
        BodyRole::Tool => Some(&layout.tool),
        BodyRole::Crf => layout.crf.as_ref(),
    }
}

/// An answer as a row that can be clicked: its places, and its value in words.
pub fn answer_row_ui(
    ui: &mut Ui,
    result: &SearchResult,
    answer: AnswerId,
    (name, value): (&str, &str),
    is_selected: bool,
) -> Response {
    let size = vec2(ui.available_width(), HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| {
        let label = format!("{name}, {value}");
        let kind = egui::WidgetType::SelectableLabel;
        egui::WidgetInfo::selected(kind, ui.is_enabled(), is_selected, label)
    });
    if !ui.is_rect_visible(rect) {
        return response;
    }
    let fill = match (is_selected, response.hovered()) {
        (true, _) => ui.visuals().selection.bg_fill,
        (false, true) => palette::WIDGET_HOVERED.color32(),
        (false, false) => palette::WIDGET.color32(),
    };
    ui.painter().rect_filled(rect, 3.0, fill);
    let Some(layout) = result.layout(answer) else {
        return response;
    };
    let split = rect.left() + OUTLINES_PART * rect.width();
    let count = result.outlines.len().max(1) as f32;
    let width = (split - rect.left() - MARGIN - (count - 1.0) * GAP) / count;
    for (number, (role, outline)) in result.outlines.iter().enumerate() {
        let left = rect.left() + MARGIN + number as f32 * (width + GAP);
        let own = Rect::from_min_size(pos2(left, rect.top()), vec2(width, HEIGHT))
            .shrink2(vec2(0.0, MARGIN));
        let start = body_of(&result.optimized.start, *role);
        if let Some(body) = body_of(layout, *role) {
            paint(ui.painter(), own, outline, body, start);
        }
    }
    let text = |text: &str, y: f32, font, color: Color32| {
        let galley = ui.painter().layout_no_wrap(text.to_owned(), font, color);
        let at = pos2(rect.right() - MARGIN - galley.size().x, y - galley.size().y / 2.0);
        ui.painter().galley(at, galley, color);
    };
    let middle = rect.center().y;
    text(value, middle - 7.0, theme::body_font(), palette::TEXT.color32());
    text(name, middle + 9.0, theme::label_font(), palette::TEXT_QUIET.color32());
    response
}

/// Sensors that moved stand out from those that did not.
fn paint(
    painter: &Painter,
    rect: Rect,
    outline: &BodyOutline,
    body: &RigidBody,
    start: Option<&RigidBody>,
) {
    let extent = [0, 1].map(|k| (outline.high[k] - outline.low[k]).max(1e-3) as f32);
    let scale = (rect.width() / extent[0]).min(rect.height() / extent[1]);
    let middle = [0, 1].map(|k| (outline.low[k] + outline.high[k]) / 2.0);
    let place = |at: [f64; 2]| -> Pos2 {
        let [right, up] = [0, 1].map(|k| (at[k] - middle[k]) as f32 * scale);
        rect.center() + vec2(right, -up)
    };
    let stroke = Stroke::new(1.0, palette::TEXT_QUIET.color32());
    for ring in &outline.rings {
        painter.add(Shape::closed_line(ring.iter().map(|at| place(*at)).collect(), stroke));
    }
    let painter = painter.with_clip_rect(rect.expand(MARGIN));
    for sensor in &body.sensors {
        let is_as_before = start.is_some_and(|start| start.sensors.contains(sensor));
        let color = if is_as_before { palette::SENSOR } else { palette::FOUND_PLACE };
        painter.circle_filled(
            place(outline.at(&sensor.position_in_body)),
            DOT_RADIUS,
            color.color32(),
        );
    }
}
