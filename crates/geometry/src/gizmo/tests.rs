use super::*;
use crate::orbit::Projection;
use crate::pose::pose_from_parts;
use nalgebra::UnitQuaternion;

fn eye() -> Eye {
    Eye {
        camera: OrbitCamera {
            focus_mm: Point3::new(20.0, -10.0, -300.0),
            distance_mm: 800.0,
            azimuth_rad: 0.7,
            elevation_rad: 0.3,
            projection: Projection::Perspective,
        },
        view_px: [900.0, 600.0],
    }
}

fn gizmo() -> Gizmo {
    Gizmo {
        tracker_from_gizmo: pose_from_parts(
            Vector3::new(35.0, 5.0, -280.0),
            UnitQuaternion::from_euler_angles(0.1, -0.2, 0.15),
        ),
        handles: Handle::ALL,
    }
}

fn ray(pixel: [f64; 2]) -> Ray {
    eye().camera.ray(pixel, eye().view_px)
}

fn pixel(point: &Point3<f64>) -> [f64; 2] {
    eye().camera.project(point, eye().view_px).unwrap()
}

#[test]
fn every_handle_is_under_its_own_grip() {
    for k in 0..40 {
        let mut eye = eye();
        eye.camera.azimuth_rad = f64::from(k) * 0.41;
        eye.camera.elevation_rad = (f64::from(k) * 1.7).sin() * 1.2;
        eye.camera.distance_mm = 60.0 + 90.0 * f64::from(k);
        let usable = gizmo().handles.iter();
        let usable = usable.filter(|handle| gizmo().is_usable(**handle, &eye));
        let gripped = usable.clone().filter(|handle| gizmo().grip_px(**handle, &eye).is_some());
        // Two rings may lie over each other on the screen, and then one of them hides the other.
        assert!(gripped.count() + 1 >= usable.count(), "{k}");
    }
}

#[test]
fn a_handle_keeps_its_size_on_the_screen() {
    for distance_mm in [100.0, 800.0, 4000.0] {
        let mut eye = eye();
        eye.camera.distance_mm = distance_mm;
        eye.camera.focus_mm = gizmo().pivot_mm();
        let [x, y] = eye.camera.project(&gizmo().pivot_mm(), eye.view_px).unwrap();
        // A ring's silhouette is a little larger than its radius, which perspective adds.
        let beside = (0..64)
            .map(|k| f64::from(k) * TAU / 64.0)
            .map(|a| [x + RING_PX * a.cos(), y + RING_PX * a.sin()])
            .filter(|at| gizmo().under(*at, &eye).is_some())
            .count();
        assert!((4..64).contains(&beside), "{beside}");
        let far = [x + 140.0, y + 140.0];
        assert_eq!(gizmo().under(far, &eye), None);
        assert_eq!(gizmo().under([x, y], &eye), None, "the middle stays free");
    }
}

#[test]
fn an_arrow_follows_the_pointer() {
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        let arrow = Handle::arrow(axis);
        let direction = gizmo().axis(axis);
        let on_axis = |mm: f64| pixel(&(gizmo().pivot_mm() + direction.into_inner() * mm));
        let mut drag = HandleDrag::new(&gizmo(), arrow, &ray(on_axis(40.0)), &eye()).unwrap();
        for wanted_mm in [-25.0, 0.0, 12.5, 60.0] {
            let movement = drag.movement_at(&ray(on_axis(40.0 + wanted_mm))).unwrap();
            let Movement::Slide { direction: d, by_mm } = movement else { panic!("{movement:?}") };
            assert_eq!(d, direction);
            assert!((by_mm - wanted_mm).abs() < 1e-7, "{by_mm} {wanted_mm}");
        }
    }
}

#[test]
fn a_ring_turns_past_half_a_turn() {
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        let at = |angle_rad: f64| pixel(&gizmo().on_ring(axis, angle_rad, 30.0));
        let start = ray(at(0.4));
        assert!(start.direction.dot(&gizmo().axis(axis)).abs() > EDGE_ON);
        let mut drag = HandleDrag::new(&gizmo(), Handle::ring(axis), &start, &eye()).unwrap();
        for step in 1..=90 {
            let wanted_rad = f64::from(step) * 0.1;
            let movement = drag.movement_at(&ray(at(0.4 + wanted_rad))).unwrap();
            let Movement::Turn { by_rad, .. } = movement else { panic!("{movement:?}") };
            assert!((by_rad - wanted_rad).abs() < 1e-7, "{by_rad} {wanted_rad}");
        }
    }
}

#[test]
fn a_ring_on_its_edge_turns_along_its_tangent() {
    // Looked at along y: the ring around z is a line.
    let mut eye = eye();
    eye.camera.look_along(Axis::Y);
    eye.camera.focus_mm = Point3::origin();
    let gizmo = Gizmo { tracker_from_gizmo: Pose::identity(), handles: Handle::ALL };
    let ray = |x: f64| {
        let [middle_x, middle_y] = eye.view_px.map(|side| side / 2.0);
        eye.camera.ray([middle_x + x, middle_y], eye.view_px)
    };
    let ring = Handle::ring(Axis::Z);
    let mut drag = HandleDrag::new(&gizmo, ring, &ray(0.0), &eye).unwrap();
    let turned = |drag: &mut HandleDrag, x: f64| match drag.movement_at(&ray(x)) {
        Some(Movement::Turn { by_rad, .. }) => by_rad,
        other => panic!("{other:?}"),
    };
    assert_eq!(turned(&mut drag, 0.0), 0.0);
    // As far as the radius is a radian; what is nearer than the pivot is larger by perspective.
    let radian = turned(&mut drag, RING_PX);
    assert!((radian.abs() - 1.0).abs() < 0.1, "{radian}");
    assert!((turned(&mut drag, -RING_PX) + radian).abs() < 1e-9);
    // The side that is seen goes where the pointer goes.
    let front = drag_point(&drag);
    let moved = Movement::Turn {
        axis: Vector3::z_axis(),
        pivot_mm: Point3::origin(),
        by_rad: turned(&mut drag, 10.0),
    };
    let after = moved.rotation() * front;
    let [before_px, after_px] =
        [front, after].map(|p| eye.camera.project(&p, eye.view_px).unwrap());
    assert!(after_px[0] > before_px[0]);
}

fn drag_point(drag: &HandleDrag) -> Point3<f64> {
    match &drag.grip {
        Grip::Tangent { point_mm, .. } => *point_mm,
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_arrow_towards_the_viewer_is_unusable() {
    let mut eye = eye();
    eye.camera.look_along(Axis::X);
    let gizmo = Gizmo {
        tracker_from_gizmo: Pose::from_parts(
            eye.camera.focus_mm.coords.into(),
            UnitQuaternion::identity(),
        ),
        handles: Handle::ALL,
    };
    let middle = eye.view_px.map(|side| side / 2.0);
    let arrow = Handle::arrow(Axis::X);
    assert!(!gizmo.is_usable(arrow, &eye));
    assert_eq!(gizmo.distance_px(arrow, middle, &eye), None);
    assert_eq!(gizmo.grip_px(arrow, &eye), None);
    assert!(gizmo.is_usable(Handle::arrow(Axis::Y), &eye));
    assert!(gizmo.arrow_end_px(Axis::X, &eye).is_none());
}
