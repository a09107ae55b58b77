//! The joint fit by its sparsity is the joint fit by the whole design matrix.

use super::support::{bounds, places, unlike};
use nalgebra::{Unit, Vector3};
use trackwright_field::bernstein::{coefficient_count, products};
use trackwright_field::fit::{Fit, FitMethod, FitSettings, factor, fit};
use trackwright_field::least_squares::{LeastSquares, Solution};
use trackwright_field::samples::{PoseError, Sample, SampleSet};
use trackwright_geometry::directions::DirectionSet;
use trackwright_task::Task;

/// Samples of no field in particular.
fn samples(count: usize) -> SampleSet {
    let samples = places(count, &bounds()).into_iter().enumerate();
    let samples = samples.map(|(i, (position_mm, axis))| {
        Sample::new(
            position_mm,
            axis,
            PoseError {
                position_mm: Vector3::from_fn(|k, _| unlike(i, k)),
                rotation_rad: Vector3::from_fn(|k, _| unlike(i, 3 + k)),
            },
        )
    });
    SampleSet { samples: samples.collect(), has_rotations: true, ambiguous: 0 }
}

fn settings(order: usize, directions: DirectionSet, ridge: f64) -> FitSettings {
    FitSettings { method: FitMethod::Joint, ridge, ..FitSettings::new(order, directions) }
}

/// The whole design matrix, row by row, and its singular value decomposition.
fn dense(set: &SampleSet, settings: &FitSettings) -> Solution {
    let block = coefficient_count(settings.order);
    let unknowns = settings.directions.len() * block;
    let mut system = LeastSquares::new(unknowns);
    for s in &set.samples {
        let weights = settings.directions.weights(&s.axis, settings.weighting);
        let products = products(settings.order, &bounds().to_unit(&s.position_mm));
        system.push(
            |row| {
                let start = row.len();
                row.resize(start + unknowns, 0.0);
                for (&direction, &w) in weights.directions.iter().zip(&weights.weights) {
                    for (i, product) in products.iter().enumerate() {
                        row[start + direction * block + i] += w * product;
                    }
                }
            },
            s.error.values(),
        );
    }
    system.into_triangle().decompose().unwrap().solve(settings.rcond, settings.ridge)
}

/// Round-off of a solution: condition times epsilon, some hundred operations deep.
#[track_caller]
fn assert_same(found: &Fit, expected: &Solution) {
    let report = found.systems[0];
    assert_eq!(report.rank, expected.rank);
    assert!(
        (report.condition / expected.condition - 1.0).abs()
            < 1e-11 + 100.0 * f64::EPSILON * expected.condition,
        "condition {} and {}",
        report.condition,
        expected.condition
    );
    let size = |c: &[[f64; 6]]| c.iter().flatten().map(|v| v * v).sum::<f64>().sqrt();
    let found = found.model.coefficients();
    let difference: Vec<[f64; 6]> = found
        .iter()
        .zip(&expected.unknowns)
        .map(|(f, e)| std::array::from_fn(|k| f[k] - e[k]))
        .collect();
    let bound = 100.0 * f64::EPSILON * report.condition * size(&expected.unknowns);
    assert!(size(&difference) <= bound, "{} is more than {bound}", size(&difference));
}

#[test]
fn determined_systems_are_solved_alike() {
    let small =
        [DirectionSet::One, DirectionSet::Six, DirectionSet::Twelve, DirectionSet::Fourteen];
    let small = small.into_iter().flat_map(|directions| [1, 2].map(|order| (directions, order)));
    let small = small.map(|(directions, order)| {
        (directions, order, 60 * directions.len() * order * order, &[0.0, 1e-3, 0.1][..])
    });
    let large = [DirectionSet::TwentySix, DirectionSet::FortyTwo];
    let large = large.into_iter().map(|directions| (directions, 1, 2500, &[0.0][..]));
    for (directions, order, count, ridges) in small.chain(large) {
        let set = samples(count);
        for ridge in ridges {
            let settings = settings(order, directions, *ridge);
            let found = fit(&set, &settings, Some(bounds())).unwrap();
            assert_eq!(found.systems[0].rank, found.systems[0].unknowns, "{settings:?}");
            assert_same(&found, &dense(&set, &settings));
        }
    }
}

#[test]
fn undetermined_systems_get_the_least_norm() {
    let half_a_sphere = |set: &mut SampleSet| set.samples.retain(|s| s.axis.z > 0.2);
    let one_plane =
        |set: &mut SampleSet| set.samples.iter_mut().for_each(|s| s.position_mm.x = 20.0);
    let few = |set: &mut SampleSet| set.samples.truncate(40);
    let one_axis = |set: &mut SampleSet| {
        let axis = Unit::new_normalize(Vector3::new(0.3, 0.5, 0.8));
        set.samples.iter_mut().for_each(|s| s.axis = axis);
    };
    let lacks: [&dyn Fn(&mut SampleSet); 4] = [&half_a_sphere, &one_plane, &few, &one_axis];
    for (case, lack) in lacks.iter().enumerate() {
        for directions in [DirectionSet::Six, DirectionSet::Fourteen] {
            for order in [1, 2] {
                let mut set = samples(1500);
                lack(&mut set);
                for ridge in [0.0, 1e-3] {
                    let settings = settings(order, directions, ridge);
                    let found = fit(&set, &settings, Some(bounds())).unwrap();
                    let expected = dense(&set, &settings);
                    assert!(expected.rank < found.systems[0].unknowns, "case {case}");
                    assert_same(&found, &expected);
                }
            }
        }
    }
}

#[test]
fn the_decomposition_is_that_of_the_whole() {
    let set = samples(800);
    let settings = settings(1, DirectionSet::Fourteen, 1e-2);
    let factored = factor(&set, &settings, Some(bounds()), &Task::default()).unwrap();
    let systems = factored.decompose().unwrap().systems;
    assert_eq!(systems.len(), 1);
    assert_eq!((systems[0].rows, systems[0].singular_values.len()), (800, 112));
    let found = systems[0].solve(settings.rcond, settings.ridge);
    let expected = dense(&set, &settings);
    for (f, e) in found.unknowns.iter().zip(&expected.unknowns) {
        // The condition is below 100 and the coefficients of order 1.
        assert!((0..6).all(|k| (f[k] - e[k]).abs() < 1e-12));
    }
}
