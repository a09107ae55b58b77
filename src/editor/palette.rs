//! Every colour of the program, by role. Nothing else names a colour.

use bevy::color::{Alpha, Color};
use bevy_egui::egui::Color32;

/// An sRGB colour of eight bits a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rgb(pub [u8; 3]);

impl Rgb {
    const fn hex(code: u32) -> Self {
        Self([(code >> 16) as u8, (code >> 8) as u8, code as u8])
    }

    /// For egui.
    pub const fn color32(self) -> Color32 {
        let [r, g, b] = self.0;
        Color32::from_rgb(r, g, b)
    }

    /// For egui, with an opacity from 0 to 255.
    pub fn color32_alpha(self, alpha: u8) -> Color32 {
        let [r, g, b] = self.0;
        Color32::from_rgba_unmultiplied(r, g, b, alpha)
    }

    /// For Bevy.
    pub fn color(self) -> Color {
        let [r, g, b] = self.0;
        Color::srgb_u8(r, g, b)
    }

    /// For Bevy, with an opacity from 0 to 1.
    pub fn color_alpha(self, alpha: f32) -> Color {
        self.color().with_alpha(alpha)
    }
}

// The interface.
pub const BACKGROUND: Rgb = Rgb::hex(0x12151A);
pub const PANEL: Rgb = Rgb::hex(0x191D24);
/// Fields that take text or numbers.
pub const FIELD: Rgb = Rgb::hex(0x101318);
pub const WIDGET: Rgb = Rgb::hex(0x232932);
pub const WIDGET_HOVERED: Rgb = Rgb::hex(0x2D3541);
pub const LINE: Rgb = Rgb::hex(0x2A303A);
pub const TEXT: Rgb = Rgb::hex(0xD7DCE3);
pub const TEXT_QUIET: Rgb = Rgb::hex(0x8A93A0);
pub const TEXT_STRONG: Rgb = Rgb::hex(0xF4F6F8);
pub const ACCENT: Rgb = Rgb::hex(0x4FA3FF);
pub const SHADOW: Rgb = Rgb::hex(0x000000);

// What a figure means; a sign always stands beside the colour.
pub const MET: Rgb = Rgb::hex(0x3FB37F);
pub const MISSED: Rgb = Rgb::hex(0xF2994A);
pub const ERROR: Rgb = Rgb::hex(0xF05D5E);

// Things in the scene.
pub const TOOL: Rgb = Rgb::hex(0xB9B4AC);
pub const CRF: Rgb = Rgb::hex(0x4F8C8A);
pub const BONE: Rgb = Rgb::hex(0xE3D9C6);
pub const GENERATOR: Rgb = Rgb::hex(0x3A3F47);
pub const SENSOR: Rgb = Rgb::hex(0xF2B134);
pub const SENSOR_AXIS: Rgb = Rgb::hex(0xFFD88A);
pub const SELECTED: Rgb = Rgb::hex(0xFFFFFF);
pub const OUTSIDE: Rgb = Rgb::hex(0xE04F4F);
pub const ERROR_VECTOR: Rgb = Rgb::hex(0xE63FB8);
pub const GHOST: Rgb = Rgb::hex(0x45D3E8);
pub const AXIS_X: Rgb = Rgb::hex(0xE06C6C);
pub const AXIS_Y: Rgb = Rgb::hex(0x7CC47C);
pub const AXIS_Z: Rgb = Rgb::hex(0x6C9CF0);
pub const VOLUME: Rgb = Rgb::hex(0x8FB4E8);
pub const MODEL_BOX: Rgb = Rgb::hex(0x8A93A0);
pub const GRID: Rgb = Rgb::hex(0x4A5360);
/// Error vectors over coloured maps.
pub const ERROR_VECTOR_ON_MAP: Rgb = Rgb::hex(0xFFFFFF);

/// Series of a chart in turn: those of Okabe and Ito (2008) that stand out from a dark ground,
/// told apart with any kind of colour vision.
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

/// Between these, parts are told from the background and from glare.
const DARKEST: f32 = 0.03;
const BRIGHTEST: f32 = 0.62;

/// The colour of a part of a body: the lightness of its own material in the hue of its role, so
/// that grips stay dark and shafts stay bright.
pub fn of_part(role: crate::design::BodyRole, own: bevy::color::LinearRgba) -> Color {
    use bevy::color::{Hsla, LinearRgba, Luminance};
    let role_color = match role {
        crate::design::BodyRole::Tool => TOOL.color(),
        crate::design::BodyRole::Crf => CRF.color(),
    };
    let lightness = Hsla::from(LinearRgba { alpha: 1.0, ..own }).lightness;
    Color::from(Hsla::from(role_color).with_luminance(lightness.clamp(DARKEST, BRIGHTEST)))
}
