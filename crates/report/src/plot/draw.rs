//! A chart's layout and its drawing.

use super::label::{Rect, line_px, place, width_px, wrapped};
use super::svg::{Anchor, Svg};
use super::ticks::Ticks;
use super::{Chart, Series, SeriesStyle};
use crate::palette::{self, Rgb};
use trackwright_formats::printable::printable_lines;

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

/// Half the cap of an interval.
const CAP_PX: i32 = 4;

/// Half the size of a marker.
const MARKER_PX: i32 = 5;

/// Shapes of markers before they come round again: filled ones first, then strokes.
const SHAPES: usize = 7;

/// The chart as SVG.
pub fn svg(chart: &Chart, size: (u32, u32)) -> String {
    let mut svg = Svg::new(size);
    Layout::new(chart, size).draw(&mut svg);
    printable_lines(&svg.finish()).into_owned()
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

    fn draw(&self, svg: &mut Svg) {
        svg.rectangle((0, 0), self.size, palette::PAPER, 1.0);
        self.draw_grid(svg);
        self.draw_words(svg);
        self.draw_legend(svg);
        for style in [
            SeriesStyle::Front,
            SeriesStyle::Bound,
            SeriesStyle::Intervals,
            SeriesStyle::Line,
            SeriesStyle::Points,
            SeriesStyle::Marked,
        ] {
            let mut taken = Vec::new();
            for (number, series) in numbered(self.chart).filter(|(_, s)| s.style == style) {
                self.draw_series(svg, series, number, &mut taken);
            }
        }
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

    fn draw_grid(&self, svg: &mut Svg) {
        let p = &self.plot;
        let upright = |x: f64| [(self.x_px(x), p.top), (self.x_px(x), p.bottom)];
        let level = |y: f64| [(p.left, self.y_px(y)), (p.right, self.y_px(y))];
        self.draw_zero_lanes(svg);
        let minor = self.x.minor.iter().map(|&x| upright(x));
        for line in minor.chain(self.y.minor.iter().map(|&y| level(y))) {
            svg.line(&line, palette::GRID_MINOR, 1);
        }
        let major = self.x.labelled.iter().map(|(x, _)| upright(*x));
        for line in major.chain(self.y.labelled.iter().map(|(y, _)| level(*y))) {
            svg.line(&line, palette::GRID, 1);
        }
        svg.line(&[(p.left, p.top), (p.left, p.bottom), (p.right, p.bottom)], palette::LINE, 1);
        for (x, label) in &self.x.labelled {
            let (x, y) = (self.x_px(*x), p.bottom);
            svg.line(&[(x, y), (x, y + 5)], palette::LINE, 1);
            svg.text((x, y + 9), label, TICK_PX, palette::INK_QUIET, Anchor::TOP);
        }
        for (y, label) in &self.y.labelled {
            let (x, y) = (p.left, self.y_px(*y));
            svg.line(&[(x - 5, y), (x, y)], palette::LINE, 1);
            svg.text((x - 8, y), label, TICK_PX, palette::INK_QUIET, Anchor::RIGHT);
        }
    }

    /// Zero lies beside a logarithmic axis, not on it: its lane is shaded.
    fn draw_zero_lanes(&self, svg: &mut Svg) {
        let p = &self.plot;
        let lane = |ticks: &Ticks, px: i32| (ticks.zero_lane * f64::from(px)).round() as i32;
        let (right, top) = (lane(&self.x, p.width()), lane(&self.y, p.height()));
        if right > 0 {
            let end = (p.left + right - 4, p.bottom);
            svg.rectangle((p.left, p.top), end, palette::GRID_MINOR, 1.0);
        }
        if top > 0 {
            let start = (p.left, p.bottom - top + 4);
            svg.rectangle(start, (p.right, p.bottom), palette::GRID_MINOR, 1.0);
        }
    }

    /// Title, labels of the axes, notes.
    fn draw_words(&self, svg: &mut Svg) {
        let p = &self.plot;
        for (i, line) in self.title.iter().enumerate() {
            let top = EDGE_PX + i as i32 * line_px(TITLE_PX);
            svg.bold_text((EDGE_PX, top), line, TITLE_PX, palette::INK);
        }
        let below = p.bottom + 9 + line_px(TICK_PX) + 5;
        let middle = ((p.left + p.right) / 2, below);
        svg.text(middle, &self.chart.x.label, TEXT_PX, palette::INK, Anchor::TOP);
        let beside = (EDGE_PX, (p.top + p.bottom) / 2);
        svg.upward_text(beside, &self.chart.y.label, TEXT_PX, palette::INK);
        for (i, line) in self.notes.iter().enumerate() {
            let from_bottom = (self.notes.len() - i) as i32 * line_px(NOTE_PX);
            let at = (EDGE_PX, self.size.1 - EDGE_PX + 8 - from_bottom);
            svg.text(at, line, NOTE_PX, palette::INK_QUIET, Anchor::TOP_LEFT);
        }
    }

    fn draw_legend(&self, svg: &mut Svg) {
        let left = self.plot.right + 18;
        let mut top = self.plot.top + 4;
        for entry in &self.legend {
            let middle = top + line_px(TEXT_PX) / 2;
            let ends = [(left, middle), (left + LEGEND_SYMBOL_PX - 8, middle)];
            let color = color(entry.number);
            match entry.series.style {
                SeriesStyle::Front => svg.line(&ends, palette::FRONT, 5),
                SeriesStyle::Line => svg.line(&ends, color, 2),
                SeriesStyle::Bound => svg.line(&ends, palette::BOUND, 1),
                SeriesStyle::Intervals => {
                    let x = (ends[0].0 + ends[1].0) / 2;
                    let half = line_px(TEXT_PX) / 3;
                    draw_interval(svg, [(x, middle - half), (x, middle + half)]);
                }
                SeriesStyle::Points | SeriesStyle::Marked => {}
            }
            if has_markers(entry.series) {
                draw_marker(svg, ((ends[0].0 + ends[1].0) / 2, middle), entry.number);
            }
            for line in &entry.lines {
                let at = (left + LEGEND_SYMBOL_PX, top + line_px(TEXT_PX) / 2);
                svg.text(at, line, TEXT_PX, palette::INK, Anchor::LEFT);
                top += line_px(TEXT_PX);
            }
            top += 6;
        }
    }

    fn draw_series(&self, svg: &mut Svg, series: &Series, number: usize, taken: &mut Vec<Rect>) {
        let held = || series.points.iter().filter(|&&p| self.chart.holds(p)).map(|&p| self.at(p));
        match series.style {
            SeriesStyle::Front => self.draw_front(svg, held()),
            SeriesStyle::Line => {
                // A point that is missing is a gap, not a shortcut.
                for run in series.points.split(|&p| !self.chart.holds(p)) {
                    let path: Vec<_> = run.iter().map(|&p| self.at(p)).collect();
                    svg.line(&path, color(number), 2);
                }
            }
            SeriesStyle::Bound => {
                if let Some((_, y)) = held().next() {
                    svg.line(&[(self.plot.left, y), (self.plot.right, y)], palette::BOUND, 1);
                }
            }
            SeriesStyle::Intervals => {
                for pair in series
                    .points
                    .chunks_exact(2)
                    .filter(|pair| pair.iter().all(|&p| self.chart.holds(p)))
                {
                    draw_interval(svg, [self.at(pair[0]), self.at(pair[1])]);
                }
            }
            SeriesStyle::Points => {}
            SeriesStyle::Marked => held().for_each(|at| self.draw_ring(svg, series, at, taken)),
        }
        if has_markers(series) {
            held().for_each(|at| draw_marker(svg, at, number));
        }
    }

    fn draw_front(&self, svg: &mut Svg, points: impl Iterator<Item = (i32, i32)>) {
        let mut path: Vec<(i32, i32)> = Vec::new();
        for at in points {
            if let Some(&(_, y)) = path.last() {
                path.push((at.0, y));
            }
            path.push(at);
        }
        if let (Some(&first), Some(&last)) = (path.first(), path.last()) {
            path.insert(0, (first.0, self.plot.top));
            path.push((self.plot.right, last.1));
        }
        svg.line(&path, palette::FRONT, 5);
    }

    fn draw_ring(&self, svg: &mut Svg, series: &Series, at: (i32, i32), taken: &mut Vec<Rect>) {
        svg.ring(at, RING_PX, palette::INK, 2);
        if series.name.is_empty() {
            return;
        }
        let size = (width_px(&series.name, TEXT_PX), line_px(TEXT_PX));
        let rect = place(at, size, RING_PX, &self.plot, &self.drawn_points(), taken);
        taken.push(rect);
        svg.rectangle((rect.left, rect.top), (rect.right, rect.bottom), palette::PAPER, 0.8);
        let middle = ((rect.left + rect.right) / 2, (rect.top + rect.bottom) / 2);
        svg.text(middle, &series.name, TEXT_PX, palette::INK, Anchor::MIDDLE);
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

/// A bar with a cap at each end.
fn draw_interval(svg: &mut Svg, ends: [(i32, i32); 2]) {
    svg.line(&ends, palette::INK_QUIET, 2);
    for (x, y) in ends {
        svg.line(&[(x - CAP_PX, y), (x + CAP_PX, y)], palette::INK_QUIET, 2);
    }
}

fn color(number: usize) -> Rgb {
    palette::SERIES[number % palette::SERIES.len()]
}

/// The shape of a series by its number: another one each time the colours come round.
pub fn shape(number: usize) -> usize {
    (number + number / palette::SERIES.len()) % SHAPES
}

/// A series' marker, with a thin edge of paper so that neighbours stay apart.
fn draw_marker(svg: &mut Svg, (x, y): (i32, i32), number: usize) {
    let (r, color) = (MARKER_PX, color(number));
    let corners: &[(i32, i32)] = match shape(number) {
        0 => {
            svg.disc((x, y), r + 1, palette::PAPER);
            return svg.disc((x, y), r, color);
        }
        1 => &[(-r, -r), (r, -r), (r, r), (-r, r)],
        2 => &[(0, -r - 1), (r + 1, r), (-r - 1, r)],
        3 => &[(0, -r - 2), (r + 2, 0), (0, r + 2), (-r - 2, 0)],
        4 => &[(0, r + 1), (r + 1, -r), (-r - 1, -r)],
        5 => {
            svg.line(&[(x - r, y - r), (x + r, y + r)], color, 3);
            return svg.line(&[(x - r, y + r), (x + r, y - r)], color, 3);
        }
        _ => {
            svg.line(&[(x - r - 1, y), (x + r + 1, y)], color, 3);
            return svg.line(&[(x, y - r - 1), (x, y + r + 1)], color, 3);
        }
    };
    for (edge, color) in [(1, palette::PAPER), (0, color)] {
        let grown = |v: i32| v + edge * v.signum();
        let placed: Vec<_> = corners.iter().map(|&(u, v)| (x + grown(u), y + grown(v))).collect();
        svg.polygon(&placed, color);
    }
}

fn has_markers(series: &Series) -> bool {
    match series.style {
        SeriesStyle::Points => true,
        SeriesStyle::Line => series.points.len() <= MAX_MARKERS_ON_LINE,
        SeriesStyle::Marked | SeriesStyle::Front | SeriesStyle::Bound | SeriesStyle::Intervals => {
            false
        }
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
