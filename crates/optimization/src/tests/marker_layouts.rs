//! Best layouts of an optical tool's markers, which are known in closed form (West and Maurer, IEEE
//! Trans. Medical Imaging 23(5), 2004): only the markers' jitter counts.

use super::cases::{ideal, needle_problem, plate, plate_top};
use crate::{BuiltError, MountedBody, Moves, Optimized, Problem, Settings, optimize};
use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};
use std::sync::Arc;
use trackwright_field::environment::Jitter;
use trackwright_simulation::{CancelToken, RigidBody, Sensor, SensorOrientation};
use trackwright_task::Task;

/// Of a marker, one axis.
const JITTER_MM: f64 = 0.2;

const TIP: [f64; 3] = [0.0, -150.0, 10.0];

/// `TRE² = FLE²/N (1 + ⅓ Σ d_k² / f_k²)` about the principal axes of the markers (Fitzpatrick, West,
/// Maurer, IEEE Trans. Medical Imaging 17(5), 1998), which West and Maurer's layouts make least.
fn tip_rms_mm(markers: &[Point3<f64>]) -> f64 {
    let n = markers.len() as f64;
    let mean: Vector3<f64> = markers.iter().map(|m| m.coords).sum::<Vector3<f64>>() / n;
    let spread: Matrix3<f64> = markers
        .iter()
        .map(|m| (m.coords - mean) * (m.coords - mean).transpose())
        .sum::<Matrix3<f64>>()
        / n;
    let eigen = SymmetricEigen::new(spread);
    let lever = Vector3::from(TIP) - mean;
    let mut ratio = 0.0;
    for k in 0..3 {
        let along = eigen.eigenvectors.column(k).dot(&lever);
        let away2 = lever.norm_squared() - along * along;
        // Of the markers' squared distance from the axis.
        let f2 = spread.trace() - eigen.eigenvalues[k];
        ratio += away2 / f2;
    }
    let fle2 = 3.0 * JITTER_MM * JITTER_MM;
    (fle2 / n * (1.0 + ratio / 3.0)).sqrt()
}

fn problem(markers: usize) -> Problem {
    let mut environment = ideal();
    environment.jitter = Some(Jitter::uniform(JITTER_MM, 0.0));
    let mut problem = needle_problem(vec![Arc::new(environment)], &[30.0], 0);
    let sensors = (0..markers).map(|k| {
        let angle = k as f64 * 2.3;
        let at = [12.0 * angle.cos(), 9.0 * angle.sin(), 0.0];
        Sensor::new(format!("marker {k}"), at, SensorOrientation::Marker)
    });
    let tool = RigidBody {
        name: "optical tool".into(),
        tip_in_body: Some(TIP.into()),
        sensors: sensors.collect(),
    };
    problem.scenarios[0].tool = tool;
    problem.tool = MountedBody::of_mesh(plate_top(), &plate());
    problem.moves = Moves { tool: (0..markers).collect(), ..Moves::default() };
    problem
}

fn search(problem: &Problem) -> Optimized {
    let settings = Settings { most_fits: 4_000_000, ..Settings::default() };
    optimize(problem, &settings, &CancelToken::default(), &Task::default(), &mut |_| ()).unwrap()
}

/// The least by the closed form over a grid of places in the same bounds.
fn least_mm(markers: usize) -> f64 {
    let steps = 11;
    let at = |k: usize| {
        let place = |k: usize| -25.0 + 50.0 * k as f64 / (steps - 1) as f64;
        Point3::new(place(k % steps), place(k / steps), 0.0)
    };
    let n = steps * steps;
    let mut least = f64::INFINITY;
    let mut chosen: Vec<usize> = (0..markers).collect();
    // All sets in lexicographic order.
    loop {
        let places: Vec<Point3<f64>> = chosen.iter().map(|k| at(*k)).collect();
        let value = tip_rms_mm(&places);
        if value < least {
            least = value;
        }
        let Some(last) = (0..markers).rev().find(|k| chosen[*k] < n - markers + k) else {
            return least;
        };
        chosen[last] += 1;
        for k in last + 1..markers {
            chosen[k] = chosen[k - 1] + 1;
        }
    }
}

#[test]
fn three_markers_are_placed_as_the_closed_form_has_it() {
    let found = search(&problem(3));
    let markers: Vec<_> = found.best.tool.sensors.iter().map(|s| s.position_in_body).collect();
    let closed = tip_rms_mm(&markers);
    let ratio = found.best.objective / closed;
    assert!((ratio - 1.0).abs() < 1e-9, "{} mm, {closed} mm", found.best.objective);
    let least = least_mm(3);
    assert!(closed <= 1.01 * least, "{closed} mm, least {least} mm");
}

#[test]
fn four_markers_are_placed_at_the_corners() {
    let found = search(&problem(4));
    let markers: Vec<_> = found.best.tool.sensors.iter().map(|s| s.position_in_body).collect();
    let corners = [[-25.0, -25.0], [25.0, -25.0], [-25.0, 25.0], [25.0, 25.0]]
        .map(|[x, y]| Point3::new(x, y, 0.0));
    // Where a rule of thumb and the closed form agree: the largest spread that the plate allows.
    let least = tip_rms_mm(&corners);
    let closed = tip_rms_mm(&markers);
    assert!(closed <= 1.01 * least, "{closed} mm, corners {least} mm, {markers:?}");
}

#[test]
fn what_is_built_off_counts_as_jitter_does() {
    let by_jitter = search(&problem(3));
    let mut built = problem(3);
    built.scenarios[0].environment = Arc::new(ideal());
    built.built = Some(BuiltError { position_mm: JITTER_MM, angle_deg: 0.0 });
    let by_building = search(&built);
    assert_eq!(by_building.best.objective, by_jitter.best.objective);
    assert_eq!(by_building.best.tool, by_jitter.best.tool);
}
