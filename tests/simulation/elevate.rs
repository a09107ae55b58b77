//! A model of a higher order is the same field.

use crate::support::studies::default_in_polynomials;
use nalgebra::{Point3, Unit, Vector3};
use trackwright_field::model::ModelError;
use trackwright_field::{DistortionModel, OutsidePolicy};

#[test]
fn a_field_of_a_higher_order_is_the_same_field() {
    let model = &default_in_polynomials().environment.model;
    let [low, high] = [model.bounds().min_mm, model.bounds().max_mm];
    for order in model.order()..=6 {
        let elevated = model.elevated(order).unwrap();
        assert_eq!(elevated.order(), order);
        for k in 0..50 {
            let part = |step: f64| (f64::from(k) * step).fract();
            let at = Point3::from(Vector3::new(part(0.31), part(0.57), part(0.83)))
                .coords
                .component_mul(&(high - low));
            let axis = Unit::new_normalize(Vector3::new(part(0.7) - 0.5, part(0.9) - 0.5, 0.4));
            let of = |model: &DistortionModel| {
                let error = model.evaluate(&(low + at), &axis, OutsidePolicy::Clamp).error;
                (error.position_mm, error.rotation_rad)
            };
            let (before, after) = (of(model), of(&elevated));
            // Averages of coefficients of a few millimetres: a few units in the last place.
            assert!((before.0 - after.0).norm() < 1e-13);
            assert!((before.1 - after.1).norm() < 1e-15);
        }
    }
    assert_eq!(model.elevated(13), Err(ModelError::Order(13)));
}
