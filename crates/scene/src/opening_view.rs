//! From where a design is first seen: its own camera, or one that frames tool and CRF.

use nalgebra::Point3;
use trackwright_design::{BodyRole, Design};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::orbit::{OrbitCamera, Projection};
use trackwright_project::World;

/// What a single sensor or tip is framed with, millimetres around it.
pub const POINT_RADIUS_MM: f64 = 25.0;

/// From where a design is looked at first: the viewer sits a little above and to the side, so
/// that shafts, which lie along an axis more often than not, are not seen end on.
const FIRST_AZIMUTH_RAD: f64 = -28.0 * std::f64::consts::PI / 180.0;
const FIRST_ELEVATION_RAD: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// How much of the surroundings the first view shows around tool and CRF.
const FIRST_SURROUNDINGS: f64 = 1.12;

/// A ball in the tracker frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    pub center_mm: Point3<f64>,
    pub radius_mm: f64,
}

impl Sphere {
    /// Around points, and never too small to be framed; `None` around none.
    ///
    /// ```
    /// use nalgebra::Point3;
    /// use trackwright_scene::opening_view::Sphere;
    /// let ends = [0.0, 80.0].map(|z| Point3::new(0.0, 0.0, z));
    /// let ball = Sphere::around(ends.into_iter()).unwrap();
    /// assert_eq!((ball.center_mm.z, ball.radius_mm), (40.0, 40.0));
    /// ```
    pub fn around(points: impl Iterator<Item = Point3<f64>>) -> Option<Self> {
        let bounds = Bounds::around(points)?;
        Some(Self {
            center_mm: bounds.center_mm(),
            radius_mm: (bounds.diagonal_mm() / 2.0).max(POINT_RADIUS_MM),
        })
    }

    /// Tool and CRF with whatever their meshes show.
    pub fn of_bodies(world: &World, design: &Design) -> Option<Self> {
        let roles = BodyRole::ALL.iter();
        Self::around(roles.flat_map(|role| points_of(world, design, *role)))
    }

    /// Whether a camera sees the whole of it.
    pub fn is_seen_by(&self, camera: &OrbitCamera, view_px: [f64; 2]) -> bool {
        let projected = camera.project(&self.center_mm, view_px);
        let Some((at, mm_per_px)) = projected.zip(camera.mm_per_px(&self.center_mm, view_px))
        else {
            return false;
        };
        let radius_px = self.radius_mm / mm_per_px;
        at.iter().zip(view_px).all(|(at, size)| *at >= radius_px && *at <= size - radius_px)
    }
}

/// Mesh corners, sensors and tip of a body, tracker frame.
pub fn points_of(world: &World, design: &Design, role: BodyRole) -> Vec<Point3<f64>> {
    let (Some(body), Some(pose)) = (design.body(role), design.tracker_from_body(role)) else {
        return Vec::new();
    };
    let corners = world
        .mesh(role)
        .into_iter()
        .flat_map(|mesh| mesh.parts.iter().flat_map(|part| part.positions_mm.iter()));
    let sensors = body.rigid.sensors.iter().map(|s| &s.position_in_body);
    corners.chain(sensors).chain(body.rigid.tip_in_body.iter()).map(|p| pose * p).collect()
}

/// Where a camera is before there is anything to see.
pub fn usual_camera() -> OrbitCamera {
    OrbitCamera {
        focus_mm: Point3::new(0.0, 0.0, -300.0),
        distance_mm: 1200.0,
        azimuth_rad: FIRST_AZIMUTH_RAD,
        elevation_rad: FIRST_ELEVATION_RAD,
        projection: Projection::Perspective,
    }
}

/// One that frames tool and CRF.
pub fn first_camera(world: &World, view_px: [f64; 2]) -> OrbitCamera {
    let mut camera = usual_camera();
    if let Some(sphere) = Sphere::of_bodies(world, world.document.design()) {
        let radius_mm = sphere.radius_mm * FIRST_SURROUNDINGS;
        camera.frame_sphere(sphere.center_mm, radius_mm, view_px);
    }
    camera
}

/// The design's own, else the first.
pub fn opening_camera(world: &World, view_px: [f64; 2]) -> OrbitCamera {
    let own = world.document.view().camera;
    own.map_or_else(|| first_camera(world, view_px), Into::into)
}
