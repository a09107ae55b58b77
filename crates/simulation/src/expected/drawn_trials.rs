//! Trials of a study in fields that differ at its sensors alone.

use crate::scenario::InputTrial;
use crate::tool_in_crf::{ErrorVectors, relative_error};
use crate::tracker::TrackBuffers;
use crate::trial::Simulator;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use trackwright_field::Environment;
use trackwright_field::FieldPoint;
use trackwright_field::environment::ComputedMetal;
use trackwright_field::gaussian::{DrawnErrors, GaussianError, Trend};
use trackwright_field::samples::PoseError;
use trackwright_geometry::pose::Pose;

/// Seeds of what sensors are off by themselves, and of what is not known of metal.
const SENSOR_SEED: u64 = 23;
const METAL_SEED: u64 = 24;

/// What each sensor of tool and CRF is off by itself in one drawn field.
struct SensorErrors {
    tool: DrawnErrors,
    crf: DrawnErrors,
}

/// Trials made ready to be tried in many fields.
pub struct DrawnTrials<'a> {
    simulator: &'a Simulator<'a>,
    environment: &'a Environment,
    trials: Vec<InputTrial>,
    tracker_from_tool: Vec<Pose>,
    /// Each place of the CRF once; none without a CRF.
    tracker_from_crf: Vec<Pose>,
    /// Of each trial, which of them is its own.
    crf_of_trial: Vec<usize>,
    /// The tool's sensors, then the CRF's.
    points: Vec<FieldPoint>,
    model_errors: Vec<PoseError>,
    /// Points that are the tool's.
    tool_points: usize,
}

impl<'a> DrawnTrials<'a> {
    /// `None` where a body has markers: what is drawn is a field of readings with an axis.
    pub fn new(
        simulator: &'a Simulator<'a>,
        environment: &'a Environment,
        trials: Vec<InputTrial>,
    ) -> Option<Self> {
        let (tool, crf) = simulator.trackers();
        let mut tracker_from_crf: Vec<Pose> = Vec::new();
        let mut crf_of_trial = Vec::with_capacity(trials.len());
        let mut tracker_from_tool = Vec::with_capacity(trials.len());
        for trial in &trials {
            let own = trial.tracker_from_crf.filter(|_| crf.is_some());
            let pose = own.unwrap_or_else(|| simulator.tracker_from_crf());
            tracker_from_tool.push(pose * trial.crf_from_tool);
            if tracker_from_crf.last() != Some(&pose) {
                tracker_from_crf.push(pose);
            }
            crf_of_trial.push(tracker_from_crf.len() - 1);
        }
        let mut buffers = TrackBuffers::default();
        let mut all = tool.field_points(&mut buffers, &tracker_from_tool)?;
        let tool_points = all.len();
        match crf {
            Some(crf) => all.extend(crf.field_points(&mut buffers, &tracker_from_crf)?),
            None => tracker_from_crf.clear(),
        }
        let (points, model_errors) = all.into_iter().unzip();
        Some(Self {
            simulator,
            environment,
            trials,
            tracker_from_tool,
            tracker_from_crf,
            crf_of_trial,
            points,
            model_errors,
            tool_points,
        })
    }

    /// Fields drawn at the points. The same seed gives the same fields.
    ///
    /// # Errors
    /// [`GaussianError::NotPositiveDefinite`].
    pub fn fields(&self, count: usize, seed: u64) -> Result<DrawnFields, GaussianError> {
        let posterior = match &self.environment.process {
            Some(process) => Some(process.posterior(&self.points)?),
            None => None,
        };
        let drawn = posterior.as_ref().map(|posterior| posterior.draws(count, seed));
        let rows = posterior.map_or(0, |posterior| posterior.rows);
        Ok(self.fields_of(drawn, count, rows))
    }

    /// The same of fields that were drawn at these points.
    pub fn fields_of(
        &self,
        drawn: Option<Vec<DrawnErrors>>,
        count: usize,
        rows: usize,
    ) -> DrawnFields {
        let metal = self.environment.metal.as_ref().map(|metal| {
            let each = self.points.iter().zip(&self.model_errors);
            let parts = each.map(|(at, error)| metal.part(error, at)).collect();
            let off = metal.solution_errors(&self.model_errors, &self.points);
            MetalDraws::new(metal, parts, off, count)
        });
        DrawnFields { drawn, sensors: self.sensor_errors(count), metal, rows }
    }

    /// What the sensors are off by themselves in each of some fields; sensors of the same place in two
    /// designs are the same.
    fn sensor_errors(&self, draws: usize) -> Vec<SensorErrors> {
        let tool = self.tool_points / self.tracker_from_tool.len().max(1);
        let crf_points = self.points.len() - self.tool_points;
        let crf = crf_points / self.tracker_from_crf.len().max(1);
        let of = |sensors, body| match &self.environment.process {
            Some(process) => process.sensor_errors(sensors, body, draws, SENSOR_SEED),
            None => vec![vec![[0.0; 6]; sensors]; draws],
        };
        let each = of(tool, 0).into_iter().zip(of(crf, 1));
        each.map(|(tool, crf)| SensorErrors { tool, crf }).collect()
    }

    /// Tip error and angle error of each trial by the room's model alone.
    pub fn model_trial_errors(&self) -> Vec<[f64; 2]> {
        self.errors(&self.model_errors)
    }

    /// Where the sensors are.
    pub fn points(&self) -> &[FieldPoint] {
        &self.points
    }

    /// Tip error in mm and angle error in degrees of each trial, where the sensors err like this.
    pub fn errors(&self, at_points: &[PoseError]) -> Vec<[f64; 2]> {
        let tip = self.simulator.tip_in_tool();
        self.tracked(at_points, |truth, simulated| {
            let error = relative_error(truth, simulated, tip);
            [error.tip_error_in_crf_mm.norm(), error.angle_rad.to_degrees()]
        })
    }

    /// The same as vectors.
    pub fn error_vectors(&self, at_points: &[PoseError]) -> Vec<ErrorVectors> {
        let tip = self.simulator.tip_in_tool();
        self.tracked(at_points, |truth, simulated| ErrorVectors::of(truth, simulated, tip))
    }

    /// What comes of each trial's true and simulated pose of the tool in the CRF.
    fn tracked<T>(&self, at_points: &[PoseError], of: impl Fn(&Pose, &Pose) -> T) -> Vec<T> {
        let (tool_errors, crf_errors) = at_points.split_at(self.tool_points);
        let (tool, crf) = self.simulator.trackers();
        let tool_fits = tool.fit_with_errors(&self.tracker_from_tool, tool_errors);
        let crf_fits = crf.map(|crf| crf.fit_with_errors(&self.tracker_from_crf, crf_errors));
        let each = self.trials.iter().zip(&tool_fits).zip(&self.crf_of_trial);
        each.map(|((trial, tracker_from_tool), &place)| {
            let tracker_from_crf = match &crf_fits {
                Some(fits) => fits[place],
                None => Pose::identity(),
            };
            of(&trial.crf_from_tool, &(tracker_from_crf.inverse() * tracker_from_tool))
        })
        .collect()
    }
}

/// Fields drawn at the sensors of trials.
pub struct DrawnFields {
    /// Those of the process; `None` in a room that was not measured.
    drawn: Option<Vec<DrawnErrors>>,
    sensors: Vec<SensorErrors>,
    metal: Option<MetalDraws>,
    rows: usize,
}

impl DrawnFields {
    /// Measurements that they are conditioned on.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The errors at the points in one field: what is drawn, what it is added to, what each sensor is off by
    /// itself, and what the metal's errors are off by.
    pub fn errors(&self, at: &DrawnTrials, draw: usize) -> Vec<PoseError> {
        let trend = at.environment.process.as_ref().map_or(Trend::Model, |process| process.trend);
        let (drawn, own) = (self.drawn.as_ref().map(|drawn| &drawn[draw]), &self.sensors[draw]);
        let mut noise = self.metal.as_ref().map(|metal| metal.noise(draw));
        let each = at.model_errors.iter().enumerate().map(|(point, model)| {
            let own = match point.checked_sub(at.tool_points) {
                None => own.tool[point / at.tracker_from_tool.len()],
                Some(point) => own.crf[point / at.tracker_from_crf.len()],
            };
            let metal = self.metal.as_ref().map(|metal| metal.parts[point]);
            let base = match trend {
                Trend::Model => Some(*model),
                Trend::None => metal,
            };
            let mut values = base.map_or([0.0; 6], |base| base.values());
            for c in 0..6 {
                values[c] += own[c] + drawn.map_or(0.0, |drawn| drawn[point][c]);
            }
            if let Some((metal, noise)) = self.metal.as_ref().zip(noise.as_mut()) {
                metal.add_error(&mut values, point, draw, noise);
            }
            PoseError::of_values(values)
        });
        each.collect()
    }
}

/// Draws are antithetic pairs, as those of the field are.
fn side(draw: usize) -> f64 {
    if draw.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// What is not known of computed metal, in each of some fields.
struct MetalDraws {
    /// The metal's own errors at the points.
    parts: Vec<PoseError>,
    /// What another solution changes of them.
    off: Vec<PoseError>,
    /// What the errors are times in each field, less 1, and how much of what the other solution changes is in it.
    excess: Vec<f64>,
    change: Vec<f64>,
    solution_std: f64,
    position_std_mm: f64,
}

impl MetalDraws {
    fn new(
        metal: &ComputedMetal,
        parts: Vec<PoseError>,
        off: Vec<PoseError>,
        draws: usize,
    ) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(METAL_SEED);
        let std = metal.material_std;
        let mut pairs = || -> Vec<f64> {
            let normals: Vec<f64> =
                (0..draws.div_ceil(2)).map(|_| StandardNormal.sample(&mut random)).collect();
            (0..draws).map(|draw| side(draw) * normals[draw / 2]).collect()
        };
        let excess = pairs().into_iter().map(|normal| (std * normal - 0.5 * std * std).exp_m1());
        Self {
            excess: excess.collect(),
            change: pairs(),
            parts,
            off,
            solution_std: metal.solution_std,
            position_std_mm: metal.position_std_mm,
        }
    }

    fn noise(&self, draw: usize) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(METAL_SEED);
        random.set_stream(1 + draw as u64 / 2);
        random
    }

    /// Adds what the metal's errors at a point are off by in one field.
    fn add_error(&self, values: &mut [f64; 6], point: usize, draw: usize, noise: &mut ChaCha8Rng) {
        let mut normal = || {
            let normal: f64 = StandardNormal.sample(noise);
            side(draw) * normal
        };
        let by = self.excess[draw] + self.solution_std * normal();
        let (own, off) = (self.parts[point].values(), self.off[point].values());
        for (c, value) in values.iter_mut().enumerate() {
            let evaluation_mm = if c < 3 { self.position_std_mm * normal() } else { 0.0 };
            *value += by * own[c] + self.change[draw] * off[c] + evaluation_mm;
        }
    }
}
