//! The colours of things in a scene, by role, on a dark and on a light ground.

use trackwright_design::BodyRole;
use trackwright_geometry::color::{fractions, lightness, srgb_from_linear, with_lightness};

/// What colours are seen on: dark, as the eye wants it in a dim room, or light, as paper is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Ground {
    #[default]
    Dark,
    Light,
}

/// A role's sRGB colour of eight bits a channel, on a dark and on a light ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rgb {
    dark: [u8; 3],
    light: [u8; 3],
}

impl Rgb {
    /// The same on both.
    pub const fn same(srgb: [u8; 3]) -> Self {
        Self { dark: srgb, light: srgb }
    }

    /// The same colour on both grounds, as `0xRRGGBB`.
    pub const fn hex(code: u32) -> Self {
        Self::same(channels(code))
    }

    /// A colour for each ground, as `0xRRGGBB`.
    pub const fn pair(dark: u32, light: u32) -> Self {
        Self { dark: channels(dark), light: channels(light) }
    }

    /// The colour for a ground.
    pub fn on(self, ground: Ground) -> [u8; 3] {
        match ground {
            Ground::Dark => self.dark,
            Ground::Light => self.light,
        }
    }
}

const fn channels(code: u32) -> [u8; 3] {
    [(code >> 16) as u8, (code >> 8) as u8, code as u8]
}

// No two things that are drawn together share a colour; a test of the editor compares them.

// What a figure means; a sign always stands beside the colour.
pub const MET: Rgb = Rgb::pair(0x3FB37F, 0x1B7F52);
pub const MISSED: Rgb = Rgb::pair(0xF2994A, 0xAB5600);

pub const TOOL: Rgb = Rgb::pair(0xB9B4AC, 0x4E4A44);
pub const CRF: Rgb = Rgb::pair(0x4F8C8A, 0x14555F);
pub const BONE: Rgb = Rgb::pair(0xE3D9C6, 0xA8997C);
pub const SENSOR: Rgb = Rgb::pair(0xF2B134, 0x9A5B00);
pub const SENSOR_AXIS: Rgb = Rgb::pair(0xFFD88A, 0xA86A00);
pub const OUTSIDE: Rgb = Rgb::pair(0xFF3B30, 0xD00000);
pub const ERROR_VECTOR: Rgb = Rgb::pair(0xE63FB8, 0xC4108F);
pub const GHOST: Rgb = Rgb::pair(0x45D3E8, 0x0B8DA3);
/// The sphere that the tip's error vector should end in.
pub const REQUIREMENT: Rgb = Rgb::pair(0xF4EE8C, 0x6B7A00);
/// Where the tracker's jitter puts the tip.
pub const SCATTER: Rgb = Rgb::pair(0x4A7BFF, 0x0040C0);
/// What the tool's range of motion runs through.
pub const MOTION: Rgb = Rgb::pair(0xD9A07A, 0x7A3B2E);
/// The best place that was found for a sensor.
pub const BEST_PLACE: Rgb = Rgb::pair(0xB8F53D, 0x86A800);
/// Where sensors may be mounted, and where no coil may be.
pub const MOUNTING: Rgb = Rgb::pair(0x12E892, 0x00C04E);
pub const FORBIDDEN: Rgb = Rgb::pair(0xC8143C, 0x8E0024);
pub const AXIS_X: Rgb = Rgb::pair(0xE06C6C, 0xC23B3B);
pub const AXIS_Y: Rgb = Rgb::pair(0x7CC47C, 0x4C8F1E);
pub const AXIS_Z: Rgb = Rgb::pair(0x6C9CF0, 0x2F62C9);
/// Of x, y, z.
pub const AXES: [Rgb; 3] = [AXIS_X, AXIS_Y, AXIS_Z];
pub const VOLUME: Rgb = Rgb::pair(0x8FB4E8, 0x4A78A0);
pub const MODEL_BOX: Rgb = Rgb::pair(0x8A93A0, 0x7C8796);
/// Where the room's model is valid.
pub const SUPPORT: Rgb = Rgb::pair(0x8C6CF0, 0x6B45C6);
/// The coils of a generator.
pub const COIL: Rgb = Rgb::pair(0xA87888, 0x6E3F5C);
// Metal in the room.
pub const ALUMINIUM: Rgb = Rgb::pair(0xA9B7C6, 0x6B7B8C);
pub const COPPER: Rgb = Rgb::pair(0xB4694A, 0x8F4A2C);
pub const BRONZE: Rgb = Rgb::pair(0x94733A, 0x705420);
pub const TITANIUM: Rgb = Rgb::pair(0x86808C, 0x5C5666);
pub const STEEL: Rgb = Rgb::pair(0x626D7A, 0x3F4954);
pub const FERRITE: Rgb = Rgb::pair(0x34373D, 0x26282C);
/// Of a material without a name.
pub const OTHER_METAL: Rgb = Rgb::pair(0x7C7F6E, 0x585B4A);
pub const GRID: Rgb = Rgb::pair(0x5A6675, 0xA9B2BD);

/// Between these, parts are distinguishable from the background and from glare.
const DARKEST: f64 = 0.03;
const BRIGHTEST: f64 = 0.62;

/// The sRGB colour of a part of a body, 0 to 1: the lightness of its own material (linear RGB) in the
/// hue of its role, so that grips stay dark and shafts stay bright.
pub fn of_part(role: BodyRole, own_linear: [f64; 3], ground: Ground) -> [f64; 3] {
    let role = match role {
        BodyRole::Tool => TOOL,
        BodyRole::Crf => CRF,
    };
    let own = lightness(own_linear.map(|part| srgb_from_linear(part.max(0.0))));
    with_lightness(fractions(role.on(ground)), own.clamp(DARKEST, BRIGHTEST))
}
