//! How thick and how long error vectors are drawn.

use nalgebra::Vector3;
use trackwright_geometry::solid::ArrowSize;

/// Vectors shorter than this on the screen are no arrows any more and are left out.
const LEAST_PX: f64 = 1.5;

/// Vectors longer than this share of the view's height are cut there and end in two heads.
const MOST_SHARE: f64 = 0.22;

/// How thick arrows are on the screen, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArrowStyle {
    pub shaft_px: f64,
    pub head_width_px: f64,
    pub head_length_px: f64,
}

impl ArrowStyle {
    /// A sensor's error.
    pub const OF_SENSOR: Self = Self { shaft_px: 2.6, head_width_px: 9.0, head_length_px: 11.0 };

    /// The tip's.
    pub const OF_TIP: Self = Self { shaft_px: 4.5, head_width_px: 15.0, head_length_px: 17.0 };

    /// Of a vector where a pixel spans so much, in a view so many pixels high; `None` where it is too
    /// short to be seen, or no vector.
    ///
    /// ```
    /// use nalgebra::Vector3;
    /// use trackwright_scene::arrow_style::ArrowStyle;
    /// let size = |mm| ArrowStyle::OF_TIP.size(&Vector3::new(mm, 0.0, 0.0), 0.5, 900.0);
    /// assert!(size(0.5).is_none());
    /// assert_eq!(size(20.0).map(|arrow| arrow.shaft_mm), Some(2.25));
    /// ```
    pub fn size(
        &self,
        vector_mm: &Vector3<f64>,
        mm_per_px: f64,
        height_px: f64,
    ) -> Option<ArrowSize> {
        let whole = vector_mm.norm();
        (whole > LEAST_PX * mm_per_px).then_some(ArrowSize {
            shaft_mm: self.shaft_px * mm_per_px,
            head_width_mm: self.head_width_px * mm_per_px,
            head_length_mm: self.head_length_px * mm_per_px,
            most_mm: MOST_SHARE * height_px * mm_per_px,
        })
    }
}
