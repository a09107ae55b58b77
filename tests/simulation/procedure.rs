//! What a step comes to, and what is reported of one that was decided.

use trackwright_procedure::*;
use trackwright_simulation::{Metric, Requirement};
use trackwright_task::Task;

/// A built-in design in its room, and in one that is not to be had.
fn plan() -> Plan {
    let world = trackwright_project::open_builtin_without_meshes("pointer-on-head").unwrap();
    let design = world.document.design();
    let crf = trackwright_project::resolve_crf(design, &world.environment);
    let named = |file: &str| RoomName { name: String::new(), file: file.to_owned() };
    Plan {
        crf_targets: crf.iter().map(|judged| judged.target.clone()).collect(),
        crf_requirement: design.crf.as_ref().and_then(|crf| crf.requirement),
        requirement: design.requirement,
        rooms: vec![
            Room {
                name: named("own.env.ron"),
                is_for_now: false,
                studies: Ok(RoomStudies {
                    crf,
                    tool: trackwright_project::resolve(design, &world.environment),
                }),
            },
            Room {
                name: named("gone.env.ron"),
                is_for_now: false,
                studies: Err("gone".to_owned()),
            },
        ],
        recording: None,
        decided_crf: None,
        decided_tool: None,
        decided_built: None,
    }
}

/// With this bound of the tool's RMS error.
fn bounded(mut plan: Plan, position_rms_mm: Option<f64>) -> Plan {
    plan.requirement =
        position_rms_mm.map(|limit| Requirement::at_most([(Metric::TIP_RMS, limit)]));
    let readable = plan.rooms.iter_mut().filter_map(|room| room.studies.as_mut().ok());
    for studies in readable {
        studies.tool.requirement = plan.requirement;
    }
    plan
}

fn judged(plan: Plan) -> StepStatus {
    step_status(plan, &Task::default()).unwrap()
}

fn studies(found: &StepStatus, step: Step) -> DecidedStudies {
    match found.basis(step).unwrap() {
        DecisionBasis::Studies(studies) => studies,
        DecisionBasis::Recording(_) => panic!("{step} has studies"),
    }
}

#[test]
fn only_rooms_with_figures_decide_a_requirement() {
    let found = judged(bounded(plan(), None));
    assert_eq!(found.tool.state, State::NoRequirement);
    let Ok(own) = &found.tool.rows[0].studied else {
        panic!("{:?}", found.tool.rows[0]);
    };
    let figure = own.figures.get(Metric::TIP_RMS).expect("the room is there");
    let (low, high) = figure.low.zip(figure.high).expect("the room was measured");
    let value = figure.value;
    for (limit, state) in
        [(high, State::Met), (value, State::CannotTell), (0.999 * low, State::Missed)]
    {
        let found = judged(bounded(plan(), Some(limit)));
        assert_eq!(found.tool.state, state);
        let counts = RowCounts {
            with_figures: 1,
            missed: usize::from(state == State::Missed),
            cannot_tell: usize::from(state == State::CannotTell),
        };
        assert_eq!(found.tool.counts(), counts);
        let objection = found.objection(Step::Tool);
        assert_eq!(objection.is_none(), state == State::Met, "{objection:?}");
        let words = headline(&found, Step::Tool);
        assert!(words.contains("of 1 room; one has no figures"), "{words}");
    }
    let mut nowhere = plan();
    nowhere.rooms.remove(0);
    let found = judged(nowhere);
    assert_eq!((found.crf.state, found.tool.state), (State::NoFigures, State::NoFigures));
    // Every target of the CRF has its row there too.
    assert_eq!(found.crf.rows.len(), plan().crf_targets.len());
    let why = found.basis(Step::Tool).unwrap_err().to_string();
    assert!(why.contains("gone"), "{why}");
}

#[test]
fn a_step_stays_decided_until_an_input_changes() {
    let first = judged(bounded(plan(), Some(10.0)));
    let decided = || Plan {
        decided_crf: Some(studies(&first, Step::Crf)),
        decided_tool: Some(studies(&first, Step::Tool)),
        ..bounded(plan(), Some(10.0))
    };
    let found = judged(decided());
    assert_eq!((found.crf.state, found.tool.state), (State::Decided, State::Decided));

    let changes_of = |plan: Plan, step: Step| {
        let found = judged(plan);
        assert_eq!(found.state(step), State::DecidedOnOtherFigures);
        let changes = found.changes(step).iter();
        changes.map(ToString::to_string).collect::<Vec<_>>()
    };
    let stricter = bounded(decided(), Some(9.0));
    assert_eq!(changes_of(stricter, Step::Tool), ["required position_rms was 10, is 9"]);
    let mut fewer = decided();
    fewer.rooms.pop();
    assert_eq!(changes_of(fewer.clone(), Step::Tool), ["gone.env.ron: not judged any more"]);
    assert_eq!(changes_of(fewer, Step::Crf).len(), plan().crf_targets.len());
    let mut more = decided();
    let mut attic = more.rooms[1].clone();
    attic.name.file = "attic.env.ron".to_owned();
    more.rooms.push(attic);
    assert_eq!(changes_of(more.clone(), Step::Tool), ["attic.env.ron: not judged then"]);
    more.rooms[2].is_for_now = true;
    assert_eq!(judged(more).tool.state, State::Decided);
    let mut lost = decided();
    lost.rooms[0].studies = Err("lost".to_owned());
    assert_eq!(changes_of(lost, Step::Tool), ["own.env.ron: no figures any more: lost"]);
    let mut found_again = decided();
    found_again.rooms[1].studies = found_again.rooms[0].studies.clone();
    assert_eq!(changes_of(found_again, Step::Tool), ["gone.env.ron: has figures, had none"]);
    let mut moved = decided();
    if let Ok(studies) = &mut moved.rooms[0].studies {
        studies.tool.crf_from_tool.translation.vector.y += 15.0;
    }
    let moved_changes = changes_of(moved, Step::Tool);
    assert!(
        moved_changes.iter().any(|change| change.contains("tip error RMS was ")),
        "{moved_changes:?}"
    );
}

#[test]
fn a_missing_recording_invalidates_its_decision() {
    let decided = DecidedRecording {
        room: RoomName::default(),
        recording: trackwright_calibration::agreement::BuiltRecording::of("a.csv".to_owned()),
        poses: 20,
        used: 20,
        measured_rms_mm: 1.0,
        predicted_rms_mm: 1.0,
        residual_rms_mm: 0.1,
        explained: Some(0.99),
        slope: Some(1.0),
        statement: String::new(),
    };
    let with = |recording| Plan { recording, decided_built: Some(decided.clone()), ..plan() };
    let found = judged(with(None));
    assert_eq!(found.built.state, State::Decided);
    let found = judged(with(Some(Err("a.csv: no such file".to_owned()))));
    assert_eq!(found.built.state, State::DecidedOnOtherFigures);
    let change = found.changes(Step::Built)[0].to_string();
    assert_eq!(change, "no figures any more: a.csv: no such file");
    assert!(matches!(found.basis(Step::Built), Err(Undecidable::NoFigures { .. })));
}
