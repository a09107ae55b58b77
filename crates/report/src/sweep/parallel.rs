//! Parallel coordinates: an axis a column, a line a row, coloured by the first figure.

use super::{NumberColumn, SweepColumns, significant};
use crate::palette::{self, Rgb};
use crate::plot::label::{line_px, width_px, wrapped};
use crate::plot::svg::{Anchor, Svg};
use trackwright_formats::printable::printable_lines;
use trackwright_geometry::colormap::ColorMap;
use trackwright_result::with_separators;

const EDGE_PX: i32 = 20;
const TITLE_PX: f64 = 18.0;
const TEXT_PX: f64 = 12.0;
const BAR_PX: i32 = 14;
const BAR_STEPS: i32 = 24;

/// The picture as SVG.
pub fn parallel_coordinates(sweep: &SweepColumns, (width, height): (u32, u32)) -> String {
    let mut svg = Svg::new((width, height));
    let (width, height) = (width as i32, height as i32);
    svg.rectangle((0, 0), (width, height), palette::PAPER, 1.0);
    let columns: Vec<&NumberColumn> = sweep.parameters.iter().chain(&sweep.figures).collect();
    let drawn = sweep.drawn();
    let colored = &sweep.figures[0];
    let title = format!(
        "{}: {} of {} rows, coloured by {}",
        sweep.title,
        drawn.len(),
        with_separators(sweep.rows.len()),
        colored.label()
    );
    let title = wrapped(&title, TITLE_PX, width - 2 * EDGE_PX);
    for (k, line) in title.iter().enumerate() {
        svg.bold_text(
            (EDGE_PX, EDGE_PX + k as i32 * line_px(TITLE_PX)),
            line,
            TITLE_PX,
            palette::INK,
        );
    }
    let step = (width - 2 * EDGE_PX) / columns.len().max(1) as i32;
    let labels: Vec<Vec<String>> =
        columns.iter().map(|column| broken(&column.label(), step - 8)).collect();
    let label_lines = labels.iter().map(Vec::len).max().unwrap_or(0) as i32;
    let top = EDGE_PX + title.len() as i32 * line_px(TITLE_PX) + line_px(TEXT_PX) + 12;
    let bottom = height - EDGE_PX - (label_lines + 1) * line_px(TEXT_PX) - 6;
    let x = |axis: usize| EDGE_PX + step / 2 + axis as i32 * step;
    let ranges: Vec<Option<[f64; 2]>> = columns.iter().map(|column| column.range()).collect();
    let y = |axis: usize, row: usize| {
        let part = part(ranges[axis], columns[axis].values[row]);
        bottom - (part * f64::from(bottom - top)).round() as i32
    };
    let colors = colored.range();
    // The best are drawn last, over the others.
    let mut order = drawn;
    order.sort_by(|&a, &b| colored.values[b].total_cmp(&colored.values[a]));
    for row in order {
        let points: Vec<(i32, i32)> =
            (0..columns.len()).map(|axis| (x(axis), y(axis, row))).collect();
        svg.line(&points, color(part(colors, colored.values[row])), 1);
    }
    for (axis, range) in ranges.iter().enumerate() {
        svg.line(&[(x(axis), top), (x(axis), bottom)], palette::INK, 1);
        if let Some([low, high]) = *range {
            let above = (x(axis), top - line_px(TEXT_PX) / 2 - 4);
            svg.text(above, &significant(high), TEXT_PX, palette::INK_QUIET, Anchor::MIDDLE);
            svg.text(
                (x(axis), bottom + 4),
                &significant(low),
                TEXT_PX,
                palette::INK_QUIET,
                Anchor::TOP,
            );
        }
        for (k, line) in labels[axis].iter().enumerate() {
            let below = bottom + 4 + (k as i32 + 1) * line_px(TEXT_PX);
            svg.text((x(axis), below), line, TEXT_PX, palette::INK, Anchor::TOP);
        }
    }
    draw_bar(&mut svg, x(sweep.parameters.len()) - BAR_PX, (top, bottom));
    printable_lines(&svg.finish()).into_owned()
}

/// The colours beside the axis of the figure that they stand for.
fn draw_bar(svg: &mut Svg, left: i32, (top, bottom): (i32, i32)) {
    let at = |k: i32| bottom - k * (bottom - top) / BAR_STEPS;
    for k in 0..BAR_STEPS {
        let middle = (f64::from(k) + 0.5) / f64::from(BAR_STEPS);
        svg.rectangle((left, at(k + 1)), (left + BAR_PX - 2, at(k)), color(middle), 1.0);
    }
}

/// Where a value is on its column's axis, from 0 to 1; the middle where all are the same.
fn part(range: Option<[f64; 2]>, value: f64) -> f64 {
    match range {
        Some([low, high]) if high > low => (value - low) / (high - low),
        _ => 0.5,
    }
}

/// Dark is small.
fn color(part: f64) -> Rgb {
    let [red, green, blue] = ColorMap::Viridis.srgb(part);
    Rgb(red, green, blue)
}

/// A path in lines that fit, broken behind its dots.
fn broken(label: &str, max_px: i32) -> Vec<String> {
    let mut lines = vec![String::new()];
    for piece in label.split_inclusive(['.', ' ', '_']) {
        match lines.last_mut() {
            Some(last)
                if last.is_empty() || width_px(&format!("{last}{piece}"), TEXT_PX) <= max_px =>
            {
                last.push_str(piece);
            }
            _ => lines.push(piece.to_owned()),
        }
    }
    lines
}
