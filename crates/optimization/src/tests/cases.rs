//! Designs that the tests search.

use crate::{Goal, MountedBody, Moves, OverRooms, Problem};
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use std::sync::Arc;
use trackwright_field::random_models::{Seeded, random_model};
use trackwright_field::samples::MapKind;
use trackwright_field::{DistortionModel, Environment, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, Weighting};
use trackwright_geometry::mesh::{MeshPart, SurfaceMesh};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_simulation::scenario::ScenarioCrf;
use trackwright_simulation::{
    AxisRange, Coil, Metric, Mode, Motion, Mounting, MountingAxis, MountingRegion, RigidBody,
    Scenario, Sensor,
};

/// Of the needle, from the tip.
pub(crate) const CHANNEL_MM: [f64; 2] = [5.0, 145.0];

pub(crate) const COIL: Coil = Coil { diameter_mm: 0.8, length_mm: 9.0 };

/// A room of the order whose errors are some mm and tenths of a degree.
pub(crate) fn room(seed: u64) -> Arc<Environment> {
    let model = random_model(2, DirectionSet::Fourteen, Weighting::default(), [1.5, 0.01], seed);
    Arc::new(Environment::of_model("room", model))
}

/// A room without any error.
pub(crate) fn ideal() -> Environment {
    let model =
        DistortionModel::zero(trackwright_field::random_models::room(), MapKind::Distortion);
    Environment::of_model("ideal", model)
}

/// Some turns about x and y and ways along z.
pub(crate) fn motion() -> Motion {
    let range = |far: f64| Some(AxisRange { min: -far, max: far, step: far });
    Motion { x: range(30.0), z: range(30.0), rx: range(25.0), ry: range(25.0), ..Motion::default() }
}

pub(crate) fn coil(name: &str, position: [f64; 3], axis: Vector3<f64>) -> Sensor {
    Sensor { coil: Some(COIL), ..Sensor::five_dof(name, position, Unit::new_normalize(axis)) }
}

/// A needle of 150 mm with its tip at the origin and coils along its axis.
pub(crate) fn needle(places_mm: &[f64]) -> RigidBody {
    let each = places_mm.iter().enumerate();
    let sensors = each.map(|(k, z)| coil(&format!("coil {}", k + 1), [0.0, 0.0, *z], Vector3::z()));
    RigidBody {
        name: "needle".into(),
        tip_in_body: Some(Point3::origin()),
        sensors: sensors.collect(),
    }
}

/// Its lumen.
pub(crate) fn lumen() -> Mounting {
    let points_mm = CHANNEL_MM.map(|z| Point3::new(0.0, 0.0, z)).to_vec();
    let channel =
        MountingRegion::Channel { points_mm, radius_mm: Some(0.5), axis: MountingAxis::Along };
    Mounting { regions: vec![channel], ..Mounting::default() }
}

/// A needle in rooms, two coils of which may move.
pub(crate) fn needle_problem(
    rooms: Vec<Arc<Environment>>,
    starts_mm: &[f64],
    seed: u64,
) -> Problem {
    let mut seeded = Seeded::new(seed);
    let turn = UnitQuaternion::from_euler_angles(
        0.4 * seeded.normal(),
        0.4 * seeded.normal(),
        0.4 * seeded.normal(),
    );
    let at = Vector3::new(30.0 * seeded.normal(), 30.0 * seeded.normal(), -300.0);
    let scenario = |environment| Scenario {
        environment,
        tool: needle(starts_mm),
        crf: None,
        crf_from_tool: pose_from_parts(at, turn),
        motion: Some(motion()),
        orientation_weight_mm: 100.0,
        requirement: None,
        outside: OutsidePolicy::Clamp,
    };
    Problem {
        scenarios: rooms.into_iter().map(scenario).collect(),
        mode: Mode::Motion,
        tool: MountedBody::without_mesh(lumen()),
        crf: None,
        crf_patches: Vec::new(),
        moves: Moves { tool: (0..starts_mm.len()).collect(), ..Moves::default() },
        goal: Goal::Figure(Metric::TIP_RMS),
        rooms: OverRooms::Worst,
        built: None,
    }
}

/// A plate of 60 x 60 x 6 mm with its top at z = 0.
pub(crate) fn plate() -> SurfaceMesh {
    let half = Vector3::new(30.0, 30.0, 3.0);
    let mut part = MeshPart::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = part.positions_mm.len() as u32;
            let mut normal = Vector3::zeros();
            normal[axis] = side;
            // Counterclockwise seen from outside.
            for [u, v] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
                let mut corner = normal;
                corner[(axis + 1) % 3] = u * side;
                corner[(axis + 2) % 3] = v;
                let at = corner.component_mul(&half) - Vector3::z() * half.z;
                part.positions_mm.push(at.into());
                part.normals.push(normal);
            }
            part.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    SurfaceMesh { parts: vec![part], ..SurfaceMesh::default() }
}

/// The plate's top, with a least gap and axes along it.
pub(crate) fn plate_top() -> Mounting {
    let top = Bounds::from(([-25.0, -25.0, -0.5], [25.0, 25.0, 0.5]));
    let region = MountingRegion::Surface { axis: MountingAxis::AsItIs, boxes: vec![top] };
    Mounting { regions: vec![region], least_gap_mm: Some(3.0), ..Mounting::default() }
}

/// A pointer held against a CRF of three coils on a plate, which may move.
pub(crate) fn crf_problem(rooms: Vec<Arc<Environment>>, seed: u64) -> Problem {
    let mut problem = needle_problem(rooms, &[30.0, 110.0], seed);
    let sensors = vec![
        coil("a", [-15.0, -12.0, 0.0], Vector3::x()),
        coil("b", [15.0, -12.0, 0.0], Vector3::new(0.5, 0.866, 0.0)),
        coil("c", [0.0, 14.0, 0.0], Vector3::new(-0.5, 0.866, 0.0)),
    ];
    let body = RigidBody { name: "plate".into(), tip_in_body: None, sensors };
    for scenario in &mut problem.scenarios {
        let tracker_from_crf = Pose::translation(40.0, 10.0, -330.0);
        scenario.crf_from_tool = tracker_from_crf.inverse() * scenario.crf_from_tool;
        scenario.crf = Some(ScenarioCrf { body: body.clone(), tracker_from_crf });
    }
    problem.crf = Some(MountedBody::of_mesh(plate_top(), &plate()));
    problem.moves = Moves { crf: vec![0, 1, 2], ..Moves::default() };
    problem
}
