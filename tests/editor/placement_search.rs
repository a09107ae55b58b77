//! The search for better places: started and stopped in the panel, shown in the scene, taken as one
//! undo step.

use super::app::{
    create_app, create_scene_app_with, document, named, request, settle, wait_for_work, world,
};
use super::harness::{assert_nothing_overlaps, panel, use_panel};
use bevy::prelude::*;
use bevy_egui::egui;
use bevy_egui::egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use nalgebra::Point3;
use std::sync::Arc;
use trackwright_design::{BodyRole, Design, Document, Edit, Origin, View};
use trackwright_editor::document::requests::{EditRequest, OpenWorld};
use trackwright_editor::document::state::WorldGeneration;
use trackwright_editor::layers::legend::Legends;
use trackwright_editor::shell::commands::{CommandsPlugin, RunCommand};
use trackwright_editor::shell::window::Workspace;
use trackwright_editor::workspaces;
use trackwright_editor::workspaces::design::DesignPlugin;
use trackwright_editor::workspaces::design::placement_search::ghosts::{
    LEGEND_ORDER, PlacementGhostsPlugin,
};
use trackwright_editor::workspaces::design::placement_search::result_ui::STALE;
use trackwright_editor::workspaces::design::placement_search::search_ui::{
    FOLD, UNFOLD, placement_search_ui,
};
use trackwright_editor::workspaces::design::placement_search::state::{
    AnswerId, PlacementSearch, PlacementSearchRequest, Running, Searched,
};
use trackwright_editor::workspaces::design::placement_search::wish::{Reach, Wish};
use trackwright_editor::workspaces::design::placement_search::{FIND_PLACES, STEP};
use trackwright_optimization::{
    BuiltError, Layout, Optimized, OverRooms, Problem, SensorChoice, Settings, optimize,
};
use trackwright_project::{DEFAULT_BUILTIN, Files, design_rooms, placement_problem};
use trackwright_simulation::{
    CancelToken, Coil, Metric, Mounting, MountingAxis, MountingRegion, Requirement,
};
use trackwright_task::Task;

const BEST: AnswerId = AnswerId::Candidate(0);

/// Fast, and enough for two sensors in a bore.
const QUICK: Settings = Settings { seed: 0, most_fits: 300_000 };

/// Of the bore in which the tool's sensors may be, from the tip.
const BORE_MM: [f64; 2] = [10.0, 180.0];

/// The test design, its tool's sensors in a bore of a radius.
fn design(radius_mm: f64) -> Design {
    let mut design = super::app::design();
    let channel = MountingRegion::Channel {
        points_mm: BORE_MM.map(|z| Point3::new(0.0, 0.0, z)).to_vec(),
        radius_mm: Some(radius_mm),
        axis: MountingAxis::AsItIs,
    };
    let tool = &mut design.tool.body;
    tool.mounting = Mounting { regions: vec![channel], ..Mounting::default() };
    for sensor in &mut tool.rigid.sensors {
        sensor.coil = Some(Coil { diameter_mm: 1.0, length_mm: 2.0 });
    }
    design
}

fn app_of(design: Design) -> App {
    let mut app = create_app();
    app.add_plugins((CommandsPlugin, DesignPlugin));
    let document = Document::new(design, View::default(), Origin::File("test.design.ron".into()));
    let open =
        trackwright_project::World::new(document, Arc::clone(&world().environment), None, None);
    app.insert_resource(OpenWorld(open));
    app.world_mut().resource_mut::<PlacementSearch>().settings = QUICK;
    settle(&mut app);
    write(&mut app, PlacementSearchRequest::Open);
    app
}

fn app() -> App {
    app_of(design(5.0))
}

fn write(app: &mut App, request: PlacementSearchRequest) {
    app.world_mut().write_message(request);
    app.update();
}

fn search(app: &App) -> &PlacementSearch {
    app.world().resource()
}

fn wait(app: &mut App) {
    while search(app).running.is_some() {
        wait_for_work(app);
    }
}

fn start_and_wait(app: &mut App) {
    write(app, PlacementSearchRequest::Start);
    wait(app);
}

fn optimized(app: &App) -> &Optimized {
    let search = search(app);
    let result = search.result.as_ref();
    &result.unwrap_or_else(|| panic!("no result: {:?}", search.problem)).1.optimized
}

fn apply(app: &mut App, edit: Edit) {
    request(app, EditRequest::Apply(edit));
    settle(app);
}

/// What the panel requests while it is used.
fn use_search(app: &App, act: impl FnOnce(&mut Harness)) -> Vec<PlacementSearchRequest> {
    let (design, search) = (document(app).design(), search(app));
    use_panel([276.0, 2000.0], |ui| placement_search_ui(ui, design, search), act)
}

#[test]
fn a_search_finds_what_the_core_finds() {
    let mut app = app();
    let before = document(&app).design().clone();
    start_and_wait(&mut app);
    let open = &app.world().resource::<OpenWorld>().0;
    let rooms = design_rooms(&Files::default(), open).unwrap();
    let wish = Wish::of(&before);
    let (moves, goal) = (wish.moves(&before), wish.goal(&before).unwrap());
    let problem = placement_problem(open, &rooms, moves, goal, OverRooms::Worst);
    // As the command line has it where nothing else is stated.
    let problem = Problem { built: Some(BuiltError::default()), ..problem };
    let (enough, task) = (CancelToken::default(), Task::default());
    let expected = optimize(&problem, &QUICK, &enough, &task, &mut |_| ()).unwrap();
    let found = optimized(&app);
    assert_eq!(found.best, expected.best);
    assert_eq!(found.candidates, expected.candidates);
    assert!(found.is_better && found.best.objective < found.start.objective);
    let curve = &search(&app).curve;
    assert!(curve.windows(2).all(|pair| pair[0][0] <= pair[1][0] && pair[0][1] > pair[1][1]));
    assert_eq!(curve.last().map(|last| last[1]), Some(found.best.objective));
    // Nothing changes by itself.
    assert_eq!((document(&app).design(), document(&app).undo_label()), (&before, None));
}

#[test]
fn a_taken_answer_is_one_undo_step() {
    let mut app = app();
    let before = document(&app).design().clone();
    start_and_wait(&mut app);
    let best = optimized(&app).candidates[0].clone();
    write(&mut app, PlacementSearchRequest::Take(BEST));
    settle(&mut app);
    assert_eq!(document(&app).design().tool.body.rigid, best.tool);
    assert_eq!(document(&app).undo_label(), Some(STEP));
    assert!(!search(&app).is_current);
    // A second click has nothing to take.
    write(&mut app, PlacementSearchRequest::Take(BEST));
    request(&mut app, EditRequest::Undo);
    settle(&mut app);
    assert_eq!((document(&app).design(), document(&app).undo_label()), (&before, None));
    assert!(search(&app).is_current, "it is the design that was searched again");
}

#[test]
fn a_stopped_search_keeps_its_best() {
    let mut app = app();
    app.world_mut().resource_mut::<PlacementSearch>().settings = Settings::default();
    write(&mut app, PlacementSearchRequest::Start);
    let best = |app: &App| Some(search(app).running.as_ref()?.best.as_ref()?.objective);
    while best(&app).is_none() && search(&app).running.is_some() {
        wait_for_work(&mut app);
    }
    let so_far = best(&app).unwrap();
    let requests = use_search(&app, |harness| harness.get_by_label("Stop").click());
    assert_eq!(requests, [PlacementSearchRequest::Stop]);
    write(&mut app, PlacementSearchRequest::Stop);
    wait(&mut app);
    let found = optimized(&app);
    assert!(found.is_stopped);
    assert!(found.best.objective <= so_far, "{} {so_far}", found.best.objective);
}

#[test]
fn a_changed_design_makes_a_result_stale() {
    let mut app = app();
    start_and_wait(&mut app);
    assert!(search(&app).is_current);
    apply(&mut app, Edit::SetName("Another".into()));
    assert!(!search(&app).is_current);
    let before = document(&app).design().clone();
    let requests = use_search(&app, |harness| {
        harness.get_by_label_contains(STALE);
        let take = harness.get_by_label("Take this one");
        assert!(take.accesskit_node().is_disabled());
        take.click();
    });
    assert!(!requests.contains(&PlacementSearchRequest::Take(BEST)), "{requests:?}");
    write(&mut app, PlacementSearchRequest::Take(BEST));
    settle(&mut app);
    assert_eq!(document(&app).design(), &before);
}

#[test]
fn nothing_is_searched_without_a_goal() {
    let mut app = app();
    apply(&mut app, Edit::SetRequirement(None));
    let why = "The design has no requirement: state one, or choose a figure";
    let requests = use_search(&app, |harness| {
        harness.get_by_label_contains(why);
        harness.get_by_label("Start").click();
    });
    assert_eq!(requests, []);
    write(&mut app, PlacementSearchRequest::Start);
    assert!(search(&app).running.is_none());
    assert_eq!(search(&app).problem.as_deref(), Some(why));
    let design = document(&app).design();
    let wish = Wish { figure: Some(Metric::TIP_MAX), ..Wish::of(design) };
    write(&mut app, PlacementSearchRequest::Set(wish));
    start_and_wait(&mut app);
    assert_eq!(search(&app).problem, None);
    let (best, start) = (&optimized(&app).best, &optimized(&app).start);
    let largest_mm = |of: &Layout| of.studies[0].figures.get(Metric::TIP_MAX).unwrap().value;
    assert!(largest_mm(best) < largest_mm(start));
    let nothing = Wish { tool: [].into(), ..Wish::of(document(&app).design()) };
    write(&mut app, PlacementSearchRequest::Set(nothing));
    use_search(&app, |harness| {
        harness.get_by_label_contains("Nothing may move: choose a sensor");
    });
}

#[test]
fn what_cannot_be_searched_is_one_sentence() {
    let mut app = app_of(design(0.2));
    start_and_wait(&mut app);
    let problem = search(&app).problem.clone().unwrap();
    assert!(problem.starts_with("No place of the tool holds the coil of "), "{problem}");
    use_search(&app, |harness| {
        harness.get_by_label_contains(&problem);
    });
}

#[test]
fn an_optimal_start_is_no_gain() {
    let mut app = app();
    start_and_wait(&mut app);
    write(&mut app, PlacementSearchRequest::Take(BEST));
    settle(&mut app);
    start_and_wait(&mut app);
    assert!(!optimized(&app).is_better);
    let verdict = optimized(&app).verdict();
    use_search(&app, |harness| {
        harness.get_by_label(verdict);
    });
}

#[test]
fn answers_are_chosen_and_shown_by_rows() {
    let mut app = app();
    start_and_wait(&mut app);
    assert!(optimized(&app).candidates.len() > 1);
    let requests = use_search(&app, |harness| {
        for label in ["✔ better than the start", "tip RMS, mm", "Result"] {
            harness.get_by_label(label);
        }
        harness.get_by_label_contains("answer 2, ").click();
    });
    let second = AnswerId::Candidate(1);
    assert!(requests.contains(&PlacementSearchRequest::Show(second)), "{requests:?}");
    assert!(requests.contains(&PlacementSearchRequest::Hover(Some(second))), "{requests:?}");
    write(&mut app, PlacementSearchRequest::Show(second));
    let requests = use_search(&app, |harness| harness.get_by_label("Take this one").click());
    assert!(requests.contains(&PlacementSearchRequest::Take(second)), "{requests:?}");
}

#[test]
fn each_number_of_sensors_can_be_taken() {
    let mut app = app();
    start_and_wait(&mut app);
    let five = optimized(&app).best.clone();
    // In this room fewer sensors are better, so that a search finds no front of several.
    let mut four = five.clone();
    four.tool.sensors.pop();
    four.objective += 0.1;
    {
        let mut search = app.world_mut().resource_mut::<PlacementSearch>();
        search.result.as_mut().unwrap().1.optimized.pareto = vec![four.clone(), five];
    }
    let first = AnswerId::Pareto(0);
    let requests = use_search(&app, |harness| {
        harness.get_by_label("5 sensors");
        harness.get_by_label("4 sensors").click();
    });
    assert!(requests.contains(&PlacementSearchRequest::Show(first)), "{requests:?}");
    assert!(requests.contains(&PlacementSearchRequest::Hover(Some(first))), "{requests:?}");
    write(&mut app, PlacementSearchRequest::Take(first));
    settle(&mut app);
    assert_eq!(document(&app).design().tool.body.rigid, four.tool);
    assert_eq!(document(&app).undo_label(), Some(STEP));
}

#[test]
fn a_result_stands_above_the_fold() {
    let mut app = app();
    start_and_wait(&mut app);
    let show = |app: &App| {
        let (design, search) = (document(app).design(), search(app));
        // As wide and as high as the side of a window of 1024x700 with its timeline.
        let (mut harness, _) = panel([276.0, 500.0], |ui| placement_search_ui(ui, design, search));
        harness.run_steps(3);
        let boxes = harness.query_all_by_role_and_label(Role::CheckBox, "shaft").count();
        let result = harness.get_by_label("Result").rect();
        assert_nothing_overlaps(&harness, 276.0, 12);
        (boxes, result.top())
    };
    let (boxes, top) = show(&app);
    assert_eq!(boxes, 0);
    assert!(top < 130.0, "{top}");
    let requests = use_search(&app, |harness| {
        harness.get_by_label("2 sensors of the tool · ratio to the requirement");
        harness.get_by_label(UNFOLD).click();
    });
    assert!(requests.contains(&PlacementSearchRequest::ShowSettings(true)), "{requests:?}");
    write(&mut app, PlacementSearchRequest::ShowSettings(true));
    assert_eq!(show(&app).0, 1);
    let requests = use_search(&app, |harness| harness.get_by_label(FOLD).click());
    assert!(requests.contains(&PlacementSearchRequest::ShowSettings(false)), "{requests:?}");
    // Whoever starts again looks at what is found.
    start_and_wait(&mut app);
    assert_eq!(show(&app).0, 0);
    // Without a result there is nothing that the settings would be in the way of.
    let wish = Wish { figure: Some(Metric::TIP_MAX), ..Wish::of(document(&app).design()) };
    assert_eq!(wish.summary(document(&app).design()), "2 sensors of the tool · tip error max");
    app.insert_resource(OpenWorld(world()));
    app.world_mut().resource_mut::<WorldGeneration>().0 += 1;
    settle(&mut app);
    let requests = use_search(&app, |harness| {
        harness.get_by_role_and_label(Role::CheckBox, "shaft").click();
        assert_eq!(harness.query_all_by_label(UNFOLD).count(), 0);
    });
    assert_eq!(requests.len(), 1);
}

#[test]
fn the_panel_chooses_what_may_move() {
    let app = app();
    let design = document(&app).design();
    let wish = Wish::of(design);
    let after = |label: &str| {
        let requests = use_search(&app, |harness| {
            harness.get_by_role_and_label(Role::CheckBox, label).click();
        });
        match requests.as_slice() {
            [PlacementSearchRequest::Set(wish), ..] => wish.clone(),
            other => panic!("{label}: {other:?}"),
        }
    };
    assert_eq!(after("shaft"), Wish { tool: [1].into(), ..wish.clone() });
    assert_eq!(after("Sensors of the tool"), Wish { tool: [].into(), ..wish.clone() });
    assert_eq!(after("Sensors of the CRF"), Wish { crf: [0, 1, 2].into(), ..wish.clone() });
    let moves = after("Field generator").moves(design);
    assert_eq!(moves.generator.map(|bounds| bounds.turn_deg), Some(10.0));
    let counted = after("Number of sensors").moves(design);
    assert_eq!(counted.sensors, Some(1..=3));
}

#[test]
fn what_sensors_are_built_within_is_typed() {
    let app = app();
    let wish = Wish::of(document(&app).design());
    assert_eq!((wish.built.position_mm, wish.built.angle_deg), (0.2, 0.3));
    for (field, text, built) in [
        ("building error in mm", "0.45", BuiltError { position_mm: 0.45, ..wish.built }),
        ("building error in degrees", "0", BuiltError { angle_deg: 0.0, ..wish.built }),
    ] {
        let requests = use_search(&app, |harness| {
            harness.get_by_label(field).click();
            harness.run_steps(2);
            harness.get_by_label(field).type_text(text);
            harness.run_steps(1);
            harness.key_press(egui::Key::Enter);
        });
        let wanted = PlacementSearchRequest::Set(Wish { built, ..wish.clone() });
        assert_eq!(requests, [wanted], "{field}");
    }
}

const KINDS: [SensorChoice; 2] = [
    SensorChoice { degrees_of_freedom: 5, coil: None, cost: 120.0 },
    SensorChoice { degrees_of_freedom: 6, coil: None, cost: 300.0 },
];

#[test]
fn kinds_of_sensors_are_stated_with_costs() {
    let mut app = app();
    let wish = Wish::of(document(&app).design());
    let changed = |app: &App, act: &dyn Fn(&mut Harness)| {
        let requests = use_search(app, |harness| act(harness));
        match requests.into_iter().next() {
            Some(PlacementSearchRequest::Set(wish)) => wish,
            other => panic!("{other:?}"),
        }
    };
    let first = changed(&app, &|harness| harness.get_by_label("Kinds of sensors").click());
    // As the first that moves is, at one unit.
    let [own] = first.kinds[..] else { panic!("{first:?}") };
    assert_eq!((own.degrees_of_freedom, own.coil, own.cost), (5, None, 1.0));
    write(&mut app, PlacementSearchRequest::Set(first.clone()));
    let second = changed(&app, &|harness| harness.get_by_label("Add kind").click());
    assert_eq!(second.kinds, [own, SensorChoice { degrees_of_freedom: 6, ..own }]);
    write(&mut app, PlacementSearchRequest::Set(second));
    let typed = changed(&app, &|harness| {
        harness.get_by_label("cost of kind 2").click();
        harness.run_steps(2);
        harness.get_by_label("cost of kind 2").type_text("300");
        harness.run_steps(1);
        harness.key_press(egui::Key::Enter);
    });
    assert_eq!(typed.kinds[1].cost, 300.0);
    let coil = changed(&app, &|harness| harness.get_by_label("coil of kind 1").click());
    // That of the first sensor that moves.
    assert_eq!(coil.kinds[0].coil, Some(Coil { diameter_mm: 1.0, length_mm: 2.0 }));
    write(&mut app, PlacementSearchRequest::Set(coil.clone()));
    assert_eq!(coil.moves(document(&app).design()).kinds, coil.kinds);
    let (mut harness, _) =
        panel([276.0, 900.0], |ui| placement_search_ui(ui, document(&app).design(), search(&app)));
    harness.run_steps(3);
    assert_nothing_overlaps(&harness, 276.0, 20);
    drop(harness);
    let left = changed(&app, &|harness| harness.get_by_label("Remove kind 1").click());
    assert_eq!(left.kinds, coil.kinds[1..]);
    let none = changed(&app, &|harness| harness.get_by_label("Kinds of sensors").click());
    assert_eq!(none, wish);
}

#[test]
fn too_many_sets_of_kinds_are_refused() {
    let app = app();
    let design = document(&app).design();
    let kinds = vec![KINDS[0]; 6];
    let wish = Wish { kinds, counts: Some([1, 5]), ..Wish::of(design) };
    let why = wish.refusal(design).unwrap();
    // Of 1 to 5 sensors of six kinds: 6 + 21 + 56 + 126 + 252.
    assert!(why.starts_with("These kinds and numbers make 461 sets of sensors"), "{why}");
    let few = Wish { counts: Some([1, 2]), ..wish.clone() };
    assert_eq!(few.refusal(design), None);
    // Kinds are of sensors that move.
    let none =
        Wish { tool: [].into(), generator: Reach { is_free: true, ..wish.generator }, ..wish };
    assert_eq!((none.refusal(design), none.moves(design).kinds), (None, vec![]));
}

#[test]
fn designs_of_each_cost_can_be_taken() {
    let mut app = app();
    let wish = Wish { kinds: KINDS.to_vec(), ..Wish::of(document(&app).design()) };
    write(&mut app, PlacementSearchRequest::Set(wish));
    start_and_wait(&mut app);
    let found = optimized(&app);
    let costs: Vec<f64> = found.pareto.iter().filter_map(|layout| layout.cost).collect();
    assert_eq!(costs.len(), found.pareto.len());
    assert!(costs.iter().all(|cost| [240.0, 420.0, 600.0].contains(cost)), "{costs:?}");
    let cheap = found.best.clone();
    let dear = Layout { cost: Some(600.0), objective: cheap.objective - 0.1, ..cheap.clone() };
    let cheap = Layout { cost: Some(240.0), ..cheap };
    let in_all = cheap.tool.sensors.len() + cheap.crf.as_ref().map_or(0, |crf| crf.sensors.len());
    {
        let mut search = app.world_mut().resource_mut::<PlacementSearch>();
        search.result.as_mut().unwrap().1.optimized.pareto = vec![cheap, dear];
    }
    let requests = use_search(&app, |harness| {
        harness.get_by_label("By cost");
        harness.get_by_label(&format!("{in_all} sensors, cost 240"));
        harness.get_by_label(&format!("{in_all} sensors, cost 600")).click();
    });
    let second = AnswerId::Pareto(1);
    assert!(requests.contains(&PlacementSearchRequest::Show(second)), "{requests:?}");
}

#[test]
fn another_design_forgets_the_search() {
    let mut app = app();
    start_and_wait(&mut app);
    app.insert_resource(OpenWorld(world()));
    app.world_mut().resource_mut::<WorldGeneration>().0 += 1;
    settle(&mut app);
    assert!(search(&app).result.is_none());
    assert_eq!(search(&app).wish, Some(Wish::of(document(&app).design())));
}

#[test]
fn a_command_opens_the_panel() {
    let mut app = app();
    write(&mut app, PlacementSearchRequest::Close);
    assert!(!search(&app).is_open);
    app.insert_resource(workspaces::study::WORKSPACE);
    assert_eq!(FIND_PLACES.name, "Find better places");
    app.world_mut().write_message(RunCommand(FIND_PLACES.name));
    app.update();
    assert!(search(&app).is_open);
    assert_eq!(*app.world().resource::<Workspace>(), workspaces::design::WORKSPACE);
}

#[test]
fn the_best_so_far_is_a_ghost_in_the_scene() {
    let mut app = create_scene_app_with(|app| {
        app.add_plugins((DesignPlugin, PlacementGhostsPlugin));
    });
    app.insert_resource(workspaces::design::WORKSPACE);
    app.insert_resource(OpenWorld(trackwright_project::open_builtin(DEFAULT_BUILTIN).unwrap()));
    settle(&mut app);
    let (design, room) = {
        let open = &app.world().resource::<OpenWorld>().0;
        (open.document.shared_design(), Arc::clone(&open.environment))
    };
    let mut tool = design.tool.body.rigid.clone();
    tool.sensors[0].position_in_body.z += 12.0;
    let requirement = Requirement::at_most([(Metric::TIP_RMS, 1.0)]);
    let of = Arc::new(Searched {
        generation: 0,
        revision: document(&app).revision(),
        wish: Wish::of(&design),
        goal: trackwright_optimization::Goal::Requirement(requirement),
        design: Arc::clone(&design),
        room,
    });
    let best = Layout {
        tool,
        crf: design.crf.as_ref().map(|crf| crf.body.rigid.clone()),
        tracker_from_crf: design.crf.as_ref().map(|crf| crf.tracker_from_crf),
        crf_from_tool: design.tool.crf_from_tool,
        objective: 0.75,
        studies: Vec::new(),
        cost: None,
    };
    let enough = CancelToken::default();
    let running = Running { of, enough, best: Some(Box::new(best)), evaluations: 10 };
    {
        let mut search = app.world_mut().resource_mut::<PlacementSearch>();
        search.running = Some(running);
        (search.is_open, search.is_current) = (true, true);
    }
    app.update();
    // Only the one that moved.
    assert_eq!(named(&mut app, "found sensor"), 1);
    let words =
        |app: &App| app.world().resource::<Legends>().words(LEGEND_ORDER).map(str::to_owned);
    assert_eq!(words(&app).as_deref(), Some("best places so far: 0.75 of the requirement"));
    for hide in [PlacementSearchRequest::Close, PlacementSearchRequest::Open] {
        let is_open = hide == PlacementSearchRequest::Open;
        write(&mut app, hide);
        assert_eq!(named(&mut app, "found sensor"), usize::from(is_open));
        assert_eq!(words(&app).is_some(), is_open);
    }
    // Of a design that was edited they are no longer.
    let mut sensor = design.tool.body.rigid.sensors[0].clone();
    sensor.position_in_body.z += 1.0;
    apply(&mut app, Edit::SetSensor { body: BodyRole::Tool, index: 0, sensor });
    app.update();
    assert_eq!((named(&mut app, "found sensor"), words(&app)), (0, None));
}
