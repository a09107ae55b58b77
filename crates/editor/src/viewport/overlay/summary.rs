//! The result written into a picture that has no panels.

use crate::palette;
use crate::palette::ThemedColor;
use crate::viewport::overlay::OverlayView;
use crate::widgets::basic::{THIN_SPACE, counted, length, with_unit};
use crate::widgets::theme;
use crate::widgets::verdict::{bound_text, figure_color};
use bevy_egui::egui::{Align2, Painter, Rect, Shape, pos2, vec2};
use trackwright_formats::printable::printable;
use trackwright_simulation::Metric;
use trackwright_simulation::headline;

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
    if let Some(figures) = view.figures {
        let headline = headline(figures, view.expected);
        let (name, unit) = (headline.metric.label(), headline.metric.unit());
        line(
            &with_unit(&format!("{:.2}", headline.value), unit),
            theme::figure_font(),
            figure_color(headline.bound.map(|bound| bound.verdict)),
        );
        let mut text = |text: &str| line(text, theme::label_font(), palette::TEXT.color32());
        match headline.interval {
            None => text(name),
            Some([low, high]) => {
                let high = with_unit(&format!("{high:.2}"), unit);
                text(&format!("expected {name}"));
                text(&format!("95{THIN_SPACE}%: {low:.2} to {high}"));
            }
        }
        if let Some(bound) = &headline.bound {
            text(&bound_text(bound, unit));
        }
        let expected_max = view.expected.map(|expected| expected.of(Metric::TIP_MAX));
        let rest = format!(
            "max {}, {}",
            length(expected_max.map_or(figures.position_mm.max(), |(value, _)| value)),
            counted(figures.trials, "trial", "trials")
        );
        line(&rest, theme::label_font(), palette::TEXT_QUIET.color32());
    }
    let covered = covered.expand(6.0);
    painter.set(plate, Shape::rect_filled(covered, 4.0, palette::plate()));
    covered
}
