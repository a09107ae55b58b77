//! Rooms for the tests of this part of the program.
use super::polynomial_room::in_polynomials;
use super::{Family, Settings, Timing, What, measure};
use std::sync::Arc;
use trackwright_field::bernstein::control_points;
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, Environment};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_simulation::Scenario;
use trackwright_task::{CancelToken, Task};

pub fn bounds() -> Bounds {
    Bounds::from(([-100.0, -50.0, -300.0], [100.0, 50.0, -100.0]))
}

/// Coefficients of some millimetres, of no pattern that a method could lean on.
pub fn model(order: usize, directions: DirectionSet, weighting: Weighting) -> DistortionModel {
    let count = directions.len() * (order + 1).pow(3);
    let coefficients = (0..count)
        .map(|i| std::array::from_fn(|k| 3.0 * (1.7 * i as f64 + k as f64).sin()))
        .collect();
    DistortionModel::new(order, directions, weighting, MapKind::Distortion, bounds(), coefficients)
        .expect("finite coefficients")
}

/// A model whose values are x, y, z of the unit cube twice.
pub fn linear_model(order: usize) -> DistortionModel {
    let coefficients = control_points(order).map(|[x, y, z]| [x, y, z, x, y, z]).collect();
    DistortionModel::of_position(order, bounds(), coefficients).expect("finite coefficients")
}

/// Largest coefficient of a position.
pub fn largest_mm(model: &DistortionModel) -> f64 {
    model.coefficients().iter().flat_map(|c| &c[..3]).fold(0.0, |m, v| v.abs().max(m))
}

/// The built-in design in its own room as polynomials.
pub fn built_in() -> Scenario {
    let world = trackwright_project::open_builtin(trackwright_project::DEFAULT_BUILTIN)
        .expect("the built-in design");
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    in_polynomials(&scenario, &CancelToken::default())
}

/// The built-in design in a room of another field.
pub fn scenario(model: DistortionModel) -> Scenario {
    Scenario { environment: Arc::new(Environment::of_model("room", model)), ..built_in() }
}

/// A family, each of its methods run once.
pub fn family(what: What, scenario: &Scenario, settings: Settings) -> Family {
    let settings = Settings { timing: Timing::ONCE, ..settings };
    measure(what, 0, scenario, &settings, &Task::default()).expect("nobody cancels")
}
