//! The Present workspace: slides over the scene, made in place, and the design's own view untouched.

use super::app::{create_app, document, request, settle};
use super::harness::{Requests, panel};
use bevy::prelude::*;
use bevy_egui::egui;
use bevy_egui::egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use trackwright_design::view::CameraView;
use trackwright_design::{BodyRole, Edit, Slide, SlideEdit, SlideFigure, View};
use trackwright_editor::document::requests::{EditRequest, OpenWorld, ViewRequest};
use trackwright_editor::document::selection::Selection;
use trackwright_editor::document::shown::ShownDesign;
use trackwright_editor::runner::results::Results;
use trackwright_editor::shell::window::Workspace;
use trackwright_editor::widgets::verdict::verdict_mark;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::design::DesignPlugin;
use trackwright_editor::workspaces::present::panels::StageView;
use trackwright_editor::workspaces::present::panels::slides_ui::slides_ui;
use trackwright_editor::workspaces::present::panels::stage_ui::stage_ui;
use trackwright_editor::workspaces::present::{PresentPlugin, PresentRequest, Presenter};
use trackwright_editor::workspaces::study::StudyPlugin;
use trackwright_editor::workspaces::study::state::StudyRequest;
use trackwright_report::words::{PlainFigure, plain_figure};

fn slide(title: &str, azimuth_rad: f64) -> Slide {
    let mut slide = Slide {
        title: title.to_owned(),
        caption: format!("{title}, in a sentence"),
        figures: vec![SlideFigure::WithinLimit, SlideFigure::LargestTipError],
        ..Slide::default()
    };
    slide.view.layers.slice = false;
    slide.view.camera = Some(CameraView {
        focus_mm: [0.0, 0.0, -300.0],
        distance_mm: 600.0,
        azimuth_rad,
        elevation_rad: 0.2,
        is_orthographic: false,
    });
    slide
}

fn present_app(slides: &[Slide]) -> App {
    let mut app = create_app();
    app.add_plugins((DesignPlugin, StudyPlugin, PresentPlugin));
    for (index, slide) in slides.iter().enumerate() {
        let slide = Box::new(slide.clone());
        let edit = Edit::Slides(SlideEdit::Add { index, slide });
        request(&mut app, EditRequest::Apply(edit));
    }
    settle(&mut app);
    app
}

fn go_to(app: &mut App, workspace: Workspace) {
    app.insert_resource(workspace);
    settle(app);
}

fn request_and_wait(app: &mut App, request: PresentRequest) {
    app.world_mut().write_message(request);
    settle(app);
}

#[test]
fn slides_leave_the_designs_own_view() {
    let slides = [slide("one", 0.1), slide("two", 0.7)];
    let mut app = present_app(&slides);
    let own = document(&app).view().clone();
    go_to(&mut app, workspaces::present::WORKSPACE);
    assert_eq!(*document(&app).view(), slides[0].view);
    request_and_wait(&mut app, PresentRequest::Step(1));
    assert_eq!(*document(&app).view(), slides[1].view);
    // The last one stays.
    request_and_wait(&mut app, PresentRequest::Step(1));
    assert_eq!(*document(&app).view(), slides[1].view);
    assert_eq!(*document(&app).own_view(), own, "what would be saved");
    request_and_wait(&mut app, PresentRequest::Leave);
    assert_eq!(*document(&app).view(), own);
    assert_eq!(*app.world().resource::<Workspace>(), workspaces::design::WORKSPACE);
}

#[test]
fn only_keeping_a_view_changes_a_slide() {
    let mut app = present_app(&[slide("one", 0.1), slide("two", 0.7)]);
    go_to(&mut app, workspaces::present::WORKSPACE);
    let mut around = document(&app).view().clone();
    around.layers.ghost = false;
    app.world_mut().write_message(ViewRequest::Set(around.clone()));
    settle(&mut app);
    assert_eq!(*document(&app).view(), around);
    let kept = |app: &App| document(app).design().slides[0].view.clone();
    assert_eq!(kept(&app), slide("one", 0.1).view);
    request_and_wait(&mut app, PresentRequest::BackToView);
    assert_eq!(*document(&app).view(), slide("one", 0.1).view);

    app.world_mut().write_message(ViewRequest::Set(around.clone()));
    settle(&mut app);
    request_and_wait(&mut app, PresentRequest::KeepView);
    assert_eq!((kept(&app), document(&app).view()), (around.clone(), &around));
    assert_eq!(document(&app).undo_label(), Some("Change view of slide 1"));
    request(&mut app, EditRequest::Undo);
    settle(&mut app);
    assert_eq!(*document(&app).view(), slide("one", 0.1).view, "as it is kept");
}

#[test]
fn changes_without_slides_make_the_first_slide() {
    let mut app = present_app(&[]);
    go_to(&mut app, workspaces::present::WORKSPACE);
    let layers = document(&app).view().layers;
    assert!(!layers.slice && !layers.sensor_errors && layers.ghost);
    let presenter = Presenter::default();
    let view = StageView {
        document: document(&app),
        environment: &app.world().resource::<OpenWorld>().0.environment,
        presenter: &presenter,
        figures: None,
    };
    let (shown, ..) = view.slide();
    assert_eq!(shown.title, "Test design");
    let mut shown = shown.into_owned();
    shown.title = "For the ward".to_owned();
    let title = shown.title.clone();
    request_and_wait(&mut app, PresentRequest::SetTitle { slide: 0, title });
    assert_eq!(document(&app).design().slides, [shown]);
    request_and_wait(&mut app, PresentRequest::Add);
    let titles = |app: &App| {
        let slides = &document(app).design().slides;
        slides.iter().map(|s| s.title.clone()).collect::<Vec<_>>()
    };
    assert_eq!(titles(&app), ["For the ward", "For the ward"]);
    assert_eq!(app.world().resource::<Presenter>().slide, 1);
    request_and_wait(&mut app, PresentRequest::Move(-1));
    request_and_wait(&mut app, PresentRequest::Remove);
    request_and_wait(&mut app, PresentRequest::Remove);
    request_and_wait(&mut app, PresentRequest::Remove);
    assert!(titles(&app).is_empty());
}

#[test]
fn a_slides_motion_ends_with_it() {
    let mut app = present_app(&[slide("one", 0.1)]);
    go_to(&mut app, workspaces::present::WORKSPACE);
    let shown = |app: &App| app.world().resource::<ShownDesign>().trial.clone();
    assert_eq!(shown(&app), None, "it begins where it is designed");
    app.world_mut().write_message(StudyRequest::Show(Some(3)));
    settle(&mut app);
    assert_eq!(shown(&app).map(|trial| trial.number), Some(3));
    go_to(&mut app, workspaces::design::WORKSPACE);
    assert_eq!(shown(&app), None);
}

#[test]
fn after_slides_selection_and_trial_are_as_before() {
    let mut app = present_app(&[slide("one", 0.1)]);
    go_to(&mut app, workspaces::study::WORKSPACE);
    let selected = Selection::of_sensors(BodyRole::Tool, [0, 1]);
    *app.world_mut().resource_mut::<Selection>() = selected.clone();
    app.world_mut().write_message(StudyRequest::Show(Some(3)));
    settle(&mut app);
    let shown = |app: &App| {
        let trial = app.world().resource::<ShownDesign>().trial.clone();
        (trial.map(|trial| trial.number), app.world().resource::<Selection>().clone())
    };
    let before = (Some(3), selected);
    assert_eq!(shown(&app), before);
    go_to(&mut app, workspaces::present::WORKSPACE);
    assert_eq!(shown(&app), (None, Selection::default()));
    request_and_wait(&mut app, PresentRequest::Leave);
    assert_eq!(shown(&app), before);
}

/// The writing over a scene of 16 to 9, and the panel beside it while slides are made.
fn harness<'a>(app: &'a App, presenter: &'a Presenter) -> (Harness<'a>, Requests<PresentRequest>) {
    let figures = app.world().resource::<Results>().study.as_ref();
    panel([996.0, 560.0], move |ui| {
        let view = StageView {
            document: document(app),
            environment: &app.world().resource::<OpenWorld>().0.environment,
            presenter,
            figures: figures.map(|study| &study.value.figures),
        };
        let mut covered = Vec::new();
        let stage = ui.max_rect();
        let mut actions = stage_ui(ui.ctx(), stage, &view, &mut covered);
        for rect in &covered {
            assert!(stage.contains_rect(*rect), "{rect:?} is not on the screen");
        }
        let overlaps = |a: &egui::Rect, b: &egui::Rect| a.shrink(0.5).intersects(b.shrink(0.5));
        for (index, rect) in covered.iter().enumerate() {
            let others = &covered[index + 1..];
            assert!(!others.iter().any(|other| overlaps(rect, other)), "{covered:?}");
        }
        if presenter.is_editing {
            actions.extend(slides_ui(ui, &view));
        }
        actions
    })
}

#[test]
fn slide_text_stays_clear_and_visible() {
    let mut app = present_app(&[slide("one", 0.1), slide("two", 0.7)]);
    go_to(&mut app, workspaces::present::WORKSPACE);
    let presenter = app.world().resource::<Presenter>().clone();
    let (mut harness, requests) = harness(&app, &presenter);
    harness.run_steps(3);
    assert!(requests.borrow().is_empty());
}

#[test]
fn figures_on_a_slide_have_names() {
    let mut app = present_app(&[slide("one", 0.1)]);
    go_to(&mut app, workspaces::present::WORKSPACE);
    let presenter = app.world().resource::<Presenter>().clone();
    let (mut harness, _) = harness(&app, &presenter);
    harness.run_steps(2);
    let results = app.world().resource::<Results>();
    let figures = &results.study.as_ref().unwrap().value.figures;
    let largest = SlideFigure::LargestTipError;
    let PlainFigure { value, words, verdict } = plain_figure(largest, figures).unwrap();
    let sign = verdict.map_or_else(String::new, |verdict| format!("{} ", verdict_mark(verdict).0));
    harness.get_by_label(&format!("{value} {sign}{words}"));
}

#[test]
fn text_on_a_slide_is_one_step() {
    let mut app = present_app(&[slide("one", 0.1)]);
    go_to(&mut app, workspaces::present::WORKSPACE);
    request_and_wait(&mut app, PresentRequest::ToggleEditing);
    let presenter = app.world().resource::<Presenter>().clone();
    assert!(presenter.is_editing);
    let (mut harness, requests) = harness(&app, &presenter);
    harness.run_steps(2);
    harness.get_by_role(Role::TextInput).focus();
    harness.run_steps(2);
    harness.get_by_role(Role::TextInput).type_text(" <b>& only");
    harness.run_steps(2);
    assert!(requests.borrow().is_empty(), "it is still being written");
    harness.get_by_label("Done").click();
    harness.run_steps(3);
    let title = "one <b>& only".to_owned();
    let written = [PresentRequest::SetTitle { slide: 0, title }, PresentRequest::ToggleEditing];
    assert_eq!(*requests.borrow(), written);
}

/// An app in which the first slide is edited, and looked at otherwise than it is kept.
fn editing_app(slides: &[Slide]) -> (App, View) {
    let mut app = present_app(slides);
    go_to(&mut app, workspaces::present::WORKSPACE);
    request_and_wait(&mut app, PresentRequest::ToggleEditing);
    let mut around = document(&app).view().clone();
    around.layers.ghost = !around.layers.ghost;
    around.camera = slide("around", 1.3).view.camera;
    app.world_mut().write_message(ViewRequest::Set(around.clone()));
    settle(&mut app);
    (app, around)
}

/// What is requested by writing into the caption and then doing this.
fn written(app: &App, then: impl Fn(&mut Harness)) -> Vec<PresentRequest> {
    let presenter = app.world().resource::<Presenter>().clone();
    let (mut harness, requests) = harness(app, &presenter);
    harness.run_steps(2);
    harness.get_by_role(Role::MultilineTextInput).focus();
    harness.run_steps(2);
    harness.get_by_role(Role::MultilineTextInput).type_text(", and more");
    harness.run_steps(2);
    then(&mut harness);
    harness.run_steps(3);
    drop(harness);
    requests.take()
}

#[test]
fn escape_keeps_what_was_written_on_a_slide() {
    let (app, _) = editing_app(&[slide("one", 0.1)]);
    let requests = written(&app, |harness| harness.key_press(egui::Key::Escape));
    let caption = "one, in a sentence, and more".to_owned();
    assert_eq!(requests, [PresentRequest::SetCaption { slide: 0, caption }]);
}

#[test]
fn one_click_ends_writing_and_keeps_the_view() {
    let slides = [slide("one", 0.1)];
    let (mut app, around) = editing_app(&slides);
    let requests = written(&app, |harness| harness.get_by_label("Keep this view").click());
    let caption = "one, in a sentence, and more".to_owned();
    let set = PresentRequest::SetCaption { slide: 0, caption: caption.clone() };
    assert_eq!(requests, [set, PresentRequest::KeepView]);
    // In one frame, in whichever order the panels are drawn.
    for request in requests.into_iter().rev() {
        app.world_mut().write_message(request);
    }
    settle(&mut app);
    let expected = Slide { caption, view: around, ..slides[0].clone() };
    assert_eq!(document(&app).design().slides, [expected]);
}

#[test]
fn the_first_click_makes_one_slide() {
    let (mut app, around) = editing_app(&[]);
    let place = |app: &App| {
        let presenter = app.world().resource::<Presenter>().clone();
        let (mut harness, _) = harness(app, &presenter);
        harness.run_steps(2);
        harness.get_by_label("Keep this view").rect()
    };
    let before = place(&app);
    let caption = "first".to_owned();
    app.world_mut().write_message(PresentRequest::KeepView);
    app.world_mut().write_message(PresentRequest::SetCaption { slide: 0, caption });
    settle(&mut app);
    let [first] = document(&app).design().slides.as_slice() else {
        panic!("{:?}", document(&app).design().slides);
    };
    assert_eq!((first.caption.as_str(), &first.view), ("first", &around));
    // Nothing moves away from under the pointer when it is made.
    assert_eq!(place(&app), before);
}

#[test]
fn what_was_written_stays_on_its_own_slide() {
    let slides = [slide("one", 0.1), slide("two", 0.7)];
    let (mut app, _) = editing_app(&slides);
    let caption = "of the first".to_owned();
    let set = PresentRequest::SetCaption { slide: 0, caption: caption.clone() };
    for request in [PresentRequest::Show(1), set] {
        app.world_mut().write_message(request);
    }
    settle(&mut app);
    let expected = [Slide { caption, ..slides[0].clone() }, slides[1].clone()];
    assert_eq!(document(&app).design().slides, expected);
    assert_eq!(app.world().resource::<Presenter>().slide, 1);
}

/// The slide of a file that turns on what this program does not have and what this design cannot show.
#[test]
fn a_slide_with_lost_layers_is_shown() {
    let mut gone = slide("one", 0.1);
    gone.view.layers.region = true;
    gone.view.layers.support = true;
    gone.view.unknown_layers = vec!["halo".to_owned()];
    let mut app = present_app(&[gone.clone()]);
    request(&mut app, EditRequest::Apply(Edit::SetRequirement(None)));
    settle(&mut app);
    let requested = |app: &App| {
        let environment = &app.world().resource::<OpenWorld>().0.environment;
        document(app).missing_layers(environment)
    };
    assert_eq!(requested(&app).len(), 3);
    go_to(&mut app, workspaces::present::WORKSPACE);
    request_and_wait(&mut app, PresentRequest::ToggleEditing);
    let presenter = app.world().resource::<Presenter>().clone();
    {
        let (mut harness, _) = harness(&app, &presenter);
        harness.run_steps(2);
        for words in ["layer \"halo\"", "no requirement", "no model validity"] {
            harness.get_by_label_contains(words);
        }
    }
    request_and_wait(&mut app, PresentRequest::KeepView);
    let kept = document(&app).design().slides[0].view.clone();
    assert_eq!(kept.unknown_layers, [""; 0]);
    assert_eq!(kept.layers, gone.view.layers);
    assert_eq!(*document(&app).view(), kept, "shown as it is kept");
    assert_eq!(requested(&app).len(), 2);
}
