//! Lines of the legend: a swatch and a few words each.

use crate::layers::legend::Swatch;
use crate::palette::ThemedColor;
use crate::palette::{self, Rgb};
use crate::widgets::theme;
use bevy_egui::egui::{Galley, Painter, Pos2, Rect, Stroke, StrokeKind, Vec2, pos2, vec2};
use std::sync::Arc;
use trackwright_geometry::colormap::{
    NO_VALUE_LINE_SRGB, NO_VALUE_SRGB, UNSUPPORTED_LINE_OPACITY, UNSUPPORTED_LINE_SRGB, over,
};

const LINE: f32 = 15.0;
const SWATCH: [f32; 2] = [16.0, 10.0];
/// Where the words begin.
const INDENT: f32 = 22.0;
/// Between the lines of a hatching.
const HATCH_PX: f32 = 5.0;
/// Longer words are broken.
const MOST_WIDTH: f32 = 250.0;

/// A line that is ready to be painted.
pub(super) struct LaidKey {
    swatch: Swatch,
    text: Arc<Galley>,
    pub size: Vec2,
}

impl LaidKey {
    pub fn new(painter: &Painter, swatch: Swatch, words: &str) -> Self {
        let color = palette::TEXT.color32();
        let text = painter.layout(words.to_owned(), theme::label_font(), color, MOST_WIDTH);
        let indent = if swatch == Swatch::Nothing { 0.0 } else { INDENT };
        let size = vec2(indent + text.size().x, text.size().y.max(LINE));
        Self { swatch, text, size }
    }

    pub fn paint(&self, painter: &Painter, at: Pos2) {
        let middle = at.y + LINE / 2.0;
        let box_min = pos2(at.x, middle - SWATCH[1] / 2.0);
        paint_swatch(painter, self.swatch, Rect::from_min_size(box_min, SWATCH.into()));
        let indent = self.size.x - self.text.size().x;
        let text_at = pos2(at.x + indent, at.y + (self.size.y - self.text.size().y) / 2.0);
        painter.galley(text_at, Arc::clone(&self.text), palette::TEXT.color32());
    }
}

fn paint_swatch(painter: &Painter, swatch: Swatch, rect: Rect) {
    let rgb = |srgb| Rgb::same(srgb).color32();
    let line = |y: f32, color: Rgb| {
        let ends = [pos2(rect.left(), y), pos2(rect.right(), y)];
        painter.line_segment(ends, Stroke::new(3.0, color.color32()));
    };
    match swatch {
        Swatch::Nothing => {}
        Swatch::NoValue => {
            painter.rect_filled(rect, 1.0, rgb(NO_VALUE_SRGB));
            hatch(painter, rect, Stroke::new(1.2, rgb(NO_VALUE_LINE_SRGB)), 1.0);
        }
        Swatch::Unsupported(map) => {
            let middle = map.srgb(0.4);
            let line = over(middle, UNSUPPORTED_LINE_SRGB, UNSUPPORTED_LINE_OPACITY);
            painter.rect_filled(rect, 1.0, rgb(middle));
            hatch(painter, rect, Stroke::new(1.2, rgb(line)), -1.0);
        }
        Swatch::Surface(color) => {
            painter.rect_filled(rect, 1.0, color.color32_alpha(70));
            let stroke = Stroke::new(1.0, color.color32());
            painter.rect_stroke(rect, 1.0, stroke, StrokeKind::Inside);
        }
        Swatch::Line(color) => line(rect.center().y, color),
        Swatch::Ball(color) => {
            painter.circle_filled(rect.center(), rect.height() / 2.0, color.color32());
        }
        Swatch::Axes(colors) => {
            for (k, color) in colors.into_iter().enumerate() {
                line(rect.top() + 1.0 + 4.0 * k as f32, color);
            }
        }
    }
}

/// Diagonal lines that rise to the right, or fall.
fn hatch(painter: &Painter, rect: Rect, stroke: Stroke, rise: f32) {
    let painter = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
    let height = rect.height();
    let count = ((rect.width() + height) / HATCH_PX) as usize;
    for k in 0..=count {
        let x = rect.left() - height + HATCH_PX * (k as f32 + 0.5);
        let [from, to] = match rise > 0.0 {
            true => [rect.bottom(), rect.top()],
            false => [rect.top(), rect.bottom()],
        };
        painter.line_segment([pos2(x, from), pos2(x + height, to)], stroke);
    }
}
