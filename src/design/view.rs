//! How a design is looked at: camera, layers, what is hidden or locked, magnification, slice. Saved with it, never undone.

use super::things::Things;
pub use crate::geometry::colormap::ColorMap;
pub use crate::study::{AxisRule, Quantity};
use serde::{Deserialize, Serialize};

/// The view of a design. Anything that a file leaves out has its default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct View {
    /// `None` frames tool and CRF.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraView>,
    #[serde(skip_serializing_if = "is_default")]
    pub layers: Layers,
    /// Neither drawn nor picked. What is wrong with them is said all the same.
    #[serde(skip_serializing_if = "is_default")]
    pub hidden: Things,
    /// Drawn, but not picked in the scene.
    #[serde(skip_serializing_if = "is_default")]
    pub locked: Things,
    #[serde(skip_serializing_if = "is_default")]
    pub magnification: Magnification,
    #[serde(skip_serializing_if = "is_default")]
    pub slice: SliceView,
    #[serde(skip_serializing_if = "is_default")]
    pub arrows: ArrowsView,
    /// How a sensor is imagined to be turned where its body is painted by placement.
    #[serde(skip_serializing_if = "is_default")]
    pub placement_rule: AxisRule,
}

/// An orbit camera in the tracker frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraView {
    pub focus_mm: [f64; 3],
    pub distance_mm: f64,
    pub azimuth_rad: f64,
    pub elevation_rad: f64,
}

/// What is drawn; a layer that is off costs nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(default)]
pub struct Layers {
    /// Edges of the tracker's measurement volume.
    pub volume: bool,
    pub generator: bool,
    pub grid: bool,
    /// The head or whatever else the CRF's mesh shows beside the CRF itself.
    pub anatomy: bool,
    /// Error vector of each sensor.
    pub sensor_errors: bool,
    /// Error vector of the tip.
    pub tip_error: bool,
    /// The tool as the tracker believes it to be.
    pub ghost: bool,
    /// What the tool's range of motion runs through.
    pub motion: bool,
    /// The ellipsoid that holds 95 % of where the tracker's jitter puts the tip.
    pub tip_scatter: bool,
    pub slice: bool,
    /// The field's error as arrows on a lattice.
    pub arrows: bool,
    /// The selected sensor's body painted by what the tip error would be with the sensor there.
    pub placement: bool,
    /// Where the design meets its requirement.
    pub region: bool,
    pub labels: bool,
}

impl Default for Layers {
    fn default() -> Self {
        Self {
            volume: true,
            generator: true,
            grid: true,
            anatomy: true,
            sensor_errors: true,
            tip_error: true,
            ghost: true,
            motion: true,
            tip_scatter: true,
            slice: true,
            arrows: false,
            placement: false,
            region: false,
            labels: true,
        }
    }
}

/// How many times larger than life errors are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Magnification {
    /// 1, 2 or 5 times a power of ten, so that the tip's error is easy to see.
    #[default]
    Auto,
    Times(f64),
}

/// The plane through the volume that is coloured by the error, or by how far to believe it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SliceView {
    #[serde(skip_serializing_if = "is_default")]
    pub quantity: Quantity,
    /// The tracker's axis that the plane is perpendicular to.
    pub axis: SliceAxis,
    /// Where along that axis, in the tracker frame.
    pub position_mm: f64,
    /// Axis of the sensor that is imagined at each point, in the tracker frame.
    pub sensor_axis: [f64; 3],
    /// Upper end of the colour bar, in the unit of the quantity; `None` takes the 95th percentile
    /// of the slice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_mm: Option<f64>,
    pub color_map: ColorMap,
}

impl Default for SliceView {
    fn default() -> Self {
        Self {
            quantity: Quantity::default(),
            axis: SliceAxis::Z,
            position_mm: -300.0,
            sensor_axis: [0.0, 0.0, 1.0],
            range_mm: None,
            color_map: ColorMap::default(),
        }
    }
}

/// The arrows of the field's error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ArrowsView {
    /// Arrows along each side of the lattice, within [`ArrowsView::PER_SIDE`].
    pub per_side: usize,
    /// Of the tool's own sensors as the design turns them; else of one along the slice's axis.
    pub of_tool: bool,
}

impl ArrowsView {
    /// From two corners to more than ten thousand arrows.
    pub const PER_SIDE: std::ops::RangeInclusive<usize> = 2..=22;

    /// What a file says, within what can be drawn.
    pub fn per_side(&self) -> usize {
        self.per_side
            .clamp(*Self::PER_SIDE.start(), *Self::PER_SIDE.end())
    }
}

impl Default for ArrowsView {
    fn default() -> Self {
        Self {
            per_side: 9,
            of_tool: false,
        }
    }
}

/// An axis of the tracker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum SliceAxis {
    X,
    Y,
    Z,
}

impl SliceAxis {
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// 0, 1, 2.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// A number of a view that cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ViewError {
    #[error("view.{field} is {value}, expected {expected}")]
    Number {
        field: &'static str,
        value: f64,
        expected: &'static str,
    },
}

impl View {
    /// # Errors
    /// The first number that is not finite, or not positive where it has to be.
    pub fn check(&self) -> Result<(), ViewError> {
        let error = |field, value, expected| {
            Err(ViewError::Number {
                field,
                value,
                expected,
            })
        };
        let finite = [
            ("slice.position_mm", Some(self.slice.position_mm)),
            ("camera.azimuth_rad", self.camera.map(|c| c.azimuth_rad)),
            ("camera.elevation_rad", self.camera.map(|c| c.elevation_rad)),
            (
                "camera.focus_mm",
                self.camera.and_then(|c| first_not_finite(&c.focus_mm)),
            ),
            (
                "slice.sensor_axis",
                first_not_finite(&self.slice.sensor_axis),
            ),
        ];
        for (field, value) in finite {
            if let Some(value) = value.filter(|v| !v.is_finite()) {
                return error(field, value, "a finite number");
            }
        }
        let magnification = match self.magnification {
            Magnification::Auto => None,
            Magnification::Times(times) => Some(times),
        };
        let positive = [
            ("camera.distance_mm", self.camera.map(|c| c.distance_mm)),
            ("magnification", magnification),
            ("slice.range_mm", self.slice.range_mm),
        ];
        for (field, value) in positive {
            if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
                return error(field, value, "a number above zero");
            }
        }
        if self.slice.sensor_axis.iter().all(|v| *v == 0.0) {
            return error("slice.sensor_axis", 0.0, "a direction");
        }
        Ok(())
    }
}

fn first_not_finite(values: &[f64; 3]) -> Option<f64> {
    values.iter().copied().find(|v| !v.is_finite())
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_that_says_nothing_is_the_default_one() {
        assert_eq!(ron::from_str::<View>("()").unwrap(), View::default());
        assert_eq!(ron::to_string(&View::default()).unwrap(), "()");
    }

    #[test]
    fn numbers_that_cannot_be_drawn_are_named() {
        let mut view = View::default();
        assert_eq!(view.check(), Ok(()));
        view.magnification = Magnification::Times(0.0);
        let message = view.check().unwrap_err().to_string();
        assert_eq!(
            message,
            "view.magnification is 0, expected a number above zero"
        );
        view.magnification = Magnification::Auto;
        view.slice.sensor_axis = [0.0, f64::NAN, 0.0];
        let message = view.check().unwrap_err().to_string();
        assert!(
            message.starts_with("view.slice.sensor_axis is NaN"),
            "{message}"
        );
    }
}
