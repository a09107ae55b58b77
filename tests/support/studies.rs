//! Small rooms, bodies and ranges of motion, and the built-in designs as scenarios.

use nalgebra::{Unit, Vector3};
use std::sync::{Arc, OnceLock};
use trackwright_calibration::room_fit::{RoomOrder, RoomTable, fit_room};
use trackwright_calibration::room_model::{GeneratorChoice, HarmonicOrder, RoomModel};
use trackwright_field::fit::FitSettings;
use trackwright_field::generator::Generator;
use trackwright_field::harmonic::Loss;
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, Environment, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;
use trackwright_geometry::pose::Pose;
use trackwright_geometry::volume::Volume;
use trackwright_project::{DEFAULT_BUILTIN, Files};
use trackwright_simulation::{
    AxisRange, CancelToken, Mode, Outcome, RigidBody, Scenario, Sensor, SensorOrientation,
    SlicePlan, SlicePlane,
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

/// A tool by itself, at rest in a room.
pub fn tool_alone(
    room: impl Into<Arc<Environment>>,
    tool: RigidBody,
    tracker_from_tool: Pose,
) -> Scenario {
    Scenario {
        environment: room.into(),
        tool,
        crf: None,
        crf_from_tool: tracker_from_tool,
        motion: None,
        orientation_weight_mm: 100.0,
        requirement: None,
        outside: OutsidePolicy::Clamp,
    }
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

/// The fields of the generator that the built-in room was measured with.
pub fn harmonics() -> RoomModel {
    RoomModel::Harmonic(HarmonicOrder {
        generator: GeneratorChoice::Known(Generator::planar_nine()),
        degree: None,
        ridge: None,
        loss: Loss::default(),
    })
}

/// The built-in room fitted with a model to every so many rows of its measurements; of polynomials order 2
/// with 42 orientations.
pub fn built_in_room(model: &RoomModel, every: usize) -> Environment {
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/environments/data/cube-fit.csv");
    let read = Files::default().read_measurements(data.as_ref()).unwrap();
    let mut samples = read.samples(MapKind::Distortion);
    samples.samples = samples.samples.into_iter().step_by(every).collect();
    let order = RoomOrder {
        name: "Operating table",
        table: RoomTable { name: "cube-fit.csv", samples: &samples },
        held_out: None,
        model,
        settings: FitSettings::new(2, DirectionSet::FortyTwo),
        bounds: None,
        volume: Some(Volume::AuroraCube),
        jitter: None,
        with_support: true,
        sensors: None,
        registration: None,
    };
    fit_room(&order, |_| Task::default()).unwrap().environment
}

/// A built-in design in the built-in room as polynomials have it.
pub fn in_polynomial_room(name: &str) -> Scenario {
    static ROOM: OnceLock<Arc<Environment>> = OnceLock::new();
    let room = ROOM.get_or_init(|| Arc::new(built_in_room(&RoomModel::PAPER, 1)));
    Scenario { environment: Arc::clone(room), ..built_in(name) }
}

/// [`default_design`] in the built-in room as polynomials have it.
pub fn default_in_polynomials() -> Scenario {
    in_polynomial_room(DEFAULT_BUILTIN)
}

/// A slice across y that is 40 mm larger than the room's box on each side, so that some of it is outside,
/// for a sensor along no axis of the tracker.
pub fn slice_beyond_box(room: &Environment, counts: [usize; 2]) -> SlicePlan {
    let own = room.model.bounds();
    let out = Vector3::repeat(40.0);
    SlicePlan {
        plane: SlicePlane::Across {
            normal_axis: 1,
            position_mm: own.center_mm().y,
            bounds: Bounds { min_mm: own.min_mm - out, max_mm: own.max_mm + out },
        },
        sensor_axis: Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8)),
        counts,
    }
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
