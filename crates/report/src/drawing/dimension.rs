//! Dimension lines: a length between two places, with arrows at its ends.

use super::dimension_text;
use super::paper::{line, px, text};
use maud::{Markup, html};

/// An arrow's length and half its width.
const ARROW_PX: [f64; 2] = [8.0, 2.5];

/// Shorter dimensions have their arrows and their number outside.
const LEAST_INSIDE_PX: f64 = 44.0;

/// How far an extension line goes beyond the dimension line, and how far from its object it begins.
const BEYOND_PX: f64 = 4.0;

/// Width of a digit of a dimension's text.
const DIGIT_PX: f64 = 8.0;

/// A dimension along the paper's x, its line at height `at_px`; extension lines come from
/// `from_px` heights.
pub fn across(ends_px: [f64; 2], from_px: f64, at_px: f64, length_mm: f64) -> Markup {
    let down = if at_px > from_px { BEYOND_PX } else { -BEYOND_PX };
    html! {
        @for x in ends_px {
            (line("extension", [x, from_px], [x, at_px + down]))
        }
        (dimension_line(ends_px, length_mm, |along, off| [along, at_px + off], false))
    }
}

/// A dimension along the paper's y, its line at `at_px` from the left.
pub fn upright(ends_px: [f64; 2], from_px: f64, at_px: f64, length_mm: f64) -> Markup {
    let out = if at_px > from_px { BEYOND_PX } else { -BEYOND_PX };
    html! {
        @for y in ends_px {
            (line("extension", [from_px, y], [at_px + out, y]))
        }
        (dimension_line(ends_px, length_mm, |along, off| [at_px + off, along], true))
    }
}

/// The line, its arrows and its number, in coordinates along it and off it.
fn dimension_line(
    ends_px: [f64; 2],
    length_mm: f64,
    place: impl Fn(f64, f64) -> [f64; 2],
    is_upright: bool,
) -> Markup {
    let [low, high] = [ends_px[0].min(ends_px[1]), ends_px[0].max(ends_px[1])];
    let is_inside = high - low >= LEAST_INSIDE_PX;
    let words = dimension_text(length_mm);
    // Outside, the line goes on to the number.
    let stub = 2.0 * ARROW_PX[0];
    let number_px = words.chars().count() as f64 * DIGIT_PX;
    let (line_from, line_to, number_at) = match is_inside {
        true => (low, high, (low + high) / 2.0),
        false => (low - stub, high + stub, high + stub + 2.0 + number_px / 2.0),
    };
    let arrow = |tip: f64, is_forward: bool| {
        let [long, half] = ARROW_PX;
        let back = if is_forward { tip - long } else { tip + long };
        let corners = [place(tip, 0.0), place(back, half), place(back, -half)];
        let points = corners.map(|[x, y]| format!("{x:.1},{y:.1}")).join(" ");
        html! { polygon class="arrow" points=(points) {} }
    };
    let at = place(number_at, if is_inside { -4.0 } else { 0.0 });
    html! {
        (line("dimension", place(line_from, 0.0), place(line_to, 0.0)))
        (arrow(low, !is_inside))
        (arrow(high, is_inside))
        @if is_upright && is_inside {
            text class="measure" text-anchor="middle" x=(px(at[0])) y=(px(at[1]))
                transform=(format!("rotate(-90 {:.1} {:.1})", at[0], at[1])) { (words) }
        } @else if is_inside {
            (text("measure", "middle", at, &words))
        } @else {
            (text("measure", "middle", [at[0], at[1] + if is_upright { 10.0 } else { 5.0 }], &words))
        }
    }
}

/// A bar of a round length of about `target_px`, its left end at a place.
pub fn scale_bar(at: [f64; 2], px_per_mm: f64, target_px: f64) -> Markup {
    let length_mm = trackwright_geometry::number::round_above(target_px / px_per_mm);
    let right = at[0] + length_mm * px_per_mm;
    html! {
        @for x in [at[0], right] {
            (line("scale-bar", [x, at[1] - 5.0], [x, at[1] + 5.0]))
        }
        (line("scale-bar", at, [right, at[1]]))
        (text("measure", "start", [right + 8.0, at[1] + 5.0], &format!("{}\u{2009}mm", dimension_text(length_mm))))
    }
}
