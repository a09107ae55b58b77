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
use trackwright_editor::shell::window::{DragReadout, PointerHint, ViewportRect};
use trackwright_editor::viewport::camera::OrbitRig;
use trackwright_simulation::motion_outline::{HandlePath, MotionHandle, RangeEnd};

/// The axes of the built-in design, each with the same ranges.
const SHIFT_STEP_MM: f64 = 20.0;
const TURN_STEP_DEG: f64 = 15.0;

const LINES: &str = "range of motion";
const BALL: &str = "motion handle";

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
    let grid = design.motion.unwrap().grid(&design.tool.crf_from_tool);
    grid.unwrap().trials()
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
