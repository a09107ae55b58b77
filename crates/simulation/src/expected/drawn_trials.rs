//! Trials of a study in fields that differ at its sensors alone.

use crate::scenario::InputTrial;
use crate::tool_in_crf::relative_error;
use crate::tracker::TrackBuffers;
use crate::trial::Simulator;
use trackwright_field::gaussian::{DrawnErrors, ErrorValues, FieldPoint, GaussianField, Trend};
use trackwright_field::samples::PoseError;
use trackwright_geometry::pose::Pose;

/// What each sensor of tool and CRF is off by itself in one drawn field.
pub struct SensorErrors {
    tool: DrawnErrors,
    crf: DrawnErrors,
}

/// Trials made ready to be tried in many fields.
pub struct DrawnTrials<'a> {
    simulator: &'a Simulator<'a>,
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
    pub fn new(simulator: &'a Simulator<'a>, trials: Vec<InputTrial>) -> Option<Self> {
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
            trials,
            tracker_from_tool,
            tracker_from_crf,
            crf_of_trial,
            points,
            model_errors,
            tool_points,
        })
    }

    /// The errors at the points of a drawn field, the trend and what each sensor is off by itself added.
    pub fn field_errors(
        &self,
        drawn: &[ErrorValues],
        trend: Trend,
        own: &SensorErrors,
    ) -> Vec<PoseError> {
        let each = drawn.iter().zip(&self.model_errors).enumerate();
        each.map(|(point, (values, model))| {
            let own = match point.checked_sub(self.tool_points) {
                None => own.tool[point / self.tracker_from_tool.len()],
                Some(point) => own.crf[point / self.tracker_from_crf.len()],
            };
            let error = PoseError::of_values(std::array::from_fn(|c| values[c] + own[c]));
            match trend {
                Trend::None => error,
                Trend::Model => PoseError {
                    position_mm: error.position_mm + model.position_mm,
                    rotation_rad: error.rotation_rad + model.rotation_rad,
                },
            }
        })
        .collect()
    }

    /// What the sensors are off by themselves in each of some fields; sensors of the same place in two
    /// designs are the same.
    pub fn sensor_errors(
        &self,
        process: &GaussianField,
        draws: usize,
        seed: u64,
    ) -> Vec<SensorErrors> {
        let tool = self.tool_points / self.tracker_from_tool.len().max(1);
        let crf_points = self.points.len() - self.tool_points;
        let crf = crf_points / self.tracker_from_crf.len().max(1);
        let of = |sensors, body| process.sensor_errors(sensors, body, draws, seed);
        let each = of(tool, 0).into_iter().zip(of(crf, 1));
        each.map(|(tool, crf)| SensorErrors { tool, crf }).collect()
    }

    /// Tip error and angle error of each trial in the room's own field.
    pub fn model_trial_errors(&self) -> Vec<[f64; 2]> {
        self.errors(&self.model_errors)
    }

    /// Where the sensors are.
    pub fn points(&self) -> &[FieldPoint] {
        &self.points
    }

    /// Tip error in mm and angle error in degrees of each trial, where the sensors err like this.
    pub fn errors(&self, at_points: &[PoseError]) -> Vec<[f64; 2]> {
        let (tool_errors, crf_errors) = at_points.split_at(self.tool_points);
        let (tool, crf) = self.simulator.trackers();
        let tool_fits = tool.fit_with_errors(&self.tracker_from_tool, tool_errors);
        let crf_fits = crf.map(|crf| crf.fit_with_errors(&self.tracker_from_crf, crf_errors));
        let tip = self.simulator.tip_in_tool();
        let each = self.trials.iter().zip(&tool_fits).zip(&self.crf_of_trial);
        each.map(|((trial, tracker_from_tool), &place)| {
            let tracker_from_crf = match &crf_fits {
                Some(fits) => fits[place],
                None => Pose::identity(),
            };
            let simulated = tracker_from_crf.inverse() * tracker_from_tool;
            let error = relative_error(&trial.crf_from_tool, &simulated, tip);
            [error.tip_error_in_crf_mm.norm(), error.angle_rad.to_degrees()]
        })
        .collect()
    }
}
