//! Colours for scalar values: perceptually even maps as 8-bit sRGB, and one colour for no value.

use serde::{Deserialize, Serialize};

/// What a value that is missing, not finite or outside the model's box is painted: a grey that no
/// map contains.
pub const NO_VALUE_SRGB: [u8; 3] = [0x6E, 0x73, 0x7B];

/// Lines over what has no value: hatched, so that the grey is not taken for a colour of a map.
pub const NO_VALUE_LINE_SRGB: [u8; 3] = [0x96, 0x9C, 0xA5];

/// Lines over a map where its model is not valid, and how opaque they are there.
pub const UNSUPPORTED_LINE_SRGB: [u8; 3] = [0xF4, 0xF6, 0xF8];
pub const UNSUPPORTED_LINE_OPACITY: f64 = 0.6;

/// The line where a map passes a requirement, and its edges: together they stand out from every
/// colour of a map.
pub const LEVEL_LINE_SRGB: [u8; 3] = [0xFF, 0xFF, 0xFF];
pub const LEVEL_EDGE_SRGB: [u8; 3] = [0x0C, 0x0F, 0x13];

/// A colour with another over it.
pub fn over(below: [u8; 3], above: [u8; 3], opacity: f64) -> [u8; 3] {
    let opacity = opacity.clamp(0.0, 1.0);
    std::array::from_fn(|k| {
        let (from, to) = (f64::from(below[k]), f64::from(above[k]));
        (from + (to - from) * opacity).round() as u8
    })
}

/// A map from a fraction of the range to a colour, lightness rising throughout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ColorMap {
    #[default]
    Viridis,
    Inferno,
    Cividis,
}

impl ColorMap {
    pub const ALL: [Self; 3] = [Self::Viridis, Self::Inferno, Self::Cividis];

    /// What a person calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Viridis => "viridis",
            Self::Inferno => "inferno",
            Self::Cividis => "cividis",
        }
    }

    /// The colour at a fraction of the range, held at both ends.
    pub fn srgb(self, fraction: f64) -> [u8; 3] {
        if fraction.is_nan() {
            return NO_VALUE_SRGB;
        }
        let gradient = match self {
            Self::Viridis => colorous::VIRIDIS,
            Self::Inferno => colorous::INFERNO,
            Self::Cividis => colorous::CIVIDIS,
        };
        let color = gradient.eval_continuous(fraction.clamp(0.0, 1.0));
        [color.r, color.g, color.b]
    }

    /// The colour of a value on a scale from 0 to `max`; a scale without extent is all bottom.
    pub fn srgb_of_value(self, value: f64, max: f64) -> [u8; 3] {
        if value.is_finite() && max > 0.0 {
            self.srgb(value / max)
        } else if value.is_finite() {
            self.srgb(0.0)
        } else {
            NO_VALUE_SRGB
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness of an sRGB colour.
    fn lightness(srgb: [u8; 3]) -> f64 {
        let [r, g, b] = crate::color::linear(srgb);
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        116.0 * y.cbrt() - 16.0
    }

    #[test]
    fn lightness_rises_along_every_map() {
        for map in ColorMap::ALL {
            let mut last = -20.0;
            for i in 0..=64 {
                let now = lightness(map.srgb(f64::from(i) / 64.0));
                // Eight bits round a step of about 1.3 by up to 0.3.
                assert!(now > last - 0.3, "{map:?} at {i}: {now} after {last}");
                last = now;
            }
            assert!(lightness(map.srgb(1.0)) - lightness(map.srgb(0.0)) > 60.0, "{map:?}");
        }
    }

    #[test]
    fn ends_of_viridis_are_the_published_ones() {
        assert_eq!(ColorMap::Viridis.srgb(0.0), [68, 1, 84]);
        assert_eq!(ColorMap::Viridis.srgb(1.0), [253, 231, 37]);
        assert_eq!(ColorMap::Viridis.srgb(7.0), [253, 231, 37]);
    }

    #[test]
    fn what_is_no_number_is_grey() {
        assert_eq!(ColorMap::Inferno.srgb(f64::NAN), NO_VALUE_SRGB);
        assert_eq!(ColorMap::Inferno.srgb_of_value(f64::INFINITY, 1.0), NO_VALUE_SRGB);
        assert_eq!(ColorMap::Inferno.srgb_of_value(0.5, 0.0), ColorMap::Inferno.srgb(0.0));
    }
}
