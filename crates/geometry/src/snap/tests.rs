use super::*;
use crate::orbit::{AxisEnd, OrbitCamera, Projection};
use crate::surface::tests::cylinder;
use nalgebra::UnitQuaternion;
use std::f64::consts::TAU;

const RADIUS_MM: f64 = 1.5;
const LENGTH_MM: f64 = 80.0;
const SIDES: u32 = 24;

/// A round shaft along z from the origin, beside z by `at_mm`.
fn shaft(at_mm: Vector3<f64>) -> SurfaceMesh {
    let mut mesh = cylinder(RADIUS_MM, LENGTH_MM, SIDES);
    mesh.parts[0].positions_mm.iter_mut().for_each(|at| *at += at_mm);
    mesh
}

fn eye(end: AxisEnd, projection: Projection) -> Eye {
    let mut camera = OrbitCamera {
        focus_mm: Point3::new(0.0, 0.0, LENGTH_MM / 2.0),
        distance_mm: 400.0,
        azimuth_rad: 0.0,
        elevation_rad: 0.0,
        projection,
    };
    camera.look_from(end);
    Eye { camera, view_px: [900.0, 600.0] }
}

fn points(mesh: &SurfaceMesh) -> SnapPoints {
    SnapPoints::of(mesh, Surface::new(mesh).as_ref())
}

fn ends(mesh: &SurfaceMesh) -> Vec<Point3<f64>> {
    let points = points(mesh);
    let ends = points.iter().filter(|point| point.kind == SnapKind::ShaftEnd);
    ends.map(|point| point.at_mm).collect()
}

const SIDE: AxisEnd = AxisEnd::new(crate::orbit::Axis::X, true);

/// What a pointer so far from the pixel of a point snaps to.
fn snapped(mesh: &SurfaceMesh, eye: &Eye, at: Point3<f64>, by_px: [f64; 2]) -> Option<SnapPoint> {
    let [x, y] = eye.camera.project(&at, eye.view_px).unwrap();
    let ray = eye.camera.ray([x + by_px[0], y + by_px[1]], eye.view_px);
    points(mesh).under(&ray, eye, &Surface::new(mesh).unwrap())
}

#[test]
fn the_shaft_end_is_the_end_of_its_axis() {
    let at_mm = Vector3::new(3.0, -2.0, 0.0);
    let ends = ends(&shaft(at_mm));
    assert_eq!(ends.len(), 2);
    for (end, z) in ends.iter().zip([LENGTH_MM, 0.0]) {
        let off_mm = (end - Point3::from(at_mm) - Vector3::z() * z).norm();
        assert!(off_mm < 1e-12, "{off_mm}");
    }
}

#[test]
fn a_slanted_shaft_ends_on_its_axis() {
    // Its longest side is along z, its axis is not.
    let turn = UnitQuaternion::from_euler_angles(0.3, -0.4, 0.0);
    let mut mesh = shaft(Vector3::zeros());
    let part = &mut mesh.parts[0];
    for at in &mut part.positions_mm {
        *at = turn * *at;
    }
    for normal in &mut part.normals {
        *normal = turn * *normal;
    }
    let ends = ends(&mesh);
    assert_eq!(ends.len(), 2);
    for (end, z) in ends.iter().zip([LENGTH_MM, 0.0]) {
        let off_mm = (end - turn * Point3::new(0.0, 0.0, z)).norm();
        assert!(off_mm < 1e-9, "{off_mm}");
    }
}

#[test]
fn each_place_is_one_point() {
    let mut mesh = shaft(Vector3::zeros());
    mesh.parts.push(mesh.parts[0].clone());
    assert_eq!(points(&mesh).iter().count(), 2 + 2 + 2 * SIDES as usize);
}

#[test]
fn rims_are_edges_and_the_middle_of_a_face_is_none() {
    let mesh = shaft(Vector3::zeros());
    for point in points(&mesh).iter() {
        let is_rim = (point.at_mm.coords.xy().norm() - RADIUS_MM).abs() < 1e-9;
        assert_eq!(point.kind == SnapKind::EdgeEnd, is_rim, "{point:?}");
    }
}

#[test]
fn a_pointer_near_the_end_snaps_to_it() {
    let mesh = shaft(Vector3::zeros());
    let end = Point3::new(0.0, 0.0, LENGTH_MM);
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let eye = eye(SIDE, projection);
        let found = snapped(&mesh, &eye, end, [6.0, -4.0]).unwrap();
        assert_eq!(found.kind, SnapKind::ShaftEnd);
        assert!((found.at_mm - end).norm() < 1e-12);
        assert_eq!(snapped(&mesh, &eye, end, [40.0, 40.0]), None);
        let middle = Point3::new(0.0, 0.0, LENGTH_MM / 2.0);
        assert_eq!(snapped(&mesh, &eye, middle, [0.0, 0.0]), None);
    }
}

#[test]
fn a_hidden_corner_is_left_out() {
    let mesh = shaft(Vector3::zeros());
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let eye = eye(SIDE, projection);
        let surface = Surface::new(&mesh).unwrap();
        let ray = eye.camera.ray([450.0, 300.0], eye.view_px);
        // In the middle of a side's width, clear of the triangles' edges.
        let (sin, cos) = (TAU / f64::from(2 * SIDES)).sin_cos();
        let [x, y] = [cos, sin].map(|part| part * cos * RADIUS_MM);
        assert!(is_seen(&Point3::new(x, y, 47.0), &ray, &eye, &surface));
        assert!(!is_seen(&Point3::new(-x, y, 47.0), &ray, &eye, &surface));
    }
}

#[test]
fn a_vertex_between_smooth_faces_has_less_reach() {
    assert!(SnapKind::Vertex.reach_px() < SnapKind::EdgeEnd.reach_px());
    assert!(SnapKind::EdgeEnd.reach_px() < SnapKind::ShaftEnd.reach_px());
    assert!(points(&SurfaceMesh::default()).iter().next().is_none());
}
