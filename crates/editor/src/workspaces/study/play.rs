//! Answers requests to the Study workspace, and plays trials one after the other.

use crate::document::requests::{FileRequest, OpenWorld};
use crate::document::trials::{ModeKind, TrialChoice};
use crate::runner::results::Results;
use crate::runner::solve::SolverSystems;
use crate::schedule::EditorSystems;
use crate::workspaces::study::are_trials_shown;
use crate::workspaces::study::state::{StudyRequest, StudyState};
use bevy::prelude::*;
use bevy::window::RequestRedraw;
use trackwright_simulation::trial_count;

/// Longest step of one frame, seconds: after the window was hidden playing goes on, and does not
/// jump.
const LONGEST_STEP_S: f64 = 1.0;

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<StudyState>().add_message::<StudyRequest>().add_systems(
        Update,
        (
            advance.run_if(is_playing.and_then(are_trials_shown)),
            answer.run_if(on_message::<StudyRequest>),
            show_worst.run_if(is_worst_due),
        )
            .chain()
            .in_set(EditorSystems::Edit),
    );
    // Also in the frame that receives the study: none may follow.
    app.add_systems(
        Update,
        show_worst.run_if(is_worst_due).after(SolverSystems).in_set(EditorSystems::Solve),
    );
}

fn is_playing(choice: Res<TrialChoice>) -> bool {
    choice.is_playing()
}

fn answer(
    mut requests: MessageReader<StudyRequest>,
    mut choice: ResMut<TrialChoice>,
    mut state: ResMut<StudyState>,
    world: Option<Res<OpenWorld>>,
    mut files: MessageWriter<FileRequest>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let Some(world) = world else {
        requests.clear();
        return;
    };
    for request in requests.read() {
        let last = || last_trial(&world.0, &choice);
        // Another choice of a trial takes the place of one that is awaited.
        let is_worst = matches!(request, StudyRequest::ShowWorst);
        let chooses = matches!(
            request,
            StudyRequest::Choose(_)
                | StudyRequest::Show(_)
                | StudyRequest::Step(_)
                | StudyRequest::TogglePlay
        );
        state.awaits_worst = is_worst || (state.awaits_worst && !chooses);
        match *request {
            StudyRequest::Choose(ModeKind::Input) if choice.input().is_none() => {
                files.write(FileRequest::ShowReadInput);
            }
            StudyRequest::Choose(kind) => choice.choose(kind),
            StudyRequest::Show(trial) => choice.show(trial),
            StudyRequest::Step(by) => {
                if let Some(last) = last() {
                    let next = match choice.trial {
                        Some(trial) => trial.saturating_add_signed(by).min(last),
                        None if by < 0 => last,
                        None => 0,
                    };
                    choice.show(Some(next));
                }
            }
            StudyRequest::ShowWorst => {}
            StudyRequest::TogglePlay => {
                choice.playing = match (choice.playing, last()) {
                    (None, Some(last)) if last > 0 => Some(match choice.trial {
                        Some(trial) if trial < last => trial as f64,
                        // At the end it begins anew.
                        _ => 0.0,
                    }),
                    _ => None,
                };
            }
            StudyRequest::SetRate(rate_per_s) => state.rate_per_s = rate_per_s,
            StudyRequest::ShowSide(side) => state.side = side,
            StudyRequest::ShowRotation(form) => state.rotation = form,
            StudyRequest::ShowAxis(axis) => state.axis = axis,
            StudyRequest::CancelLog => continue,
        }
        if let Some(position) = choice.playing {
            choice.trial = Some(position as usize);
        }
        redraw.write(RequestRedraw);
    }
}

/// Whether the worst trial is awaited and known: of all trials of the document as it is.
fn is_worst_due(
    state: Res<StudyState>,
    world: Option<Res<OpenWorld>>,
    results: Res<Results>,
) -> bool {
    let revision = world.map(|world| world.0.document.revision());
    let study = results.study.as_ref().filter(|_| results.is_whole());
    state.awaits_worst && study.is_some_and(|study| Some(study.revision) == revision)
}

fn show_worst(
    mut state: ResMut<StudyState>,
    mut choice: ResMut<TrialChoice>,
    world: Res<OpenWorld>,
    results: Res<Results>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    state.awaits_worst = false;
    if let (Some(study), Some(_)) = (&results.study, last_trial(&world.0, &choice)) {
        choice.show(Some(study.value.room_field.worst.trial));
        redraw.write(RequestRedraw);
    }
}

/// Runs before requests are answered: the frame that starts playing shows the first trial.
fn advance(
    time: Res<Time<Real>>,
    mut choice: ResMut<TrialChoice>,
    state: Res<StudyState>,
    world: Option<Res<OpenWorld>>,
    mut redraw: MessageWriter<RequestRedraw>,
) {
    let last = world.and_then(|world| last_trial(&world.0, &choice));
    let (Some(position), Some(last)) = (choice.playing, last) else {
        choice.playing = None;
        return;
    };
    let step = time.delta_secs_f64().min(LONGEST_STEP_S) * state.rate_per_s;
    let next = position + step;
    choice.trial = Some((next as usize).min(last));
    choice.playing = (next < last as f64).then_some(next);
    // While it plays the next frame follows at once; the last one shows the last trial.
    redraw.write(RequestRedraw);
}

/// `None` where there are no trials to go through, as for a single pose.
fn last_trial(world: &trackwright_project::World, choice: &TrialChoice) -> Option<usize> {
    let scenario = trackwright_project::resolve(world.document.design(), &world.environment);
    let trials = trial_count(&scenario, &choice.mode(&scenario))?;
    (trials > 1).then(|| trials - 1)
}
