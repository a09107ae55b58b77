//! A channel's middle line as a way: places along it, and where a straight coil fits.

use nalgebra::{Point3, Unit, Vector3};
use trackwright_simulation::Coil;

/// A polyline by the way along it.
#[derive(Clone, Debug)]
pub(crate) struct Channel {
    points_mm: Vec<Point3<f64>>,
    /// Way to each point.
    along_mm: Vec<f64>,
    radius_mm: Option<f64>,
}

impl Channel {
    /// A line through at least two points, no two consecutive ones the same.
    pub fn new(points_mm: &[Point3<f64>], radius_mm: Option<f64>) -> Self {
        let mut along_mm = vec![0.0];
        let mut way_mm = 0.0;
        for pair in points_mm.windows(2) {
            way_mm += (pair[1] - pair[0]).norm();
            along_mm.push(way_mm);
        }
        Self { points_mm: points_mm.to_vec(), along_mm, radius_mm }
    }

    pub fn length_mm(&self) -> f64 {
        self.along_mm.last().copied().unwrap_or(0.0)
    }

    /// Where a coil's middle may be, along the way; `None` where the channel is too short for it.
    pub fn range_mm(&self, coil: Option<Coil>) -> Option<[f64; 2]> {
        let half_mm = coil.map_or(0.0, |coil| coil.length_mm / 2.0);
        let range = [half_mm, self.length_mm() - half_mm];
        (range[0] <= range[1]).then_some(range)
    }

    /// The place at a way, and the direction there.
    pub fn at(&self, along_mm: f64) -> (Point3<f64>, Unit<Vector3<f64>>) {
        let pieces = self.points_mm.len().saturating_sub(1).max(1);
        let piece = self.along_mm[1..pieces].iter().take_while(|end| **end < along_mm).count();
        let [start, end] = [self.points_mm[piece], self.points_mm[piece + 1]];
        let direction = Unit::new_normalize(end - start);
        (start + direction.into_inner() * (along_mm - self.along_mm[piece]), direction)
    }

    /// The way to the place that is nearest to a point.
    pub fn nearest_mm(&self, point: &Point3<f64>) -> f64 {
        let pieces = self.points_mm.windows(2).zip(&self.along_mm);
        let nearest = pieces.map(|(pair, start_mm)| {
            let line = pair[1] - pair[0];
            let length_mm = line.norm();
            let along_mm = (point - pair[0]).dot(&(line / length_mm)).clamp(0.0, length_mm);
            let at = pair[0] + line * (along_mm / length_mm);
            ((point - at).norm(), start_mm + along_mm)
        });
        nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |nearest| nearest.1)
    }

    /// Whether a coil with its middle on the line is within the radius, all along.
    pub fn holds(&self, middle: &Point3<f64>, axis: &Unit<Vector3<f64>>, coil: Coil) -> bool {
        /// Round-off of a coil that is as wide as its channel.
        const TOUCH_MM: f64 = 1e-6;
        let Some(radius_mm) = self.radius_mm else {
            return true;
        };
        let play_mm = radius_mm - coil.diameter_mm / 2.0;
        [-0.5, -0.25, 0.0, 0.25, 0.5].into_iter().all(|part| {
            let point = middle + axis.into_inner() * (part * coil.length_mm);
            let (nearest, _) = self.at(self.nearest_mm(&point));
            // Beyond an end only what is across counts: the ends are the range's affair.
            (point - nearest).norm() <= play_mm + TOUCH_MM
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bent() -> Channel {
        let points = [[0.0, 0.0, 0.0], [0.0, 0.0, 50.0], [0.0, 30.0, 90.0]].map(Point3::from);
        Channel::new(&points, Some(0.5))
    }

    #[test]
    fn places_along_a_channel_are_as_far_as_the_way() {
        let channel = bent();
        assert_eq!(channel.length_mm(), 100.0);
        assert_eq!(channel.at(20.0).0, Point3::new(0.0, 0.0, 20.0));
        let (place, direction) = channel.at(75.0);
        assert!((place - Point3::new(0.0, 15.0, 70.0)).norm() < 1e-12);
        assert!((direction.y - 0.6).abs() < 1e-15);
        assert!((channel.nearest_mm(&Point3::new(4.0, 15.0, 70.0)) - 75.0).abs() < 1e-12);
    }

    #[test]
    fn a_coil_does_not_fit_around_a_bend() {
        let channel = bent();
        let coil = Coil { diameter_mm: 0.8, length_mm: 9.0 };
        let fits = |along_mm: f64| {
            let (middle, axis) = channel.at(along_mm);
            channel.holds(&middle, &axis, coil)
        };
        assert!(fits(40.0) && fits(60.0));
        assert!(!fits(50.0) && !fits(53.0));
    }

    #[test]
    fn a_channel_shorter_than_the_coil_has_no_place() {
        let points = [[0.0, 0.0, 0.0], [0.0, 0.0, 8.0]].map(Point3::from);
        let channel = Channel::new(&points, None);
        assert_eq!(channel.range_mm(Some(Coil { diameter_mm: 0.8, length_mm: 9.0 })), None);
        assert_eq!(channel.range_mm(None), Some([0.0, 8.0]));
    }
}
