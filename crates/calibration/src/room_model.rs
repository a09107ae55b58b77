//! Models of a room that are no polynomials, fitted to its measurements: kriging, and the fields of a
//! generator's coils.

use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;
use trackwright_field::DistortionModel;
use trackwright_field::computed::{FieldSource, ModelKind};
use trackwright_field::fit::{Fit, residuals};
use trackwright_field::gaussian::{GaussianError, GaussianField, Kriging};
use trackwright_field::generator::Generator;
use trackwright_field::harmonic::{
    DEFAULT_RIDGE, HarmonicFit, HarmonicFitError, HarmonicFitSettings, HarmonicModel, HarmonicRows,
    LearnError, LearnSettings, LearnedGenerator, Loss, learn, learn::degree_for, learn_again,
};
use trackwright_field::model::OutsidePolicy;
use trackwright_field::samples::{MapKind, PoseError, Sample, SampleSet};
use trackwright_geometry::bounds::Bounds;
use trackwright_task::Task;

#[derive(Clone, Debug, PartialEq)]
pub enum RoomModel {
    /// Bernstein polynomials, of the settings beside it.
    Bernstein {
        /// Whether an axis turned round has the same error, as that of a 5-DOF coil has.
        is_symmetric: bool,
    },
    Kriging,
    Harmonic(HarmonicOrder),
}

impl RoomModel {
    /// The paper's.
    pub const PAPER: Self = Self::Bernstein { is_symmetric: false };

    /// The kind of model.
    pub fn kind(&self) -> ModelKind {
        match self {
            Self::Bernstein { .. } => ModelKind::Bernstein,
            Self::Kriging => ModelKind::Kriging,
            Self::Harmonic(_) => ModelKind::Harmonic,
        }
    }
}

/// A harmonic model to fit.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicOrder {
    pub generator: GeneratorChoice,
    /// From the number of measurements where there is none.
    pub degree: Option<usize>,
    /// [`DEFAULT_RIDGE`] where there is none.
    pub ridge: Option<f64>,
    pub loss: Loss,
}

impl HarmonicOrder {
    /// What is fitted to so many measurements.
    pub fn settings(&self, measurements: usize) -> HarmonicFitSettings {
        HarmonicFitSettings {
            degree: self.degree.unwrap_or_else(|| degree_for(measurements)),
            ridge: self.ridge.unwrap_or(DEFAULT_RIDGE),
            loss: self.loss,
        }
    }
}

/// Whose fields are disturbed.
#[derive(Clone, Debug, PartialEq)]
pub enum GeneratorChoice {
    Known(Generator),
    /// Learned from the measurements themselves; what was learned of them already is not learned again.
    Learned(Option<Arc<LearnedGenerator>>),
}

impl GeneratorChoice {
    /// The generator's, or that it is learned.
    pub fn name(&self) -> &str {
        match self {
            Self::Known(generator) => &generator.name,
            Self::Learned(_) => LEARNED,
        }
    }
}

#[derive(Debug, thiserror::Error)]
pub enum RoomModelError {
    #[error("a harmonic model is a function of the true pose, expected the distortion map")]
    CorrectionMap,
    #[error(
        "the measured positions are within {across_mm:.2} mm RMS of one line, expected {LEAST_ACROSS_MM} mm at least: \
         no field beside it follows from them"
    )]
    OnALine { across_mm: f64 },
    #[error(transparent)]
    Process(#[from] GaussianError),
    #[error(transparent)]
    Harmonic(#[from] HarmonicFitError),
    #[error(transparent)]
    Learn(#[from] LearnError),
}

impl RoomModelError {
    /// Whether the work was cancelled.
    pub fn is_cancelled(&self) -> bool {
        matches!(
            self,
            Self::Process(GaussianError::Cancelled(_))
                | Self::Harmonic(HarmonicFitError::Cancelled(_))
                | Self::Learn(LearnError::Fit(HarmonicFitError::Cancelled(_)))
        )
    }
}

/// What a harmonic fit found beside the model.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicReport {
    pub generator: Generator,
    pub settings: HarmonicFitSettings,
    /// Standard deviation of a row in mm, misfit of the degree included.
    pub noise_mm: Option<f64>,
    /// Measurements that count for less than the others.
    pub down_weighted: usize,
    pub learned: Option<LearnedGenerator>,
}

const LEARNED: &str = "learned";

/// What the box of a harmonic model has at each face beyond the measurements, as a part of its size. A field
/// does not end where measurements do. In the outer half of that margin of five rooms of
/// `tests/rooms/others.rs` errors are 1.3 to 2.0 times those at the faces, and the stated 95 % bounds hold 95
/// to 100 %; at four times the margin 85 to 96 %.
const HARMONIC_MARGIN: f64 = 0.05;

/// Distance of positions from a line, RMS, that determines a field: a few times the noise of a tracker.
const LEAST_ACROSS_MM: f64 = 1.0;

/// Part of the time that learning takes, for progress only.
const LEARNING_PART: f64 = 0.9;

/// Samples of the distortion map made ready for harmonic models of several degrees.
pub struct HarmonicTable {
    pub generator: Generator,
    pub learned: Option<Arc<LearnedGenerator>>,
    rows: HarmonicRows,
}

impl HarmonicTable {
    /// # Errors
    /// Samples that no generator can read, or learn from.
    pub fn new(
        samples: &SampleSet,
        choice: &GeneratorChoice,
        max_degree: usize,
        task: &Task,
    ) -> Result<Self, RoomModelError> {
        let set = samples.measurements();
        let (generator, learned) = match choice {
            GeneratorChoice::Known(generator) => (generator.clone(), None),
            GeneratorChoice::Learned(Some(learned)) => {
                (learned.generator.clone(), Some(learned.clone()))
            }
            GeneratorChoice::Learned(None) => {
                let task = task.subtask(0.0, LEARNING_PART);
                let learned = learn(&task, LEARNED, &set, &LearnSettings::default())?;
                (learned.generator.clone(), Some(Arc::new(learned)))
            }
        };
        let task = task.subtask(LEARNING_PART, 1.0);
        Ok(Self {
            rows: HarmonicRows::new(&task, &generator, &set, max_degree)?,
            generator,
            learned,
        })
    }

    /// With a generator that is learned again from some of the samples, beginning with one that was learned
    /// from all of them.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn learned_again(
        samples: &SampleSet,
        from: &[usize],
        known: &LearnedGenerator,
        max_degree: usize,
        task: &Task,
    ) -> Result<Self, RoomModelError> {
        let part = samples.of_rows(from).measurements();
        let generator = learn_again(task, known, &part, &LearnSettings::default())?;
        Self::new(samples, &GeneratorChoice::Known(generator), max_degree, task)
    }

    /// Fits all samples, or those whose indices are `used`.
    pub fn fit(
        &self,
        used: Option<&[usize]>,
        settings: &HarmonicFitSettings,
        task: &Task,
    ) -> Result<HarmonicFit, HarmonicFitError> {
        self.rows.fit(task, used, settings)
    }
}

/// What a harmonic model gives at a sample's pose; nothing where the tracker would read none.
pub fn predicted(model: &HarmonicModel, sample: &Sample) -> PoseError {
    model.axis_error_at(&sample.position_mm, &sample.axis).unwrap_or_default()
}

/// Fits a harmonic model.
pub fn fit_harmonic(
    samples: &SampleSet,
    order: &HarmonicOrder,
    map: MapKind,
    task: &Task,
) -> Result<(Fit, HarmonicReport, HarmonicTable), RoomModelError> {
    if map != MapKind::Distortion {
        return Err(RoomModelError::CorrectionMap);
    }
    let settings = order.settings(samples.samples.len());
    let prepared = task.subtask(0.0, 0.7);
    let table = HarmonicTable::new(samples, &order.generator, settings.degree, &prepared)?;
    not_on_a_line(samples)?;
    let found = table.fit(None, &settings, &task.subtask(0.7, 1.0))?;
    let report = HarmonicReport {
        generator: table.generator.clone(),
        settings,
        noise_mm: found.noise_mm,
        down_weighted: found.down_weighted(),
        learned: table.learned.as_deref().cloned(),
    };
    let source = FieldSource::Harmonic(Arc::new(found.model));
    let bounds = measured_bounds(samples)?.grown(HARMONIC_MARGIN);
    Ok((fit_of(samples, source, map, bounds), report, table))
}

/// Fits a process to the errors themselves, and its mean as the model.
pub fn fit_kriging(
    samples: &SampleSet,
    map: MapKind,
    task: &Task,
) -> Result<(Fit, Arc<GaussianField>), RoomModelError> {
    not_on_a_line(samples)?;
    let process = Arc::new(GaussianField::fit(samples, None, &task.subtask(0.0, 0.6))?);
    let kriging = Kriging::new(process.clone(), &task.subtask(0.6, 1.0))?;
    let source = FieldSource::Kriging(Arc::new(kriging));
    Ok((fit_of(samples, source, map, measured_bounds(samples)?), process))
}

/// Positions on a line, or at one place, where a model would be of its prior alone.
fn not_on_a_line(samples: &SampleSet) -> Result<(), RoomModelError> {
    let places = samples.samples.iter().map(|s| s.position_mm.coords);
    let count = samples.samples.len() as f64;
    let middle = places.clone().sum::<Vector3<f64>>() / count;
    let spread: Matrix3<f64> =
        places.map(|p| (p - middle) * (p - middle).transpose() / count).sum();
    let along_mm2 = spread.symmetric_eigenvalues().max();
    let across_mm = (spread.trace() - along_mm2).max(0.0).sqrt();
    match across_mm < LEAST_ACROSS_MM {
        true => Err(RoomModelError::OnALine { across_mm }),
        false => Ok(()),
    }
}

fn measured_bounds(samples: &SampleSet) -> Result<Bounds, GaussianError> {
    let bounds = Bounds::around(samples.samples.iter().map(|s| s.position_mm));
    bounds.ok_or(GaussianError::TooFewRows(0))
}

/// A fit whose model is no polynomial: there are no systems to report.
fn fit_of(samples: &SampleSet, source: FieldSource, map: MapKind, bounds: Bounds) -> Fit {
    let model = DistortionModel::of_source(source, map, bounds);
    let zero = DistortionModel::zero(bounds, map);
    Fit {
        samples: samples.samples.len(),
        before: residuals(&zero, samples, OutsidePolicy::Clamp),
        after: residuals(&model, samples, OutsidePolicy::Clamp),
        model,
        systems: Vec::new(),
        ambiguous: samples.ambiguous,
    }
}
