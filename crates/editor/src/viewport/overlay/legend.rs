//! Legends in the corners of the 3D view: colour bar, magnification, scale bar, caption.

use crate::layers::legend::{ColorBar, StrokeKey};
use crate::palette::ThemedColor;
use crate::palette::{self, Rgb};
use crate::viewport::overlay::ruler::{decimals, round_below, ticks};
use crate::viewport::overlay::{OverlayView, keys};
use crate::widgets::basic::{THIN_SPACE, count, decimal, with_unit};
use crate::widgets::theme;
use bevy_egui::egui::{Align2, Color32, Mesh, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};
use trackwright_field::Environment;
use trackwright_geometry::colormap::{ColorMap, LEVEL_EDGE_SRGB, LEVEL_LINE_SRGB};
use trackwright_geometry::magnification::MAX_GHOST_TURN_RAD;
use trackwright_report::room;

/// How opaque the plates behind writing are.
pub const PLATE_ALPHA: u8 = 200;

/// Distance of legends from the view's edges.
pub const MARGIN: f32 = 12.0;
/// Between a plate's edge and what is written on it.
pub const PADDING: f32 = 8.0;
const LINE: f32 = 15.0;
/// Where a key's name begins, behind its stroke.
const KEY_INDENT: f32 = 22.0;
const BAR_WIDTH: f32 = 200.0;
const BAR_HEIGHT: f32 = 10.0;
const MAX_TICKS: usize = 5;
/// Of the ends of a bar that does not begin at zero.
const END_DECIMALS: usize = 2;
/// Longest scale bar, pixels.
const MAX_SCALE_PX: f64 = 150.0;

/// Where a picture's conclusions come from, for every picture that leaves the program.
pub fn caption(environment: &Environment) -> String {
    room::caption(environment)
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
    for bar in &view.color_bars {
        let rect = color_bar(painter, bar, right_bottom);
        covered.push(rect);
        right_bottom.y = rect.top() - 8.0;
    }
    if let Some(rect) = keys::paint(painter, &view.keys, right_bottom) {
        covered.push(rect);
        right_bottom.y = rect.top() - 8.0;
    }
    covered.extend(magnification(painter, view, right_bottom));
    covered
}

/// Small text on its own; what it covers.
fn text(painter: &Painter, at: Pos2, align: Align2, text: &str, color: Rgb) -> Rect {
    painter.text(at, align, text, theme::label_font(), color.color32())
}

/// A dark plate behind a legend, so that it reads over any scene.
pub fn plate(painter: &Painter, rect: Rect) {
    painter.rect_filled(rect, 4.0, palette::BACKGROUND.color32_alpha(PLATE_ALPHA));
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

fn color_bar(painter: &Painter, scale: &ColorBar, right_bottom: Pos2) -> Rect {
    let span = scale.max - scale.min;
    let is_clipped = scale.largest > scale.max + 1e-9 * span.abs();
    let largest =
        format!("largest {}", with_unit(&decimal(scale.largest, scale.decimals), scale.unit));
    let width = |text: &str| {
        let color = palette::TEXT.color32();
        let laid = painter.layout_no_wrap(text.to_owned(), theme::label_font(), color);
        laid.size().x
    };
    // The largest value stands in a line of its own where the name leaves no room for it.
    let has_room = width(&scale.label) + width(&largest) + 8.0 <= BAR_WIDTH + 14.0;
    let name_lines = if is_clipped && !has_room { 2.0 } else { 1.0 };
    let limit_lines = if scale.limit.is_some() { 1.0 } else { 0.0 };
    let size = vec2(
        BAR_WIDTH + 2.0 * PADDING + 14.0,
        (name_lines + limit_lines) * LINE + BAR_HEIGHT + LINE + 2.0 * PADDING,
    );
    let frame = Rect::from_min_max(right_bottom - size, right_bottom);
    plate(painter, frame);
    let at = frame.left_top() + vec2(PADDING, PADDING);
    let bar_top = at.y + name_lines * LINE;
    text(painter, at, Align2::LEFT_TOP, &scale.label, palette::TEXT);
    if is_clipped {
        text(
            painter,
            pos2(frame.right() - PADDING, bar_top - 1.0),
            Align2::RIGHT_BOTTOM,
            &largest,
            palette::TEXT_QUIET,
        );
    }
    let bar = Rect::from_min_size(pos2(at.x, bar_top), vec2(BAR_WIDTH, BAR_HEIGHT));
    gradient(painter, bar, scale.map);
    if is_clipped {
        arrow_right(painter, bar, top_color(scale.map));
    }
    let values = values_of(scale);
    let decimals = match scale.min {
        0.0 => decimals(&values),
        _ => END_DECIMALS,
    };
    for (k, value) in values.iter().enumerate() {
        let part = (value - scale.min) / span.max(f64::MIN_POSITIVE);
        let x = bar.left() + bar.width() * part as f32;
        painter.line_segment(
            [pos2(x, bar.bottom()), pos2(x, bar.bottom() + 3.0)],
            Stroke::new(1.0, palette::TEXT.color32()),
        );
        let unit = if k + 1 == values.len() { scale.unit } else { "" };
        let label = with_unit(&format!("{value:.decimals$}"), unit);
        // The first begins at the bar's end, and one at the other end ends there, so that they stay
        // on the plate.
        let align = if k == 0 {
            Align2::LEFT_TOP
        } else if part > 0.99 && scale.min != 0.0 {
            Align2::RIGHT_TOP
        } else {
            Align2::CENTER_TOP
        };
        text(painter, pos2(x, bar.bottom() + 3.0), align, &label, palette::TEXT);
    }
    if let Some(limit) = scale.limit {
        requirement(painter, scale, limit, bar, frame);
    }
    frame
}

/// A line across the bar at the requirement, as on the map, and below the bar what it is.
fn requirement(painter: &Painter, scale: &ColorBar, limit: f64, bar: Rect, frame: Rect) {
    let line = |from: Pos2, to: Pos2| {
        for (width, srgb) in [(4.0, LEVEL_EDGE_SRGB), (1.6, LEVEL_LINE_SRGB)] {
            painter.line_segment([from, to], Stroke::new(width, color32(srgb)));
        }
    };
    let part = (limit - scale.min) / (scale.max - scale.min).max(f64::MIN_POSITIVE);
    let is_on_bar = (0.0..=1.0).contains(&part);
    if is_on_bar {
        let x = bar.left() + bar.width() * part as f32;
        line(pos2(x, bar.top() - 2.0), pos2(x, bar.bottom() + 2.0));
    }
    let y = frame.bottom() - PADDING - LINE / 2.0;
    line(pos2(bar.left(), y), pos2(bar.left() + 16.0, y));
    let value = with_unit(&decimal(limit, scale.decimals), scale.unit);
    let words = match is_on_bar {
        true => format!("requirement {value}"),
        false => format!("requirement {value}, off the bar"),
    };
    let at = pos2(bar.left() + KEY_INDENT, y);
    text(painter, at, Align2::LEFT_CENTER, &words, palette::TEXT);
}

fn color32([r, g, b]: [u8; 3]) -> Color32 {
    Rgb::same([r, g, b]).color32()
}

/// Round values along a bar that begins at zero, else its two ends.
fn values_of(scale: &ColorBar) -> Vec<f64> {
    match scale.min {
        0.0 => ticks(scale.max, MAX_TICKS),
        _ => vec![scale.min, scale.max],
    }
}

fn top_color(map: ColorMap) -> Color32 {
    color32(map.srgb(1.0))
}

/// One column a pixel, each of the map's own colour and none blended.
fn gradient(painter: &Painter, bar: Rect, map: ColorMap) {
    let columns = bar.width().round() as usize;
    let mut mesh = Mesh::default();
    for k in 0..columns {
        let color = color32(map.srgb((k as f64 + 0.5) / columns as f64));
        let left = bar.left() + bar.width() * k as f32 / columns as f32;
        let right = bar.left() + bar.width() * (k + 1) as f32 / columns as f32;
        let column = Rect::from_min_max(pos2(left, bar.top()), pos2(right, bar.bottom()));
        mesh.add_colored_rect(column, color);
    }
    painter.add(Shape::mesh(mesh));
}

/// Shows that there are values beyond the end of the bar.
fn arrow_right(painter: &Painter, bar: Rect, color: Color32) {
    let x = bar.right() + 2.0;
    painter.add(Shape::convex_polygon(
        vec![pos2(x, bar.top()), pos2(x + 9.0, bar.center().y), pos2(x, bar.bottom())],
        color,
        Stroke::NONE,
    ));
}

/// `errors × 50`, and what magnified things look like.
fn magnification(painter: &Painter, view: &OverlayView, right_bottom: Pos2) -> Option<Rect> {
    let shown = view.magnification?;
    let words = |key: &StrokeKey| match view.is_plain {
        false => key.words,
        true => key.plain_words,
    };
    let keys: Vec<(&str, Rgb)> = view.strokes.iter().map(|key| (words(key), key.color)).collect();
    if keys.is_empty() {
        return None;
    }
    let mut head = match (shown.times == 1.0, view.is_plain) {
        (true, _) => "errors at true size".to_owned(),
        (false, false) => format!("errors × {}", times(shown.times)),
        (false, true) => format!("errors drawn {} times as large", times(shown.times)),
    };
    if shown.is_capped && !view.is_plain {
        let most_deg = MAX_GHOST_TURN_RAD.to_degrees();
        head.push_str(&format!(", turn held at {most_deg:.0}°"));
    }
    let head = painter.layout_no_wrap(head, theme::body_font(), palette::TEXT_STRONG.color32());
    let widest_key = keys
        .iter()
        .map(|(name, _)| {
            let name = (*name).to_owned();
            let color = palette::TEXT.color32();
            KEY_INDENT + painter.layout_no_wrap(name, theme::label_font(), color).size().x
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
        painter
            .line_segment([pos2(at.x, y), pos2(at.x + 16.0, y)], Stroke::new(3.0, color.color32()));
        text(painter, at + vec2(KEY_INDENT, 0.0), Align2::LEFT_TOP, name, palette::TEXT);
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
