//! Widgets of egui that several panels share.

pub mod axis_ticks;
pub mod basic;
pub mod chart;
pub mod switch;
pub mod theme;
pub mod tooltip;
pub mod verdict;
