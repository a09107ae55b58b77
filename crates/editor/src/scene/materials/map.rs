//! The material of coloured maps: the texture's own colours and nothing else, so that a map matches
//! its colour bar to the bit.

use bevy::asset::{load_internal_asset, uuid_handle};
use bevy::mesh::MeshVertexBufferLayoutRef;
use bevy::pbr::{MaterialPipeline, MaterialPipelineKey};
use bevy::prelude::*;
use bevy::render::render_resource::{
    AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError,
};
use bevy::shader::ShaderRef;

const MAP_SHADER: Handle<Shader> = uuid_handle!("2d9f6c18-7b43-4c0a-9e51-f84ab36d0e72");

/// Adds [`MapMaterial`].
pub(crate) struct MapPlugin;

impl Plugin for MapPlugin {
    fn build(&self, app: &mut App) {
        load_internal_asset!(app, MAP_SHADER, "map.wgsl", Shader::from_wgsl);
        app.add_plugins(MaterialPlugin::<MapMaterial>::default());
    }
}

/// A picture on a surface, seen from both sides.
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
pub struct MapMaterial {
    #[texture(0)]
    #[sampler(1)]
    pub picture: Handle<Image>,
}

impl Material for MapMaterial {
    fn fragment_shader() -> ShaderRef {
        MAP_SHADER.into()
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
        _key: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        descriptor.primitive.cull_mode = None;
        Ok(())
    }
}
