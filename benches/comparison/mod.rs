//! Designs beside each other: 20 of them in 10 rooms, against as many single studies, and what a room's
//! drawn fields cost.

use super::{bounds, samples, scenario};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use std::sync::Arc;
use trackwright_field::Environment;
use trackwright_field::fit::{DEFAULT_RCOND, FitSettings, factor};
use trackwright_field::validity::FitValidity;
use trackwright_geometry::directions::DirectionSet;
use trackwright_simulation::comparison::{Pair, Plan, Settings, compare};
use trackwright_simulation::{CancelToken, Mode, Scenario, study};
use trackwright_task::Task;

const DESIGNS: usize = 20;
const ROOMS: usize = 10;

/// The built-in design with its sensors moved along the tool, in rooms of order 4 with 14 orientations
/// that keep their model validity.
fn plan() -> Plan {
    let set = samples(4000);
    let settings = FitSettings::new(4, DirectionSet::Fourteen);
    let task = Task::default();
    let factored = factor(&set, &settings, Some(bounds()), &task).expect("samples");
    let model = factored.solve(DEFAULT_RCOND, 0.0).expect("samples fit").model;
    let support = FitValidity::of_fit(&set, &factored, &model, &task).expect("support");
    let base = scenario(4);
    let rooms: Vec<Arc<Environment>> = (0..ROOMS)
        .map(|_| {
            Arc::new(Environment {
                model: model.clone(),
                fit_validity: Some(support.clone()),
                ..Environment::clone(&base.environment)
            })
        })
        .collect();
    let moved = |design: usize, room: &Arc<Environment>| {
        let mut scenario = Scenario { environment: Arc::clone(room), ..base.clone() };
        for sensor in &mut scenario.tool.sensors {
            sensor.position_in_body.z += design as f64;
        }
        scenario
    };
    let pairs = (0..DESIGNS * ROOMS).map(|pair| {
        let (design, room) = (pair / ROOMS, pair % ROOMS);
        Pair { design, room, scenario: moved(design, &rooms[room]) }
    });
    Plan { pairs: pairs.collect(), rooms: rooms.clone(), baseline: 0 }
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn of_20_designs_in_10_rooms(bencher: Bencher) {
    let plan = plan();
    let settings = Settings::default();
    bencher
        .counter(ItemsCount::new(DESIGNS * ROOMS))
        .bench_local(|| compare(black_box(&plan), &settings, &Task::default()));
}

/// The same studies one after the other, without a word on their differences.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn single_studies(bencher: Bencher) {
    let plan = plan();
    bencher.counter(ItemsCount::new(DESIGNS * ROOMS)).bench_local(|| {
        for pair in &plan.pairs {
            let study = study(&pair.scenario, &Mode::Motion, &CancelToken::default(), None);
            let _ = black_box(study);
        }
    });
}

/// The fields that one room might as well have.
#[divan::bench(sample_count = 5, sample_size = 1)]
fn drawn_fields_of_a_room(bencher: Bencher) {
    let plan = plan();
    let room = &plan.rooms[0];
    let support = room.fit_validity.as_ref().expect("a support");
    let draws = Settings::default().draws;
    bencher.bench_local(|| support.draw(&room.model, 0.0, draws, 0, &Task::default()));
}
