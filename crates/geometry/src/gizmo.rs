//! Handles that move a thing: arrows along its axes and rings around them, of one size on the
//! screen. Where they are, which is under the pointer, and how far a drag has brought it.

use super::movement::Movement;
use super::orbit::{Axis, OrbitCamera, Projection};
use super::pose::Pose;
use super::surface::Ray;
use nalgebra::{Point3, Unit, Vector2, Vector3};
use std::f64::consts::{FRAC_PI_4, TAU};

/// Radius of the rings. What is moved stays free inside them.
pub const RING_PX: f64 = 66.0;

/// Where an arrow begins and ends: outside the rings, so that no handle crosses another.
pub const ARROW_PX: [f64; 2] = [78.0, 116.0];

/// How far beyond the tip of its arrow, on the screen, the letter of an axis stands.
const LETTER_BEYOND_PX: f64 = 13.0;

/// How near to a handle the pointer takes hold of it.
const REACH_PX: f64 = 7.0;

/// An arrow that points at the viewer more directly than this is a dot that cannot be pulled.
const LEAST_ARROW_SINE: f64 = 0.2;

/// A ring whose plane is seen at a smaller slant than this is pulled along its tangent: where a
/// ray meets the plane would jump about.
const EDGE_ON: f64 = 0.2;

/// Corners of the line that a ring is picked as.
const RING_CORNERS: u32 = 72;

/// The 3D view: from where it is seen, and its size in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    pub camera: OrbitCamera,
    pub view_px: [f64; 2],
}

impl Eye {
    /// Millimetres a pixel spans at a point; of the focus for what is behind the camera.
    pub fn mm_per_px(&self, point_mm: &Point3<f64>) -> f64 {
        self.camera
            .mm_per_px(point_mm, self.view_px)
            .unwrap_or_else(|| self.camera.view_height_mm() / self.view_px[1])
    }

    /// Millimetres a pixel spans so far along a ray of the view.
    pub fn mm_per_px_along(&self, along_mm: f64) -> f64 {
        let at_focus = self.camera.view_height_mm() / self.view_px[1].max(1.0);
        match self.camera.projection {
            Projection::Perspective => at_focus * along_mm / self.camera.distance_mm,
            Projection::Orthographic => at_focus,
        }
    }
}

/// What a handle does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HandleKind {
    /// Moves along its axis.
    Arrow,
    /// Turns about its axis.
    Ring,
}

/// One handle of a gizmo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Handle {
    pub kind: HandleKind,
    pub axis: Axis,
}

/// Handles around a pivot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gizmo {
    /// Its origin is the pivot.
    pub tracker_from_gizmo: Pose,
    pub handles: &'static [Handle],
}

impl Handle {
    /// The arrow along an axis.
    pub const fn arrow(axis: Axis) -> Self {
        let kind = HandleKind::Arrow;
        Self { kind, axis }
    }

    /// The ring around an axis.
    pub const fn ring(axis: Axis) -> Self {
        let kind = HandleKind::Ring;
        Self { kind, axis }
    }

    /// To move and to turn.
    pub const ALL: &'static [Self] = &[
        Self::arrow(Axis::X),
        Self::arrow(Axis::Y),
        Self::arrow(Axis::Z),
        Self::ring(Axis::X),
        Self::ring(Axis::Y),
        Self::ring(Axis::Z),
    ];

    /// To turn only.
    pub const RINGS: &'static [Self] =
        &[Self::ring(Axis::X), Self::ring(Axis::Y), Self::ring(Axis::Z)];

    /// To turn what has an axis, its z, and no roll about it.
    pub const RINGS_OF_AXIS: &'static [Self] = &[Self::ring(Axis::X), Self::ring(Axis::Y)];
}

impl Gizmo {
    /// Origin of the gizmo, tracker frame.
    pub fn pivot_mm(&self) -> Point3<f64> {
        Point3::from(self.tracker_from_gizmo.translation.vector)
    }

    /// An axis of the gizmo in the tracker frame.
    pub fn axis(&self, axis: Axis) -> Unit<Vector3<f64>> {
        self.tracker_from_gizmo.rotation * axis.unit()
    }

    /// Whether a handle can be used as it is seen.
    pub fn is_usable(&self, handle: Handle, eye: &Eye) -> bool {
        match handle.kind {
            HandleKind::Ring => true,
            HandleKind::Arrow => {
                let sight = eye.camera.sight(&self.pivot_mm());
                let sine = sight.cross(&self.axis(handle.axis)).norm() / sight.norm();
                sine > LEAST_ARROW_SINE
            }
        }
    }

    /// The handle under a pixel and how far it is from it.
    pub fn under(&self, pixel: [f64; 2], eye: &Eye) -> Option<(Handle, f64)> {
        let handles = self.handles.iter();
        handles
            .filter_map(|handle| Some((*handle, self.distance_px(*handle, pixel, eye)?)))
            .filter(|(_, distance)| *distance <= REACH_PX)
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Distance on the screen from a pixel to a handle; `None` where that cannot be used, or is
    /// behind the camera.
    pub fn distance_px(&self, handle: Handle, pixel: [f64; 2], eye: &Eye) -> Option<f64> {
        if !self.is_usable(handle, eye) {
            return None;
        }
        let to_segment = |ends| eye.camera.distance_px(pixel, ends, eye.view_px);
        match handle.kind {
            HandleKind::Arrow => {
                let [from, to] = ARROW_PX;
                to_segment([
                    self.on_axis(handle.axis, from, eye)?,
                    self.on_axis(handle.axis, to, eye)?,
                ])
            }
            HandleKind::Ring => {
                let radius_mm = RING_PX * self.mm_per_px(eye)?;
                let corner = |k| self.on_ring(handle.axis, corner_rad(k), radius_mm);
                (0..RING_CORNERS)
                    .filter_map(|k| to_segment([corner(k), corner(k + 1)]))
                    .min_by(f64::total_cmp)
            }
        }
    }

    /// Pixels of an arrow's tip and of the letter of its axis beyond it; `None` where there is no
    /// arrow to be used.
    pub fn arrow_end_px(&self, axis: Axis, eye: &Eye) -> Option<[[f64; 2]; 2]> {
        let arrow = Handle::arrow(axis);
        if !self.handles.contains(&arrow) || !self.is_usable(arrow, eye) {
            return None;
        }
        let project = |point| eye.camera.project(&point, eye.view_px).map(Vector2::from);
        let pivot = project(self.pivot_mm())?;
        let tip = project(self.on_axis(axis, ARROW_PX[1], eye)?)?;
        let beyond = tip + (tip - pivot).normalize() * LETTER_BEYOND_PX;
        Some([tip.into(), beyond.into()])
    }

    /// A pixel at which the pointer takes hold of a handle, as far from the others as there is
    /// one; `None` where it is out of reach.
    pub fn grip_px(&self, handle: Handle, eye: &Eye) -> Option<[f64; 2]> {
        let mm_per_px = self.mm_per_px(eye)?;
        let points: Vec<Point3<f64>> = match handle.kind {
            HandleKind::Arrow => {
                let [from, to] = ARROW_PX;
                vec![self.on_axis(handle.axis, (from + to) / 2.0, eye)?]
            }
            // Halfway between the crossings with the other rings.
            HandleKind::Ring => [1.0, 3.0, 5.0, 7.0]
                .map(|k| self.on_ring(handle.axis, k * FRAC_PI_4, RING_PX * mm_per_px))
                .to_vec(),
        };
        let pixels = points.iter().filter_map(|point| eye.camera.project(point, eye.view_px));
        let room = |pixel: &[f64; 2]| {
            let others = self.handles.iter().filter(|other| **other != handle);
            others
                .filter_map(|other| self.distance_px(*other, *pixel, eye))
                .fold(f64::INFINITY, f64::min)
        };
        pixels
            .filter(|pixel| (self.under(*pixel, eye)).is_some_and(|found| found.0 == handle))
            .max_by(|a, b| room(a).total_cmp(&room(b)))
    }

    fn mm_per_px(&self, eye: &Eye) -> Option<f64> {
        eye.camera.mm_per_px(&self.pivot_mm(), eye.view_px)
    }

    /// A point of an axis so many pixels from the pivot, as they are at the pivot's depth.
    fn on_axis(&self, axis: Axis, distance_px: f64, eye: &Eye) -> Option<Point3<f64>> {
        let distance_mm = distance_px * self.mm_per_px(eye)?;
        Some(self.pivot_mm() + self.axis(axis).into_inner() * distance_mm)
    }

    fn on_ring(&self, axis: Axis, angle_rad: f64, radius_mm: f64) -> Point3<f64> {
        let [u, v] = axis.others().map(|other| self.axis(other).into_inner());
        self.pivot_mm() + (u * angle_rad.cos() + v * angle_rad.sin()) * radius_mm
    }
}

fn corner_rad(number: u32) -> f64 {
    TAU * f64::from(number) / f64::from(RING_CORNERS)
}

/// A handle that is held. What it did comes from where it was taken hold of: nothing is added up
/// but whole turns.
#[derive(Clone, Debug, PartialEq)]
pub struct HandleDrag {
    pivot_mm: Point3<f64>,
    axis: Unit<Vector3<f64>>,
    grip: Grip,
}

#[derive(Clone, Debug, PartialEq)]
enum Grip {
    /// Where along the axis.
    Line { grabbed_mm: f64 },
    /// In which direction from the pivot, and the turn since.
    Plane { grabbed: Vector3<f64>, latest_rad: f64 },
    /// A ring seen on its edge.
    Tangent { point_mm: Point3<f64>, tangent: Unit<Vector3<f64>>, radius_mm: f64, grabbed_mm: f64 },
}

impl HandleDrag {
    /// Takes hold of a handle with a ray of the tracker frame that passes near it.
    pub fn new(gizmo: &Gizmo, handle: Handle, ray: &Ray, eye: &Eye) -> Option<Self> {
        let (pivot_mm, axis) = (gizmo.pivot_mm(), gizmo.axis(handle.axis));
        let grip = match handle.kind {
            HandleKind::Arrow => Grip::Line { grabbed_mm: along(ray, &pivot_mm, &axis)? },
            HandleKind::Ring if ray.direction.dot(&axis).abs() > EDGE_ON => Grip::Plane {
                grabbed: ray.meets_plane(&pivot_mm, &axis)? - pivot_mm,
                latest_rad: 0.0,
            },
            HandleKind::Ring => {
                let radius_mm = RING_PX * gizmo.mm_per_px(eye)?;
                let off =
                    |point: &Point3<f64>| (point - ray.origin_mm).cross(&ray.direction).norm();
                // Of the two sides that lie over each other, the one that is seen.
                let point_mm = (0..RING_CORNERS)
                    .map(|k| gizmo.on_ring(handle.axis, corner_rad(k), radius_mm))
                    .filter(|point| (point - pivot_mm).dot(&ray.direction) <= 0.0)
                    .min_by(|a, b| off(a).total_cmp(&off(b)))?;
                let tangent = Unit::new_normalize(axis.cross(&(point_mm - pivot_mm)));
                Grip::Tangent {
                    point_mm,
                    tangent,
                    radius_mm,
                    grabbed_mm: along(ray, &point_mm, &tangent)?,
                }
            }
        };
        Some(Self { pivot_mm, axis, grip })
    }

    /// What the handle did since, with the pointer on `ray`; `None` where that determines nothing.
    pub fn movement_at(&mut self, ray: &Ray) -> Option<Movement> {
        let (pivot_mm, axis) = (self.pivot_mm, self.axis);
        let turn = |by_rad| Movement::Turn { axis, pivot_mm, by_rad };
        Some(match &mut self.grip {
            Grip::Line { grabbed_mm } => Movement::Slide {
                direction: axis,
                by_mm: along(ray, &pivot_mm, &axis)? - *grabbed_mm,
            },
            Grip::Plane { grabbed, latest_rad } => {
                let now = ray.meets_plane(&pivot_mm, &axis)? - pivot_mm;
                let angle_rad = axis.dot(&grabbed.cross(&now)).atan2(grabbed.dot(&now));
                // More than half a turn goes on and does not jump back.
                let turns = ((*latest_rad - angle_rad) / TAU).round();
                *latest_rad = angle_rad + turns * TAU;
                turn(*latest_rad)
            }
            Grip::Tangent { point_mm, tangent, radius_mm, grabbed_mm } => {
                turn((along(ray, point_mm, tangent)? - *grabbed_mm) / *radius_mm)
            }
        })
    }
}

/// Where a line passes nearest to a ray; `None` where that is behind the viewer, as it is beyond
/// the line's vanishing point.
fn along(ray: &Ray, point_mm: &Point3<f64>, direction: &Unit<Vector3<f64>>) -> Option<f64> {
    let distance_mm = ray.nearest_on_line(point_mm, direction)?;
    let nearest = point_mm + direction.into_inner() * distance_mm;
    ((nearest - ray.origin_mm).dot(&ray.direction) > 0.0).then_some(distance_mm)
}

#[cfg(test)]
mod tests;
