//! A chart's layout and its drawing.

use super::super::palette;
use super::label::{Rect, line_px, place, width_px, wrapped};
use super::ticks::Ticks;
use super::{Chart, Series, SeriesStyle, marker};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use trackwright_formats::printable::printable_lines;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn<'a> = Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>>;

const TITLE_PX: f64 = 18.0;
const TEXT_PX: f64 = 14.0;
const TICK_PX: f64 = 13.0;
const NOTE_PX: f64 = 12.0;

/// Free edge around everything.
const EDGE_PX: i32 = 20;

/// The legend takes at most this part of the width.
const LEGEND_PART: f64 = 0.3;

/// From the beginning of a legend's line to its text.
const LEGEND_SYMBOL_PX: i32 = 30;

/// Pixels between labelled ticks, so that numbers do not touch.
const TICK_SPACING_PX: i32 = 70;

/// Points of a line beyond which each would hide the next.
const MAX_MARKERS_ON_LINE: usize = 40;

const RING_PX: i32 = 10;

/// Between points of a line that labels keep away from.
const ALONG_LINE_PX: i32 = 8;

/// The chart as SVG.
pub fn svg(chart: &Chart, size: (u32, u32)) -> String {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let drawn = Layout::new(chart, size).draw(&area);
        debug_assert!(drawn.is_ok(), "a string takes all that is written to it");
    }
    printable_lines(&text).into_owned()
}

/// Where everything goes.
struct Layout<'a> {
    chart: &'a Chart,
    size: (i32, i32),
    plot: Rect,
    x: Ticks,
    y: Ticks,
    title: Vec<String>,
    legend: Vec<Entry<'a>>,
    notes: Vec<String>,
}

/// A line of the legend: a series, its colour and shape by number, its name in lines.
struct Entry<'a> {
    series: &'a Series,
    number: usize,
    lines: Vec<String>,
}

impl<'a> Layout<'a> {
    fn new(chart: &'a Chart, (width, height): (u32, u32)) -> Self {
        let (width, height) = (width as i32, height as i32);
        let text_width = width - 2 * EDGE_PX;
        let title = wrapped(&chart.title, TITLE_PX, text_width);
        let notes: Vec<String> =
            chart.notes().iter().flat_map(|n| wrapped(n, NOTE_PX, text_width)).collect();
        let (legend, legend_width) = legend(chart, width);
        // A bound has a level and no place along x.
        let kept = |with_bounds: bool| {
            chart
                .series
                .iter()
                .filter(move |s| with_bounds || s.style != SeriesStyle::Bound)
                .flat_map(|s| &s.points)
                .filter(|&&p| chart.holds(p))
        };
        let top = EDGE_PX + title.len() as i32 * line_px(TITLE_PX) + 12;
        let below = line_px(TICK_PX) + 10 + line_px(TEXT_PX) + 4;
        let bottom = height - EDGE_PX - below - notes.len() as i32 * line_px(NOTE_PX);
        let wanted = |px: i32| (px / TICK_SPACING_PX).max(2) as usize;
        let y = Ticks::new(
            chart.y.scale,
            kept(true).map(|p| p.1),
            // Numbers one above another may stand closer.
            wanted((bottom - top) * 4 / 3),
        );
        let numbers = y.labelled.iter().map(|(_, l)| width_px(l, TICK_PX)).max();
        let left = EDGE_PX + line_px(TEXT_PX) + 8 + numbers.unwrap_or(0) + 8;
        let right = width - EDGE_PX - legend_width;
        let x = Ticks::new(chart.x.scale, kept(false).map(|p| p.0), wanted(right - left));
        Self {
            chart,
            size: (width, height),
            plot: Rect { left, top, right: right.max(left + 1), bottom: bottom.max(top + 1) },
            x,
            y,
            title,
            legend,
            notes,
        }
    }

    fn draw<'b>(&self, area: &Area<'b>) -> Drawn<'b> {
        area.fill(&palette::PAPER)?;
        self.draw_grid(area)?;
        self.draw_words(area)?;
        self.draw_legend(area)?;
        for style in [
            SeriesStyle::Front,
            SeriesStyle::Bound,
            SeriesStyle::Line,
            SeriesStyle::Points,
            SeriesStyle::Marked,
        ] {
            let mut taken = Vec::new();
            for (number, series) in numbered(self.chart) {
                if series.style == style {
                    self.draw_series(area, series, number, &mut taken)?;
                }
            }
        }
        area.present()
    }

    /// A point of the chart in pixels.
    fn at(&self, (x, y): (f64, f64)) -> (i32, i32) {
        (self.x_px(x), self.y_px(y))
    }

    fn x_px(&self, x: f64) -> i32 {
        self.plot.left + (self.x.part(x) * f64::from(self.plot.width())).round() as i32
    }

    fn y_px(&self, y: f64) -> i32 {
        self.plot.bottom - (self.y.part(y) * f64::from(self.plot.height())).round() as i32
    }

    fn draw_grid<'b>(&self, area: &Area<'b>) -> Drawn<'b> {
        let p = &self.plot;
        let upright = |x: f64| [(self.x_px(x), p.top), (self.x_px(x), p.bottom)];
        let level = |y: f64| [(p.left, self.y_px(y)), (p.right, self.y_px(y))];
        self.draw_zero_lanes(area)?;
        let minor = self.x.minor.iter().map(|&x| upright(x));
        for line in minor.chain(self.y.minor.iter().map(|&y| level(y))) {
            area.draw(&PathElement::new(line, palette::GRID_MINOR))?;
        }
        let major = self.x.labelled.iter().map(|(x, _)| upright(*x));
        for line in major.chain(self.y.labelled.iter().map(|(y, _)| level(*y))) {
            area.draw(&PathElement::new(line, palette::GRID))?;
        }
        let axes = [(p.left, p.top), (p.left, p.bottom), (p.right, p.bottom)];
        area.draw(&PathElement::new(axes, palette::LINE))?;
        for (x, label) in &self.x.labelled {
            let at = (self.x_px(*x), p.bottom);
            area.draw(&PathElement::new([at, (at.0, at.1 + 5)], palette::LINE))?;
            let style = text(TICK_PX, palette::INK_QUIET, HPos::Center, VPos::Top);
            area.draw_text(label, &style, (at.0, at.1 + 9))?;
        }
        for (y, label) in &self.y.labelled {
            let at = (p.left, self.y_px(*y));
            area.draw(&PathElement::new([(at.0 - 5, at.1), at], palette::LINE))?;
            let style = text(TICK_PX, palette::INK_QUIET, HPos::Right, VPos::Center);
            area.draw_text(label, &style, (at.0 - 8, at.1))?;
        }
        Ok(())
    }

    /// Zero lies beside a logarithmic axis, not on it: its lane is shaded.
    fn draw_zero_lanes<'b>(&self, area: &Area<'b>) -> Drawn<'b> {
        let p = &self.plot;
        let lane = |ticks: &Ticks, px: i32| (ticks.zero_lane * f64::from(px)).round() as i32;
        let (right, top) = (lane(&self.x, p.width()), lane(&self.y, p.height()));
        let shade = palette::GRID_MINOR.filled();
        if right > 0 {
            let corners = [(p.left, p.top), (p.left + right - 4, p.bottom)];
            area.draw(&Rectangle::new(corners, shade))?;
        }
        if top > 0 {
            let corners = [(p.left, p.bottom - top + 4), (p.right, p.bottom)];
            area.draw(&Rectangle::new(corners, shade))?;
        }
        Ok(())
    }

    /// Title, labels of the axes, notes.
    fn draw_words<'b>(&self, area: &Area<'b>) -> Drawn<'b> {
        let p = &self.plot;
        let bold = FontDesc::new(FontFamily::SansSerif, TITLE_PX * SVG_SIZE, FontStyle::Bold);
        for (i, line) in self.title.iter().enumerate() {
            let top = EDGE_PX + i as i32 * line_px(TITLE_PX);
            area.draw_text(line, &bold.color(&palette::INK), (EDGE_PX, top))?;
        }
        let style = text(TEXT_PX, palette::INK, HPos::Center, VPos::Top);
        let below = p.bottom + 9 + line_px(TICK_PX) + 5;
        let middle = ((p.left + p.right) / 2, below);
        area.draw_text(&self.chart.x.label, &style, middle)?;
        let turned = FontDesc::new(FontFamily::SansSerif, TEXT_PX * SVG_SIZE, FontStyle::Normal)
            .transform(FontTransform::Rotate270)
            .color(&palette::INK)
            .pos(Pos::new(HPos::Center, VPos::Top));
        let beside = (EDGE_PX, (p.top + p.bottom) / 2);
        area.draw_text(&self.chart.y.label, &turned, beside)?;
        for (i, line) in self.notes.iter().enumerate() {
            let from_bottom = (self.notes.len() - i) as i32 * line_px(NOTE_PX);
            let style = text(NOTE_PX, palette::INK_QUIET, HPos::Left, VPos::Top);
            let at = (EDGE_PX, self.size.1 - EDGE_PX + 8 - from_bottom);
            area.draw_text(line, &style, at)?;
        }
        Ok(())
    }

    fn draw_legend<'b>(&self, area: &Area<'b>) -> Drawn<'b> {
        let left = self.plot.right + 18;
        let mut top = self.plot.top + 4;
        for entry in &self.legend {
            let middle = top + line_px(TEXT_PX) / 2;
            let ends = [(left, middle), (left + LEGEND_SYMBOL_PX - 8, middle)];
            let color = color(entry.number);
            match entry.series.style {
                SeriesStyle::Front => {
                    area.draw(&PathElement::new(ends, palette::FRONT.stroke_width(5)))?;
                }
                SeriesStyle::Line => {
                    area.draw(&PathElement::new(ends, color.stroke_width(2)))?;
                }
                SeriesStyle::Bound => {
                    area.draw(&PathElement::new(ends, palette::BOUND.stroke_width(1)))?;
                }
                SeriesStyle::Points | SeriesStyle::Marked => {}
            }
            if has_markers(entry.series) {
                let at = ((ends[0].0 + ends[1].0) / 2, middle);
                marker::draw(area, at, shape(entry.number), color)?;
            }
            for line in &entry.lines {
                let style = text(TEXT_PX, palette::INK, HPos::Left, VPos::Center);
                let at = (left + LEGEND_SYMBOL_PX, top + line_px(TEXT_PX) / 2);
                area.draw_text(line, &style, at)?;
                top += line_px(TEXT_PX);
            }
            top += 6;
        }
        Ok(())
    }

    fn draw_series<'b>(
        &self,
        area: &Area<'b>,
        series: &Series,
        number: usize,
        taken: &mut Vec<Rect>,
    ) -> Drawn<'b> {
        match series.style {
            SeriesStyle::Front => self.draw_front(area, series)?,
            SeriesStyle::Line => {
                // A point that is missing is a gap, not a shortcut.
                for run in series.points.split(|&p| !self.chart.holds(p)) {
                    let path: Vec<_> = run.iter().map(|&p| self.at(p)).collect();
                    area.draw(&PathElement::new(path, color(number).stroke_width(2)))?;
                }
            }
            SeriesStyle::Bound => {
                let level = series.points.iter().find(|&&p| self.chart.holds(p));
                let ends = level
                    .map(|p| self.y_px(p.1))
                    .map(|y| [(self.plot.left, y), (self.plot.right, y)]);
                if let Some(line) = ends {
                    area.draw(&PathElement::new(line, palette::BOUND.stroke_width(1)))?;
                }
            }
            SeriesStyle::Points => {}
            SeriesStyle::Marked => self.draw_rings(area, series, taken)?,
        }
        if has_markers(series) {
            for &p in series.points.iter().filter(|&&p| self.chart.holds(p)) {
                marker::draw(area, self.at(p), shape(number), color(number))?;
            }
        }
        Ok(())
    }

    fn draw_front<'b>(&self, area: &Area<'b>, series: &Series) -> Drawn<'b> {
        let mut path: Vec<(i32, i32)> = Vec::new();
        for at in series.points.iter().filter(|&&p| self.chart.holds(p)).map(|&p| self.at(p)) {
            if let Some(&(_, y)) = path.last() {
                path.push((at.0, y));
            }
            path.push(at);
        }
        if let (Some(&first), Some(&last)) = (path.first(), path.last()) {
            path.insert(0, (first.0, self.plot.top));
            path.push((self.plot.right, last.1));
        }
        area.draw(&PathElement::new(path, palette::FRONT.stroke_width(5)))
    }

    fn draw_rings<'b>(&self, area: &Area<'b>, series: &Series, taken: &mut Vec<Rect>) -> Drawn<'b> {
        let covered = self.drawn_points();
        for &p in series.points.iter().filter(|&&p| self.chart.holds(p)) {
            let at = self.at(p);
            area.draw(&Circle::new(at, RING_PX, palette::INK.stroke_width(2)))?;
            if series.name.is_empty() {
                continue;
            }
            let size = (width_px(&series.name, TEXT_PX), line_px(TEXT_PX));
            let rect = place(at, size, RING_PX, &self.plot, &covered, taken);
            taken.push(rect);
            let corners = [(rect.left, rect.top), (rect.right, rect.bottom)];
            area.draw(&Rectangle::new(corners, palette::PAPER.mix(0.8).filled()))?;
            let style = text(TEXT_PX, palette::INK, HPos::Center, VPos::Center);
            let middle = ((rect.left + rect.right) / 2, (rect.top + rect.bottom) / 2);
            area.draw_text(&series.name, &style, middle)?;
        }
        Ok(())
    }

    /// Points that a label should not cover: markers, and points along lines.
    fn drawn_points(&self) -> Vec<(i32, i32)> {
        let mut points = Vec::new();
        for series in &self.chart.series {
            for run in series.points.split(|&p| !self.chart.holds(p)) {
                points.extend(run.iter().map(|&p| self.at(p)));
                if series.style == SeriesStyle::Line {
                    for pair in run.windows(2) {
                        points.extend(between(self.at(pair[0]), self.at(pair[1])));
                    }
                }
            }
        }
        points
    }
}

/// Points on the way from one to another, every few pixels.
fn between(a: (i32, i32), b: (i32, i32)) -> impl Iterator<Item = (i32, i32)> {
    let length = (b.0 - a.0).abs().max((b.1 - a.1).abs());
    let count = length / ALONG_LINE_PX;
    (1..count).map(move |i| {
        let part = f64::from(i) / f64::from(count);
        let mid = |a: i32, b: i32| a + (part * f64::from(b - a)).round() as i32;
        (mid(a.0, b.0), mid(a.1, b.1))
    })
}

/// The backend writes sizes divided by this.
const SVG_SIZE: f64 = 1.24;

fn text(size_px: f64, color: RGBColor, h: HPos, v: VPos) -> TextStyle<'static> {
    FontDesc::new(FontFamily::SansSerif, size_px * SVG_SIZE, FontStyle::Normal)
        .color(&color)
        .pos(Pos::new(h, v))
}

fn color(number: usize) -> RGBColor {
    palette::SERIES[number % palette::SERIES.len()]
}

fn shape(number: usize) -> usize {
    marker::shape(number, palette::SERIES.len())
}

fn has_markers(series: &Series) -> bool {
    match series.style {
        SeriesStyle::Points => true,
        SeriesStyle::Line => series.points.len() <= MAX_MARKERS_ON_LINE,
        SeriesStyle::Marked | SeriesStyle::Front | SeriesStyle::Bound => false,
    }
}

/// Series with a number each for colour and shape; what has neither takes none.
fn numbered(chart: &Chart) -> impl Iterator<Item = (usize, &Series)> {
    let mut next = 0;
    chart.series.iter().map(move |series| {
        let number = next;
        next += usize::from(matches!(series.style, SeriesStyle::Line | SeriesStyle::Points));
        (number, series)
    })
}

/// The legend's lines and the width they take, in the order of the series.
fn legend(chart: &Chart, width: i32) -> (Vec<Entry<'_>>, i32) {
    let max = (f64::from(width) * LEGEND_PART) as i32 - LEGEND_SYMBOL_PX;
    let entries: Vec<_> = numbered(chart)
        .filter(|(_, s)| s.style != SeriesStyle::Marked && !s.name.is_empty())
        .map(|(number, series)| Entry {
            series,
            number,
            lines: wrapped(&series.name, TEXT_PX, max),
        })
        .collect();
    let widest = entries.iter().flat_map(|e| &e.lines).map(|l| width_px(l, TEXT_PX)).max();
    let width = widest.map_or(0, |w| 18 + LEGEND_SYMBOL_PX + w);
    (entries, width)
}
