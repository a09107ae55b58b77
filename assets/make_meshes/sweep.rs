//! Bodies along a path: a rounded rectangle that goes on, turns, and changes its size on the way.

use std::f64::consts::FRAC_PI_2;

use crate::profile::{RoundedRectangle, skinned};
use crate::shape::Shape;
use crate::vector::{Placement, Vec3, VecExt, vec3};

/// Rings of an end's rounded edge: pieces that turn by less than a crease.
const EDGE_PIECES: usize = 3;

/// Shrinking copies of a ring that close an end.
const CAP_RINGS: usize = 2;

/// A rounded rectangle across a path.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Along the path's own x and y.
    pub half_mm: [f64; 2],
    pub corner_mm: f64,
}

/// Into how many pieces corners and sides of all sections of a body are cut.
#[derive(Clone, Copy, Debug)]
pub struct Pieces {
    pub corner: usize,
    /// Along own x and y.
    pub sides: [usize; 2],
}

/// A section and where it stands: own +z is ahead.
#[derive(Clone, Copy, Debug)]
pub struct Station {
    pub placement: Placement,
    pub section: Section,
}

/// A direction across a path, along its own axes.
#[derive(Clone, Copy, Debug)]
pub enum Towards {
    PlusX,
    MinusX,
    PlusY,
}

/// Stations, each added where the one before ends.
#[derive(Clone, Debug)]
pub struct Sweep {
    stations: Vec<Station>,
    last: Station,
}

/// Shorthand for a [`Section`] by its full size.
pub const fn section(width_mm: f64, height_mm: f64, corner_mm: f64) -> Section {
    Section { half_mm: [width_mm / 2.0, height_mm / 2.0], corner_mm }
}

impl Section {
    fn between(self, other: Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * t;
        Self {
            half_mm: [0, 1].map(|k| mix(self.half_mm[k], other.half_mm[k])),
            corner_mm: mix(self.corner_mm, other.corner_mm),
        }
    }
}

impl Towards {
    /// Components along own x and y, and half the section's size that way.
    fn of(self, section: &Section) -> ([f64; 2], f64) {
        let [half_x_mm, half_y_mm] = section.half_mm;
        match self {
            Self::PlusX => ([1.0, 0.0], half_x_mm),
            Self::MinusX => ([-1.0, 0.0], half_x_mm),
            Self::PlusY => ([0.0, 1.0], half_y_mm),
        }
    }
}

impl Sweep {
    pub fn new(placement: Placement, section: Section) -> Self {
        let last = Station { placement, section };
        Self { stations: vec![last], last }
    }

    /// Goes straight on, in equal pieces, to another section.
    #[must_use]
    pub fn forward(mut self, length_mm: f64, to: Section, pieces: usize) -> Self {
        let from = self.last;
        for i in 1..=pieces {
            let t = i as f64 / pieces as f64;
            let mut placement = from.placement;
            placement.origin += placement.z_axis * (length_mm * t);
            self.push(Station { placement, section: from.section.between(to, t) });
        }
        self
    }

    /// Turns, in equal pieces, with the section's near side at `inner_mm` from the axis of the turn.
    #[must_use]
    pub fn turn(
        mut self,
        towards: Towards,
        degrees: f64,
        inner_mm: f64,
        to: Section,
        pieces: usize,
    ) -> Self {
        let from = self.last;
        let ([x, y], half_mm) = towards.of(&from.section);
        let Placement { origin, x_axis, y_axis, z_axis } = from.placement;
        let inward = x_axis * x + y_axis * y;
        let pivot = origin + inward * (half_mm + inner_mm);
        for i in 1..=pieces {
            let t = i as f64 / pieces as f64;
            let (sin, cos) = (degrees * t).to_radians().sin_cos();
            let section = from.section.between(to, t);
            let (_, half_mm) = towards.of(&section);
            let new_inward = inward * cos - z_axis * sin;
            let ahead = z_axis * cos + inward * sin;
            let x_hint = x_axis + (new_inward - inward) * x;
            let origin = pivot - new_inward * (half_mm + inner_mm);
            self.push(Station { placement: Placement::new(origin, ahead, x_hint), section });
        }
        self
    }

    /// The path and its mirror image in x = 0, where the last station must be.
    pub fn mirrored(self) -> Vec<Station> {
        let mirror = |v: Vec3| vec3(-v.x, v.y, v.z);
        let back = self.stations.iter().rev().skip(1).map(|station| {
            let Placement { origin, x_axis, y_axis, z_axis } = station.placement;
            // Own x is kept, own z turned round twice: by the mirror, and by going the other way.
            let placement = Placement {
                origin: mirror(origin),
                x_axis: mirror(x_axis),
                y_axis: mirror(y_axis),
                z_axis: -mirror(z_axis),
            };
            Station { placement, ..*station }
        });
        self.stations.iter().copied().chain(back).collect()
    }

    pub fn stations(self) -> Vec<Station> {
        self.stations
    }

    fn push(&mut self, station: Station) {
        self.last = station;
        self.stations.push(station);
    }
}

/// The body of some stations; the edges of its two ends are rounded within its length.
pub fn swept(stations: &[Station], pieces: Pieces, edges_mm: [f64; 2]) -> Shape {
    let Some((last, first)) = stations.last().zip(stations.first()) else {
        return Shape::default();
    };
    let ring = |station: &Station, inset_mm: f64, ahead_mm: f64| {
        let Section { half_mm: [half_width_mm, half_height_mm], corner_mm } = station.section;
        let rectangle = RoundedRectangle {
            half_width_mm,
            half_height_mm,
            corner_mm,
            corner_pieces: pieces.corner,
            side_pieces: pieces.sides,
        };
        let lift = |&[x, y]: &[f64; 2]| station.placement.body_from_part(vec3(x, y, ahead_mm));
        rectangle.outline(-inset_mm).iter().map(lift).collect::<Vec<_>>()
    };
    // How far in, and how far from the end, the edge is after `i` pieces.
    let on_edge = |edge_mm: f64, i: usize| {
        let (sin, cos) = (FRAC_PI_2 * i as f64 / EDGE_PIECES as f64).sin_cos();
        (edge_mm * (1.0 - sin), edge_mm * (1.0 - cos))
    };
    let mut rings = Vec::new();
    for i in 0..=EDGE_PIECES {
        let (inset_mm, from_end_mm) = on_edge(edges_mm[0], i);
        rings.push(ring(first, inset_mm, from_end_mm));
    }
    rings.extend(stations[1..stations.len() - 1].iter().map(|station| ring(station, 0.0, 0.0)));
    for i in (0..=EDGE_PIECES).rev() {
        let (inset_mm, from_end_mm) = on_edge(edges_mm[1], i);
        rings.push(ring(last, inset_mm, -from_end_mm));
    }
    skinned(&rings, CAP_RINGS)
}

/// Stations along points, own y as near to `y_hint` as a right angle allows.
pub fn along(points: &[(Vec3, Section)], y_hint: Vec3) -> Vec<Station> {
    let at = |i: usize| points[i.min(points.len() - 1)].0;
    let station = |(i, &(origin, section)): (usize, &(Vec3, Section))| {
        let ahead = (at(i + 1) - at(i.saturating_sub(1))).normalized();
        Station { placement: Placement::new(origin, ahead, y_hint.cross(&ahead)), section }
    };
    points.iter().enumerate().map(station).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::{open_edge_count, volume_mm3};
    use crate::shape::bounds_mm;
    use std::f64::consts::PI;

    const BAR: Section = section(10.0, 20.0, 1.0);
    const PIECES: Pieces = Pieces { corner: 4, sides: [1, 2] };

    fn start() -> Placement {
        Placement::new(Vec3::default(), Vec3::z(), Vec3::x())
    }

    #[test]
    fn a_bent_bar_has_its_volume() {
        for towards in [Towards::PlusX, Towards::MinusX, Towards::PlusY] {
            let (_, half_mm) = towards.of(&BAR);
            let sweep = Sweep::new(start(), BAR).forward(40.0, BAR, 1);
            let sweep = sweep.turn(towards, 90.0, 30.0, BAR, 40).forward(5.0, BAR, 1);
            let shape = swept(&sweep.stations(), PIECES, [0.1; 2]);
            assert_eq!(open_edge_count(&shape), 0);
            let area_mm2 = 200.0 - (4.0 - PI);
            // Pappus: the area times the way of its middle.
            let expected_mm3 = area_mm2 * (45.0 + FRAC_PI_2 * (30.0 + half_mm));
            assert!((volume_mm3(&shape) / expected_mm3 - 1.0).abs() < 2e-3, "{towards:?}");
        }
    }

    #[test]
    fn a_mirrored_bar_is_symmetric() {
        let start = Placement::new(vec3(25.0, 0.0, 0.0), Vec3::z(), Vec3::x());
        let sweep = Sweep::new(start, BAR).turn(Towards::MinusX, 90.0, 15.0, BAR, 8);
        let shape = swept(&sweep.forward(5.0, BAR, 1).mirrored(), PIECES, [0.5; 2]);
        assert_eq!(open_edge_count(&shape), 0);
        assert!(volume_mm3(&shape) > 0.0);
        let (low, high) = bounds_mm(&shape.points);
        assert!((low.x + 30.0).abs() < 1e-9 && (high.x - 30.0).abs() < 1e-9, "{low:?} {high:?}");
        assert!(low.z.abs() < 1e-9 && (high.z - 25.0).abs() < 1e-9, "{low:?} {high:?}");
    }
}
