//! An elliptic cylinder in front of a field generator that ends in a dome: what NDI's domed
//! measurement volumes are made of.
//!
//! The dome is a sphere about the tracker's origin with the pole's distance as its radius: it ends the
//! walls of three volumes at 452.99, 519.6 and 148.7 mm where NDI's meshes have 452, 519 and 148.

use super::bounds::{Bounds, INSIDE_TOLERANCE};
use super::outline::{BRACKET_SHARE, Dimension, DimensionKind, Outline};
use nalgebra::Point3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Chords of a whole turn in an outline: 0.3 mm from a circle with a radius of 480 mm.
const TURN_CHORDS: usize = 96;

/// Chords from a rim to the pole.
const DOME_CHORDS: usize = 24;

/// Nodes of the trapezoidal rule over a whole turn. The integrand is periodic and smooth, so the
/// error falls by `exp(-3.2)` every two nodes for the tabletop's axes and is round-off from some 24
/// on.
const NODES: usize = 64;

/// `(x/a)² + (y/b)² <= 1`, `z <= top`, `|p| <= reach`, in the tracker frame, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DomedCylinder {
    /// Semi-axes of the wall along x and y.
    pub radii_mm: [f64; 2],
    /// z of the flat top, which faces the generator; below zero.
    pub top_mm: f64,
    /// Radius of the dome about the origin: its pole is at `z = -reach`.
    pub reach_mm: f64,
}

impl DomedCylinder {
    /// The smallest box around it.
    pub fn bounds(&self) -> Bounds {
        let [a, b] = self.radii_mm;
        Bounds::from(([-a, -b, -self.reach_mm], [a, b, self.top_mm]))
    }

    /// At most zero within, above it outside, continuous; beside the wall of a circular cylinder,
    /// the top and the dome it is the distance in millimetres. Not a number where the point is not.
    pub fn excess_mm(&self, point_mm: &Point3<f64>) -> f64 {
        let [a, b] = self.radii_mm;
        let beyond = [
            ((point_mm.x / a).hypot(point_mm.y / b) - 1.0) * a.min(b),
            point_mm.z - self.top_mm,
            point_mm.coords.norm() - self.reach_mm,
        ];
        // `f64::max` would drop what is not a number.
        match beyond.iter().any(|excess| excess.is_nan()) {
            true => f64::NAN,
            false => beyond.into_iter().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Whether the point is within, give or take [`INSIDE_TOLERANCE`] of the reach.
    pub fn contains(&self, point_mm: &Point3<f64>) -> bool {
        self.excess_mm(point_mm) <= INSIDE_TOLERANCE * self.reach_mm
    }

    /// `∫∫ (√(R² - r²) - |top|) dA` over the ellipse: in closed form along the radius, to round-off
    /// by the trapezoidal rule around the turn. For a circle it is
    /// `2π/3 (R³ - (R² - a²)^(3/2)) - π a² |top|`.
    pub fn volume_mm3(&self) -> f64 {
        let [a, b] = self.radii_mm;
        let reach2 = self.reach_mm * self.reach_mm;
        let sum: f64 = (0..NODES)
            .map(|i| {
                let (sine, cosine) = (TAU * i as f64 / NODES as f64).sin_cos();
                let rim2 = (a * cosine).powi(2) + (b * sine).powi(2);
                (self.reach_mm.powi(3) - (reach2 - rim2).max(0.0).powf(1.5)) / rim2
            })
            .sum();
        a * b / 3.0 * sum * (TAU / NODES as f64) + PI * a * b * self.top_mm
    }

    /// Both rims, and eight lines from the top down the wall and over the dome to its pole.
    pub fn outline(&self) -> Outline {
        let turn = |rim: fn(&Self, f64) -> Point3<f64>| -> Vec<Point3<f64>> {
            (0..=TURN_CHORDS)
                .map(|i| rim(self, TAU * (i % TURN_CHORDS) as f64 / TURN_CHORDS as f64))
                .collect()
        };
        let meridian = |angle: f64| -> Vec<Point3<f64>> {
            let dome = (0..=DOME_CHORDS).map(|i| {
                // Even in the angle from the pole, not in the distance from the axis.
                let rim = self.wall_end(angle);
                let width = rim.coords.xy().norm();
                let polar = (width / self.reach_mm).asin();
                let left = 1.0 - i as f64 / DOME_CHORDS as f64;
                let (sine, cosine) = (polar * left).sin_cos();
                let out = rim.coords.xy() * (self.reach_mm * sine / width);
                Point3::new(out.x, out.y, -self.reach_mm * cosine)
            });
            std::iter::once(self.top_rim(angle)).chain(dome).collect()
        };
        let mut lines = vec![turn(Self::top_rim), turn(Self::wall_end)];
        lines.extend((0..8).map(|i| meridian(f64::from(i) * FRAC_PI_4)));
        let mut brackets = Vec::new();
        for i in 0..4 {
            let angle = f64::from(i) * FRAC_PI_2;
            let arc = |rim: fn(&Self, f64) -> Point3<f64>| {
                [-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0]
                    .map(|step| rim(self, angle + step / 4.0 * BRACKET_SHARE * FRAC_PI_2))
                    .to_vec()
            };
            let (top, end) = (self.top_rim(angle), self.wall_end(angle));
            let part = (end - top) * BRACKET_SHARE;
            brackets.extend([
                arc(Self::top_rim),
                arc(Self::wall_end),
                vec![top, top + part],
                vec![end, end - part],
            ]);
        }
        Outline { lines, brackets }
    }

    /// Its widths at its rims and its depth at the pole.
    pub fn dimensions(&self) -> Vec<Dimension> {
        let across = |kind, angles: &[f64], length_mm| Dimension {
            kind,
            length_mm,
            places_mm: angles
                .iter()
                .flat_map(|angle| [self.top_rim(*angle), self.wall_end(*angle)])
                .collect(),
        };
        // Where a rim is farthest from the x axis it runs along it, and the other way around.
        let [along_x, along_y] = [[FRAC_PI_2, -FRAC_PI_2], [0.0, PI]];
        let [a, b] = self.radii_mm;
        let mut dimensions = match a == b {
            true => vec![across(DimensionKind::Diameter, &[along_x, along_y].concat(), 2.0 * a)],
            false => vec![
                across(DimensionKind::Side, &along_x, 2.0 * a),
                across(DimensionKind::Side, &along_y, 2.0 * b),
            ],
        };
        dimensions.push(Dimension {
            kind: DimensionKind::Depth,
            length_mm: self.reach_mm + self.top_mm,
            places_mm: vec![Point3::new(0.0, 0.0, -self.reach_mm)],
        });
        dimensions
    }

    /// A point of the top's rim.
    fn top_rim(&self, angle: f64) -> Point3<f64> {
        let (sine, cosine) = angle.sin_cos();
        let [a, b] = self.radii_mm;
        Point3::new(a * cosine, b * sine, self.top_mm)
    }

    /// Where the wall ends and the dome begins: for an ellipse not all at one z.
    fn wall_end(&self, angle: f64) -> Point3<f64> {
        let top = self.top_rim(angle);
        let out2 = top.coords.xy().norm_squared();
        let depth_mm = (self.reach_mm * self.reach_mm - out2).max(0.0).sqrt();
        Point3::new(top.x, top.y, -depth_mm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Volume;

    fn all() -> [DomedCylinder; 3] {
        [Volume::DOME, Volume::TABLETOP, Volume::COMPACT]
    }

    #[test]
    fn walls_end_where_the_published_meshes_do() {
        for (shape, published_mm) in all().iter().zip([-452.0, -519.0, -148.0]) {
            let highest = (0..360)
                .map(|i| shape.wall_end(f64::from(i).to_radians()).z)
                .fold(f64::NEG_INFINITY, f64::max);
            assert!((highest - published_mm).abs() < 1.0, "{highest}");
        }
    }

    #[test]
    fn volumes_are_closed_forms_and_sums_of_slices() {
        let [dome, tabletop, compact] = all();
        for round in [dome, compact] {
            let (a, reach) = (round.radii_mm[0], round.reach_mm);
            let expected = 2.0 / 3.0 * PI * (reach.powi(3) - (reach * reach - a * a).powf(1.5))
                + PI * a * a * round.top_mm;
            assert!((round.volume_mm3() / expected - 1.0).abs() < 1e-13);
        }
        // Midpoints in x and y: second order, but for the ellipse's edge.
        let [a, b] = tabletop.radii_mm;
        let n = 2000;
        let cell = 4.0 * a * b / f64::from(n * n);
        let column = |i: i32, j: i32| {
            let [u, v] = [i, j].map(|k| (2.0 * f64::from(k) + 1.0) / f64::from(n) - 1.0);
            let r2 = (a * u).powi(2) + (b * v).powi(2);
            let depth = (tabletop.reach_mm.powi(2) - r2).sqrt() + tabletop.top_mm;
            if u * u + v * v <= 1.0 { depth } else { 0.0 }
        };
        let sum: f64 = (0..n).flat_map(|i| (0..n).map(move |j| column(i, j))).sum();
        assert!((sum * cell / tabletop.volume_mm3() - 1.0).abs() < 1e-4);
    }

    #[test]
    fn outlines_lie_on_the_surface() {
        for shape in all() {
            let outline = shape.outline();
            let points = || outline.lines.iter().flatten().copied();
            for point in points() {
                assert!(shape.excess_mm(&point).abs() < 1e-9, "{point}");
            }
            let around = Bounds::around(points()).unwrap();
            let bounds = shape.bounds();
            assert!((around.min_mm - bounds.min_mm).norm() < 1e-9);
            assert!((around.max_mm - bounds.max_mm).norm() < 1e-9);
            let brackets = outline.brackets.iter().flatten();
            assert!(brackets.clone().all(|p| shape.excess_mm(p).abs() < 1e-9));
        }
    }

    #[test]
    fn what_is_no_point_is_not_within() {
        let nowhere = Point3::new(0.0, f64::NAN, -300.0);
        assert!(all().iter().all(|shape| !shape.contains(&nowhere)));
    }
}
