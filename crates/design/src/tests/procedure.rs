//! The procedure as it is edited.

use super::*;
use trackwright_calibration::agreement::BuiltRecording;
use trackwright_procedure::{
    DecidedFigures, DecidedRecording, DecidedRow, DecidedStudies, DecisionBasis, RoomName, Step,
};
use trackwright_simulation::requirement::Requirement;
use trackwright_simulation::{Metric, Verdict};

fn studies(rms: f64) -> DecisionBasis {
    let room = RoomName { name: "OR".into(), file: "room.env.ron".into() };
    let requirement = Requirement::at_most([(Metric::TIP_RMS, 1.0)]);
    let figures = DecidedFigures {
        trials: 3,
        without_field: 0,
        values: Metric::decided().zip([rms, 0.4, 0.8, 0.9, 0.0, 0.0, 0.0]).collect(),
        are_expected: true,
        verdict: Some(if rms <= 1.0 { Verdict::Met } else { Verdict::Missed }),
    };
    DecisionBasis::Studies(DecidedStudies {
        requirement: Some(requirement),
        rows: vec![DecidedRow { room, target: None, figures: Ok(figures) }],
    })
}

fn recording() -> DecisionBasis {
    DecisionBasis::Recording(Box::new(DecidedRecording {
        room: RoomName { name: "OR".into(), file: "room.env.ron".into() },
        recording: BuiltRecording::of("built.csv".into()),
        poses: 20,
        used: 12,
        measured_rms_mm: 1.0,
        predicted_rms_mm: 0.9,
        residual_rms_mm: 0.3,
        explained: Some(0.9),
        slope: None,
        statement: "So.".into(),
    }))
}

fn decide(step: Step, basis: DecisionBasis) -> Edit {
    let date = "2005-10-26".parse().unwrap();
    Edit::Procedure(ProcedureEdit::Decide {
        step,
        decision: Box::new(Decision { date, note: String::new(), basis }),
    })
}

fn add_room(file: &str) -> Edit {
    Edit::Procedure(ProcedureEdit::AddRoom(file.to_owned()))
}

fn remove_room(file: &str) -> Edit {
    Edit::Procedure(ProcedureEdit::RemoveRoom(file.to_owned()))
}

#[test]
fn rooms_and_decisions_are_undone_by_name() {
    let mut document = document();
    let withdraw = Edit::Procedure(ProcedureEdit::Withdraw { step: Step::Tool });
    let edits = [
        (add_room("ward.env.ron"), "Add room"),
        (decide(Step::Crf, studies(0.5)), "Decide on CRF alone"),
        (decide(Step::Tool, studies(1.5)), "Decide on tool"),
        (decide(Step::Tool, studies(0.7)), "Decide on tool"),
        (decide(Step::Built, recording()), "Decide on built tool"),
        (withdraw, "Withdraw decision on tool"),
        (remove_room("ward.env.ron"), "Remove room"),
    ];
    let mut states = vec![document.shared_design()];
    for (edit, _) in &edits {
        document.apply(edit.clone()).unwrap();
        states.push(document.shared_design());
    }
    let last = &states[edits.len()].procedure;
    let decided: Vec<_> = last.decisions().map(|(step, _)| step).collect();
    assert_eq!(decided, [Step::Crf, Step::Built]);
    assert!(last.further_rooms.is_empty());
    let before_withdrawal = states[edits.len() - 2].procedure.decision(Step::Tool);
    assert_eq!(before_withdrawal.unwrap().basis, studies(0.7));
    for (state, (_, label)) in states.iter().zip(&edits).rev() {
        assert_eq!(document.undo().as_deref(), Some(*label));
        assert_eq!(document.design(), &**state);
    }
    assert!(!document.is_dirty());
}

#[test]
fn what_cannot_be_leaves_the_procedure_as_it_is() {
    let mut document = document();
    document.apply(add_room("ward.env.ron")).unwrap();
    let withdraw = Edit::Procedure(ProcedureEdit::Withdraw { step: Step::Built });
    let mut of_nan = studies(0.5);
    if let DecisionBasis::Studies(studies) = &mut of_nan
        && let Ok(figures) = &mut studies.rows[0].figures
    {
        figures.values.set(Metric::named("position_mean").unwrap(), Some(f64::NAN));
    }
    let mut lie = studies(1.5);
    if let DecisionBasis::Studies(studies) = &mut lie
        && let Ok(figures) = &mut studies.rows[0].figures
    {
        figures.verdict = Some(Verdict::Met);
    }
    for (edit, message) in [
        (add_room(" "), "the further room's file is empty, expected a name"),
        (add_room("ward.env.ron"), "the design is judged in ward.env.ron already"),
        (add_room("room.env.ron"), "the design is judged in room.env.ron already"),
        (
            remove_room("attic.env.ron"),
            "the design is not judged in \"attic.env.ron\", expected one of its further rooms",
        ),
        (withdraw, "nothing is decided on the built tool"),
        (
            decide(Step::Built, studies(0.5)),
            "decision: the built tool is decided on a recording, found studies",
        ),
        (
            decide(Step::Crf, recording()),
            "decision: the CRF alone is decided on studies, found a recording",
        ),
        (
            decide(Step::Tool, of_nan),
            "decision: rows[0].position.mean is NaN, expected zero or more",
        ),
        (
            decide(Step::Tool, lie),
            "decision: rows[0].verdict is met, expected what its figures allow",
        ),
    ] {
        let before = document.shared_design();
        let error = document.apply(edit).unwrap_err();
        assert_eq!(error.to_string(), message);
        assert_eq!(document.design(), &*before);
    }
    for index in 1..MAX_FURTHER_ROOMS {
        document.apply(add_room(&format!("{index}.env.ron"))).unwrap();
    }
    let error = document.apply(add_room("one more")).unwrap_err();
    assert_eq!(error, EditError::TooManyRooms);
}

#[test]
fn without_a_crf_nothing_is_decided_on_it() {
    let mut design = design();
    design.crf = None;
    let mut document = Document::new(design, View::default(), Origin::BuiltIn("x"));
    let error = document.apply(decide(Step::Crf, studies(0.5))).unwrap_err();
    assert_eq!(error, EditError::NoCrf);
    document.apply(decide(Step::Tool, studies(0.5))).unwrap();
}
