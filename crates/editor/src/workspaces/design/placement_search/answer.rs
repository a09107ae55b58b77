//! Answers requests to the panel, and receives what the search finds.

use crate::document::requests::{EditRequest, OpenWorld};
use crate::document::state::WorldGeneration;
use crate::runner::jobs::{JobInfo, Work};
use crate::workspaces::design::placement_search::state::{
    AnswerId, Found, PlacementSearch, PlacementSearchRequest, Running, Searched,
};
use crate::workspaces::design::placement_search::wish::Wish;
use crate::workspaces::design::placement_search::work::SearchJob;
use bevy::prelude::*;
use std::sync::Arc;
use trackwright_design::{Document, Edit, EditError};
use trackwright_project::layout_edits;
use trackwright_simulation::figures::capitalised;
use trackwright_task::CancelToken;

/// What undo calls the step.
pub const STEP: &str = "Take better places";

/// Another design has other sensors; one that was edited is another one than was searched.
pub(super) fn follow_document(
    mut search: ResMut<PlacementSearch>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
    mut last: Local<Option<u64>>,
) {
    if last.replace(generation.0).is_some_and(|last| last != generation.0) {
        search.forget();
        search.wish = search.is_open.then(|| Wish::of(world.0.document.design()));
    }
    let is_current = is_current(&search, &world, generation.0);
    if search.is_current != is_current {
        search.is_current = is_current;
    }
}

fn is_current(search: &PlacementSearch, world: &OpenWorld, generation: u64) -> bool {
    search.searched().is_some_and(|searched| searched.is_of(world, generation))
}

pub(super) fn answer(
    mut requests: MessageReader<PlacementSearchRequest>,
    mut search: ResMut<PlacementSearch>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
    mut edits: MessageWriter<EditRequest>,
) {
    let document = &world.0.document;
    for request in requests.read() {
        match request {
            PlacementSearchRequest::Open => {
                search.is_open = true;
                search.wish.get_or_insert_with(|| Wish::of(document.design()));
            }
            PlacementSearchRequest::Close => {
                search.is_open = false;
                search.hovered = None;
            }
            PlacementSearchRequest::Set(wish) => search.wish = Some(wish.clone()),
            PlacementSearchRequest::ShowSettings(shown) => search.shows_settings = *shown,
            PlacementSearchRequest::Start => start(&mut search, &world, generation.0),
            PlacementSearchRequest::Stop => {
                if let Some(running) = &search.running {
                    running.enough.cancel();
                }
            }
            PlacementSearchRequest::Show(answer) => search.selected = *answer,
            PlacementSearchRequest::Hover(answer) => search.hovered = *answer,
            PlacementSearchRequest::Take(answer) => {
                take(&mut search, document, *answer, &mut edits);
            }
        }
    }
}

fn start(search: &mut PlacementSearch, world: &OpenWorld, generation: u64) {
    let document = &world.0.document;
    let wish = search.wish.get_or_insert_with(|| Wish::of(document.design())).clone();
    search.forget();
    search.shows_settings = false;
    let goal = match (wish.refusal(document.design()), wish.goal(document.design())) {
        (None, Some(goal)) => goal,
        (refusal, _) => {
            search.problem = refusal;
            return;
        }
    };
    let searched = Arc::new(Searched {
        generation,
        revision: document.revision(),
        design: document.shared_design(),
        room: Arc::clone(&world.0.environment),
        wish,
        goal,
    });
    let enough = CancelToken::default();
    search.running = Some(Running {
        of: Arc::clone(&searched),
        enough: enough.clone(),
        best: None,
        evaluations: 0,
    });
    search.is_current = true;
    let (settings, hold) = (search.settings, search.hold.clone());
    let (open, of) = (world.0.clone(), Arc::clone(&searched));
    let work: Work<Found> = Box::new(move |task, report| {
        let job = SearchJob { world: &open, of: &of, settings, hold: &hold, enough: &enough, task };
        Some(Found::End(Box::new(job.run(report))))
    });
    search.runner.submit(JobInfo::default(), searched, work);
}

/// Requests the edits as one undo step.
fn take(
    search: &mut PlacementSearch,
    document: &Document,
    answer: AnswerId,
    edits: &mut MessageWriter<EditRequest>,
) {
    let result = search.result.as_ref().filter(|_| search.is_current);
    let Some(layout) = result.and_then(|(_, result)| result.layout(answer)) else {
        return;
    };
    let steps = layout_edits(document.design(), layout);
    // A step is taken whole or not at all.
    if let Err(error) = try_edits(document, &steps) {
        search.problem = Some(capitalised(&error.to_string()));
        return;
    }
    search.hovered = None;
    edits.write_batch(EditRequest::step(STEP, steps));
}

fn try_edits(document: &Document, edits: &[Edit]) -> Result<(), EditError> {
    let mut document = document.clone();
    for edit in edits {
        document.apply(edit.clone())?;
    }
    Ok(())
}

pub(super) fn receive(
    mut search: ResMut<PlacementSearch>,
    world: Res<OpenWorld>,
    generation: Res<WorldGeneration>,
) {
    let answers = search.bypass_change_detection().runner.answers();
    for answer in answers.into_iter().filter(|answer| answer.is_newest) {
        match answer.value {
            Ok(Found::Better { best, evaluations, after_secs }) => {
                search.curve.push([after_secs, best.objective]);
                if let Some(running) = &mut search.running {
                    running.best = Some(best);
                    running.evaluations = evaluations;
                }
            }
            Ok(Found::End(found)) => {
                search.running = None;
                match *found {
                    Ok(result) => {
                        search.selected = AnswerId::Candidate(0);
                        search.hovered = None;
                        search.result = Some((answer.key, result));
                        search.is_current = is_current(&search, &world, generation.0);
                    }
                    Err(error) => search.problem = Some(capitalised(&error.to_string())),
                }
            }
            Err(lost) => {
                search.running = None;
                search.problem = Some(capitalised(&lost.to_string()));
            }
        }
    }
}
