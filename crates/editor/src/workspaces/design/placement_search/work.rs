//! The search itself, on threads of its own.

use crate::workspaces::design::placement_search::state::{
    Found, SearchError, SearchResult, Searched,
};
use rayon::ThreadPoolBuilder;
use std::sync::mpsc::channel;
use std::time::Instant;
use trackwright_design::BodyRole;
use trackwright_optimization::{Problem, Settings, optimize};
use trackwright_project::{Files, World, design_rooms, placement_problem};
use trackwright_report::drawing::BodyOutline;
use trackwright_task::{CancelToken, Hold, Task};

/// What is searched, in all rooms of the design, and how it is ended.
pub struct SearchJob<'a> {
    pub world: &'a World,
    pub of: &'a Searched,
    pub settings: Settings,
    /// Lets it wait while frames are drawn.
    pub hold: &'a Hold,
    /// Ends it with the best so far.
    pub enough: &'a CancelToken,
    pub task: &'a Task,
}

impl SearchJob<'_> {
    /// Searches; `report` gets each better layout.
    pub fn run(&self, report: &mut dyn FnMut(Found)) -> Result<SearchResult, SearchError> {
        let (sender, better) = channel();
        let mut found = Err(SearchError::StoppedEarly);
        // Of its own: what a hand waits for must not queue behind held work.
        let pool = ThreadPoolBuilder::new().thread_name(|_| "placement search".to_owned());
        pool.build()?.in_place_scope(|scope| {
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
        let Self { world, of, settings, hold, .. } = self;
        let (enough, task) = (self.enough.held_by(hold), self.task.held_by(hold));
        let start = Instant::now();
        let rooms = design_rooms(&Files::default(), world)?;
        let moves = of.wish.moves(&of.design);
        let problem = placement_problem(world, &rooms, moves, of.goal, of.wish.rooms);
        let problem = Problem { built: of.wish.built.unless_exact(), ..problem };
        let optimized = optimize(&problem, settings, &enough, &task, &mut |progress| {
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
