//! A metal body and where it is: what is in it, cut by it or near it.

use crate::body::{MetalBody, MetalShape};
use crate::panel::Panel;
use nalgebra::Point3;
use std::sync::Arc;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::Pose;

/// A body and where it is.
#[derive(Clone, Debug)]
pub struct PlacedBody {
    pub body: Arc<MetalBody>,
    pub tracker_from_body: Pose,
}

impl PlacedBody {
    /// Whether a point of the tracker frame is in the metal.
    pub fn contains(&self, p: &Point3<f64>) -> bool {
        self.contains_in_body(&self.tracker_from_body.inverse_transform_point(p))
    }

    /// Whether a segment of the tracker frame is in the metal or goes through it.
    pub(super) fn meets_segment(&self, from: &Point3<f64>, to: &Point3<f64>) -> bool {
        let [from, to] = [from, to].map(|p| self.tracker_from_body.inverse_transform_point(p));
        match self.body.shape() {
            MetalShape::Sphere { radius_mm } => {
                let side = to - from;
                let along = -from.coords.dot(&side) / side.norm_squared().max(f64::MIN_POSITIVE);
                (from.coords + side * along.clamp(0.0, 1.0)).norm() <= *radius_mm
            }
            MetalShape::Surface(shape) => {
                let surface = shape.surface();
                let around = Bounds { min_mm: from.inf(&to), max_mm: from.sup(&to) };
                let is_near = (0..3).all(|k| {
                    let bounds = surface.bounds();
                    around.min_mm[k] <= bounds.max_mm[k] && bounds.min_mm[k] <= around.max_mm[k]
                });
                is_near
                    && (surface.contains(&from)
                        || surface.panels().iter().any(|panel| panel.is_cut_by(&from, &to)))
            }
        }
    }

    /// Triangles that span the holes that go through the body.
    fn spans(&self) -> impl Iterator<Item = &Panel> {
        let spans = match self.body.shape() {
            MetalShape::Sphere { .. } => &[],
            MetalShape::Surface(shape) => shape.spans(),
        };
        spans.iter().flatten().map(|(_, panel)| panel)
    }

    /// Whether a segment of the tracker frame goes through a hole.
    pub(super) fn is_spanned(&self, from: &Point3<f64>, to: &Point3<f64>) -> bool {
        let [from, to] = [from, to].map(|p| self.tracker_from_body.inverse_transform_point(p));
        self.spans().any(|panel| panel.is_cut_by(&from, &to))
    }

    /// Whether another body reaches into a hole of this one.
    pub(super) fn holds(&self, other: &Self) -> bool {
        if self.spans().next().is_none() {
            return false;
        }
        match other.body.shape() {
            MetalShape::Sphere { radius_mm } => {
                let middle = other.tracker_from_body.translation.vector.into();
                let in_body = self.tracker_from_body.inverse_transform_point(&middle);
                self.spans().any(|panel| panel.distance_mm(&in_body) < *radius_mm)
            }
            MetalShape::Surface(shape) => {
                let sides = shape.surface().panels().iter().flat_map(|panel| {
                    let [a, b, c] = panel.corners_mm().map(|p| other.tracker_from_body * p);
                    [(a, b), (b, c), (c, a)]
                });
                sides.into_iter().any(|(from, to)| self.is_spanned(&from, &to))
            }
        }
    }

    pub(super) fn contains_in_body(&self, p: &Point3<f64>) -> bool {
        match self.body.shape() {
            MetalShape::Sphere { radius_mm } => p.coords.norm() <= *radius_mm,
            MetalShape::Surface(shape) => shape.surface().contains(p),
        }
    }

    /// Distance of a point of the tracker frame from the surface.
    pub(super) fn distance_mm(&self, p: &Point3<f64>) -> f64 {
        let in_body = self.tracker_from_body.inverse_transform_point(p);
        match self.body.shape() {
            MetalShape::Sphere { radius_mm } => (in_body.coords.norm() - radius_mm).abs(),
            MetalShape::Surface(shape) => shape.surface().nearest(&in_body).0,
        }
    }

    /// Whether a part of this body's surface is in another one, or their spheres overlap.
    pub(super) fn cuts(&self, other: &Self) -> bool {
        match (self.body.shape(), other.body.shape()) {
            (MetalShape::Sphere { radius_mm: one }, MetalShape::Sphere { radius_mm: two }) => {
                let between = self.tracker_from_body.translation.vector
                    - other.tracker_from_body.translation.vector;
                between.norm() <= one + two
            }
            (MetalShape::Sphere { radius_mm }, MetalShape::Surface(_)) => {
                let middle = self.tracker_from_body.translation.vector.into();
                other.contains(&middle) || other.distance_mm(&middle) <= *radius_mm
            }
            (MetalShape::Surface(shape), _) => {
                let corners = shape.surface().panels().iter().flat_map(|panel| panel.corners_mm());
                corners.into_iter().any(|corner| other.contains(&(self.tracker_from_body * corner)))
            }
        }
    }
}
