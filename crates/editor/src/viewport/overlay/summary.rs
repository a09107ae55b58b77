//! The result written into a picture that has no panels.

use crate::palette;
use crate::palette::ThemedColor;
use crate::viewport::overlay::OverlayView;
use crate::widgets::basic::{counted, length, with_unit};
use crate::widgets::theme;
use crate::widgets::verdict::{bound_text, figure_color, interval_text, verdict_text};
use bevy_egui::egui::{Align2, Painter, Rect, Shape, pos2, vec2};
use trackwright_formats::printable::printable;
use trackwright_simulation::Metric;

/// Paints name and result into the upper left corner; what they cover.
pub fn paint(painter: &Painter, view: &OverlayView) -> Rect {
    let mut at = view.rect.left_top() + vec2(14.0, 12.0);
    let mut covered = Rect::from_min_size(at, vec2(0.0, 0.0));
    // Its plate is as large as what is written, which is not known yet.
    let plate = painter.add(Shape::Noop);
    let mut line = |text: &str, font, color: bevy_egui::egui::Color32| {
        let rect = painter.text(at, Align2::LEFT_TOP, printable(text), font, color);
        at = pos2(at.x, rect.bottom() + 2.0);
        covered = covered.union(rect);
    };
    line(&view.design.name, theme::body_font(), palette::TEXT_STRONG.color32());
    if let Some(study) = view.study {
        let figures = &study.figures;
        let requirement = figures.requirement.as_ref();
        if let Some(figure) = figures.headline() {
            let (metric, unit) = (figure.metric, figure.metric.unit());
            let bound = requirement.and_then(|requirement| requirement.bound(metric));
            let color = figure_color(bound.map(|bound| bound.verdict));
            line(&with_unit(&figure.value_text(2), unit), theme::figure_font(), color);
            let mut text = |text: &str| line(text, theme::label_font(), palette::TEXT.color32());
            text(metric.label());
            if let Some(interval) = interval_text(figure) {
                text(&interval);
            }
            if let Some(bound) = bound {
                text(&bound_text(bound));
            }
        } else if let Some(requirement) = requirement {
            let color = figure_color(Some(requirement.verdict));
            line(&verdict_text(requirement.verdict), theme::label_font(), color);
        }
        let largest = figures.get(Metric::TIP_MAX);
        let largest =
            largest.map_or("no figures".to_owned(), |f| format!("max {}", length(f.value)));
        let rest = format!("{largest}, {}", counted(study.room_field.trials, "trial", "trials"));
        line(&rest, theme::label_font(), palette::TEXT_QUIET.color32());
    }
    let covered = covered.expand(6.0);
    painter.set(plate, Shape::rect_filled(covered, 4.0, palette::plate()));
    covered
}
