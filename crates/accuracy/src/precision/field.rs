//! The field: equation (8) at poses of the design's room and at other orders, against itself in
//! 192 bits.

use super::interpolated::ValueLattice;
use super::sampling::poses;
use super::single::{SingleModel, single_pose};
use super::{Bench, Row, Settings, Stop, What};
use crate::high::High;
use crate::references;
use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;
use trackwright_field::batch::Batch;
use trackwright_field::fit::{FitSettings, fit};
use trackwright_field::model::{Coefficient, Evaluation};
use trackwright_field::samples::{PoseError, Sample, SampleSet};
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, DirectionWeights};

/// Poses anywhere, with any axis: the design's room.
const SCATTERED: &str = "scattered poses in the design's room";
/// Poses of one axis.
const ONE_AXIS: &str = "poses of one orientation in the design's room";
/// Points of a lattice, one axis.
const LATTICE: &str = "a lattice of one orientation in the design's room";

/// Nodes a side of the lattices that are interpolated.
const NODES: [usize; 5] = [5, 9, 17, 33, 65];

/// A lattice of values that is larger is left out: nobody would keep it for a study.
const MAX_LATTICE_BYTES: usize = 64 << 20;

/// The set of orientations that orders are compared at, the paper's.
const USUAL_DIRECTIONS: DirectionSet = DirectionSet::Fourteen;
/// The order that sets of orientations are compared at.
const USUAL_ORDER: usize = 4;

type ScatteredPose = (Point3<f64>, Unit<Vector3<f64>>);

/// Every way of evaluating the field.
pub fn measure(bench: &mut Bench) -> Result<(), Stop> {
    let (model, settings) = (bench.room(), bench.settings);
    bench.family.charted = SCATTERED.to_owned();
    bench.family.about =
        "Equation (8) at poses spread over the room's box, one thread, triangle search and \
                weights in the time. The error is the largest difference of a position from the \
                same sum in 192 bits: a few 1e-15 mm are round-off, and which of them is less is \
                chance. Where the room is replaced by a smaller model or by a lattice \
                of its values, it is that replacement's distance from the room. Lattices and \
                replacements are made beforehand, outside the time."
            .to_owned();
    bench.need_field("there is no field to evaluate")?;
    let others = other_models(settings.max_order);
    bench.steps = 5 + others.len();
    let scattered = poses(model.bounds(), settings.poses, settings.seed);
    let probe = Probe::new(model, scattered.clone(), SCATTERED, settings);
    bench.next()?;
    bench.family.rows.extend(probe.plain_and_single(true));
    bench.next()?;
    bench.family.rows.extend(probe.interpolated());
    bench.next()?;
    bench.family.rows.extend(probe.replaced(settings));
    bench.next()?;
    bench.family.rows.extend(shared(model, settings));
    bench.next()?;
    for (order, directions) in others {
        let other = resampled(model, order, directions);
        let orientations = match directions.len() {
            1 => "one orientation".to_owned(),
            count => format!("{count} orientations"),
        };
        let problem = format!("round-off at order {order}, {orientations}");
        let probe = Probe::new(&other, scattered.clone(), &problem, settings);
        // Another room's round-off: in the table, not beside the room's in the picture.
        let rows = probe.plain_and_single(false).into_iter().map(Row::uncharted);
        bench.family.rows.extend(rows);
        bench.next()?;
    }
    Ok(())
}

/// Orders at the usual set, then sets at the usual order.
fn other_models(max_order: usize) -> Vec<(usize, DirectionSet)> {
    let orders = (1..=max_order).map(|order| (order, USUAL_DIRECTIONS));
    let sets = DirectionSet::ALL
        .into_iter()
        .filter(|&set| set != USUAL_DIRECTIONS && USUAL_ORDER <= max_order)
        .map(|set| (USUAL_ORDER, set));
    orders.chain(sets).collect()
}

/// A model of another size with values like the room's: its coefficients are the room's field at
/// their nodes.
fn resampled(room: &DistortionModel, order: usize, directions: DirectionSet) -> DistortionModel {
    let (bounds, axes) = (*room.bounds(), directions.directions());
    let coefficients = ValueLattice::new(room, axes, order + 1).values;
    DistortionModel::new(order, directions, room.weighting(), room.map(), bounds, coefficients)
        // Only an order beyond the largest could be refused.
        .unwrap_or_else(|_| room.clone())
}

/// Poses that all share an axis allow less work, and those of a lattice less still.
fn shared(model: &DistortionModel, settings: &Settings) -> Vec<Row> {
    let axis = Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8));
    let positions = poses(model.bounds(), settings.poses, settings.seed)
        .into_iter()
        .map(|(position, _)| (position, axis))
        .collect();
    let probe = Probe::new(model, positions, ONE_AXIS, settings);
    let mut rows = vec![
        probe.scattered("scattered", model, false).uncharted(),
        probe.shared(&axis, true).charted("shared orientation"),
    ];
    let only = DirectionWeights { directions: [0; 3], weights: [1.0, 0.0, 0.0] };
    for nodes in NODES {
        let lattice = ValueLattice::new(model, &[axis], nodes);
        let spacing = ValueLattice::spacing_mm(model.bounds(), nodes);
        let row = probe.row(
            &format!("interpolated lattice of one orientation, {spacing:.1} mm"),
            false,
            |out| out.extend(probe.poses.iter().map(|(p, _)| lattice.at(p, &only))),
        );
        rows.push(row.step_of("interpolated lattice, one orientation"));
    }
    let side = (settings.poses as f64).cbrt().round() as usize;
    let coordinates = [0, 1, 2].map(|k| place(model.bounds(), k, side));
    let points = coordinates[0]
        .iter()
        .flat_map(|&x| coordinates[1].iter().map(move |&y| (x, y)))
        .flat_map(|(x, y)| coordinates[2].iter().map(move |&z| Point3::new(x, y, z)))
        .map(|position| (position, axis))
        .collect();
    let probe = Probe::new(model, points, LATTICE, settings);
    rows.push(probe.scattered("scattered", model, false).uncharted());
    rows.push(probe.shared(&axis, false).uncharted());
    let row = probe.row("lattice", true, |out: &mut Vec<Evaluation>| {
        let coordinates = coordinates.each_ref().map(Vec::as_slice);
        model.at_axis(&axis).evaluate_lattice(coordinates, OutsidePolicy::Clamp, out);
    });
    rows.push(row.charted("lattice, one orientation"));
    rows
}

/// Evenly spaced coordinates along an axis of the box, both ends included.
fn place(bounds: &Bounds, axis: usize, count: usize) -> Vec<f64> {
    let (min, size) = (bounds.min_mm[axis], bounds.size_mm()[axis]);
    let last = count.saturating_sub(1).max(1) as f64;
    (0..count).map(|i| min + i as f64 / last * size).collect()
}

/// A room evaluated at some poses, with the exact answers.
struct Probe<'a> {
    model: &'a DistortionModel,
    poses: Vec<ScatteredPose>,
    exact: Vec<Vec<High>>,
    problem: &'a str,
    settings: &'a Settings,
}

impl<'a> Probe<'a> {
    fn new(
        model: &'a DistortionModel,
        poses: Vec<ScatteredPose>,
        problem: &'a str,
        settings: &'a Settings,
    ) -> Self {
        let exact = poses.par_iter().map(|(p, a)| exact_position_mm(model, p, a)).collect();
        Self { model, poses, exact, problem, settings }
    }

    /// A row for one way to get all values, in whatever form it gives them.
    fn row<T: Answer>(
        &self,
        method: &str,
        is_default: bool,
        mut evaluate: impl FnMut(&mut Vec<T>),
    ) -> Row {
        let mut found = Vec::with_capacity(self.poses.len());
        let (seconds, ()) = self.settings.timing.measure(|| {
            found.clear();
            evaluate(&mut found);
        });
        let error = self
            .exact
            .iter()
            .zip(&found)
            .map(|(exact, found)| references::distance(found.position_mm().as_slice(), exact))
            .fold(0.0, f64::max);
        Row::new(What::Field, self.model, self.problem, method)
            .measured(self.poses.len(), seconds, error)
            .default_if(is_default)
    }

    /// The path that simulations take.
    fn scattered(&self, method: &str, model: &DistortionModel, is_default: bool) -> Row {
        let (positions, axes): (Vec<_>, Vec<_>) = self.poses.iter().copied().unzip();
        let mut batch = Batch::default();
        self.row(method, is_default, |out: &mut Vec<Evaluation>| {
            batch.evaluate(model, &positions, &axes, OutsidePolicy::Clamp, out);
        })
    }

    /// The orientations blended once, in the time.
    fn shared(&self, axis: &Unit<Vector3<f64>>, is_default: bool) -> Row {
        let positions: Vec<_> = self.poses.iter().map(|(position, _)| *position).collect();
        let mut batch = Batch::default();
        self.row("shared-orientation", is_default, |out: &mut Vec<Evaluation>| {
            let model = self.model.at_axis(axis);
            model.evaluate_all(&mut batch, &positions, OutsidePolicy::Clamp, out);
        })
    }

    /// The program's own path, and plain loops in both precisions.
    fn plain_and_single(&self, is_default: bool) -> Vec<Row> {
        let single = SingleModel::new(self.model);
        let single_poses: Vec<_> = self.poses.iter().map(|(p, a)| single_pose(p, a)).collect();
        vec![
            self.scattered("scattered", self.model, is_default),
            self.row("plain loop", false, |out| {
                out.extend(
                    self.poses.iter().map(|(p, a)| self.model.evaluate(p, a, OutsidePolicy::Clamp)),
                );
            }),
            self.row("plain loop, f32", false, |out| {
                out.extend(single_poses.iter().map(|pose| single.evaluate(pose)));
            }),
        ]
    }

    /// The room's values at each basis orientation, read off lattices.
    fn interpolated(&self) -> Vec<Row> {
        let set = self.model.directions();
        NODES
            .into_iter()
            .filter(|&nodes| ValueLattice::bytes(set.len(), nodes) <= MAX_LATTICE_BYTES)
            .map(|nodes| {
                let lattice = ValueLattice::new(self.model, set.directions(), nodes);
                let spacing = ValueLattice::spacing_mm(self.model.bounds(), nodes);
                let weighting = self.model.weighting();
                let method = format!("interpolated lattice, {spacing:.1} mm");
                let row = self.row(&method, false, |out| {
                    out.extend(
                        self.poses.iter().map(|(p, a)| lattice.at(p, &set.weights(a, weighting))),
                    );
                });
                row.step_of("interpolated lattice")
            })
            .collect()
    }

    /// Models of lower order or with fewer orientations, fitted to the room.
    fn replaced(&self, settings: &Settings) -> Vec<Row> {
        let own = (self.model.order(), self.model.directions());
        let lower = (1..own.0).map(|order| ("lower order", order, own.1));
        let fewer = DirectionSet::ALL
            .into_iter()
            .filter(|set| set.len() < own.1.len())
            .map(|set| ("fewer orientations", own.0, set));
        let samples = samples_of(self.model, settings);
        lower
            .chain(fewer)
            .filter_map(|(method, order, directions)| {
                let wanted = FitSettings {
                    weighting: self.model.weighting(),
                    map: self.model.map(),
                    ..FitSettings::new(order, directions)
                };
                let smaller = fit(&samples, &wanted, Some(*self.model.bounds())).ok()?.model;
                let row = self.scattered(method, &smaller, false);
                Some(Row { order, directions: directions.len(), ..row })
            })
            .collect()
    }
}

/// The exact position error at a pose. On an edge between triangles all of them give the same to
/// round-off, and the first is taken.
pub(super) fn exact_position_mm(
    model: &DistortionModel,
    position_mm: &Point3<f64>,
    axis: &Unit<Vector3<f64>>,
) -> Vec<High> {
    let (position, axis) = (references::point3(position_mm), references::axis3(axis));
    let all = references::evaluate(model, &position, &axis, OutsidePolicy::Clamp);
    all.into_iter().next().map_or_else(Vec::new, |found| found.values[..3].to_vec())
}

/// The room's model alone as samples, at other poses than those that it is judged at.
fn samples_of(model: &DistortionModel, settings: &Settings) -> SampleSet {
    let samples = poses(model.bounds(), settings.samples, settings.seed + 1)
        .into_iter()
        .map(|(position_mm, axis)| {
            let error: PoseError = model.evaluate(&position_mm, &axis, OutsidePolicy::Clamp).error;
            Sample::new(position_mm, axis, error)
        })
        .collect();
    SampleSet { samples, has_rotations: true, ambiguous: 0 }
}

/// What a way of evaluating gives.
trait Answer {
    fn position_mm(&self) -> Vector3<f64>;
}

impl Answer for Evaluation {
    fn position_mm(&self) -> Vector3<f64> {
        self.error.position_mm
    }
}

impl Answer for Coefficient {
    fn position_mm(&self) -> Vector3<f64> {
        Vector3::new(self[0], self[1], self[2])
    }
}

impl Answer for [f32; 8] {
    fn position_mm(&self) -> Vector3<f64> {
        Vector3::from_fn(|k, _| f64::from(self[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::testing;
    use trackwright_geometry::directions::Weighting;

    #[test]
    fn the_programs_answers_are_exact_to_round_off() {
        for weighting in [Weighting::Area, Weighting::Gnomonic] {
            for set in DirectionSet::ALL {
                let model = testing::model(4, set, weighting);
                let largest = testing::largest_mm(&model);
                for (position, axis) in poses(model.bounds(), 50, 3) {
                    let exact = exact_position_mm(&model, &position, &axis);
                    let found = model.evaluate(&position, &axis, OutsidePolicy::Clamp);
                    let off = references::distance(found.error.position_mm.as_slice(), &exact);
                    // Three directions, three sums of five terms: some tens of roundings.
                    assert!(off < 100.0 * f64::EPSILON * largest, "{set:?} {off:e}");
                }
            }
        }
    }

    #[test]
    fn a_linear_field_is_exact() {
        let model = testing::linear_model(4);
        let at = Point3::new(0.0, 25.0, -150.0);
        let exact = exact_position_mm(&model, &at, &Vector3::z_axis());
        for (exact, expected) in exact.iter().zip([0.5, 0.75]) {
            assert!((exact - High::from(expected)).abs() < High::from(1e-30));
        }
    }
}
