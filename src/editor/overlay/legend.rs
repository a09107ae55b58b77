//! Legends in the corners of the 3D view: colour bar, magnification, scale bar, caption.

use super::OverlayView;
use super::ruler::{decimals, round_below, ticks};
use crate::editor::palette::{self, Rgb};
use crate::editor::state::ColorScale;
use crate::editor::ui::theme;
use crate::editor::ui::widgets::{THIN_SPACE, count, decimal, length, with_unit};
use crate::field::Environment;
use crate::geometry::magnification::MAX_GHOST_TURN_RAD;
use crate::study::Quantity;
use bevy_egui::egui::{Align2, Color32, Mesh, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};

/// Distance of legends from the view's edges.
pub const MARGIN: f32 = 12.0;
const PADDING: f32 = 8.0;
const LINE: f32 = 15.0;
/// Where a key's name begins, behind its stroke.
const KEY_INDENT: f32 = 22.0;
const BAR_WIDTH: f32 = 200.0;
const BAR_HEIGHT: f32 = 10.0;
const MAX_TICKS: usize = 5;
/// Longest scale bar, pixels.
const MAX_SCALE_PX: f64 = 150.0;

/// Where a picture's conclusions come from, for every picture that leaves the program.
pub fn caption(environment: &Environment) -> String {
    let name = &environment.name;
    let from = match &environment.provenance {
        None => "an ideal room".to_owned(),
        Some(from) => {
            let samples = count(from.samples);
            match &from.holdout {
                Some(holdout) => format!(
                    "{samples} samples, held-out error {}",
                    length(holdout.after.position_rms_mm)
                ),
                None => format!("{samples} samples, no held-out error"),
            }
        }
    };
    format!("Predicted in room {name}, {from}; not for clinical use")
}

/// Paints the legends; the rectangles they cover.
pub fn paint(painter: &Painter, view: &OverlayView) -> Vec<Rect> {
    let mut covered = Vec::new();
    let rect = view.rect;
    let caption = painter.layout_no_wrap(
        caption(view.environment),
        theme::label_font(),
        palette::TEXT.color32(),
    );
    let caption_rect =
        Align2::LEFT_BOTTOM.anchor_size(rect.left_bottom() + vec2(MARGIN, -8.0), caption.size());
    plate(painter, caption_rect.expand2(vec2(5.0, 2.0)));
    painter.galley(caption_rect.min, caption, palette::TEXT.color32());
    covered.push(caption_rect.expand(4.0));
    let bottom = caption_rect.top() - 8.0;
    covered.push(scale_bar(painter, view, pos2(rect.left() + MARGIN, bottom)));
    let mut right_bottom = pos2(rect.right() - MARGIN, rect.bottom() - MARGIN);
    // A narrow view has no room for caption and colour bar side by side.
    if caption_rect.right() > right_bottom.x - BAR_WIDTH - 3.0 * PADDING {
        right_bottom.y = bottom;
    }
    if let Some(scale) = view.color_scale.filter(|_| view.layers.slice) {
        let bar = color_bar(painter, view, scale, right_bottom);
        covered.push(bar);
        right_bottom.y = bar.top() - 8.0;
    }
    covered.extend(magnification(painter, view, right_bottom));
    covered
}

/// Small text on its own; what it covers.
fn text(painter: &Painter, at: Pos2, align: Align2, text: &str, color: Rgb) -> Rect {
    painter.text(at, align, text, theme::label_font(), color.color32())
}

/// A dark plate behind a legend, so that it reads over any scene.
fn plate(painter: &Painter, rect: Rect) {
    painter.rect_filled(rect, 4.0, palette::BACKGROUND.color32_alpha(200));
}

fn scale_bar(painter: &Painter, view: &OverlayView, left_bottom: Pos2) -> Rect {
    let mm_per_px = view.camera.view_height_mm() / f64::from(view.rect.height().max(1.0));
    let length_mm = round_below(MAX_SCALE_PX * mm_per_px);
    let width = (length_mm / mm_per_px) as f32;
    let at = left_bottom + vec2(0.0, -3.0);
    let stroke = Stroke::new(1.5, palette::TEXT.color32());
    let end = at + vec2(width, 0.0);
    painter.line_segment([at, end], stroke);
    for x in [at, end] {
        painter.line_segment([x - vec2(0.0, 4.0), x + vec2(0.0, 1.0)], stroke);
    }
    let label = text(
        painter,
        at + vec2(width / 2.0, -5.0),
        Align2::CENTER_BOTTOM,
        &format!("{length_mm}{THIN_SPACE}mm"),
        palette::TEXT,
    );
    label.union(Rect::from_two_pos(at, end)).expand(3.0)
}

fn color_bar(painter: &Painter, view: &OverlayView, scale: ColorScale, right_bottom: Pos2) -> Rect {
    let largest_mm = view.slice_max_mm.unwrap_or(scale.max_mm);
    let is_clipped = largest_mm > scale.max_mm * (1.0 + 1e-9);
    let quantity_unit = view.slice_quantity.unit();
    // The largest value stands in a line of its own where the name leaves no room for it.
    let name_lines = if is_clipped && view.slice_quantity != Quantity::PositionErrorMm {
        2.0
    } else {
        1.0
    };
    let size = vec2(
        BAR_WIDTH + 2.0 * PADDING + 14.0,
        name_lines * LINE + BAR_HEIGHT + LINE + 2.0 * PADDING,
    );
    let frame = Rect::from_min_max(right_bottom - size, right_bottom);
    plate(painter, frame);
    let at = frame.left_top() + vec2(PADDING, PADDING);
    let bar_top = at.y + name_lines * LINE;
    text(
        painter,
        at,
        Align2::LEFT_TOP,
        view.slice_quantity.label(),
        palette::TEXT,
    );
    if is_clipped {
        text(
            painter,
            pos2(frame.right() - PADDING, bar_top - 1.0),
            Align2::RIGHT_BOTTOM,
            &format!(
                "largest {}",
                with_unit(&decimal(largest_mm, 2), quantity_unit)
            ),
            palette::TEXT_QUIET,
        );
    }
    let bar = Rect::from_min_size(pos2(at.x, bar_top), vec2(BAR_WIDTH, BAR_HEIGHT));
    gradient(painter, bar, scale);
    if is_clipped {
        arrow_right(painter, bar, top_color(scale));
    }
    let values = ticks(scale.max_mm, MAX_TICKS);
    let decimals = decimals(&values);
    for (k, value) in values.iter().enumerate() {
        let x = bar.left() + bar.width() * (value / scale.max_mm.max(f64::MIN_POSITIVE)) as f32;
        painter.line_segment(
            [pos2(x, bar.bottom()), pos2(x, bar.bottom() + 3.0)],
            Stroke::new(1.0, palette::TEXT.color32()),
        );
        let unit = if k + 1 == values.len() {
            quantity_unit
        } else {
            ""
        };
        let label = with_unit(&format!("{value:.decimals$}"), unit);
        // The first begins at the bar's end, so that it stays on the plate.
        let align = if k == 0 {
            Align2::LEFT_TOP
        } else {
            Align2::CENTER_TOP
        };
        text(
            painter,
            pos2(x, bar.bottom() + 3.0),
            align,
            &label,
            palette::TEXT,
        );
    }
    frame
}

fn color32([r, g, b]: [u8; 3]) -> Color32 {
    Rgb::same([r, g, b]).color32()
}

fn top_color(scale: ColorScale) -> Color32 {
    color32(scale.map.srgb(1.0))
}

/// One column a pixel, each of the map's own colour and none blended.
fn gradient(painter: &Painter, bar: Rect, scale: ColorScale) {
    let columns = bar.width().round() as usize;
    let mut mesh = Mesh::default();
    for k in 0..columns {
        let color = color32(scale.map.srgb((k as f64 + 0.5) / columns as f64));
        let left = bar.left() + bar.width() * k as f32 / columns as f32;
        let right = bar.left() + bar.width() * (k + 1) as f32 / columns as f32;
        let column = Rect::from_min_max(pos2(left, bar.top()), pos2(right, bar.bottom()));
        mesh.add_colored_rect(column, color);
    }
    painter.add(Shape::mesh(mesh));
}

/// Says that there are values beyond the end of the bar.
fn arrow_right(painter: &Painter, bar: Rect, color: Color32) {
    let x = bar.right() + 2.0;
    painter.add(Shape::convex_polygon(
        vec![
            pos2(x, bar.top()),
            pos2(x + 9.0, bar.center().y),
            pos2(x, bar.bottom()),
        ],
        color,
        Stroke::NONE,
    ));
}

/// `errors × 50`, and what magnified things look like.
fn magnification(painter: &Painter, view: &OverlayView, right_bottom: Pos2) -> Option<Rect> {
    let layers = view.layers;
    let shown = view.magnification?;
    let keys: Vec<(&str, Rgb)> = [
        (
            layers.sensor_errors || layers.tip_error,
            "error vectors, two heads where cut",
            palette::ERROR_VECTOR,
        ),
        (layers.ghost, "tool as tracked", palette::GHOST),
        (
            layers.tip_scatter && view.has_scatter,
            "95 % of the tip's jitter",
            palette::GHOST,
        ),
    ]
    .into_iter()
    .filter(|(is_on, _, _)| *is_on)
    .map(|(_, name, color)| (name, color))
    .collect();
    if keys.is_empty() {
        return None;
    }
    let mut head = if shown.times == 1.0 {
        "errors at true size".to_owned()
    } else {
        format!("errors × {}", times(shown.times))
    };
    if shown.is_capped {
        let most_deg = MAX_GHOST_TURN_RAD.to_degrees();
        head.push_str(&format!(", turn held at {most_deg:.0}°"));
    }
    let head = painter.layout_no_wrap(head, theme::body_font(), palette::TEXT_STRONG.color32());
    let widest_key = keys
        .iter()
        .map(|(name, _)| {
            let name = (*name).to_owned();
            let color = palette::TEXT.color32();
            KEY_INDENT
                + painter
                    .layout_no_wrap(name, theme::label_font(), color)
                    .size()
                    .x
        })
        .fold(0.0, f32::max);
    let width = head.size().x.max(widest_key) + 2.0 * PADDING;
    let height = head.size().y + LINE * keys.len() as f32 + 2.0 * PADDING;
    let frame = Rect::from_min_max(right_bottom - vec2(width, height), right_bottom);
    plate(painter, frame);
    let mut at = frame.left_top() + vec2(PADDING, PADDING);
    let head_height = head.size().y;
    painter.galley(at, head, palette::TEXT_STRONG.color32());
    at.y += head_height + 2.0;
    for (name, color) in keys {
        let y = at.y + LINE / 2.0 - 1.0;
        painter.line_segment(
            [pos2(at.x, y), pos2(at.x + 16.0, y)],
            Stroke::new(3.0, color.color32()),
        );
        text(
            painter,
            at + vec2(KEY_INDENT, 0.0),
            Align2::LEFT_TOP,
            name,
            palette::TEXT,
        );
        at.y += LINE;
    }
    Some(frame)
}

/// `50`, `0.5`, `10,000`.
fn times(times: f64) -> String {
    if times >= 1.0 && times.fract() == 0.0 && times < 1e9 {
        count(times as usize)
    } else {
        format!("{times}")
    }
}
