//! The texture of a slice: the map, hatched where there is no value or no support for the model,
//! with a line where the requirement is passed.
//!
//! It is finer than the lattice: values are interpolated and then coloured, so that a point of the
//! lattice has exactly the colour that the colour bar gives its value.

use bevy::asset::RenderAssetUsages;
use bevy::ecs::resource::Resource;
use bevy::image::{Image, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use rayon::prelude::*;
use trackwright_geometry::colormap::{
    ColorMap, LEVEL_EDGE_SRGB, LEVEL_LINE_SRGB, NO_VALUE_LINE_SRGB, NO_VALUE_SRGB,
    UNSUPPORTED_LINE_OPACITY, UNSUPPORTED_LINE_SRGB, over,
};
use trackwright_simulation::SliceOutcome;

/// Texels between neighbouring points of the lattice.
const TEXELS_PER_CELL: usize = 6;

/// From one line of a hatching to the next across the lines, and how much of that a line takes.
const HATCH_MM: f64 = 9.0;
const HATCH_LINE_MM: f64 = 2.0;

/// Half the width of the line at the requirement, and of that with its edges.
const LEVEL_LINE_MM: f64 = 1.2;
const LEVEL_EDGE_MM: f64 = 2.8;

/// The colour scale of the error map as drawn.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct ColorScale {
    pub map: ColorMap,
    pub max_mm: f64,
}

/// How a slice is coloured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceLook {
    pub scale: ColorScale,
    /// The value at which a line is drawn.
    pub level: Option<f64>,
}

/// Half a texel as a part of the texture's side over so many points: texels sit on the lattice's
/// points, so that the plane reaches half a texel into the outermost ones.
pub fn inset(points: usize) -> f32 {
    0.5 / texels(points) as f32
}

fn texels(points: usize) -> usize {
    (points - 1) * TEXELS_PER_CELL + 1
}

/// Width and height of the texture.
pub fn size(slice: &SliceOutcome) -> [usize; 2] {
    slice.plan.counts.map(texels)
}

/// The texture, the plane's first axis along its rows.
pub fn picture(slice: &SliceOutcome, look: &SliceLook) -> Image {
    let [width, height] = size(slice);
    let painter = Painter::new(slice, look);
    let data: Vec<u8> = (0..height)
        .into_par_iter()
        .flat_map_iter(|y| (0..width).map(move |x| (x, y)))
        .flat_map_iter(|(x, y)| {
            let [r, g, b] = painter.color_at(x, y);
            [r, g, b, 255]
        })
        .collect();
    let mut image = Image::new(
        Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: 1 },
        TextureDimension::D2,
        data,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        ..Default::default()
    });
    image
}

/// Colours texels one by one.
struct Painter<'a> {
    slice: &'a SliceOutcome,
    look: &'a SliceLook,
    /// Size of a texel; cells are as good as square.
    texel_mm: [f64; 2],
}

impl<'a> Painter<'a> {
    fn new(slice: &'a SliceOutcome, look: &'a SliceLook) -> Self {
        Self { slice, look, texel_mm: slice.plan.cell_mm().map(|mm| mm / TEXELS_PER_CELL as f64) }
    }

    fn color_at(&self, x: usize, y: usize) -> [u8; 3] {
        let place = [x, y].map(|t| t as f64 / TEXELS_PER_CELL as f64);
        let [x_mm, y_mm] = [x as f64 * self.texel_mm[0], y as f64 * self.texel_mm[1]];
        let Some(value) = self.slice.value_at(place) else {
            let line = self.hatch(x_mm - y_mm);
            return over(NO_VALUE_SRGB, NO_VALUE_LINE_SRGB, line);
        };
        let scale = self.look.scale;
        let map = scale.map.srgb_of_value(value, scale.max_mm);
        let mapped = match self.slice.is_supported_at(place) {
            true => map,
            false => {
                // Against the lines of what has no value.
                let line = self.hatch(x_mm + y_mm) * UNSUPPORTED_LINE_OPACITY;
                over(map, UNSUPPORTED_LINE_SRGB, line)
            }
        };
        let level = self.look.level.and_then(|level| {
            let step = 1.0 / TEXELS_PER_CELL as f64;
            self.slice.cells_to_level(place, level, step)
        });
        match level {
            Some(cells) => self.with_level(mapped, cells * TEXELS_PER_CELL as f64),
            None => mapped,
        }
    }

    /// How much of a texel lines of a hatching cover, by how far it is along both axes together.
    fn hatch(&self, diagonal_mm: f64) -> f64 {
        let across_mm = diagonal_mm / std::f64::consts::SQRT_2;
        let from_line_mm = (across_mm.rem_euclid(HATCH_MM) - HATCH_MM / 2.0).abs();
        self.covered(HATCH_LINE_MM / 2.0, from_line_mm / self.texel_mm[0])
    }

    /// A colour so many texels from the line at the requirement.
    fn with_level(&self, color: [u8; 3], texels: f64) -> [u8; 3] {
        let edged = over(color, LEVEL_EDGE_SRGB, self.covered(LEVEL_EDGE_MM, texels));
        over(edged, LEVEL_LINE_SRGB, self.covered(LEVEL_LINE_MM, texels))
    }

    /// How much of a texel a line covers whose middle is so many texels away.
    fn covered(&self, half_width_mm: f64, texels: f64) -> f64 {
        (half_width_mm / self.texel_mm[0] + 0.5 - texels).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use trackwright_geometry::bounds::Bounds;
    use trackwright_simulation::{Quantity, SlicePlan, SlicePlane, Work};

    const LOOK: SliceLook =
        SliceLook { scale: ColorScale { map: ColorMap::Viridis, max_mm: 4.0 }, level: None };

    /// Cells of 12 mm, and so texels of 2 mm.
    fn slice() -> SliceOutcome {
        SliceOutcome {
            plan: SlicePlan {
                plane: SlicePlane::Across {
                    normal_axis: 2,
                    position_mm: 5.0,
                    bounds: Bounds::from(([0.0; 3], [24.0, 12.0, 30.0])),
                },
                sensor_axis: Vector3::z_axis(),
                counts: [3, 2],
            },
            quantity: Quantity::PositionErrorMm,
            values: vec![0.0, 1.0, 2.0, 3.0, 4.0, 0.5],
            is_inside: vec![true, true, true, true, true, false],
            bounds: None,
            is_supported: Vec::new(),
            max: 4.0,
            p95: 4.0,
            work: Work::default(),
        }
    }

    fn colors(slice: &SliceOutcome, look: &SliceLook) -> Vec<([usize; 2], [u8; 3])> {
        let painter = Painter::new(slice, look);
        let places = (0..texels(2)).flat_map(|y| (0..texels(3)).map(move |x| [x, y]));
        places.map(|at| (at, painter.color_at(at[0], at[1]))).collect()
    }

    #[test]
    fn a_point_of_the_lattice_has_the_colour_of_its_value() {
        let slice = slice();
        let painter = Painter::new(&slice, &LOOK);
        for (i, value) in slice.values.iter().enumerate().take(5) {
            let (u, v) = (i % 3, i / 3);
            let color = painter.color_at(u * TEXELS_PER_CELL, v * TEXELS_PER_CELL);
            assert_eq!(color, ColorMap::Viridis.srgb_of_value(*value, 4.0));
        }
        let between = painter.color_at(TEXELS_PER_CELL / 2, 0);
        assert_eq!(between, ColorMap::Viridis.srgb_of_value(0.5, 4.0));
    }

    #[test]
    fn only_what_has_no_value_is_hatched_in_grey() {
        let (mut plain, mut lines) = (0, 0);
        for ([x, y], color) in colors(&slice(), &LOOK) {
            let is_grey =
                (0..3).all(|k| (NO_VALUE_SRGB[k]..=NO_VALUE_LINE_SRGB[k]).contains(&color[k]));
            // The half cell around the last point.
            assert_eq!(is_grey, x >= 9 && y >= 3, "{x} {y}");
            plain += usize::from(color == NO_VALUE_SRGB);
            lines += usize::from(is_grey && color != NO_VALUE_SRGB);
        }
        assert!(plain > 0 && lines > 0, "{plain} {lines}");
    }

    #[test]
    fn unsupported_areas_are_hatched_over_the_map() {
        let plain = slice();
        let hatched =
            SliceOutcome { is_supported: vec![false, true, true, false, true, true], ..slice() };
        let (mut lines, mut left) = (0, 0);
        for ((at, color), (_, map)) in
            colors(&hatched, &LOOK).into_iter().zip(colors(&plain, &LOOK))
        {
            assert!(color == map || at[0] < 3, "{at:?}");
            // Never so much that the map cannot be read.
            let most = over(map, UNSUPPORTED_LINE_SRGB, UNSUPPORTED_LINE_OPACITY);
            assert!(
                (0..3).all(|k| (map[k].min(most[k])..=map[k].max(most[k])).contains(&color[k])),
                "{at:?}"
            );
            lines += usize::from(color != map);
            left += usize::from(color == map && at[0] < 3);
        }
        assert!(lines > 3 && left > 3, "{lines} {left}");
    }

    #[test]
    fn the_requirement_line_is_drawn_where_values_cross() {
        let mut slice = slice();
        // 0 to 2 along the first axis, the same along the second.
        slice.values = vec![0.0, 1.0, 2.0, 0.0, 1.0, 2.0];
        slice.is_inside[5] = true;
        let look = SliceLook { level: Some(1.0), ..LOOK };
        for ((at, color), (_, map)) in colors(&slice, &look).into_iter().zip(colors(&slice, &LOOK))
        {
            match at[0].abs_diff(TEXELS_PER_CELL) {
                0 => assert_eq!(color, LEVEL_LINE_SRGB),
                // An edge of 2.8 mm ends within the second texel.
                1 => assert_ne!(color, map, "{at:?}"),
                2 => {}
                _ => assert_eq!(color, map, "{at:?}"),
            }
        }
    }
}
