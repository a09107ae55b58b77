//! What the slice can show besides the error: where the model is valid.

use super::app::{change_view, create_app};
use bevy::prelude::*;
use trackwright_design::view::Quantity;
use trackwright_editor::document::requests::OpenWorld;
use trackwright_editor::runner::results::Results;
use trackwright_field::{FieldPoint, OutsidePolicy, Validity};

fn show(app: &mut App, quantity: Quantity) {
    change_view(app, |view| {
        view.layers.slice = true;
        view.slice.quantity = quantity;
    });
}

#[test]
fn the_slice_has_standard_error_and_distance() {
    let mut app = create_app();
    let builtin = trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN).unwrap();
    app.insert_resource(OpenWorld(builtin));
    let wanted = |quantity: Quantity, at: &Validity| match quantity {
        Quantity::StdErrorMm => at.position_error_mm,
        _ => at.distance_mm,
    };
    for quantity in [Quantity::StdErrorMm, Quantity::SupportDistanceMm] {
        show(&mut app, quantity);
        let results = app.world().resource::<Results>();
        assert_eq!(results.slice.as_ref().unwrap().value.quantity, quantity);
        let slice = &results.slice.as_ref().unwrap().value;
        let [nu, nv] = slice.plan.counts;
        let environment = &app.world().resource::<OpenWorld>().0.environment;
        for (u, v) in [(nu / 2, nv / 2), (nu / 3, nv / 4), (2, nv - 3)] {
            let point = slice.plan.point_mm(u, v);
            let at = FieldPoint::new(point, slice.plan.sensor_axis);
            let stated = environment.validity(&[at], OutsidePolicy::Clamp).unwrap().unwrap();
            let (found, wanted) = (slice.values[v * nu + u], wanted(quantity, &stated[0]));
            assert!((found / wanted - 1.0).abs() < 1e-9, "{found} {wanted}");
        }
    }
}

#[test]
fn a_room_without_validity_has_no_such_slice() {
    let mut app = create_app();
    show(&mut app, Quantity::PositionErrorMm);
    assert!(app.world().resource::<Results>().slice.is_some());
    show(&mut app, Quantity::StdErrorMm);
    assert!(app.world().resource::<Results>().slice.is_none());
}
