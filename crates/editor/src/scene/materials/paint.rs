//! The material of surfaces whose corners have colours of their own: arrows of the field, and bodies
//! painted by the error with a sensor there.

use bevy::asset::{load_internal_asset, uuid_handle};
use bevy::prelude::*;
use bevy::render::render_resource::AsBindGroup;
use bevy::shader::ShaderRef;

const PAINT_SHADER: Handle<Shader> = uuid_handle!("9b0e57d4-2f86-4c3b-b1a9-60d27c85e1f3");

/// Adds [`PaintMaterial`].
pub(crate) struct PaintPlugin;

impl Plugin for PaintPlugin {
    fn build(&self, app: &mut App) {
        load_internal_asset!(app, PAINT_SHADER, "paint.wgsl", Shader::from_wgsl);
        app.add_plugins(MaterialPlugin::<PaintMaterial>::default());
    }
}

/// Colours of the mesh's corners, darker the more a surface turns away.
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
pub struct PaintMaterial {
    /// x: what is left of a colour at the rim, from 0 to 1; 1 leaves every colour as it is.
    #[uniform(0)]
    pub rim: Vec4,
    /// Whether it covers what is at the very same place.
    pub is_over: bool,
}

impl PaintMaterial {
    /// For markers that are compared with a map beside them.
    pub fn exact() -> Self {
        Self { rim: Vec4::ONE, is_over: false }
    }

    /// For arrows, whose colours are read against a colour bar.
    pub fn flat() -> Self {
        Self { rim: Vec4::new(0.7, 0.0, 0.0, 0.0), is_over: false }
    }

    /// For the surface of a body, whose form has to be seen too.
    pub fn over_a_body() -> Self {
        Self { rim: Vec4::new(0.55, 0.0, 0.0, 0.0), is_over: true }
    }
}

impl Material for PaintMaterial {
    fn fragment_shader() -> ShaderRef {
        PAINT_SHADER.into()
    }

    fn depth_bias(&self) -> f32 {
        if self.is_over { 1.0 } else { 0.0 }
    }

    fn enable_prepass() -> bool {
        false
    }

    fn enable_shadows() -> bool {
        false
    }
}
