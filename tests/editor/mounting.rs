//! Mounting regions in the scene: the layer, the brush, drawn channels and forbidden boxes.

use super::anatomy::{add, anatomy};
use super::app::{change_view, create_scene_app_with, named, settle};
use super::meshes::box_obj;
use super::pointer::{SHAFT, SimulatedPointer};
use bevy::picking::PickingSettings;
use bevy::picking::pointer::PointerButton;
use bevy::prelude::*;
use nalgebra::{Point3, Vector3};
use std::sync::Arc;
use std::time::Duration;
use trackwright_design::{BodyRole, Document, Edit, Origin};
use trackwright_editor::document::commands::{CANCEL_DRAG, DocumentCommandsPlugin};
use trackwright_editor::document::requests::{ActiveDrag, EditRequest, OpenWorld};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::document::state::Notice;
use trackwright_editor::layers::legend::Legends;
use trackwright_editor::layers::mounting::{LAYER, MountingDrawings, MountingLayerPlugin};
use trackwright_editor::shell::commands::{CommandsPlugin, RunCommand};
use trackwright_editor::shell::window::{DragReadout, PointerHint, ViewportRect};
use trackwright_editor::viewport::camera::OrbitRig;
use trackwright_editor::viewport::mounting::MountingPlugin;
use trackwright_editor::viewport::mounting::box_handles::BoxBall;
use trackwright_editor::viewport::mounting::channel::ChannelDraft;
use trackwright_editor::viewport::mounting::seats::ADD_SEATS;
use trackwright_editor::viewport::mounting::state::MountingState;
use trackwright_editor::viewport::surfaces::Surfaces;
use trackwright_editor::viewport::tool::SceneTool;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::surface::Surface;
use trackwright_project::{DEFAULT_BUILTIN, World};
use trackwright_simulation::{Mounting, MountingAxis, MountingRegion};

const REGIONS: &str = "mounting regions";

/// The built-in design, without the regions that it states.
fn world() -> World {
    let open = trackwright_project::open_builtin(DEFAULT_BUILTIN).unwrap();
    let mut design = open.document.design().clone();
    design.tool.body.mounting = Mounting::default();
    if let Some(crf) = &mut design.crf {
        crf.body.mounting = Mounting::default();
    }
    let view = open.document.view().clone();
    let document = Document::new(design, view, Origin::BuiltIn(DEFAULT_BUILTIN));
    let [tool, crf] = BodyRole::ALL.map(|role| open.mesh(role).cloned());
    World::new(document, Arc::clone(&open.environment), tool, crf)
}

/// With what regions are drawn and edited with.
fn pointer() -> SimulatedPointer {
    let app = create_scene_app_with(|app| {
        app.insert_resource(OpenWorld(world()));
        app.add_plugins((CommandsPlugin, DocumentCommandsPlugin, MountingPlugin))
            .add_plugins(MountingLayerPlugin)
            // However slow the frames are, two clicks at one place are a double click.
            .insert_resource(PickingSettings {
                multi_click_interval: Duration::from_secs(3600),
                ..PickingSettings::default()
            });
    });
    let mut pointer = SimulatedPointer { app };
    settle(&mut pointer.app);
    pointer
}

/// With the regions of the tool open, and a tool in hand.
fn pointer_with(tool: SceneTool) -> SimulatedPointer {
    let mut pointer = pointer();
    pointer.select(Some(Selected::Body(BodyRole::Tool)));
    pointer.app.world_mut().resource_mut::<MountingState>().is_open = true;
    settle(&mut pointer.app);
    take(&mut pointer, tool);
    pointer
}

fn take(pointer: &mut SimulatedPointer, tool: SceneTool) {
    pointer.app.world_mut().insert_resource(tool);
    settle(&mut pointer.app);
}

fn mounting(pointer: &SimulatedPointer) -> Mounting {
    pointer.design().tool.body.mounting
}

fn set(pointer: &mut SimulatedPointer, mounting: Mounting) {
    let mounting = Box::new(mounting);
    let edit = Edit::SetMounting { body: BodyRole::Tool, mounting };
    pointer.request(EditRequest::Apply(edit));
    settle(&mut pointer.app);
}

/// The boxes of a patch.
fn boxes(mounting: &Mounting, region: usize) -> &[Bounds] {
    match &mounting.regions[region] {
        MountingRegion::Surface { boxes, .. } => boxes,
        other => panic!("{other:?}"),
    }
}

/// The point of the tool's surface at a place in the window.
fn under(pointer: &SimulatedPointer, at: Vec2) -> Point3<f64> {
    let (rig, view) = (pointer.resource::<OrbitRig>(), pointer.resource::<ViewportRect>());
    let ray = rig.camera.ray(view.pixel(at), rig.view_px);
    let surfaces = pointer.resource::<Surfaces>();
    let hit = surfaces.hit(&pointer.design(), &ray, &[BodyRole::Tool]);
    hit.unwrap().1.position_mm
}

fn is_in(boxes: &[Bounds], point: &Point3<f64>) -> bool {
    boxes.iter().any(|own| own.contains(point))
}

#[test]
fn a_brush_stroke_is_one_undo_step() {
    let mut pointer = pointer_with(SceneTool::PaintPatch);
    let before = pointer.design();
    // It begins on a sensor, which is not taken hold of.
    let (at, along) = pointer.shaft();
    let by = along * 60.0;
    let ends = [under(&pointer, at), under(&pointer, at + by)];
    pointer.drag(at, by, PointerButton::Primary);
    assert_eq!(*pointer.resource::<ActiveDrag>(), ActiveDrag(true));
    let text = pointer.resource::<DragReadout>().0.clone().unwrap().text;
    assert!(text.ends_with(" box") || text.ends_with(" boxes"), "{text}");
    pointer.release(at + by, PointerButton::Primary);
    let painted = mounting(&pointer);
    assert_eq!(painted.regions.len(), 1);
    assert!(ends.iter().all(|end| is_in(boxes(&painted, 0), end)), "{painted:?} {ends:?}");
    // Between the ends too, where the pointer was in steps.
    let middle = under(&pointer, at + by * 0.5);
    assert!(is_in(boxes(&painted, 0), &middle), "{painted:?} {middle}");
    assert_eq!(pointer.undo_label().as_deref(), Some("Paint mounting patch of the tool"));
    let selected = Some(Selected::Body(BodyRole::Tool));
    assert_eq!(pointer.resource::<Selection>().primary(), selected);
    pointer.request(EditRequest::Undo);
    assert_eq!((pointer.design(), pointer.undo_label()), (before, None));
}

#[test]
fn a_second_stroke_goes_to_the_same_patch() {
    let mut pointer = pointer_with(SceneTool::PaintPatch);
    let (at, along) = pointer.shaft();
    for from in [at, at + along * 30.0, at] {
        pointer.drag(from, along * 15.0, PointerButton::Primary);
        pointer.release(from + along * 15.0, PointerButton::Primary);
    }
    let painted = mounting(&pointer);
    assert_eq!(painted.regions.len(), 1, "{painted:?}");
    assert_eq!(boxes(&painted, 0).len(), 2);
    // The third stroke was over what the first had painted: it changed nothing and is no step.
    pointer.request(EditRequest::Undo);
    assert_eq!(boxes(&mounting(&pointer), 0), &boxes(&painted, 0)[..1]);
    assert_eq!(*pointer.resource::<SceneTool>(), SceneTool::PaintPatch);
}

#[test]
fn a_click_of_the_brush_is_one_box_of_its_size() {
    let mut pointer = pointer_with(SceneTool::PaintPatch);
    pointer.app.world_mut().resource_mut::<MountingState>().brush_mm = 8.0;
    settle(&mut pointer.app);
    let before = pointer.design();
    let (at, _) = pointer.shaft();
    let point = under(&pointer, at);
    pointer.click(at);
    let painted = mounting(&pointer);
    let [own] = boxes(&painted, 0) else { panic!("{painted:?}") };
    assert!((own.size_mm() - Vector3::repeat(8.0)).norm() < 1e-9 && own.contains(&point));
    assert_eq!(pointer.undo_label().as_deref(), Some("Paint mounting patch of the tool"));
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
}

#[test]
fn escape_takes_a_brush_stroke_back() {
    let mut pointer = pointer_with(SceneTool::PaintPatch);
    let before = pointer.design();
    let (at, along) = pointer.shaft();
    pointer.drag(at, along * 40.0, PointerButton::Primary);
    assert_ne!(pointer.design(), before);
    pointer.assert_escape_restores(&before, at + along * 60.0);
}

/// With a stroke of 60 px on the tool; from where, and which way.
fn painted() -> (SimulatedPointer, Vec2, Vec2) {
    let mut pointer = pointer_with(SceneTool::PaintPatch);
    let (at, along) = pointer.shaft();
    pointer.drag(at, along * 60.0, PointerButton::Primary);
    pointer.release(at + along * 60.0, PointerButton::Primary);
    (pointer, at, along)
}

#[test]
fn an_eraser_takes_out_what_it_covers() {
    let (mut pointer, at, along) = painted();
    let before = pointer.design();
    let [kept, erased, end] = [0.0, 45.0, 60.0].map(|by| under(&pointer, at + along * by));
    take(&mut pointer, SceneTool::ErasePatch);
    pointer.drag(at + along * 45.0, along * 15.0, PointerButton::Primary);
    let text = pointer.resource::<DragReadout>().0.clone().unwrap().text;
    assert!(text.ends_with(" box") || text.ends_with(" boxes"), "{text}");
    pointer.release(at + along * 60.0, PointerButton::Primary);
    let left = mounting(&pointer);
    assert!(is_in(boxes(&left, 0), &kept), "{left:?} {kept}");
    assert!(![erased, end].iter().any(|point| is_in(boxes(&left, 0), point)), "{left:?}");
    assert_eq!(pointer.undo_label().as_deref(), Some("Erase mounting patch of the tool"));
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
    // Without a region it is erased from the whole surface.
    set(&mut pointer, Mounting::default());
    pointer.click(at);
    let left = mounting(&pointer);
    assert!(!is_in(boxes(&left, 0), &kept) && is_in(boxes(&left, 0), &end), "{left:?}");
}

#[test]
fn with_alt_the_brush_erases() {
    let (mut pointer, at, along) = painted();
    let before = mounting(&pointer);
    let point = under(&pointer, at + along * 30.0);
    pointer.hold(KeyCode::AltLeft);
    pointer.drag(at + along * 20.0, along * 20.0, PointerButton::Primary);
    // What began as erasing goes on as that.
    pointer.app.world_mut().resource_mut::<ButtonInput<KeyCode>>().release(KeyCode::AltLeft);
    pointer.release(at + along * 40.0, PointerButton::Primary);
    assert!(is_in(boxes(&before, 0), &point) && !is_in(boxes(&mounting(&pointer), 0), &point));
    assert_eq!(pointer.undo_label().as_deref(), Some("Erase mounting patch of the tool"));
}

#[test]
fn an_erased_patch_is_removed() {
    let mut pointer = pointer_with(SceneTool::PaintPatch);
    let (at, along) = pointer.shaft();
    pointer.click(at);
    take(&mut pointer, SceneTool::ErasePatch);
    let painted = pointer.design();
    pointer.drag(at, along * 40.0, PointerButton::Primary);
    let text = pointer.resource::<DragReadout>().0.clone().unwrap().text;
    assert_eq!(text, "nothing left to erase");
    // The rest of the stroke erases nothing of the surface that counts now.
    assert_eq!(mounting(&pointer).regions, []);
    pointer.escape();
    assert_eq!(pointer.design(), painted);
}

/// Beside the shaft, so that no sensor is nearer to the pointer than its faces.
const BOX: ([f64; 3], [f64; 3]) = ([20.0, 20.0, 90.0], [60.0, 50.0, 140.0]);

/// With a forbidden box of the tool whose faces have balls.
fn pointer_with_box() -> SimulatedPointer {
    let mut pointer = pointer_with(SceneTool::Select);
    let keep_out = vec![Bounds::from(BOX)];
    set(&mut pointer, Mounting { keep_out, ..Mounting::default() });
    pointer
}

/// Of the balls that are picked, the one that moves most on the screen: its pixel, and how far that
/// moves when the face moves out by 10 mm.
fn free_ball(pointer: &mut SimulatedPointer) -> (BoxBall, Vec2, Vec2) {
    let world = pointer.app.world_mut();
    let balls: Vec<BoxBall> = world.query::<&BoxBall>().iter(world).copied().collect();
    let mut found = Vec::new();
    for ball in balls {
        let own = *mounting(pointer).stated_box(ball.place).unwrap();
        let middle = ball.face.middle_mm(&own);
        let out = if ball.face.is_max { 10.0 } else { -10.0 };
        let at = pointer.pixel(&middle);
        let ahead = middle + Vector3::ith_axis(ball.face.axis).into_inner() * out;
        pointer.move_to(at);
        pointer.app.update();
        pointer.app.update();
        let axis = ["along x", "along y", "along z"][ball.face.axis];
        let end = if ball.face.is_max { "ends" } else { "begins" };
        let hint = pointer.resource::<PointerHint>().0.clone().unwrap_or_default();
        if hint.contains(&format!("the forbidden box {end} {axis}")) {
            found.push((ball, at, pointer.pixel(&ahead) - at));
        }
    }
    let longest = found.into_iter().max_by(|a, b| a.2.length().total_cmp(&b.2.length()));
    longest.expect("a ball under the pointer")
}

#[test]
fn a_dragged_face_resizes_a_box_in_one_step() {
    let mut pointer = pointer_with_box();
    let before = pointer.design();
    let (ball, at, by) = free_ball(&mut pointer);
    pointer.drag(at, by, PointerButton::Primary);
    let text = pointer.resource::<DragReadout>().0.clone().unwrap().text;
    let end = if ball.face.is_max { "to" } else { "from" };
    assert!(text.contains(&format!(" {end} ")) && text.contains(" × "), "{text}");
    pointer.release(at + by, PointerButton::Primary);
    let resized = *mounting(&pointer).stated_box(ball.place).unwrap();
    let expected = {
        let own = Bounds::from(BOX);
        let out = if ball.face.is_max { 10.0 } else { -10.0 };
        ball.face.moved_to(&own, ball.face.value_mm(&own) + out)
    };
    // A pixel of the window has 24 bits.
    assert!((resized.min_mm - expected.min_mm).norm() < 0.05, "{resized:?} {expected:?}");
    assert!((resized.max_mm - expected.max_mm).norm() < 0.05, "{resized:?} {expected:?}");
    assert_eq!(pointer.undo_label().as_deref(), Some("Resize forbidden box of the tool"));
    assert_eq!(pointer.resource::<Selection>().primary(), Some(Selected::Body(BodyRole::Tool)));
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
    settle(&mut pointer.app);
    pointer.hold(KeyCode::ControlLeft);
    pointer.drag(at, by * 0.77, PointerButton::Primary);
    pointer.release(at + by * 0.77, PointerButton::Primary);
    let rounded = *mounting(&pointer).stated_box(ball.place).unwrap();
    assert_eq!(ball.face.value_mm(&rounded).fract(), 0.0, "{rounded:?}");
}

#[test]
fn escape_takes_a_resized_box_back() {
    let mut pointer = pointer_with_box();
    let (_, at, by) = free_ball(&mut pointer);
    // What was stated is a step of its own.
    let (before, label) = (pointer.design(), pointer.undo_label());
    pointer.drag(at, by, PointerButton::Primary);
    assert_ne!(pointer.design(), before);
    pointer.escape();
    pointer.release(at + by, PointerButton::Primary);
    assert_eq!((pointer.design(), pointer.undo_label()), (before, label));
}

#[test]
fn boxes_have_balls_while_they_are_edited() {
    const BALL: &str = "box handle";
    let mut pointer = pointer_with_box();
    assert_eq!(named(&mut pointer.app, BALL), 6);
    take(&mut pointer, SceneTool::PaintPatch);
    assert_eq!(named(&mut pointer.app, BALL), 0);
    take(&mut pointer, SceneTool::Select);
    // A box of a patch has them too.
    let boxes = vec![Bounds::from(BOX)];
    let patch = MountingRegion::Surface { axis: MountingAxis::Normal, boxes };
    let both = Mounting { regions: vec![patch], ..mounting(&pointer) };
    set(&mut pointer, both);
    assert_eq!(named(&mut pointer.app, BALL), 12);
    pointer.select(Some(Selected::Body(BodyRole::Crf)));
    assert_eq!(named(&mut pointer.app, BALL), 0);
    pointer.select(Some(Selected::Body(BodyRole::Tool)));
    pointer.app.world_mut().resource_mut::<MountingState>().is_open = false;
    settle(&mut pointer.app);
    assert_eq!(named(&mut pointer.app, BALL), 0);
}

#[test]
fn a_dragged_box_is_around_both_ends() {
    let mut pointer = pointer_with(SceneTool::DrawBox);
    let before = pointer.design();
    let (at, along) = pointer.shaft();
    let by = along * 60.0;
    let ends = [under(&pointer, at), under(&pointer, at + by)];
    pointer.drag(at, by, PointerButton::Primary);
    let text = pointer.resource::<DragReadout>().0.clone().unwrap().text;
    assert!(text.contains(" × ") && text.ends_with("\u{2009}mm"), "{text}");
    pointer.release(at + by, PointerButton::Primary);
    let drawn = mounting(&pointer);
    let [own] = drawn.keep_out[..] else { panic!("{drawn:?}") };
    let brush_mm = pointer.resource::<MountingState>().brush_mm;
    for end in ends {
        assert!(own.contains(&end), "{own:?} {end}");
    }
    // No larger than needed by more than the brush.
    let size = (ends[1] - ends[0]).abs() + Vector3::repeat(brush_mm);
    assert!((own.size_mm() - size).norm() < 0.01, "{own:?}");
    assert_eq!(pointer.undo_label().as_deref(), Some("Draw forbidden box of the tool"));
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
    pointer.drag(at, by, PointerButton::Primary);
    assert_eq!(mounting(&pointer).keep_out.len(), 1);
    pointer.assert_escape_restores(&before, at);
}

#[test]
fn anatomy_is_painted_for_the_crf() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("head.obj");
    std::fs::write(&file, box_obj([60.0; 3], "")).unwrap();
    let mut pointer = pointer();
    pointer.request(add(anatomy("head", file.to_str().unwrap())));
    pointer.select(Some(Selected::Anatomy(0)));
    pointer.app.world_mut().resource_mut::<MountingState>().is_open = true;
    settle(&mut pointer.app);
    // A box is of a body alone.
    take(&mut pointer, SceneTool::DrawBox);
    assert_eq!(*pointer.resource::<SceneTool>(), SceneTool::Select);
    take(&mut pointer, SceneTool::PaintPatch);
    let before = pointer.design();
    let tracker_from_mesh = before.anatomy[0].tracker_from_mesh(&before);
    let world = &pointer.resource::<OpenWorld>().0;
    let mesh = Arc::clone(world.anatomy_mesh(&before.anatomy[0].mesh).unwrap());
    let surface = Surface::new(&mesh).unwrap();
    let (rig, view) = (pointer.resource::<OrbitRig>().clone(), *pointer.resource::<ViewportRect>());
    let [x, y] = {
        let middle = tracker_from_mesh * Point3::new(30.0, 30.0, 30.0);
        rig.camera.project(&middle, rig.view_px).unwrap()
    };
    let at = view.min + Vec2::new(x as f32, y as f32);
    let by = Vec2::new(12.0, 0.0);
    let under = |at: Vec2| {
        let ray = rig.camera.ray(view.pixel(at), rig.view_px);
        surface.cast(&ray.transformed_by(&tracker_from_mesh.inverse())).unwrap().position_mm
    };
    pointer.drag(at, by, PointerButton::Primary);
    pointer.release(at + by, PointerButton::Primary);
    let patch = |pointer: &SimulatedPointer| pointer.design().anatomy[0].crf_patch.clone();
    let painted = patch(&pointer);
    assert!([at, at + by].iter().all(|at| is_in(&painted, &under(*at))), "{painted:?}");
    assert_eq!(pointer.undo_label().as_deref(), Some("Paint CRF patch of anatomy head"));
    assert_eq!(pointer.design().tool.body.mounting, before.tool.body.mounting);
    settle(&mut pointer.app);
    assert_eq!((named(&mut pointer.app, REGIONS), named(&mut pointer.app, "CRF patch")), (1, 1));
    take(&mut pointer, SceneTool::ErasePatch);
    pointer.click(at);
    assert!(!is_in(&patch(&pointer), &under(at)), "{:?}", patch(&pointer));
    assert_eq!(pointer.undo_label().as_deref(), Some("Erase CRF patch of anatomy head"));
    pointer.request(EditRequest::Undo);
    assert_eq!(patch(&pointer), painted);
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
    // Without a patch there is nothing to erase.
    settle(&mut pointer.app);
    pointer.click(at);
    assert_eq!(pointer.design(), before);
}

#[test]
fn clicks_and_enter_draw_a_channel() {
    let mut pointer = pointer_with(SceneTool::DrawChannel);
    let before = pointer.design();
    let (at, along) = pointer.shaft();
    pointer.click(at);
    pointer.click(at + along * 15.0);
    assert_eq!(pointer.resource::<ChannelDraft>().points_mm.len(), 2);
    assert_eq!(pointer.design(), before, "nothing is stated before its end");
    pointer.hold(KeyCode::Enter);
    pointer.app.world_mut().run_schedule(Update);
    settle(&mut pointer.app);
    let drawn = mounting(&pointer);
    let [MountingRegion::Channel { points_mm, radius_mm: None, axis }] = &drawn.regions[..] else {
        panic!("{drawn:?}")
    };
    assert_eq!((points_mm.len(), *axis), (2, MountingAxis::Along));
    // In the middle of the shaft, which the sensor is on the axis of.
    let on_axis = pointer.position_mm(SHAFT).coords.xy();
    for point in points_mm {
        let off_mm = (point.coords.xy() - on_axis).norm();
        assert!(off_mm < 0.2, "{point}");
    }
    assert_eq!(*pointer.resource::<SceneTool>(), SceneTool::Select);
    assert_eq!(pointer.resource::<ChannelDraft>().points_mm, []);
    assert_eq!(pointer.undo_label().as_deref(), Some("Draw mounting channel of the tool"));
    pointer.request(EditRequest::Undo);
    assert_eq!(pointer.design(), before);
}

#[test]
fn a_double_click_ends_a_channel() {
    let mut pointer = pointer_with(SceneTool::DrawChannel);
    let (at, along) = pointer.shaft();
    pointer.click(at);
    pointer.click(at + along * 15.0);
    pointer.click(at + along * 15.0);
    settle(&mut pointer.app);
    let drawn = mounting(&pointer);
    let [MountingRegion::Channel { points_mm, .. }] = &drawn.regions[..] else {
        panic!("{drawn:?}")
    };
    assert_eq!(points_mm.len(), 2);
}

#[test]
fn escape_discards_a_channel_and_one_point_is_none() {
    let mut pointer = pointer_with(SceneTool::DrawChannel);
    let before = pointer.design();
    let (at, along) = pointer.shaft();
    pointer.click(at);
    pointer.hold(KeyCode::Enter);
    pointer.app.world_mut().run_schedule(Update);
    let notice = pointer.resource::<Notice>().clone();
    assert!(matches!(&notice, Notice::Refused(why) if why.contains("two points")), "{notice:?}");
    pointer.click(at + along * 15.0);
    assert_eq!(pointer.resource::<ChannelDraft>().points_mm.len(), 2);
    pointer.app.world_mut().write_message(RunCommand(CANCEL_DRAG.name));
    settle(&mut pointer.app);
    assert_eq!(*pointer.resource::<SceneTool>(), SceneTool::Select);
    assert_eq!(*pointer.resource::<ChannelDraft>(), ChannelDraft::default());
    assert_eq!((pointer.design(), pointer.undo_label()), (before, None));
}

#[test]
fn a_tool_ends_with_the_section_it_belongs_to() {
    for tool in
        [SceneTool::PaintPatch, SceneTool::ErasePatch, SceneTool::DrawChannel, SceneTool::DrawBox]
    {
        let mut pointer = pointer_with(tool);
        let hint = pointer.resource::<PointerHint>().0.clone().unwrap();
        assert!(hint.contains("selected body") && hint.ends_with("Esc ends"), "{hint}");
        pointer.select(Some(Selected::Body(BodyRole::Crf)));
        assert_eq!(*pointer.resource::<SceneTool>(), tool, "another body, the same tool");
        pointer.select(Some(Selected::Sensor(BodyRole::Tool, SHAFT)));
        assert_eq!(*pointer.resource::<SceneTool>(), SceneTool::Select);
        // Drags take hold of sensors again.
        let before = mounting(&pointer);
        let (at, along) = pointer.shaft();
        pointer.drag(at, along * 15.0, PointerButton::Primary);
        pointer.release(at + along * 15.0, PointerButton::Primary);
        assert_eq!(pointer.undo_label().as_deref(), Some("Move sensor shaft"));
        assert_eq!(mounting(&pointer), before);
    }
}

#[test]
fn a_command_makes_seats_of_the_selected_sensors() {
    let mut pointer = pointer();
    let before = pointer.design();
    let both = Selection::of_sensors(BodyRole::Tool, [SHAFT, 1]);
    *pointer.app.world_mut().resource_mut::<Selection>() = both;
    pointer.app.world_mut().write_message(RunCommand(ADD_SEATS.name));
    settle(&mut pointer.app);
    let expected: Vec<MountingRegion> =
        before.tool.body.rigid.sensors[..2].iter().map(MountingRegion::seat_of).collect();
    assert_eq!(mounting(&pointer).regions, expected);
    pointer.request(EditRequest::Undo);
    assert_eq!((pointer.design(), pointer.undo_label()), (before, None));
}

#[test]
fn only_the_selected_body_is_painted() {
    let mut pointer = pointer_with(SceneTool::PaintPatch);
    let (at, along) = pointer.shaft();
    pointer.select(Some(Selected::Body(BodyRole::Crf)));
    let before = pointer.design();
    pointer.drag(at, along * 15.0, PointerButton::Primary);
    pointer.release(at + along * 15.0, PointerButton::Primary);
    assert_eq!(mounting(&pointer), before.tool.body.mounting);
}

#[test]
fn regions_that_are_off_cost_nothing() {
    let mut pointer = pointer();
    let count = |pointer: &SimulatedPointer| pointer.resource::<MountingDrawings>().0;
    let is_explained =
        |pointer: &SimulatedPointer| pointer.resource::<Legends>().words(LAYER.row.order).is_some();
    pointer.select(Some(Selected::Body(BodyRole::Tool)));
    set(&mut pointer, Mounting { tip_clearance_mm: 3.0, ..Mounting::default() });
    assert_eq!((named(&mut pointer.app, REGIONS), count(&pointer)), (0, 0));
    assert!(!is_explained(&pointer));
    change_view(&mut pointer.app, |view| view.layers.mounting = true);
    assert_eq!((named(&mut pointer.app, REGIONS), count(&pointer)), (2, 2), "tool and CRF");
    assert!(is_explained(&pointer));
    // A moved sensor is no other region.
    let mut sensor = pointer.design().tool.body.rigid.sensors[SHAFT].clone();
    sensor.position_in_body.z += 1.0;
    let edit = Edit::SetSensor { body: BodyRole::Tool, index: SHAFT, sensor };
    pointer.request(EditRequest::Apply(edit));
    settle(&mut pointer.app);
    assert_eq!(count(&pointer), 2);
    change_view(&mut pointer.app, |view| view.layers.mounting = false);
    assert_eq!(named(&mut pointer.app, REGIONS), 0);
    assert!(!is_explained(&pointer));
}

#[test]
fn edited_regions_are_drawn_without_the_layer() {
    let mut pointer = pointer_with(SceneTool::Select);
    assert_eq!(named(&mut pointer.app, REGIONS), 1, "the tool's alone");
    assert_eq!(named(&mut pointer.app, "mounting patch"), 1, "its whole surface");
    let ends = [Point3::new(0.0, 0.0, 20.0), Point3::new(0.0, 0.0, 60.0)];
    let regions = vec![
        MountingRegion::channel(&ends).unwrap(),
        MountingRegion::Seat { position_mm: ends[0], axis: None },
    ];
    let keep_out = vec![Bounds::from(([0.0; 3], [5.0; 3]))];
    let stated = Mounting { regions, keep_out, tip_clearance_mm: 4.0, ..Mounting::default() };
    set(&mut pointer, stated);
    for (name, count) in [
        ("mounting patch", 0),
        ("mounting channel", 1),
        ("mounting seat", 1),
        ("forbidden box", 1),
        ("tip clearance", 1),
    ] {
        assert_eq!(named(&mut pointer.app, name), count, "{name}");
    }
    pointer.app.world_mut().resource_mut::<MountingState>().is_open = false;
    settle(&mut pointer.app);
    assert_eq!(named(&mut pointer.app, REGIONS), 0);
}
