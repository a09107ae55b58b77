//! Fits (4) of 14 orientations beside a plain one in the same run: for each orientation the whole
//! weighted matrix at once, by its singular value decomposition, as `lstsq` does.

use super::{bounds, samples};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use faer::Mat;
use trackwright_field::bernstein::{coefficient_count, push_products};
use trackwright_field::fit::{DEFAULT_RCOND, FitMethod, FitSettings, factor, fit};
use trackwright_field::samples::SampleSet;
use trackwright_geometry::directions::DirectionSet;
use trackwright_task::Task;

/// Order and samples.
const SIZES: [(usize, usize); 3] = [(4, 20_000), (4, 100_000), (6, 20_000)];

fn settings(order: usize) -> FitSettings {
    FitSettings::new(order, DirectionSet::Fourteen)
}

fn one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread").install(work)
}

/// Coefficients of one orientation, the singular value decomposition taken of all its rows.
fn plain(set: &SampleSet, order: usize, direction: usize) -> Mat<f64> {
    let settings = settings(order);
    let mut rows = Vec::new();
    for s in &set.samples {
        let weight = settings.directions.weights(&s.axis, settings.weighting).of(direction);
        if weight > 0.0 {
            rows.push((s, weight));
        }
    }
    let mut products = Vec::new();
    for (s, _) in &rows {
        push_products(order, &bounds().to_unit(&s.position_mm), &mut products);
    }
    let unknowns = coefficient_count(order);
    let a = Mat::from_fn(rows.len(), unknowns, |i, j| rows[i].1 * products[i * unknowns + j]);
    let b = Mat::from_fn(rows.len(), 6, |i, k| {
        let (s, weight) = rows[i];
        weight * s.error.values()[k]
    });
    let svd = a.thin_svd().expect("finite numbers");
    let largest = svd.S().column_vector()[0];
    let mut rotated = svd.U().transpose() * b;
    for (i, &s) in svd.S().column_vector().iter().enumerate() {
        let gain = if s > DEFAULT_RCOND * largest { 1.0 / s } else { 0.0 };
        (0..6).for_each(|k| rotated[(i, k)] *= gain);
    }
    svd.V() * rotated
}

#[divan::bench(args = SIZES, sample_count = 3)]
fn plain_svd_of_all_rows_one_thread(bencher: Bencher, (order, count): (usize, usize)) {
    let set = samples(count);
    bencher.counter(ItemsCount::new(count)).bench_local(|| {
        (0..14).map(|direction| plain(black_box(&set), order, direction)).collect::<Vec<_>>()
    });
}

#[divan::bench(args = SIZES, sample_count = 5)]
fn per_direction_one_thread(bencher: Bencher, (order, count): (usize, usize)) {
    let set = samples(count);
    bencher.counter(ItemsCount::new(count)).bench_local(|| {
        one_thread(|| {
            factor(black_box(&set), &settings(order), Some(bounds()), &Task::default())
                .and_then(|f| f.solve(DEFAULT_RCOND, 0.0))
        })
    });
}

#[divan::bench(args = SIZES, sample_count = 5)]
fn per_direction(bencher: Bencher, (order, count): (usize, usize)) {
    let set = samples(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| fit(black_box(&set), &settings(order), Some(bounds())));
}

/// 4,802 unknowns at order 6.
#[divan::bench(args = [(2, 20_000), (4, 20_000), (6, 20_000), (6, 100_000)], sample_count = 1)]
fn joint(bencher: Bencher, (order, count): (usize, usize)) {
    let set = samples(count);
    let settings = FitSettings { method: FitMethod::Joint, ..settings(order) };
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| fit(black_box(&set), &settings, Some(bounds())));
}
