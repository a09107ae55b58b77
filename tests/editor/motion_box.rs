//! The range of motion in the scene: its lines, and its balls under the pointer.

use super::app::{change_view, named, settle};
use super::pointer::SimulatedPointer;
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use nalgebra::{Point3, UnitQuaternion};
use trackwright_design::{BodyRole, Design, Edit};
use trackwright_editor::document::requests::{ActiveDrag, EditRequest};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::layers::motion::MotionBall;
use trackwright_editor::layers::pivot_ball::PivotBall;
use trackwright_editor::shell::window::{DragReadout, PointerHint, ViewportRect};
use trackwright_editor::viewport::ball_handle::BallHandle;
use trackwright_editor::viewport::camera::OrbitRig;
use trackwright_simulation::motion_outline::{HandlePath, MotionHandle, RangeEnd};
use trackwright_simulation::{Motion, Pivot, shaft_in_body};

/// The axes of the built-in design, each with the same ranges.
const SHIFT_STEP_MM: f64 = 20.0;
const TURN_STEP_DEG: f64 = 15.0;

const LINES: &str = "range of motion";
const BALL: &str = "motion handle";
const PIVOT: &str = "pivot handle";

/// With the layer on.
fn pointer() -> SimulatedPointer {
    let mut pointer = SimulatedPointer::new();
    change_view(&mut pointer.app, |view| view.layers.motion = true);
    pointer
}

fn handles(pointer: &mut SimulatedPointer) -> Vec<MotionHandle> {
    let world = pointer.app.world_mut();
    let mut balls = world.query::<&MotionBall>();
    balls.iter(world).map(|ball| ball.0).collect()
}

fn pixel(pointer: &SimulatedPointer, point_mm: &Point3<f64>) -> Vec2 {
    let (rig, view) = (pointer.resource::<OrbitRig>(), pointer.resource::<ViewportRect>());
    let [x, y] = rig.camera.project(point_mm, rig.view_px).unwrap();
    view.min + Vec2::new(x as f32, y as f32)
}

/// Where a handle is once its value is so much larger.
fn ahead(handle: &MotionHandle, by: f64) -> Point3<f64> {
    match handle.path {
        HandlePath::Line(along) => handle.at_mm + along.into_inner() * by,
        HandlePath::Circle { center_mm, axis } => {
            let turn = UnitQuaternion::from_axis_angle(&axis, by.to_radians());
            center_mm + turn * (handle.at_mm - center_mm)
        }
    }
}

/// Of the shifts or the turns, the upper end that moves most on the screen, and the pixels from it
/// to where its value is so much larger.
fn upper_end(
    pointer: &mut SimulatedPointer,
    axes: std::ops::Range<usize>,
    by: f64,
) -> (MotionHandle, Vec2, Vec2) {
    handles(pointer)
        .into_iter()
        .filter(|h| axes.contains(&h.axis) && h.end == RangeEnd::Max)
        .map(|h| {
            let from = pixel(pointer, &h.at_mm);
            (h, from, pixel(pointer, &ahead(&h, by)) - from)
        })
        .max_by(|a, b| a.2.length().total_cmp(&b.2.length()))
        .unwrap()
}

fn with_upper_end(before: &Design, axis: usize, by: f64) -> Design {
    let motion = before.motion.unwrap();
    let mut range = motion.axes()[axis].1.unwrap();
    range.max += by;
    Design { motion: Some(motion.with_axis(axis, Some(range))), ..before.clone() }
}

fn trials(design: &Design) -> usize {
    design.motion.unwrap().trials().unwrap()
}

#[test]
fn a_dragged_ball_moves_its_end_in_one_step() {
    for (axes, step, counts) in [(0..3, SHIFT_STEP_MM, (3, 4)), (3..6, TURN_STEP_DEG, (5, 6))] {
        let mut pointer = pointer();
        let before = pointer.design();
        let (handle, at, by) = upper_end(&mut pointer, axes, 1.1 * step);
        pointer.drag(at, by, PointerButton::Primary);
        assert_eq!(*pointer.resource::<ActiveDrag>(), ActiveDrag(true));
        let text = pointer.resource::<DragReadout>().0.clone().unwrap().text;
        assert!(text.contains(" to +") && text.ends_with(" poses"), "{text}");
        pointer.release(at + by, PointerButton::Primary);
        assert_eq!(pointer.design(), with_upper_end(&before, handle.axis, step));
        assert_eq!(trials(&pointer.design()) * counts.0, trials(&before) * counts.1);
        // The ball went along.
        settle(&mut pointer.app);
        let mut now = handles(&mut pointer).into_iter();
        let now = now.find(|h| (h.axis, h.end) == (handle.axis, handle.end));
        let expected = ahead(&handle, step);
        assert!((now.unwrap().at_mm - expected).norm() < 1e-9);
        assert_eq!(*pointer.resource::<ActiveDrag>(), ActiveDrag(false));
        assert_eq!(pointer.resource::<DragReadout>().0, None);
        assert_eq!(pointer.undo_label().as_deref(), Some("Set range of motion"));
        pointer.request(EditRequest::Undo);
        assert_eq!(pointer.design(), before);
        assert_eq!(pointer.undo_label(), None);
    }
}

#[test]
fn with_control_an_end_is_rounded_to_a_millimetre() {
    let mut pointer = pointer();
    let before = pointer.design();
    let (handle, at, by) = upper_end(&mut pointer, 0..3, 7.2);
    pointer.hold(KeyCode::ControlLeft);
    pointer.drag(at, by, PointerButton::Primary);
    pointer.release(at + by, PointerButton::Primary);
    assert_eq!(pointer.design(), with_upper_end(&before, handle.axis, 7.0));
}

#[test]
fn with_shift_an_end_moves_finely() {
    let mut pointer = pointer();
    let before = pointer.design();
    let (handle, at, by) = upper_end(&mut pointer, 0..3, 1.4 * SHIFT_STEP_MM);
    pointer.drag(at, by, PointerButton::Primary);
    pointer.hold(KeyCode::ShiftLeft);
    // All the way back counts for a tenth, which is less than a step.
    for back in [0.05, 1.0] {
        pointer.move_to(at + by * (1.0 - back));
        pointer.app.update();
    }
    pointer.release(at, PointerButton::Primary);
    assert_eq!(pointer.design(), with_upper_end(&before, handle.axis, SHIFT_STEP_MM));
}

#[test]
fn the_status_line_explains_the_end() {
    let mut pointer = pointer();
    let (handle, at, _) = upper_end(&mut pointer, 3..6, TURN_STEP_DEG);
    pointer.move_to(at);
    pointer.app.update();
    let hint = pointer.resource::<PointerHint>().0.clone().unwrap();
    let name = ["x", "y", "z", "rx", "ry", "rz"][handle.axis];
    assert!(hint.contains(&format!("the turn {name} ends")) && hint.contains("5°"), "{hint}");
    pointer.move_to(at + Vec2::new(0.0, 300.0));
    pointer.app.update();
    assert_eq!(pointer.resource::<PointerHint>().0, None);
}

#[test]
fn escape_leaves_the_motion_as_it_was_to_the_bit() {
    let mut pointer = pointer();
    let before = pointer.design();
    let (_, at, by) = upper_end(&mut pointer, 0..3, 2.2 * SHIFT_STEP_MM);
    pointer.drag(at, by, PointerButton::Primary);
    assert_ne!(pointer.design(), before);
    pointer.assert_escape_restores(&before, at + by * 2.0);
}

#[test]
fn a_press_that_hardly_moves_changes_nothing() {
    let mut pointer = pointer();
    let before = pointer.design();
    let (_, at, _) = upper_end(&mut pointer, 0..3, SHIFT_STEP_MM);
    pointer.click(at);
    assert_eq!(pointer.resource::<Selection>().primary(), None);
    pointer.drag(at, Vec2::splat(1.5), PointerButton::Primary);
    pointer.release(at + Vec2::splat(1.5), PointerButton::Primary);
    assert_eq!((pointer.design(), pointer.undo_label()), (before, None));
}

#[test]
fn balls_need_the_layer_and_a_motion() {
    let mut pointer = pointer();
    let there = |pointer: &mut SimulatedPointer| {
        (named(&mut pointer.app, LINES), named(&mut pointer.app, BALL))
    };
    assert_eq!(there(&mut pointer), (1, 12));
    pointer.select(Some(Selected::Body(BodyRole::Tool)));
    assert_eq!(there(&mut pointer), (1, 0));
    pointer.select(None);
    change_view(&mut pointer.app, |view| view.layers.motion = false);
    assert_eq!(there(&mut pointer), (0, 0));
    change_view(&mut pointer.app, |view| view.layers.motion = true);
    assert_eq!(there(&mut pointer), (1, 12));
    pointer.request(EditRequest::Apply(Edit::SetMotion(None)));
    settle(&mut pointer.app);
    assert_eq!(there(&mut pointer), (0, 0));
}

/// Of the ball in the scene.
fn pivot_mm(pointer: &mut SimulatedPointer) -> Point3<f64> {
    let world = pointer.app.world_mut();
    let mut balls = world.query_filtered::<&BallHandle, With<PivotBall>>();
    balls.single(world).unwrap().at_mm
}

/// What trials without a shift leave where it is, tracker frame.
fn fixed_mm(design: &Design) -> Point3<f64> {
    let tool = &design.tool;
    let motion = design.motion.unwrap();
    let tip_in_tool = tool.body.rigid.judged_tip_in_body();
    let in_tool = motion.pivot.in_body(&tip_in_tool, &tool.crf_from_tool);
    let grid = motion.grid(&tool.crf_from_tool, &tip_in_tool).unwrap();
    let turned = grid.moved([0.0, 0.0, 0.0, 20.0, -10.0, 5.0]) * in_tool;
    assert!((turned - tool.crf_from_tool * in_tool).norm() < 1e-9);
    design.tracker_from_body(BodyRole::Crf).unwrap() * turned
}

#[test]
fn a_dragged_pivot_stays_what_it_is_a_point_of() {
    for pivot in [Pivot::Origin, Pivot::Tip, Pivot::Reference([-10.0, 5.0, 60.0])] {
        let mut pointer = pointer();
        let motion = Motion { pivot, ..pointer.design().motion.unwrap() };
        pointer.request(EditRequest::Apply(Edit::SetMotion(Some(motion))));
        settle(&mut pointer.app);
        let before = pointer.design();
        let from_mm = pivot_mm(&mut pointer);
        assert!((from_mm - fixed_mm(&before)).norm() < 1e-9);
        let (at, by) = (pixel(&pointer, &from_mm), Vec2::new(-30.0, -45.0));
        pointer.drag(at, by, PointerButton::Primary);
        let text = pointer.resource::<DragReadout>().0.clone().unwrap().text;
        pointer.release(at + by, PointerButton::Primary);
        settle(&mut pointer.app);
        let after = pointer.design();
        let moved = after.motion.unwrap().pivot;
        match pivot {
            Pivot::Reference(_) => assert!(matches!(moved, Pivot::Reference(_))),
            _ => assert!(matches!(moved, Pivot::Body(_))),
        }
        assert!(text.starts_with("pivot at ") && text.contains("mm of the "), "{text}");
        let to_mm = pivot_mm(&mut pointer);
        assert!((to_mm - fixed_mm(&after)).norm() < 1e-9);
        assert!((pixel(&pointer, &to_mm) - (at + by)).length() < 1.0);
        assert_eq!(pointer.undo_label().as_deref(), Some("Move pivot"));
        pointer.request(EditRequest::Undo);
        assert_eq!(pointer.design(), before);
    }
}

#[test]
fn with_control_a_pivot_stays_on_the_shaft() {
    let mut pointer = pointer();
    let body = pointer.design().tool.body.rigid;
    let (tip, shaft) = (body.judged_tip_in_body(), shaft_in_body(&body).unwrap());
    let tracker_from_tool = pointer.design().tracker_from_body(BodyRole::Tool).unwrap();
    let from_mm = pivot_mm(&mut pointer);
    let to_mm = tracker_from_tool * (tip + *shaft * 40.0);
    let at = pixel(&pointer, &from_mm);
    let by = pixel(&pointer, &to_mm) - at + Vec2::new(6.0, 0.0);
    pointer.hold(KeyCode::ControlLeft);
    pointer.drag(at, by, PointerButton::Primary);
    pointer.release(at + by, PointerButton::Primary);
    let pivot = Point3::from(pointer.design().motion.unwrap().pivot.point().unwrap());
    assert!((pivot - tip).cross(&shaft).norm() < 1e-9, "{pivot}");
    assert!(((pivot - tip).dot(&shaft) - 40.0).abs() < 10.0, "{pivot}");
}

#[test]
fn a_range_without_turns_has_no_pivot() {
    let mut pointer = pointer();
    assert_eq!(named(&mut pointer.app, PIVOT), 1);
    let motion = pointer.design().motion.unwrap();
    let shifts = (3..6).fold(motion, |motion, axis| motion.with_axis(axis, None));
    pointer.request(EditRequest::Apply(Edit::SetMotion(Some(shifts))));
    settle(&mut pointer.app);
    assert_eq!(named(&mut pointer.app, PIVOT), 0);
}
