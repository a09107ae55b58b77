// Glyphs that no lamp lights: a colour, its opacity in the middle and at the rim.
#import bevy_pbr::{forward_io::VertexOutput, mesh_view_bindings::view}

struct Glow {
    color: vec4<f32>,
    // Opacity where the surface faces the viewer, opacity at the rim, how narrow the rim is,
    // and how much the colour darkens towards the rim.
    shape: vec4<f32>,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> glow: Glow;

@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    let normal = normalize(in.world_normal);
    // In orthographic projection every point is seen from the same direction.
    let to_eye = view.world_position.xyz - in.world_position.xyz;
    let is_orthographic = view.clip_from_view[3].w == 1.0;
    let to_viewer = normalize(select(to_eye, view.world_from_view[2].xyz, is_orthographic));
    let turned_away = 1.0 - abs(dot(normal, to_viewer));
    let alpha = mix(glow.shape.x, glow.shape.y, pow(turned_away, glow.shape.z));
    let shade = 1.0 - glow.shape.w * turned_away;
    return vec4<f32>(glow.color.rgb * shade, alpha);
}
