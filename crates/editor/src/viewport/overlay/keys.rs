//! What hatchings and surfaces in the scene mean: a swatch and a few words each, on one plate.

use crate::layers::legend::{LegendKey, Swatch};
use crate::palette::ThemedColor;
use crate::palette::{self, Rgb};
use crate::viewport::overlay::legend::{PADDING, plate};
use crate::widgets::theme;
use bevy_egui::egui::{Painter, Pos2, Rect, Stroke, StrokeKind, pos2, vec2};
use trackwright_geometry::colormap::{
    NO_VALUE_LINE_SRGB, NO_VALUE_SRGB, UNSUPPORTED_LINE_OPACITY, UNSUPPORTED_LINE_SRGB, over,
};

const LINE: f32 = 15.0;
const SWATCH: [f32; 2] = [16.0, 10.0];
/// Where the words begin.
const INDENT: f32 = 22.0;
/// Between the lines of a hatching.
const HATCH_PX: f32 = 5.0;

/// Paints the plate; what it covers.
pub fn paint(painter: &Painter, keys: &[LegendKey], right_bottom: Pos2) -> Option<Rect> {
    let color = palette::TEXT.color32();
    let lines: Vec<_> = keys
        .iter()
        .map(|key| {
            let indent = if key.swatch == Swatch::Nothing { 0.0 } else { INDENT };
            let text = painter.layout_no_wrap(key.text.clone(), theme::label_font(), color);
            (key.swatch, indent, text)
        })
        .collect();
    let width = lines.iter().map(|(_, indent, text)| indent + text.size().x);
    let width = width.reduce(f32::max)?;
    let size = vec2(width, LINE * lines.len() as f32) + vec2(2.0, 2.0) * PADDING;
    let frame = Rect::from_min_max(right_bottom - size, right_bottom);
    plate(painter, frame);
    let mut at = frame.min + vec2(PADDING, PADDING);
    for (swatch, indent, text) in lines {
        let middle = at.y + LINE / 2.0;
        let box_min = pos2(at.x, middle - SWATCH[1] / 2.0);
        paint_swatch(painter, swatch, Rect::from_min_size(box_min, SWATCH.into()));
        painter.galley(pos2(at.x + indent, middle - text.size().y / 2.0), text, color);
        at.y += LINE;
    }
    Some(frame)
}

fn paint_swatch(painter: &Painter, swatch: Swatch, rect: Rect) {
    let rgb = |srgb| Rgb::same(srgb).color32();
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
