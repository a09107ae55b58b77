//! The material of glyphs: what no lamp lights, and what shines through what hides it.

use crate::palette::ThemedColor;
use crate::palette::{Rgb, Theme};
use bevy::asset::{load_internal_asset, uuid_handle};
use bevy::mesh::MeshVertexBufferLayoutRef;
use bevy::pbr::{MaterialPipeline, MaterialPipelineKey};
use bevy::prelude::*;
use bevy::render::render_resource::{
    AsBindGroup, CompareFunction, Face, RenderPipelineDescriptor, ShaderType,
    SpecializedMeshPipelineError,
};
use bevy::shader::ShaderRef;

const GLOW_SHADER: Handle<Shader> = uuid_handle!("6a8d3c52-5f0e-4d6b-9a37-2b1c90e4d7f1");

/// Adds [`GlowMaterial`].
pub(crate) struct GlowPlugin;

impl Plugin for GlowPlugin {
    fn build(&self, app: &mut App) {
        load_internal_asset!(app, GLOW_SHADER, "glow.wgsl", Shader::from_wgsl);
        app.add_plugins(MaterialPlugin::<GlowMaterial>::default())
            .add_systems(Update, retint.run_if(resource_changed::<Theme>));
    }
}

/// Every glyph in the colours of the theme of now.
fn retint(mut materials: ResMut<Assets<GlowMaterial>>) {
    for (_, material) in materials.iter_mut() {
        let color = material.role.color().to_linear();
        if material.glow.color != color {
            material.glow.color = color;
        }
    }
}

/// One colour, the same in any light.
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
#[bind_group_data(GlowKey)]
pub struct GlowMaterial {
    #[uniform(0)]
    pub glow: Glow,
    pub key: GlowKey,
    pub role: Rgb,
    /// Larger is drawn later among what is translucent, in millimetres of distance.
    pub order_mm: f32,
}

/// What the shader reads.
#[derive(ShaderType, Clone, Copy, Debug)]
pub struct Glow {
    pub color: LinearRgba,
    pub shape: Vec4,
}

/// What makes another pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GlowKey {
    pub shown: Shown,
    pub faces: Faces,
    pub is_opaque: bool,
}

/// Where a glyph is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shown {
    /// Where nothing is in front of it.
    InFront,
    /// Only where something is in front of it: the dimmed copy that shines through.
    Hidden,
    /// Everywhere.
    Always,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Faces {
    Front,
    /// Seen from inside: a hull that is a little larger makes an outline.
    Back,
    Both,
}

impl From<&GlowMaterial> for GlowKey {
    fn from(material: &GlowMaterial) -> Self {
        material.key
    }
}

impl GlowMaterial {
    /// Opaque, slightly darker towards the rim so that round things look round.
    pub fn solid(color: Rgb) -> Self {
        Self::new(color, [1.0, 1.0], Shown::InFront)
    }

    /// The copy that shines through whatever hides a solid glyph.
    pub fn shining_through(color: Rgb, alpha: f32) -> Self {
        Self::new(color, [alpha, alpha], Shown::Hidden)
    }

    /// Translucent with a rim, from the opacity in the middle to that of the rim.
    pub fn translucent(color: Rgb, middle: f32, rim: f32) -> Self {
        Self::new(color, [middle, rim], Shown::InFront)
    }

    /// The back of a larger hull: an outline around what stands in front.
    pub fn outline(color: Rgb) -> Self {
        let mut material = Self::new(color, [1.0, 1.0], Shown::Always);
        material.key.faces = Faces::Back;
        material
    }

    pub fn shown(mut self, shown: Shown) -> Self {
        self.key.shown = shown;
        self
    }

    /// How narrow the rim is; 2 by default.
    pub fn rim(mut self, power: f32) -> Self {
        self.glow.shape.z = power;
        self
    }

    /// Seen from inside too.
    pub fn both_faces(mut self) -> Self {
        self.key.faces = Faces::Both;
        self
    }

    pub fn order(mut self, order_mm: f32) -> Self {
        self.order_mm = order_mm;
        self
    }

    fn new(color: Rgb, [middle, rim]: [f32; 2], shown: Shown) -> Self {
        let is_opaque = middle >= 1.0 && rim >= 1.0 && shown == Shown::InFront;
        Self {
            glow: Glow {
                color: color.color().to_linear(),
                shape: Vec4::new(middle, rim, 2.0, if is_opaque { 0.45 } else { 0.25 }),
            },
            role: color,
            key: GlowKey { shown, faces: Faces::Front, is_opaque },
            order_mm: 0.0,
        }
    }
}

impl Material for GlowMaterial {
    fn fragment_shader() -> ShaderRef {
        GLOW_SHADER.into()
    }

    fn alpha_mode(&self) -> AlphaMode {
        if self.key.is_opaque { AlphaMode::Opaque } else { AlphaMode::Blend }
    }

    fn depth_bias(&self) -> f32 {
        self.order_mm
    }

    fn enable_prepass() -> bool {
        false
    }

    fn enable_shadows() -> bool {
        false
    }

    fn specialize(
        _pipeline: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _layout: &MeshVertexBufferLayoutRef,
        key: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let key = key.bind_group_data;
        descriptor.primitive.cull_mode = match key.faces {
            Faces::Front => Some(Face::Back),
            Faces::Back => Some(Face::Front),
            Faces::Both => None,
        };
        if let Some(depth) = &mut descriptor.depth_stencil {
            // Depth is reversed: nearer is greater.
            depth.depth_compare = Some(match key.shown {
                Shown::InFront => CompareFunction::GreaterEqual,
                Shown::Hidden => CompareFunction::Less,
                Shown::Always => CompareFunction::Always,
            });
            depth.depth_write_enabled = Some(key.is_opaque);
        }
        Ok(())
    }
}
