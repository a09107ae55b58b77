//! Small rooms, bodies and ranges of motion, and the built-in designs as scenarios.

use nalgebra::{Unit, Vector3};
use trackwright_field::{DistortionModel, Environment};
use trackwright_geometry::bounds::Bounds;
use trackwright_project::DEFAULT_BUILTIN;
use trackwright_simulation::{
    AxisRange, CancelToken, Mode, Outcome, RigidBody, Scenario, Sensor, SensorOrientation,
};
use trackwright_task::Task;

/// A room of which nothing is known but its model.
pub fn room(model: DistortionModel) -> Environment {
    Environment::of_model("room", model)
}

/// A distortion map without orientations.
pub fn one_direction(order: usize, bounds: Bounds, coefficients: Vec<[f64; 6]>) -> DistortionModel {
    DistortionModel::of_position(order, bounds, coefficients).unwrap()
}

pub fn sensor(position: [f64; 3], orientation: SensorOrientation) -> Sensor {
    Sensor::new("s", position, orientation)
}

/// A 5-DOF sensor.
pub fn five(position: [f64; 3], axis: [f64; 3]) -> Sensor {
    let axis = Unit::new_normalize(Vector3::from(axis));
    sensor(position, SensorOrientation::FiveDof(axis))
}

pub fn marker(position: [f64; 3]) -> Sensor {
    sensor(position, SensorOrientation::Marker)
}

pub fn body(sensors: Vec<Sensor>, tip: Option<[f64; 3]>) -> RigidBody {
    RigidBody { name: "body".into(), tip_in_body: tip.map(Into::into), sensors }
}

/// From `-reach` to `reach` in so many steps.
pub fn steps(reach: f64, steps: f64) -> Option<AxisRange> {
    Some(AxisRange { min: -reach, max: reach, step: 2.0 * reach / steps })
}

/// A built-in design in its room.
pub fn built_in(name: &str) -> Scenario {
    let world = trackwright_project::open_builtin_without_meshes(name).unwrap();
    trackwright_project::resolve(world.document.design(), &world.environment)
}

/// The built-in design that opens first, in its room.
pub fn default_design() -> Scenario {
    built_in(DEFAULT_BUILTIN)
}

pub fn study(scenario: &Scenario, mode: &Mode) -> Outcome {
    trackwright_simulation::run(scenario, mode, &CancelToken::default(), None).unwrap()
}

/// The same work on a number of threads.
pub fn on_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// A task that was cancelled before it began.
pub fn cancelled() -> Task {
    let task = Task::default();
    task.cancel.cancel();
    task
}
