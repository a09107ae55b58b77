//! The panels of the Study workspace as functions.

use super::app::world;
use super::harness::panel;
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use trackwright_editor::document::shown::ShownTrial;
use trackwright_editor::document::trials::ModeKind;
use trackwright_editor::workspaces::study::commands::{
    NEXT, OWN_POSE, PLAY, PREVIOUS, READ_INPUT, WORST, WRITE_LOG, choose,
};
use trackwright_editor::workspaces::study::state::{RotationForm, StudyRequest};
use trackwright_editor::workspaces::study::study_charts_ui::{StudyChartsView, study_charts_ui};
use trackwright_editor::workspaces::study::timeline_ui::{
    TimelineAction, TimelineView, timeline_ui,
};
use trackwright_editor::workspaces::study::trial_ui::{TrialView, trial_ui};
use trackwright_geometry::rotation::log_quaternion;
use trackwright_project::MeasuredError;
use trackwright_simulation::{
    CancelToken, ChartedProfile, Mode, PoseDetail, Scenario, TrialSource, simulate_pose,
    source_words, study_profiled, trial_offsets, trial_pose,
};

fn scenario() -> Scenario {
    let world = world();
    trackwright_project::resolve(world.document.design(), &world.environment)
}

fn charted(scenario: &Scenario) -> ChartedProfile {
    let token = CancelToken::default();
    let (_, profile) = study_profiled(scenario, &Mode::Motion, &token).unwrap();
    ChartedProfile::new(profile.unwrap(), scenario.requirement.as_ref())
}

fn trial(scenario: &Scenario, number: usize) -> ShownTrial {
    ShownTrial {
        number,
        of: 15,
        kind: ModeKind::Motion,
        offsets: trial_offsets(scenario, &Mode::Motion, number),
        pose: trial_pose(scenario, &Mode::Motion, number).unwrap(),
    }
}

fn timeline<'a>(charted: &'a ChartedProfile, shown: Option<&'a ShownTrial>) -> TimelineView<'a> {
    TimelineView {
        kind: ModeKind::Motion,
        has_motion: true,
        input: None,
        trials: 15,
        shown,
        profile: Some(charted),
        measured: None,
        is_computing: false,
        is_playing: false,
        rate_per_s: 25.0,
        log_part: None,
    }
}

/// Without sources or what was measured.
fn trial_view(detail: &PoseDetail) -> TrialView<'_> {
    TrialView {
        trial: Some(&detail.trial),
        title: "Trial 1".to_owned(),
        columns: ["true", "simulated"],
        rotation: RotationForm::EulerAngles,
        has_crf: true,
        sources: &[],
        measured: None,
    }
}

fn click(harness: &mut Harness, at: egui::Pos2) {
    harness.event(egui::Event::PointerMoved(at));
    harness.run_steps(1);
    for pressed in [true, false] {
        harness.event(egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        });
        harness.run_steps(1);
    }
}

#[test]
fn timeline_buttons_are_commands() {
    let scenario = scenario();
    let (charted, shown) = (charted(&scenario), trial(&scenario, 3));
    let (mut harness, requests) =
        panel([1200.0, 156.0], |ui| timeline_ui(ui, &timeline(&charted, Some(&shown))));
    harness.run_steps(2);
    harness.get_by_label("trial 4 of 15: x \u{2212}50\u{2009}mm, rz 45°");
    for (label, command) in [
        ("Play or pause", PLAY),
        ("Next trial", NEXT),
        ("Previous trial", PREVIOUS),
        ("Worst", WORST),
        ("Own pose", OWN_POSE),
        ("Single pose", *choose(ModeKind::Single)),
        ("Input data…", READ_INPUT),
        ("Save all trials…", WRITE_LOG),
    ] {
        requests.borrow_mut().clear();
        harness.get_by_label(label).click();
        harness.run_steps(2);
        assert_eq!(*requests.borrow(), [TimelineAction::Run(command.name)], "{label}");
    }
}

#[test]
fn a_timeline_click_shows_its_trial() {
    let scenario = scenario();
    let charted = charted(&scenario);
    let (mut harness, requests) =
        panel([1200.0, 156.0], |ui| timeline_ui(ui, &timeline(&charted, None)));
    harness.run_steps(2);
    let mut shown = Vec::new();
    for x in [100.0, 620.0, 1190.0] {
        requests.borrow_mut().clear();
        click(&mut harness, egui::pos2(x, 90.0));
        let requests = requests.borrow();
        let Some(TimelineAction::Study(StudyRequest::Show(Some(trial)))) = requests.first() else {
            panic!("{requests:?}");
        };
        shown.push(*trial);
    }
    assert_eq!([shown[0], shown[2]], [0, 14]);
    assert!((6..=8).contains(&shown[1]), "{shown:?}");
}

#[test]
fn a_log_under_way_can_be_cancelled() {
    let scenario = scenario();
    let charted = charted(&scenario);
    let (mut harness, requests) = panel([1200.0, 156.0], |ui| {
        let view = TimelineView { log_part: Some(0.4), ..timeline(&charted, None) };
        timeline_ui(ui, &view)
    });
    harness.get_by_label("Cancel").click();
    harness.run_steps(2);
    let cancel = TimelineAction::Study(StudyRequest::CancelLog);
    assert_eq!(*requests.borrow(), [cancel]);
}

#[test]
fn a_study_of_too_many_trials_has_no_timeline() {
    let scenario = scenario();
    let charted = charted(&scenario);
    let (harness, _) = panel([1200.0, 156.0], |ui| {
        let view = TimelineView { profile: None, trials: 2_000_000, ..timeline(&charted, None) };
        timeline_ui(ui, &view)
    });
    harness.get_by_label_contains("2,000,000 trials: more than the 1,048,576");
}

#[test]
fn a_trial_is_shown_in_numbers_with_units() {
    let scenario = scenario();
    let pose = trial_pose(&scenario, &Mode::Motion, 3).unwrap();
    let detail = simulate_pose(&Scenario { crf_from_tool: pose.crf_from_tool, ..scenario });
    for (form, turn) in [
        (RotationForm::EulerAngles, 45.0),
        (RotationForm::Rodrigues, log_quaternion(&pose.crf_from_tool.rotation).z.to_degrees()),
    ] {
        let (mut harness, requests) = panel([276.0, 400.0], |ui| {
            let view =
                TrialView { title: "Trial 4".to_owned(), rotation: form, ..trial_view(&detail) };
            trial_ui(ui, &view)
        });
        harness.run_steps(1);
        harness.get_by_label("Trial 4 in the CRF");
        let turn = format!("{turn:.3}°");
        assert!(harness.query_all_by_label(&turn).count() >= 1, "{turn}");
        let error = detail.trial.tip_error_mm;
        harness.get_by_label(&format!("{error:.2}\u{2009}mm"));
        harness.get_by_label("vector").click();
        harness.run_steps(2);
        let show = StudyRequest::ShowRotation(RotationForm::Rodrigues);
        assert_eq!(*requests.borrow(), [show]);
    }
}

#[test]
fn a_recorded_pose_shows_what_was_measured() {
    let detail = simulate_pose(&scenario());
    let measured = MeasuredError {
        tip_error_in_crf_mm: nalgebra::Vector3::new(0.3, 0.0, -0.4),
        angle_error_deg: Some(0.125),
        crf_from_tool: None,
    };
    let (harness, _) = panel([276.0, 400.0], |ui| {
        trial_ui(ui, &TrialView { measured: Some(&measured), ..trial_view(&detail) })
    });
    harness.get_by_label("measured tip error");
    harness.get_by_label("0.50\u{2009}mm");
    harness.get_by_label("0.125°");
}

#[test]
fn contributions_are_listed_within_a_narrow_panel() {
    let detail = simulate_pose(&scenario());
    let source = |body, name: &str, along_tip_error_mm| TrialSource {
        body,
        name: name.to_owned(),
        along_tip_error_mm,
    };
    let none = Vec::new();
    let two = vec![source("tool", "front", 0.12), source("CRF", "left", -0.31)];
    let long = "a sensor whose name is longer than the panel is wide by half".to_owned();
    let many: Vec<TrialSource> = (0..9)
        .map(|k| source("tool", &format!("{long} {k}"), 0.1))
        .chain([source("tool", &"x".repeat(60), 0.2)])
        .collect();
    let starts = "tip error from ";
    for (sources, listed) in [(&none, 0), (&two, 2), (&many, 7)] {
        // 270 points between the margins.
        let (mut harness, _) =
            panel([286.0, 900.0], |ui| trial_ui(ui, &TrialView { sources, ..trial_view(&detail) }));
        harness.run_steps(2);
        let Some(text) = harness.query_by_label_contains(starts) else {
            assert_eq!(listed, 0);
            continue;
        };
        assert!(text.rect().right() <= 278.0, "{:?}", text.rect());
        let words = source_words(sources, 6, "\u{2009}");
        assert_eq!(words.len(), listed);
        harness.get_by_label(&format!("{starts}{}", words.join(", ")));
    }
    let words = source_words(&two, 6, "\u{2009}").join(", ");
    assert_eq!(words, "CRF left \u{2212}0.31\u{2009}mm, front 0.12\u{2009}mm");
}

#[test]
fn the_error_along_the_shaft_has_a_chart() {
    let charted = charted(&scenario());
    let mut bare = charted.clone();
    bare.profile.along_shaft = None;
    let shown = [charted, bare].map(|charted| {
        let (mut harness, _) = panel([276.0, 700.0], |ui| {
            let view = StudyChartsView { charted: &charted, axis: "x", shown: None };
            study_charts_ui(ui, &view)
        });
        harness.run_steps(2);
        harness.query_all_by_label("RMS error along the shaft, room's model alone").count()
    });
    assert_eq!(shown, [1, 0]);
}

#[test]
fn charts_name_their_field_and_choose_axes() {
    let scenario = scenario();
    let charted = charted(&scenario);
    let (mut harness, requests) = panel([276.0, 500.0], |ui| {
        let view = StudyChartsView { charted: &charted, axis: "x", shown: Some(3) };
        study_charts_ui(ui, &view)
    });
    harness.run_steps(2);
    harness.get_by_label("Tip error of all trials, room's model alone");
    harness.get_by_label("rz").click();
    harness.run_steps(2);
    let axis = StudyRequest::ShowAxis("rz");
    assert_eq!(*requests.borrow(), [axis]);
    requests.borrow_mut().clear();
    // The lower chart: three values of x, the last at its right end.
    let chart = harness.get_by_label("rz").rect();
    click(&mut harness, egui::pos2(262.0, chart.bottom() + 60.0));
    let worst = charted.profile.axes[0].worst_trial[2];
    let show = StudyRequest::Show(Some(worst));
    assert_eq!(*requests.borrow(), [show]);
}
