//! From the pointer to the document: picking, dragging, undoing, letting go.

use super::app::{change_view, named, settle};
use super::pointer::{SHAFT, SimulatedPointer};
use bevy::picking::pointer::{PointerAction, PointerButton};
use bevy::prelude::*;
use trackwright_design::view::{FreePlane, Layers};
use trackwright_design::{BodyRole, Thing, Things, View};
use trackwright_editor::document::requests::{ActiveDrag, EditRequest, OpenWorld, ViewRequest};
use trackwright_editor::document::selection::{Hovered, Selected, Selection};
use trackwright_editor::layers::slice::SliceHandle;
use trackwright_editor::scene::{BodyRoot, SensorMark};
use trackwright_editor::shell::window::{DragReadout, PointerHint, ViewportRect};
use trackwright_editor::viewport::camera::OrbitRig;
use trackwright_editor::viewport::scene_menu::SceneMenu;
use trackwright_editor::viewport::sensor_drag::FollowsSurface;

#[test]
fn a_drag_along_the_shaft_is_one_undo_step() {
    // Not so far that the handle begins, which is thicker.
    const PX: f32 = 15.0;
    let mut pointer = SimulatedPointer::new();
    let before = pointer.design();
    let start = pointer.position_mm(SHAFT);
    let (at, along) = pointer.shaft();
    pointer.drag(at, along * PX, PointerButton::Primary);
    assert_eq!(*pointer.app.world().resource::<ActiveDrag>(), ActiveDrag(true));
    assert!(pointer.app.world().resource::<DragReadout>().0.is_some());
    pointer.release(at + along * PX, PointerButton::Primary);
    let moved = pointer.position_mm(SHAFT) - start;
    let expected = {
        let rig = pointer.app.world().resource::<OrbitRig>();
        let pose = before.tracker_from_body(BodyRole::Tool).unwrap();
        rig.mm_per_px(&(pose * start)) * f64::from(PX)
    };
    // Along the shaft by what the pixels span, more where the shaft is seen at a slant; not
    // across it, as the sensor is on its axis.
    assert!(moved.z >= 0.9 * expected && moved.z < 3.0 * expected, "{moved}");
    assert!(moved.xy().norm() < 1e-9, "{moved}");
    assert_eq!(*pointer.app.world().resource::<ActiveDrag>(), ActiveDrag(false));
    assert_eq!(pointer.app.world().resource::<DragReadout>().0, None);
    assert_eq!(pointer.undo_label().as_deref(), Some("Move sensor shaft"));
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
    assert_eq!(pointer.undo_label(), None);
}

#[test]
fn a_dragged_sensor_keeps_its_axis() {
    let mut pointer = SimulatedPointer::new();
    let before = pointer.design();
    let (at, along) = pointer.shaft();
    // Onto the handle, whose surface is farther out and leans.
    pointer.drag(at, along * 90.0, PointerButton::Primary);
    pointer.release(at + along * 90.0, PointerButton::Primary);
    let [start, end] =
        [&before, &pointer.design()].map(|d| d.tool.body.rigid.sensors[SHAFT].clone());
    assert_eq!(end.orientation, start.orientation);
    let moved = end.position_in_body - start.position_in_body;
    assert!(moved.z > 10.0 && moved.xy().norm() < 1e-9, "{moved}");
}

#[test]
fn a_drag_that_follows_the_surface_turns_the_axis() {
    let mut pointer = SimulatedPointer::new();
    assert_eq!(pointer.resource::<PointerHint>().0, None);
    pointer.app.world_mut().resource_mut::<FollowsSurface>().0 = true;
    settle(&mut pointer.app);
    let hint = pointer.resource::<PointerHint>().0.clone().unwrap_or_default();
    assert!(hint.starts_with("Drags follow the surface"), "{hint}");
    let axis = |pointer: &SimulatedPointer| {
        pointer.design().tool.body.rigid.sensors[SHAFT].axis_in_body().unwrap()
    };
    let (start, (at, along)) = (axis(&pointer), pointer.shaft());
    pointer.press(at, PointerButton::Primary);
    // Up the collar and over the grip: somewhere there the surface leans.
    let mut largest = 0.0_f64;
    for step in 1..=24 {
        pointer.move_to(at + along * 5.0 * step as f32);
        pointer.app.update();
        largest = largest.max(axis(&pointer).angle(&start));
    }
    pointer.release(at + along * 120.0, PointerButton::Primary);
    assert!(largest > 0.01, "{largest}");
}

#[test]
fn selected_sensors_are_dragged_together() {
    const GRIP: usize = 1;
    let mut pointer = SimulatedPointer::new();
    let before = pointer.design();
    let both = Selection::of_sensors(BodyRole::Tool, [SHAFT, GRIP]);
    *pointer.app.world_mut().resource_mut::<Selection>() = both;
    let start = [SHAFT, GRIP].map(|index| pointer.position_mm(index));
    let (at, along) = pointer.shaft();
    pointer.drag(at, along * 15.0, PointerButton::Primary);
    pointer.release(at + along * 15.0, PointerButton::Primary);
    let moved = [pointer.position_mm(SHAFT) - start[0], pointer.position_mm(GRIP) - start[1]];
    assert!(moved[0].z > 1.0, "{moved:?}");
    assert!((moved[0] - moved[1]).norm() < 0.1, "{moved:?}");
    assert_eq!(pointer.undo_label().as_deref(), Some("Move 2 sensors"));
    let selection = pointer.app.world().resource::<Selection>();
    let shaft = Some(Selected::Sensor(BodyRole::Tool, SHAFT));
    assert_eq!(selection.primary(), shaft);
    let both = Some((BodyRole::Tool, vec![SHAFT, GRIP]));
    assert_eq!(selection.sensors(), both, "the click that ends a drag selects nothing");
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
}

#[test]
fn a_click_with_control_adds_to_what_is_selected() {
    let mut pointer = SimulatedPointer::new();
    *pointer.app.world_mut().resource_mut::<Selection>() =
        Selection::of(Some(Selected::Sensor(BodyRole::Tool, 1)));
    let (at, _) = pointer.shaft();
    pointer.press(at, PointerButton::Primary);
    pointer.app.world_mut().resource_mut::<ButtonInput<KeyCode>>().press(KeyCode::ControlLeft);
    pointer.release(at, PointerButton::Primary);
    let selection = pointer.app.world().resource::<Selection>();
    assert_eq!(selection.sensors(), Some((BodyRole::Tool, vec![SHAFT, 1])));
}

#[test]
fn what_is_hidden_or_locked_is_not_taken_hold_of() {
    type ThingsOf = fn(&mut View) -> &mut Things;
    let things: [ThingsOf; 2] = [|view| &mut view.hidden, |view| &mut view.locked];
    for things_of in things {
        for thing in [Thing::sensor(BodyRole::Tool, "shaft"), Thing::Tool] {
            let mut pointer = SimulatedPointer::new();
            let before = pointer.design();
            let mut view = View::default();
            things_of(&mut view).toggle(thing);
            pointer.app.world_mut().write_message(ViewRequest::Set(view));
            settle(&mut pointer.app);
            let (at, along) = pointer.shaft();
            pointer.drag(at, along * 15.0, PointerButton::Primary);
            pointer.release(at + along * 15.0, PointerButton::Primary);
            assert_eq!(pointer.design(), before);
        }
    }
}

#[test]
fn hidden_is_not_drawn_and_locked_is() {
    let mut pointer = SimulatedPointer::new();
    let mut view = View::default();
    view.hidden.toggle(Thing::sensor(BodyRole::Tool, "shaft"));
    view.hidden.toggle(Thing::Crf);
    view.locked.toggle(Thing::Tool);
    pointer.app.world_mut().write_message(ViewRequest::Set(view));
    settle(&mut pointer.app);
    let world = pointer.app.world_mut();
    let mut roots = world.query::<(&BodyRoot, &Visibility)>();
    for (root, visibility) in roots.iter(world) {
        let is_hidden = *visibility == Visibility::Hidden;
        assert_eq!(is_hidden, root.0 == BodyRole::Crf, "{root:?}");
    }
    let mut sensors = world.query::<(&SensorMark, &Visibility)>();
    for (mark, visibility) in sensors.iter(world) {
        let is_hidden = *visibility == Visibility::Hidden;
        let wanted = mark.body == BodyRole::Crf || mark.index == SHAFT;
        assert_eq!(is_hidden, wanted, "{mark:?}");
    }
}

#[test]
fn the_other_button_opens_a_sensor_menu() {
    let mut pointer = SimulatedPointer::new();
    let (at, _) = pointer.shaft();
    pointer.press(at, PointerButton::Secondary);
    pointer.release(at, PointerButton::Secondary);
    let shaft = Some(Selected::Sensor(BodyRole::Tool, SHAFT));
    assert_eq!(pointer.app.world().resource::<Selection>().primary(), shaft);
    assert_eq!(pointer.app.world().resource::<SceneMenu>().0, Some(at));
}

#[test]
fn escape_takes_a_drag_back_to_the_bit_and_lets_go() {
    let mut pointer = SimulatedPointer::new();
    let before = pointer.design();
    let (at, along) = pointer.shaft();
    pointer.drag(at, along * 30.0, PointerButton::Primary);
    assert_ne!(pointer.design(), before);
    pointer.app.world_mut().resource_mut::<ButtonInput<KeyCode>>().press(KeyCode::Escape);
    // Input is cleared at the start of an update, so the key goes in just before `Update`.
    pointer.app.world_mut().run_schedule(Update);
    assert_eq!(pointer.design(), before);
    pointer.move_to(at + along * 50.0);
    pointer.app.update();
    pointer.release(at + along * 50.0, PointerButton::Primary);
    assert_eq!(pointer.design(), before);
    assert_eq!(pointer.undo_label(), None);
}

#[test]
fn a_press_that_hardly_moves_only_selects() {
    let mut pointer = SimulatedPointer::new();
    let before = pointer.design();
    let (at, _) = pointer.shaft();
    pointer.press(at, PointerButton::Primary);
    pointer.move_to(at + Vec2::new(1.0, 1.0));
    pointer.app.update();
    pointer.release(at + Vec2::new(1.0, 1.0), PointerButton::Primary);
    let shaft = Some(Selected::Sensor(BodyRole::Tool, SHAFT));
    assert_eq!(pointer.app.world().resource::<Selection>().primary(), shaft);
    assert_eq!(pointer.app.world().resource::<Hovered>().0, shaft);
    assert_eq!(pointer.design(), before);
}

#[test]
fn other_buttons_drag_no_sensor() {
    let mut pointer = SimulatedPointer::new();
    let before = pointer.design();
    let (at, along) = pointer.shaft();
    pointer.drag(at, along * 30.0, PointerButton::Secondary);
    pointer.release(at + along * 30.0, PointerButton::Secondary);
    assert_eq!(pointer.design(), before);
}

#[test]
fn a_drag_between_slow_frames_keeps_its_start() {
    let mut pointer = SimulatedPointer::new();
    let start = pointer.position_mm(SHAFT);
    let (at, along) = pointer.shaft();
    pointer.send(at, PointerAction::Press(PointerButton::Primary));
    pointer.move_to(at + along * 12.0);
    pointer.move_to(at + along * 30.0);
    pointer.app.update();
    pointer.release(at + along * 30.0, PointerButton::Primary);
    assert!((pointer.position_mm(SHAFT) - start).z > 5.0);
    assert_eq!(pointer.undo_label().as_deref(), Some("Move sensor shaft"));
}

#[test]
fn layers_that_are_off_have_no_entities() {
    const LAYERS: [&str; 7] = [
        "measurement volume",
        "field generator",
        "ground",
        "sensor errors",
        "tip error",
        "ghost",
        "slice",
    ];
    let mut pointer = SimulatedPointer::new();
    let on = "volume,generator,grid,sensor-errors,tip-error,ghost,slice";
    change_view(&mut pointer.app, |view| view.layers = Layers::named(on).unwrap());
    for name in LAYERS {
        assert!(named(&mut pointer.app, name) > 0, "{name}");
    }
    change_view(&mut pointer.app, |view| view.layers = Layers::none());
    for name in LAYERS {
        assert_eq!(named(&mut pointer.app, name), 0, "{name}");
    }
}

#[test]
fn a_slice_handle_moves_it_along_its_normal() {
    let mut pointer = SimulatedPointer::new();
    let world = pointer.app.world_mut();
    // All of the slice is in view.
    world.resource_mut::<OrbitRig>().camera.distance_mm = 2500.0;
    let mut view = world.resource::<OpenWorld>().0.document.view().clone();
    let turned = FreePlane { normal: [1.0, 1.0, 0.5], offset_mm: -150.0 };
    view.slice.free = Some(turned);
    world.write_message(ViewRequest::Set(view.clone()));
    settle(&mut pointer.app);
    let world = pointer.app.world_mut();
    let handle = *world.query::<&SliceHandle>().single(world).unwrap();
    let off = view.slice.normal().dot(&handle.at_mm.coords) + 150.0;
    assert!(off.abs() < 1e-9, "{off}");
    let in_window = |point: &nalgebra::Point3<f64>| {
        let rig = world.resource::<OrbitRig>();
        let [x, y] = rig.camera.project(point, rig.view_px).unwrap();
        world.resource::<ViewportRect>().min + Vec2::new(x as f32, y as f32)
    };
    const WAY_MM: f64 = 60.0;
    let from = in_window(&handle.at_mm);
    let to = in_window(&(handle.at_mm + handle.normal.into_inner() * WAY_MM));
    pointer.drag(from, to - from, PointerButton::Primary);
    pointer.release(to, PointerButton::Primary);
    settle(&mut pointer.app);
    let world = pointer.app.world().resource::<OpenWorld>();
    let slice = world.0.document.view().slice;
    let moved = slice.free.unwrap();
    assert_eq!(moved.normal, turned.normal);
    // A press that has not yet moved far enough is no drag, and places are whole millimetres.
    let way = moved.offset_mm - turned.offset_mm;
    assert!((0.6 * WAY_MM..1.05 * WAY_MM).contains(&way), "{way}");
    assert_eq!(moved.offset_mm, moved.offset_mm.round());
    assert_eq!(slice.position_mm, view.slice.position_mm);
}
