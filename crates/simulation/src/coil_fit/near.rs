//! Whether a coil fits into no place near one: what a search may leave out without trying each.
//!
//! A point of the coil's middle line that is `d` from the surface keeps its side of it wherever it is
//! moved by less than `d`. What is stated holds for every place, not for those that were tried.

use super::{ACROSS_RAD, Cylinder, LEAST_MM, MOST_DIP_RADII, MOST_DIP_SLOPE, STATIONS};
use crate::body::Sensor;
use nalgebra::{Point3, Unit, Vector3};
use trackwright_geometry::surface::{Surface, bore_directions};

/// Directions from a point in which a way out of the body is looked for.
const MOST_DIRECTIONS: usize = 6;

/// Steps of such a way, and the least of its width that is left: near a wall they become short.
const MOST_STEPS: usize = 60;
const LEAST_CLEARANCE_MM: f64 = 0.01;

/// Places of a piece of the middle line at which its least depth is taken.
const DEPTH_PLACES: u32 = 8;

/// How far a sensor may be from where it is, and how far its axis may be turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearby {
    pub way_mm: f64,
    pub turn_rad: f64,
}

/// Points of the middle line of a sensor's coil, from end to end, each with how far it may be off; of
/// a sensor whose coil has no stated size, where it is.
pub fn coil_line_near(sensor: &Sensor, near: Nearby) -> Vec<(Point3<f64>, f64)> {
    let Some(cylinder) = Cylinder::of(sensor) else {
        return vec![(sensor.position_in_body, near.way_mm)];
    };
    (0..=STATIONS).map(|k| (cylinder.middle_at(k), cylinder.off_mm(k, near))).collect()
}

/// Whether a coil sticks out of the body wherever it is nearby. `false` states nothing.
pub fn sticks_out_near(sensor: &Sensor, near: Nearby, surface: &Surface) -> bool {
    let Some(cylinder) = Cylinder::of(sensor).filter(|_| surface.is_closed()) else {
        return false;
    };
    let line: Vec<Station> = (0..=STATIONS).map(|k| cylinder.station(k, near, surface)).collect();
    let outside = || line.iter().filter(|own| !own.is_inside && own.clear_mm > LEAST_MM);
    line.iter().any(|own| own.is_inside && own.clear_mm > 0.0)
        && cylinder.dips_near(&line, surface)
        && outside().any(|own| cylinder.is_in_no_bore(own, near, surface))
}

/// A point of the middle line.
struct Station {
    along_mm: f64,
    at_mm: Point3<f64>,
    off_mm: f64,
    is_inside: bool,
    /// Wherever it is, the surface is so far away at the least; below zero where it may be on either
    /// side.
    clear_mm: f64,
}

impl Cylinder {
    /// How far a point of the middle line may be from where it is.
    fn off_mm(&self, station: u32, near: Nearby) -> f64 {
        let arm_mm = self.size.length_mm * (f64::from(station) / f64::from(STATIONS) - 0.5).abs();
        near.way_mm + arm_mm * 2.0 * (near.turn_rad / 2.0).sin()
    }

    fn station(&self, number: u32, near: Nearby, surface: &Surface) -> Station {
        let at_mm = self.middle_at(number);
        let off_mm = self.off_mm(number, near);
        let away_mm = (surface.closest(&at_mm).position_mm - at_mm).norm();
        let along_mm = self.size.length_mm * f64::from(number) / f64::from(STATIONS);
        let is_inside = surface.contains(&at_mm);
        Station { along_mm, at_mm, off_mm, is_inside, clear_mm: away_mm - off_mm }
    }

    /// Whether the middle line dips too deep into the body for a coil that lies on it: at a quarter,
    /// the middle or three quarters of the dip, wherever that begins and ends.
    fn dips_near(&self, line: &[Station], surface: &Surface) -> bool {
        let is_deep = |own: &Station| own.is_inside && own.clear_mm > 0.0;
        // Two spheres that have a point in common: all between is inside.
        let is_joined = |a: &Station, b: &Station| {
            is_deep(a) && is_deep(b) && a.clear_mm + b.clear_mm > b.along_mm - a.along_mm
        };
        let mut first = 0;
        while first < line.len() {
            let more = line[first..].windows(2).take_while(|pair| is_joined(&pair[0], &pair[1]));
            let last = first + more.count();
            if is_deep(&line[first]) && self.is_deep_run(line, [first, last], surface) {
                return true;
            }
            first = last + 1;
        }
        false
    }

    fn is_deep_run(&self, line: &[Station], [first, last]: [usize; 2], surface: &Surface) -> bool {
        let run = &line[first..=last];
        let length_mm = self.size.length_mm;
        let is_out = |own: &&Station| !own.is_inside && own.clear_mm > 0.0;
        let before = line[..first].iter().rev().find(is_out);
        let after = line[last..].iter().find(is_out);
        // From where to where the dip may begin and end.
        let begin_mm = [
            before.map_or(0.0, |own| own.along_mm + own.clear_mm),
            (run[0].along_mm - run[0].clear_mm).max(0.0),
        ];
        let end = &run[run.len() - 1];
        let off_mm = line.iter().map(|own| own.off_mm).fold(0.0, f64::max);
        let end_mm = [
            (end.along_mm + end.clear_mm).min(length_mm),
            after.map_or(length_mm, |own| own.along_mm - own.clear_mm),
        ];
        let shallow_mm = (MOST_DIP_RADII * self.radius_mm())
            .min(MOST_DIP_SLOPE * (end_mm[1] - begin_mm[0]).max(0.0));
        [0.25, 0.5, 0.75].into_iter().any(|part| {
            let place = |k: usize| (1.0 - part) * begin_mm[k] + part * end_mm[k];
            self.least_depth_mm([place(0), place(1)], off_mm, surface) > shallow_mm
        })
    }

    /// How far the middle line is from the surface at the least between two places, wherever it is.
    fn least_depth_mm(&self, [from, to]: [f64; 2], off_mm: f64, surface: &Surface) -> f64 {
        let step_mm = (to - from).max(0.0) / f64::from(DEPTH_PLACES);
        let depth_mm = (0..=DEPTH_PLACES).map(|k| {
            let along_mm = from + step_mm * f64::from(k);
            let at = self.start_mm() + *self.axis * along_mm;
            (surface.closest(&at).position_mm - at).norm()
        });
        // Between two places it is less by half of what is between them at the most.
        depth_mm.fold(f64::INFINITY, f64::min) - off_mm - step_mm / 2.0
    }

    /// Whether a point that is outside of the solid is in no bore: one direction square to the axis
    /// is free as far as a bore's wall may be.
    fn is_in_no_bore(&self, own: &Station, near: Nearby, surface: &Surface) -> bool {
        let away = own.at_mm - surface.closest(&own.at_mm).position_mm;
        let mut directions: Vec<Unit<Vector3<f64>>> = bore_directions(&self.axis).collect();
        directions.sort_by(|a, b| b.dot(&away).total_cmp(&a.dot(&away)));
        // Those about a turned axis are others, of which one is at most half a step beside.
        let beside_rad = if near.turn_rad > 0.0 { near.turn_rad + ACROSS_RAD / 2.0 } else { 0.0 };
        let slope = 2.0 * (beside_rad / 2.0).sin();
        directions.iter().take(MOST_DIRECTIONS).any(|direction| {
            let mut along_mm = 0.0;
            for _ in 0..MOST_STEPS {
                let at = own.at_mm + direction.into_inner() * along_mm;
                let width_mm = own.off_mm + slope * along_mm;
                let clear_mm = (surface.closest(&at).position_mm - at).norm() - width_mm;
                if clear_mm < LEAST_CLEARANCE_MM {
                    return false;
                }
                along_mm += clear_mm / (1.0 + slope);
                if along_mm > self.size.length_mm {
                    return true;
                }
            }
            false
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Coil, SensorOrientation};
    use crate::coil_fits;
    use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};
    use trackwright_geometry::solid::Solid;

    /// A handle with a shaft, and a tube.
    fn bodies() -> Vec<Surface> {
        let handle: &[[f64; 2]] =
            &[[0.0, 0.0], [2.0, 0.0], [2.0, 40.0], [12.0, 50.0], [9.0, 80.0], [0.0, 90.0]];
        let outer: &[[f64; 2]] = &[[1.5, 0.0], [3.0, 0.0], [3.0, 60.0], [1.5, 60.0], [1.5, 0.0]];
        let surface = |outline: &[[f64; 2]]| {
            let Solid { positions_mm, normals, triangles } = Solid::turned(outline);
            let part = MeshPart { positions_mm, normals, triangles, ..MeshPart::default() };
            Surface::new(&SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }).unwrap()
        };
        [handle, outer].map(surface).into()
    }

    fn coil(at: Point3<f64>, axis: Vector3<f64>) -> Sensor {
        let orientation = SensorOrientation::FiveDof(Unit::new_normalize(axis));
        let coil = Some(Coil { diameter_mm: 0.8, length_mm: 9.0 });
        Sensor { coil, ..Sensor::new("a", at, orientation) }
    }

    #[test]
    fn no_coil_fits_where_none_is_stated_to() {
        // Quasi-random places, ways and turns: no seed.
        let part = |k: u32, by: f64| (f64::from(k) * by).fract() * 2.0 - 1.0;
        let mut stated = 0;
        for (number, surface) in bodies().iter().enumerate() {
            assert!(surface.is_closed(), "{number}");
            for k in 0..600 {
                let axis = Vector3::new(part(k, 0.7549), part(k, 0.5698), part(k, 0.3247) * 2.0);
                let free = Point3::new(
                    15.0 * part(k, 0.6180),
                    15.0 * part(k, 0.4142),
                    45.0 + 50.0 * part(k, 0.7321),
                );
                let sensor = coil(surface.closest(&free).position_mm, axis);
                let near = Nearby {
                    way_mm: 0.8 * part(k, 0.2361).abs(),
                    turn_rad: if k % 2 == 0 { 0.0 } else { 0.1 * part(k, 0.8090).abs() },
                };
                if !sticks_out_near(&sensor, near, surface) {
                    continue;
                }
                stated += 1;
                for i in 0..12 {
                    let j = 37 * k + i;
                    let way = Vector3::new(part(j, 0.1459), part(j, 0.9021), part(j, 0.4384));
                    let turn = Vector3::new(part(j, 0.3820), part(j, 0.1623), part(j, 0.6055));
                    let own = sensor.axis_in_body().unwrap();
                    let across = turn - own.into_inner() * own.dot(&turn);
                    let tilt = across.normalize() * near.turn_rad.tan();
                    let axis = if near.turn_rad > 0.0 { own.into_inner() + tilt } else { *own };
                    let at = sensor.position_in_body + way.normalize() * near.way_mm;
                    let moved = coil(at, axis);
                    assert!(
                        !coil_fits(&moved, std::iter::empty(), Some(surface)),
                        "{k}: {moved:?}"
                    );
                }
            }
        }
        assert!(stated > 150, "{stated} of 1200");
    }
}
