//! What is searched for when an open design's sensors are to be placed: the design in its rooms, its
//! bodies with their meshes, and what may move, by its name.

use super::error::StoreError;
use super::files::Files;
use super::resolve::resolve;
use super::rooms::{RoomSource, further_rooms, own_room};
use super::world::World;
use nalgebra::Vector3;
use std::ops::RangeInclusive;
use std::sync::Arc;
use trackwright_design::{BodyRole, Design};
use trackwright_field::Environment;
use trackwright_geometry::limits::MAX_LENGTH_MM;
use trackwright_optimization::{
    CrfPatch, Goal, MountedBody, Moves, OverRooms, PoseBounds, Problem,
};
use trackwright_simulation::{Mode, Scenario};

/// Names of what may move that are no sensor's.
const TOOL: &str = "tool";
const CRF: &str = "crf";
const GENERATOR: &str = "generator";
const CRF_POSE: &str = "crf-pose";

/// More sensors than any tracker has inputs for.
pub const MOST_SENSORS: usize = 32;

/// More sets of sensors leave a search no time for each.
pub const MOST_SETS: u64 = 100;

/// How far the poses may be moved that are named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoveBounds {
    pub generator: PoseBounds,
    pub crf_pose: PoseBounds,
}

impl MoveBounds {
    /// Ways along each axis and turns, mm and degrees; where they are not stated, what a table's arm and a
    /// head's curve allow. A patch of the anatomy bounds the way by itself.
    pub fn of(
        design: &Design,
        generator: Option<(f64, f64)>,
        crf_pose: Option<(f64, f64)>,
    ) -> Self {
        let has_patch = design.anatomy.iter().any(|anatomy| !anatomy.crf_patch.is_empty());
        let crf_mm = if has_patch { MAX_LENGTH_MM } else { 20.0 };
        let bounds = |stated: Option<(f64, f64)>, usual_mm| {
            let (mm, turn_deg) = stated.unwrap_or((usual_mm, 10.0));
            PoseBounds { shift_mm: Vector3::repeat(mm), turn_deg }
        };
        Self { generator: bounds(generator, 50.0), crf_pose: bounds(crf_pose, crf_mm) }
    }
}

/// Why names do not determine what may move.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MoveError {
    #[error("found no sensor {name:?}, expected {}", expected.join(", "))]
    NoSuchSensor { name: String, expected: Vec<String> },
    #[error("found {count} sensors {name:?} of the {body}, expected names that differ")]
    SeveralSensors { name: String, body: BodyRole, count: usize },
    #[error("{name}: the design has no CRF")]
    NoCrf { name: &'static str },
}

/// What may move, by names: `tool` and `crf` are all sensors of a body, `generator` and `crf-pose` the
/// poses of field generator and CRF, anything else is a sensor's name, the tool's before the CRF's.
/// Without names all sensors of the tool move. How many sensors of which kinds there may be is left as
/// it is.
pub fn named_moves(
    design: &Design,
    names: &[String],
    bounds: MoveBounds,
) -> Result<Moves, MoveError> {
    let count = |role| design.body(role).map(|body| body.rigid.sensors.len());
    let mut moves = Moves::default();
    if names.is_empty() {
        moves.tool = (0..design.tool.body.rigid.sensors.len()).collect();
    }
    for name in names {
        match name.as_str() {
            TOOL => moves.tool.extend(0..design.tool.body.rigid.sensors.len()),
            CRF => {
                let sensors = count(BodyRole::Crf).ok_or(MoveError::NoCrf { name: CRF })?;
                moves.crf.extend(0..sensors);
            }
            GENERATOR => moves.generator = Some(bounds.generator),
            CRF_POSE if design.crf.is_none() => return Err(MoveError::NoCrf { name: CRF_POSE }),
            CRF_POSE => moves.crf_pose = Some(bounds.crf_pose),
            name => match sensor_named(design, name)? {
                (BodyRole::Tool, index) => moves.tool.push(index),
                (BodyRole::Crf, index) => moves.crf.push(index),
            },
        }
    }
    for numbers in [&mut moves.tool, &mut moves.crf] {
        numbers.sort_unstable();
        numbers.dedup();
    }
    Ok(moves)
}

/// How many sets of sensors a search goes through: of each number that there may be, each set of kinds
/// of those that move. One where the sensors stay which they are.
pub fn sets_of_sensors(design: &Design, moves: &Moves) -> u64 {
    let (role, moving) = match moves.tool.is_empty() {
        true => (BodyRole::Crf, moves.crf.len()),
        false => (BodyRole::Tool, moves.tool.len()),
    };
    let have = design.body(role).map_or(0, |body| body.rigid.sensors.len());
    let fixed = have.saturating_sub(moving);
    let numbers = moves.sensors.clone().unwrap_or(have..=have);
    let [least, most] = [numbers.start(), numbers.end()].map(|count| count.saturating_sub(fixed));
    sets_of_kinds(least..=most, moves.kinds.len())
}

/// How many sets of kinds there are of any of these numbers of sensors, as far as they can be counted.
fn sets_of_kinds(sensors: RangeInclusive<usize>, kinds: usize) -> u64 {
    let of_number = |sensors: usize| {
        let choose = |sets: u64, chosen: u64| sets.saturating_mul(sensors as u64 + chosen) / chosen;
        (1..kinds.max(1) as u64).fold(1, choose)
    };
    sensors.map(of_number).fold(0, u64::saturating_add)
}

fn sensor_named(design: &Design, name: &str) -> Result<(BodyRole, usize), MoveError> {
    for (role, body) in design.bodies() {
        let sensors = body.rigid.sensors.iter().enumerate();
        let found: Vec<usize> =
            sensors.filter(|(_, sensor)| sensor.name == name).map(|(index, _)| index).collect();
        match found[..] {
            [] => {}
            [index] => return Ok((role, index)),
            _ => {
                let (name, count) = (name.to_owned(), found.len());
                return Err(MoveError::SeveralSensors { name, body: role, count });
            }
        }
    }
    let bodies = design.bodies().flat_map(|(_, body)| &body.rigid.sensors);
    let poses: &[&str] = match design.crf {
        Some(_) => &[TOOL, CRF, GENERATOR, CRF_POSE],
        None => &[TOOL, GENERATOR],
    };
    let others = poses.iter().map(|name| (*name).to_owned());
    let mut expected: Vec<String> = others.collect();
    for sensor in bodies {
        if !expected.contains(&sensor.name) {
            expected.push(sensor.name.clone());
        }
    }
    Err(MoveError::NoSuchSensor { name: name.to_owned(), expected })
}

/// The rooms that an open design is judged in: its own and its further ones, each once.
///
/// # Errors
/// One that cannot be read.
pub fn design_rooms(files: &Files, world: &World) -> Result<Vec<Arc<Environment>>, StoreError> {
    let mut known = vec![own_room(world)?];
    let mut rooms = vec![Arc::clone(&world.environment)];
    for room in further_rooms(world)? {
        if known.contains(&room) {
            continue;
        }
        if let RoomSource::File(file) = &room {
            files.input(file)?;
        }
        rooms.push(room.read_solved()?);
        known.push(room);
    }
    Ok(rooms)
}

/// The search for the best places of what moves in an open design: over its range of motion, or at
/// its pose where it has none.
pub fn placement_problem(
    world: &World,
    environments: &[Arc<Environment>],
    moves: Moves,
    goal: Goal,
    rooms: OverRooms,
) -> Problem {
    let design = world.document.design();
    let scenarios: Vec<Scenario> =
        environments.iter().map(|environment| resolve(design, environment)).collect();
    Problem {
        mode: study_mode(design),
        tool: mounted(world, BodyRole::Tool).unwrap_or_default(),
        crf: mounted(world, BodyRole::Crf),
        crf_patches: crf_patches(world),
        scenarios,
        moves,
        goal,
        rooms,
        built: None,
    }
}

/// Where on the patient the CRF may stand, as the anatomy states it.
fn crf_patches(world: &World) -> Vec<CrfPatch> {
    let design = world.document.design();
    let Some(crf) = &design.crf else {
        return Vec::new();
    };
    let crf_from_tracker = crf.tracker_from_crf.inverse();
    let each = design.anatomy.iter().filter(|anatomy| !anatomy.crf_patch.is_empty());
    let each = each.map(|anatomy| {
        let mesh = world.anatomy_mesh(&anatomy.mesh).map(Arc::as_ref);
        let crf_from_mesh = crf_from_tracker * anatomy.tracker_from_mesh(design);
        CrfPatch::of_mesh(&anatomy.name, mesh, &anatomy.crf_patch, crf_from_mesh)
    });
    each.collect()
}

/// A design's own study.
fn study_mode(design: &Design) -> Mode {
    match design.motion {
        Some(_) => Mode::Motion,
        None => Mode::Single,
    }
}

/// Where a body's sensors may be, on its mesh where that was read.
fn mounted(world: &World, role: BodyRole) -> Option<MountedBody> {
    let mounting = world.document.design().body(role)?.mounting.clone();
    Some(match world.mesh(role) {
        Some(mesh) => MountedBody::of_mesh(mounting, mesh),
        None => MountedBody::without_mesh(mounting),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::open_builtin;
    use trackwright_optimization::{SensorChoice, Settings, optimize};
    use trackwright_simulation::CancelToken;
    use trackwright_task::Task;

    fn bounds(design: &Design) -> MoveBounds {
        MoveBounds::of(design, None, Some((5.0, 10.0)))
    }

    fn moves(design: &Design, names: &[&str]) -> Result<Moves, MoveError> {
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        named_moves(design, &names, bounds(design))
    }

    #[test]
    fn names_determine_what_may_move() {
        let world = open_builtin("pointer-on-head").unwrap();
        let design = world.document.design();
        let all = moves(design, &[]).unwrap();
        assert_eq!(all, Moves { tool: vec![0, 1, 2], ..Moves::default() });
        assert_eq!(moves(design, &["tool"]).unwrap(), all);
        let named = moves(design, &["left", "grip", "crf-pose", "grip"]).unwrap();
        let crf_pose = Some(bounds(design).crf_pose);
        let expected = Moves { tool: vec![1], crf: vec![1], crf_pose, ..Moves::default() };
        assert_eq!(named, expected);
        let poses = moves(design, &["generator", "crf"]).unwrap();
        let generator = Some(bounds(design).generator);
        assert_eq!(poses, Moves { crf: vec![0, 1, 2], generator, ..Moves::default() });
    }

    #[test]
    fn unknown_names_list_the_known_ones() {
        let world = open_builtin("pointer-on-head").unwrap();
        let mut design = world.document.design().clone();
        let error = moves(&design, &["tip"]).unwrap_err().to_string();
        let known = "tool, crf, generator, crf-pose, shaft, grip, housing, right, left, top";
        assert_eq!(error, format!("found no sensor \"tip\", expected {known}"));
        design.tool.body.rigid.sensors[1].name = "shaft".to_owned();
        let error = moves(&design, &["shaft"]).unwrap_err().to_string();
        assert_eq!(error, "found 2 sensors \"shaft\" of the tool, expected names that differ");
        // The tool's is meant where the CRF has one of the same name.
        design.tool.body.rigid.sensors[1].name = "left".to_owned();
        assert_eq!(moves(&design, &["left"]).unwrap().tool, [1]);
        design.crf = None;
        for name in ["crf", "crf-pose"] {
            let error = moves(&design, &[name]).unwrap_err().to_string();
            assert_eq!(error, format!("{name}: the design has no CRF"));
        }
    }

    #[test]
    fn sets_of_kinds_are_counted() {
        assert_eq!(sets_of_kinds(3..=3, 0), 1);
        assert_eq!(sets_of_kinds(1..=4, 1), 4);
        // 55, 56, 66; and two more of each that a third kind makes.
        assert_eq!(sets_of_kinds(2..=2, 2), 3);
        assert_eq!(sets_of_kinds(2..=2, 3), 6);
        assert_eq!(sets_of_kinds(1..=3, 2), 2 + 3 + 4);
    }

    #[test]
    fn sets_of_sensors_are_of_those_that_move() {
        let world = open_builtin("pointer-on-head").unwrap();
        let design = world.document.design();
        let kind = SensorChoice { degrees_of_freedom: 5, coil: None, cost: 1.0 };
        let all = moves(design, &[]).unwrap();
        assert_eq!(sets_of_sensors(design, &all), 1);
        let two_kinds = Moves { kinds: vec![kind; 2], ..all.clone() };
        assert_eq!(sets_of_sensors(design, &two_kinds), 4);
        // One of three moves: with two or three in all it is none or one that has a kind.
        let one = moves(design, &["grip"]).unwrap();
        let counted = Moves { sensors: Some(2..=3), ..Moves { kinds: vec![kind; 2], ..one } };
        assert_eq!(sets_of_sensors(design, &counted), 1 + 2);
    }

    #[test]
    fn a_problem_is_the_design_in_its_rooms() {
        let world = open_builtin("pointer-on-head").unwrap();
        let rooms = design_rooms(&Files::default(), &world).unwrap();
        assert_eq!(rooms.len(), 1);
        let design = world.document.design();
        let goal = Goal::Requirement(design.requirement.unwrap());
        let moves = moves(design, &[]).unwrap();
        let problem = placement_problem(&world, &rooms, moves, goal, OverRooms::Worst);
        assert!(matches!(problem.mode, Mode::Motion));
        assert_eq!(problem.scenarios[0].tool, design.tool.body.rigid);
        assert_eq!(problem.tool.mounting, design.tool.body.mounting);
        let crf = problem.crf.unwrap();
        assert_eq!(crf.mounting, design.crf.as_ref().unwrap().body.mounting);
        assert!(problem.tool.surface.is_some() && crf.surface.is_some());
    }

    #[test]
    fn what_does_not_hold_the_coil_is_left_out() {
        let world = open_builtin("shaver-on-head").unwrap();
        let rooms = design_rooms(&Files::default(), &world).unwrap();
        let goal = Goal::Requirement(world.document.design().requirement.unwrap());
        let moves = moves(world.document.design(), &["back"]).unwrap();
        let problem = placement_problem(&world, &rooms, moves, goal, OverRooms::Worst);
        let settings = Settings { most_fits: 4_000_000, ..Settings::default() };
        let (enough, task) = (CancelToken::default(), Task::default());
        let found = optimize(&problem, &settings, &enough, &task, &mut |_| ()).unwrap();
        // Some places that the handle does not hold the coil at are 10 mm from all of the grid's.
        let certain_to_mm = found.certain_to_mm.unwrap();
        assert!(certain_to_mm < 9.0, "{certain_to_mm} mm");
    }
}
