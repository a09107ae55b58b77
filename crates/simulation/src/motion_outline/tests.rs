//! Lines against the trials they stand for, and handles under rays that point at them.

use super::*;
use crate::body::Sensor;
use crate::pivot::Pivot;
use nalgebra::UnitQuaternion;
use trackwright_geometry::bounds::Bounds;

fn range(min: f64, max: f64, step: f64) -> Option<AxisRange> {
    Some(AxisRange { min, max, step })
}

/// A tip that lies off the origin, and a sensor far behind it.
fn tool(tip: [f64; 3]) -> RigidBody {
    RigidBody {
        name: "probe".into(),
        tip_in_body: Some(tip.into()),
        sensors: vec![Sensor::six_dof("far", [5.0, 0.0, 150.0], UnitQuaternion::identity())],
    }
}

fn poses() -> (Pose, Pose) {
    let turn = |x, y, z| UnitQuaternion::from_euler_angles(x, y, z);
    (
        Pose::from_parts(Vector3::new(20.0, -30.0, 40.0).into(), turn(0.3, -0.8, 1.9)),
        Pose::from_parts(Vector3::new(-50.0, 10.0, -300.0).into(), turn(-0.5, 0.2, 0.4)),
    )
}

fn outline_of(motion: &Motion, tool: &RigidBody) -> MotionOutline {
    let (crf_from_tool, tracker_from_crf) = poses();
    motion_outline(motion, tool, &crf_from_tool, &tracker_from_crf).unwrap()
}

/// Where each trial has a point of the tool, tracker frame.
fn trials(motion: &Motion, tool: &RigidBody, point_in_tool: Point3<f64>) -> Vec<Point3<f64>> {
    let (crf_from_tool, tracker_from_crf) = poses();
    let grid = motion.grid(&crf_from_tool, &tool.judged_tip_in_body()).unwrap();
    (0..grid.trials()).map(|trial| tracker_from_crf * grid.pose(trial) * point_in_tool).collect()
}

fn has(points: &[Point3<f64>], point: &Point3<f64>) -> bool {
    points.iter().any(|p| (p - point).norm() < 1e-9)
}

#[test]
fn box_corners_are_tip_positions_of_extreme_trials() {
    // z's last trial is at 5, short of its end.
    let motion = Motion {
        x: range(-20.0, 40.0, 20.0),
        y: range(10.0, 30.0, 10.0),
        z: range(-5.0, 12.0, 10.0),
        ..Motion::default()
    };
    let tip = [3.0, -4.0, 5.0];
    let outline = outline_of(&motion, &tool(tip));
    assert_eq!(outline.edges.len(), 12);
    let tips = trials(&motion, &tool(tip), tip.into());
    let (_, tracker_from_crf) = poses();
    let in_crf = |p: &Point3<f64>| tracker_from_crf.inverse() * p;
    let around = |points: Vec<Point3<f64>>| Bounds::around(points.iter().map(in_crf)).unwrap();
    let corners: Vec<_> = outline.edges.iter().flatten().copied().collect();
    assert!(corners.iter().all(|corner| has(&tips, corner)));
    let (lines, visited) = (around(corners), around(tips));
    assert!((lines.min_mm - visited.min_mm).norm() < 1e-9);
    assert!((lines.max_mm - visited.max_mm).norm() < 1e-9);
    // 4, 3 and 2 values on the four edges along each axis.
    assert_eq!(outline.marks.len(), 4 * (4 + 3 + 2));
    assert_eq!(outline.handles.len(), 6);
    assert_eq!(outline.stems.len(), 1);
    let end = outline.stems[0].last().unwrap();
    let of_z = outline.handles[5];
    assert_eq!((of_z.axis, of_z.end), (2, RangeEnd::Max));
    assert!((of_z.at_mm - end).norm() < 1e-9);
    assert!((in_crf(end).z - visited.max_mm.z - 7.0).abs() < 1e-9);
}

#[test]
fn fixed_axes_reduce_the_box_to_a_rectangle_or_line() {
    let flat = Motion {
        x: range(-20.0, 20.0, 20.0),
        y: range(7.0, 7.0, 1.0),
        z: range(0.0, 10.0, 10.0),
        ..Motion::default()
    };
    let line = Motion { z: None, ..flat };
    let still = Motion { x: None, ..line };
    for (motion, edges, handles) in [(flat, 4, 4), (line, 1, 2), (still, 0, 0)] {
        let outline = outline_of(&motion, &tool([0.0; 3]));
        assert_eq!((outline.edges.len(), outline.handles.len()), (edges, handles));
        let tips = trials(&motion, &tool([0.0; 3]), Point3::origin());
        let ends = outline.edges.iter().flatten();
        assert!(ends.into_iter().all(|end| has(&tips, end)));
    }
}

#[test]
fn arc_ends_are_tip_positions_at_extreme_angles() {
    let pivots =
        [Pivot::Origin, Pivot::Body([5.0, -60.0, 10.0]), Pivot::Reference([9.0, 8.0, 7.0])];
    for (axis, name) in [(3, "rx"), (4, "ry"), (5, "rz")] {
        for pivot in pivots {
            let motion = Motion { pivot, ..Motion::default() };
            let motion = motion.with_axis(axis, range(-30.0, 50.0, 20.0));
            let tip = [30.0, -40.0, 55.0];
            let outline = outline_of(&motion, &tool(tip));
            let tips = trials(&motion, &tool(tip), tip.into());
            let fan = &outline.fans[0];
            assert_eq!((fan.axis, outline.fans.len()), (axis, 1));
            let ends = [fan.arc[0], fan.arc[fan.arc.len() - 1]];
            assert!((ends[0] - tips[0]).norm() < 1e-9, "{name}");
            assert!((ends[1] - tips[4]).norm() < 1e-9, "{name}");
            assert_eq!(fan.spokes.len(), 5);
            for ([_, end], tip) in fan.spokes.iter().zip(&tips) {
                assert!((end - tip).norm() < 1e-9);
            }
            for (handle, end) in outline.handles.iter().zip(&ends) {
                assert!((handle.at_mm - end).norm() < 1e-9);
            }
            assert!(outline.edges.is_empty() && outline.stems.is_empty());
        }
    }
}

#[test]
fn a_moved_pivot_is_where_it_was_moved_to() {
    let (crf_from_tool, tracker_from_crf) = poses();
    let there = Point3::new(-31.0, 4.0, -270.0);
    let in_crf = tracker_from_crf.inverse() * there;
    let turns = Motion { ry: range(-10.0, 10.0, 10.0), ..Motion::default() };
    for pivot in [Pivot::Origin, Pivot::Tip, Pivot::Body([1.0; 3]), Pivot::Reference([1.0; 3])] {
        let moved = pivot.moved_to(&in_crf, &crf_from_tool);
        let is_of_reference = |pivot| matches!(pivot, Pivot::Reference(_));
        assert_eq!(is_of_reference(moved), is_of_reference(pivot));
        let outline = outline_of(&Motion { pivot: moved, ..turns }, &tool([3.0, 2.0, 80.0]));
        assert!((outline.pivot_mm.unwrap() - there).norm() < 1e-9, "{pivot:?}");
    }
    assert_eq!(outline_of(&Motion::default(), &tool([0.0; 3])).pivot_mm, None);
}

#[test]
fn a_fan_of_a_fixed_tip_shows_the_farthest_sensor() {
    let motion = Motion { rx: range(-10.0, 10.0, 10.0), ..Motion::default() };
    let mut tool = tool([0.0; 3]);
    let sensor = tool.sensors[0].position_in_body;
    let ends = trials(&motion, &tool, sensor);
    let outline = outline_of(&motion, &tool);
    assert!((outline.fans[0].arc[0] - ends[0]).norm() < 1e-9);
    // Without one the angle is shown all the same.
    tool.sensors.clear();
    let outline = outline_of(&motion, &tool);
    let [pivot, end] = outline.fans[0].spokes[0];
    assert!(((end - pivot).norm() - PLACEHOLDER_ARM_MM).abs() < 1e-9);
}

/// From somewhere to a point.
fn ray_to(point: &Point3<f64>) -> Ray {
    let origin_mm = point + Vector3::new(300.0, -700.0, 400.0);
    Ray { origin_mm, direction: Unit::new_normalize(point - origin_mm) }
}

#[test]
fn dragging_a_handle_moves_only_its_end_in_steps() {
    let motion = Motion {
        x: range(-20.0, 20.0, 20.0),
        z: range(-7.0, 12.0, 10.0),
        ry: range(-30.0, 30.0, 15.0),
        ..Motion::default()
    };
    let tool = tool([30.0, -40.0, 55.0]);
    let outline = outline_of(&motion, &tool);
    let (crf_from_tool, tracker_from_crf) = poses();
    // Where the handle of an axis is while the axis is at a value: that of a motion to there.
    let handle = |motion: &Motion, axis, end| {
        let outline = motion_outline(motion, &tool, &crf_from_tool, &tracker_from_crf).unwrap();
        let mut handles = outline.handles.into_iter();
        handles.find(|h| h.axis == axis && h.end == end).unwrap()
    };
    for (axis, end, pointed_at, expected) in [
        (0, RangeEnd::Max, 55.0, 60.0),
        (0, RangeEnd::Max, -300.0, 0.0),
        (0, RangeEnd::Min, -69.0, -60.0),
        // The last trial is at 3, so the first is a whole number of steps before that.
        (2, RangeEnd::Min, -26.0, -27.0),
        (2, RangeEnd::Max, 20.0, 23.0),
        (4, RangeEnd::Max, 80.0, 75.0),
        (4, RangeEnd::Min, -50.0, -45.0),
        (4, RangeEnd::Min, 100.0, 15.0),
    ] {
        let held_at = handle(&motion, axis, end);
        assert!(outline.handles.contains(&held_at));
        let mut held = held_at.take(&motion, &ray_to(&held_at.at_mm)).unwrap();
        let before = motion.axes()[axis].1.unwrap();
        let with = |value| match end {
            RangeEnd::Min => AxisRange { min: value, ..before },
            RangeEnd::Max => AxisRange { max: value, ..before },
        };
        // The place on the handle's path that belongs to the value.
        let there = match held_at.path {
            HandlePath::Line(along) => {
                held_at.at_mm + along.into_inner() * (pointed_at - end.of(&before))
            }
            HandlePath::Circle { center_mm, axis } => {
                let angle = (pointed_at - end.of(&before)).to_radians();
                let turn = UnitQuaternion::from_axis_angle(&axis, angle);
                center_mm + turn * (held_at.at_mm - center_mm)
            }
        };
        let now = held.motion_at(&ray_to(&there), None).unwrap();
        assert_eq!(now, motion.with_axis(axis, Some(with(expected))));
        // Back where it was taken hold of, everything is as it was, but for an end that was short.
        let back = held.motion_at(&ray_to(&held_at.at_mm), None).unwrap();
        if axis != 2 {
            assert_eq!(back, motion);
        }
    }
}

#[test]
fn rounded_ends_are_whole_and_keep_one_in_the_range() {
    let given = AxisRange { min: -12.5, max: 20.0, step: 10.0 };
    let rounded = |end, value| with_end(given, end, value, Some(1.0), FARTHEST_MM);
    assert_eq!(rounded(RangeEnd::Max, 33.4).max, 33.0);
    assert_eq!(rounded(RangeEnd::Max, -40.0).max, -12.0);
    assert_eq!(rounded(RangeEnd::Min, -3.6).min, -4.0);
    assert_eq!(rounded(RangeEnd::Min, 90.0).min, 19.0);
    assert_eq!(rounded(RangeEnd::Max, 1e9).max, FARTHEST_MM - 12.0);
    let tenths = AxisRange { min: 0.0, max: 0.2, step: 0.1 };
    let longer = with_end(tenths, RangeEnd::Max, 0.31, None, FARTHEST_MM);
    assert_eq!(longer.max, 0.3);
}

#[test]
fn a_dragged_angle_grows_up_to_360_degrees() {
    let motion = Motion { rz: range(0.0, 90.0, 45.0), ..Motion::default() };
    let outline = outline_of(&motion, &tool([80.0, 0.0, 0.0]));
    let handle = outline.handles[1];
    let HandlePath::Circle { center_mm, axis } = handle.path else {
        panic!("a turn's handle moves on a circle");
    };
    let at = |angle_deg: f64| {
        let turn = UnitQuaternion::from_axis_angle(&axis, angle_deg.to_radians());
        let point = center_mm + turn * (handle.at_mm - center_mm);
        Ray { origin_mm: point + axis.into_inner() * 500.0, direction: -axis }
    };
    let mut held = handle.take(&motion, &at(0.0)).unwrap();
    let mut largest = 0.0;
    for moved in [60.0, 120.0, 180.0, 240.0, 300.0, 400.0] {
        let max = held.motion_at(&at(moved), None).unwrap().rz.unwrap().max;
        assert!(max >= largest, "{max} after {largest}");
        largest = max;
    }
    assert_eq!(largest, 360.0);
}

#[test]
fn a_fan_seen_edge_on_still_follows_the_pointer() {
    let motion = Motion { rz: range(0.0, 90.0, 10.0), ..Motion::default() };
    let tool = tool([80.0, 0.0, 0.0]);
    let identity = Pose::identity();
    let outline = motion_outline(&motion, &tool, &identity, &identity).unwrap();
    let handle = outline.handles[1];
    // The tip is at (0, 80, 0) there, seen from y: turning on takes it towards -x.
    let along =
        |x_mm: f64| Ray { origin_mm: Point3::new(x_mm, 500.0, 0.0), direction: -Vector3::y_axis() };
    let mut held = handle.take(&motion, &along(0.0)).unwrap();
    let now = held.motion_at(&along(-14.0), None).unwrap();
    // 14 mm of a circle with 80 mm are 10.03°.
    assert_eq!(now.rz.unwrap().max, 100.0);
}
