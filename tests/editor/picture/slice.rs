//! The slice shows what `distort` computes, in the colours of its colour bar.

use super::render;
use crate::copied::Copied;
use crate::pixels::{Pixel, is_near};
use crate::support::program::{succeed, text};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use trackwright_design::BodyRole;
use trackwright_design::view::{ColorMap, Quantity, SliceAxis, SliceView};
use trackwright_editor::runner::solve::slice_plan;
use trackwright_geometry::colormap::{NO_VALUE_LINE_SRGB, NO_VALUE_SRGB};
use trackwright_geometry::orbit::{OrbitCamera, Projection};
use trackwright_project::World;

const SIZE: [u32; 2] = [640, 480];

/// Errors from here on have the last colour; the slice's largest is below.
const RANGE_MM: f64 = 15.0;

/// How many points are read.
const POINTS: usize = 5;

/// Sensors shine through everything, this far around their middles.
const SENSOR_PX: f64 = 45.0;

/// A point of the slice and the pixel it is drawn in.
#[derive(Clone, Copy, Debug)]
struct Seen {
    point_mm: Point3<f64>,
    pixel: Pixel,
    /// From the middle of the pixel, in pixels.
    off_px: f64,
}

fn slice() -> SliceView {
    SliceView {
        quantity: Quantity::PositionErrorMm,
        // Between the camera and all bodies.
        axis: SliceAxis::X,
        position_mm: 150.0,
        free: None,
        sensor_axis: [0.6, 0.0, 0.8],
        range_mm: Some(RANGE_MM),
        color_map: ColorMap::Viridis,
    }
}

fn camera() -> OrbitCamera {
    OrbitCamera {
        focus_mm: Point3::new(150.0, 0.0, -300.0),
        distance_mm: 1000.0,
        azimuth_rad: 0.15,
        elevation_rad: 0.1,
        projection: Projection::Perspective,
    }
}

/// Of each fifth of the slice, the lattice point that is drawn nearest to the middle of a pixel
/// and is hidden by nothing: neither by a sensor nor by the legends along the picture's edges.
fn seen(world: &World) -> Vec<Seen> {
    let view_px = SIZE.map(f64::from);
    let project = |point: &Point3<f64>| camera().project(point, view_px).unwrap();
    let design = world.document.design();
    let sensors: Vec<[f64; 2]> = BodyRole::ALL
        .into_iter()
        .filter_map(|role| Some((design.body(role)?, design.tracker_from_body(role)?)))
        .flat_map(|(body, pose)| body.rigid.sensors.iter().map(move |s| pose * s.position_in_body))
        .map(|point| project(&point))
        .collect();
    let plan = slice_plan(&world.environment, &slice());
    let mut best: [Option<Seen>; POINTS] = [None; POINTS];
    for u in 1..plan.counts[0] - 1 {
        for v in 1..plan.counts[1] - 1 {
            let point_mm = plan.point_mm(u, v);
            let at = project(&point_mm);
            let is_free = (0..2).all(|k| (0.2..0.75).contains(&(at[k] / view_px[k])))
                && sensors.iter().all(|s| (s[0] - at[0]).hypot(s[1] - at[1]) > SENSOR_PX);
            if !is_free {
                continue;
            }
            let off_px = at.map(|p| p - p.floor() - 0.5);
            let seen = Seen {
                point_mm,
                pixel: at.map(|p| p as usize),
                off_px: off_px[0].hypot(off_px[1]),
            };
            let best = &mut best[u * POINTS / plan.counts[0]];
            if best.is_none_or(|best| seen.off_px < best.off_px) {
                *best = Some(seen);
            }
        }
    }
    best.into_iter().flatten().collect()
}

/// The position error that `distort` gives at each point, for the sensor that the slice imagines.
fn distorted_mm(copy: &Copied, points: &[Seen]) -> Vec<f64> {
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &Vector3::from(slice().sensor_axis))
        .unwrap();
    let [qx, qy, qz, qw]: [f64; 4] = turn.coords.into();
    let mut table = "x,y,z,qw,qx,qy,qz\n".to_owned();
    for Seen { point_mm: p, .. } in points {
        table += &format!("{},{},{},{qw},{qx},{qy},{qz}\n", p.x, p.y, p.z);
    }
    let (ideal, measured) = (copy.path("ideal.csv"), copy.path("measured.csv"));
    std::fs::write(&ideal, table).unwrap();
    let environment = copy.path("assets/environments/operating-table.env.ron");
    succeed(&["distort", &text(&environment), &text(&ideal), "-o", &text(&measured)]);
    let measured = std::fs::read_to_string(measured).unwrap();
    let position = |row: &str| {
        let cells: Vec<f64> = row.split(',').take(3).map(|cell| cell.parse().unwrap()).collect();
        Point3::from_slice(&cells)
    };
    let rows: Vec<_> = measured.lines().skip(1).map(position).collect();
    assert_eq!(rows.len(), points.len());
    rows.iter().zip(points).map(|(row, seen)| (row - seen.point_mm).norm()).collect()
}

#[test]
fn slice_pixels_have_the_colours_of_distort() {
    let copy = Copied::new("pointer-on-head");
    copy.change_view(|view| {
        view.slice = slice();
        view.camera = Some(camera().into());
    });
    let world = trackwright_project::open_design(&copy.design).unwrap();
    let points = seen(&world);
    assert_eq!(points.len(), POINTS);
    let size = format!("{}x{}", SIZE[0], SIZE[1]);
    let picture = render(&copy, &size, &["--layers", "slice"]);
    let errors_mm = distorted_mm(&copy, &points);
    let mut colors = Vec::new();
    for (seen, error_mm) in points.iter().zip(&errors_mm) {
        assert!(*error_mm < RANGE_MM, "{error_mm} mm is beyond the colour bar");
        let wanted = ColorMap::Viridis.srgb_of_value(*error_mm, RANGE_MM);
        let found = picture.at(seen.pixel);
        assert!(is_near(found, wanted, 2), "{found:?}, not {wanted:?}: {error_mm} mm at {seen:?}");
        colors.push(wanted);
    }
    colors.dedup();
    assert_eq!(colors.len(), POINTS, "points of the same colour show less");
}

#[test]
fn a_facing_slice_is_hatched_outside_the_box() {
    let copy = Copied::new("pointer-on-head");
    let oblique = OrbitCamera {
        // In front of all bodies.
        focus_mm: Point3::new(130.0, 110.0, -390.0),
        distance_mm: 1000.0,
        azimuth_rad: 0.75,
        elevation_rad: 0.5,
        projection: Projection::Perspective,
    };
    let bounds = {
        let world = trackwright_project::open_design(&copy.design).unwrap();
        *world.environment.model.bounds()
    };
    let mut wanted = slice();
    wanted.face(&oblique, &bounds);
    copy.change_view(|view| {
        view.slice = wanted;
        view.camera = Some(oblique.into());
    });
    let world = trackwright_project::open_design(&copy.design).unwrap();
    let plan = slice_plan(&world.environment, &wanted);
    let size = format!("{}x{}", SIZE[0], SIZE[1]);
    let picture = render(&copy, &size, &["--layers", "slice"]);
    let sensors: Vec<[f64; 2]> = BodyRole::ALL
        .into_iter()
        .filter_map(|role| {
            let design = world.document.design();
            Some((design.body(role)?, design.tracker_from_body(role)?))
        })
        .flat_map(|(body, pose)| {
            let sensors = body.rigid.sensors.iter();
            sensors.map(move |s| pose * s.position_in_body)
        })
        .filter_map(|point| oblique.project(&point, SIZE.map(f64::from)))
        .collect();
    let grey = |color: [u8; 3]| {
        (0..3).all(|k| {
            let ends = [NO_VALUE_SRGB[k], NO_VALUE_LINE_SRGB[k]];
            (ends[0] - 3..=ends[1] + 3).contains(&color[k])
        })
    };
    let (mut inside, mut plain, mut lines) = (0, 0, 0);
    for u in 1..plan.counts[0] - 1 {
        for v in 1..plan.counts[1] - 1 {
            let at = plan.point_mm(u, v);
            let Some([x, y]) = oblique.project(&at, SIZE.map(f64::from)) else { continue };
            let is_free = (0.2..0.75).contains(&(x / f64::from(SIZE[0])))
                && (0.2..0.75).contains(&(y / f64::from(SIZE[1])))
                && sensors.iter().all(|s| (s[0] - x).hypot(s[1] - y) > SENSOR_PX);
            // Neighbours on the other side of the box mix into one pixel.
            let around = [(-1, -1), (-1, 1), (1, -1), (1, 1)].map(|(i, j)| {
                let place = |at: usize, by: isize| at.wrapping_add_signed(by);
                bounds.contains(&plan.point_mm(place(u, i), place(v, j)))
            });
            if !is_free || around.iter().any(|inside| *inside != around[0]) {
                continue;
            }
            let color = picture.at([x as usize, y as usize]);
            assert_eq!(grey(color), !around[0], "{color:?} at {x:.0} {y:.0}");
            match around[0] {
                true => inside += 1,
                false if is_near(color, NO_VALUE_SRGB, 6) => plain += 1,
                false => lines += 1,
            }
        }
    }
    assert!(inside > 200, "{inside} inside");
    assert!(lines > 20 && plain > lines, "{plain} grey, {lines} lines");
}
