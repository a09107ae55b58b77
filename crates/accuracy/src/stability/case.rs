//! What the cases of the battery are made of: the computations under test, inputs, quantities with
//! bounds, rows.

use nalgebra::{Complex, Matrix3, Point3, Unit, UnitQuaternion, Vector3};
use serde::Serialize;
use trackwright_field::batch::{Batch, Instructions};
use trackwright_field::bernstein::coefficient_count;
use trackwright_field::evaluation::Matrix6x3;
use trackwright_field::fit::{Fit, FitError, FitSettings, fit};
use trackwright_field::inverse::{InverseState, undistort};
use trackwright_field::least_squares::{LeastSquares, NoConvergence, Solution};
use trackwright_field::samples::{MapKind, PoseError, SampleSet};
use trackwright_field::{DistortionModel, OutsidePolicy};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::directions::{DirectionSet, DirectionWeights, Weighting};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::{
    AxisRotation, axis_rotation, exp_vector, log_matrix, log_quaternion, rotation_angle_rad,
};
use trackwright_geometry::svd3::{Svd3, svd3};
use trackwright_metal::material::Material;
use trackwright_metal::sphere::{SphereError, sphere_factor};
use trackwright_simulation::frame_fit::{FrameFit, FrameFitter, Reading};
use trackwright_simulation::linear_fit::{
    RotationNotDetermined, SensorCovariance, point_covariance_mm2,
};
use trackwright_simulation::tool_in_crf::{RelativeError, relative_error};
use trackwright_simulation::{RigidBody, Sensor, Statistics};
use trackwright_task::Task;

/// How much of the battery runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// All of it: minutes.
    Full,
    /// Every family with its smaller cases: seconds, even without optimisation.
    Reduced,
}

impl Extent {
    /// One of two.
    pub fn of<T>(self, full: T, reduced: T) -> T {
        match self {
            Self::Full => full,
            Self::Reduced => reduced,
        }
    }
}

type Axis = Unit<Vector3<f64>>;

/// The computations under test: the program's own are [`Methods::OWN`], and a test exchanges one of
/// them for a naive one that has to be found out.
#[derive(Clone, Copy)]
#[expect(clippy::type_complexity, reason = "the signatures of the methods under test")]
pub struct Methods {
    pub evaluate: fn(&DistortionModel, &Point3<f64>, &Axis, OutsidePolicy) -> PoseError,
    /// The same at many poses at once, by each set of instructions.
    pub evaluate_together:
        fn(&DistortionModel, &[Point3<f64>], &[Axis], OutsidePolicy) -> Vec<Vec<PoseError>>,
    /// The same for one axis: at one position, in a batch, and on a lattice of one point.
    pub evaluate_along: fn(&DistortionModel, &Point3<f64>, &Axis, OutsidePolicy) -> Vec<PoseError>,
    /// Derivatives by position, a mm, and by steps of the axis in its tangent plane, a rad.
    pub derivatives: fn(&DistortionModel, &Point3<f64>, &Axis, OutsidePolicy) -> [Matrix6x3; 2],
    /// The poses behind readings, and what became of each.
    pub undistort:
        fn(&DistortionModel, &[Pose], OutsidePolicy) -> Vec<(Option<Pose>, InverseState)>,
    pub weights: fn(DirectionSet, &Axis, Weighting) -> DirectionWeights,
    /// Least squares of least norm: rows of the design matrix, six values a row, cutoff, ridge.
    pub solve: fn(&[Vec<f64>], &[[f64; 6]], f64, f64) -> Result<Solution, NoConvergence>,
    pub fit: fn(&SampleSet, &FitSettings, Option<Bounds>) -> Result<Fit, FitError>,
    pub exp: fn(&Vector3<f64>) -> UnitQuaternion<f64>,
    pub log_quaternion: fn(&UnitQuaternion<f64>) -> Vector3<f64>,
    pub log_matrix: fn(&Matrix3<f64>) -> Vector3<f64>,
    pub angle: fn(&UnitQuaternion<f64>) -> f64,
    pub axis_rotation: fn(&Axis, &Axis) -> AxisRotation,
    pub svd3: fn(&Matrix3<f64>) -> Svd3,
    /// A body, the weight of its axes in mm, readings, and its true pose.
    pub frame: fn(&RigidBody, f64, &[Reading], &Pose) -> FrameFit,
    /// The tool in the CRF, true and simulated, and its tip.
    pub relative_error: fn(&Pose, &Pose, &Point3<f64>) -> RelativeError,
    /// Of a point of a body, whose axes weigh so many mm.
    pub covariance: fn(
        &RigidBody,
        f64,
        &[SensorCovariance],
        &Point3<f64>,
    ) -> Result<Matrix3<f64>, RotationNotDetermined>,
    pub statistics: fn(&mut [f64]) -> Option<Statistics>,
    /// Induced dipole of a sphere of a radius in mm, at a frequency in Hz.
    pub sphere_factor: fn(f64, &Material, f64) -> Result<Complex<f64>, SphereError>,
}

impl Methods {
    /// The program's own.
    pub const OWN: Self = Self {
        evaluate: |model, position_mm, axis, outside| {
            model.evaluate(position_mm, axis, outside).error
        },
        evaluate_together: |model, positions_mm, axes, outside| {
            let by = |level| {
                let mut out = Vec::new();
                let mut batch = Batch::with_instructions(level);
                batch.evaluate(model, positions_mm, axes, outside, &mut out);
                out.iter().map(|e| e.error).collect()
            };
            [Instructions::Best, Instructions::Avx2, Instructions::Portable].map(by).to_vec()
        },
        evaluate_along: |model, position_mm, axis, outside| {
            let along = model.at_axis(axis);
            let mut together = Vec::new();
            along.evaluate_all(&mut Batch::default(), &[*position_mm], outside, &mut together);
            let mut lattice = Vec::new();
            let [x, y, z] = position_mm.coords.into();
            along.evaluate_lattice([&[x], &[y], &[z]], outside, &mut lattice);
            let single = along.evaluate(position_mm, outside);
            [vec![single], together, lattice].concat().iter().map(|e| e.error).collect()
        },
        derivatives: |model, position_mm, axis, outside| {
            let there = model.evaluate_with_jacobian(position_mm, axis, outside);
            [there.by_position, there.by_axis]
        },
        undistort: |model, measured, outside| {
            // Nobody cancels a task of its own.
            let all = undistort(model, measured, outside, &Task::default()).unwrap_or_default();
            all.into_iter().map(|u| (u.pose, u.state)).collect()
        },
        weights: |set, axis, weighting| set.weights(axis, weighting),
        solve: |rows, values, rcond, ridge| {
            let mut system = LeastSquares::new(rows.first().map_or(0, Vec::len));
            for (row, values) in rows.iter().zip(values) {
                system.push(|out| out.extend(row), *values);
            }
            system.solve(rcond, ridge)
        },
        fit,
        exp: exp_vector,
        log_quaternion,
        log_matrix,
        angle: rotation_angle_rad,
        axis_rotation,
        svd3,
        frame: |body, weight_mm, readings, truth| {
            FrameFitter::new(body, weight_mm).fit(readings, truth)
        },
        relative_error,
        covariance: point_covariance_mm2,
        statistics: |values| Statistics::of(values),
        sphere_factor,
    };
}

/// A linear congruential sequence (Knuth's multiplier): no randomness is needed, only numbers
/// that no formula is fond of.
#[derive(Clone, Debug)]
pub struct Sequence(u64);

impl Sequence {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Self {
        let mut sequence = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        sequence.unit();
        sequence
    }

    /// In `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In `[-1, 1)`.
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Components in `[-1, 1)`.
    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.signed())
    }

    /// A direction.
    pub fn axis(&mut self) -> Unit<Vector3<f64>> {
        loop {
            let v = self.vector();
            if (0.1..1.0).contains(&v.norm()) {
                return Unit::new_normalize(v);
            }
        }
    }

    /// A rotation by up to 3 rad.
    pub fn rotation(&mut self) -> UnitQuaternion<f64> {
        let axis = self.axis();
        UnitQuaternion::from_axis_angle(&axis, 3.0 * self.signed())
    }

    /// A point in a box.
    pub fn point_in(&mut self, bounds: &Bounds) -> Point3<f64> {
        let size = bounds.size_mm();
        bounds.min_mm + Vector3::from_fn(|k, _| size[k] * self.unit())
    }
}

/// A body of these sensors whose tip is its origin.
pub fn body_of(sensors: impl IntoIterator<Item = Sensor>) -> RigidBody {
    let sensors = sensors.into_iter().collect();
    RigidBody { name: "body".to_owned(), tip_in_body: None, sensors }
}

/// A cube with one corner somewhere.
pub fn cube(corner: [f64; 3], edge_mm: f64) -> Bounds {
    Bounds::from((corner, corner.map(|c| c + edge_mm)))
}

/// A model, or what is claimed of it.
pub type Made = Result<DistortionModel, &'static str>;

/// A model whose coefficients change sign without pattern, to 1 mm and 0.01 rad.
///
/// # Errors
/// The claim that it is one, where [`DistortionModel::new`] refuses it.
pub fn model(
    order: usize,
    directions: DirectionSet,
    weighting: Weighting,
    bounds: Bounds,
    seed: u64,
) -> Made {
    let mut sequence = Sequence::new(seed);
    let coefficients = (0..directions.len() * coefficient_count(order))
        .map(|_| std::array::from_fn(|k| sequence.signed() * if k < 3 { 1.0 } else { 0.01 }))
        .collect();
    let map = MapKind::Distortion;
    DistortionModel::new(order, directions, weighting, map, bounds, coefficients)
        .map_err(|_| "is a model")
}

/// What is measured, and what its bound is made of: `constant · condition · epsilon · scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    pub name: &'static str,
    /// At most 100. Of the order of the number of roundings that a value passes through.
    pub constant: f64,
    /// What the condition number is of.
    pub condition: &'static str,
    /// What the error is relative to.
    pub scale: &'static str,
}

/// One error and its bound. `error` and `bound` are in the quantity's unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    #[serde(skip)]
    pub family: &'static str,
    /// What a row adds to the case's name, until `Case::rows` puts that before it.
    pub case: String,
    pub quantity: &'static str,
    pub condition: f64,
    pub error: f64,
    pub bound: f64,
    pub holds: bool,
}

impl Quantity {
    /// A quantity by its name, constant, and what condition and scale are of.
    pub const fn new(
        name: &'static str,
        constant: f64,
        condition: &'static str,
        scale: &'static str,
    ) -> Self {
        Self { name, constant, condition, scale }
    }

    /// A row.
    pub fn row(&self, condition: f64, error: f64, scale: f64) -> Row {
        let bound = self.constant * condition * f64::EPSILON * scale;
        Row { condition, ..Row::within(self.name, error, bound) }
    }

    /// Of several errors with their scales, the one that comes nearest to its bound.
    pub fn worst(&self, condition: f64, errors: &[(f64, f64)]) -> Row {
        let rows = errors.iter().map(|&(error, scale)| self.row(condition, error, scale));
        rows.reduce(Row::worse).unwrap_or_else(|| self.row(condition, f64::NAN, 0.0))
    }
}

impl Row {
    /// What must happen in a case, and whether it did.
    pub fn behaviour(case: &str, must: &'static str, did: bool) -> Self {
        let error = if did { 0.0 } else { 1.0 };
        Self { case: case.to_owned(), ..Self::within(must, error, 0.0) }
    }

    /// A method's own error beside a bound that is stated with it, in the place of round-off's. An
    /// error that is not a number does not hold.
    pub fn within(quantity: &'static str, error: f64, bound: f64) -> Self {
        let holds = error <= bound && bound.is_finite();
        Self { family: "", case: String::new(), quantity, condition: 1.0, error, bound, holds }
    }

    /// Of two rows, the one that comes nearer to its bound or is further beyond it.
    fn worse(self, other: Self) -> Self {
        if other.badness() > self.badness() { other } else { self }
    }

    /// Of the answers that are right, the one that is meant; the claim that there is one where
    /// there is none.
    pub fn nearest(rows: impl Iterator<Item = Self>, claim: &'static str) -> Self {
        rows.min_by(|a, b| a.badness().total_cmp(&b.badness()))
            .unwrap_or_else(|| must(claim, false))
    }

    /// Error over bound; one at the bound, infinite where nothing is allowed and something is.
    pub fn badness(&self) -> f64 {
        if self.error == 0.0 {
            0.0
        } else if self.error.is_nan() || self.bound.is_nan() {
            f64::INFINITY
        } else {
            self.error / self.bound
        }
    }
}

/// What must happen, and whether it did.
pub fn must(claim: &'static str, did: bool) -> Row {
    Row::behaviour("", claim, did)
}

/// What a case finds, any number of rows a quantity; or the claim that it fails before there is
/// anything to compare.
pub type Found = Result<Vec<Row>, &'static str>;

/// What a case computes with.
type Run = Box<dyn Fn(&Methods) -> Found + Send + Sync>;

/// One input and all that is measured on it.
pub struct Case {
    pub name: String,
    run: Run,
}

impl Case {
    /// A case of a name, and what is measured on it.
    pub fn new(
        name: impl Into<String>,
        run: impl Fn(&Methods) -> Found + Send + Sync + 'static,
    ) -> Self {
        Self { name: name.into(), run: Box::new(run) }
    }

    /// Of each quantity the row that comes nearest to its bound, in the order of their first ones.
    /// A panic is a row that does not hold.
    pub fn rows(&self, methods: &Methods) -> Vec<Row> {
        let attempt = std::panic::AssertUnwindSafe(|| (self.run)(methods));
        let found = std::panic::catch_unwind(attempt).unwrap_or(Err("does not panic"));
        let mut rows: Vec<Row> = Vec::new();
        for row in found.unwrap_or_else(|claim| vec![must(claim, false)]) {
            match rows.iter_mut().find(|known| known.quantity == row.quantity) {
                Some(known) => *known = known.clone().worse(row),
                None => rows.push(row),
            }
        }
        for row in &mut rows {
            row.case.insert_str(0, &self.name);
        }
        rows
    }
}

/// Cases that belong together.
pub struct Family {
    pub name: &'static str,
    /// What is compared with what, in a sentence or two.
    pub about: &'static str,
    pub quantities: Vec<Quantity>,
    pub cases: Vec<Case>,
}

impl Family {
    /// A family without cases.
    pub fn new(name: &'static str, about: &'static str, quantities: &[Quantity]) -> Self {
        Self { name, about, quantities: quantities.to_vec(), cases: Vec::new() }
    }

    /// Adds a case with a single claim.
    pub fn claim(
        &mut self,
        name: impl Into<String>,
        claim: &'static str,
        holds: impl Fn(&Methods) -> bool + Send + Sync + 'static,
    ) {
        self.cases.push(Case::new(name, move |m| Ok(vec![must(claim, holds(m))])));
    }

    /// With a case for each input, by its name: all that `run` measures on it.
    pub fn with<I: Send + Sync + 'static>(
        mut self,
        inputs: impl IntoIterator<Item = (impl Into<String>, I)>,
        run: impl Fn(&Methods, &I) -> Found + Copy + Send + Sync + 'static,
    ) -> Self {
        let case = |(name, input): (_, I)| Case::new(name, move |m: &Methods| run(m, &input));
        self.cases.extend(inputs.into_iter().map(case));
        self
    }
}
