//! Every colour of pages and plots, by role; they stand on white.

use std::fmt;

/// An sRGB colour of eight bits a channel; printed as `#1D222A`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rgb(pub u8, pub u8, pub u8);

impl fmt::Display for Rgb {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(red, green, blue) = self;
        write!(f, "#{red:02X}{green:02X}{blue:02X}")
    }
}

pub const PAPER: Rgb = Rgb(0xFF, 0xFF, 0xFF);
pub const INK: Rgb = Rgb(0x1D, 0x22, 0x2A);
pub const INK_QUIET: Rgb = Rgb(0x5B, 0x65, 0x72);
/// Axis lines.
pub const LINE: Rgb = Rgb(0x8A, 0x93, 0xA0);
pub const GRID: Rgb = Rgb(0xDD, 0xE1, 0xE7);
pub const GRID_MINOR: Rgb = Rgb(0xF0, 0xF2, 0xF5);
/// A required level.
pub const BOUND: Rgb = INK;
/// The best that anything in a chart does, behind its points.
pub const FRONT: Rgb = Rgb(0xC3, 0xCB, 0xD6);

/// Series in turn: those of Okabe and Ito (2008) that stand out from white, distinguishable with
/// any kind of colour vision.
pub const SERIES: [Rgb; 7] = [
    Rgb(0x00, 0x72, 0xB2),
    Rgb(0xD5, 0x5E, 0x00),
    Rgb(0x00, 0x9E, 0x73),
    Rgb(0xCC, 0x79, 0xA7),
    Rgb(0xE6, 0x9F, 0x00),
    Rgb(0x56, 0xB4, 0xE9),
    Rgb(0x3B, 0x3B, 0x3B),
];

/// The one colour of a page that is not ink.
pub const ACCENT: Rgb = Rgb(0x00, 0x5F, 0x9E);
/// A requirement that is met, and one that is missed; always with a word.
pub const MET: Rgb = Rgb(0x1E, 0x7A, 0x4C);
pub const MISSED: Rgb = Rgb(0xB3, 0x4A, 0x00);
/// Shapes on drawings: the tool, the reference, a coil.
pub const METAL: Rgb = Rgb(0xE9, 0xEC, 0xF0);
pub const REFERENCE: Rgb = Rgb(0xD9, 0xE8, 0xE8);
pub const COIL: Rgb = Rgb(0xD9, 0x8A, 0x00);
