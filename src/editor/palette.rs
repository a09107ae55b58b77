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
pub const BACKGROUND: Rgb = Rgb::hex(0x12_15_1A);
pub const PANEL: Rgb = Rgb::hex(0x19_1D_24);
/// Fields that take text or numbers.
pub const FIELD: Rgb = Rgb::hex(0x10_13_18);
pub const WIDGET: Rgb = Rgb::hex(0x23_29_32);
pub const WIDGET_HOVERED: Rgb = Rgb::hex(0x2D_35_41);
pub const LINE: Rgb = Rgb::hex(0x2A_30_3A);
pub const TEXT: Rgb = Rgb::hex(0xD7_DC_E3);
pub const TEXT_QUIET: Rgb = Rgb::hex(0x8A_93_A0);
pub const TEXT_STRONG: Rgb = Rgb::hex(0xF4_F6_F8);
pub const ACCENT: Rgb = Rgb::hex(0x4F_A3_FF);
pub const SHADOW: Rgb = Rgb::hex(0x00_00_00);

// What a figure means; a sign always stands beside the colour.
pub const MET: Rgb = Rgb::hex(0x3F_B3_7F);
pub const MISSED: Rgb = Rgb::hex(0xF2_99_4A);
pub const ERROR: Rgb = Rgb::hex(0xF0_5D_5E);

// Things in the scene.
pub const TOOL: Rgb = Rgb::hex(0xB9_B4_AC);
pub const CRF: Rgb = Rgb::hex(0x4F_8C_8A);
pub const BONE: Rgb = Rgb::hex(0xE3_D9_C6);
pub const GENERATOR: Rgb = Rgb::hex(0x3A_3F_47);
pub const SENSOR: Rgb = Rgb::hex(0xF2_B1_34);
pub const SENSOR_AXIS: Rgb = Rgb::hex(0xFF_D8_8A);
pub const SELECTED: Rgb = Rgb::hex(0xFF_FF_FF);
pub const OUTSIDE: Rgb = Rgb::hex(0xE0_4F_4F);
pub const ERROR_VECTOR: Rgb = Rgb::hex(0xE6_3F_B8);
pub const GHOST: Rgb = Rgb::hex(0x45_D3_E8);
pub const AXIS_X: Rgb = Rgb::hex(0xE0_6C_6C);
pub const AXIS_Y: Rgb = Rgb::hex(0x7C_C4_7C);
pub const AXIS_Z: Rgb = Rgb::hex(0x6C_9C_F0);
pub const VOLUME: Rgb = Rgb::hex(0x8F_B4_E8);
pub const MODEL_BOX: Rgb = Rgb::hex(0x8A_93_A0);
pub const GRID: Rgb = Rgb::hex(0x4A_53_60);
/// Error vectors over coloured maps.
pub const ERROR_VECTOR_ON_MAP: Rgb = Rgb::hex(0xFF_FF_FF);

// Light.
pub const KEY_LIGHT: Rgb = Rgb::hex(0xFF_F6_EA);
pub const FILL_LIGHT: Rgb = Rgb::hex(0xD6_E4_FF);
pub const ROOM_ABOVE: Rgb = Rgb::hex(0xF2_F5_FA);
pub const ROOM_AROUND: Rgb = Rgb::hex(0x7C_86_94);
pub const ROOM_BELOW: Rgb = Rgb::hex(0x2A_2E_36);

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
