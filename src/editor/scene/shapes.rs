//! Meshes of unit size that glyphs share.

use crate::editor::convert;
use bevy::prelude::*;
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;

const SIDES: u32 = 28;

/// Makes [`GlyphShapes`] at startup.
pub struct ShapesPlugin;

/// Shapes along z, one unit long and one across, centred.
#[derive(Resource, Clone, Debug)]
pub struct GlyphShapes {
    pub coil: Handle<Mesh>,
    pub cylinder: Handle<Mesh>,
    /// Base at z = 0, point at z = 1.
    pub cone: Handle<Mesh>,
    /// Of diameter 1.
    pub ball: Handle<Mesh>,
    /// Of radius 1.
    pub sphere: Handle<Mesh>,
}

impl Plugin for ShapesPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PreStartup, make);
    }
}

fn make(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
    let cylinder = [[0.0, -0.5], [0.5, -0.5], [0.5, 0.5], [0.0, 0.5]];
    let cone = [[0.0, 0.0], [0.5, 0.0], [0.0, 1.0]];
    commands.insert_resource(GlyphShapes {
        coil: meshes.add(turned(&coil_outline())),
        cylinder: meshes.add(turned(&cylinder)),
        cone: meshes.add(turned(&cone)),
        ball: meshes.add(Sphere::new(0.5).mesh().uv(32, 16)),
        sphere: meshes.add(Sphere::new(1.0).mesh().uv(48, 24)),
    });
}

/// A bobbin: collars at both ends and the windings between them.
fn coil_outline() -> Vec<[f64; 2]> {
    const WINDINGS: u32 = 7;
    let mut outline = vec![[0.0, -0.5], [0.5, -0.5], [0.5, -0.42]];
    for i in 0..WINDINGS {
        let from = -0.42 + 0.84 * f64::from(i) / f64::from(WINDINGS);
        let step = 0.84 / f64::from(WINDINGS);
        outline.extend([
            [0.36, from + 0.04 * step],
            [0.43, from + 0.5 * step],
            [0.36, from + 0.96 * step],
        ]);
    }
    outline.extend([[0.5, 0.42], [0.5, 0.5], [0.0, 0.5]]);
    outline
}

/// Turns an outline of `[radius, z]`, from the lower to the upper end, around z; flat-shaded
/// along the outline, smooth around it.
fn turned(outline: &[[f64; 2]]) -> Mesh {
    let mut positions = Vec::new();
    let mut normals = Vec::new();
    let mut triangles = Vec::new();
    for pair in outline.windows(2) {
        let ([r0, z0], [r1, z1]) = (pair[0], pair[1]);
        let (out, up) = (z1 - z0, r0 - r1);
        let base = positions.len() as u32;
        for i in 0..=SIDES {
            let (sine, cosine) = (f64::from(i) / f64::from(SIDES) * TAU).sin_cos();
            let normal = Vector3::new(cosine * out, sine * out, up).normalize();
            for (r, z) in [(r0, z0), (r1, z1)] {
                positions.push(Point3::new(cosine * r, sine * r, z));
                normals.push(normal);
            }
        }
        for i in 0..SIDES {
            let a = base + 2 * i;
            if r0 > 0.0 {
                triangles.push([a, a + 2, a + 1]);
            }
            if r1 > 0.0 {
                triangles.push([a + 1, a + 2, a + 3]);
            }
        }
    }
    convert::triangle_mesh(&positions, &normals, &triangles)
}
