//! What a mesh file holds: named parts, each in one material, closed by themselves or together.

use crate::shape::Shape;
use crate::vector::Vec3;

/// A physically based material with linear colours, as glTF wants them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    pub name: &'static str,
    pub base_color: [f64; 4],
    pub metallic: f64,
    pub roughness: f64,
}

/// One node of a file.
#[derive(Clone, Debug)]
pub struct Part {
    pub name: &'static str,
    pub material: Material,
    pub shape: Shape,
}

/// One file: its name without extension, and its parts.
#[derive(Clone, Debug)]
pub struct Model {
    pub name: &'static str,
    pub parts: Vec<Part>,
}

impl Part {
    pub fn new(name: &'static str, material: Material, shape: Shape) -> Self {
        Self { name, material, shape }
    }
}

/// One closed shape as parts in several materials; `region` gives a triangle's by its middle.
///
/// The parts are open, and closed together: they meet at the same points. Light falls as on the whole.
pub fn painted(
    shape: &Shape,
    regions: &[(&'static str, Material)],
    region: impl Fn(Vec3) -> usize,
) -> Vec<Part> {
    let shaded = shape.shaded();
    let region_of = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|index| shaded.positions[index as usize]);
        region((a + b + c) / 3.0)
    };
    let part_of = |(index, &(name, material)): (usize, &(&'static str, Material))| {
        let mut part = Shape { normals: Some(Vec::new()), ..Shape::default() };
        let mut new_index = vec![None; shaded.positions.len()];
        for triangle in shaded.triangles.iter().filter(|triangle| region_of(triangle) == index) {
            let corners = triangle.map(|old| {
                *new_index[old as usize].get_or_insert_with(|| {
                    part.points.push(shaded.positions[old as usize]);
                    part.normals.get_or_insert_default().push(shaded.normals[old as usize]);
                    part.points.len() as u32 - 1
                })
            });
            part.triangles.push(corners);
        }
        Part::new(name, material, part)
    };
    regions.iter().enumerate().map(part_of).collect()
}

/// The materials of all instruments. Metals stay below full metallic: the editor lights them with
/// lamps only, and a mirror with nothing to reflect is black.
pub mod materials {
    use super::Material;

    pub const STEEL: Material = opaque("steel", [0.600, 0.570, 0.525], 0.65, 0.30);
    pub const BRUSHED_STEEL: Material = opaque("brushed-steel", [0.440, 0.418, 0.388], 0.60, 0.44);
    pub const ANODISED: Material = opaque("anodised", [0.052, 0.055, 0.062], 0.45, 0.42);
    pub const GRIP: Material = opaque("grip", [0.020, 0.021, 0.024], 0.05, 0.62);
    pub const HOUSING: Material = opaque("housing", [0.075, 0.080, 0.088], 0.05, 0.46);
    pub const DARK_STEEL: Material = opaque("dark-steel", [0.085, 0.080, 0.075], 0.60, 0.38);
    pub const BORE: Material = opaque("bore", [0.006, 0.006, 0.006], 0.0, 0.80);
    /// Green marks a straight-ahead endoscope.
    pub const ANGLE_GREEN: Material = opaque("angle-green", [0.045, 0.260, 0.090], 0.0, 0.45);
    pub const GLASS: Material = opaque("glass", [0.012, 0.018, 0.030], 0.10, 0.06);
    pub const CABLE: Material = opaque("cable", [0.016, 0.017, 0.019], 0.0, 0.55);
    pub const TEAL: Material = opaque("teal", [0.070, 0.235, 0.235], 0.0, 0.42);
    pub const DARK_TEAL: Material = opaque("dark-teal", [0.032, 0.120, 0.122], 0.0, 0.50);
    pub const PAD: Material = opaque("pad", [0.340, 0.400, 0.390], 0.0, 0.85);
    pub const FABRIC: Material = opaque("fabric", [0.060, 0.105, 0.108], 0.0, 0.90);
    pub const GRAPHITE: Material = opaque("graphite", [0.030, 0.033, 0.038], 0.10, 0.50);
    pub const PANEL: Material = opaque("panel", [0.090, 0.097, 0.108], 0.05, 0.55);
    pub const ENAMEL: Material = opaque("enamel", [0.360, 0.375, 0.390], 0.05, 0.40);
    pub const MARK: Material = opaque("mark", [0.560, 0.600, 0.640], 0.0, 0.50);
    /// Translucent, so that tools and targets inside the head stay visible.
    pub const BONE: Material = Material {
        name: "bone",
        base_color: [0.800, 0.720, 0.590, 0.25],
        metallic: 0.0,
        roughness: 0.60,
    };

    const fn opaque(
        name: &'static str,
        [r, g, b]: [f64; 3],
        metallic: f64,
        roughness: f64,
    ) -> Material {
        Material { name, base_color: [r, g, b, 1.0], metallic, roughness }
    }
}
