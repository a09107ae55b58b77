//! The search itself, on threads of its own that leave the processor to what draws.

use crate::workspaces::design::placement_search::state::{
    Found, SearchError, SearchResult, Searched,
};
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::num::NonZero;
use std::sync::mpsc::channel;
use std::time::Instant;
use thread_priority::ThreadPriority;
use trackwright_design::BodyRole;
use trackwright_optimization::{Settings, optimize};
use trackwright_project::{Files, World, design_rooms, placement_problem};
use trackwright_report::drawing::BodyOutline;
use trackwright_task::{CancelToken, Task};

/// Where frames are drawn meanwhile, threads for half of the processors that run while nothing else
/// wants these: memory and caches are shared with what draws.
fn pool(gives_way: bool) -> Result<ThreadPool, ThreadPoolBuildError> {
    let pool = ThreadPoolBuilder::new().thread_name(|_| "placement search".to_owned());
    if !gives_way {
        return pool.build();
    }
    let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
    // Where the system refuses it the search is as good, and frames are fewer.
    let pool = pool.start_handler(|_| drop(run_when_idle()));
    pool.num_threads(processors.div_ceil(2)).build()
}

/// Under Linux a thread of this policy is preempted at once by any other. A low priority alone
/// would let it keep the processor for a time slice, some 3 ms, at each wake of a thread that draws.
#[cfg(target_os = "linux")]
fn run_when_idle() -> Result<(), thread_priority::Error> {
    use thread_priority::{
        NormalThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy,
        thread_native_id,
    };
    set_thread_priority_and_policy(
        thread_native_id(),
        ThreadPriority::Min,
        ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Idle),
    )
}

#[cfg(not(target_os = "linux"))]
fn run_when_idle() -> Result<(), thread_priority::Error> {
    thread_priority::set_current_thread_priority(ThreadPriority::Min)
}

/// What is searched, in all rooms of the design, and how it is ended.
pub struct SearchJob<'a> {
    pub world: &'a World,
    pub of: &'a Searched,
    pub settings: Settings,
    /// See [`PlacementSearch::gives_way`](super::state::PlacementSearch::gives_way).
    pub gives_way: bool,
    /// Ends it with the best so far.
    pub enough: &'a CancelToken,
    pub task: &'a Task,
}

impl SearchJob<'_> {
    /// Searches; `report` gets each better layout.
    pub fn run(&self, report: &mut dyn FnMut(Found)) -> Result<SearchResult, SearchError> {
        let (sender, better) = channel();
        let mut found = Err(SearchError::StoppedEarly);
        pool(self.gives_way)?.in_place_scope(|scope| {
            let found = &mut found;
            scope.spawn(move |_| {
                *found = self.find(&mut |better| {
                    // The receiver lives as long as the search.
                    let _ = sender.send(better);
                });
            });
            better.into_iter().for_each(report);
        });
        found
    }

    fn find(&self, report: &mut dyn FnMut(Found)) -> Result<SearchResult, SearchError> {
        let Self { world, of, settings, enough, task, .. } = self;
        let start = Instant::now();
        let rooms = design_rooms(&Files::default(), world)?;
        let moves = of.wish.moves(&of.design);
        let problem = placement_problem(world, &rooms, moves, of.goal, of.wish.rooms);
        let optimized = optimize(&problem, settings, enough, task, &mut |progress| {
            let after_secs = start.elapsed().as_secs_f64();
            let (best, evaluations) = (Box::new(progress.best.clone()), progress.evaluations);
            report(Found::Better { best, evaluations, after_secs });
        });
        Ok(SearchResult {
            optimized: optimized.map_err(SearchError::Search)?,
            outlines: outlines(world, of),
            rooms: rooms.iter().map(|room| room.name.clone()).collect(),
            took_secs: start.elapsed().as_secs_f64(),
        })
    }
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
