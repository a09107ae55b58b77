//! Choosing a model beside a plain loop that fits every candidate to every fold anew.

use super::samples;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use trackwright_field::OutsidePolicy;
use trackwright_field::fit::{fit, residuals};
use trackwright_field::samples::SampleSet;
use trackwright_field::selection::folds::Folds;
use trackwright_field::selection::{Candidate, DEFAULT_RIDGES, SelectSettings, select};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;
use trackwright_task::Task;

const ROWS: usize = 4000;

fn settings(order: usize) -> SelectSettings {
    SelectSettings {
        orders: vec![order],
        direction_sets: vec![DirectionSet::Fourteen],
        ..SelectSettings::for_samples(&samples(ROWS))
    }
}

/// One order with 14 orientations and as many ridges as `select` tries, five folds.
#[divan::bench(args = [2, 4], sample_count = 3)]
fn reusing_factorisations(bencher: Bencher, order: usize) {
    let (set, settings) = (samples(ROWS), settings(order));
    bencher
        .counter(ItemsCount::new(DEFAULT_RIDGES.len()))
        .bench_local(|| select(black_box(&set), None, &settings, &Task::default()));
}

#[divan::bench(args = [2, 4], sample_count = 1)]
fn plain_loop(bencher: Bencher, order: usize) {
    let (set, settings) = (samples(ROWS), settings(order));
    let bounds = Bounds::around(set.samples.iter().map(|s| s.position_mm)).expect("samples");
    let folds = Folds::of_rows(ROWS, settings.folds, settings.seed);
    bencher.counter(ItemsCount::new(DEFAULT_RIDGES.len())).bench_local(|| {
        for ridge in DEFAULT_RIDGES {
            let candidate = Candidate { order, directions: DirectionSet::Fourteen, ridge };
            let fit_settings = settings.fit_settings(&candidate);
            for held_out in &folds.rows {
                let (train, test) = split(&set, held_out);
                let fitted = fit(&train, &fit_settings, Some(bounds)).expect("samples fit");
                black_box(residuals(&fitted.model, &test, OutsidePolicy::Clamp));
            }
        }
    });
}

fn split(set: &SampleSet, held_out: &[usize]) -> (SampleSet, SampleSet) {
    let part = |is_wanted: &dyn Fn(usize) -> bool| SampleSet {
        samples: (0..set.samples.len())
            .filter(|row| is_wanted(*row))
            .map(|row| set.samples[row])
            .collect(),
        has_rotations: set.has_rotations,
        ambiguous: 0,
    };
    let is_held_out = |row| held_out.binary_search(&row).is_ok();
    (part(&|row| !is_held_out(row)), part(&is_held_out))
}
