//! How much of the gain that is there a search finds in a room of others: what it finds in the fitted room, and what
//! it finds in the room itself, both judged by the room.

use super::others::{Made, fitted, made};
use super::tracker::{Random, Room};
use super::{five_dof, measurement, place, scenario, truth};
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_field::Environment;
use trackwright_field::samples::{MapKind, SampleSet};
use trackwright_optimization::{Goal, Layout, Moves, OverRooms, Problem, Settings, optimize};
use trackwright_project::{open_builtin, placement_problem};
use trackwright_simulation::{CancelToken, Metric, Mode, RigidBody, Scenario};
use trackwright_task::Task;

/// Places in a room that are tried.
const PLACES: usize = 300;

/// Rooms that searches are made in.
const ROOMS: usize = 8;

/// Rows without noise that stand for the room itself.
const TRUE_ROWS: usize = 4_000;

/// A table of the room without noise, in no order.
fn without_noise(room: &Room, random: &mut Random) -> SampleSet {
    let each = std::iter::repeat_with(|| {
        let at = (room.position(random), random.direction());
        Some(measurement(&at, &room.read(&at)?))
    });
    five_dof(each.flatten().take(TRUE_ROWS)).samples(MapKind::Distortion)
}

/// Where a search moves all sensors of the built-in pointer, alone.
fn of_pointer() -> Problem {
    let world = open_builtin("pointer-on-head").unwrap();
    let sensors = world.document.design().body(BodyRole::Tool).unwrap().rigid.sensors.len();
    let moves = Moves { tool: (0..sensors).collect(), ..Moves::default() };
    let goal = Goal::Figure(Metric::TIP_RMS);
    let rooms = [Arc::clone(&world.environment)];
    Problem {
        mode: Mode::Motion,
        crf: None,
        crf_patches: Vec::new(),
        ..placement_problem(&world, &rooms, moves, goal, OverRooms::Worst)
    }
}

/// The search in a room, the tool moving about a place.
fn in_room(of_pointer: &Problem, scenario: Scenario) -> Problem {
    Problem { scenarios: vec![scenario], ..of_pointer.clone() }
}

/// The pointer about the first place by chance where the tracker follows it.
fn followed(
    room: &Room,
    environment: &Arc<Environment>,
    tool: &RigidBody,
    random: &mut Random,
) -> Option<Scenario> {
    (0..PLACES).find_map(|_| {
        let found = scenario(room, environment, tool.clone(), false, place(room, random))?;
        truth(room, &found).map(|_| found)
    })
}

/// The start and the best; `None` where the room has no place for the sensors.
fn searched(problem: &Problem) -> Option<[Layout; 2]> {
    let enough = CancelToken::default();
    let found = optimize(problem, &Settings::default(), &enough, &Task::default(), &mut |_| {});
    found.ok().map(|found| [found.start, found.best])
}

#[test]
#[ignore = "sixteen whole searches, minutes of work"]
#[expect(clippy::print_stdout, reason = "its figures are what it is run for")]
fn gain_of_searches_page() {
    let first: u64 = std::env::var("ROOMS").map_or(36, |text| text.parse().unwrap());
    let of_pointer = of_pointer();
    let tool = &of_pointer.scenarios[0].tool;
    let mut parts = Vec::new();
    for seed in first.. {
        if parts.len() == ROOMS {
            break;
        }
        let Made { room, table, names } = made(seed);
        let mut random = Random::new(80_000 + seed);
        let Some((model, kind, _)) = fitted(&table, None) else { continue };
        let Some(scenario) = followed(&room, &model, tool, &mut random) else {
            println!("{seed} {names:?}: not followed");
            continue;
        };
        let (known, _, held_out) = fitted(&without_noise(&room, &mut random), None).unwrap();
        let in_known = Scenario { environment: known, ..scenario.clone() };
        let found = searched(&in_room(&of_pointer, scenario.clone()));
        let Some(([start, by_model], [_, by_room])) =
            found.zip(searched(&in_room(&of_pointer, in_known)))
        else {
            println!("{seed} {names:?}: no place for the sensors");
            continue;
        };
        let true_mm = [start, by_model, by_room].map(|layout| {
            let Layout { tool, crf_from_tool, .. } = layout;
            let found = Scenario { tool, crf_from_tool, ..scenario.clone() };
            truth(&room, &found).map(|of| of[Metric::TIP_RMS.index()])
        });
        println!("{seed} {names:?} {kind}; without noise: {held_out}: {true_mm:.3?} mm");
        if let [Some(start), Some(by_model), Some(by_room)] = true_mm {
            let part = (start - by_model) / (start - by_room.min(by_model));
            println!("   {:.0} % of the gain", 100.0 * part);
            parts.push(part);
        }
    }
    parts.sort_by(f64::total_cmp);
    println!("median {:.0} %", 50.0 * (parts[ROOMS / 2 - 1] + parts[ROOMS / 2]));
}
