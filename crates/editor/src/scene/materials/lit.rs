//! The material of bodies, under light that stays with the viewer: a soft key over the shoulder, a
//! weaker fill, and a faint room that is brighter above.

use crate::palette;
use crate::palette::ThemedColor;
use bevy::asset::{load_internal_asset, uuid_handle};
use bevy::prelude::*;
use bevy::render::render_resource::{AsBindGroup, ShaderType};
use bevy::shader::ShaderRef;

const LIT_SHADER: Handle<Shader> = uuid_handle!("c1a5be20-93d4-4f1c-8a6e-5b7f0d2e9c34");

/// Towards the lights, in the camera's axes: x right, y up, z to the viewer.
const KEY_FROM: Vec3 = Vec3::new(0.9, 1.3, 1.2);
const FILL_FROM: Vec3 = Vec3::new(-1.4, 0.1, 0.7);

/// How much light comes from where, chosen by eye so that steel reads as steel before a dark
/// ground and nothing is burnt out.
const KEY_STRENGTH: f32 = 0.85;
const FILL_STRENGTH: f32 = 0.22;
const ROOM_STRENGTH: f32 = 0.30;

/// Adds [`LitMaterial`].
pub(crate) struct LitPlugin;

impl Plugin for LitPlugin {
    fn build(&self, app: &mut App) {
        load_internal_asset!(app, LIT_SHADER, "lit.wgsl", Shader::from_wgsl);
        app.add_plugins(MaterialPlugin::<LitMaterial>::default());
    }
}

/// A lit, opaque surface.
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
pub struct LitMaterial {
    #[uniform(0)]
    pub lit: Lit,
}

/// What the shader reads.
#[derive(ShaderType, Clone, Copy, Debug)]
pub struct Lit {
    pub color: LinearRgba,
    /// Metal and roughness, each from 0 to 1.
    pub surface: Vec4,
    key_from: Vec4,
    fill_from: Vec4,
    key: LinearRgba,
    fill: LinearRgba,
    above: LinearRgba,
    around: LinearRgba,
    below: LinearRgba,
}

impl LitMaterial {
    /// Of a colour that is more or less a metal's, from 0 to 1, and more or less rough.
    pub fn new(color: Color, metallic: f32, roughness: f32) -> Self {
        let light = |color: palette::Rgb, strength: f32| color.color().to_linear() * strength;
        Self {
            lit: Lit {
                color: color.to_linear(),
                surface: Vec4::new(metallic, roughness, 0.0, 0.0),
                key_from: KEY_FROM.normalize().extend(0.0),
                fill_from: FILL_FROM.normalize().extend(0.0),
                key: light(palette::KEY_LIGHT, KEY_STRENGTH),
                fill: light(palette::FILL_LIGHT, FILL_STRENGTH),
                above: light(palette::ROOM_ABOVE, ROOM_STRENGTH),
                around: light(palette::ROOM_AROUND, ROOM_STRENGTH),
                below: light(palette::ROOM_BELOW, ROOM_STRENGTH),
            },
        }
    }
}

impl Material for LitMaterial {
    fn fragment_shader() -> ShaderRef {
        LIT_SHADER.into()
    }

    fn enable_prepass() -> bool {
        false
    }

    fn enable_shadows() -> bool {
        false
    }
}
