//! The marks of a small chart: as few as can be read, at 1, 2 or 5 times a power of ten.

use crate::widgets::basic::decimal;
use crate::widgets::theme;
use bevy_egui::egui::{Sense, TextStyle, Ui};
use egui_plot::{GridInput, GridMark, Plot};
use std::ops::RangeInclusive;
use trackwright_report::plot::nice_step;

/// Marks of an axis, at most so many steps apart from end to end.
pub fn axis_ticks(most: usize) -> impl Fn(GridInput) -> Vec<GridMark> {
    move |input: GridInput| {
        let (low, high) = input.bounds;
        let extent = high - low;
        if !(extent > 0.0 && extent.is_finite()) {
            return Vec::new();
        }
        // One number alone gives no scale: steps are smaller until there are two.
        let found = (most.max(1)..=most + MOST_TRIES).find_map(|most| {
            let step_size = nice_step(extent / most as f64, false);
            let (first, last) = ((low / step_size).ceil(), (high / step_size).floor());
            (last - first >= 1.0).then_some((step_size, first, (last - first) as usize))
        });
        let Some((step_size, first, steps)) = found else { return Vec::new() };
        (0..=steps).map(|k| GridMark { value: (first + k as f64) * step_size, step_size }).collect()
    }
}

/// Two marks lie within any extent of this many steps; smaller steps are tried up to then.
const MOST_TRIES: usize = 8;

/// The value of a mark with as many decimals as its step needs.
pub fn mark_text(mark: GridMark) -> String {
    let decimals = (-mark.step_size.log10().floor()).clamp(0.0, 6.0) as usize;
    decimal(mark.value, decimals)
}

/// Within it plots write their marks as small as labels.
pub fn small_marks<R>(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> R) -> R {
    ui.scope(|ui| {
        let styles = &mut ui.style_mut().text_styles;
        styles.insert(TextStyle::Body, theme::label_font());
        add(ui)
    })
    .inner
}

/// Steps between marks, along and up.
const STEPS: [usize; 2] = [4, 3];

/// A chart of a panel that stays as it is and can be clicked.
pub fn small_plot(name: &str, height: f32) -> Plot<'_> {
    Plot::new(name)
        .height(height)
        .show_grid([false, true])
        .x_grid_spacer(axis_ticks(STEPS[0]))
        .y_grid_spacer(axis_ticks(STEPS[1]))
        .y_axis_min_width(38.0)
        .x_axis_formatter(|mark: GridMark, _: &RangeInclusive<f64>| mark_text(mark))
        .y_axis_formatter(|mark: GridMark, _: &RangeInclusive<f64>| mark_text(mark))
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .sense(Sense::click())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marks(bounds: (f64, f64), most: usize) -> Vec<String> {
        let input = GridInput { bounds, base_step_size: 1.0 };
        axis_ticks(most)(input).into_iter().map(mark_text).collect()
    }

    #[test]
    fn marks_are_few_and_have_the_decimals_that_they_need() {
        assert_eq!(marks((0.0, 1.1), 3), ["0.0", "0.5", "1.0"]);
        assert_eq!(marks((0.0, 430.0), 3), ["0", "200", "400"]);
        assert_eq!(marks((-21.0, 21.0), 4), ["\u{2212}20", "0", "20"]);
        assert!(marks((1.0, 1.0), 3).is_empty());
    }

    #[test]
    fn no_axis_has_a_single_mark() {
        for reach in [10.0, 45.0, 52.5, 60.0, 90.0] {
            for most in 1..6 {
                assert!(marks((-reach, reach), most).len() >= 2, "{reach} {most}");
            }
        }
    }
}
