//! Every colour of the program, by role: those of things in a scene are the core's, which exports
//! them too, all others are named here and nowhere else.

use bevy::color::{Alpha, Color};
use bevy::ecs::resource::Resource;
use bevy_egui::egui::Color32;
use std::sync::atomic::{AtomicBool, Ordering};
pub use trackwright_scene::palette::{
    AXES, AXIS_X, AXIS_Y, AXIS_Z, BEST_PLACE, BONE, COIL, CRF, ERROR_VECTOR, FORBIDDEN, GHOST,
    GRID, Ground, MET, MISSED, MODEL_BOX, MOTION, MOUNTING, OUTSIDE, REQUIREMENT, Rgb, SCATTER,
    SENSOR, SENSOR_AXIS, SUPPORT, TOOL, VOLUME,
};

/// Whether what is drawn now is dark on light. One flag for the whole program: a window has one
/// theme, and colours are read in every part of it.
static IS_LIGHT: AtomicBool = AtomicBool::new(false);

/// Dark, as the eye wants it in a dim room, or light, for daylight and paper.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Theme {
    #[default]
    Dark,
    Light,
}

impl Theme {
    /// From now on every colour is this theme's.
    pub fn apply(self) {
        IS_LIGHT.store(self == Self::Light, Ordering::Relaxed);
    }

    /// The one that was applied last.
    pub fn now() -> Self {
        match IS_LIGHT.load(Ordering::Relaxed) {
            false => Self::Dark,
            true => Self::Light,
        }
    }

    pub fn other(self) -> Self {
        match self {
            Self::Dark => Self::Light,
            Self::Light => Self::Dark,
        }
    }

    /// What its colours are seen on.
    pub fn ground(self) -> Ground {
        match self {
            Self::Dark => Ground::Dark,
            Self::Light => Ground::Light,
        }
    }
}

/// A role's colour in the theme of now, for whoever draws.
pub trait ThemedColor {
    /// In the theme of now.
    fn srgb(self) -> [u8; 3];

    /// For egui.
    fn color32(self) -> Color32;

    /// For egui, with an opacity from 0 to 255.
    fn color32_alpha(self, alpha: u8) -> Color32;

    /// For Bevy.
    fn color(self) -> Color;

    /// For Bevy, with an opacity from 0 to 1.
    fn color_alpha(self, alpha: f32) -> Color;
}

impl ThemedColor for Rgb {
    fn srgb(self) -> [u8; 3] {
        self.on(Theme::now().ground())
    }

    fn color32(self) -> Color32 {
        let [r, g, b] = self.srgb();
        Color32::from_rgb(r, g, b)
    }

    fn color32_alpha(self, alpha: u8) -> Color32 {
        let [r, g, b] = self.srgb();
        Color32::from_rgba_unmultiplied(r, g, b, alpha)
    }

    fn color(self) -> Color {
        let [r, g, b] = self.srgb();
        Color::srgb_u8(r, g, b)
    }

    fn color_alpha(self, alpha: f32) -> Color {
        self.color().with_alpha(alpha)
    }
}

// The interface.
pub const BACKGROUND: Rgb = Rgb::pair(0x12151A, 0xDDE2E8);
pub const PANEL: Rgb = Rgb::pair(0x191D24, 0xF6F7F9);
/// Fields that take text or numbers.
pub const FIELD: Rgb = Rgb::pair(0x101318, 0xFFFFFF);
pub const WIDGET: Rgb = Rgb::pair(0x232932, 0xE7EAEE);
pub const WIDGET_HOVERED: Rgb = Rgb::pair(0x2D3541, 0xD8DDE4);
pub const LINE: Rgb = Rgb::pair(0x2A303A, 0xC6CCD5);
pub const TEXT: Rgb = Rgb::pair(0xD7DCE3, 0x232930);
pub const TEXT_QUIET: Rgb = Rgb::pair(0x8A93A0, 0x4A5460);
pub const TEXT_STRONG: Rgb = Rgb::pair(0xF4F6F8, 0x0C0F13);
pub const ACCENT: Rgb = Rgb::pair(0x4FA3FF, 0x1766D0);
pub const SHADOW: Rgb = Rgb::hex(0x000000);

/// How opaque the plates behind writing in the 3D view are: lines of the scene do not strike it
/// through.
pub const PLATE_ALPHA: u8 = 215;

/// The plate behind writing in the 3D view, in the theme of now. In the light one it is opaque: what
/// is translucent is blended darker there, and looks grey beside the panels.
pub fn plate() -> Color32 {
    match Theme::now() {
        Theme::Dark => PANEL.color32_alpha(PLATE_ALPHA),
        Theme::Light => PANEL.color32(),
    }
}

// What a figure means; a sign always stands beside the colour.
pub const ERROR: Rgb = Rgb::pair(0xF05D5E, 0xC0282A);

// Things in the scene.
pub const GENERATOR: Rgb = Rgb::pair(0x3A3F47, 0x5A626D);
pub const SELECTED: Rgb = Rgb::pair(0xFFFFFF, 0x0C0F13);
/// A pinned design beside the one that is worked on.
pub const BASELINE: Rgb = Rgb::pair(0xC9A0FF, 0xA020C0);
/// The built tool as it was measured at a recorded pose, in the scene and in charts.
pub const MEASURED: Rgb = Rgb::pair(0xFF7A1A, 0xE05A00);
/// Places that a search found for sensors, in the scene and in small pictures.
pub const FOUND_PLACE: Rgb = Rgb::pair(0x2DFF00, 0x007800);
/// Metal that was found in measurements.
pub const FOUND_METAL: Rgb = Rgb::pair(0xBC9D00, 0x4C3F00);
/// The ball that moves the slice.
pub const SLICE_HANDLE: Rgb = Rgb::pair(0x7FFFD4, 0x00A884);

// Anatomy that is not bone, the same on any ground: a design keeps what was chosen.
pub const SKIN: Rgb = Rgb::hex(0xE0AC94);
pub const VESSEL: Rgb = Rgb::hex(0xC8504B);
pub const ORGAN: Rgb = Rgb::hex(0xA8697E);
pub const EQUIPMENT: Rgb = Rgb::hex(0x8FA3B5);

/// Series of a chart in turn: those of Okabe and Ito (2008) that stand out from a dark ground,
/// distinguishable with any kind of colour vision.
pub const SERIES: [Rgb; 7] = [
    Rgb::hex(0x56B4E9),
    Rgb::hex(0xE69F00),
    Rgb::hex(0x009E73),
    Rgb::hex(0xF0E442),
    Rgb::hex(0xCC79A7),
    Rgb::hex(0xD55E00),
    Rgb::hex(0xBBBBBB),
];

// Light.
pub const KEY_LIGHT: Rgb = Rgb::hex(0xFFF6EA);
pub const FILL_LIGHT: Rgb = Rgb::hex(0xD6E4FF);
pub const ROOM_ABOVE: Rgb = Rgb::hex(0xF2F5FA);
pub const ROOM_AROUND: Rgb = Rgb::hex(0x7C8694);
pub const ROOM_BELOW: Rgb = Rgb::hex(0x2A2E36);

/// The colour of a part of a body: the lightness of its own material in the hue of its role, so
/// that grips stay dark and shafts stay bright.
pub fn of_part(role: trackwright_design::BodyRole, own: bevy::color::LinearRgba) -> Color {
    let own = [own.red, own.green, own.blue].map(f64::from);
    let [r, g, b] = trackwright_scene::palette::of_part(role, own, Theme::now().ground());
    Color::srgb(r as f32, g as f32, b as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of text on its ground, the least of the Web Content Accessibility Guidelines (level AA).
    const LEAST_CONTRAST: f64 = 4.5;

    fn channels(color: [u8; 3]) -> [f64; 3] {
        color.map(|channel| f64::from(channel) / 255.0)
    }

    fn luminance(color: [f64; 3]) -> f64 {
        let [r, g, b] = color.map(|channel| match channel <= 0.04045 {
            true => channel / 12.92,
            false => ((channel + 0.055) / 1.055).powf(2.4),
        });
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    fn contrast(one: [f64; 3], other: [f64; 3]) -> f64 {
        let (one, other) = (luminance(one) + 0.05, luminance(other) + 0.05);
        one.max(other) / one.min(other)
    }

    /// A plate with something of the scene behind it.
    fn plate_over(scene: [f64; 3], ground: Ground) -> [f64; 3] {
        let opacity = f64::from(PLATE_ALPHA) / 255.0;
        let plate = channels(PANEL.on(ground));
        std::array::from_fn(|k| opacity * plate[k] + (1.0 - opacity) * scene[k])
    }

    #[test]
    fn black_on_white_has_a_contrast_of_21() {
        assert!((contrast([0.0; 3], [1.0; 3]) - 21.0).abs() < 1e-12);
        assert!((contrast([0.3; 3], [0.3; 3]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn writing_on_panels_and_plates_is_readable() {
        let colors = [TEXT, TEXT_QUIET, TEXT_STRONG, ACCENT, ERROR, MET, MISSED];
        for ground in [Ground::Dark, Ground::Light] {
            let behind = channels(BACKGROUND.on(ground));
            for under in [channels(PANEL.on(ground)), plate_over(behind, ground)] {
                for color in colors {
                    let found = contrast(channels(color.on(ground)), under);
                    assert!(found >= LEAST_CONTRAST, "{color:?} {ground:?}: {found}");
                }
            }
        }
    }

    #[test]
    fn text_on_a_plate_is_readable_over_anything() {
        for ground in [Ground::Dark, Ground::Light] {
            for scene in [[0.0; 3], [1.0; 3]] {
                for color in [TEXT, TEXT_STRONG] {
                    let found = contrast(channels(color.on(ground)), plate_over(scene, ground));
                    assert!(found >= LEAST_CONTRAST, "{color:?} {ground:?}: {found}");
                }
            }
        }
    }
}
