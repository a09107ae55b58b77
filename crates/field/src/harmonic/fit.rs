//! Fits the harmonics of a room whose generator is known.
//!
//! Linear least squares on rows in mm, columns scaled to unit norm, with a ridge. A measurement
//! whose rows contradict the others by more than the noise is down-weighted: Huber's loss of the
//! length of its residual, by iteratively reweighted least squares, the scale from the median
//! length (Huber, *Robust Statistics*, 1981).

use super::model::{HarmonicModel, HarmonicModelError, HarmonicResiduals};
use super::normal::{Scaling, Solved, System};
use super::rows::{Harmonics, Maps, SolveError};
use super::solid_harmonics::{MAX_DEGREE, terms};
use crate::generator::reading::ReadingError;
use crate::generator::{Generator, GeneratorError};
use crate::samples::{Measurement, MeasurementContent, MeasurementSet};
use faer::Mat;
use nalgebra::Point3;
use trackwright_geometry::pose::is_finite;
use trackwright_task::{Cancelled, Task};

/// Damping of the scaled columns relative to their largest singular value, of the worked cases.
pub const DEFAULT_RIDGE: f64 = 1e-6;

/// Reweighting ends where no weight moves by more than this.
const SETTLED: f64 = 1e-3;

/// Most times that measurements are weighted anew: with 2 % of outliers 6 to 9 are needed.
const MAX_REWEIGHTINGS: usize = 20;

/// What a degree cannot follow is larger near metal than elsewhere, so that residuals have longer
/// tails than noise.
const HUBER_FACTOR: f64 = 2.0;

/// How the residual of a measurement counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Loss {
    /// Quadratic up to the 90 % quantile of the length of normal noise, linear beyond.
    #[default]
    Huber,
    /// Plain least squares.
    Squares,
}

/// What to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HarmonicFitSettings {
    pub degree: usize,
    pub ridge: f64,
    pub loss: Loss,
}

impl HarmonicFitSettings {
    /// A degree with the default ridge and loss.
    pub fn new(degree: usize) -> Self {
        Self { degree, ridge: DEFAULT_RIDGE, loss: Loss::default() }
    }
}

/// A fitted room, and its fit quality.
#[derive(Clone, Debug)]
pub struct HarmonicFit {
    pub model: HarmonicModel,
    pub settings: HarmonicFitSettings,
    /// Measurements used.
    pub measurements: usize,
    /// Rows: 5 a measurement, 6 of a sensor with three axes.
    pub rows: usize,
    /// What the rows determine of the coefficients, between 0 and their number.
    pub effective_parameters: f64,
    /// Standard deviation of a row: of its weighted residuals, over what the rows are more than the
    /// effective parameters. Misfit of the degree is in it. `None` where they are not more.
    pub noise_mm: Option<f64>,
    /// Weight of each measurement used, in their order.
    pub weights: Vec<f64>,
}

impl HarmonicFitError {
    pub(super) fn of(error: SolveError, rows: usize, unknowns: usize, ridge: f64) -> Self {
        match error {
            SolveError::Cancelled => Self::Cancelled(Cancelled),
            SolveError::Reading { measurement, cause } => Self::Reading { measurement, cause },
            SolveError::NotDetermined => Self::NotDetermined { rows, unknowns, ridge },
        }
    }
}

impl HarmonicFit {
    /// Measurements that count for less than the others.
    pub fn down_weighted(&self) -> usize {
        self.weights.iter().filter(|w| **w < 1.0).count()
    }
}

/// Why measurements cannot be fitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HarmonicFitError {
    #[error("no measurements to fit")]
    NoMeasurements,
    #[error(
        "the measurements have no orientations; the fields that a sensor measures depend on its axis"
    )]
    PositionOnly,
    #[error("measurement {0} (counted from 0) has a number that is not finite")]
    NotFinite(usize),
    #[error("measurement {measurement} (counted from 0): {cause}")]
    Reading { measurement: usize, cause: ReadingError },
    #[error("degree is {0}, expected 1 to {1}")]
    Degree(usize, usize),
    #[error("ridge is {0}, expected a finite number of zero or more")]
    Ridge(f64),
    #[error("{rows} rows do not determine {unknowns} coefficients with a ridge of {ridge}")]
    NotDetermined { rows: usize, unknowns: usize, ridge: f64 },
    #[error(transparent)]
    Generator(#[from] GeneratorError),
    #[error(transparent)]
    Model(#[from] HarmonicModelError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Measurements prepared for fits of several degrees, to all of them or to some.
pub struct HarmonicRows {
    generator: Generator,
    content: MeasurementContent,
    harmonics: Harmonics,
    maps: Maps,
    max_degree: usize,
}

impl HarmonicRows {
    /// Prepares rows of degrees up to `max_degree`; the ball is that of all measurements.
    pub fn new(
        task: &Task,
        generator: &Generator,
        set: &MeasurementSet,
        max_degree: usize,
    ) -> Result<Self, HarmonicFitError> {
        if let Some(problem) = generator.problem() {
            return Err(problem.into());
        }
        if !(1..=MAX_DEGREE).contains(&max_degree) {
            return Err(HarmonicFitError::Degree(max_degree, MAX_DEGREE));
        }
        check(set)?;
        let (measurements, content) = (&set.measurements, set.content);
        let maps = Maps::new(task, generator, measurements, content)
            .map_err(|error| HarmonicFitError::of(error, measurements.len(), 0, 0.0))?;
        Ok(Self {
            generator: generator.clone(),
            content,
            harmonics: Harmonics::new(measurements, content, max_degree),
            maps,
            max_degree,
        })
    }

    /// Number of measurements prepared.
    pub fn measurements(&self) -> usize {
        self.harmonics.measurements()
    }

    /// Middle of the measurements' box, tracker frame.
    pub fn center_mm(&self) -> &Point3<f64> {
        &self.harmonics.center_mm
    }

    /// Half the diagonal of the measurements' box.
    pub fn scale_mm(&self) -> f64 {
        self.harmonics.scale_mm
    }

    /// Fits all measurements, or those whose indices are `used`, in their order.
    ///
    /// # Errors
    /// See [`HarmonicFitError`].
    ///
    /// # Panics
    /// If an index is not one of a measurement.
    pub fn fit(
        &self,
        task: &Task,
        used: Option<&[usize]>,
        settings: &HarmonicFitSettings,
    ) -> Result<HarmonicFit, HarmonicFitError> {
        let (degree, ridge) = (settings.degree, settings.ridge);
        if !(1..=self.max_degree).contains(&degree) {
            return Err(HarmonicFitError::Degree(degree, self.max_degree));
        }
        if !(ridge.is_finite() && ridge >= 0.0) {
            return Err(HarmonicFitError::Ridge(ridge));
        }
        let used = used.map_or_else(|| (0..self.measurements()).collect(), <[usize]>::to_vec);
        if used.is_empty() {
            return Err(HarmonicFitError::NoMeasurements);
        }
        let system = System::new(&self.harmonics, &self.maps, terms(degree), used);
        let rows = system.used().len() * system.dof();
        let weighted = Weighted::solve(task, &system, settings)
            .map_err(|error| HarmonicFitError::of(error, rows, system.unknowns(), ridge))?;
        let model = HarmonicModel::new(
            self.generator.clone(),
            self.harmonics.center_mm,
            self.harmonics.scale_mm,
            degree,
            weighted.solved.coefficients,
        )?;
        let effective_parameters =
            effective_parameters(&weighted.solved.factor, weighted.scaling.damping);
        let squares: f64 = weighted
            .residuals
            .chunks_exact(system.dof())
            .zip(&weighted.weights)
            .map(|(r, w)| w * square(r))
            .sum();
        let free = rows as f64 - effective_parameters;
        Ok(HarmonicFit {
            model,
            settings: *settings,
            measurements: system.used().len(),
            rows,
            effective_parameters,
            noise_mm: (free > 0.5).then(|| (squares / free).sqrt()),
            weights: weighted.weights,
        })
    }

    /// Residuals of some of the measurements, which are `set`'s in its order.
    pub fn residuals(
        &self,
        model: &HarmonicModel,
        set: &[Measurement],
        held_out: &[usize],
    ) -> HarmonicResiduals {
        model.residuals(held_out.iter().map(|&k| &set[k]), self.content)
    }
}

/// Fits all measurements of a table; see [`HarmonicRows`] for several degrees or folds.
pub fn fit(
    task: &Task,
    generator: &Generator,
    set: &MeasurementSet,
    settings: &HarmonicFitSettings,
) -> Result<HarmonicFit, HarmonicFitError> {
    HarmonicRows::new(task, generator, set, settings.degree)?.fit(task, None, settings)
}

/// The first reason why a table cannot be fitted by any generator.
pub fn check(set: &MeasurementSet) -> Result<(), HarmonicFitError> {
    if set.content == MeasurementContent::PositionOnly {
        return Err(HarmonicFitError::PositionOnly);
    }
    if set.measurements.is_empty() {
        return Err(HarmonicFitError::NoMeasurements);
    }
    let is_wrong = |m: &Measurement| {
        !(is_finite(&m.tracker_from_ideal) && is_finite(&m.tracker_from_measured))
    };
    match set.measurements.iter().position(is_wrong) {
        Some(index) => Err(HarmonicFitError::NotFinite(index)),
        None => Ok(()),
    }
}

/// A solution with the weights that its own residuals give.
struct Weighted {
    solved: Solved,
    scaling: Scaling,
    residuals: Vec<f64>,
    weights: Vec<f64>,
}

impl Weighted {
    fn solve(
        task: &Task,
        system: &System<'_>,
        settings: &HarmonicFitSettings,
    ) -> Result<Self, SolveError> {
        let mut weights = vec![1.0; system.used().len()];
        let unweighted = system.gram(&task.subtask(0.0, 0.5), &weights)?;
        let scaling = Scaling::new(&unweighted, settings.ridge)?;
        let mut solved = system.solve(&unweighted, &weights, &scaling)?;
        let mut residuals = system.residuals(&solved.coefficients);
        if settings.loss == Loss::Huber {
            for round in 0..MAX_REWEIGHTINGS {
                task.step(MAX_REWEIGHTINGS + round, 2 * MAX_REWEIGHTINGS)?;
                let next = huber_weights(&residuals, system.dof());
                let moved = next.iter().zip(&weights).map(|(a, b)| (a - b).abs());
                let moved = moved.fold(0.0, f64::max);
                weights = next;
                if moved <= SETTLED {
                    break;
                }
                let gram = reweighted(task, system, &unweighted, &weights)?;
                solved = system.solve(&gram, &weights, &scaling)?;
                residuals = system.residuals(&solved.coefficients);
            }
        }
        task.step(1, 1)?;
        Ok(Self { solved, scaling, residuals, weights })
    }
}

/// The normal matrix with weights: most of them are 1, so that only the others' part is removed.
fn reweighted(
    task: &Task,
    system: &System<'_>,
    unweighted: &Mat<f64>,
    weights: &[f64],
) -> Result<Mat<f64>, Cancelled> {
    let quiet = Task::cancelled_by(task.cancel.clone());
    let less: Vec<_> = weights.iter().map(|w| w - 1.0).collect();
    Ok(unweighted + system.gram_of_some(&quiet, &less)?)
}

/// Huber's weights of measurements from the lengths of their residuals; all 1 without any spread.
pub fn huber_weights(residuals: &[f64], dof: usize) -> Vec<f64> {
    let lengths = lengths(residuals, dof);
    let limit = huber_limit(dof) * noise_of_lengths(&mut lengths.clone(), dof);
    let weight = |length: f64| if length <= limit { 1.0 } else { limit / length };
    if limit > 0.0 { lengths.into_iter().map(weight).collect() } else { vec![1.0; lengths.len()] }
}

/// Where Huber's loss becomes linear: [`HUBER_FACTOR`] times the 90 % quantile of the length of 5 or
/// 6 standard normal components (χ² tables).
fn huber_limit(dof: usize) -> f64 {
    HUBER_FACTOR * if dof == 6 { 3.263 } else { 3.039 }
}

/// Standard deviation of a component from the median length: over that of 5 or 6 standard normal
/// components. Reorders the lengths.
fn noise_of_lengths(lengths: &mut [f64], dof: usize) -> f64 {
    let median_length = if dof == 6 { 2.312_6 } else { 2.086_0 };
    let middle = lengths.len() / 2;
    if lengths.is_empty() {
        return 0.0;
    }
    let (_, median, _) = lengths.select_nth_unstable_by(middle, f64::total_cmp);
    *median / median_length
}

fn lengths(residuals: &[f64], dof: usize) -> Vec<f64> {
    residuals.chunks_exact(dof).map(|r| square(r).sqrt()).collect()
}

fn square(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum()
}

/// `tr((N + μ)⁻¹ N) = unknowns − μ ‖L⁻¹‖²`.
fn effective_parameters(factor: &Mat<f64>, damping: f64) -> f64 {
    let unknowns = factor.nrows();
    let mut inverse = Mat::<f64>::identity(unknowns, unknowns);
    factor.solve_lower_triangular_in_place(inverse.as_mut());
    (unknowns as f64 - damping * inverse.squared_norm_l2()).max(0.0)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::generator::tests::{physics, point, vector};
    use crate::samples::Measurement;
    use nalgebra::{Quaternion, UnitQuaternion, Vector3};
    use trackwright_geometry::pose::pose_from_parts;

    /// One of the room's tables, "fit" or "holdout".
    pub(crate) fn room_a(kind: &str) -> MeasurementSet {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/room-a");
        let path = format!("{folder}/room-a-{kind}.csv");
        let mut table = csv::Reader::from_path(path).unwrap();
        let measurements = table.deserialize().map(|row| {
            let row: [f64; 14] = row.unwrap();
            let pose = |k: usize| {
                let [x, y, z, qw, qx, qy, qz]: [f64; 7] = row[k..k + 7].try_into().unwrap();
                let rotation = UnitQuaternion::from_quaternion(Quaternion::new(qw, qx, qy, qz));
                pose_from_parts(Vector3::new(x, y, z), rotation)
            };
            Measurement { tracker_from_ideal: pose(0), tracker_from_measured: pose(7) }
        });
        MeasurementSet {
            content: MeasurementContent::FiveDof,
            measurements: measurements.collect(),
        }
    }

    fn squares(degree: usize) -> HarmonicFitSettings {
        HarmonicFitSettings { loss: Loss::Squares, ..HarmonicFitSettings::new(degree) }
    }

    fn nine() -> Generator {
        Generator::planar_nine()
    }

    #[test]
    fn the_fit_is_the_worked_one() {
        let golden = physics();
        let worked = &golden["fit"];
        let degree = golden["degree"].as_u64().unwrap() as usize;
        let settings =
            HarmonicFitSettings { ridge: worked["ridge"].as_f64().unwrap(), ..squares(degree) };
        let fitted = fit(&Task::default(), &nine(), &room_a("fit"), &settings).unwrap();
        let model = &fitted.model;
        assert!((model.center_mm() - point(&golden["centre_mm"])).norm() < 1e-9);
        let scale_mm = golden["scale_mm"].as_f64().unwrap();
        assert!((model.scale_mm() - scale_mm).abs() < 1e-9);
        let holdout = room_a("holdout");
        for row in worked["predicted"].as_array().unwrap() {
            let m = &holdout.measurements[row["row"].as_u64().unwrap() as usize];
            let pose = &m.tracker_from_ideal;
            let axis = pose.rotation * Vector3::z_axis();
            let reading = model.read_axis(&pose.translation.vector.into(), &axis).unwrap();
            assert!((reading.position_mm - point(&row["position_mm"])).norm() < 1e-6);
            assert!((reading.axis.as_ref() - vector(&row["axis"])).norm() < 1e-8);
        }
        let found = model.residuals(&holdout.measurements, holdout.content);
        assert_eq!(found.without_reading, 0);
        let rms_mm = found.residuals.position_rms_mm;
        let worked_mm = worked["holdout_rms_mm"].as_f64().unwrap();
        assert!((rms_mm / worked_mm - 1.0).abs() < 1e-9, "{rms_mm}");
        let none = model.with_coefficients(vec![0.0; model.coefficients().len()]).unwrap();
        let raw = none.residuals(&holdout.measurements, holdout.content);
        let worked_mm = worked["raw_rms_mm"].as_f64().unwrap();
        assert!((raw.residuals.position_rms_mm / worked_mm - 1.0).abs() < 1e-9);
    }

    /// Measurements that a model itself makes of the room's true poses.
    fn measured_by(model: &HarmonicModel, set: &MeasurementSet) -> MeasurementSet {
        let measurements = set.measurements.iter().map(|m| {
            let ideal = m.tracker_from_ideal;
            let measured = if set.content == MeasurementContent::SixDof {
                model.read_pose(&ideal).unwrap().tracker_from_sensor
            } else {
                let axis = ideal.rotation * Vector3::z_axis();
                let position = ideal.translation.vector.into();
                let reading = model.read_axis(&position, &axis).unwrap();
                let turn = trackwright_geometry::rotation::axis_rotation(&axis, &reading.axis);
                pose_from_parts(
                    reading.position_mm.coords,
                    trackwright_geometry::rotation::exp_vector(&turn.vector_rad) * ideal.rotation,
                )
            };
            Measurement { tracker_from_ideal: ideal, tracker_from_measured: measured }
        });
        MeasurementSet { measurements: measurements.collect(), content: set.content }
    }

    #[test]
    fn a_room_of_the_models_own_kind_is_found_again() {
        let task = Task::default();
        for content in [MeasurementContent::FiveDof, MeasurementContent::SixDof] {
            let mut set = room_a("fit");
            let room = fit(&task, &nine(), &set, &squares(3)).unwrap().model;
            set.content = content;
            set.measurements.truncate(400);
            let made = measured_by(&room, &set);
            let fitted = fit(&task, &nine(), &made, &squares(3)).unwrap().model;
            let before = room.residuals(&set.measurements, content);
            let after = fitted.residuals(&made.measurements, content);
            // What no pose explains of the signals is of second order: the square of the error over
            // the distance, and the part of the disturbance that the pose hides.
            let (before, after) =
                (before.residuals.position_rms_mm, after.residuals.position_rms_mm);
            assert!(after < 0.1 * before, "{after} of {before}");
        }
    }

    #[test]
    fn outliers_do_not_move_the_fit() {
        let task = Task::default();
        let mut set = room_a("fit");
        let holdout = room_a("holdout");
        let error_mm = |set: &MeasurementSet, loss| {
            let settings = HarmonicFitSettings { loss, ..squares(4) };
            let fitted = fit(&task, &nine(), set, &settings).unwrap();
            let found = fitted.model.residuals(&holdout.measurements, holdout.content);
            (found.residuals.position_rms_mm, fitted)
        };
        let (clean_mm, _) = error_mm(&set, Loss::Huber);
        for k in (0..set.measurements.len()).step_by(100) {
            let moved = Vector3::new(20.0, -35.0, 15.0);
            set.measurements[k].tracker_from_measured.translation.vector += moved;
        }
        let (squares_mm, _) = error_mm(&set, Loss::Squares);
        let (huber_mm, huber) = error_mm(&set, Loss::Huber);
        assert!(huber_mm < 1.2 * clean_mm, "{huber_mm} {clean_mm}");
        assert!(squares_mm > 2.0 * huber_mm, "{squares_mm} {huber_mm}");
        for k in (0..set.measurements.len()).step_by(100) {
            assert!(huber.weights[k] < 0.05);
        }
        assert!(huber.down_weighted() > 10);
    }

    #[test]
    fn fits_to_some_are_fits_of_those_alone() {
        let task = Task::default();
        let set = room_a("fit");
        let rows = HarmonicRows::new(&task, &nine(), &set, 5).unwrap();
        let used: Vec<_> = (0..set.measurements.len()).filter(|k| k % 3 != 0).collect();
        let held_out: Vec<_> = (0..set.measurements.len()).step_by(3).collect();
        let some = rows.fit(&task, Some(&used), &squares(3)).unwrap();
        assert_eq!(some.measurements, used.len());
        let found = rows.residuals(&some.model, &set.measurements, &held_out);
        assert!(found.residuals.position_rms_mm < 0.6);
        // The ball is that of all; all together is a plain fit.
        let all = rows.fit(&task, None, &squares(3)).unwrap();
        let plain = fit(&task, &nine(), &set, &squares(3)).unwrap();
        assert_eq!(all.model, plain.model);
    }

    #[test]
    fn results_do_not_depend_on_threads() {
        let set = room_a("fit");
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            let settings = HarmonicFitSettings::new(4);
            pool.install(|| fit(&Task::default(), &nine(), &set, &settings).unwrap().model)
        };
        assert_eq!(with(1), with(3));
    }

    #[test]
    fn tables_that_cannot_be_fitted_are_refused() {
        let task = Task::default();
        let set = room_a("fit");
        let error = |change: &dyn Fn(&mut MeasurementSet), settings: &HarmonicFitSettings| {
            let mut set = set.clone();
            set.measurements.truncate(60);
            change(&mut set);
            fit(&task, &nine(), &set, settings).unwrap_err()
        };
        let two = squares(2);
        let no_change = |_: &mut MeasurementSet| ();
        assert_eq!(
            error(&|s| s.content = MeasurementContent::PositionOnly, &two),
            HarmonicFitError::PositionOnly
        );
        assert_eq!(error(&|s| s.measurements.clear(), &two), HarmonicFitError::NoMeasurements);
        let broken = |s: &mut MeasurementSet| {
            s.measurements[7].tracker_from_measured.translation.vector.x = f64::NAN;
        };
        assert_eq!(error(&broken, &two), HarmonicFitError::NotFinite(7));
        let on_a_coil = |s: &mut MeasurementSet| {
            s.measurements[5].tracker_from_measured.translation.vector = Vector3::zeros();
        };
        assert_eq!(
            error(&on_a_coil, &two),
            HarmonicFitError::Reading { measurement: 5, cause: ReadingError::NotFinite }
        );
        assert_eq!(error(&no_change, &squares(0)), HarmonicFitError::Degree(0, 10));
        assert_eq!(error(&no_change, &squares(11)), HarmonicFitError::Degree(11, 10));
        let negative = HarmonicFitSettings { ridge: -1.0, ..two };
        assert_eq!(error(&no_change, &negative), HarmonicFitError::Ridge(-1.0));
        let none = HarmonicFitSettings { ridge: 0.0, ..squares(6) };
        assert_eq!(
            error(&no_change, &none),
            HarmonicFitError::NotDetermined { rows: 300, unknowns: 432, ridge: 0.0 }
        );
        let cancelled = Task::default();
        cancelled.cancel.cancel();
        assert_eq!(
            fit(&cancelled, &nine(), &set, &two).unwrap_err(),
            HarmonicFitError::Cancelled(Cancelled)
        );
    }

    #[test]
    fn rows_at_one_place_are_held_by_the_ridge() {
        let mut set = room_a("fit");
        let place = set.measurements[0];
        set.measurements = vec![place; 30];
        let fitted = fit(&Task::default(), &nine(), &set, &squares(4)).unwrap();
        let found = fitted.model.residuals(&set.measurements, set.content);
        let raw_mm = (place.tracker_from_measured.translation.vector
            - place.tracker_from_ideal.translation.vector)
            .norm();
        assert!(found.residuals.position_rms_mm < 0.1 * raw_mm);
        assert!(fitted.effective_parameters < 5.1);
    }
}
