//! The straight channel along the axis of a round body: its bore, or the middle of its solid.
//!
//! At stations along the axis of revolution rays go out square to it. Each ray counts the walls that it
//! meets, so that parts may overlap: their sum shows whether it began in the solid, and the first place
//! where that changes is the wall. The majority of a station's rays decides whether it is in
//! the solid or in a bore, so that a mesh with holes has a channel too. The radius is the one that most
//! of the stations have room for: a tip or a cone does not narrow the channel, it ends there.

use super::{Ray, Surface};
use crate::revolution::RevolutionAxis;
use crate::rotation::perpendicular;
use nalgebra::{Point3, Unit, Vector3};
use std::f64::consts::TAU;

/// Places along the axis that are looked at.
const STATIONS: usize = 200;

/// Rays of a station: a hexagon's flats are then met within 0.2 % of its inner radius.
const AROUND: u32 = 48;

/// The first of them, in parts of a step: none then runs to a corner of a round part of as many sides.
const OFF_CORNERS: f64 = 0.381_966;

/// The least part of a station's rays that have to meet a wall: less is the mouth of a slanted tip.
const LEAST_WALLED: f64 = 2.0 / 3.0;

/// The largest wall distance of a round station over the least: a pentagon has 1.24, a square 1.41.
const MOST_OUT_OF_ROUND: f64 = 1.3;

/// The least length of a channel, in its diameters.
const LEAST_LENGTH: f64 = 3.0;

/// A bore is one where so many of the stations are in it: a socket in a handle is none.
const LEAST_BORE: f64 = 1.0 / 3.0;

/// So many of the stations may be narrower than the channel: those of a tip.
const NARROW: f64 = 0.1;

/// Stations that are narrower by less belong to the channel.
const SLACK: f64 = 0.01;

/// Halvings that find an end: a millionth of the way between two stations.
const HALVINGS: u32 = 20;

/// A straight channel along the axis of a round body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisChannel {
    pub start_mm: Point3<f64>,
    pub end_mm: Point3<f64>,
    /// Of the largest cylinder about the axis that has room all along it.
    pub radius_mm: f64,
    /// Whether it is a bore; else it is in the solid.
    pub is_bore: bool,
}

/// The walls around a place of the axis.
#[derive(Clone, Copy, Debug)]
struct Section {
    radius_mm: f64,
    /// The largest distance of the wall over the least.
    out_of_round: f64,
    is_bore: bool,
}

impl Surface {
    /// The channel along the body's axis of revolution, its start the end that `long_axis` points away
    /// from; `None` where the body has no long round part.
    ///
    /// ```
    /// use nalgebra::{Point3, Vector3};
    /// use trackwright_geometry::placeholder::placeholder;
    /// use trackwright_geometry::surface::Surface;
    ///
    /// // A rod of 1.5 mm from the origin along z.
    /// let mesh = placeholder(&Point3::origin(), &[Point3::new(0.0, 0.0, 100.0)]);
    /// let surface = Surface::new(&mesh).unwrap();
    /// let channel = surface.axis_channel(&Vector3::z()).unwrap();
    /// assert!((channel.radius_mm - 1.5).abs() < 0.03 && !channel.is_bore);
    /// ```
    pub fn axis_channel(&self, long_axis: &Vector3<f64>) -> Option<AxisChannel> {
        let axis = self.revolution_axis(long_axis)?;
        let bounds = &self.nodes.first()?.bounds;
        let origin_mm = axis.point_mm.coords.dot(&axis.direction);
        let [from_mm, to_mm] = bounds.span_mm(&axis.direction).map(|along| along - origin_mm);
        let step_mm = (to_mm - from_mm) / STATIONS as f64;
        let at_mm = |station: f64| from_mm + step_mm * (station + 0.5);
        let sections: Vec<Option<Section>> =
            (0..STATIONS).map(|k| self.section(&axis, at_mm(k as f64))).collect();

        let walled = sections.iter().flatten().count();
        let of_bore = sections.iter().flatten().filter(|section| section.is_bore).count();
        let is_bore = of_bore > 0 && of_bore as f64 >= LEAST_BORE * walled as f64;
        // What is in the solid may lead through a hollow of it.
        let is_kind = |section: &&Section| section.is_bore || !is_bore;
        let radii_mm = sections.iter().flatten().filter(is_kind).map(|section| section.radius_mm);
        let least_mm = narrow(radii_mm.collect())? * (1.0 - SLACK);
        let fits = |section: &Section| section.radius_mm >= least_mm && is_kind(&section);

        let run = longest_run(&sections, fits)?;
        let own: Vec<&Section> = sections[run.0..=run.1].iter().flatten().collect();
        let out_of_round = median(own.iter().map(|section| section.out_of_round).collect())?;
        let radius_mm = own.iter().map(|section| section.radius_mm).fold(f64::INFINITY, f64::min);
        // From a station of the channel to the next one out.
        let end_mm = |inside: usize, outward: f64| {
            let (mut inside, mut outside) = (inside as f64, inside as f64 + outward);
            for _ in 0..HALVINGS {
                let middle = f64::midpoint(inside, outside);
                match self.section(&axis, at_mm(middle)).is_some_and(|section| fits(&section)) {
                    true => inside = middle,
                    false => outside = middle,
                }
            }
            at_mm(inside)
        };
        let [start_mm, end_mm] = [end_mm(run.0, -1.0), end_mm(run.1, 1.0)];
        let is_long = end_mm - start_mm >= LEAST_LENGTH * 2.0 * radius_mm;
        let place = |along_mm: f64| axis.point_mm + axis.direction.into_inner() * along_mm;
        (is_long && out_of_round <= MOST_OUT_OF_ROUND).then(|| AxisChannel {
            start_mm: place(start_mm),
            end_mm: place(end_mm),
            radius_mm,
            is_bore,
        })
    }

    /// The walls around the axis at a place; `None` outside of the body.
    fn section(&self, axis: &RevolutionAxis, along_mm: f64) -> Option<Section> {
        let origin_mm = axis.point_mm + axis.direction.into_inner() * along_mm;
        let x = perpendicular(&axis.direction);
        let y = axis.direction.cross(&x);
        let rays = (0..AROUND).map(|k| {
            let turn_rad = (f64::from(k) + OFF_CORNERS) / f64::from(AROUND) * TAU;
            let (sine, cosine) = turn_rad.sin_cos();
            let direction = Unit::new_normalize(*x * cosine + y * sine);
            let mut walls = self.crossings(&Ray { origin_mm, direction });
            walls.sort_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm));
            walls
        });
        let rays: Vec<_> = rays.collect();
        // Out of as many parts as it is in.
        let mut parts: Vec<i32> =
            rays.iter().map(|walls| -walls.iter().map(|wall| wall.step).sum::<i32>()).collect();
        parts.sort_unstable();
        let parts = parts[parts.len() / 2];
        let is_bore = parts <= 0;
        let walls_mm = rays.iter().filter_map(|walls| {
            let mut parts = parts;
            let wall = walls.iter().find(|wall| {
                parts += wall.step;
                (parts <= 0) != is_bore
            });
            wall.map(|wall| wall.distance_mm)
        });
        let walls_mm: Vec<f64> = walls_mm.collect();
        let radius_mm = walls_mm.iter().copied().fold(f64::INFINITY, f64::min);
        let most_mm = walls_mm.iter().copied().fold(0.0, f64::max);
        let is_walled = walls_mm.len() as f64 >= LEAST_WALLED * f64::from(AROUND);
        (is_walled && radius_mm > 0.0).then(|| Section {
            radius_mm,
            out_of_round: most_mm / radius_mm,
            is_bore,
        })
    }
}

/// The radius that all but a [`NARROW`] part have.
fn narrow(mut radii_mm: Vec<f64>) -> Option<f64> {
    radii_mm.sort_by(f64::total_cmp);
    radii_mm.get((radii_mm.len() as f64 * NARROW) as usize).copied()
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// The first and last station of the most in a row that fit.
fn longest_run(
    sections: &[Option<Section>],
    fits: impl Fn(&Section) -> bool,
) -> Option<(usize, usize)> {
    let mut best: Option<(usize, usize)> = None;
    let mut first = None;
    for (station, section) in sections.iter().enumerate() {
        if !section.as_ref().is_some_and(&fits) {
            first = None;
            continue;
        }
        let run = (*first.get_or_insert(station), station);
        if best.is_none_or(|best| run.1 - run.0 > best.1 - best.0) {
            best = Some(run);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MeshPart, SurfaceMesh};
    use crate::pose::Pose;
    use crate::solid::Solid;
    use crate::surface::tests::cylinder;

    /// Flats of a turned body of 24 sides are nearer to the axis than its corners.
    const FLATS: f64 = 0.01;

    fn turned(outline: &[[f64; 2]]) -> SurfaceMesh {
        let Solid { positions_mm, normals, triangles } = Solid::turned(outline);
        let part = MeshPart { positions_mm, normals, triangles, ..MeshPart::default() };
        SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
    }

    /// 1.4 mm across with a bore of 0.8 mm, 120 mm long, a funnel at its end.
    const NEEDLE: [[f64; 2]; 7] = [
        [0.4, 0.0],
        [0.7, 0.0],
        [0.7, 112.0],
        [2.6, 120.0],
        [2.0, 120.0],
        [0.4, 112.0],
        [0.4, 0.0],
    ];

    fn channel(mesh: &SurfaceMesh) -> Option<AxisChannel> {
        Surface::new(mesh).unwrap().axis_channel(&mesh.long_axis())
    }

    fn assert_channel(found: Option<AxisChannel>, ends_mm: [Point3<f64>; 2], radius_mm: f64) {
        let found = found.unwrap();
        for (end, expected) in [found.start_mm, found.end_mm].iter().zip(ends_mm) {
            assert!((end - expected).norm() < 0.01, "{found:?}");
        }
        let least_mm = radius_mm * (1.0 - FLATS);
        assert!((least_mm..=radius_mm + 1e-9).contains(&found.radius_mm), "{found:?}");
    }

    fn on_z(from_mm: f64, to_mm: f64) -> [Point3<f64>; 2] {
        [from_mm, to_mm].map(|z| Point3::new(0.0, 0.0, z))
    }

    #[test]
    fn a_needle_has_the_channel_of_its_bore() {
        let found = channel(&turned(&NEEDLE));
        assert!(found.unwrap().is_bore);
        assert_channel(found, on_z(0.0, 120.0), 0.4);
        // One that is closed at its tip.
        let blind =
            turned(&[[0.0, 0.0], [1.0, 0.0], [1.0, 80.0], [0.4, 80.0], [0.4, 10.0], [0.0, 10.0]]);
        let found = channel(&blind);
        assert!(found.unwrap().is_bore);
        assert_channel(found, on_z(10.0, 80.0), 0.4);
    }

    #[test]
    fn a_solid_rod_has_what_fits_inside() {
        let rod = channel(&cylinder(2.0, 100.0, 96));
        assert!(!rod.unwrap().is_bore);
        assert_channel(rod, on_z(0.0, 100.0), 2.0);
        // A point does not narrow it, nor does a thicker handle widen it.
        let pointed =
            [[0.0, 0.0], [1.0, 8.0], [1.0, 70.0], [5.0, 80.0], [5.0, 120.0], [0.0, 120.0]];
        let found = channel(&turned(&pointed)).unwrap();
        assert!((7.7..8.1).contains(&found.start_mm.z), "{found:?}");
        assert!((found.end_mm.z - 120.0).abs() < 0.01, "{found:?}");
        assert!((0.96..=1.0).contains(&found.radius_mm), "{found:?}");
        // A socket in the end of a handle is no bore of the tool.
        let socket = [[0.0, 0.0], [3.0, 0.0], [3.0, 90.0], [2.0, 90.0], [2.0, 75.0], [0.0, 75.0]];
        let found = channel(&turned(&socket)).unwrap();
        assert!(!found.is_bore && (found.radius_mm - 2.0).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn a_tilted_needle_has_its_channel() {
        let turn = nalgebra::UnitQuaternion::from_euler_angles(0.4, 0.7, -0.2);
        let pose = Pose::from_parts(Vector3::new(30.0, -20.0, 55.0).into(), turn);
        let mut mesh = turned(&NEEDLE);
        for part in &mut mesh.parts {
            part.positions_mm.iter_mut().for_each(|position| *position = pose * *position);
            part.normals.iter_mut().for_each(|normal| *normal = pose * *normal);
        }
        let found = Surface::new(&mesh).unwrap().axis_channel(&(pose * Vector3::z()));
        assert_channel(found, on_z(0.0, 120.0).map(|end| pose * end), 0.4);
        let back = Surface::new(&mesh).unwrap().axis_channel(&(pose * -Vector3::z()));
        assert_channel(back, on_z(120.0, 0.0).map(|end| pose * end), 0.4);
    }

    #[test]
    fn coarse_and_open_meshes_have_a_channel() {
        for sides in [6, 8] {
            let found = channel(&cylinder(2.0, 100.0, sides)).unwrap();
            let inner_mm = 2.0 * (std::f64::consts::PI / f64::from(sides)).cos();
            assert!((found.radius_mm / inner_mm - 1.0).abs() < 0.003, "{sides}: {found:?}");
        }
        // Without its ends, and one triangle in eight missing elsewhere.
        let mut open = turned(&NEEDLE);
        let part = &mut open.parts[0];
        let mut count = 0;
        part.triangles.retain(|_| {
            count += 1;
            count % 8 != 3
        });
        let found = channel(&open);
        assert!(found.unwrap().is_bore);
        assert_channel(found, on_z(0.0, 120.0), 0.4);
        let mut tube = cylinder(2.0, 100.0, 24);
        let corners = tube.parts[0].positions_mm.clone();
        let is_side =
            |t: &[u32; 3]| t.iter().all(|i| corners[*i as usize].coords.xy().norm() > 1.0);
        tube.parts[0].triangles.retain(is_side);
        assert_channel(channel(&tube), on_z(0.0, 100.0), 2.0);
    }

    #[test]
    fn what_is_not_long_and_round_has_none() {
        for size in [[20.0, 30.0, 60.0], [4.0, 4.0, 120.0], [10.0, 10.0, 10.0]] {
            assert_eq!(channel(&block(size)), None, "{size:?}");
        }
        assert_eq!(channel(&cylinder(20.0, 8.0, 48)), None, "a disc");
    }

    /// A closed box about the origin.
    fn block(size_mm: [f64; 3]) -> SurfaceMesh {
        let mut part = MeshPart::default();
        for i in 0..8_u32 {
            let corner = |k: usize| (f64::from(i >> k & 1) - 0.5) * size_mm[k];
            part.positions_mm.push(Point3::new(corner(0), corner(1), corner(2)));
        }
        part.normals = vec![Vector3::z(); 8];
        for [a, b, c, d] in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            part.triangles.extend([[a, b, c], [a, c, d]]);
        }
        SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
    }
}
