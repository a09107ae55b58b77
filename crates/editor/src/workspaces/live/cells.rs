//! The volume as it fills: a block for every cell that was sampled, the brighter the more ways it was
//! sampled turned, and a frame where to go next.

use crate::convert::{self, Painted};
use crate::palette;
use crate::palette::ThemedColor;
use crate::scene::materials::paint::PaintMaterial;
use crate::schedule::EditorSystems;
use crate::shell::window::Workspace;
use crate::workspaces::live::collected::Collected;
use crate::workspaces::live::state::LiveState;
use bevy::picking::Pickable;
use bevy::prelude::*;
use nalgebra::{Point3, Vector3};
use trackwright_geometry::colormap::ColorMap;

/// How much of a cell a block takes: the tool between them stays to be seen.
const BLOCK_PART: f64 = 0.22;

/// That of the next place stands out.
const NEXT_PART: f64 = 0.5;
const EDGE_PART: f64 = 0.06;

/// The colours of blocks.
const COLOR_MAP: ColorMap = ColorMap::Viridis;

/// The blocks, and the next place.
#[derive(Component)]
struct Cells;

/// Draws them in [`EditorSystems::Draw`] while the workspace is shown.
pub struct CellsPlugin;

impl Plugin for CellsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<LiveState>().add_systems(
            Update,
            (
                draw.run_if(crate::workspaces::live::requests::is_shown),
                remove
                    .run_if(resource_changed::<Workspace>)
                    .run_if(not(crate::workspaces::live::requests::is_shown)),
            )
                .in_set(EditorSystems::Draw),
        );
    }
}

fn draw(
    mut commands: Commands,
    state: Res<LiveState>,
    blocks: Query<Entity, With<Cells>>,
    mut drawn: Local<Option<(u64, usize)>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<PaintMaterial>>,
) {
    let collected = state.collected.as_ref();
    let key = collected.map(|c| (c.summary.distinct, c.cells.len()));
    if *drawn == key && (key.is_none() || !blocks.is_empty()) {
        return;
    }
    *drawn = key;
    for entity in &blocks {
        commands.entity(entity).despawn();
    }
    if let Some(collected) = collected {
        commands.spawn((
            Name::new("collected"),
            Cells,
            Pickable::IGNORE,
            Mesh3d(meshes.add(blocks_of(collected))),
            MeshMaterial3d(materials.add(PaintMaterial::exact())),
        ));
    }
}

fn remove(mut commands: Commands, blocks: Query<Entity, With<Cells>>) {
    for entity in &blocks {
        commands.entity(entity).despawn();
    }
}

fn blocks_of(collected: &Collected) -> Mesh {
    let mut painted = Painted::default();
    for cell in collected.cells.iter().filter(|cell| cell.samples > 0) {
        let color = convert::linear(COLOR_MAP.srgb(brightness(cell.turned)));
        block(&mut painted, &cell.center_mm, &(collected.cell_mm * BLOCK_PART), color);
    }
    if let Some(next_mm) = &collected.next_mm {
        let color = convert::linear(palette::ACCENT.srgb());
        frame(&mut painted, next_mm, &(collected.cell_mm * NEXT_PART), color);
    }
    painted.mesh()
}

/// Where colours begin: the darkest are not seen before the dark.
const DARKEST: f64 = 0.3;

/// A part of all orientations as a part of the colours. The first few count for more than the last:
/// one of fourteen is a quarter of the way.
fn brightness(turned: f64) -> f64 {
    DARKEST + (1.0 - DARKEST) * turned.sqrt()
}

/// A box, each face counter-clockwise seen from outside.
fn block(painted: &mut Painted, center: &Point3<f64>, size: &Vector3<f64>, color: [f32; 4]) {
    for axis in 0..3 {
        let half = |k: usize| Vector3::ith((axis + k) % 3, 0.5 * size[(axis + k) % 3]);
        let (out, u, v) = (half(0), half(1), half(2));
        for side in [1.0, -1.0] {
            let middle = center + out * side;
            let corners = [u + v * side, v * side - u, -u - v * side, u - v * side];
            let corners = corners.map(|corner| middle + corner);
            painted.quad(corners, &Vector3::ith(axis, side), color);
        }
    }
}

/// The twelve edges of a box, each a thin block.
fn frame(painted: &mut Painted, center: &Point3<f64>, size: &Vector3<f64>, color: [f32; 4]) {
    let thin = size * EDGE_PART;
    for axis in 0..3 {
        let [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
        for (a, b) in [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)] {
            let off = Vector3::ith(one, a * size[one]) + Vector3::ith(other, b * size[other]);
            let mut edge = thin;
            edge[axis] += size[axis];
            block(painted, &(center + off), &edge, color);
        }
    }
}
