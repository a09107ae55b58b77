// Bodies under a key light, a fill light and a room, all fixed to the viewer but for the room's up.
#import bevy_pbr::{forward_io::VertexOutput, mesh_view_bindings::view}

struct Lit {
    color: vec4<f32>,
    // Metal and roughness.
    surface: vec4<f32>,
    key_from: vec4<f32>,
    fill_from: vec4<f32>,
    key: vec4<f32>,
    fill: vec4<f32>,
    above: vec4<f32>,
    around: vec4<f32>,
    below: vec4<f32>,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> lit: Lit;

// What the room sends from a direction; the tracker's -z is up.
fn room(direction: vec3<f32>) -> vec3<f32> {
    let up = -direction.z;
    let far = select(lit.below.rgb, lit.above.rgb, up > 0.0);
    return mix(lit.around.rgb, far, abs(up));
}

// What a light adds: matt reflection, and a highlight that is narrow where the surface is smooth.
fn lamp(
    to_light: vec3<f32>,
    light: vec3<f32>,
    normal: vec3<f32>,
    to_viewer: vec3<f32>,
    matt: vec3<f32>,
    shine: vec3<f32>,
    power: f32,
) -> vec3<f32> {
    let facing = max(dot(normal, to_light), 0.0);
    let halfway = normalize(to_light + to_viewer);
    // Keeps the same light in a narrower highlight.
    let highlight = pow(max(dot(normal, halfway), 0.0), power) * (power + 8.0) / 25.0;
    return light * facing * (matt + shine * highlight);
}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
    let outward = normalize(in.world_normal);
    let normal = select(-outward, outward, is_front);
    // In orthographic projection every point is seen from the same direction.
    let to_eye = view.world_position.xyz - in.world_position.xyz;
    let is_orthographic = view.clip_from_view[3].w == 1.0;
    let to_viewer = normalize(select(to_eye, view.world_from_view[2].xyz, is_orthographic));
    let axes = mat3x3<f32>(
        view.world_from_view[0].xyz,
        view.world_from_view[1].xyz,
        view.world_from_view[2].xyz,
    );
#ifdef VERTEX_COLORS
    let color = in.color.rgb;
#else
    let color = lit.color.rgb;
#endif
    let metal = lit.surface.x;
    let smoothness = 1.0 - lit.surface.y;
    let matt = color * (1.0 - metal);
    let shine = mix(vec3<f32>(0.04), color, metal);
    // From a broad sheen to a polished point.
    let power = exp2(2.0 + 6.0 * smoothness);
    var light = lamp(axes * lit.key_from.xyz, lit.key.rgb, normal, to_viewer, matt, shine, power);
    light += lamp(axes * lit.fill_from.xyz, lit.fill.rgb, normal, to_viewer, matt, shine, power);
    // Metal shows the room as a mirror does, the more so at the rim.
    let rim = pow(1.0 - max(dot(normal, to_viewer), 0.0), 4.0);
    let mirrored = room(reflect(-to_viewer, normal));
    light += room(normal) * matt;
    light += mirrored * mix(shine, vec3<f32>(1.0), rim * smoothness) * (0.6 + 1.6 * metal);
    return vec4<f32>(light, 1.0);
}
