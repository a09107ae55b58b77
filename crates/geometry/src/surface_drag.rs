//! Sliding a sensor along a body: pure functions of where the drag began and where it is now.

use super::pose::Pose;
use super::revolution::RevolutionAxis;
use super::rotation::{axis_rotation, exp_vector, perpendicular};
use super::surface::{Ray, Surface, SurfacePoint};
use nalgebra::{Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

/// Normals closer than this to the long axis are end caps, where the long axis gives no
/// direction in the surface.
const CAP_ANGLE_RAD: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// A face is flat where normals within a step of the grid differ by less than this: a tube of
/// more than 57 steps' radius counts as flat, one that a hand can hold does not.
const FLAT_ANGLE_RAD: f64 = std::f64::consts::PI / 180.0;

/// A sensor this close to the axis of a body of revolution lies on it, as in the bore of a needle: more
/// than a place that was typed or clicked is off, less than the wall of any tube.
pub const ON_AXIS_MM: f64 = 0.1;

/// A grid that places on a surface are rounded to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    pub step_mm: f64,
    /// Whether it has lines across the body's long axis only, as around a shaft, where there is no
    /// other coordinate that stays in the surface, or both ways.
    pub is_flat: bool,
}

impl Grid {
    /// The grid at a point of a surface.
    pub fn at(surface: &Surface, point: &SurfacePoint, step_mm: f64) -> Self {
        let [u, v] = tangents(&point.normal);
        let is_flat = [u, -u, v, -v].iter().all(|direction| {
            let beside = surface.closest(&(point.position_mm + direction * step_mm));
            beside.normal.dot(&point.normal) > FLAT_ANGLE_RAD.cos()
        });
        Self { step_mm, is_flat }
    }
}

/// Two directions in the plane of a normal.
fn tangents(normal: &Unit<Vector3<f64>>) -> [Vector3<f64>; 2] {
    let u = perpendicular(normal);
    [u.into_inner(), normal.cross(&u)]
}

/// What a drag along a body goes by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DragGuide {
    /// Direction in which the body is longest, body frame.
    pub long_axis: Vector3<f64>,
    /// Of a body of revolution: what lies on it slides along it.
    pub axis: Option<RevolutionAxis>,
    /// Whether the sensor's axis turns with the surface's normal; else it stays as it is, and only
    /// the sensor's place goes around the body with the surface.
    pub follows_surface: bool,
}

/// Where a sensor that is held sits relative to the surface.
///
/// Poses are of the sensor in its body, millimetres. Every pose of a drag comes from its start:
/// nothing is added up, so going back to the first point gives back the first pose.
#[derive(Clone, Debug)]
pub struct SurfaceDrag {
    start_body_from_sensor: Pose,
    start: SurfaceFrame,
    latest: SurfaceFrame,
    long_axis: Unit<Vector3<f64>>,
    axis: Option<RevolutionAxis>,
    follows_surface: bool,
    /// The sensor lies on the axis and does not follow the surface.
    slides_on_axis: bool,
    /// The surface's own normal where the sensor was taken hold of.
    grabbed: Unit<Vector3<f64>>,
}

/// A point of the surface with a direction in it.
#[derive(Clone, Copy, Debug)]
struct SurfaceFrame {
    origin_mm: Point3<f64>,
    normal: Unit<Vector3<f64>>,
    /// `body_from_surface`: x along the long axis' projection, z along the normal.
    rotation: UnitQuaternion<f64>,
}

impl SurfaceDrag {
    /// Takes hold of a sensor at the surface point under the pointer.
    pub fn new(body_from_sensor: Pose, grabbed: &SurfacePoint, guide: &DragGuide) -> Self {
        let longest = Unit::try_new(guide.long_axis, 1e-12).unwrap_or_else(Vector3::z_axis);
        let long_axis = guide.axis.map_or(longest, |axis| axis.direction);
        let place = Point3::from(body_from_sensor.translation.vector);
        let is_on = |axis: RevolutionAxis| axis.arm_mm(&place).norm() <= ON_AXIS_MM;
        let start = SurfaceFrame {
            origin_mm: grabbed.position_mm,
            normal: grabbed.normal,
            rotation: projected_frame(&grabbed.normal, &long_axis),
        };
        let mut drag = Self {
            start_body_from_sensor: body_from_sensor,
            start,
            latest: start,
            long_axis,
            axis: guide.axis,
            follows_surface: guide.follows_surface,
            slides_on_axis: !guide.follows_surface && guide.axis.is_some_and(is_on),
            grabbed: grabbed.normal,
        };
        drag.start = drag.frame(grabbed);
        drag.latest = drag.start;
        drag
    }

    /// The sensor's pose where the drag began.
    pub fn start_body_from_sensor(&self) -> &Pose {
        &self.start_body_from_sensor
    }

    /// The sensor's pose with the surface point under the pointer at `hit`.
    ///
    /// Its place relative to the grabbed point stays: the signed depth below the surface and the
    /// offset along it. One on the axis of a body of revolution slides along that. Its rotation stays
    /// in the body, or where it follows the surface, in the surface's frame. With a grid its place is
    /// rounded: along the body's long axis, and on a flat face across it too.
    pub fn pose_at(&mut self, hit: &SurfacePoint, snap: Option<Grid>) -> Pose {
        if let Some(axis) = self.axis.filter(|_| self.slides_on_axis) {
            return self.along(&axis, hit, snap);
        }
        let is_at_start = (hit.position_mm, hit.normal) == (self.start.origin_mm, self.grabbed);
        if is_at_start {
            // To the bit, and not by way of products that are one within rounding.
            self.latest = self.start;
            if snap.is_none() {
                return self.start_body_from_sensor;
            }
        }
        self.latest = self.frame(hit);
        let turn = self.latest.rotation * self.start.rotation.inverse();
        let start = &self.start_body_from_sensor;
        let offset = turn * (start.translation.vector - self.start.origin_mm.coords);
        let mut position = hit.position_mm.coords + offset;
        if let Some(grid) = snap {
            position += self.snap_shift(&position, grid);
        }
        let rotation = match self.follows_surface {
            true => UnitQuaternion::new_normalize((turn * start.rotation).into_inner()),
            false => start.rotation,
        };
        Pose::from_parts(Translation3::from(position), rotation)
    }

    /// The pose of a sensor that slides along an axis as far as the pointer does.
    fn along(&self, axis: &RevolutionAxis, hit: &SurfacePoint, snap: Option<Grid>) -> Pose {
        let direction = axis.direction.into_inner();
        let start = &self.start_body_from_sensor;
        let way_mm = (hit.position_mm - self.start.origin_mm).dot(&direction);
        let mut position = start.translation.vector + direction * way_mm;
        if let Some(grid) = snap {
            let now = position.dot(&self.long_axis);
            let wanted = (now / grid.step_mm).round() * grid.step_mm;
            position += direction * ((wanted - now) / direction.dot(&self.long_axis));
        }
        Pose::from_parts(Translation3::from(position), start.rotation)
    }

    /// The surface's frame at a point: of a body of revolution radial, however its normals lean,
    /// unless the sensor turns with them.
    fn frame(&self, at: &SurfacePoint) -> SurfaceFrame {
        let is_round = |axis: &RevolutionAxis| {
            !self.follows_surface
                && !is_cap(&at.normal, &self.long_axis)
                && axis.is_met_by(&at.position_mm, &at.normal)
        };
        let arm = self.axis.filter(is_round).map(|axis| axis.arm_mm(&at.position_mm));
        let radial = arm.and_then(|arm| Unit::try_new(arm, 1e-9));
        // The inside of a bore faces the axis.
        let normal = radial.map_or(at.normal, |radial| match radial.dot(&at.normal) < 0.0 {
            true => -radial,
            false => radial,
        });
        SurfaceFrame { origin_mm: at.position_mm, normal, rotation: self.frame_rotation(&normal) }
    }

    fn frame_rotation(&self, normal: &Unit<Vector3<f64>>) -> UnitQuaternion<f64> {
        if is_cap(normal, &self.long_axis) {
            let carry = axis_rotation(&self.latest.normal, normal).vector_rad;
            exp_vector(&carry) * self.latest.rotation
        } else {
            projected_frame(normal, &self.long_axis)
        }
    }

    /// In the surface to the next line of the grid. On an end cap, where the long axis leaves the
    /// surface, the lines are those of the body's two other axes.
    fn snap_shift(&self, position: &Vector3<f64>, grid: Grid) -> Vector3<f64> {
        let normal = &self.latest.normal;
        let shift = |coordinate: &Vector3<f64>, tangent: &Vector3<f64>| {
            let now = position.dot(coordinate);
            let wanted = (now / grid.step_mm).round() * grid.step_mm;
            tangent * ((wanted - now) / tangent.dot(coordinate))
        };
        if is_cap(normal, &self.long_axis) {
            if !grid.is_flat {
                return Vector3::zeros();
            }
            let [u, v] = tangents(&self.long_axis);
            let in_surface = |axis: &Vector3<f64>| axis - normal.into_inner() * normal.dot(axis);
            return shift(&u, &in_surface(&u)) + shift(&v, &in_surface(&v));
        }
        let along = self.latest.rotation * Vector3::x();
        let across = self.latest.rotation * Vector3::y();
        let mut total = shift(&self.long_axis, &along);
        if grid.is_flat {
            total += shift(&across, &across);
        }
        total
    }
}

fn is_cap(normal: &Unit<Vector3<f64>>, long_axis: &Unit<Vector3<f64>>) -> bool {
    normal.dot(long_axis).abs() > CAP_ANGLE_RAD.cos()
}

/// x along the projection of the long axis on the tangent plane, z along the normal.
fn projected_frame(
    normal: &Unit<Vector3<f64>>,
    long_axis: &Unit<Vector3<f64>>,
) -> UnitQuaternion<f64> {
    let along = long_axis.into_inner() - normal.into_inner() * normal.dot(long_axis);
    let x = Unit::try_new(along, 1e-9).unwrap_or_else(|| perpendicular(normal));
    let y = normal.cross(&x);
    let columns = Matrix3::from_columns(&[x.into_inner(), y, normal.into_inner()]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns))
}

/// Directions of a body's surface at the point of it that is nearest to a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceDirections {
    /// Outward.
    pub normal: Unit<Vector3<f64>>,
    /// Along the shaft: the axis of a body of revolution, elsewhere in the surface; on an end cap, where
    /// the long axis leaves the surface, the long axis itself.
    pub along: Unit<Vector3<f64>>,
}

impl SurfaceDirections {
    /// At the surface point nearest to `place_mm`, which may lie inside, as a coil in a shaft
    /// does. All in the body frame.
    pub fn near(surface: &Surface, place_mm: &Point3<f64>, long_axis: Vector3<f64>) -> Self {
        let axis = surface.revolution_axis(&long_axis);
        let long_axis = Unit::try_new(long_axis, 1e-12).unwrap_or_else(Vector3::z_axis);
        let nearest = surface.closest(place_mm);
        let normal = nearest.normal;
        // Only where the surface is a part of the revolution: a grip to one side has its own way.
        let axis = axis.filter(|axis| axis.is_met_by(&nearest.position_mm, &normal));
        let along = match axis {
            Some(axis) => axis.direction,
            None if is_cap(&normal, &long_axis) => long_axis,
            None => projected_frame(&normal, &long_axis) * Vector3::x_axis(),
        };
        Self { normal, along }
    }
}

/// Dragging freely in the plane that faces the viewer: a body without a mesh, or a sensor that
/// is taken off the surface.
#[derive(Clone, Debug)]
pub struct PlaneDrag {
    start_body_from_sensor: Pose,
    plane_point_mm: Point3<f64>,
    plane_normal: Unit<Vector3<f64>>,
    grabbed_mm: Point3<f64>,
}

impl PlaneDrag {
    /// Takes hold of a sensor with a ray (body frame) that passes near it; the plane goes
    /// through the sensor and faces along `view_direction`.
    pub fn new(
        body_from_sensor: Pose,
        ray_in_body: &Ray,
        view_direction_in_body: Unit<Vector3<f64>>,
    ) -> Self {
        let point = Point3::from(body_from_sensor.translation.vector);
        let grabbed = ray_in_body.meets_plane(&point, &view_direction_in_body);
        Self {
            start_body_from_sensor: body_from_sensor,
            plane_point_mm: point,
            plane_normal: view_direction_in_body,
            grabbed_mm: grabbed.unwrap_or(point),
        }
    }

    /// The sensor's pose with the pointer on `ray_in_body`; `None` where that misses the plane.
    /// With `snap_mm` the position is rounded to that step along the body's axes.
    pub fn pose_at(&self, ray_in_body: &Ray, snap_mm: Option<f64>) -> Option<Pose> {
        let now = ray_in_body.meets_plane(&self.plane_point_mm, &self.plane_normal)?;
        let start = &self.start_body_from_sensor;
        let mut position = start.translation.vector + (now - self.grabbed_mm);
        if let Some(step_mm) = snap_mm {
            position = position.map(|x| (x / step_mm).round() * step_mm);
        }
        Some(Pose::from_parts(Translation3::from(position), start.rotation))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::pose_from_parts;
    use crate::solid::Solid;
    use crate::surface::tests::cylinder;

    fn ray_along_x(y: f64, z: f64) -> Ray {
        Ray { origin_mm: Point3::new(200.0, y, z), direction: -Vector3::x_axis() }
    }

    fn hit_at(surface: &Surface, y: f64, z: f64) -> SurfacePoint {
        surface.cast(&ray_along_x(y, z)).unwrap()
    }

    /// The sensor's axis stays, as drags are where nothing else is chosen.
    fn guide(surface: &Surface) -> DragGuide {
        DragGuide {
            long_axis: Vector3::z(),
            axis: surface.revolution_axis(&Vector3::z()),
            follows_surface: false,
        }
    }

    /// The sensor's axis turns with the surface.
    fn following(surface: &Surface) -> DragGuide {
        DragGuide { follows_surface: true, ..guide(surface) }
    }

    fn no_axis() -> DragGuide {
        DragGuide { long_axis: Vector3::z(), axis: None, follows_surface: false }
    }

    /// A handle with a waist and a grip: from 2 mm to 6 mm and back, its normals lean.
    fn handle() -> Surface {
        let mut mesh = cylinder(1.0, 100.0, 48);
        let mut solid = Solid::turned(&[
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 30.0],
            [6.0, 50.0],
            [4.0, 70.0],
            [6.0, 100.0],
            [0.0, 100.0],
        ]);
        let part = &mut mesh.parts[0];
        part.positions_mm = std::mem::take(&mut solid.positions_mm);
        part.normals = std::mem::take(&mut solid.normals);
        part.triangles = std::mem::take(&mut solid.triangles);
        Surface::new(&mesh).unwrap()
    }

    fn shaft() -> Surface {
        Surface::new(&cylinder(2.0, 150.0, 96)).unwrap()
    }

    #[test]
    fn a_coil_in_a_shaft_slides_along_it_at_its_depth() {
        let surface = shaft();
        let start = pose_from_parts(
            Vector3::new(0.0, 0.0, 60.0),
            UnitQuaternion::from_scaled_axis(Vector3::new(0.1, 0.2, 0.0)),
        );
        let grabbed = hit_at(&surface, 0.0, 62.0);
        let mut drag = SurfaceDrag::new(start, &grabbed, &guide(&surface));
        let pose = drag.pose_at(&hit_at(&surface, 0.0, 92.0), None);
        assert!((pose.translation.vector - Vector3::new(0.0, 0.0, 90.0)).norm() < 1e-9);
        assert!(pose.rotation.angle_to(&start.rotation) < 1e-9);
    }

    #[test]
    fn around_a_shaft_a_following_sensor_turns() {
        let surface = shaft();
        let start = Pose::translation(2.5, 0.0, 60.0);
        let grabbed = hit_at(&surface, 0.0, 60.0);
        let mut drag = SurfaceDrag::new(start, &grabbed, &following(&surface));
        let from_above =
            Ray { origin_mm: Point3::new(0.0, 100.0, 60.0), direction: -Vector3::y_axis() };
        let pose = drag.pose_at(&surface.cast(&from_above).unwrap(), None);
        // Half a millimetre above the surface it was, and half a millimetre it stays; the
        // corners of 96 sides lie 0.001 mm above their middles.
        assert!((pose.translation.vector - Vector3::new(0.0, 2.5, 60.0)).norm() < 0.003);
        let quarter =
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
        assert!(pose.rotation.angle_to(&quarter) < 1e-6);
    }

    #[test]
    fn back_at_the_start_the_pose_is_exact() {
        let surface = shaft();
        let rotation = UnitQuaternion::from_euler_angles(0.3, 1.1, -2.0);
        let start = pose_from_parts(Vector3::new(0.3, 0.1, 60.123), rotation);
        let grabbed = hit_at(&surface, 0.4, 61.0);
        for guide in [guide(&surface), following(&surface), no_axis()] {
            let mut drag = SurfaceDrag::new(start, &grabbed, &guide);
            for z in [70.0, 120.0, 3.0] {
                let _ = drag.pose_at(&hit_at(&surface, -1.0, z), None);
            }
            let back = drag.pose_at(&hit_at(&surface, 0.4, 61.0), None);
            assert_eq!(back, start);
        }
    }

    #[test]
    fn the_way_taken_along_a_shaft_does_not_matter() {
        let surface = shaft();
        let start = Pose::translation(0.0, 0.0, 60.0);
        let grabbed = hit_at(&surface, 0.0, 60.0);
        let end = hit_at(&surface, 0.9, 100.0);
        for guide in [guide(&surface), following(&surface), no_axis()] {
            let mut straight = SurfaceDrag::new(start, &grabbed, &guide);
            let mut wandering = straight.clone();
            for i in 0..200 {
                let y = (f64::from(i) * 0.37).sin() * 1.8;
                let _ = wandering.pose_at(&hit_at(&surface, y, 20.0 + f64::from(i) * 0.5), None);
            }
            assert_eq!(straight.pose_at(&end, None), wandering.pose_at(&end, None));
        }
    }

    #[test]
    fn over_a_cap_the_turn_is_the_smallest() {
        let start = Pose::translation(0.0, 0.0, 149.0);
        let side =
            SurfacePoint { position_mm: Point3::new(2.0, 0.0, 149.0), normal: Vector3::x_axis() };
        let follow = DragGuide { follows_surface: true, ..no_axis() };
        let mut drag = SurfaceDrag::new(start, &side, &follow);
        let cap =
            SurfacePoint { position_mm: Point3::new(0.5, 0.0, 150.0), normal: Vector3::z_axis() };
        let pose = drag.pose_at(&cap, None);
        // x to z is a quarter turn about -y.
        let expected =
            UnitQuaternion::from_axis_angle(&-Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
        assert!(pose.rotation.angle_to(&expected) < 1e-9);
        assert!((pose.translation.vector - Vector3::new(0.5, 0.0, 148.0)).norm() < 1e-9);
        let kept = SurfaceDrag::new(start, &side, &no_axis()).pose_at(&cap, None);
        assert_eq!(kept.rotation, start.rotation);
        assert!((kept.translation.vector - pose.translation.vector).norm() < 1e-9);
    }

    #[test]
    fn the_axis_of_a_dragged_sensor_stays() {
        let surface = handle();
        let rotation = UnitQuaternion::from_euler_angles(0.3, 1.1, -2.0);
        // On the axis, beside it in the body, on the surface; with and without a known axis.
        for x in [0.0, 1.0, 2.0] {
            for guide in [guide(&surface), no_axis()] {
                let start = pose_from_parts(Vector3::new(x, 0.0, 20.0), rotation);
                let grabbed = hit_at(&surface, 0.3, 20.0);
                let mut drag = SurfaceDrag::new(start, &grabbed, &guide);
                for (y, z) in [(0.0, 25.0), (1.5, 45.0), (-2.0, 60.0), (0.0, 90.0)] {
                    let pose = drag.pose_at(&hit_at(&surface, y, z), None);
                    assert_eq!(pose.rotation, rotation, "{x} {y} {z}");
                }
            }
        }
    }

    #[test]
    fn a_sensor_on_the_axis_slides_along_it() {
        let surface = handle();
        let start = Pose::translation(0.0, 0.0, 20.0);
        let grabbed = hit_at(&surface, 0.3, 22.0);
        let mut drag = SurfaceDrag::new(start, &grabbed, &guide(&surface));
        for (y, z) in [(0.0, 25.0), (1.5, 45.0), (-2.0, 60.0), (0.0, 90.0)] {
            let place = drag.pose_at(&hit_at(&surface, y, z), None).translation.vector;
            assert!((place - Vector3::new(0.0, 0.0, z - 2.0)).norm() < 1e-9, "{place}");
        }
        // The mode frees it.
        let mut drag = SurfaceDrag::new(start, &grabbed, &following(&surface));
        let hit = hit_at(&surface, 0.0, 45.0);
        assert!(drag.pose_at(&hit, None).translation.vector.xy().norm() > 1.0);
    }

    #[test]
    fn a_sensor_in_the_wall_keeps_its_depth() {
        let surface = handle();
        // Half a millimetre under a surface of 2 mm.
        let start = Pose::translation(1.5, 0.0, 20.0);
        let grabbed = hit_at(&surface, 0.0, 20.0);
        let mut drag = SurfaceDrag::new(start, &grabbed, &guide(&surface));
        for (y, z, radius) in [(0.0, 28.0, 2.0), (1.0, 25.0, 2.0), (1.0, 40.0, 4.0)] {
            let place = drag.pose_at(&hit_at(&surface, y, z), None).translation.vector;
            // A chord of 28 sides is 2 (1 - cos(pi / 28)) = 0.013 mm inside a circle of 2 mm.
            let depth = radius - place.xy().norm();
            assert!((depth - 0.5).abs() < 0.03, "{depth} at {z}");
            assert!((place.z - z).abs() < 1e-9);
        }
    }

    #[test]
    fn the_shafts_direction_is_that_of_its_axis() {
        // On a cone the surface leans against the axis by 11 degrees.
        let surface = handle();
        for z in [10.0, 40.0, 60.0, 90.0] {
            let place = Point3::new(3.0, 1.0, z);
            let at = SurfaceDirections::near(&surface, &place, Vector3::z());
            assert_eq!(at.along, Vector3::z_axis(), "{z}");
        }
    }

    #[test]
    fn snapping_rounds_the_place_along_the_body() {
        let surface = shaft();
        let start = Pose::translation(0.0, 0.0, 60.4);
        let grabbed = hit_at(&surface, 0.0, 60.0);
        let mut drag = SurfaceDrag::new(start, &grabbed, &guide(&surface));
        let hit = hit_at(&surface, 0.3, 71.3);
        let free = drag.pose_at(&hit, None).translation.vector;
        let grid = Grid::at(&surface, &hit, 1.0);
        assert!(!grid.is_flat);
        let snapped = drag.pose_at(&hit, Some(grid)).translation.vector;
        assert!((snapped.z - 72.0).abs() < 1e-12);
        assert!((snapped - free).xy().norm() < 1e-12, "around it as it was");
    }

    #[test]
    fn on_flat_faces_snapping_rounds_both_ways() {
        // The end of a thick shaft.
        let surface = Surface::new(&cylinder(30.0, 150.0, 96)).unwrap();
        let above =
            Ray { origin_mm: Point3::new(7.3, -11.6, 300.0), direction: -Vector3::z_axis() };
        let hit = surface.cast(&above).unwrap();
        let grid = Grid::at(&surface, &hit, 1.0);
        assert!(grid.is_flat);
        let start = Pose::translation(7.1, -11.2, 150.0);
        let grabbed = SurfacePoint { position_mm: Point3::new(7.1, -11.2, 150.0), ..hit };
        let mut drag = SurfaceDrag::new(start, &grabbed, &guide(&surface));
        let snapped = drag.pose_at(&hit, Some(grid)).translation.vector;
        assert!((snapped - Vector3::new(7.0, -12.0, 150.0)).norm() < 1e-12, "{snapped}");
    }

    #[test]
    fn directions_inside_a_shaft_lead_out_and_along() {
        let surface = shaft();
        let place = Point3::new(0.0, 1.5, 60.0);
        let at = SurfaceDirections::near(&surface, &place, Vector3::z());
        assert!(at.normal.dot(&Vector3::y()) > 0.999, "{:?}", at.normal);
        assert!(at.along.dot(&Vector3::z()) > 0.999_999, "{:?}", at.along);
        let cap = Point3::new(0.0, 0.0, 151.0);
        let at = SurfaceDirections::near(&surface, &cap, Vector3::z());
        assert!(at.normal.dot(&Vector3::z()) > 0.999, "{:?}", at.normal);
        assert_eq!(at.along, Vector3::z_axis());
    }

    #[test]
    fn without_a_mesh_a_sensor_stays_in_the_view_plane() {
        let start = Pose::translation(5.0, 0.0, 60.0);
        let drag = PlaneDrag::new(start, &ray_along_x(1.0, 60.0), -Vector3::x_axis());
        let pose = drag.pose_at(&ray_along_x(4.0, 71.2), None).unwrap();
        assert!((pose.translation.vector - Vector3::new(5.0, 3.0, 71.2)).norm() < 1e-12);
        assert_eq!(drag.pose_at(&ray_along_x(1.0, 60.0), None).unwrap(), start);
        let snapped = drag.pose_at(&ray_along_x(4.0, 71.2), Some(1.0)).unwrap();
        assert_eq!(snapped.translation.vector, Vector3::new(5.0, 3.0, 71.0));
    }
}
