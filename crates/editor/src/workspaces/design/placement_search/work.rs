//! The search itself, on threads of its own that leave the processor to whatever else wants it.

use crate::workspaces::design::placement_search::state::{
    Found, SearchError, SearchResult, Searched,
};
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::sync::mpsc::channel;
use std::time::Instant;
use trackwright_design::BodyRole;
use trackwright_optimization::{Settings, optimize};
use trackwright_project::{Files, World, design_rooms, placement_problem};
use trackwright_report::drawing::BodyOutline;
use trackwright_task::{CancelToken, Task};

/// How much less the search's threads count to the scheduler than those that answer a hand.
#[cfg(target_os = "linux")]
const NICENESS: i32 = 15;

/// Half of the processors: what is dragged meanwhile has the others.
fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, |all| all.get().div_ceil(2))
}

/// Of low priority where a system gives single threads one.
fn pool() -> Result<ThreadPool, ThreadPoolBuildError> {
    let pool = ThreadPoolBuilder::new().num_threads(threads());
    let pool = pool.thread_name(|_| "placement search".to_owned());
    pool.start_handler(|_| lower_priority()).build()
}

fn lower_priority() {
    // Where it is refused the search is as before, and the hand slower.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(None, NICENESS);
}

/// Searches in all rooms of the design; `report` gets each better layout.
pub fn search(
    world: &World,
    searched: &Searched,
    settings: &Settings,
    enough: &CancelToken,
    task: &Task,
    report: &mut dyn FnMut(Found),
) -> Result<SearchResult, SearchError> {
    let (sender, better) = channel();
    let mut found = Err(SearchError::StoppedEarly);
    pool()?.in_place_scope(|scope| {
        let found = &mut found;
        scope.spawn(move |_| {
            *found = find(world, searched, settings, enough, task, &mut |better| {
                // The receiver lives as long as the search.
                let _ = sender.send(better);
            });
        });
        better.into_iter().for_each(report);
    });
    found
}

fn find(
    world: &World,
    searched: &Searched,
    settings: &Settings,
    enough: &CancelToken,
    task: &Task,
    report: &mut dyn FnMut(Found),
) -> Result<SearchResult, SearchError> {
    let start = Instant::now();
    let rooms = design_rooms(&Files::default(), world)?;
    let moves = searched.wish.moves(&searched.design);
    let problem = placement_problem(world, &rooms, moves, searched.goal, searched.wish.rooms);
    let optimized = optimize(&problem, settings, enough, task, &mut |progress| {
        let after_secs = start.elapsed().as_secs_f64();
        let (best, evaluations) = (Box::new(progress.best.clone()), progress.evaluations);
        report(Found::Better { best, evaluations, after_secs });
    });
    let optimized = optimized.map_err(SearchError::Search)?;
    Ok(SearchResult {
        outlines: outlines(world, searched),
        optimized,
        rooms: rooms.iter().map(|room| room.name.clone()).collect(),
        took_secs: start.elapsed().as_secs_f64(),
    })
}

fn outlines(world: &World, searched: &Searched) -> Vec<(BodyRole, BodyOutline)> {
    let moved =
        searched.design.bodies().filter(|(role, _)| !searched.wish.numbers(*role).is_empty());
    let each = moved.filter_map(|(role, body)| {
        let mesh = world.mesh(role).map(AsRef::as_ref);
        Some((role, BodyOutline::of(&body.rigid, mesh)?))
    });
    each.collect()
}
