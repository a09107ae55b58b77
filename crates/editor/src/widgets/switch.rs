//! The small switches at the end of a row: an eye and a lock, drawn, as fonts differ in what they
//! have.

use crate::palette;
use crate::palette::ThemedColor;
use crate::widgets::theme;
use crate::widgets::tooltip::Explain;
use bevy_egui::egui::{
    self, Color32, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, vec2,
};

/// Room that one switch takes in a row.
pub const SWITCH_WIDTH: f32 = 18.0;

/// Half the width and half the height of an eye.
const EYE: [f32; 2] = [6.0, 3.6];
/// Points of each of its lids.
const LID_POINTS: usize = 9;

/// What can be switched of a thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Switch {
    /// On where the thing is hidden.
    Eye,
    /// On where the thing is locked.
    Lock,
}

impl Switch {
    /// What a click does to a thing of this name.
    fn label(self, is_on: bool, name: &str) -> String {
        let verb = match (self, is_on) {
            (Self::Eye, false) => "Hide",
            (Self::Eye, true) => "Show",
            (Self::Lock, false) => "Lock",
            (Self::Lock, true) => "Unlock",
        };
        format!("{verb} {name}")
    }

    fn about(self) -> &'static str {
        match self {
            Self::Eye => "What is hidden is neither drawn nor picked in the scene; it still counts",
            Self::Lock => "What is locked is not picked in the scene",
        }
    }
}

/// Draws a switch. One that is off is seen only while the row or the switch is under the pointer.
pub fn switch_ui(ui: &mut Ui, switch: Switch, is_on: bool, is_near: bool, name: &str) -> Response {
    let size = vec2(SWITCH_WIDTH, theme::ROW_HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let label = switch.label(is_on, name);
    response.widget_info(|| {
        egui::WidgetInfo::selected(egui::WidgetType::Checkbox, ui.is_enabled(), is_on, &label)
    });
    let color = if response.hovered() {
        Some(palette::TEXT_STRONG)
    } else if is_on {
        Some(palette::TEXT)
    } else {
        is_near.then_some(palette::TEXT_QUIET)
    };
    if let Some(color) = color.filter(|_| ui.is_rect_visible(rect)) {
        paint(ui.painter(), switch, is_on, rect, color.color32());
    }
    response.explained(format!("{label}. {}", switch.about()))
}

fn paint(painter: &Painter, switch: Switch, is_on: bool, rect: Rect, color: Color32) {
    let at = rect.center();
    let stroke = Stroke::new(1.2, color);
    match switch {
        Switch::Eye => {
            painter.add(Shape::closed_line(eye(at), stroke));
            painter.circle_filled(at, 1.7, color);
            if is_on {
                let half = vec2(5.0, 5.0);
                painter.line_segment([at - half, at + half], stroke);
            }
        }
        Switch::Lock => {
            let case = Rect::from_center_size(at + vec2(0.0, 2.0), vec2(8.0, 6.0));
            painter.rect_filled(case, 1.0, color);
            // An open bow stands to the side.
            let aside = if is_on { 0.0 } else { 3.5 };
            let bow = (0..=8).map(|k| {
                let (sine, cosine) = (std::f32::consts::PI * k as f32 / 8.0).sin_cos();
                at + vec2(aside - 2.6 * cosine, -1.0 - 3.4 * sine)
            });
            painter.add(Shape::line(bow.collect(), stroke));
        }
    }
}

/// The outline of an eye: the upper lid from left to right, the lower one back.
fn eye(at: Pos2) -> Vec<Pos2> {
    let [half_width, half_height] = EYE;
    let lid = |sign: f32| {
        (0..LID_POINTS).map(move |k| {
            let along = k as f32 / LID_POINTS as f32 * 2.0 - 1.0;
            at + sign * vec2(along * half_width, -half_height * (1.0 - along * along))
        })
    };
    lid(1.0).chain(lid(-1.0)).collect()
}
