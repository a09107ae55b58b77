//! The ellipsoid of the tip's jitter: drawn where the room states a jitter, and else no work.

use super::app::{change_view, create_scene_app, named, request, scenario, settle};
use bevy::prelude::*;
use std::sync::Arc;
use trackwright_design::Edit;
use trackwright_design::view::Magnification;
use trackwright_editor::document::requests::{EditRequest, OpenWorld};
use trackwright_editor::runner::diagnostics::Diagnostics;
use trackwright_editor::runner::results::Results;
use trackwright_field::Environment;
use trackwright_field::environment::Jitter;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::uncertainty::first_order;

const GLYPH: &str = "tip scatter";

/// The built-in design, its room with a jitter or without.
fn app(jitter: Option<Jitter>) -> App {
    let mut app = create_scene_app();
    let mut open = app.world_mut().resource_mut::<OpenWorld>();
    open.0.environment =
        Arc::new(Environment { jitter, ..Environment::clone(&open.0.environment) });
    settle(&mut app);
    change_view(&mut app, |view| view.layers.tip_scatter = true);
    app.update();
    app
}

fn jitter() -> Option<Jitter> {
    Some(Jitter::uniform(0.2, 0.004))
}

fn transform(app: &mut App) -> Transform {
    let world = app.world_mut();
    let mut glyphs = world.query::<(&Name, &Transform)>();
    let found = glyphs.iter(world).find(|(name, _)| name.as_str() == GLYPH);
    *found.unwrap().1
}

#[test]
fn a_room_without_jitter_has_no_ellipsoid() {
    let mut app = app(None);
    assert_eq!(named(&mut app, GLYPH), 0);
    assert!(app.world().resource::<Results>().scatter.is_none());
}

#[test]
fn the_ellipsoid_is_the_magnified_95_percent() {
    let mut app = app(jitter());
    assert_eq!(named(&mut app, GLYPH), 1);
    let times = 25.0;
    change_view(&mut app, |view| view.magnification = Magnification::Times(times));
    app.update();
    let mut wanted = first_order(&scenario(&app)).unwrap().ellipsoid.lengths_mm();
    wanted.sort_by(f64::total_cmp);
    let mut drawn = transform(&mut app).scale.to_array().map(f64::from);
    drawn.sort_by(f64::total_cmp);
    for (drawn, wanted) in drawn.into_iter().zip(wanted) {
        // Drawn in single precision.
        let difference = (drawn / times - wanted).abs();
        assert!(difference < 1e-5 * wanted, "{drawn} / {times}, {wanted}");
    }
}

#[test]
fn a_hidden_ellipsoid_is_not_computed() {
    let mut app = app(jitter());
    let evaluations = |app: &App| app.world().resource::<Diagnostics>().work.pose_evaluations;
    let of_an_edit = |app: &mut App, x_mm: f64| {
        let before = evaluations(app);
        let pose = Pose::translation(x_mm, 0.0, 30.0);
        request(app, EditRequest::Apply(Edit::SetToolPose(pose)));
        settle(app);
        evaluations(app) - before
    };
    let shown = of_an_edit(&mut app, 1.0);
    change_view(&mut app, |view| view.layers.tip_scatter = false);
    app.update();
    assert_eq!(named(&mut app, GLYPH), 0);
    assert!(app.world().resource::<Results>().scatter.is_none());
    let without = of_an_edit(&mut app, 2.0);
    assert!(0 < without && without < shown, "{without} of {shown}");
}
