//! Colour bars of the legend.

use crate::layers::legend::ColorBar;
use crate::palette::ThemedColor;
use crate::palette::{self, Rgb};
use crate::viewport::overlay::ruler::{decimals, ticks};
use crate::widgets::basic::{decimal, with_unit};
use crate::widgets::theme;
use bevy_egui::egui::{
    Align2, Color32, Mesh, Painter, Pos2, Rect, Shape, Stroke, Vec2, pos2, vec2,
};
use trackwright_geometry::colormap::{ColorMap, LEVEL_EDGE_SRGB, LEVEL_LINE_SRGB};

const LINE: f32 = 15.0;
/// Where the words begin, behind a stroke.
const KEY_INDENT: f32 = 22.0;
const BAR_WIDTH: f32 = 200.0;
const BAR_HEIGHT: f32 = 10.0;
/// Right of a bar, for the sign that there are values beyond it.
const BEYOND: f32 = 14.0;
const MAX_TICKS: usize = 5;
/// Of the ends of a bar that does not begin at zero.
const END_DECIMALS: usize = 2;

/// A bar that is ready to be painted.
pub(super) struct LaidBar<'a> {
    scale: &'a ColorBar,
    /// The largest value, where it is beyond the end, and whether it has a line of its own.
    largest: Option<(String, bool)>,
    name_lines: f32,
    pub size: Vec2,
}

impl<'a> LaidBar<'a> {
    pub fn new(painter: &Painter, scale: &'a ColorBar) -> Self {
        let span = scale.max - scale.min;
        let is_clipped = scale.largest > scale.max + 1e-9 * span.abs();
        let width = |text: &str| {
            let color = palette::TEXT.color32();
            painter.layout_no_wrap(text.to_owned(), theme::label_font(), color).size().x
        };
        let label = width(&scale.label);
        let largest = is_clipped.then(|| {
            let value = with_unit(&decimal(scale.largest, scale.decimals), scale.unit);
            let text = format!("largest {value}");
            let has_room = label + 8.0 + width(&text) <= BAR_WIDTH + BEYOND;
            (text, !has_room)
        });
        let note = scale.note.as_deref().map_or(0.0, width);
        let lines = |is_there: bool| f32::from(u8::from(is_there));
        let is_below = largest.as_ref().is_some_and(|(_, is_below)| *is_below);
        let name_lines = 1.0 + lines(scale.note.is_some()) + lines(is_below);
        let limit_lines = lines(scale.limit.is_some());
        let size = vec2(
            (BAR_WIDTH + BEYOND).max(label).max(note),
            (name_lines + limit_lines + 1.0) * LINE + BAR_HEIGHT,
        );
        Self { scale, largest, name_lines, size }
    }

    pub fn paint(&self, painter: &Painter, at: Pos2) {
        let Self { scale, name_lines, size, .. } = self;
        let frame = Rect::from_min_size(at, *size);
        let span = scale.max - scale.min;
        let bar_top = at.y + name_lines * LINE;
        text(painter, at, Align2::LEFT_TOP, &scale.label, palette::TEXT);
        if let Some(note) = &scale.note {
            text(painter, at + vec2(0.0, LINE), Align2::LEFT_TOP, note, palette::TEXT_QUIET);
        }
        if let Some((largest, is_below)) = &self.largest {
            let bottom = if *is_below { bar_top } else { at.y + LINE };
            let right = pos2(at.x + BAR_WIDTH + BEYOND, bottom - 1.0);
            text(painter, right, Align2::RIGHT_BOTTOM, largest, palette::TEXT_QUIET);
        }
        let bar = Rect::from_min_size(pos2(at.x, bar_top), vec2(BAR_WIDTH, BAR_HEIGHT));
        gradient(painter, bar, scale.map);
        if self.largest.is_some() {
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
    }
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
    let y = frame.bottom() - LINE / 2.0;
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

/// Small text on its own.
fn text(painter: &Painter, at: Pos2, align: Align2, text: &str, color: Rgb) {
    painter.text(at, align, text, theme::label_font(), color.color32());
}
