//! The result written into a picture that has no panels.

use super::OverlayView;
use super::legend::PLATE_ALPHA;
use crate::editor::palette;
use crate::editor::ui::result::headline;
use crate::editor::ui::theme;
use crate::editor::ui::widgets::{MET_SIGN, MISSED_SIGN, counted, length, with_unit};
use bevy_egui::egui::{Align2, Painter, Rect, Shape, pos2, vec2};

/// Paints name and result into the upper left corner; what they cover.
pub fn paint(painter: &Painter, view: &OverlayView) -> Rect {
    let mut at = view.rect.left_top() + vec2(14.0, 12.0);
    let mut covered = Rect::from_min_size(at, vec2(0.0, 0.0));
    // Its plate is as large as what is written, which is not known yet.
    let plate = painter.add(Shape::Noop);
    let mut line = |text: &str, font, color: bevy_egui::egui::Color32| {
        let rect = painter.text(at, Align2::LEFT_TOP, text, font, color);
        at = pos2(at.x, rect.bottom() + 2.0);
        covered = covered.union(rect);
    };
    line(
        &view.design.name,
        theme::body_font(),
        palette::TEXT_STRONG.color32(),
    );
    if let Some(figures) = view.figures {
        let headline = headline(figures);
        let is_met = headline.limit.map(|(_, is_met)| is_met);
        line(
            &with_unit(&format!("{:.2}", headline.value), headline.unit),
            theme::figure_font(),
            theme::verdict_color(is_met),
        );
        let verdict = match headline.limit {
            None => headline.name.to_owned(),
            Some((limit, is_met)) => {
                let limit = with_unit(&format!("{limit:.2}"), headline.unit);
                let (sign, word) = if is_met {
                    (MET_SIGN, "met")
                } else {
                    (MISSED_SIGN, "missed")
                };
                format!("{}, {sign} {word}: at most {limit}", headline.name)
            }
        };
        line(&verdict, theme::label_font(), palette::TEXT.color32());
        let rest = format!(
            "max {}, {}",
            length(figures.position_mm.max),
            counted(figures.trials, "trial", "trials")
        );
        line(&rest, theme::label_font(), palette::TEXT_QUIET.color32());
    }
    let covered = covered.expand(6.0);
    let color = palette::BACKGROUND.color32_alpha(PLATE_ALPHA);
    painter.set(plate, Shape::rect_filled(covered, 4.0, color));
    covered
}
