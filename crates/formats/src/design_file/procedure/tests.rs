//! Decisions in design files: the same to the bit once written, refused where they cannot be.

use super::super::{DesignFile, parse, write};
use crate::test_cases::{any_text, assert_refused};
use proptest::prelude::*;
use trackwright_calibration::agreement::{BuiltRecording, RecordedFrame};
use trackwright_design::{Day, Decision, Procedure};
use trackwright_procedure::{
    DecidedFigures, DecidedRecording, DecidedRow, DecidedStudies, DecisionBasis, RoomName, Step,
};
use trackwright_simulation::requirement::Requirement;
use trackwright_simulation::{Metric, Verdict};

fn design(procedure: Procedure) -> DesignFile {
    let mut file = parse(DECIDED.as_bytes()).unwrap();
    file.design.procedure = procedure;
    file
}

/// With a decision on the tool and one on what was built.
const DECIDED: &str = r#"(
    version: 1,
    name: "Pointer",
    environment: "or.env.ron",
    tool: (
        body: "pointer.body.ron",
        pose: (position: (0.0, 0.0, 0.0), rotation: (1.0, 0.0, 0.0, 0.0)),
    ),
    procedure: (
        rooms: ["ward.env.ron"],
        tool: (
            date: "2005-10-26",
            note: "good enough \"here\"",
            requirement: (position_rms: 1.0),
            rows: [
                (
                    room: "OR",
                    file: "or.env.ron",
                    trials: 3375,
                    without_field: 12,
                    position: (rms: 0.48591, mean: 0.4, p95: 0.7, max: 0.9),
                    angle: (rms: 0.131, p95: 0.2, max: 0.3),
                    expected: true,
                    verdict: Met,
                ),
                (
                    room: "",
                    file: "ward.env.ron",
                    no_figures: "no such file",
                ),
            ],
        ),
        built: (
            date: "2005-10-27",
            room: "OR",
            file: "or.env.ron",
            table: "built.csv",
            poses: 91,
            used: 45,
            measured_rms: 4.0,
            predicted_rms: 3.22,
            residual_rms: 1.67,
            explained: 0.83,
            slope: 1.1,
            statement: "The simulation explains 83 %.",
        ),
    ),
)
"#;

#[test]
fn decisions_are_written_as_they_were_read() {
    let design = parse(DECIDED.as_bytes()).unwrap();
    let procedure = &design.design.procedure;
    assert_eq!(procedure.further_rooms, ["ward.env.ron"]);
    let steps: Vec<_> = procedure.decisions().map(|(step, _)| step).collect();
    assert_eq!(steps, [Step::Tool, Step::Built]);
    let tool = procedure.tool.as_ref().unwrap();
    assert_eq!(tool.date.to_string(), "2005-10-26");
    let DecisionBasis::Studies(studies) = &tool.basis else {
        panic!("{tool:?}");
    };
    let first = studies.rows[0].figures.as_ref().unwrap();
    assert_eq!((first.trials, first.without_field), (3375, 12));
    assert_eq!((first.values.get(Metric::TIP_MAX), first.verdict), (Some(0.9), Some(Verdict::Met)));
    assert_eq!(studies.rows[1].figures, Err("no such file".to_owned()));
    let text = write(&design);
    let ours = text.find("    procedure: (").unwrap();
    let theirs = DECIDED.find("    procedure: (").unwrap();
    assert_eq!(text[ours..], DECIDED[theirs..]);
}

#[test]
fn an_empty_procedure_is_not_written() {
    let text = write(&design(Procedure::default()));
    assert!(!text.contains("procedure"), "{text}");
    let empty = text.replace("    tool: (", "    procedure: (),\n    tool: (");
    assert!(parse(empty.as_bytes()).unwrap().design.procedure.is_empty());
}

#[test]
fn impossible_decisions_are_refused_by_field() {
    let cases = r#"
        "2005-10-26" => "2005-02-30"
            | procedure.tool.date is "2005-02-30", expected a day such as 2005-10-26
        "2005-10-27" => "yesterday"
            | procedure.built.date is "yesterday", expected a day such as 2005-10-26
        rms: 0.48591 => rms: NaN
            | procedure.tool.rows[0].position.rms is NaN, expected zero or more
        p95: 0.2 => p95: -0.2
            | procedure.tool.rows[0].angle.p95 is -0.2, expected zero or more
        position_rms: 1.0 => position_rms: -inf
            | procedure.tool.requirement.position_rms is -inf, expected zero or more
        verdict: Met => verdict: Missed
            | procedure.tool.rows[0].verdict is missed, expected what its figures allow
        verdict: Met,\n =>
            | procedure.tool.rows[0].verdict is absent, expected whether the requirement was met
        requirement: (position_rms: 1.0),\n =>
            | procedure.tool.rows[0].verdict is met, expected none without a requirement
        trials: 3375 => trials: 0 | procedure.tool.rows[0].trials is 0, expected one at least
        without_field: 12 => without_field: 3375
            | procedure.tool.rows[0].without_field is 3375, expected fewer than the trials
        trials: 3375, => no_figures: "none",
            | procedure.tool.rows is without figures, expected those of a room at least
        file: "or.env.ron",\n                    trials => file: " ",\n                    trials
            | procedure.tool.rows[0].file is empty, expected a file
        rooms: ["ward.env.ron"] => rooms: ["a", ""]
            | procedure.rooms[1] is empty, expected a file
        used: 45 => used: 92 | procedure.built.used is 92, expected no more than poses
        table: "built.csv" => table: "built.csv", averaged: 0
            | procedure.built.averaged is 0, expected one reading at least
        slope: 1.1 => slope: -inf | procedure.built.slope is -inf, expected a finite number
        residual_rms: 1.67 => residual_rms: -1.67
            | procedure.built.residual_rms is -1.67, expected zero or more
        trials: 3375 => trials: 99999999999999999999999 | …line 19…
        trials: 3375, => | …rows[0].trials is absent…
        verdict: Met => verdict: Some | …line 24…
    "#;
    assert_refused(DECIDED, cases, |text| parse(text.as_bytes()).unwrap_err().to_string());
}

fn positive() -> impl Strategy<Value = f64> {
    prop_oneof![0.0..10.0_f64, 0.0..=1e9_f64, Just(f64::MIN_POSITIVE)]
}

fn any_file() -> impl Strategy<Value = String> {
    any_text(0..12).prop_map(|text| format!("../a{text}.env.ron"))
}

fn any_room() -> impl Strategy<Value = RoomName> {
    (any_text(0..12), any_file()).prop_map(|(name, file)| RoomName { name, file })
}

fn any_day() -> impl Strategy<Value = Day> {
    (0..200_000_i64).prop_map(|days| Day::of_unix_seconds(86_400 * days).unwrap())
}

fn any_figures() -> impl Strategy<Value = DecidedFigures> {
    let numbers = prop::array::uniform7(positive());
    (1..1_000_000_usize, 0..1_000_000_usize, numbers).prop_map(|(trials, without_field, n)| {
        DecidedFigures {
            trials,
            without_field: without_field % trials,
            values: Metric::decided().zip(n.into_iter().cycle()).collect(),
            are_expected: true,
            verdict: None,
        }
    })
}

fn any_row() -> impl Strategy<Value = DecidedRow> {
    let figures = prop_oneof![
        3 => any_figures().prop_map(Ok),
        1 => any_text(0..12).prop_map(Err),
    ];
    let target = prop::option::of(any_text(0..12));
    (any_room(), target, figures).prop_map(|(room, target, figures)| DecidedRow {
        room,
        target,
        figures,
    })
}

fn any_studies() -> impl Strategy<Value = DecidedStudies> {
    let bound = prop::option::of(0.0..=3600.0_f64);
    let bounds = prop::collection::vec(bound, Metric::bounded().count());
    let requirement = bounds.prop_map(|bounds| {
        let each = Metric::bounded().zip(bounds);
        each.fold(Requirement::default(), |all, (metric, bound)| all.with(metric, bound))
    });
    let rows = prop::collection::vec(any_row(), 0..4);
    (prop::option::of(requirement), any_row(), any_figures(), rows).prop_map(
        |(requirement, first, figures, mut rows)| {
            rows.push(DecidedRow { figures: Ok(figures), ..first });
            for figures in rows.iter_mut().filter_map(|row| row.figures.as_mut().ok()) {
                let beyond =
                    |(metric, limit)| figures.values.get(metric).is_some_and(|v| v > limit);
                let mut bounds = requirement.iter().flat_map(|r| r.bounds()).peekable();
                figures.verdict = bounds.peek().is_some().then(|| match bounds.any(beyond) {
                    true => Verdict::Missed,
                    false => Verdict::CannotTell,
                });
            }
            DecidedStudies { requirement, rows }
        },
    )
}

fn any_recording() -> impl Strategy<Value = DecidedRecording> {
    let tables = (any_file(), prop::option::of(any_file()), any::<[bool; 2]>());
    let taken = (1..=u32::MAX, positive(), prop::option::of(any_text(0..12)));
    let recording = (tables, taken).prop_map(
        |((table, crf_table, [in_crf, is_registered]), (averaged, truth_std_mm, whole))| {
            BuiltRecording {
                table,
                crf_table,
                frame: match in_crf {
                    true => RecordedFrame::Crf,
                    false => RecordedFrame::Tracker,
                },
                is_registered,
                averaged,
                truth_std_mm,
                whole,
            }
        },
    );
    let part = || prop::option::of(-1e9..1e9_f64);
    let counts = (0..1000_usize, 0..1000_usize);
    let figures = (prop::array::uniform3(positive()), part(), part());
    (any_room(), recording, counts, figures, any_text(0..12)).prop_map(
        |(room, recording, (used, more), ([m, p, r], explained, slope), statement)| {
            DecidedRecording {
                room,
                recording,
                poses: used + more,
                used,
                measured_rms_mm: m,
                predicted_rms_mm: p,
                residual_rms_mm: r,
                explained,
                slope,
                statement,
            }
        },
    )
}

fn decided(basis: impl Strategy<Value = DecisionBasis>) -> impl Strategy<Value = Option<Decision>> {
    prop::option::of((any_day(), any_text(0..12), basis).prop_map(|(date, note, basis)| Decision {
        date,
        note,
        basis,
    }))
}

fn any_procedure() -> impl Strategy<Value = Procedure> {
    let recording =
        any_recording().prop_map(|recording| DecisionBasis::Recording(Box::new(recording)));
    (
        prop::collection::vec(any_file(), 0..3),
        decided(any_studies().prop_map(DecisionBasis::Studies)),
        decided(any_studies().prop_map(DecisionBasis::Studies)),
        decided(recording),
    )
        .prop_map(|(further_rooms, crf, tool, built)| Procedure {
            further_rooms,
            crf,
            tool,
            built,
        })
}

proptest! {
    #[test]
    fn whatever_was_decided_reads_back_to_the_bit(procedure in any_procedure()) {
        let file = design(procedure);
        let text = write(&file);
        let again = parse(text.as_bytes());
        prop_assert_eq!(again.as_ref(), Ok(&file), "{}", text);
        // Equal numbers may differ in their sign.
        prop_assert_eq!(write(&again.unwrap()), text);
    }

    #[test]
    fn a_file_cut_in_its_decisions_is_refused(cut in 0..DECIDED.len() - 2) {
        prop_assert!(parse(&DECIDED.as_bytes()[..cut]).is_err());
    }
}
