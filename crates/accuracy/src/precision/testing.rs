//! Rooms for the tests of this part of the program.
use super::polynomial_room::in_polynomials;
use super::{Family, Row, Settings, Timing, What, measure};
use crate::stability::case;
use std::sync::Arc;
use trackwright_field::bernstein::control_points;
use trackwright_field::{DistortionModel, Environment};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_simulation::Scenario;
use trackwright_task::{CancelToken, Task};

pub fn bounds() -> Bounds {
    Bounds::from(([-100.0, -50.0, -300.0], [100.0, 50.0, -100.0]))
}

/// Coefficients of no pattern that a method could lean on, up to 1 mm and 0.01 rad.
pub fn model(order: usize, directions: DirectionSet, weighting: Weighting) -> DistortionModel {
    case::model(order, directions, weighting, bounds(), 1).expect("finite coefficients")
}

/// A row of the study's in a room of order 2 with 14 orientations.
pub fn row(problem: &str, method: &str) -> Row {
    Row::new(What::Motion, &model(2, DirectionSet::Fourteen, Weighting::Area), problem, method)
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
