//! A camera that orbits a point of the tracker frame, screen-up along tracker -z, in perspective or
//! in orthographic projection.

use super::pose::Pose;
use super::surface::Ray;
use nalgebra::{Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector2, Vector3};

/// Full vertical angle of view: narrow, so that lengths in depth compare well by eye.
pub const VERTICAL_FOV_RAD: f64 = 30.0 * std::f64::consts::PI / 180.0;

/// Straight up and down are left out by this much: there azimuth has no meaning.
const MAX_ELEVATION_RAD: f64 = 89.9 * std::f64::consts::PI / 180.0;

/// A drag over the whole height of the view turns the camera by half a turn.
const TURN_PER_HEIGHT_RAD: f64 = std::f64::consts::PI;

/// One notch of a wheel brings the camera nearer by this factor.
const ZOOM_PER_STEP: f64 = 0.88;

/// How far an orthographic camera stands from its focus: behind everything, since what it sees does
/// not depend on it.
pub const ORTHOGRAPHIC_EYE_MM: f64 = 10_000.0;

/// Nearest and farthest that a camera goes, in millimetres.
const DISTANCE_MM: std::ops::RangeInclusive<f64> = 10.0..=8000.0;

/// How much of the view a framed sphere leaves free around it.
const FRAME_MARGIN: f64 = 1.12;

/// One of a frame's three axes; of the tracker's, where a camera looks along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// The axis in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        }
    }

    /// Unit vector along the axis.
    pub fn unit(self) -> Unit<Vector3<f64>> {
        match self {
            Self::X => Vector3::x_axis(),
            Self::Y => Vector3::y_axis(),
            Self::Z => Vector3::z_axis(),
        }
    }

    /// The other two, such that the three are right-handed.
    pub fn others(self) -> [Self; 2] {
        match self {
            Self::X => [Self::Y, Self::Z],
            Self::Y => [Self::Z, Self::X],
            Self::Z => [Self::X, Self::Y],
        }
    }
}

/// One end of a frame's axis: a camera looks from there towards the other end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AxisEnd {
    pub axis: Axis,
    pub is_positive: bool,
}

impl AxisEnd {
    /// Both ends of x, then of y, then of z, the positive one first.
    pub const ALL: [Self; 6] = [
        Self::new(Axis::X, true),
        Self::new(Axis::X, false),
        Self::new(Axis::Y, true),
        Self::new(Axis::Y, false),
        Self::new(Axis::Z, true),
        Self::new(Axis::Z, false),
    ];

    /// The end of an axis where its coordinate is positive, or the other one.
    pub const fn new(axis: Axis, is_positive: bool) -> Self {
        Self { axis, is_positive }
    }

    /// `+X`, or `−X` with a true minus sign.
    pub const fn name(self) -> &'static str {
        match (self.axis, self.is_positive) {
            (Axis::X, true) => "+X",
            (Axis::X, false) => "\u{2212}X",
            (Axis::Y, true) => "+Y",
            (Axis::Y, false) => "\u{2212}Y",
            (Axis::Z, true) => "+Z",
            (Axis::Z, false) => "\u{2212}Z",
        }
    }

    /// Unit vector from the origin to this end.
    pub fn unit(self) -> Unit<Vector3<f64>> {
        if self.is_positive { self.axis.unit() } else { -self.axis.unit() }
    }
}

/// How depth is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Projection {
    /// What is farther away is smaller.
    #[default]
    Perspective,
    /// One scale at every depth, so that lengths across the view can be compared.
    Orthographic,
}

impl Projection {
    /// The one of the two that this is not.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Perspective => Self::Orthographic,
            Self::Orthographic => Self::Perspective,
        }
    }
}

/// Where the camera is, by what it looks at. Lengths in millimetres, angles in radians, tracker
/// frame; elevation is positive above, towards -z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitCamera {
    pub focus_mm: Point3<f64>,
    pub distance_mm: f64,
    pub azimuth_rad: f64,
    pub elevation_rad: f64,
    /// In orthographic projection the distance is that at which a perspective camera sees as much at
    /// the focus.
    pub projection: Projection,
}

impl OrbitCamera {
    /// How far the eye is from the focus.
    pub fn eye_distance_mm(&self) -> f64 {
        match self.projection {
            Projection::Perspective => self.distance_mm,
            Projection::Orthographic => ORTHOGRAPHIC_EYE_MM,
        }
    }

    /// The camera's pose in the tracker frame: x right, y up, z backwards, as cameras have it.
    pub fn tracker_from_camera(&self) -> Pose {
        let (sin_a, cos_a) = self.azimuth_rad.sin_cos();
        let (sin_e, cos_e) = self.elevation_rad.sin_cos();
        let back = Vector3::new(cos_e * cos_a, cos_e * sin_a, -sin_e);
        let right = Vector3::new(sin_a, -cos_a, 0.0);
        let up = back.cross(&right);
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[right, up, back]));
        Pose::from_parts(
            Translation3::from(self.focus_mm.coords + back * self.eye_distance_mm()),
            UnitQuaternion::from_rotation_matrix(&rotation),
        )
    }

    /// Turns by a drag in pixels (y down): the scene follows the pointer.
    pub fn orbit(&mut self, drag_px: [f64; 2], view_px: [f64; 2]) {
        let scale = TURN_PER_HEIGHT_RAD / view_px[1].max(1.0);
        self.azimuth_rad = wrap_angle(self.azimuth_rad + drag_px[0] * scale);
        self.elevation_rad =
            (self.elevation_rad + drag_px[1] * scale).clamp(-MAX_ELEVATION_RAD, MAX_ELEVATION_RAD);
    }

    /// The same after a part of a whole turn about the vertical through the focus; 1 is the same as 0.
    pub fn turned(&self, part: f64) -> Self {
        let angle_rad = part.rem_euclid(1.0) * std::f64::consts::TAU;
        Self {
            azimuth_rad: match angle_rad == 0.0 {
                true => self.azimuth_rad,
                false => wrap_angle(self.azimuth_rad + angle_rad),
            },
            ..*self
        }
    }

    /// Moves by a drag in pixels such that what lies at the focus stays under the pointer.
    pub fn pan(&mut self, drag_px: [f64; 2], view_px: [f64; 2]) {
        let mm_per_px = self.view_height_mm() / view_px[1].max(1.0);
        let rotation = self.tracker_from_camera().rotation;
        self.focus_mm += rotation * Vector3::new(-drag_px[0], drag_px[1], 0.0) * mm_per_px;
    }

    /// Goes nearer by notches of a wheel, towards what lies under the pointer.
    pub fn zoom(&mut self, steps: f64, pointer_px: [f64; 2], view_px: [f64; 2]) {
        let before = self.distance_mm;
        self.distance_mm = clamped_distance(before * ZOOM_PER_STEP.powf(steps));
        let ray = self.ray(pointer_px, view_px);
        // The point under the pointer in the focus' plane keeps its pixel.
        let old = Self { distance_mm: before, ..*self };
        let normal = self.tracker_from_camera().rotation * Vector3::z();
        let (Some(wanted), Some(now)) = (
            old.ray(pointer_px, view_px).meets_plane(&self.focus_mm, &normal),
            ray.meets_plane(&self.focus_mm, &normal),
        ) else {
            return;
        };
        self.focus_mm += wanted - now;
    }

    /// Looks at the same picture, turning about the depth of a point from now on; a point behind
    /// the camera changes nothing.
    pub fn refocus(&mut self, point_mm: &Point3<f64>) {
        let pose = self.tracker_from_camera();
        let depth = -(pose.inverse() * point_mm).z;
        if depth <= 0.0 {
            return;
        }
        let back = pose.rotation * Vector3::z();
        match self.projection {
            Projection::Perspective => {
                let distance_mm = clamped_distance(depth);
                self.focus_mm = Point3::from(pose.translation.vector - back * distance_mm);
                self.distance_mm = distance_mm;
            }
            // The scale is the same at every depth.
            Projection::Orthographic => {
                self.focus_mm += back * (point_mm - self.focus_mm).dot(&back);
            }
        }
    }

    /// Looks at a sphere from where the camera is turned to, the whole of it in view.
    pub fn frame_sphere(&mut self, center_mm: Point3<f64>, radius_mm: f64, view_px: [f64; 2]) {
        let aspect = view_px[0] / view_px[1].max(1.0);
        let half_height = (VERTICAL_FOV_RAD / 2.0).tan();
        let half_angle = half_height.min(half_height * aspect).atan();
        self.focus_mm = center_mm;
        // Rays that touch the sphere start at the eye, or are parallel.
        let per_radius = match self.projection {
            Projection::Perspective => half_angle.sin(),
            Projection::Orthographic => half_angle.tan(),
        };
        self.distance_mm = clamped_distance(radius_mm * FRAME_MARGIN / per_radius);
    }

    /// Turns to look along a tracker axis: x and y from their positive ends, z from above.
    pub fn look_along(&mut self, axis: Axis) {
        self.look_from(AxisEnd::new(axis, axis != Axis::Z));
    }

    /// Turns to look from an end of a tracker axis towards the other one.
    pub fn look_from(&mut self, end: AxisEnd) {
        use std::f64::consts::{FRAC_PI_2, PI};
        (self.azimuth_rad, self.elevation_rad) = match (end.axis, end.is_positive) {
            (Axis::X, true) => (0.0, 0.0),
            (Axis::X, false) => (PI, 0.0),
            (Axis::Y, true) => (FRAC_PI_2, 0.0),
            (Axis::Y, false) => (-FRAC_PI_2, 0.0),
            // Elevation is towards -z.
            (Axis::Z, true) => (FRAC_PI_2, -FRAC_PI_2),
            (Axis::Z, false) => (FRAC_PI_2, FRAC_PI_2),
        };
    }

    /// A direction of the tracker frame as it is on the screen: right, down, towards the viewer.
    pub fn on_screen(&self, direction: &Unit<Vector3<f64>>) -> [f64; 3] {
        let in_camera = self.tracker_from_camera().rotation.inverse() * direction.into_inner();
        [in_camera.x, -in_camera.y, in_camera.z]
    }

    /// Direction in which a point is seen, of any length.
    pub fn sight(&self, point_mm: &Point3<f64>) -> Vector3<f64> {
        let pose = self.tracker_from_camera();
        match self.projection {
            Projection::Perspective => point_mm.coords - pose.translation.vector,
            Projection::Orthographic => pose.rotation * -Vector3::z(),
        }
    }

    /// Height of what is seen at the focus, in millimetres.
    pub fn view_height_mm(&self) -> f64 {
        2.0 * self.distance_mm * (VERTICAL_FOV_RAD / 2.0).tan()
    }

    /// The ray under a pixel (from the view's top left, y down), in the tracker frame.
    pub fn ray(&self, pixel: [f64; 2], view_px: [f64; 2]) -> Ray {
        let right_px = pixel[0] - view_px[0] / 2.0;
        let up_px = view_px[1] / 2.0 - pixel[1];
        let eye = self.tracker_from_camera();
        match self.projection {
            Projection::Perspective => {
                let per_px = 2.0 * (VERTICAL_FOV_RAD / 2.0).tan() / view_px[1].max(1.0);
                let in_camera = Vector3::new(right_px * per_px, up_px * per_px, -1.0);
                Ray {
                    origin_mm: Point3::from(eye.translation.vector),
                    direction: Unit::new_normalize(eye.rotation * in_camera),
                }
            }
            Projection::Orthographic => {
                let per_px = self.view_height_mm() / view_px[1].max(1.0);
                Ray {
                    origin_mm: eye * Point3::new(right_px * per_px, up_px * per_px, 0.0),
                    direction: eye.rotation * -Vector3::z_axis(),
                }
            }
        }
    }

    /// The pixel of a point of the tracker frame; `None` behind the camera.
    pub fn project(&self, point_mm: &Point3<f64>, view_px: [f64; 2]) -> Option<[f64; 2]> {
        let in_camera = self.tracker_from_camera().inverse() * point_mm;
        if in_camera.z >= 0.0 {
            return None;
        }
        let px_per_mm = match self.projection {
            Projection::Perspective => {
                view_px[1] / (2.0 * (VERTICAL_FOV_RAD / 2.0).tan() * -in_camera.z)
            }
            Projection::Orthographic => view_px[1] / self.view_height_mm(),
        };
        Some([
            view_px[0] / 2.0 + in_camera.x * px_per_mm,
            view_px[1] / 2.0 - in_camera.y * px_per_mm,
        ])
    }

    /// Distance on the screen from a pixel to a segment; `None` where an end is behind the camera.
    pub fn distance_px(
        &self,
        pixel: [f64; 2],
        ends_mm: [Point3<f64>; 2],
        view_px: [f64; 2],
    ) -> Option<f64> {
        let [a, b] = ends_mm.map(|end| self.project(&end, view_px).map(Vector2::from));
        let (a, b) = (a?, b?);
        let along = b - a;
        let fraction = (Vector2::from(pixel) - a).dot(&along) / along.norm_squared();
        // Both ends on one pixel: that pixel.
        let fraction = if fraction.is_finite() { fraction.clamp(0.0, 1.0) } else { 0.0 };
        Some((Vector2::from(pixel) - a - along * fraction).norm())
    }

    /// Millimetres that a pixel spans at the depth of a point; `None` behind the camera.
    pub fn mm_per_px(&self, point_mm: &Point3<f64>, view_px: [f64; 2]) -> Option<f64> {
        let depth = -(self.tracker_from_camera().inverse() * point_mm).z;
        let height_mm = match self.projection {
            Projection::Perspective => 2.0 * depth * (VERTICAL_FOV_RAD / 2.0).tan(),
            Projection::Orthographic => self.view_height_mm(),
        };
        (depth > 0.0).then(|| height_mm / view_px[1].max(1.0))
    }

    /// Part of the way to another camera, the short way round, in its projection.
    pub fn towards(&self, other: &Self, fraction: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * fraction;
        Self {
            focus_mm: self.focus_mm + (other.focus_mm - self.focus_mm) * fraction,
            distance_mm: (mix(self.distance_mm.ln(), other.distance_mm.ln())).exp(),
            azimuth_rad: self.azimuth_rad
                + wrap_angle(other.azimuth_rad - self.azimuth_rad) * fraction,
            elevation_rad: mix(self.elevation_rad, other.elevation_rad),
            projection: other.projection,
        }
    }
}

fn clamped_distance(distance_mm: f64) -> f64 {
    distance_mm.clamp(*DISTANCE_MM.start(), *DISTANCE_MM.end())
}

/// To `[-π, π]`.
fn wrap_angle(angle_rad: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle_rad - (angle_rad / turn).round() * turn
}

#[cfg(test)]
mod tests;
