//! The page of error against run time: measured in the background, for the open design.

use super::app::{create_app, request, settle, wait_for_work};
use bevy::prelude::*;
use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::cell::RefCell;
use trackwright_accuracy::precision::{Settings, What};
use trackwright_design::Edit;
use trackwright_editor::document::requests::EditRequest;
use trackwright_editor::workspaces::study::precision::{
    PrecisionPage, PrecisionPlugin, PrecisionRequest,
};
use trackwright_editor::workspaces::study::precision_ui::precision_ui;

fn app() -> App {
    let mut app = create_app();
    app.add_plugins(PrecisionPlugin);
    app.world_mut().resource_mut::<PrecisionPage>().settings = Settings::quick();
    settle(&mut app);
    app
}

/// Updates until nothing is measured any more.
fn wait(app: &mut App) {
    while app.world().resource::<PrecisionPage>().part().is_some() {
        wait_for_work(app);
    }
}

fn request_and_wait(app: &mut App, request: PrecisionRequest) {
    app.world_mut().write_message(request);
    app.update();
}

/// The page as it is drawn, and what was requested in it.
fn use_page(
    page: &PrecisionPage,
    is_current: bool,
    act: impl Fn(&mut Harness),
) -> Vec<PrecisionRequest> {
    let requests = RefCell::new(Vec::new());
    let mut harness = Harness::builder().with_size(egui::vec2(760.0, 700.0)).build_ui(|ui| {
        requests.borrow_mut().extend(precision_ui(ui, page, is_current));
    });
    harness.run_steps(2);
    act(&mut harness);
    harness.run_steps(2);
    drop(harness);
    requests.into_inner()
}

#[test]
fn a_measured_page_shows_every_family() {
    let mut app = app();
    request_and_wait(&mut app, PrecisionRequest::Measure);
    assert!(app.world().resource::<PrecisionPage>().part().is_some());
    wait(&mut app);
    let page = app.world().resource::<PrecisionPage>();
    assert!(page.machine.is_some(), "{:?}", page.problem);
    let families: Vec<What> = page.families.iter().map(|f| f.what).collect();
    assert_eq!(families, What::ALL);
    let of = page.of.clone().unwrap();
    assert_eq!(of.0, "Test design");

    let requests = use_page(page, true, |harness| {
        harness.get_by_label("Measure again");
        assert!(harness.query_by_label_contains("has changed").is_none());
        for family in &page.families {
            harness.get_by_label(family.what.title());
        }
        harness.get_by_label("Inverse").click();
    });
    assert_eq!(requests, [PrecisionRequest::Show(What::Inverse)]);
    request_and_wait(&mut app, PrecisionRequest::Show(What::Inverse));
    let page = app.world().resource::<PrecisionPage>();
    let inverse = page.families.iter().find(|f| f.what == What::Inverse);
    let method = &inverse.unwrap().rows[0].method;
    use_page(page, false, |harness| {
        assert!(harness.query_all_by_label(method).count() >= 1, "{method}");
        harness.get_by_label_contains("has changed since it was measured");
    });

    request(&mut app, EditRequest::Apply(Edit::SetName("Another".into())));
    settle(&mut app);
    let page = app.world().resource::<PrecisionPage>();
    assert_eq!(page.of, Some(of), "figures stay those of what was measured");
}

#[test]
fn measuring_can_be_given_up() {
    let mut app = app();
    request_and_wait(&mut app, PrecisionRequest::Measure);
    request_and_wait(&mut app, PrecisionRequest::Cancel);
    wait(&mut app);
    let page = app.world().resource::<PrecisionPage>();
    assert_eq!(page.problem.as_deref(), Some("cancelled"));
    assert!(page.machine.is_none());
    let requests = use_page(page, true, |harness| {
        harness.get_by_label_contains("Measure").click();
    });
    assert_eq!(requests, [PrecisionRequest::Measure]);
}
