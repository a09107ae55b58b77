//! The measurements in the 3D view, each coloured by its error, while the workspace is shown.
//!
//! All markers of a table are one mesh: an octahedron each for what is fitted, a cube each for what
//! is held out.

use crate::convert;
use crate::document::requests::OpenWorld;
use crate::layers::field_arrows;
use crate::layers::legend::Legends;
use crate::layers::registry::{AddLayer, ProbeInfo, ProbeRay, Probed};
use crate::layers::slice_picture::ColorScale;
use crate::runner::results::Results;
use crate::scene::materials::paint::PaintMaterial;
use crate::schedule::EditorSystems;
use crate::shell::window::Workspace;
use crate::widgets::basic::{decimal, with_unit};
use crate::workspaces::field::requests::WORKSPACE;
use crate::workspaces::field::state::{FieldState, SampleValue, Table, TableRole};
use bevy::asset::RenderAssetUsages;
use bevy::mesh::Indices;
use bevy::picking::Pickable;
use bevy::prelude::*;
use bevy::render::render_resource::PrimitiveTopology;
use std::sync::Arc;
use trackwright_design::view::Quantity;
use trackwright_field::samples::Sample;
use trackwright_geometry::pointing::{Target, first_pointed_at};

/// Most markers that are drawn of a table; of a larger one every so many-th sample is.
pub const MOST_MARKERS: usize = 20_000;

/// A marker's radius as a part of the room that its sample has to itself: they stay apart.
const RADIUS_PART: f64 = 0.07;
/// Bounds of the radius, mm: seen from across the volume, and never in the way.
const RADIUS_MM: [f64; 2] = [0.5, 3.0];

/// Draws the samples in [`EditorSystems::Draw`]; needs [`FieldState`].
pub struct SamplesPlugin;

/// The colours of the samples as drawn.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct SampleScale(pub Option<ColorScale>);

/// The samples of a table, and what they were made for.
#[derive(Component, Clone)]
struct Samples {
    role: TableRole,
    table: Table,
    /// Where the values are: the same place holds the same values.
    values: usize,
    scale: ColorScale,
}

impl Samples {
    fn is_same(&self, other: &Self) -> bool {
        self.role == other.role
            && Arc::ptr_eq(&self.table, &other.table)
            && self.values == other.values
            && self.scale == other.scale
    }
}

impl Plugin for SamplesPlugin {
    fn build(&self, app: &mut App) {
        app.add_probe(ProbeInfo { is_on: is_probed, value: value_at })
            .init_resource::<SampleScale>()
            .add_systems(
                Update,
                (choose_scale.in_set(EditorSystems::Sample), draw.in_set(EditorSystems::Draw))
                    .run_if(crate::workspaces::field::requests::is_shown),
            )
            .add_systems(
                Update,
                remove
                    .run_if(resource_changed::<Workspace>)
                    .run_if(not(crate::workspaces::field::requests::is_shown))
                    .in_set(EditorSystems::Draw),
            );
    }
}

/// That of the slice or of the arrows where they show the same quantity, so that it can be compared;
/// else one of their own, with another map.
fn choose_scale(
    state: Res<FieldState>,
    world: Option<Res<OpenWorld>>,
    results: Res<Results>,
    slice: Option<Res<ColorScale>>,
    legends: Res<Legends>,
    mut scale: ResMut<SampleScale>,
) {
    let Some(world) = world else { return };
    let view = world.0.document.view();
    let is_comparable = view.layers.slice
        && results.slice.is_some()
        && results.slice.as_ref().is_some_and(|s| s.value.quantity == Quantity::PositionErrorMm);
    let of_slice =
        slice.filter(|_| is_comparable).map(|scale| *scale).filter(|scale| scale.max_mm > 0.0);
    let largest_mm = TableRole::ALL
        .into_iter()
        .filter_map(|role| Some(state.sample_values(role)?.1.position_p95_mm))
        .reduce(f64::max);
    let of_arrows = legends.bar(field_arrows::LAYER.row.order);
    let of_arrows = of_arrows.map(|bar| ColorScale { map: bar.map, max_mm: bar.max });
    let own = largest_mm.map(|max_mm| ColorScale { map: view.color_maps().spare, max_mm });
    scale.set_if_neq(SampleScale(own.map(|own| of_slice.or(of_arrows).unwrap_or(own))));
}

fn draw(
    mut commands: Commands,
    mut state: ResMut<FieldState>,
    scale: Res<SampleScale>,
    drawn: Query<(Entity, &Samples)>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<PaintMaterial>>,
) {
    for role in TableRole::ALL {
        let table = state.slot(role).table.clone();
        let wanted = table.zip(scale.0).filter(|_| state.shown.is_shown(role));
        let wanted = wanted.zip(state.sample_values(role));
        let old = drawn.iter().find(|(_, samples)| samples.role == role);
        let Some(((table, scale), (_, left))) = wanted else {
            if let Some((entity, _)) = old {
                commands.entity(entity).despawn();
            }
            continue;
        };
        let wanted = Samples { role, values: left.position_mm.as_ptr() as usize, table, scale };
        if let Some((entity, samples)) = old {
            if samples.is_same(&wanted) {
                continue;
            }
            commands.entity(entity).despawn();
        }
        let mesh = markers(&wanted, &left.position_mm);
        state.bypass_change_detection().counts.sample_meshes += 1;
        commands.spawn((
            Name::new("samples"),
            wanted,
            Pickable::IGNORE,
            Mesh3d(meshes.add(mesh)),
            MeshMaterial3d(materials.add(PaintMaterial::exact())),
        ));
    }
}

fn remove(mut commands: Commands, drawn: Query<Entity, With<Samples>>) {
    for entity in &drawn {
        commands.entity(entity).despawn();
    }
}

fn is_probed(world: &World) -> bool {
    world.get_resource::<Workspace>() == Some(&WORKSPACE) && world.contains_resource::<FieldState>()
}

/// What is shown of the sample that the ray meets first.
fn value_at(world: &World, probe: &ProbeRay) -> Option<Probed> {
    let state = world.get_resource::<FieldState>()?;
    let of_tables = TableRole::ALL.into_iter().filter_map(|role| {
        let (kind, left) = state.sample_values(role)?;
        let table = state.slot(role).table.as_ref()?;
        let samples = &table.samples.samples;
        let radius_mm = radius_mm(table);
        let drawn = samples.iter().zip(&left.position_mm);
        let targets = drawn.step_by(stride(samples.len())).map(|(sample, &value_mm)| Target {
            ends_mm: [sample.position_mm; 2],
            radius_mm,
            is: (kind, value_mm),
        });
        first_pointed_at(&probe.ray, probe.reach_rad, targets)
            .filter(|_| state.shown.is_shown(role))
    });
    let (distance_mm, (kind, value_mm)) = of_tables.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let name = match kind {
        SampleValue::Measured => "error as measured",
        SampleValue::Left => "error left by the fit",
    };
    let words = format!("{name} {}", with_unit(&decimal(value_mm, 2), "mm"));
    Some(Probed { distance_mm, words: Some(words) })
}

fn radius_mm(table: &Table) -> f64 {
    table
        .spacing_mm()
        .map_or(RADIUS_MM[1], |spacing| spacing * RADIUS_PART)
        .clamp(RADIUS_MM[0], RADIUS_MM[1])
}

/// A step between the samples that are drawn.
pub fn stride(samples: usize) -> usize {
    samples.div_ceil(MOST_MARKERS).max(1)
}

fn markers(of: &Samples, values_mm: &[f64]) -> Mesh {
    let samples: &[Sample] = &of.table.samples.samples;
    let radius = convert::length(radius_mm(&of.table));
    let (corners, triangles): (&[Vec3], &[[u32; 3]]) = match of.role {
        TableRole::Training => (&OCTAHEDRON, &OCTAHEDRON_FACES),
        TableRole::HeldOut => (&CUBE, &CUBE_FACES),
    };
    let (mut positions, mut colors, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    let drawn = samples.iter().zip(values_mm).step_by(stride(samples.len()));
    for (sample, &value_mm) in drawn {
        let first = positions.len() as u32;
        let at = convert::point(&sample.position_mm);
        let [r, g, b] = of.scale.map.srgb_of_value(value_mm, of.scale.max_mm);
        let color = Color::srgb_u8(r, g, b).to_linear().to_f32_array();
        for corner in corners {
            positions.push((at + *corner * radius).to_array());
            colors.push(color);
        }
        indices.extend(triangles.iter().flatten().map(|i| first + i));
    }
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        // Nothing lights them, but the material's pipeline wants normals.
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; positions.len()])
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colors)
        .with_inserted_indices(Indices::U32(indices))
}

const OCTAHEDRON: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
const OCTAHEDRON_FACES: [[u32; 3]; 8] =
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];

/// Of about the octahedron's size on the screen.
const HALF: f32 = 0.7;
const CUBE: [Vec3; 8] = [
    Vec3::new(-HALF, -HALF, -HALF),
    Vec3::new(HALF, -HALF, -HALF),
    Vec3::new(-HALF, HALF, -HALF),
    Vec3::new(HALF, HALF, -HALF),
    Vec3::new(-HALF, -HALF, HALF),
    Vec3::new(HALF, -HALF, HALF),
    Vec3::new(-HALF, HALF, HALF),
    Vec3::new(HALF, HALF, HALF),
];
const CUBE_FACES: [[u32; 3]; 12] = [
    [0, 2, 1],
    [1, 2, 3],
    [4, 5, 6],
    [5, 7, 6],
    [0, 1, 4],
    [1, 5, 4],
    [2, 6, 3],
    [3, 6, 7],
    [0, 4, 2],
    [2, 4, 6],
    [1, 3, 5],
    [3, 7, 5],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_face_of_a_marker_looks_outwards() {
        for (corners, faces) in
            [(&OCTAHEDRON[..], &OCTAHEDRON_FACES[..]), (&CUBE[..], &CUBE_FACES[..])]
        {
            for face in faces {
                let [a, b, c] = face.map(|i| corners[i as usize]);
                let out = (b - a).cross(c - a).dot(a + b + c);
                assert!(out > 0.0, "{face:?}");
            }
        }
    }

    #[test]
    fn no_more_markers_are_drawn_than_the_scene_bears() {
        assert_eq!(stride(4000), 1);
        assert_eq!(stride(MOST_MARKERS + 1), 2);
        assert!(1_000_000_usize.div_ceil(stride(1_000_000)) <= MOST_MARKERS);
    }
}
