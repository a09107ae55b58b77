//! Every colour of the program, by role. Nothing else names a colour.

use bevy::color::{Alpha, Color};
use bevy::ecs::resource::Resource;
use bevy_egui::egui::Color32;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether what is drawn now is dark on light. One flag for the whole program: a window has one
/// theme, and colours are asked for in every corner of it.
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
}

/// A role's sRGB colour of eight bits a channel, in the dark and the light theme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rgb {
    dark: [u8; 3],
    light: [u8; 3],
}

impl Rgb {
    /// The same in both themes.
    pub const fn same(srgb: [u8; 3]) -> Self {
        Self {
            dark: srgb,
            light: srgb,
        }
    }

    const fn hex(code: u32) -> Self {
        Self::same(channels(code))
    }

    const fn pair(dark: u32, light: u32) -> Self {
        Self {
            dark: channels(dark),
            light: channels(light),
        }
    }

    /// In the theme of now.
    pub fn srgb(self) -> [u8; 3] {
        match Theme::now() {
            Theme::Dark => self.dark,
            Theme::Light => self.light,
        }
    }

    /// For egui.
    pub fn color32(self) -> Color32 {
        let [r, g, b] = self.srgb();
        Color32::from_rgb(r, g, b)
    }

    /// For egui, with an opacity from 0 to 255.
    pub fn color32_alpha(self, alpha: u8) -> Color32 {
        let [r, g, b] = self.srgb();
        Color32::from_rgba_unmultiplied(r, g, b, alpha)
    }

    /// For Bevy.
    pub fn color(self) -> Color {
        let [r, g, b] = self.srgb();
        Color::srgb_u8(r, g, b)
    }

    /// For Bevy, with an opacity from 0 to 1.
    pub fn color_alpha(self, alpha: f32) -> Color {
        self.color().with_alpha(alpha)
    }
}

const fn channels(code: u32) -> [u8; 3] {
    [(code >> 16) as u8, (code >> 8) as u8, code as u8]
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

// What a figure means; a sign always stands beside the colour.
pub const MET: Rgb = Rgb::pair(0x3FB37F, 0x1B7F52);
pub const MISSED: Rgb = Rgb::pair(0xF2994A, 0xB15A00);
pub const ERROR: Rgb = Rgb::pair(0xF05D5E, 0xC0282A);

// Things in the scene.
pub const TOOL: Rgb = Rgb::pair(0xB9B4AC, 0x4E4A44);
pub const CRF: Rgb = Rgb::pair(0x4F8C8A, 0x1F5F5D);
pub const BONE: Rgb = Rgb::pair(0xE3D9C6, 0xA8997C);
pub const GENERATOR: Rgb = Rgb::pair(0x3A3F47, 0x5A626D);
pub const SENSOR: Rgb = Rgb::pair(0xF2B134, 0x9A5B00);
pub const SENSOR_AXIS: Rgb = Rgb::pair(0xFFD88A, 0xA86A00);
pub const SELECTED: Rgb = Rgb::pair(0xFFFFFF, 0x0C0F13);
pub const OUTSIDE: Rgb = Rgb::pair(0xE04F4F, 0xC8282A);
pub const ERROR_VECTOR: Rgb = Rgb::pair(0xE63FB8, 0xC4108F);
pub const GHOST: Rgb = Rgb::pair(0x45D3E8, 0x0B8DA3);
/// What the tool's range of motion runs through.
pub const MOTION: Rgb = Rgb::pair(0xB9A6E8, 0x5B3FA0);
pub const AXIS_X: Rgb = Rgb::pair(0xE06C6C, 0xC23B3B);
pub const AXIS_Y: Rgb = Rgb::pair(0x7CC47C, 0x2F8A3A);
pub const AXIS_Z: Rgb = Rgb::pair(0x6C9CF0, 0x2F62C9);
pub const VOLUME: Rgb = Rgb::pair(0x8FB4E8, 0x3A66A8);
pub const MODEL_BOX: Rgb = Rgb::pair(0x8A93A0, 0x6B7683);
/// Where the room's model may be believed.
pub const SUPPORT: Rgb = Rgb::pair(0xA98BF0, 0x6B45C6);
pub const GRID: Rgb = Rgb::pair(0x4A5360, 0xA9B2BD);
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
