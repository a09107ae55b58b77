//! Where a model is valid: what keeping it adds to a fit, and what evaluating it costs beside
//! the leverage taken from the singular value decomposition of each orientation.

use super::{bounds, poses, samples};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::{Point3, Unit, Vector3};
use trackwright_field::bernstein::products;
use trackwright_field::fit::{DEFAULT_RCOND, Decomposed, Factored, FitSettings, factor};
use trackwright_field::samples::SampleSet;
use trackwright_field::validity::FitValidity;
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_geometry::directions::DirectionSet;
use trackwright_task::Task;

const SAMPLES: usize = 4000;
const POSES: usize = 1000;

struct Fitted {
    set: SampleSet,
    factored: Factored,
    model: DistortionModel,
}

fn fitted(order: usize) -> Fitted {
    let set = samples(SAMPLES);
    let settings = FitSettings::new(order, DirectionSet::Fourteen);
    let factored = factor(&set, &settings, Some(bounds()), &Task::default()).expect("samples");
    let solved = factored.solve(DEFAULT_RCOND, 0.0).expect("samples fit");
    Fitted { set, factored, model: solved.model }
}

/// What is kept of a fit besides.
#[divan::bench(args = [2, 4], sample_count = 5)]
fn of_fit(bencher: Bencher, order: usize) {
    let f = fitted(order);
    bencher.bench_local(|| {
        FitValidity::of_fit(black_box(&f.set), &f.factored, &f.model, &Task::default())
    });
}

/// Standard errors, leverage and distance at a pose.
#[divan::bench(args = [2, 4])]
fn at(bencher: Bencher, order: usize) {
    let f = fitted(order);
    let validity =
        FitValidity::of_fit(&f.set, &f.factored, &f.model, &Task::default()).expect("validity");
    let poses = poses(POSES);
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        for (position_mm, axis) in &poses {
            black_box(validity.at(black_box(position_mm), axis, OutsidePolicy::Clamp));
        }
    });
}

/// The leverage alone, from the decomposition that the fit is solved by.
#[divan::bench(args = [2, 4], sample_count = 10)]
fn plain_leverage(bencher: Bencher, order: usize) {
    let f = fitted(order);
    let decomposed = f.factored.decompose().expect("samples fit");
    let poses = poses(POSES);
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        for (position_mm, axis) in &poses {
            black_box(leverage(&f.model, &decomposed, position_mm, axis));
        }
    });
}

fn leverage(
    model: &DistortionModel,
    decomposed: &Decomposed,
    position_mm: &Point3<f64>,
    axis: &Unit<Vector3<f64>>,
) -> f64 {
    let row = products(model.order(), &bounds().to_unit(position_mm));
    let weights = model.directions().weights(axis, model.weighting());
    let mut largest = 0.0_f64;
    for (&direction, &weight) in weights.directions.iter().zip(&weights.weights) {
        if weight <= 0.0 {
            continue;
        }
        let system = &decomposed.systems[direction];
        let mut sum = 0.0;
        for (k, singular_value) in system.singular_values.iter().enumerate() {
            let along: f64 = (0..row.len()).map(|i| weight * row[i] * system.v[(i, k)]).sum();
            sum += (along / singular_value).powi(2);
        }
        largest = largest.max(sum);
    }
    largest
}
