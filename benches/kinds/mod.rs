//! Kinds of models in the built-in room: their fits, a study in each, and the paper's simulation.

use super::{built_in_samples, in_room};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use trackwright_calibration::room_fit::{RoomOrder, RoomTable, fit_room};
use trackwright_calibration::room_model::{GeneratorChoice, HarmonicOrder, RoomModel};
use trackwright_field::Environment;
use trackwright_field::fit::FitSettings;
use trackwright_field::generator::Generator;
use trackwright_field::harmonic::Loss;
use trackwright_field::samples::SampleSet;
use trackwright_geometry::directions::DirectionSet;
use trackwright_simulation::{CancelToken, Mode, run, study};
use trackwright_task::Task;

const KINDS: [&str; 5] = ["bernstein", "symmetric", "kriging", "harmonic", "harmonic, learned"];

fn model(kind: &str) -> RoomModel {
    let harmonic = |generator| {
        RoomModel::Harmonic(HarmonicOrder {
            generator,
            degree: Some(6),
            ridge: None,
            loss: Loss::Huber,
        })
    };
    match kind {
        "bernstein" => RoomModel::PAPER,
        "symmetric" => RoomModel::Bernstein { is_symmetric: true },
        "kriging" => RoomModel::Kriging,
        "harmonic" => harmonic(GeneratorChoice::Known(Generator::planar_nine())),
        _ => harmonic(GeneratorChoice::Learned(None)),
    }
}

fn fitted(kind: &str, samples: &SampleSet, with_support: bool) -> Environment {
    let order = RoomOrder {
        name: "bench",
        table: RoomTable { name: "cube", samples },
        held_out: None,
        model: &model(kind),
        settings: FitSettings { ridge: 0.1, ..FitSettings::new(3, DirectionSet::TwentySix) },
        bounds: None,
        volume: None,
        jitter: None,
        registration: None,
        with_support,
        sensors: None,
    };
    fit_room(&order, |_| Task::default()).expect("the built-in data fit").environment
}

/// 4,000 rows, with what they leave open of the field.
#[divan::bench(args = KINDS, sample_count = 3, sample_size = 1)]
fn fit_of_4000_rows(bencher: Bencher, kind: &str) {
    let samples = built_in_samples();
    bencher.bench_local(|| fitted(kind, black_box(&samples), true));
}

/// The same, the model alone; kriging has no other.
#[divan::bench(args = ["bernstein", "symmetric", "harmonic"], sample_count = 3, sample_size = 1)]
fn fit_of_4000_rows_model_alone(bencher: Bencher, kind: &str) {
    let samples = built_in_samples();
    bencher.bench_local(|| fitted(kind, black_box(&samples), false));
}

/// All cores; the compiled form is made before.
#[divan::bench(args = KINDS, sample_count = 20, sample_size = 1)]
fn room_field_of_3375_poses(bencher: Bencher, kind: &str) {
    let scenario = in_room(fitted(kind, &built_in_samples(), false));
    let room_field = || run(&scenario, &Mode::Motion, &CancelToken::default(), None);
    black_box(room_field()).expect("the built-in design");
    bencher.counter(ItemsCount::new(3_375_usize)).bench_local(room_field);
}

/// All cores: the same, and its figures in drawn fields.
#[divan::bench(args = KINDS, sample_count = 10, sample_size = 1)]
fn study_of_3375_poses(bencher: Bencher, kind: &str) {
    let scenario = in_room(fitted(kind, &built_in_samples(), true));
    let study = || study(&scenario, &Mode::Motion, &CancelToken::default(), None);
    black_box(study()).expect("the built-in room keeps its measurements");
    bencher.bench_local(study);
}
