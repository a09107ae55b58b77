//! Where caption, scale bar and legend stand in the corners of the 3D view, and when the legend folds by
//! itself. In egui's points.

use bevy_egui::egui::{Align2, Rect, Vec2, vec2};

/// Distance from the view's edges.
pub const MARGIN: f32 = 12.0;

/// Between what stands above each other.
const GAP: f32 = 8.0;

/// In a smaller view an unfolded legend would cover the tool.
pub const LEAST_VIEW: Vec2 = vec2(600.0, 400.0);

/// Part of the view's height that an unfolded legend takes at most.
const MOST_HEIGHT_PART: f32 = 0.7;

/// Whether the legend is one line: as a person wants it, or by itself in a small view.
pub fn is_folded(choice: Option<bool>, view: Vec2, unfolded: Vec2) -> bool {
    let is_small =
        view.x < LEAST_VIEW.x || view.y < LEAST_VIEW.y || unfolded.y > MOST_HEIGHT_PART * view.y;
    choice.unwrap_or(is_small)
}

/// What a click on the legend's title comes to: the other state, kept only where it is not the one that
/// the legend has by itself.
pub fn after_click(choice: Option<bool>, view: Vec2, unfolded: Vec2) -> Option<bool> {
    let wanted = !is_folded(choice, view, unfolded);
    (wanted != is_folded(None, view, unfolded)).then_some(wanted)
}

/// What stands in the corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corners {
    pub caption: Rect,
    pub scale_bar: Rect,
    pub legend: Rect,
}

/// Caption and scale bar at the left, the legend at the right; above those where there is no room
/// beside them.
pub fn corners(view: Rect, caption: Vec2, scale_bar: Vec2, legend: Vec2) -> Corners {
    let caption = Align2::LEFT_BOTTOM.anchor_size(view.left_bottom() + vec2(MARGIN, -GAP), caption);
    let scale_bar = Align2::LEFT_BOTTOM.anchor_size(caption.left_top() - vec2(0.0, GAP), scale_bar);
    let corner = view.right_bottom() - vec2(MARGIN, MARGIN);
    let mut legend = Align2::RIGHT_BOTTOM.anchor_size(corner, legend);
    for below in [caption, scale_bar] {
        if legend.expand(GAP / 2.0).intersects(below) {
            legend = legend.translate(vec2(0.0, below.top() - GAP - legend.bottom()));
        }
    }
    Corners { caption, scale_bar, legend }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_egui::egui::Pos2;

    #[test]
    fn nothing_in_the_corners_overlaps() {
        for width in [150.0, 250.0, 330.0, 420.0, 484.0, 640.0, 700.0, 900.0, 2000.0] {
            for caption in [100.0, 320.0, 480.0_f32] {
                let view = Rect::from_min_size(Pos2::new(240.0, 36.0), vec2(width, 600.0));
                let caption = vec2(caption.min(width - 2.0 * MARGIN), 26.0);
                let found = corners(view, caption, vec2(156.0, 24.0), vec2(240.0, 300.0));
                let Corners { caption, scale_bar, legend } = found;
                for (a, b) in [(caption, scale_bar), (caption, legend), (scale_bar, legend)] {
                    assert!(!a.intersects(b), "{width}: {found:?}");
                }
                assert!(view.y_range().contains(legend.top()), "{width}: {found:?}");
            }
        }
    }

    #[test]
    fn the_legend_folds_by_itself_in_a_small_view() {
        let unfolded = vec2(240.0, 260.0);
        // The hole between the panels of windows of 1024x700 and 1440x900 at several sizes of the
        // interface.
        for (view, is_small) in [
            (vec2(484.0, 520.0), true),
            (vec2(420.0, 420.0), true),
            (vec2(900.0, 340.0), true),
            (vec2(900.0, 720.0), false),
            (vec2(600.0, 400.0), false),
        ] {
            assert_eq!(is_folded(None, view, unfolded), is_small, "{view:?}");
            for choice in [true, false] {
                assert_eq!(is_folded(Some(choice), view, unfolded), choice);
            }
        }
        assert!(is_folded(None, vec2(900.0, 720.0), vec2(240.0, 600.0)));
    }

    #[test]
    fn two_clicks_leave_the_legend_to_itself() {
        for view in [vec2(484.0, 520.0), vec2(900.0, 720.0)] {
            let unfolded = vec2(240.0, 260.0);
            let by_itself = is_folded(None, view, unfolded);
            let once = after_click(None, view, unfolded);
            assert_eq!(once, Some(!by_itself));
            assert_eq!(after_click(once, view, unfolded), None);
        }
    }
}
