//! The rows of a sweep as a table: read as they are seen, sorted, shown in the scene, opened as designs.

use super::app::{document, drop_on_window, error, request, settle, write};
use super::decide::decide_app;
use super::harness::use_panel;
use bevy::prelude::*;
use bevy_egui::egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use trackwright_design::{BodyRole, Edit, Origin};
use trackwright_editor::document::drops::DropsPlugin;
use trackwright_editor::document::requests::{EditRequest, FileRequest};
use trackwright_editor::document::state::Notice;
use trackwright_editor::shell::dialogs::Dialogs;
use trackwright_editor::shell::window::Workspace;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::decide::sweep_table::state::{
    OpenSweep, SweepTableRequest, SweepTableState, step_label,
};
use trackwright_editor::workspaces::decide::sweep_table::table_ui::sweep_table_ui;
use trackwright_formats::sweep_plan;
use trackwright_project::{DEFAULT_BUILTIN, open_builtin, save_as};
use trackwright_sweep::{Cell, Direction, Folder, Part, Sweep, run};
use trackwright_task::Task;

/// The one before the last is the built-in design's own; the last one leaves no valid design.
const HEIGHTS_MM: [f64; 6] = [60.0, 70.0, 40.0, 55.0, 72.0, 1e12];

const HEIGHT: &str = "tool.body.sensors[0].position.z";

/// A sweep of a design's first sensor, in the folder `out`; `designs` are beside it.
fn swept(folder: &TempDir, design: &str) -> PathBuf {
    let text = format!(
        r#"(version: 1, designs: [{design:?}], motions: [Single], figures: ["position_rms"],
        vary: [Grid([(path: {HEIGHT:?}, values: List({HEIGHTS_MM:?}))])])"#
    );
    let plan = sweep_plan::parse(text.as_bytes()).unwrap();
    let sweep = Sweep::of_plan(plan, folder.path()).unwrap();
    let out = Folder::open(&folder.path().join("out"), &sweep).unwrap();
    run(&sweep, &out, Part::WHOLE, &Task::default(), &|_| ()).unwrap();
    out.path().to_owned()
}

fn state(app: &App) -> &SweepTableState {
    app.world().resource()
}

fn open(app: &App) -> &OpenSweep {
    state(app).open.as_ref().expect("an open sweep")
}

/// Updates until nothing is under way.
fn rest(app: &mut App) {
    let start = Instant::now();
    settle(app);
    while state(app).is_busy() {
        settle(app);
        assert!(start.elapsed() < Duration::from_secs(60), "never idle");
    }
    settle(app);
}

fn send(app: &mut App, request: SweepTableRequest) {
    app.world_mut().write_message(request);
    rest(app);
}

/// With a sweep of the design that is open.
fn app_with_sweep() -> (TempDir, App) {
    let folder = tempfile::tempdir().unwrap();
    let out = swept(&folder, DEFAULT_BUILTIN);
    let mut app = decide_app();
    send(&mut app, SweepTableRequest::Open(out));
    (folder, app)
}

fn column(app: &App, name: &str) -> usize {
    open(app).columns.iter().position(|column| column.name == name).unwrap()
}

/// The numbers of a column in the order that is shown.
fn numbers(app: &App, name: &str) -> Vec<Option<f64>> {
    let column = column(app, name);
    let number = |place| match open(app).page.cell(column, place) {
        Some(Cell::Number(number)) => Some(*number),
        _ => None,
    };
    (0..open(app).rows).map(number).collect()
}

fn height_mm(app: &App) -> f64 {
    document(app).design().tool.body.rigid.sensors[0].position_in_body.z
}

#[test]
fn a_sweep_opens_with_its_first_rows() {
    let folder = tempfile::tempdir().unwrap();
    let out = swept(&folder, DEFAULT_BUILTIN);
    let mut app = decide_app();
    app.insert_resource(workspaces::design::WORKSPACE);
    send(&mut app, SweepTableRequest::Open(out.join("plan.sweep.ron")));
    assert_eq!(open(&app).rows, 6);
    assert_eq!(numbers(&app, HEIGHT), HEIGHTS_MM.map(Some));
    assert_eq!(*app.world().resource::<Workspace>(), workspaces::decide::WORKSPACE);
    assert_eq!(open(&app).problem(4), None);
    assert!(open(&app).problem(5).unwrap().starts_with("tool.body: sensors[0]"));
    // They are there already.
    send(&mut app, SweepTableRequest::View(0..6));
    assert_eq!(state(&app).pages, 0);
    assert!(open(&app).sweep.is_none(), "no design is read before a row is shown");
    send(&mut app, SweepTableRequest::Close);
    assert!(state(&app).open.is_none());
}

#[test]
fn a_column_sorts_both_ways_and_back() {
    let (_folder, mut app) = app_with_sweep();
    let by_height = column(&app, HEIGHT);
    send(&mut app, SweepTableRequest::SortBy(by_height));
    let mut expected = HEIGHTS_MM.map(Some).to_vec();
    expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(numbers(&app, HEIGHT), expected);
    assert_eq!(open(&app).sorting.unwrap().direction, Direction::Ascending);
    send(&mut app, SweepTableRequest::SortBy(by_height));
    expected.reverse();
    assert_eq!(numbers(&app, HEIGHT), expected);
    send(&mut app, SweepTableRequest::SortBy(by_height));
    assert_eq!(numbers(&app, HEIGHT), HEIGHTS_MM.map(Some));
    assert_eq!(open(&app).sorting, None);
    // The row without figures is last.
    let by_figure = column(&app, "position_rms");
    for _ in 0..2 {
        send(&mut app, SweepTableRequest::SortBy(by_figure));
        let figures = numbers(&app, "position_rms");
        assert!(figures[..5].iter().all(Option::is_some) && figures[5].is_none());
    }
}

#[test]
fn rows_shown_one_after_another_are_one_step() {
    let (_folder, mut app) = app_with_sweep();
    let before = document(&app).design().clone();
    for row in [1, 3, 2] {
        send(&mut app, SweepTableRequest::ShowRow(row));
        assert_eq!(height_mm(&app), HEIGHTS_MM[row as usize]);
        assert_eq!(document(&app).undo_label(), Some(step_label(row).as_str()));
        assert_eq!(open(&app).selected, Some(row));
    }
    request(&mut app, EditRequest::Undo);
    settle(&mut app);
    assert_eq!((document(&app).design(), document(&app).undo_label()), (&before, None));
    // Nothing of the sweep is there to be taken back any more.
    send(&mut app, SweepTableRequest::TakeBack);
    assert_eq!(*document(&app).design(), before);
    send(&mut app, SweepTableRequest::ShowRow(3));
    send(&mut app, SweepTableRequest::TakeBack);
    assert_eq!(*document(&app).design(), before);
}

#[test]
fn a_row_that_is_the_open_design_is_no_step() {
    let (_folder, mut app) = app_with_sweep();
    send(&mut app, SweepTableRequest::ShowRow(4));
    assert_eq!(height_mm(&app), HEIGHTS_MM[4]);
    assert_eq!(document(&app).undo_label(), None);
    let notice = app.world().resource::<Notice>();
    assert_eq!(*notice, Notice::Done("The open design is row 4 already".to_owned()));
}

#[test]
fn an_edit_of_a_shown_row_stays() {
    let (_folder, mut app) = app_with_sweep();
    send(&mut app, SweepTableRequest::ShowRow(1));
    request(&mut app, EditRequest::Apply(Edit::SetOrientationWeight(Some(33.0))));
    settle(&mut app);
    let edited = document(&app).design().clone();
    send(&mut app, SweepTableRequest::ShowRow(3));
    assert_eq!(height_mm(&app), HEIGHTS_MM[3]);
    request(&mut app, EditRequest::Undo);
    settle(&mut app);
    assert_eq!(*document(&app).design(), edited);
}

#[test]
fn a_row_without_figures_states_why() {
    let (_folder, mut app) = app_with_sweep();
    let before = document(&app).design().clone();
    send(&mut app, SweepTableRequest::ShowRow(5));
    assert_eq!(*document(&app).design(), before);
    let notice = app.world().resource::<Notice>().clone();
    let Notice::Refused(why) = notice else { panic!("{notice:?}") };
    assert!(why.starts_with("row 5: tool.body: sensors[0]"), "{why}");
}

/// A sweep of a design in a folder of its own, which is not open.
fn app_with_sweep_of_file() -> (TempDir, PathBuf, App) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("own.design.ron");
    save_as(&mut open_builtin(DEFAULT_BUILTIN).unwrap(), &file).unwrap();
    let out = swept(&folder, "own.design.ron");
    let mut app = decide_app();
    send(&mut app, SweepTableRequest::Open(out));
    (folder, file, app)
}

fn is_at(app: &App, file: &Path) -> bool {
    matches!(document(app).origin(), Origin::File(own) if trackwright_project::is_same_file(own, file))
}

#[test]
fn a_row_that_is_not_opened_is_not_shown_later() {
    let (_folder, file, mut app) = app_with_sweep_of_file();
    request(&mut app, EditRequest::Apply(Edit::SetOrientationWeight(Some(33.0))));
    settle(&mut app);
    let edited = document(&app).design().clone();
    send(&mut app, SweepTableRequest::ShowRow(1));
    let dialogs = &mut app.world_mut().resource_mut::<Dialogs>();
    assert!(dialogs.current.take().is_some(), "the edit would be lost");
    settle(&mut app);
    assert_eq!(*document(&app).design(), edited);
    app.world_mut().write_message(FileRequest::Discard(Box::new(FileRequest::Open(file.clone()))));
    rest(&mut app);
    assert!(is_at(&app, &file));
    assert_eq!(document(&app).undo_label(), None);
}

#[test]
fn a_row_of_another_design_opens_that() {
    let (_folder, file, mut app) = app_with_sweep_of_file();
    send(&mut app, SweepTableRequest::ShowRow(1));
    assert!(is_at(&app, &file));
    rest(&mut app);
    assert_eq!(height_mm(&app), HEIGHTS_MM[1]);
    assert_eq!(document(&app).undo_label(), Some(step_label(1).as_str()));
    assert!(document(&app).design().tool.body.mesh.is_some());
}

#[test]
fn open_as_design_leaves_the_design_as_it_was() {
    let (folder, file, mut app) = app_with_sweep_of_file();
    let original = fs::read(&file).unwrap();
    send(&mut app, SweepTableRequest::ShowRow(1));
    rest(&mut app);
    send(&mut app, SweepTableRequest::OpenAsDesign(3));
    assert!(app.world().resource::<Dialogs>().current.is_none(), "nothing is lost by it");
    let own = folder.path().join("own-row-3.design.ron");
    assert!(is_at(&app, &own), "{:?}", document(&app).origin());
    assert_eq!(height_mm(&app), HEIGHTS_MM[3]);
    assert_eq!(document(&app).undo_label(), None);
    assert!(document(&app).is_dirty() && !own.exists());
    let copies =
        FileRequest::SaveShared(trackwright_editor::document::requests::SharedChoice::Copy);
    app.world_mut().write_message(copies);
    settle(&mut app);
    assert!(own.exists() && !document(&app).is_dirty());
    assert_eq!(fs::read(&file).unwrap(), original);
    let saved = trackwright_project::open_design(&own).unwrap();
    assert_eq!(saved.document.design(), document(&app).design());
}

#[test]
fn a_built_in_row_opens_unsaved() {
    let (_folder, mut app) = app_with_sweep();
    send(&mut app, SweepTableRequest::OpenAsDesign(2));
    assert_eq!(*document(&app).origin(), Origin::BuiltIn(DEFAULT_BUILTIN));
    assert_eq!(height_mm(&app), HEIGHTS_MM[2]);
    assert!(document(&app).is_dirty() && document(&app).undo_label().is_none());
    assert!(document(&app).design().body(BodyRole::Tool).unwrap().mesh.is_some());
}

#[test]
fn what_is_no_sweep_is_reported() {
    let (folder, mut app) = app_with_sweep();
    let empty = tempfile::tempdir().unwrap();
    send(&mut app, SweepTableRequest::Open(empty.path().to_owned()));
    assert!(error(&app).text.contains("found no sweep"), "{}", error(&app).text);
    app.world_mut().resource_mut::<Dialogs>().current = None;
    let shards = fs::read_dir(folder.path().join("out")).unwrap();
    let shard = shards.map(|entry| entry.unwrap().path());
    let shard = shard.into_iter().find(|file| file.extension().is_some_and(|e| e == "parquet"));
    let bytes = fs::read(shard.unwrap()).unwrap();
    let torn = write(&empty, "torn.parquet", &bytes[..bytes.len() / 2]);
    send(&mut app, SweepTableRequest::Open(torn));
    assert!(error(&app).text.contains("torn.parquet"), "{}", error(&app).text);
    assert_eq!(open(&app).rows, 6, "what was open stays");
}

#[test]
fn a_dropped_folder_opens_as_a_sweep() {
    let folder = tempfile::tempdir().unwrap();
    let out = swept(&folder, DEFAULT_BUILTIN);
    let mut app = decide_app();
    app.add_plugins(DropsPlugin);
    drop_on_window(&mut app, &out);
    rest(&mut app);
    assert_eq!(open(&app).rows, 6);
}

fn use_table(open: &OpenSweep, act: impl FnOnce(&mut Harness)) -> Vec<SweepTableRequest> {
    use_panel([900.0, 240.0], |ui| sweep_table_ui(ui, open, None), act)
}

#[test]
fn rows_and_heads_are_clicked() {
    let (_folder, app) = app_with_sweep();
    let requests = use_table(open(&app), |harness| {
        harness.get_by_label("row 3").click();
        harness.run_steps(2);
        harness.get_by_label(HEIGHT).click();
    });
    let sorted = SweepTableRequest::SortBy(column(&app, HEIGHT));
    assert_eq!(requests, [SweepTableRequest::ShowRow(3), sorted]);
}

#[test]
fn only_rows_in_view_are_drawn_and_read() {
    let (_folder, mut app) = app_with_sweep();
    // As if it had as many.
    app.world_mut().resource_mut::<SweepTableState>().open.as_mut().unwrap().rows = 1_000_000;
    let requests = use_table(open(&app), |harness| {
        let rows = harness.root().children_recursive();
        let is_row = |role| role == Role::Button || role == Role::ListBoxOption;
        let drawn = rows.filter(|node| is_row(node.accesskit_node().role())).count();
        assert!(drawn < 60, "{drawn}");
    });
    let Some(SweepTableRequest::View(places)) = requests.first() else { panic!("{requests:?}") };
    assert!(places.start == 0 && (6..20).contains(&places.end), "{places:?}");
    send(&mut app, SweepTableRequest::View(2..4));
    assert_eq!(state(&app).pages, 0, "these are there");
}
