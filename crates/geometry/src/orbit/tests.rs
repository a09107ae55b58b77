use super::*;

const VIEW: [f64; 2] = [900.0, 600.0];

fn camera() -> OrbitCamera {
    OrbitCamera {
        focus_mm: Point3::new(20.0, -10.0, -300.0),
        distance_mm: 800.0,
        azimuth_rad: 0.7,
        elevation_rad: 0.3,
        projection: Projection::Perspective,
    }
}

#[test]
fn tracker_minus_z_is_up_on_the_screen() {
    let pose = camera().tracker_from_camera();
    let m = pose.rotation.to_rotation_matrix();
    assert!((m.matrix().determinant() - 1.0).abs() < 1e-12);
    let above = camera().project(&Point3::new(20.0, -10.0, -350.0), VIEW).unwrap();
    assert!((above[0] - 450.0).abs() < 1e-9 && above[1] < 300.0, "{above:?}");
}

#[test]
fn projection_inverts_rays() {
    let point = Point3::new(60.0, 40.0, -250.0);
    let pixel = camera().project(&point, VIEW).unwrap();
    let ray = camera().ray(pixel, VIEW);
    let off = (point - ray.origin_mm).cross(&ray.direction).norm();
    assert!(off < 1e-9, "{off}");
    let behind = camera().tracker_from_camera() * Point3::new(0.0, 0.0, 1.0);
    assert!(camera().project(&behind, VIEW).is_none());
}

#[test]
fn panning_keeps_the_focus_under_the_pointer() {
    let mut moved = camera();
    moved.pan([120.0, -45.0], VIEW);
    let pixel = moved.project(&camera().focus_mm, VIEW).unwrap();
    assert!((pixel[0] - 570.0).abs() < 1e-6 && (pixel[1] - 255.0).abs() < 1e-6, "{pixel:?}");
}

#[test]
fn zooming_keeps_the_point_under_the_pointer() {
    let pointer = [700.0, 140.0];
    let normal = camera().tracker_from_camera().rotation * Vector3::z();
    let ray = camera().ray(pointer, VIEW);
    let point = ray.meets_plane(&camera().focus_mm, &normal).unwrap();
    let mut nearer = camera();
    nearer.zoom(4.0, pointer, VIEW);
    let pixel = nearer.project(&point, VIEW).unwrap();
    assert!(nearer.distance_mm < 500.0);
    assert!((pixel[0] - 700.0).abs() < 1e-6 && (pixel[1] - 140.0).abs() < 1e-6, "{pixel:?}");
}

#[test]
fn focusing_on_another_depth_changes_no_pixel() {
    let point = Point3::new(90.0, -60.0, -380.0);
    let pixel = camera().project(&point, VIEW).unwrap();
    let mut refocused = camera();
    refocused.refocus(&point);
    let same = refocused.project(&point, VIEW).unwrap();
    assert!((pixel[0] - same[0]).abs() < 1e-9 && (pixel[1] - same[1]).abs() < 1e-9);
    let depth = -(camera().tracker_from_camera().inverse() * point).z;
    assert!((refocused.distance_mm - depth).abs() < 1e-9);
}

#[test]
fn a_framed_sphere_fills_the_view_and_no_more() {
    let mut framed = camera();
    framed.frame_sphere(Point3::new(0.0, 0.0, -200.0), 50.0, VIEW);
    let rotation = framed.tracker_from_camera().rotation;
    let top = framed.focus_mm + rotation * Vector3::y() * 50.0;
    let y = framed.project(&top, VIEW).unwrap()[1];
    assert!((15.0..60.0).contains(&y), "{y}");
}

#[test]
fn orbiting_stops_at_the_poles() {
    let mut turned = camera();
    turned.orbit([600.0, 0.0], VIEW);
    assert!((wrap_angle(turned.azimuth_rad - 0.7).abs() - std::f64::consts::PI).abs() < 1e-9);
    turned.orbit([0.0, 5000.0], VIEW);
    assert_eq!(turned.elevation_rad, MAX_ELEVATION_RAD);
}

#[test]
fn a_whole_turn_is_exact() {
    let camera = camera();
    assert_eq!(camera.turned(1.0), camera.turned(0.0));
    assert_eq!(camera.turned(0.0), camera);
    let eye_mm = |camera: &OrbitCamera| camera.tracker_from_camera().translation.vector;
    let (front, back) = (eye_mm(&camera), eye_mm(&camera.turned(0.5)));
    // As high as before, and mirrored in the vertical through the focus.
    let focus_mm = camera.focus_mm.coords;
    let expected = 2.0 * focus_mm - front;
    assert!((back.xy() - expected.xy()).norm() < 1e-9 && (back.z - front.z).abs() < 1e-9);
    let quarter = camera.turned(0.25).turned(0.25);
    assert!((eye_mm(&quarter) - back).norm() < 1e-9);
}

#[test]
fn a_pixel_spans_what_the_projection_gives() {
    let point = Point3::new(60.0, 40.0, -250.0);
    let right = camera().tracker_from_camera().rotation * Vector3::x();
    let step = camera().mm_per_px(&point, VIEW).unwrap() * 10.0;
    let a = camera().project(&point, VIEW).unwrap();
    let b = camera().project(&(point + right * step), VIEW).unwrap();
    assert!((b[0] - a[0] - 10.0).abs() < 1e-9);
}

#[test]
fn screen_distances_are_to_the_segment() {
    let [a, b] = [Point3::new(20.0, 0.0, -300.0), Point3::new(60.0, 40.0, -250.0)];
    let [pa, pb] = [a, b].map(|p| camera().project(&p, VIEW).unwrap());
    let at = |t: f64| [pa[0] + (pb[0] - pa[0]) * t, pa[1] + (pb[1] - pa[1]) * t];
    let length = ((pb[0] - pa[0]).powi(2) + (pb[1] - pa[1]).powi(2)).sqrt();
    assert!(camera().distance_px(at(0.3), [a, b], VIEW).unwrap() < 1e-9);
    let beyond = camera().distance_px(at(1.5), [a, b], VIEW).unwrap();
    assert!((beyond - length / 2.0).abs() < 1e-9);
    assert!(camera().distance_px(pa, [a, a], VIEW).unwrap() < 1e-9);
}

#[test]
fn a_glide_takes_the_short_way_round() {
    let from = OrbitCamera { azimuth_rad: 3.0, ..camera() };
    let to = OrbitCamera { azimuth_rad: -3.0, ..camera() };
    let middle = from.towards(&to, 0.5);
    assert!((middle.azimuth_rad.abs() - std::f64::consts::PI).abs() < 1e-9);
    assert!(
        (from.towards(&to, 1.0).project(&Point3::origin(), VIEW).unwrap()[0]
            - to.project(&Point3::origin(), VIEW).unwrap()[0])
            .abs()
            < 1e-9
    );
}

fn orthographic() -> OrbitCamera {
    OrbitCamera { projection: Projection::Orthographic, ..camera() }
}

#[test]
fn orthographic_rays_are_parallel_and_project_back() {
    let camera = orthographic();
    let point = Point3::new(60.0, 40.0, -250.0);
    let pixel = camera.project(&point, VIEW).unwrap();
    let ray = camera.ray(pixel, VIEW);
    assert!((point - ray.origin_mm).cross(&ray.direction).norm() < 1e-8);
    assert_eq!(camera.ray([0.0, 0.0], VIEW).direction, camera.ray([900.0, 600.0], VIEW).direction);
}

#[test]
fn orthographic_scale_is_the_same_at_each_depth() {
    let camera = orthographic();
    let back = camera.tracker_from_camera().rotation * Vector3::z();
    let right = camera.tracker_from_camera().rotation * Vector3::x();
    for depth_mm in [-2000.0, 0.0, 900.0] {
        let near = camera.focus_mm + back * depth_mm;
        let [a, b] = [near, near + right * 30.0].map(|p| camera.project(&p, VIEW).unwrap());
        let per_px = camera.mm_per_px(&near, VIEW).unwrap();
        assert!(((b[0] - a[0]) * per_px - 30.0).abs() < 1e-8);
        assert!((per_px - camera.view_height_mm() / VIEW[1]).abs() < 1e-12);
    }
}

#[test]
fn the_projection_changes_nothing_at_the_focus() {
    let right = camera().tracker_from_camera().rotation * Vector3::x();
    let point = camera().focus_mm + right * 70.0;
    let [a, b] = [camera(), orthographic()].map(|c| c.project(&point, VIEW).unwrap());
    assert!((a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6, "{a:?} {b:?}");
}

#[test]
fn orthographic_zoom_and_pan_keep_the_point() {
    let pointer = [700.0, 140.0];
    let point = orthographic().ray(pointer, VIEW).at(ORTHOGRAPHIC_EYE_MM - 120.0);
    let mut nearer = orthographic();
    nearer.refocus(&point);
    let same = nearer.project(&point, VIEW).unwrap();
    assert!((same[0] - 700.0).abs() < 1e-6 && (same[1] - 140.0).abs() < 1e-6, "{same:?}");
    nearer.zoom(4.0, pointer, VIEW);
    let pixel = nearer.project(&point, VIEW).unwrap();
    assert!((pixel[0] - 700.0).abs() < 1e-6 && (pixel[1] - 140.0).abs() < 1e-6, "{pixel:?}");
    nearer.pan([12.0, -30.0], VIEW);
    let pixel = nearer.project(&point, VIEW).unwrap();
    assert!((pixel[0] - 712.0).abs() < 1e-6 && (pixel[1] - 110.0).abs() < 1e-6, "{pixel:?}");
}

#[test]
fn an_orthographic_frame_holds_the_sphere() {
    let mut framed = orthographic();
    framed.frame_sphere(Point3::new(0.0, 0.0, -200.0), 50.0, VIEW);
    assert!((framed.view_height_mm() - 2.0 * 50.0 * FRAME_MARGIN).abs() < 1e-9);
}

#[test]
fn the_view_from_an_end_has_it_towards_the_viewer() {
    for end in AxisEnd::ALL {
        let mut turned = camera();
        turned.look_from(end);
        let [right, down, near] = turned.on_screen(&end.unit());
        assert!((near - 1.0).abs() < 1e-12, "{end:?}: {right} {down} {near}");
        let back = turned.tracker_from_camera().rotation * Vector3::z();
        assert!((back - end.unit().into_inner()).norm() < 1e-12, "{end:?}");
    }
}
