//! The texture of a slice: the map, hatched where there is no value or the model should not be
//! believed, with a line where the requirement is passed.
//!
//! It is finer than the lattice: values are interpolated and then coloured, so that a point of the
//! lattice has exactly the colour that the colour bar gives its value.

use super::state::ColorScale;
use crate::geometry::colormap::{
    LEVEL_EDGE_SRGB, LEVEL_LINE_SRGB, NO_VALUE_LINE_SRGB, NO_VALUE_SRGB, UNSUPPORTED_LINE_OPACITY,
    UNSUPPORTED_LINE_SRGB, over,
};
use crate::study::SliceOutcome;
use bevy::asset::RenderAssetUsages;
use bevy::image::{Image, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};

/// Texels between neighbouring points of the lattice.
const TEXELS_PER_CELL: usize = 4;

/// Texels from one line of a hatching to the next, and how many of them are the line's.
const HATCH_TEXELS: usize = 9;
const HATCH_LINE_TEXELS: usize = 2;

/// Half the width of the line at the requirement, and of that with its edges, in texels.
const LEVEL_LINE_TEXELS: f64 = 0.8;
const LEVEL_EDGE_TEXELS: f64 = 2.0;

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

/// The texture, the plane's first axis along its rows.
pub fn picture(slice: &SliceOutcome, look: &SliceLook) -> Image {
    let [nu, nv] = slice.plan.counts;
    let (width, height) = (texels(nu), texels(nv));
    let mut data = Vec::with_capacity(width * height * 4);
    for y in 0..height {
        for x in 0..width {
            let [r, g, b] = color_at(slice, look, x, y);
            data.extend([r, g, b, 255]);
        }
    }
    let mut image = Image::new(
        Extent3d {
            width: width as u32,
            height: height as u32,
            depth_or_array_layers: 1,
        },
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

/// The colour of a texel.
fn color_at(slice: &SliceOutcome, look: &SliceLook, x: usize, y: usize) -> [u8; 3] {
    let place = [x, y].map(|t| t as f64 / TEXELS_PER_CELL as f64);
    let Some(value) = slice.value_at(place) else {
        return match is_hatch_line(x + y) {
            true => NO_VALUE_LINE_SRGB,
            false => NO_VALUE_SRGB,
        };
    };
    let map = look.scale.map.srgb_of_value(value, look.scale.max_mm);
    let believed = match slice.is_supported_at(place) {
        // Against the lines of what has no value.
        false if is_hatch_line(x + (HATCH_TEXELS - 1) * y) => {
            over(map, UNSUPPORTED_LINE_SRGB, UNSUPPORTED_LINE_OPACITY)
        }
        _ => map,
    };
    let level = look.level.and_then(|level| {
        let step = 1.0 / TEXELS_PER_CELL as f64;
        slice.cells_to_level(place, level, step)
    });
    match level {
        Some(cells) => with_level(believed, cells * TEXELS_PER_CELL as f64),
        None => believed,
    }
}

fn is_hatch_line(texel: usize) -> bool {
    texel % HATCH_TEXELS < HATCH_LINE_TEXELS
}

/// A colour so many texels from the line at the requirement, smooth at the line's edges.
fn with_level(color: [u8; 3], texels: f64) -> [u8; 3] {
    let within = |half_width: f64| (half_width + 0.5 - texels).clamp(0.0, 1.0);
    let edged = over(color, LEVEL_EDGE_SRGB, within(LEVEL_EDGE_TEXELS));
    over(edged, LEVEL_LINE_SRGB, within(LEVEL_LINE_TEXELS))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bounds::Bounds;
    use crate::geometry::colormap::ColorMap;
    use crate::study::{Quantity, SlicePlan, SlicePlane, Work};
    use nalgebra::Vector3;

    const LOOK: SliceLook = SliceLook {
        scale: ColorScale {
            map: ColorMap::Viridis,
            max_mm: 4.0,
        },
        level: None,
    };

    fn slice() -> SliceOutcome {
        SliceOutcome {
            plan: SlicePlan {
                plane: SlicePlane::Across {
                    normal_axis: 2,
                    position_mm: 5.0,
                    bounds: Bounds::from(([0.0; 3], [10.0, 20.0, 30.0])),
                },
                sensor_axis: Vector3::z_axis(),
                counts: [3, 2],
            },
            quantity: Quantity::PositionErrorMm,
            values: vec![0.0, 1.0, 2.0, 3.0, 4.0, 0.5],
            is_inside: vec![true, true, true, true, true, false],
            is_supported: Vec::new(),
            max: 4.0,
            p95: 4.0,
            work: Work::default(),
        }
    }

    #[test]
    fn a_point_of_the_lattice_has_the_colour_of_its_value() {
        for (i, value) in slice().values.iter().enumerate().take(5) {
            let (u, v) = (i % 3, i / 3);
            let color = color_at(&slice(), &LOOK, u * TEXELS_PER_CELL, v * TEXELS_PER_CELL);
            assert_eq!(color, ColorMap::Viridis.srgb_of_value(*value, 4.0));
        }
        let between = color_at(&slice(), &LOOK, TEXELS_PER_CELL / 2, 0);
        assert_eq!(between, ColorMap::Viridis.srgb_of_value(0.5, 4.0));
    }

    #[test]
    fn only_what_has_no_value_is_hatched_in_grey() {
        let slice = slice();
        let mut lines = 0;
        for y in 0..texels(2) {
            for x in 0..texels(3) {
                let color = color_at(&slice, &LOOK, x, y);
                let is_grey = [NO_VALUE_SRGB, NO_VALUE_LINE_SRGB].contains(&color);
                // The quarter of a cell around the last point.
                assert_eq!(is_grey, x >= 6 && y >= 2, "{x} {y}");
                lines += usize::from(color == NO_VALUE_LINE_SRGB);
            }
        }
        assert!((1..9).contains(&lines), "{lines} of 9 texels");
    }

    #[test]
    fn what_should_not_be_believed_is_the_map_with_lines() {
        let mut slice = slice();
        slice.is_inside[5] = true;
        slice.is_supported = vec![false, true, true, false, true, true];
        let plain = SliceOutcome {
            is_supported: Vec::new(),
            ..slice.clone()
        };
        let (mut lines, mut left) = (0, 0);
        for y in 0..texels(2) {
            for x in 0..texels(3) {
                let map = color_at(&plain, &LOOK, x, y);
                let line = over(map, UNSUPPORTED_LINE_SRGB, UNSUPPORTED_LINE_OPACITY);
                let color = color_at(&slice, &LOOK, x, y);
                assert!(color == map || (color == line && x < 2), "{x} {y}");
                lines += usize::from(color != map);
                left += usize::from(color == map && x < 2);
            }
        }
        assert!(lines >= 2 && left > lines, "{lines} {left}");
    }

    #[test]
    fn the_line_at_the_requirement_goes_where_the_value_passes_it() {
        let mut slice = slice();
        // 0 to 2 along the first axis, the same along the second.
        slice.values = vec![0.0, 1.0, 2.0, 0.0, 1.0, 2.0];
        slice.is_inside[5] = true;
        let look = SliceLook {
            level: Some(1.0),
            ..LOOK
        };
        for y in 0..texels(2) {
            let row: Vec<_> = (0..texels(3))
                .map(|x| color_at(&slice, &look, x, y))
                .collect();
            assert_eq!(row[TEXELS_PER_CELL], LEVEL_LINE_SRGB);
            let plain = |x| color_at(&slice, &LOOK, x, y);
            assert!((0..2).chain(7..9).all(|x| row[x] == plain(x)), "{row:?}");
            assert!([3, 5].into_iter().all(|x| row[x] != plain(x)));
        }
    }
}
