//! The value under the pointer: what was sampled there, and no work for it where nothing is coloured.

use super::app::{document, scenario};
use super::field_layers::{app_with, change_view};
use bevy::ecs::message::Messages;
use bevy::prelude::*;
use bevy::window::{PrimaryWindow, RequestRedraw};
use nalgebra::Point3;
use trackwright_design::view::{Layers, Quantity};
use trackwright_design::{BodyRole, Thing, View};
use trackwright_editor::document::requests::{ActiveDrag, OpenWorld};
use trackwright_editor::document::selection::{Selected, Selection};
use trackwright_editor::layers::legend::Legends;
use trackwright_editor::layers::placement;
use trackwright_editor::layers::probe::{Probe, ProbeLooks, ProbePlugin};
use trackwright_editor::runner::diagnostics::Diagnostics;
use trackwright_editor::runner::results::Results;
use trackwright_editor::shell::window::ViewportRect;
use trackwright_editor::viewport::camera::OrbitRig;
use trackwright_simulation::{ArrowPlan, ArrowSensor, CancelToken, SliceOutcome, sample_arrows};

fn app(change: impl FnOnce(&mut View)) -> App {
    let mut app = app_with(|app| {
        app.add_plugins(ProbePlugin);
    });
    change_view(&mut app, |view| {
        view.layers = Layers::none();
        change(view);
    });
    app
}

fn without_bodies(view: &mut View) {
    for role in BodyRole::ALL {
        view.hidden.toggle(Thing::body(role));
    }
}

/// Moves the pointer over a point of the tracker frame; what the probe shows.
fn point_at(app: &mut App, point_mm: &Point3<f64>) -> Option<String> {
    let at = {
        let rig = app.world().resource::<OrbitRig>();
        let rect = app.world().resource::<ViewportRect>();
        let [x, y] = rig.camera.project(point_mm, rig.view_px).unwrap();
        rect.min + Vec2::new(x as f32, y as f32)
    };
    let world = app.world_mut();
    let mut window =
        world.query_filtered::<&mut Window, With<PrimaryWindow>>().single_mut(world).unwrap();
    window.set_cursor_position(Some(at));
    app.update();
    let probe = app.world().resource::<Probe>().0.clone()?;
    assert_eq!(probe.at, at);
    Some(probe.text)
}

/// The number in a text such as `position error 1.24 mm`.
fn number(text: &str, before: &str) -> f64 {
    let rest = text.strip_prefix(before).unwrap_or_else(|| panic!("{text}"));
    let value = rest.trim().split('\u{2009}').next().unwrap();
    value.parse().unwrap_or_else(|_| panic!("{text}"))
}

fn slice(app: &App) -> SliceOutcome {
    let results = app.world().resource::<Results>();
    results.slice.as_ref().unwrap().value.clone()
}

#[test]
fn over_the_slice_the_sampled_value_is_shown() {
    let mut app = app(|view| {
        view.layers.slice = true;
        without_bodies(view);
    });
    let slice = slice(&app);
    let [nu, nv] = slice.plan.counts;
    let done = app.world().resource::<Diagnostics>().work;
    for (u, v) in [(nu / 2, nv / 2), (nu / 3, nv / 4), (nu * 3 / 4, nv / 2)] {
        let text = point_at(&mut app, &slice.plan.point_mm(u, v)).unwrap();
        let shown = number(&text, "position error");
        // Two decimals, at a pixel that is a place in f32.
        assert!((shown - slice.values[v * nu + u]).abs() < 0.006, "{text}");
    }
    assert_eq!(app.world().resource::<Diagnostics>().work, done);
    // Other quantities have their own name and unit.
    change_view(&mut app, |view| {
        view.slice.quantity = Quantity::OrientationErrorDeg;
    });
    let text = point_at(&mut app, &slice.plan.point_mm(nu / 2, nv / 2)).unwrap();
    assert!(text.starts_with("orientation error ") && text.ends_with('°'), "{text}");
}

#[test]
fn outside_the_box_no_value_is_shown() {
    let mut app = app(|view| {
        view.layers.slice = true;
        without_bodies(view);
    });
    // Far enough away to have all of the slice in view.
    app.world_mut().resource_mut::<OrbitRig>().camera.distance_mm = 2500.0;
    let camera = app.world().resource::<OrbitRig>().camera;
    let bounds = *app.world().resource::<OpenWorld>().0.environment.model.bounds();
    change_view(&mut app, |view| view.slice.face(&camera, &bounds));
    let slice = slice(&app);
    let [nu, nv] = slice.plan.counts;
    let outside = (0..nu * nv)
        .filter(|i| !slice.is_inside[*i])
        .map(|i| slice.plan.point_mm(i % nu, i / nu))
        .min_by_key(|p| (p - camera.focus_mm).norm() as i64)
        .expect("the shadow of a box is larger than its section");
    // Not at its very edge.
    let outside = outside + (outside - camera.focus_mm) * 0.02;
    assert_eq!(point_at(&mut app, &outside).unwrap(), "outside the room's box");
    let normal = slice.plan.plane.normal().into_inner();
    let off = slice.plan.point_mm(0, 0) - slice.plan.plane.axes()[0].into_inner() * 30.0;
    assert_eq!(point_at(&mut app, &(off + normal)), None);
}

#[test]
fn dragging_and_no_colours_stop_the_probe() {
    let mut app = app(|_| ());
    let focus = app.world().resource::<OrbitRig>().camera.focus_mm;
    let looks = |app: &App| app.world().resource::<ProbeLooks>().0;
    assert_eq!(point_at(&mut app, &focus), None);
    assert_eq!(looks(&app), 0);
    change_view(&mut app, |view| view.layers.slice = true);
    let before = looks(&app);
    assert!(before > 0);
    app.insert_resource(ActiveDrag(true));
    assert_eq!(point_at(&mut app, &focus), None);
    assert_eq!(looks(&app), before);
}

#[test]
fn a_pointer_at_rest_requests_no_frame() {
    let mut app = app(|view| view.layers.slice = true);
    let corner = slice(&app).plan.point_mm(3, 3);
    assert!(point_at(&mut app, &corner).is_some());
    for _ in 0..3 {
        app.update();
        let redraws = app.world().resource::<Messages<RequestRedraw>>();
        // The newest messages are of this frame and the one before.
        assert_eq!(redraws.iter_current_update_messages().count(), 0);
    }
}

#[test]
fn a_painted_body_hides_the_slice() {
    let mut app = app(|view| view.layers.slice = true);
    let sensor = Selected::Sensor(BodyRole::Tool, 0);
    let on_shaft = {
        let design = document(&app).design();
        let pose = design.tracker_from_body(BodyRole::Tool).unwrap();
        // Beyond the sensor, where the shaft is nothing but a shaft.
        let own = &design.tool.body.rigid.sensors[0];
        pose * (own.position_in_body + nalgebra::Vector3::z() * 12.0)
    };
    assert_eq!(point_at(&mut app, &on_shaft), None);
    *app.world_mut().resource_mut::<Selection>() = Selection::of(Some(sensor));
    change_view(&mut app, |view| view.layers.placement = true);
    let text = point_at(&mut app, &on_shaft).unwrap();
    assert!(text.starts_with("tip error RMS ") && text.ends_with("), sensor here"), "{text}");
    let legends = app.world().resource::<Legends>();
    let bar = legends.bar(placement::LAYER.row.order).unwrap();
    let shown = number(&text, "tip error RMS");
    assert!((bar.min - 0.01..bar.largest + 0.01).contains(&shown), "{text}");
}

#[test]
fn an_arrow_shows_the_length_of_its_error() {
    let mut app = app(|view| {
        view.layers.arrows = true;
        without_bodies(view);
    });
    let view = document(&app).view();
    let axis = nalgebra::Unit::new_normalize(view.slice.sensor_axis.into());
    let counts = [view.arrows.per_side(); 3];
    let plan = ArrowPlan { sensor: ArrowSensor::Along(axis), counts };
    let arrows = sample_arrows(&scenario(&app), &plan, &CancelToken::default()).unwrap();
    // Nothing is in front of the one that is most to the front.
    let mut rig = app.world_mut().resource_mut::<OrbitRig>();
    let back = rig.camera.tracker_from_camera().rotation * nalgebra::Vector3::z();
    let (from, error) = arrows
        .arrows()
        .max_by(|a, b| back.dot(&a.0.coords).total_cmp(&back.dot(&b.0.coords)))
        .unwrap();
    rig.camera.focus_mm = from;
    let text = point_at(&mut app, &from).unwrap();
    assert!((number(&text, "position error") - error.norm()).abs() < 0.006, "{text}");
}
