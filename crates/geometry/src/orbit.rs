//! A camera that orbits a point of the tracker frame, screen-up along tracker -z.

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

/// Where the camera is, by what it looks at. Lengths in millimetres, angles in radians, tracker
/// frame; elevation is positive above, towards -z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitCamera {
    pub focus_mm: Point3<f64>,
    pub distance_mm: f64,
    pub azimuth_rad: f64,
    pub elevation_rad: f64,
}

impl OrbitCamera {
    /// The camera's pose in the tracker frame: x right, y up, z backwards, as cameras have it.
    pub fn tracker_from_camera(&self) -> Pose {
        let (sin_a, cos_a) = self.azimuth_rad.sin_cos();
        let (sin_e, cos_e) = self.elevation_rad.sin_cos();
        let back = Vector3::new(cos_e * cos_a, cos_e * sin_a, -sin_e);
        let right = Vector3::new(sin_a, -cos_a, 0.0);
        let up = back.cross(&right);
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[right, up, back]));
        Pose::from_parts(
            Translation3::from(self.focus_mm.coords + back * self.distance_mm),
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
        if depth > 0.0 {
            let distance_mm = clamped_distance(depth);
            let back = pose.rotation * Vector3::z();
            self.focus_mm = Point3::from(pose.translation.vector - back * distance_mm);
            self.distance_mm = distance_mm;
        }
    }

    /// Looks at a sphere from where the camera is turned to, the whole of it in view.
    pub fn frame_sphere(&mut self, center_mm: Point3<f64>, radius_mm: f64, view_px: [f64; 2]) {
        let aspect = view_px[0] / view_px[1].max(1.0);
        let half_height = (VERTICAL_FOV_RAD / 2.0).tan();
        let half_angle = half_height.min(half_height * aspect).atan();
        self.focus_mm = center_mm;
        self.distance_mm = clamped_distance(radius_mm * FRAME_MARGIN / half_angle.sin());
    }

    /// Turns to look along a tracker axis; along z from above.
    pub fn look_along(&mut self, axis: Axis) {
        (self.azimuth_rad, self.elevation_rad) = match axis {
            Axis::X => (0.0, 0.0),
            Axis::Y => (std::f64::consts::FRAC_PI_2, 0.0),
            Axis::Z => (std::f64::consts::FRAC_PI_2, MAX_ELEVATION_RAD),
        };
    }

    /// Height of what is seen at the focus, in millimetres.
    pub fn view_height_mm(&self) -> f64 {
        2.0 * self.distance_mm * (VERTICAL_FOV_RAD / 2.0).tan()
    }

    /// The ray under a pixel (from the view's top left, y down), in the tracker frame.
    pub fn ray(&self, pixel: [f64; 2], view_px: [f64; 2]) -> Ray {
        let half_height = (VERTICAL_FOV_RAD / 2.0).tan();
        let per_px = 2.0 * half_height / view_px[1].max(1.0);
        let in_camera = Vector3::new(
            (pixel[0] - view_px[0] / 2.0) * per_px,
            (view_px[1] / 2.0 - pixel[1]) * per_px,
            -1.0,
        );
        let tracker_from_camera = self.tracker_from_camera();
        Ray {
            origin_mm: Point3::from(tracker_from_camera.translation.vector),
            direction: Unit::new_normalize(tracker_from_camera.rotation * in_camera),
        }
    }

    /// The pixel of a point of the tracker frame; `None` behind the camera.
    pub fn project(&self, point_mm: &Point3<f64>, view_px: [f64; 2]) -> Option<[f64; 2]> {
        let in_camera = self.tracker_from_camera().inverse() * point_mm;
        if in_camera.z >= 0.0 {
            return None;
        }
        let px_per = view_px[1] / (2.0 * (VERTICAL_FOV_RAD / 2.0).tan());
        Some([
            view_px[0] / 2.0 + in_camera.x / -in_camera.z * px_per,
            view_px[1] / 2.0 - in_camera.y / -in_camera.z * px_per,
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
        (depth > 0.0).then(|| 2.0 * depth * (VERTICAL_FOV_RAD / 2.0).tan() / view_px[1].max(1.0))
    }

    /// Part of the way to another camera, the short way round.
    pub fn towards(&self, other: &Self, fraction: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * fraction;
        Self {
            focus_mm: self.focus_mm + (other.focus_mm - self.focus_mm) * fraction,
            distance_mm: (mix(self.distance_mm.ln(), other.distance_mm.ln())).exp(),
            azimuth_rad: self.azimuth_rad
                + wrap_angle(other.azimuth_rad - self.azimuth_rad) * fraction,
            elevation_rad: mix(self.elevation_rad, other.elevation_rad),
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
mod tests {
    use super::*;

    const VIEW: [f64; 2] = [900.0, 600.0];

    fn camera() -> OrbitCamera {
        OrbitCamera {
            focus_mm: Point3::new(20.0, -10.0, -300.0),
            distance_mm: 800.0,
            azimuth_rad: 0.7,
            elevation_rad: 0.3,
        }
    }

    #[test]
    fn tracker_minus_z_is_up_on_the_screen() {
        let pose = camera().tracker_from_camera();
        let m = pose.rotation.to_rotation_matrix();
        assert!((m.matrix().determinant() - 1.0).abs() < 1e-12);
        let above = camera().project(&Point3::new(20.0, -10.0, -350.0), VIEW).unwrap();
        assert!((above[0] - 450.0).abs() < 1e-9 && above[1] < 300.0, "{above:?}");
    }

    #[test]
    fn projection_inverts_rays() {
        let point = Point3::new(60.0, 40.0, -250.0);
        let pixel = camera().project(&point, VIEW).unwrap();
        let ray = camera().ray(pixel, VIEW);
        let off = (point - ray.origin_mm).cross(&ray.direction).norm();
        assert!(off < 1e-9, "{off}");
        let behind = camera().tracker_from_camera() * Point3::new(0.0, 0.0, 1.0);
        assert!(camera().project(&behind, VIEW).is_none());
    }

    #[test]
    fn panning_keeps_the_focus_under_the_pointer() {
        let mut moved = camera();
        moved.pan([120.0, -45.0], VIEW);
        let pixel = moved.project(&camera().focus_mm, VIEW).unwrap();
        assert!((pixel[0] - 570.0).abs() < 1e-6 && (pixel[1] - 255.0).abs() < 1e-6, "{pixel:?}");
    }

    #[test]
    fn zooming_keeps_the_point_under_the_pointer() {
        let pointer = [700.0, 140.0];
        let normal = camera().tracker_from_camera().rotation * Vector3::z();
        let ray = camera().ray(pointer, VIEW);
        let point = ray.meets_plane(&camera().focus_mm, &normal).unwrap();
        let mut nearer = camera();
        nearer.zoom(4.0, pointer, VIEW);
        let pixel = nearer.project(&point, VIEW).unwrap();
        assert!(nearer.distance_mm < 500.0);
        assert!((pixel[0] - 700.0).abs() < 1e-6 && (pixel[1] - 140.0).abs() < 1e-6, "{pixel:?}");
    }

    #[test]
    fn focusing_on_another_depth_changes_no_pixel() {
        let point = Point3::new(90.0, -60.0, -380.0);
        let pixel = camera().project(&point, VIEW).unwrap();
        let mut refocused = camera();
        refocused.refocus(&point);
        let same = refocused.project(&point, VIEW).unwrap();
        assert!((pixel[0] - same[0]).abs() < 1e-9 && (pixel[1] - same[1]).abs() < 1e-9);
        let depth = -(camera().tracker_from_camera().inverse() * point).z;
        assert!((refocused.distance_mm - depth).abs() < 1e-9);
    }

    #[test]
    fn a_framed_sphere_fills_the_view_and_no_more() {
        let mut framed = camera();
        framed.frame_sphere(Point3::new(0.0, 0.0, -200.0), 50.0, VIEW);
        let rotation = framed.tracker_from_camera().rotation;
        let top = framed.focus_mm + rotation * Vector3::y() * 50.0;
        let y = framed.project(&top, VIEW).unwrap()[1];
        assert!((15.0..60.0).contains(&y), "{y}");
    }

    #[test]
    fn orbiting_stops_at_the_poles() {
        let mut turned = camera();
        turned.orbit([600.0, 0.0], VIEW);
        assert!((wrap_angle(turned.azimuth_rad - 0.7).abs() - std::f64::consts::PI).abs() < 1e-9);
        turned.orbit([0.0, 5000.0], VIEW);
        assert_eq!(turned.elevation_rad, MAX_ELEVATION_RAD);
    }

    #[test]
    fn a_whole_turn_is_exact() {
        let camera = camera();
        assert_eq!(camera.turned(1.0), camera.turned(0.0));
        assert_eq!(camera.turned(0.0), camera);
        let eye_mm = |camera: &OrbitCamera| camera.tracker_from_camera().translation.vector;
        let (front, back) = (eye_mm(&camera), eye_mm(&camera.turned(0.5)));
        // As high as before, and mirrored in the vertical through the focus.
        let focus_mm = camera.focus_mm.coords;
        let expected = 2.0 * focus_mm - front;
        assert!((back.xy() - expected.xy()).norm() < 1e-9 && (back.z - front.z).abs() < 1e-9);
        let quarter = camera.turned(0.25).turned(0.25);
        assert!((eye_mm(&quarter) - back).norm() < 1e-9);
    }

    #[test]
    fn a_pixel_spans_what_the_projection_gives() {
        let point = Point3::new(60.0, 40.0, -250.0);
        let right = camera().tracker_from_camera().rotation * Vector3::x();
        let step = camera().mm_per_px(&point, VIEW).unwrap() * 10.0;
        let a = camera().project(&point, VIEW).unwrap();
        let b = camera().project(&(point + right * step), VIEW).unwrap();
        assert!((b[0] - a[0] - 10.0).abs() < 1e-9);
    }

    #[test]
    fn screen_distances_are_to_the_segment() {
        let [a, b] = [Point3::new(20.0, 0.0, -300.0), Point3::new(60.0, 40.0, -250.0)];
        let [pa, pb] = [a, b].map(|p| camera().project(&p, VIEW).unwrap());
        let at = |t: f64| [pa[0] + (pb[0] - pa[0]) * t, pa[1] + (pb[1] - pa[1]) * t];
        let length = ((pb[0] - pa[0]).powi(2) + (pb[1] - pa[1]).powi(2)).sqrt();
        assert!(camera().distance_px(at(0.3), [a, b], VIEW).unwrap() < 1e-9);
        let beyond = camera().distance_px(at(1.5), [a, b], VIEW).unwrap();
        assert!((beyond - length / 2.0).abs() < 1e-9);
        assert!(camera().distance_px(pa, [a, a], VIEW).unwrap() < 1e-9);
    }

    #[test]
    fn a_glide_takes_the_short_way_round() {
        let from = OrbitCamera { azimuth_rad: 3.0, ..camera() };
        let to = OrbitCamera { azimuth_rad: -3.0, ..camera() };
        let middle = from.towards(&to, 0.5);
        assert!((middle.azimuth_rad.abs() - std::f64::consts::PI).abs() < 1e-9);
        assert!(
            (from.towards(&to, 1.0).project(&Point3::origin(), VIEW).unwrap()[0]
                - to.project(&Point3::origin(), VIEW).unwrap()[0])
                .abs()
                < 1e-9
        );
    }
}
