//! The legend in a corner of the 3D view: how much errors are magnified, what is drawn, colour bars; a
//! click on its title folds it to one line. Beside it caption and scale bar.

use crate::layers::legend::Swatch;
use crate::palette;
use crate::palette::ThemedColor;
use crate::viewport::overlay::OverlayView;
use crate::viewport::overlay::color_bar::LaidBar;
use crate::viewport::overlay::corners::{Corners, MARGIN, after_click, corners, is_folded};
use crate::viewport::overlay::keys::LaidKey;
use crate::viewport::overlay::ruler::round_below;
use crate::widgets::basic::{THIN_SPACE, times};
use crate::widgets::theme;
use bevy_egui::egui::{
    self, Align2, Area, Galley, Id, LayerId, Order, Painter, Pos2, Rect, Sense, Shape, Stroke,
    Tooltip, Vec2, WidgetInfo, WidgetType, pos2, vec2,
};
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_geometry::magnification::MAX_GHOST_TURN_RAD;
use trackwright_report::room;

/// Between a plate's edge and what is written on it.
const PADDING: f32 = 8.0;
/// Between the parts of the legend.
const GAP: f32 = 6.0;
const TITLE: &str = "Legend";
/// Before the title: a triangle that points at what is folded.
const TRIANGLE: f32 = 8.0;
const TITLE_INDENT: f32 = 14.0;
/// Longest scale bar, pixels.
const MAX_SCALE_PX: f64 = 150.0;
/// Of a scale bar with its number above it.
const SCALE_HEIGHT: f32 = 24.0;
/// The caption's lines are at least so long.
const LEAST_CAPTION: f32 = 80.0;

/// Where a picture's conclusions come from, for every picture that leaves the program.
pub fn caption(environment: &Environment) -> String {
    room::caption(environment)
}

/// The legend's title as it was painted, and its entries.
#[derive(Clone, Debug, PartialEq)]
pub struct Title {
    pub rect: Rect,
    /// Where each entry is, and what it is in a sentence; none while it is folded.
    pub entries: Vec<(Rect, &'static str)>,
    /// What a person's choice becomes with a click on it.
    pub after_click: Option<bool>,
    pub is_folded: bool,
}

/// What was painted in the corners.
pub(super) struct Painted {
    pub covered: Vec<Rect>,
    pub title: Option<Title>,
}

/// Paints the legend, the caption and the scale bar.
pub(super) fn paint(painter: &Painter, view: &OverlayView) -> Painted {
    let rect = view.rect;
    let width = (rect.width() - 2.0 * MARGIN).max(LEAST_CAPTION);
    let color = palette::TEXT.color32();
    let caption = painter.layout(caption(view.environment), theme::label_font(), color, width);
    let scale = ScaleBar::new(view);
    let unfolded = Column::new(painter, view);
    let is_folded = view.can_fold && is_folded(view.is_folded, rect.size(), unfolded.size);
    let line = folded_words(painter, view);
    let size = if is_folded { folded_size(painter, &line) } else { unfolded.size };
    let found = corners(rect, caption.size(), vec2(scale.width, SCALE_HEIGHT), size);
    let Corners { caption: caption_rect, scale_bar, legend } = found;
    plate(painter, caption_rect.expand2(vec2(5.0, 2.0)));
    painter.galley(caption_rect.min, caption, color);
    scale.paint(painter, scale_bar);
    let mut covered = vec![caption_rect.expand(4.0), scale_bar.expand(3.0)];
    if unfolded.size == Vec2::ZERO {
        return Painted { covered, title: None };
    }
    plate(painter, legend);
    covered.push(legend);
    let title = view.can_fold.then(|| {
        let after_click = after_click(view.is_folded, rect.size(), unfolded.size);
        let words = if is_folded { line } else { TITLE.to_owned() };
        paint_title(painter, legend.min + vec2(PADDING, PADDING), words, is_folded);
        let size = vec2(legend.width(), title_height(painter) + PADDING);
        let rect = Rect::from_min_size(legend.min, size);
        let abouts = view.legend.abouts.iter().copied();
        let entries = match is_folded {
            true => Vec::new(),
            false => unfolded.places(legend).into_iter().zip(abouts).collect(),
        };
        Title { rect, entries, after_click, is_folded }
    });
    if !is_folded {
        unfolded.paint(painter, legend);
    }
    Painted { covered, title }
}

/// The title as something to click on; whether it was clicked.
pub fn title_ui(ctx: &egui::Context, title: &Title) -> bool {
    let area = Area::new(Id::new("legend title"))
        .order(Order::Middle)
        .fixed_pos(title.rect.min)
        .constrain(false);
    let add = |ui: &mut egui::Ui| ui.allocate_response(title.rect.size(), Sense::click());
    let response = area.show(ctx, add).inner;
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, TITLE));
    let about = match title.is_folded {
        true => "Unfolds the legend",
        false => "Folds the legend to one line",
    };
    response.on_hover_text(about).clicked()
}

/// The sentence of the entry under the pointer. Nothing lies over the scene for it: it is dragged and
/// zoomed there as everywhere.
pub fn entries_ui(ctx: &egui::Context, title: &Title) {
    let at = ctx.input(|input| input.pointer.hover_pos().filter(|_| !input.pointer.any_down()));
    let Some(at) =
        at.filter(|at| ctx.layer_id_at(*at).is_none_or(|it| it.order == Order::Background))
    else {
        return;
    };
    if let Some((rect, about)) = title.entries.iter().find(|(rect, _)| rect.contains(at)) {
        let (layer, id) = (LayerId::background(), Id::new("legend entry"));
        Tooltip::always_open(ctx.clone(), layer, id, *rect).show(|ui| ui.label(*about));
    }
}

/// A plate behind a legend, so that it reads over any scene.
fn plate(painter: &Painter, rect: Rect) {
    painter.rect_filled(rect, 4.0, palette::plate());
}

/// Everything below the title.
struct Column<'a> {
    head: Option<Arc<Galley>>,
    keys: Vec<LaidKey>,
    bars: Vec<LaidBar<'a>>,
    /// Of the plate, with the title; zero where there is nothing to name.
    size: Vec2,
    title_height: f32,
}

impl<'a> Column<'a> {
    fn new(painter: &Painter, view: &'a OverlayView) -> Self {
        let strong = palette::TEXT_STRONG.color32();
        let entries = &view.legend;
        let head = magnified_words(view)
            .map(|words| painter.layout_no_wrap(words, theme::body_font(), strong));
        let strokes = entries.strokes.iter().map(|stroke| {
            let words = if view.is_plain { &stroke.plain_words } else { &stroke.words };
            LaidKey::new(painter, Swatch::Line(stroke.color), words)
        });
        let own = entries.keys.iter().map(|key| LaidKey::new(painter, key.swatch, &key.text));
        let keys: Vec<_> = strokes.chain(own).collect();
        let bars: Vec<_> = entries.bars.iter().map(|bar| LaidBar::new(painter, bar)).collect();
        let title_height = if view.can_fold { title_height(painter) + 2.0 } else { 0.0 };
        let heads = head.iter().map(|head| head.size() + vec2(0.0, 2.0));
        let parts = heads
            .chain(keys.iter().map(|key| key.size))
            .chain(bars.iter().map(|bar| bar.size + vec2(0.0, GAP)));
        let content = parts
            .fold(vec2(0.0, title_height), |all, part| vec2(all.x.max(part.x), all.y + part.y));
        let size = match keys.is_empty() && bars.is_empty() {
            true => Vec2::ZERO,
            false => content + vec2(2.0, 2.0) * PADDING,
        };
        Self { head, keys, bars, size, title_height }
    }

    fn start(&self, frame: Rect) -> Pos2 {
        frame.min + vec2(PADDING, PADDING + self.title_height)
    }

    /// Where the keys and the bars are.
    fn places(&self, frame: Rect) -> Vec<Rect> {
        let head = self.head.as_ref().map_or(0.0, |head| head.size().y + 2.0);
        let mut at = self.start(frame) + vec2(0.0, head);
        let keys = self.keys.iter().map(|key| (0.0, key.size));
        let bars = self.bars.iter().map(|bar| (GAP, bar.size));
        let place = |(gap, size): (f32, Vec2)| {
            let rect = Rect::from_min_size(at + vec2(0.0, gap), size);
            at.y += gap + size.y;
            rect
        };
        keys.chain(bars).map(place).collect()
    }

    fn paint(&self, painter: &Painter, frame: Rect) {
        if let Some(head) = &self.head {
            painter.galley(self.start(frame), Arc::clone(head), palette::TEXT_STRONG.color32());
        }
        let places = self.places(frame);
        let (keys, bars) = places.split_at(self.keys.len());
        for (key, place) in self.keys.iter().zip(keys) {
            key.paint(painter, place.min);
        }
        for (bar, place) in self.bars.iter().zip(bars) {
            bar.paint(painter, place.min);
        }
    }
}

/// `Errors drawn 200× larger`; `None` where nothing is magnified.
fn magnified_words(view: &OverlayView) -> Option<String> {
    let shown = view.magnification.filter(|_| !view.legend.strokes.is_empty())?;
    let mut words = match shown.times == 1.0 {
        true => "Errors at true size".to_owned(),
        false => format!("Errors drawn {}× larger", times(shown.times)),
    };
    if shown.is_capped && !view.is_plain {
        let most_deg = MAX_GHOST_TURN_RAD.to_degrees();
        words.push_str(&format!(", angles to {most_deg:.0}° at most"));
    }
    Some(words)
}

/// The one line that is left, as much of it as fits: without the factor arrows would mislead.
fn folded_words(painter: &Painter, view: &OverlayView) -> String {
    let Some(words) = magnified_words(view) else {
        return TITLE.to_owned();
    };
    let factor = words.split(',').next().unwrap_or_default().to_owned();
    let most = view.rect.width() - 2.0 * MARGIN;
    let fits = |words: &String| folded_size(painter, words).x <= most;
    [format!("{TITLE} · {words}"), format!("{TITLE} · {factor}")]
        .into_iter()
        .find(fits)
        .unwrap_or(factor)
}

fn folded_size(painter: &Painter, words: &str) -> Vec2 {
    let color = palette::TEXT.color32();
    let words = painter.layout_no_wrap(words.to_owned(), theme::label_font(), color);
    words.size() + vec2(TITLE_INDENT + 2.0 * PADDING, 2.0 * PADDING)
}

fn title_height(painter: &Painter) -> f32 {
    let color = palette::TEXT.color32();
    painter.layout_no_wrap(TITLE.to_owned(), theme::label_font(), color).size().y
}

fn paint_title(painter: &Painter, at: Pos2, words: String, is_folded: bool) {
    let color = palette::TEXT_QUIET.color32();
    let words = painter.layout_no_wrap(words, theme::label_font(), color);
    let half = TRIANGLE / 2.0;
    let middle = at + vec2(half, words.size().y / 2.0);
    let corners = match is_folded {
        true => [vec2(-half, -half), vec2(half, 0.0), vec2(-half, half)],
        false => [vec2(-half, -half), vec2(half, -half), vec2(0.0, half)],
    };
    let corners: Vec<Pos2> = corners.iter().map(|corner| middle + *corner * 0.8).collect();
    painter.add(Shape::convex_polygon(corners, color, Stroke::NONE));
    painter.galley(at + vec2(TITLE_INDENT, 0.0), words, color);
}

/// A length in the plane that the camera looks at.
struct ScaleBar {
    length_mm: f64,
    width: f32,
}

impl ScaleBar {
    fn new(view: &OverlayView) -> Self {
        let mm_per_px = view.camera.view_height_mm() / f64::from(view.rect.height().max(1.0));
        let length_mm = round_below(MAX_SCALE_PX * mm_per_px);
        Self { length_mm, width: (length_mm / mm_per_px) as f32 }
    }

    fn paint(&self, painter: &Painter, rect: Rect) {
        let color = palette::TEXT.color32();
        let stroke = Stroke::new(1.5, color);
        let at = rect.left_bottom() - vec2(0.0, 3.0);
        let end = at + vec2(self.width, 0.0);
        painter.line_segment([at, end], stroke);
        for x in [at, end] {
            painter.line_segment([x - vec2(0.0, 4.0), x + vec2(0.0, 1.0)], stroke);
        }
        let text = format!("{}{THIN_SPACE}mm", self.length_mm);
        let middle = pos2(at.x + self.width / 2.0, at.y - 5.0);
        painter.text(middle, Align2::CENTER_BOTTOM, text, theme::label_font(), color);
    }
}
