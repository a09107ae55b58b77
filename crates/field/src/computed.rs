//! Models of a room that are no polynomials: what computes the field, and how it is evaluated.
//!
//! The mean of a Gaussian process is evaluated by its compiled form, made when it is first needed.
//! A harmonic model is evaluated itself (`harmonic/batch.rs` explains why).

use super::compiled::{CompiledField, FieldBounds};
use super::evaluation::Linearization;
use super::evaluation::{Coefficient, Evaluation};
use super::field_point::FieldPoint;
use super::gaussian::Kriging;
use super::generator::Generator;
use super::harmonic::HarmonicModel;
use super::made_once::made_once;
use super::samples::PoseError;
use nalgebra::{Matrix3, Point3, Unit, Vector3};
use std::fmt;
use std::sync::{Arc, OnceLock};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::DirectionSet;

/// What computes a field.
#[derive(Clone, Debug)]
pub enum FieldSource {
    Kriging(Arc<Kriging>),
    Harmonic(Arc<HarmonicModel>),
    /// What is simulated pose by pose, by whoever knows how.
    Simulated(Arc<dyn PoseErrors>),
    /// The mean over some axes, whatever the sensor's: of one axis, the field of that.
    Of(Box<MeanOverAxes>),
}

/// A field that does not depend on the axis any more.
#[derive(Clone, Debug)]
pub enum MeanOverAxes {
    Compiled(CompiledField),
    Evaluated { source: Arc<dyn PoseErrors>, axes: Vec<Unit<Vector3<f64>>> },
}

/// Errors of a tracker's readings, computed pose by pose.
pub trait PoseErrors: fmt::Debug + Send + Sync {
    /// The error at each pose of the tracker frame: a position in mm, then a rotation vector in rad;
    /// nothing where the tracker reports no pose. There are as many axes and values as positions.
    fn axis_errors(
        &self,
        positions_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
        out: &mut [Option<Coefficient>],
    );

    /// The coils whose disturbed fields the errors are made of; none where they are made in another way.
    fn coils(&self) -> Option<MadeOfCoils<'_>> {
        None
    }
}

/// What disturbs the fields of a generator's coils.
pub trait DisturbedCoils: Sync {
    fn generator(&self) -> &Generator;

    /// What is added to the field of every coil at a place; `None` in metal.
    fn disturbance(&self, p: &Point3<f64>) -> Option<Vec<Vector3<f64>>>;

    /// A distance that no metal is nearer than; infinite where none is known of.
    fn metal_distance_mm(&self, _p: &Point3<f64>) -> f64 {
        f64::INFINITY
    }
}

/// Coils whose disturbed fields make errors.
#[derive(Clone, Copy)]
pub struct MadeOfCoils<'a> {
    pub coils: &'a dyn DisturbedCoils,
    /// Whether others are added to them, which vary little where the metal's vary much.
    pub has_others: bool,
}

impl DisturbedCoils for HarmonicModel {
    fn generator(&self) -> &Generator {
        Self::generator(self)
    }

    fn disturbance(&self, p: &Point3<f64>) -> Option<Vec<Vector3<f64>>> {
        let mut fields = vec![Vector3::zeros(); Self::generator(self).coils.len()];
        Self::disturbance(self, p, &mut fields);
        Some(fields)
    }
}

impl PoseErrors for HarmonicModel {
    fn axis_errors(
        &self,
        positions_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
        out: &mut [Option<Coefficient>],
    ) {
        Self::axis_errors(self, positions_mm, axes, out);
    }

    fn coils(&self) -> Option<MadeOfCoils<'_>> {
        Some(MadeOfCoils { coils: self, has_others: false })
    }
}

impl PartialEq for FieldSource {
    /// What is simulated is the same where it is the same computation.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Kriging(a), Self::Kriging(b)) => a == b,
            (Self::Harmonic(a), Self::Harmonic(b)) => a == b,
            (Self::Simulated(a), Self::Simulated(b)) => Arc::ptr_eq(a, b),
            (Self::Of(a), Self::Of(b)) => a == b,
            _ => false,
        }
    }
}

impl PartialEq for MeanOverAxes {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Compiled(a), Self::Compiled(b)) => a == b,
            (
                Self::Evaluated { source: a, axes: of_a },
                Self::Evaluated { source: b, axes: of_b },
            ) => Arc::ptr_eq(a, b) && of_a == of_b,
            _ => false,
        }
    }
}

/// A field over a box. Beyond the box it is that of the nearest point.
#[derive(Clone, Debug)]
pub struct ComputedField {
    source: FieldSource,
    bounds: Bounds,
    compiled: OnceLock<CompiledField>,
}

/// Buffers for evaluations.
#[derive(Clone, Debug, Default)]
pub struct ComputedBatch {
    places_mm: Vec<Point3<f64>>,
    units: Vec<Vector3<f64>>,
    values: Vec<Coefficient>,
    readings: Vec<Option<Coefficient>>,
}

impl ComputedField {
    /// A field of a source over a box.
    pub fn new(source: FieldSource, bounds: Bounds) -> Self {
        Self { source, bounds, compiled: OnceLock::new() }
    }

    /// What computes the field.
    pub fn source(&self) -> &FieldSource {
        &self.source
    }

    /// The coils whose disturbed fields the errors are made of.
    pub fn coils(&self) -> Option<MadeOfCoils<'_>> {
        match &self.source {
            FieldSource::Harmonic(model) => PoseErrors::coils(model.as_ref()),
            FieldSource::Simulated(source) => source.coils(),
            FieldSource::Kriging(_) | FieldSource::Of(_) => None,
        }
    }

    /// The compiled form, where the field has one.
    pub fn compiled(&self) -> Option<&CompiledField> {
        match &self.source {
            FieldSource::Kriging(kriging) if kriging.depends_on_roll() => None,
            FieldSource::Kriging(kriging) => {
                Some(made_once(&self.compiled, || kriging.compiled(&self.bounds)))
            }
            FieldSource::Of(mean) => match &**mean {
                MeanOverAxes::Compiled(field) => Some(field),
                MeanOverAxes::Evaluated { .. } => None,
            },
            FieldSource::Harmonic(_) | FieldSource::Simulated(_) => None,
        }
    }

    /// The field of one axis, or its mean over axes.
    #[must_use]
    pub fn at_axis(&self, axis: Option<&Unit<Vector3<f64>>>) -> Self {
        let evaluated = |source: Arc<dyn PoseErrors>| MeanOverAxes::Evaluated {
            source,
            axes: axis
                .map_or_else(|| DirectionSet::Twelve.directions().to_vec(), |axis| vec![*axis]),
        };
        let mean = match (&self.source, self.compiled()) {
            (_, Some(field)) => MeanOverAxes::Compiled(field.at_axis(axis.map(Unit::as_ref))),
            (FieldSource::Harmonic(model), None) => evaluated(model.clone()),
            (FieldSource::Simulated(source), None) => evaluated(source.clone()),
            (FieldSource::Kriging(kriging), None) => evaluated(kriging.clone()),
            (FieldSource::Of(_), None) => return self.clone(),
        };
        Self::new(FieldSource::Of(Box::new(mean)), self.bounds)
    }

    /// Values at poses. Where the tracker would read nothing there is no error, and the pose counts as
    /// outside.
    pub fn evaluate_all(
        &self,
        batch: &mut ComputedBatch,
        positions_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
        out: &mut [Evaluation],
    ) {
        let count = positions_mm.len();
        batch.places_mm.clear();
        let clamped = positions_mm.iter().map(|p| self.bounds.clamp(p));
        batch.places_mm.extend(clamped);
        batch.readings.clear();
        if let Some(field) = self.compiled() {
            batch.units.clear();
            let units = batch.places_mm.iter().map(|p| self.bounds.to_unit(p));
            batch.units.extend(units);
            batch.values.resize(count, [0.0; 6]);
            field.evaluate_all(&batch.units, axes, &mut batch.values);
            let values = batch.values.iter().copied().map(Some);
            batch.readings.extend(values);
        } else {
            batch.readings.resize(count, None);
            self.read_all(&batch.places_mm, axes, &mut batch.readings);
        }
        for ((out, p), reading) in out.iter_mut().zip(positions_mm).zip(&batch.readings) {
            *out = Evaluation {
                error: PoseError::of_values(reading.unwrap_or_default()),
                is_inside: reading.is_some() && self.bounds.contains(p),
            };
        }
    }

    /// Values at poses of 6-DOF sensors, where the field depends on their roll; `None` where it does not.
    pub(super) fn evaluate_rolled(&self, points: &[FieldPoint]) -> Option<Vec<Evaluation>> {
        let FieldSource::Kriging(kriging) = &self.source else { return None };
        if !kriging.depends_on_roll() {
            return None;
        }
        let evaluated = |point: &FieldPoint| {
            let position_mm = self.bounds.clamp(&point.position_mm);
            let values = kriging.evaluate(&FieldPoint { position_mm, ..*point });
            Evaluation {
                error: PoseError::of_values(values),
                is_inside: self.bounds.contains(&point.position_mm),
            }
        };
        Some(points.iter().map(evaluated).collect())
    }

    /// What a field without a compiled form gives.
    fn read_all(
        &self,
        places_mm: &[Point3<f64>],
        axes: &[Unit<Vector3<f64>>],
        out: &mut [Option<Coefficient>],
    ) {
        match &self.source {
            FieldSource::Harmonic(model) => model.axis_errors(places_mm, axes, out),
            FieldSource::Simulated(source) => source.axis_errors(places_mm, axes, out),
            FieldSource::Of(mean) => {
                if let MeanOverAxes::Evaluated { source, axes } = &**mean {
                    mean_readings(source.as_ref(), places_mm, axes, out);
                }
            }
            FieldSource::Kriging(kriging) => kriging.axis_errors(places_mm, axes, out),
        }
    }

    /// The error at one pose.
    pub fn evaluate(&self, position_mm: &Point3<f64>, axis: &Unit<Vector3<f64>>) -> Evaluation {
        let mut out = [Evaluation { error: PoseError::of_values([0.0; 6]), is_inside: false }];
        let (p, n) = (std::slice::from_ref(position_mm), std::slice::from_ref(axis));
        self.evaluate_all(&mut ComputedBatch::default(), p, n, &mut out);
        out[0]
    }

    /// The error and its derivatives; a coordinate that is clamped moves nothing.
    pub fn linearized(
        &self,
        position_mm: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
    ) -> Linearization {
        let place = self.bounds.clamp(position_mm);
        let is_free = |k: usize| place[k] == position_mm[k] && self.bounds.size_mm()[k] > 0.0;
        let free = Matrix3::from_diagonal(&Vector3::from_fn(|k, _| f64::from(is_free(k))));
        let mut there = match self.compiled() {
            Some(field) => {
                let there = field.evaluate_with_slopes(&self.bounds.to_unit(&place), axis);
                let per_mm = self.bounds.size_mm().map(|s| if s > 0.0 { 1.0 / s } else { 0.0 });
                Linearization {
                    at: self.evaluate(position_mm, axis),
                    by_position: there.by_unit * Matrix3::from_diagonal(&per_mm),
                    by_axis: there.by_axis,
                }
            }
            None => self.by_differences(&place, axis),
        };
        there.at = self.evaluate(position_mm, axis);
        there.by_position *= free;
        there
    }

    /// Derivatives by central differences, at a place of the box or a hair beyond it.
    fn by_differences(&self, place: &Point3<f64>, axis: &Unit<Vector3<f64>>) -> Linearization {
        let tangent = trackwright_geometry::rotation::perpendicular(axis).into_inner();
        let tangents = [tangent, axis.cross(&tangent)];
        let mut places = Vec::with_capacity(10);
        let mut axes = Vec::with_capacity(10);
        for k in 0..3 {
            for sign in [1.0, -1.0] {
                places.push(place + Vector3::ith(k, sign * STEP_MM));
                axes.push(*axis);
            }
        }
        for tangent in tangents {
            for sign in [1.0, -1.0] {
                places.push(*place);
                axes.push(Unit::new_normalize(axis.as_ref() + tangent * (sign * STEP_RAD)));
            }
        }
        let mut read = [None; 10];
        self.read_all(&places, &axes, &mut read);
        let difference = |pair: usize, step: f64| {
            let [a, b] = [read[2 * pair], read[2 * pair + 1]].map(Option::unwrap_or_default);
            nalgebra::Vector6::from_fn(|c, _| (a[c] - b[c]) / (2.0 * step))
        };
        let mut found = Linearization {
            at: self.evaluate(place, axis),
            by_position: nalgebra::SMatrix::zeros(),
            by_axis: nalgebra::SMatrix::zeros(),
        };
        for k in 0..3 {
            found.by_position.set_column(k, &difference(k, STEP_MM));
        }
        for (k, tangent) in tangents.iter().enumerate() {
            found.by_axis += difference(3 + k, STEP_RAD) * tangent.transpose();
        }
        found
    }

    /// What the field can be over a part of the box, an interval a coordinate of the unit cube. From
    /// the coefficients of a compiled form; of others from their slopes at places and axes, `BETWEEN_SAMPLES` times
    /// as large.
    pub fn bounds_over(&self, intervals: [[f64; 2]; 3]) -> FieldBounds {
        if let Some(field) = self.compiled() {
            return field.bounds_over(intervals);
        }
        let is_large = intervals.iter().any(|[low, high]| high - low > 0.5);
        let steps = if is_large { 5 } else { 2 };
        let at = |k: usize, i: usize| {
            let [low, high] = intervals[k].map(|t| t.clamp(0.0, 1.0));
            low + (high - low) * i as f64 / (steps - 1) as f64
        };
        let mut found = FieldBounds::NOTHING;
        for x in 0..steps {
            for y in 0..steps {
                for z in 0..steps {
                    let unit = Vector3::new(at(0, x), at(1, y), at(2, z));
                    let place = self.bounds.min_mm + self.bounds.size_mm().component_mul(&unit);
                    for axis in DirectionSet::TwentySix.directions() {
                        let there = self.by_differences(&place, axis);
                        found.see(&there.at.error, &there.by_position, &there.by_axis);
                    }
                }
            }
        }
        found.widened(BETWEEN_SAMPLES)
    }
}

/// Steps of central differences: readings are exact to 1e-10 mm, and change over millimetres and
/// degrees.
const STEP_MM: f64 = 0.1;
const STEP_RAD: f64 = 1e-3;

/// How much more a slope may be between the samples than at them.
const BETWEEN_SAMPLES: f64 = 2.0;

/// The mean of what the tracker reads with some axes, at each place. All are read at once, so that the
/// vectors of the machine are filled.
fn mean_readings(
    source: &dyn PoseErrors,
    places_mm: &[Point3<f64>],
    axes: &[Unit<Vector3<f64>>],
    out: &mut [Option<Coefficient>],
) {
    let each = axes.len();
    let repeated = places_mm.iter().flat_map(|place| std::iter::repeat_n(*place, each));
    let repeated: Vec<Point3<f64>> = repeated.collect();
    let turned: Vec<_> = places_mm.iter().flat_map(|_| axes.iter().copied()).collect();
    let mut read = vec![None; repeated.len()];
    source.axis_errors(&repeated, &turned, &mut read);
    for (out, read) in out.iter_mut().zip(read.chunks_exact(each)) {
        *out = mean(read);
    }
}

/// Nothing where one of the values is missing.
fn mean(values: &[Option<Coefficient>]) -> Option<Coefficient> {
    let mut sum = [0.0; 6];
    for value in values {
        for (sum, v) in sum.iter_mut().zip((*value)?) {
            *sum += v / values.len() as f64;
        }
    }
    Some(sum)
}

impl PartialEq for ComputedField {
    fn eq(&self, other: &Self) -> bool {
        self.source == other.source && self.bounds == other.bounds
    }
}

/// What kind of model a room has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ModelKind {
    /// Bernstein polynomials per basis orientation.
    #[default]
    Bernstein,
    /// The mean of a Gaussian process.
    Kriging,
    /// The fields of a generator's coils, disturbed by harmonic functions.
    Harmonic,
    /// The fields of a generator's coils among metal, simulated.
    Simulated,
}

impl ModelKind {
    /// As it is written in commands and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bernstein => "bernstein",
            Self::Kriging => "kriging",
            Self::Harmonic => "harmonic",
            Self::Simulated => "simulated",
        }
    }
}
