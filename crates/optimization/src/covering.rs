//! How far an allowed place of a region may be from the nearest of some places: an upper bound, on a
//! surface by branch and bound over pieces of its triangles.
//!
//! A piece whose corners are all near one of the places is near. Of the others a piece is left out only
//! where it is shown that none of its places is allowed, and halved where that is not shown.

use crate::channel::Channel;
use crate::constraint::{TOUCH_MM, pair_gap_mm};
use crate::problem::MountedBody;
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use trackwright_geometry::bounds::{Bounds, INSIDE_TOLERANCE};
use trackwright_simulation::{MountingAxis, Nearby, Sensor, coil_line_near, sticks_out_near};

/// Pieces that are looked at together: the result does not depend on how many threads do it.
const TOGETHER: usize = 64;

/// Most pieces that are looked at. The bound is looser where they are used up: some tenths of a
/// second.
const MOST_PIECES: usize = 12_000;

/// Pieces that reach less far from their middle are not halved.
const LEAST_MM: f64 = 0.1;

/// Pieces that a channel is looked at in, those between places apart.
const CHANNEL_PIECES: u32 = 400;

/// Cosine of the widest cone of normals of a piece whose axes follow them.
const WIDEST: f64 = 0.3;

/// A corner with its normal, of any length.
type Corner = (Point3<f64>, Vector3<f64>);

/// A sensor that is put at places of its body, and what keeps it from some.
pub(crate) struct Putting<'a> {
    pub body: &'a MountedBody,
    pub tip_in_body: Option<Point3<f64>>,
    pub sensor: &'a Sensor,
    /// Those of the body that stay where they are.
    pub others: &'a [&'a Sensor],
}

/// The part of a surface that a sensor may be at, and how it is turned there: as the rule turns the
/// sensor that is given.
pub(crate) struct SurfaceRegion<'a> {
    pub putting: &'a Putting<'a>,
    pub boxes: &'a [Bounds],
    pub axis: MountingAxis,
}

/// Part of a triangle.
struct Piece {
    corners: [Corner; 3],
    /// None of its places is farther from the nearest place.
    far_mm: f64,
}

impl Putting<'_> {
    /// Whether it is shown that a sensor is allowed nowhere near a place, by what is to be kept free and
    /// the sensors that stay.
    fn is_kept_off(&self, sensor: &Sensor, near: Nearby) -> bool {
        let mounting = &self.body.mounting;
        let line = coil_line_near(sensor, near);
        let is_at_tip = |tip: &Point3<f64>| {
            let least_mm = mounting.tip_clearance_mm - TOUCH_MM;
            line.iter().any(|(at, off_mm)| (at - tip).norm() + off_mm < least_mm)
        };
        let is_kept_out = |kept: &Bounds| {
            line.iter().any(|(at, off_mm)| {
                let low = |k: usize| at[k] - off_mm >= kept.min_mm[k];
                (0..3).all(|k| low(k) && at[k] + off_mm <= kept.max_mm[k])
            })
        };
        // No point of the coil's middle line, between which gaps are, is farther off than its ends.
        let off_mm = line.iter().map(|(_, off_mm)| *off_mm).fold(near.way_mm, f64::max);
        let is_too_near = |other: &&Sensor| {
            let (apart_mm, least_mm) = pair_gap_mm(sensor, other, mounting.least_gap_mm);
            apart_mm + off_mm < least_mm
        };
        self.tip_in_body.as_ref().is_some_and(is_at_tip)
            || mounting.keep_out.iter().any(is_kept_out)
            || self.others.iter().any(is_too_near)
    }

    /// No allowed place of a channel is farther along it from one of these ways. `at` puts the sensor.
    pub fn channel_covering_mm(
        &self,
        channel: &Channel,
        along_mm: &[f64],
        at: impl Fn(f64) -> Sensor,
    ) -> f64 {
        let Some([from, to]) = channel.range_mm(self.sensor.coil) else {
            return 0.0;
        };
        let mut ends: Vec<f64> = (0..=CHANNEL_PIECES)
            .map(|k| from + (to - from) * f64::from(k) / f64::from(CHANNEL_PIECES))
            .chain(along_mm.iter().copied())
            .collect();
        ends.sort_by(f64::total_cmp);
        let far_mm = |ends: [f64; 2]| {
            let way =
                |place: &f64| ends.map(|end| (end - place).abs()).into_iter().fold(0.0, f64::max);
            along_mm.iter().map(way).fold(f64::INFINITY, f64::min)
        };
        let each = ends.windows(2).filter_map(|ends| {
            let middle_mm = f64::midpoint(ends[0], ends[1]);
            let way_mm = (ends[1] - ends[0]) / 2.0;
            let turned = |end: f64| channel.at(end).1 != channel.at(middle_mm).1;
            let is_straight = !ends.iter().any(|end| turned(*end));
            let near = Nearby { way_mm, turn_rad: 0.0 };
            let is_forbidden = is_straight && self.is_kept_off(&at(middle_mm), near);
            (!is_forbidden).then(|| far_mm([ends[0], middle_mm]).max(far_mm([middle_mm, ends[1]])))
        });
        each.fold(0.0, f64::max)
    }
}

impl SurfaceRegion<'_> {
    /// No allowed place is farther from one of these places.
    pub fn covering_mm(&self, places: &[Point3<f64>]) -> f64 {
        let Some(surface) = self.putting.body.surface.as_deref() else {
            return 0.0;
        };
        let triangles: Vec<[Corner; 3]> = surface.triangles().collect();
        let pieces = triangles
            .into_par_iter()
            .filter(|corners| is_in_one(self.boxes, corners))
            .map(|corners| Piece::new(corners, places));
        let mut open: BinaryHeap<Piece> = pieces.collect::<Vec<_>>().into();
        let mut settled_mm = 0.0_f64;
        let mut looked_at = 0;
        while open.peek().is_some_and(|piece| piece.far_mm > settled_mm) && looked_at < MOST_PIECES
        {
            let farthest: Vec<Piece> = (0..TOGETHER).map_while(|_| open.pop()).collect();
            looked_at += farthest.len();
            let left: Vec<Piece> = farthest
                .into_par_iter()
                .filter(|piece| piece.far_mm > settled_mm && !self.is_forbidden(piece))
                .collect();
            for piece in left {
                match piece.reach_mm() < LEAST_MM {
                    true => settled_mm = settled_mm.max(piece.far_mm),
                    false => open.extend(piece.halves(places)),
                }
            }
        }
        open.peek().map_or(settled_mm, |piece| piece.far_mm.max(settled_mm))
    }

    /// Whether it is shown that no place of a piece is allowed.
    fn is_forbidden(&self, piece: &Piece) -> bool {
        if !is_in_one(self.boxes, &piece.corners) {
            return true;
        }
        let Some((sensor, near)) = self.sensor_near(piece) else {
            return false;
        };
        let surface = self.putting.body.surface.as_deref();
        self.putting.is_kept_off(&sensor, near)
            || surface.is_some_and(|surface| sticks_out_near(&sensor, near, surface))
    }

    /// The sensor in the middle of a piece, and how far from that it is at any of its places; `None`
    /// where the rule turns it by more than can be stated.
    fn sensor_near(&self, piece: &Piece) -> Option<(Sensor, Nearby)> {
        let position_in_body = piece.middle();
        let sensor = Sensor { position_in_body, ..self.putting.sensor.clone() };
        let as_it_is = (sensor.clone(), Nearby { way_mm: piece.reach_mm(), turn_rad: 0.0 });
        let Some(own) = sensor.axis_in_body() else {
            return Some(as_it_is);
        };
        let (axis, turn_rad) = match self.axis {
            MountingAxis::AsItIs | MountingAxis::Along => return Some(as_it_is),
            MountingAxis::Free => return None,
            MountingAxis::Normal => piece.normals()?,
            MountingAxis::Tangent => {
                let (normal, turn_rad) = piece.normals()?;
                let along = own.into_inner() - normal.into_inner() * normal.dot(&own);
                // The projections onto two planes differ by the sine of the angle between them.
                let turned = turn_rad.sin() / along.norm();
                (turned < 0.9).then(|| (Unit::new_normalize(along), turned.asin()))?
            }
        };
        Some((sensor.pointed_along(&axis), Nearby { turn_rad, ..as_it_is.1 }))
    }
}

impl Piece {
    fn new(corners: [Corner; 3], places: &[Point3<f64>]) -> Self {
        let farthest = |place: &Point3<f64>| {
            let away = corners.iter().map(|(at, _)| (at - place).norm_squared());
            away.fold(0.0, f64::max)
        };
        // The distance to one place is largest at a corner.
        let far2_mm2 = places.iter().map(farthest).fold(f64::INFINITY, f64::min);
        Self { corners, far_mm: far2_mm2.sqrt() }
    }

    fn middle(&self) -> Point3<f64> {
        let [a, b, c] = self.corners.map(|(at, _)| at.coords);
        Point3::from((a + b + c) / 3.0)
    }

    /// How far its places are from its middle at the most.
    fn reach_mm(&self) -> f64 {
        let middle = self.middle();
        self.corners.iter().map(|(at, _)| (at - middle).norm()).fold(0.0, f64::max)
    }

    /// The direction in the middle of its normals, and the angle that none is farther from it.
    fn normals(&self) -> Option<(Unit<Vector3<f64>>, f64)> {
        let normals = self.corners.map(|(_, normal)| Unit::try_new(normal, 1e-9));
        let [Some(a), Some(b), Some(c)] = normals else {
            return None;
        };
        let middle = Unit::try_new(a.into_inner() + b.into_inner() + c.into_inner(), 1e-9)?;
        let cosine = [a, b, c].iter().map(|own| own.dot(&middle)).fold(1.0, f64::min);
        (cosine > WIDEST).then(|| (middle, cosine.acos()))
    }

    /// Cut through the middle of its longest edge.
    fn halves(&self, places: &[Point3<f64>]) -> [Self; 2] {
        let length2 = |k: &usize| (self.corners[(k + 1) % 3].0 - self.corners[*k].0).norm_squared();
        let first = (0..3).max_by(|a, b| length2(a).total_cmp(&length2(b))).unwrap_or(0);
        let [a, b, c] = [0, 1, 2].map(|k| self.corners[(first + k) % 3]);
        let middle = (nalgebra::center(&a.0, &b.0), (a.1 + b.1) / 2.0);
        [Self::new([a, middle, c], places), Self::new([middle, b, c], places)]
    }
}

/// Whether a triangle may have a place in one of the boxes, or there are none.
fn is_in_one(boxes: &[Bounds], corners: &[Corner; 3]) -> bool {
    let own = Bounds::around(corners.map(|(at, _)| at));
    let reaches = |bounds: &Bounds| {
        let slack = bounds.size_mm() * INSIDE_TOLERANCE;
        let with_round_off =
            Bounds { min_mm: bounds.min_mm - slack, max_mm: bounds.max_mm + slack };
        own.is_some_and(|own| own.intersection(&with_round_off).is_some())
    };
    boxes.is_empty() || boxes.iter().any(reaches)
}

impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        let at = |piece: &Self| piece.corners.map(|(at, _)| <[f64; 3]>::from(at.coords));
        let [own, others] = [at(self), at(other)];
        let place = own.as_flattened().iter().zip(others.as_flattened());
        // Of those that are as far where they are decides: the order is always the same.
        self.far_mm.total_cmp(&other.far_mm).then_with(|| {
            place
                .map(|(a, b)| a.total_cmp(b))
                .find(|order| order.is_ne())
                .unwrap_or(Ordering::Equal)
        })
    }
}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Piece {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::places::Places;
    use crate::tests::cases::{coil, plate, plate_top};
    use trackwright_field::random_models::Seeded;
    use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};
    use trackwright_geometry::solid::Solid;
    use trackwright_simulation::{Mounting, MountingRegion};

    /// A handle with a shaft along z.
    fn handle() -> SurfaceMesh {
        let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 40.0], [12.0, 50.0], [9.0, 80.0], [0.0, 90.0]];
        let Solid { positions_mm, normals, triangles } = Solid::turned(&outline);
        let part = MeshPart { positions_mm, normals, triangles, ..MeshPart::default() };
        SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
    }

    /// Random places of the surface, each as the rule has it.
    fn sampled(body: &MountedBody, places: &Places, sensor: &Sensor) -> Vec<Point3<f64>> {
        let triangles: Vec<[Corner; 3]> = body.surface.as_ref().unwrap().triangles().collect();
        let mut seeded = Seeded::new(5);
        let mut found = Vec::new();
        for _ in 0..3_000 {
            let number = (seeded.uniform() * triangles.len() as f64) as usize;
            let [a, b, c] = triangles[number].map(|(at, _)| at);
            let (u, v) = (seeded.uniform(), seeded.uniform());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let position_in_body = a + (b - a) * u + (c - a) * v;
            let place = places.nearest(&Sensor { position_in_body, ..sensor.clone() }).unwrap();
            if places.fault(&place).is_none() {
                found.push(place.sensor.position_in_body);
            }
        }
        found
    }

    #[test]
    fn no_allowed_place_is_farther_than_stated() {
        let sensor = coil("a", [0.0; 3], Vector3::new(0.0, 0.3, 1.0));
        let kept = Bounds::from(([-20.0, -20.0, 55.0], [20.0, 0.0, 62.0]));
        for axis in [MountingAxis::AsItIs, MountingAxis::Tangent] {
            let region = MountingRegion::Surface { axis, boxes: Vec::new() };
            let mounting = Mounting {
                regions: vec![region],
                keep_out: vec![kept],
                tip_clearance_mm: 6.0,
                ..Mounting::default()
            };
            let body = MountedBody::of_mesh(mounting, &handle());
            let places = Places::new(&body, Some(Point3::origin()));
            let grid = places.grid(&sensor, 60);
            let stated_mm = places.spacing_mm(&sensor, &[], &grid.places).unwrap();
            let far_mm = |at: &Point3<f64>| {
                let away = grid.places.iter().map(|own| (own.sensor.position_in_body - at).norm());
                away.fold(f64::INFINITY, f64::min)
            };
            let allowed = sampled(&body, &places, &sensor);
            let farthest_mm = allowed.iter().map(far_mm).fold(0.0, f64::max);
            assert!(allowed.len() > 20, "{axis:?}: {} allowed", allowed.len());
            assert!(farthest_mm <= stated_mm, "{axis:?}: {farthest_mm} mm, stated {stated_mm} mm");
        }
    }

    #[test]
    fn a_patch_is_covered_as_far_as_its_grid_is_wide() {
        let body = MountedBody::of_mesh(plate_top(), &plate());
        let places = Places::new(&body, None);
        let sensor = coil("a", [0.0; 3], Vector3::x());
        let still = coil("b", [0.0; 3], Vector3::x());
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [0.0, 0.0]];
        let grid: Vec<_> = corners
            .iter()
            .map(|[x, y]| [20.0 * x, 20.0 * y, 0.0].into())
            .map(|position_in_body| Sensor { position_in_body, ..sensor.clone() })
            .map(|sensor| places.nearest(&sensor).unwrap())
            .collect();
        // The middles of the patch's sides, 25 mm off: 25 mm from the middle, farther from the corners.
        let covered_mm = places.spacing_mm(&sensor, &[], &grid).unwrap();
        let expected_mm = 20.0_f64.hypot(5.0);
        assert!((covered_mm - expected_mm).abs() < 0.4, "{covered_mm} mm, not {expected_mm} mm");
        // Without the middle it is the farthest; another coil that stays there keeps the sensor off it.
        let around = &grid[..4];
        let middle_mm = 20.0 * 2.0_f64.sqrt();
        let covered_mm = places.spacing_mm(&sensor, &[], around).unwrap();
        assert!((covered_mm - middle_mm).abs() < 0.4, "{covered_mm} mm, not {middle_mm} mm");
        let covered_mm = places.spacing_mm(&sensor, &[&still], around).unwrap();
        assert!(covered_mm < middle_mm - 1.0, "{covered_mm} mm");
        // No place at all stands for none.
        assert_eq!(places.spacing_mm(&sensor, &[], &[]), None);
    }
}
