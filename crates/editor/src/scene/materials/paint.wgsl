// Colours of the corners, darker towards the rim so that a form is seen.
#import bevy_pbr::{forward_io::VertexOutput, mesh_view_bindings::view}

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> rim: vec4<f32>;

@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    // In orthographic projection every point is seen from the same direction.
    let to_eye = view.world_position.xyz - in.world_position.xyz;
    let is_orthographic = view.clip_from_view[3].w == 1.0;
    let to_viewer = normalize(select(to_eye, view.world_from_view[2].xyz, is_orthographic));
    let facing = abs(dot(normalize(in.world_normal), to_viewer));
    let shade = mix(rim.x, 1.0, facing);
#ifdef VERTEX_COLORS
    return vec4<f32>(in.color.rgb * shade, 1.0);
#else
    return vec4<f32>(vec3<f32>(shade), 1.0);
#endif
}
