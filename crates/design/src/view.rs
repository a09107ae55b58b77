//! How a design is looked at: camera, layers, what is hidden or locked, magnification, slice. Saved with it, never undone.

pub use super::layers::{Layer, Layers};
use super::things::Things;
use nalgebra::{Point3, Unit, Vector3};
use serde::{Deserialize, Serialize};
use trackwright_geometry::bounds::Bounds;
pub use trackwright_geometry::colormap::ColorMap;
use trackwright_geometry::limits::{
    angle_problem, length_above_zero_problem, position_problem, short,
};
use trackwright_geometry::orbit::{OrbitCamera, Projection};
use trackwright_simulation::SlicePlane;
pub use trackwright_simulation::{AxisRule, CoilDepth, Quantity};

/// Largest factor that errors are drawn by: a picometre as a metre.
const MAX_MAGNIFICATION: f64 = 1e12;

/// The view of a design. Anything that a file leaves out has its default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct View {
    /// `None` frames tool and CRF.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraView>,
    #[serde(skip_serializing_if = "is_default")]
    pub layers: Layers,
    /// What a file turns on by names that no layer has: those of another version, or mistyped.
    /// Reported where the view is shown, and never written.
    #[serde(skip)]
    pub unknown_layers: Vec<String>,
    /// Neither drawn nor picked. What is wrong with them is reported all the same.
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
    /// How deep below the surface it is imagined there.
    #[serde(skip_serializing_if = "is_default")]
    pub placement_depth: CoilDepth,
    /// Upper end of the colours of placement; `None` takes the 95th percentile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub placement_range_mm: Option<f64>,
}

/// An orbit camera in the tracker frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraView {
    pub focus_mm: [f64; 3],
    pub distance_mm: f64,
    pub azimuth_rad: f64,
    pub elevation_rad: f64,
    /// Left out by a file, it is in perspective.
    #[serde(default, skip_serializing_if = "is_default")]
    pub is_orthographic: bool,
}

impl From<OrbitCamera> for CameraView {
    fn from(camera: OrbitCamera) -> Self {
        Self {
            focus_mm: camera.focus_mm.coords.into(),
            distance_mm: camera.distance_mm,
            azimuth_rad: camera.azimuth_rad,
            elevation_rad: camera.elevation_rad,
            is_orthographic: camera.projection == Projection::Orthographic,
        }
    }
}

impl From<CameraView> for OrbitCamera {
    fn from(view: CameraView) -> Self {
        Self {
            focus_mm: view.focus_mm.into(),
            distance_mm: view.distance_mm,
            azimuth_rad: view.azimuth_rad,
            elevation_rad: view.elevation_rad,
            projection: match view.is_orthographic {
                true => Projection::Orthographic,
                false => Projection::Perspective,
            },
        }
    }
}

/// How many times larger than life errors are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Magnification {
    /// 1, 2 or 5 times a power of ten, so that the tip's error is easy to see when the design is
    /// opened; kept from then on.
    #[default]
    Auto,
    Times(f64),
}

/// The plane through the volume that is coloured by the error, or by the model validity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SliceView {
    #[serde(skip_serializing_if = "is_default")]
    pub quantity: Quantity,
    /// The tracker's axis that the plane is perpendicular to, unless it is a free one.
    pub axis: SliceAxis,
    /// Where along that axis, in the tracker frame.
    pub position_mm: f64,
    /// Any plane, in the place of one across an axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub free: Option<FreePlane>,
    /// Axis of the sensor that is imagined at each point, in the tracker frame.
    pub sensor_axis: [f64; 3],
    /// Upper end of the colour bar, in the unit of the quantity; `None` takes the 95th percentile
    /// of the slice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_mm: Option<f64>,
    /// Of the first coloured layer; see [`View::color_maps`].
    pub color_map: ColorMap,
}

impl Default for SliceView {
    fn default() -> Self {
        Self {
            quantity: Quantity::default(),
            axis: SliceAxis::Z,
            position_mm: -300.0,
            free: None,
            sensor_axis: [0.0, 0.0, 1.0],
            range_mm: None,
            color_map: ColorMap::default(),
        }
    }
}

/// A plane that faces any way, tracker frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FreePlane {
    /// Any length but zero.
    pub normal: [f64; 3],
    /// From the tracker's origin along the normal.
    pub offset_mm: f64,
}

impl FreePlane {
    fn unit_normal(&self) -> Unit<Vector3<f64>> {
        let normal = Vector3::from(self.normal);
        // Whatever a file holds, the square of its length is a number.
        Unit::try_new(normal / normal.amax(), 0.5).unwrap_or_else(Vector3::z_axis)
    }
}

impl SliceView {
    /// Which way the plane faces, tracker frame.
    pub fn normal(&self) -> Unit<Vector3<f64>> {
        match &self.free {
            Some(free) => free.unit_normal(),
            None => Unit::new_unchecked(Vector3::ith(self.axis.index(), 1.0)),
        }
    }

    /// Where the plane is along its normal, from the tracker's origin.
    pub fn offset_mm(&self) -> f64 {
        self.free.map_or(self.position_mm, |free| free.offset_mm)
    }

    /// Moves the plane along its normal.
    pub fn set_offset_mm(&mut self, offset_mm: f64) {
        match &mut self.free {
            Some(free) => free.offset_mm = offset_mm,
            None => self.position_mm = offset_mm,
        }
    }

    /// Turns the plane to face the camera, through what the camera looks at or as near to that as
    /// the box reaches. It stays there when the camera turns: seen from elsewhere it is the same
    /// plane, and nothing is computed while one looks around.
    pub fn face(&mut self, camera: &OrbitCamera, bounds: &Bounds) {
        let back = camera.tracker_from_camera().rotation * Vector3::z_axis();
        let [least, most] = bounds.span_mm(&back);
        self.free = Some(FreePlane {
            normal: back.into_inner().into(),
            offset_mm: back.dot(&camera.focus_mm.coords).clamp(least, most),
        });
    }

    /// The plane over a box: across an axis the box's own section, else what holds its shadow along
    /// the normal, screen-up (tracker -z) as near to up as that allows.
    pub fn plane(&self, bounds: &Bounds) -> SlicePlane {
        match &self.free {
            None => SlicePlane::Across {
                normal_axis: self.axis.index(),
                position_mm: self.position_mm,
                bounds: *bounds,
            },
            Some(free) => {
                let normal = free.unit_normal();
                let through = Point3::from(normal.into_inner() * free.offset_mm);
                SlicePlane::facing(bounds, &through, &normal, &-Vector3::z())
            }
        }
    }
}

/// The arrows of the field's error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ArrowsView {
    /// Arrows along each side of the lattice, within [`ArrowsView::PER_SIDE`].
    pub per_side: usize,
    /// Of the tool's own sensors as the design turns them; else of one along the slice's axis.
    pub of_tool: bool,
    /// Upper end of the arrows' colours; `None` takes the 95th percentile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_mm: Option<f64>,
}

impl ArrowsView {
    /// From two corners to more than ten thousand arrows.
    pub const PER_SIDE: std::ops::RangeInclusive<usize> = 2..=22;

    /// The file's number, limited to what can be drawn.
    pub fn per_side(&self) -> usize {
        self.per_side.clamp(*Self::PER_SIDE.start(), *Self::PER_SIDE.end())
    }
}

impl Default for ArrowsView {
    fn default() -> Self {
        Self { per_side: 9, of_tool: false, range_mm: None }
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

/// The map of each coloured layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColorMaps {
    pub slice: ColorMap,
    pub arrows: ColorMap,
    pub placement: ColorMap,
    /// One that none of the layers that are on has, as far as there are as many.
    pub spare: ColorMap,
}

/// A number of a view that cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ViewError {
    #[error("view.{field} is {}, expected {expected}", short(*value))]
    Number { field: &'static str, value: f64, expected: &'static str },
}

impl View {
    /// Whether it holds anything that a file without a view would not.
    pub fn is_to_be_written(&self) -> bool {
        let default = Self { unknown_layers: self.unknown_layers.clone(), ..Self::default() };
        *self != default
    }

    /// Whether the arrows have the slice's scale: both show position errors.
    pub fn arrows_share_scale(&self) -> bool {
        let layers = &self.layers;
        layers.slice && layers.arrows && self.slice.quantity == Quantity::PositionErrorMm
    }

    /// Upper end of the slice's colours, which the arrows may share; `None` is automatic.
    pub fn slice_range(&self) -> Option<f64> {
        let shared = self.arrows.range_mm.filter(|_| self.arrows_share_scale());
        self.slice.range_mm.or(shared)
    }

    /// Sets that end; what the arrows were set to counts no longer where they share it.
    pub fn set_slice_range(&mut self, range: Option<f64>) {
        if range != self.slice_range() {
            self.slice.range_mm = range;
            if self.arrows_share_scale() {
                self.arrows.range_mm = None;
            }
        }
    }

    /// The maps of the layers that are on: of two scales each has its own map. The chosen one is
    /// that of the first layer.
    pub fn color_maps(&self) -> ColorMaps {
        let all = ColorMap::ALL;
        let chosen = self.slice.color_map;
        let first = all.iter().position(|map| *map == chosen).unwrap_or(0);
        let mut rest = (0..all.len()).map(|k| all[(first + k) % all.len()]);
        let mut of = |is_on: bool| if is_on { rest.next().unwrap_or(chosen) } else { chosen };
        let slice = of(self.layers.slice);
        let arrows = match self.arrows_share_scale() {
            true => slice,
            false => of(self.layers.arrows),
        };
        let placement = of(self.layers.placement);
        ColorMaps { slice, arrows, placement, spare: of(true) }
    }

    /// Whether it can be drawn.
    ///
    /// ```
    /// use trackwright_design::view::{Magnification, View};
    ///
    /// let view = View { magnification: Magnification::Times(0.0), ..View::default() };
    /// let error = view.check().unwrap_err().to_string();
    /// assert_eq!(error, "view.magnification is 0, expected a number above zero");
    /// ```
    ///
    /// # Errors
    /// The first number that is not finite, too large, or not positive where it has to be.
    pub fn check(&self) -> Result<(), ViewError> {
        type Problem = fn(f64) -> Option<&'static str>;
        let error = |field, value, expected| Err(ViewError::Number { field, value, expected });
        let position: Problem = |value| position_problem(&[value]);
        let angle: Problem = |value| angle_problem(value.abs().to_degrees());
        let (slice, free, camera) = (&self.slice, self.slice.free, self.camera);
        // Any length of a direction will do that can be squared.
        let numbers: [(_, Option<f64>, Problem); 11] = [
            ("slice.position_mm", Some(slice.position_mm), position),
            ("slice.free.offset_mm", free.map(|free| free.offset_mm), position),
            ("slice.free.normal", free.and_then(|free| worst(&free.normal)), position),
            ("camera.focus_mm", camera.and_then(|c| worst(&c.focus_mm)), position),
            ("slice.sensor_axis", worst(&slice.sensor_axis), position),
            ("camera.azimuth_rad", camera.map(|c| c.azimuth_rad), angle),
            ("camera.elevation_rad", camera.map(|c| c.elevation_rad), angle),
            ("camera.distance_mm", camera.map(|c| c.distance_mm), length_above_zero_problem),
            ("slice.range_mm", slice.range_mm, length_above_zero_problem),
            ("arrows.range_mm", self.arrows.range_mm, length_above_zero_problem),
            ("placement_range_mm", self.placement_range_mm, length_above_zero_problem),
        ];
        for (field, value, problem) in numbers {
            if let Some((value, expected)) = value.and_then(|v| Some((v, problem(v)?))) {
                return error(field, value, expected);
            }
        }
        if let Magnification::Times(times) = self.magnification {
            if !(times.is_finite() && times > 0.0) {
                return error("magnification", times, "a number above zero");
            }
            if times > MAX_MAGNIFICATION {
                return error("magnification", times, "at most 1e12");
            }
        }
        let directions = [
            ("slice.sensor_axis", Some(self.slice.sensor_axis)),
            ("slice.free.normal", self.slice.free.map(|free| free.normal)),
        ];
        for (field, direction) in directions {
            if direction.is_some_and(|d| d.iter().all(|v| *v == 0.0)) {
                return error(field, 0.0, "a direction");
            }
        }
        Ok(())
    }
}

/// The first of the numbers that no coordinate may be.
fn worst(values: &[f64; 3]) -> Option<f64> {
    let is_wrong = |value: &f64| position_problem([value]).is_some();
    values.iter().copied().find(is_wrong)
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_view_is_the_default_one() {
        assert_eq!(ron::from_str::<View>("()").unwrap(), View::default());
        assert_eq!(ron::to_string(&View::default()).unwrap(), "()");
    }

    #[test]
    fn numbers_that_cannot_be_drawn_are_named() {
        let mut view = View::default();
        assert_eq!(view.check(), Ok(()));
        view.magnification = Magnification::Times(0.0);
        let message = view.check().unwrap_err().to_string();
        assert_eq!(message, "view.magnification is 0, expected a number above zero");
        view.magnification = Magnification::Auto;
        view.slice.sensor_axis = [0.0, f64::NAN, 0.0];
        let message = view.check().unwrap_err().to_string();
        assert!(message.starts_with("view.slice.sensor_axis is NaN"), "{message}");
        view.slice.sensor_axis = [0.0, 0.0, 1.0];
        let mut free = FreePlane { normal: [0.0; 3], offset_mm: -250.0 };
        view.slice.free = Some(free);
        let message = view.check().unwrap_err().to_string();
        assert_eq!(message, "view.slice.free.normal is 0, expected a direction");
        free.normal = [0.0, 2.0, 0.0];
        view.slice.free = Some(free);
        assert_eq!(view.check(), Ok(()));
        free.offset_mm = f64::INFINITY;
        view.slice.free = Some(free);
        assert!(view.check().is_err());
    }

    #[test]
    fn two_scales_never_share_a_colour_map() {
        for quantity in Quantity::ALL {
            for on in 0..8 {
                let mut view = View::default();
                view.slice.quantity = quantity;
                view.slice.color_map = ColorMap::ALL[on % 3];
                view.layers.slice = on & 1 > 0;
                view.layers.arrows = on & 2 > 0;
                view.layers.placement = on & 4 > 0;
                let maps = view.color_maps();
                let is_shared = maps.slice == maps.arrows;
                if view.layers.slice && view.layers.arrows {
                    assert_eq!(is_shared, quantity == Quantity::PositionErrorMm, "{view:?}");
                }
                if view.layers.placement {
                    assert!(!view.layers.slice || maps.placement != maps.slice, "{view:?}");
                    assert!(!view.layers.arrows || maps.placement != maps.arrows, "{view:?}");
                }
                // What is on alone has the map that a person chose.
                let first = match on & 1 > 0 {
                    true => Some(maps.slice),
                    false if on & 2 > 0 => Some(maps.arrows),
                    false => (on & 4 > 0).then_some(maps.placement),
                };
                assert!(first.is_none_or(|map| map == view.slice.color_map), "{view:?}");
            }
        }
    }

    #[test]
    fn one_quantity_has_one_range() {
        let mut view = View::default();
        view.layers.arrows = true;
        view.arrows.range_mm = Some(1.5);
        assert_eq!(view.slice_range(), Some(1.5));
        view.set_slice_range(Some(1.5));
        assert_eq!((view.slice.range_mm, view.arrows.range_mm), (None, Some(1.5)), "no change");
        view.set_slice_range(None);
        assert_eq!(view.slice_range(), None);
        view.set_slice_range(Some(2.0));
        view.slice = SliceView { quantity: Quantity::OrientationErrorDeg, ..SliceView::default() };
        assert_eq!(view.slice_range(), None);
    }

    #[test]
    fn a_facing_slice_goes_through_the_focus() {
        let bounds = Bounds::from(([-100.0, -100.0, -400.0], [100.0, 100.0, -200.0]));
        let mut camera = OrbitCamera {
            focus_mm: Point3::new(20.0, -30.0, -310.0),
            distance_mm: 800.0,
            azimuth_rad: 0.7,
            elevation_rad: 0.4,
            projection: Projection::Perspective,
        };
        let mut view = View::default();
        view.slice.face(&camera, &bounds);
        let plane = view.slice.plane(&bounds);
        let eye = camera.tracker_from_camera().translation.vector;
        let toward_eye = (eye - camera.focus_mm.coords).normalize();
        assert!((plane.normal().into_inner() - toward_eye).norm() < 1e-12);
        let off = view.slice.normal().dot(&camera.focus_mm.coords) - view.slice.offset_mm();
        assert!(off.abs() < 1e-12);
        // The first axis is to the right on the screen, the second up.
        let [right, up] = plane.axes();
        let in_camera = camera.tracker_from_camera().rotation.inverse();
        assert!((in_camera * right.into_inner() - Vector3::x()).norm() < 1e-12);
        assert!((in_camera * up.into_inner() - Vector3::y()).norm() < 1e-12);
        let file = ron::to_string(&view).unwrap();
        assert_eq!(ron::from_str::<View>(&file).unwrap(), view);
        // A focus beyond the box: the plane touches the box.
        camera.focus_mm = Point3::new(0.0, 5000.0, -300.0);
        view.slice.face(&camera, &bounds);
        let [least, most] = bounds.span_mm(&view.slice.normal());
        assert!([least, most].contains(&view.slice.offset_mm()));
        view.slice.set_offset_mm(least + 1.0);
        assert_eq!(view.slice.offset_mm(), least + 1.0);
        assert_eq!(view.slice.position_mm, SliceView::default().position_mm);
    }
}
