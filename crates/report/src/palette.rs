//! Every colour of pages and plots, by role; they stand on white.

use plotters::style::RGBColor;

pub const PAPER: RGBColor = RGBColor(0xFF, 0xFF, 0xFF);
pub const INK: RGBColor = RGBColor(0x1D, 0x22, 0x2A);
pub const INK_QUIET: RGBColor = RGBColor(0x5B, 0x65, 0x72);
/// Axis lines.
pub const LINE: RGBColor = RGBColor(0x8A, 0x93, 0xA0);
pub const GRID: RGBColor = RGBColor(0xDD, 0xE1, 0xE7);
pub const GRID_MINOR: RGBColor = RGBColor(0xF0, 0xF2, 0xF5);
/// A level that is asked for.
pub const BOUND: RGBColor = INK;
/// The best that anything in a chart does, behind its points.
pub const FRONT: RGBColor = RGBColor(0xC3, 0xCB, 0xD6);

/// Series in turn: those of Okabe and Ito (2008) that stand out from white, told apart with any
/// kind of colour vision.
pub const SERIES: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x9E, 0x73),
    RGBColor(0xCC, 0x79, 0xA7),
    RGBColor(0xE6, 0x9F, 0x00),
    RGBColor(0x56, 0xB4, 0xE9),
    RGBColor(0x3B, 0x3B, 0x3B),
];

/// The one colour of a page that is not ink.
pub const ACCENT: RGBColor = RGBColor(0x00, 0x5F, 0x9E);
/// A requirement that is met, and one that is missed; always with a word.
pub const MET: RGBColor = RGBColor(0x1E, 0x7A, 0x4C);
pub const MISSED: RGBColor = RGBColor(0xB3, 0x4A, 0x00);
/// Shapes on drawings: the tool, the reference, a coil.
pub const METAL: RGBColor = RGBColor(0xE9, 0xEC, 0xF0);
pub const REFERENCE: RGBColor = RGBColor(0xD9, 0xE8, 0xE8);
pub const COIL: RGBColor = RGBColor(0xD9, 0x8A, 0x00);
