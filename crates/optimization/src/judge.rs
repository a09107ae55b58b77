//! What a layout comes to: over few poses while it is searched for, and as its study has it.

use crate::bodies::Bodies;
use crate::constraint::Constraint;
use crate::problem::{BuiltError, Goal, OverRooms, Problem};
use crate::scatter::{FieldScatter, SensorScatter, TipScatter};
use std::sync::Arc;
use trackwright_field::FieldPoint;
use trackwright_field::OutsidePolicy;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::linear_fit::LinearFit;
use trackwright_simulation::metric::ErrorOf;
use trackwright_simulation::metric::Summary;
use trackwright_simulation::pose_rule::{PoseRule, corners};
use trackwright_simulation::trial::{Simulator, TrialBuffers};
use trackwright_simulation::{
    CancelToken, InputTrial, Metric, Mode, PlacedBody, RoomFieldFigures, Scenario, Study,
    StudyError, Trial, WeakRotation, study,
};

/// Poses that stand for a range of motion while it is searched: the weighted ones of a Gauss rule,
/// or plain ones for figures that are no mean.
const FEW_WEIGHTED: usize = 130;
const FEW_PLAIN: usize = 240;

/// A tip that free rotations move by less is as good as one that they do not move.
const REACH_MM: f64 = 1e-6;

/// A layout's study, and what it comes to.
#[derive(Clone, Debug)]
pub(crate) struct Judged {
    /// Of what is to be expected, with the building error.
    pub objective: f64,
    /// With [`BuiltError::rough`].
    pub roughly_built: f64,
    /// One a room.
    pub studies: Vec<Study>,
}

/// Judges layouts of one problem.
pub(crate) struct Judge<'a> {
    pub problem: &'a Problem,
    /// What each room leaves open of its field at the start's sensors.
    fields: Vec<Option<FieldScatter<'a>>>,
    /// Each figure that counts, and what it is divided by.
    required: Vec<(Metric, f64)>,
    /// What the start leaves open; a layout is not to leave more open.
    start: Open,
    /// Of the start, in each room: trials with a sensor outside the model's box, and out of the volume.
    start_outside: Vec<[usize; 2]>,
    /// Likewise of few poses, outside the model's box.
    few_outside: Vec<usize>,
}

/// Few trials that stand for a study.
pub(crate) struct Few {
    pub trials: Vec<InputTrial>,
    /// `None` where all count alike.
    pub weights: Option<Vec<f64>>,
    /// Trials come in runs of one orientation, each so long.
    pub run: usize,
}

impl Few {
    /// These trials of a scenario.
    fn simulated(&self, scenario: &Scenario) -> Vec<Trial> {
        let simulator = Simulator::new(scenario);
        let mut buffers = TrialBuffers::default();
        if self.run < 2 {
            return simulator.given_trials(&mut buffers, &self.trials);
        }
        let poses: Vec<Pose> = self.trials.iter().map(|trial| trial.crf_from_tool).collect();
        simulator.trials(&mut buffers, &poses, self.run)
    }
}

/// Rotations that the sensors of both bodies leave open.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Open {
    /// How far free rotations can carry the tip.
    reach_mm: f64,
    is_weak: bool,
}

impl<'a> Judge<'a> {
    /// Judges against what the start, whose study is given, leaves open.
    ///
    /// # Errors
    /// See [`Judge::few`].
    pub fn new(
        problem: &'a Problem,
        start: &Bodies,
        figures: &[RoomFieldFigures],
    ) -> Result<Self, StudyError> {
        let required = match problem.goal {
            Goal::Figure(metric) => vec![(metric, 1.0)],
            Goal::Requirement(requirement) => requirement
                .bounds()
                .filter(|(metric, _)| problem.scenarios[0].judges(&problem.mode, *metric))
                .collect(),
        };
        let mut judge = Self {
            problem,
            fields: problem.scenarios.iter().map(|scenario| field(scenario, start)).collect(),
            required,
            start: Open { reach_mm: 0.0, is_weak: false },
            start_outside: figures.iter().map(|f| [f.outside, f.out_of_volume]).collect(),
            few_outside: Vec::new(),
        };
        judge.start = judge.open(start);
        let each = problem.scenarios.iter().map(|scenario| {
            let scenario = start.in_room(scenario);
            let few = judge.few(&scenario)?;
            let trials = few.simulated(&scenario);
            Ok(trials.iter().filter(|trial| trial.outside > 0).count())
        });
        judge.few_outside = each.collect::<Result<_, StudyError>>()?;
        Ok(judge)
    }

    /// Trials of the start's few poses with a sensor outside the model's box.
    pub fn most_outside(&self, room: usize) -> usize {
        self.few_outside.get(room).copied().unwrap_or(usize::MAX)
    }

    /// Whether any figure counts.
    pub fn requires_anything(&self) -> bool {
        !self.required.is_empty()
    }

    /// Few trials that stand for the study of a scenario.
    ///
    /// # Errors
    /// See [`Motion::counts`](trackwright_simulation::Motion::counts).
    pub fn few(&self, scenario: &Scenario) -> Result<Few, StudyError> {
        let plain = |trials: Vec<InputTrial>| Few { trials, weights: None, run: 1 };
        let is_mean =
            |(metric, _): &(Metric, f64)| matches!(metric.summary, Summary::Rms | Summary::Mean);
        match &self.problem.mode {
            Mode::Single => Ok(plain(vec![InputTrial::at(scenario.crf_from_tool)])),
            Mode::Input(trials) => Ok(plain(some(trials))),
            Mode::Motion if self.required.iter().all(is_mean) => {
                let rule = PoseRule::gauss(scenario, FEW_WEIGHTED)?;
                let trials = rule.poses.into_iter().map(InputTrial::at).collect();
                Ok(Few { trials, weights: Some(rule.weights), run: rule.run })
            }
            Mode::Motion => {
                let grid = scenario.motion_grid()?.ok_or(StudyError::NoMotion)?;
                let all: Arc<[InputTrial]> = match grid.trials() <= FEW_PLAIN {
                    true => (0..grid.trials()).map(|k| InputTrial::at(grid.pose(k))).collect(),
                    false => {
                        let ends = corners(&grid);
                        let between = FEW_PLAIN.saturating_sub(ends.len());
                        let between =
                            trackwright_simulation::spread::spread(grid.trials(), between);
                        let poses = ends.into_iter().chain(between.map(|k| grid.pose(k)));
                        poses.map(InputTrial::at).collect()
                    }
                };
                Ok(plain(all.to_vec()))
            }
        }
    }

    /// Frame fits that a layout takes over few poses, in all rooms.
    pub fn few_fits(&self, bodies: &Bodies) -> u64 {
        let each = self.problem.scenarios.iter().map(|scenario| {
            self.few(&bodies.in_room(scenario)).map_or(1, |few| few.trials.len() as u64 + 1)
        });
        each.sum()
    }

    /// What a layout comes to over few poses; `None` where it leaves the field at more of them than the
    /// start, or is no number.
    ///
    /// # Errors
    /// See [`Judge::few`].
    pub fn few_value(&self, bodies: &Bodies) -> Result<Option<f64>, StudyError> {
        let mut values = Vec::with_capacity(self.problem.scenarios.len());
        for (room, scenario) in self.problem.scenarios.iter().enumerate() {
            let scenario = bodies.in_room(scenario);
            let few = self.few(&scenario)?;
            let trials = few.simulated(&scenario);
            let outside = trials.iter().filter(|trial| trial.outside > 0).count();
            if self.few_outside.get(room).is_some_and(|most| outside > *most) {
                return Ok(None);
            }
            let scatter = self.scatter(&scenario, bodies, room);
            let is_left_out = |trial: &Trial| rejects(&scenario) && trial.outside > 0;
            let errors: Vec<[f64; 2]> = trials
                .iter()
                .zip(&few.trials)
                .map(|(trial, given)| match (&scatter, is_left_out(trial)) {
                    (_, true) => [0.0; 2],
                    (Some(scatter), _) => with_scatter(trial, scatter, given.tracker_from_crf),
                    (None, _) => [trial.tip_error_mm, trial.angle_error_deg],
                })
                .collect();
            values.push(self.of_few(&errors, &few));
        }
        Ok(over_rooms(self.problem.rooms, &values))
    }

    /// What the errors of few trials come to, tip and angle, scatter included; `None` where they are
    /// no numbers.
    pub fn of_few(&self, errors: &[[f64; 2]], few: &Few) -> f64 {
        self.of_errors(errors, few.weights.as_deref())
    }

    fn of_errors(&self, errors: &[[f64; 2]], weights: Option<&[f64]>) -> f64 {
        let mut values = Vec::with_capacity(errors.len());
        self.worst(|metric| {
            let component = usize::from(metric.of == ErrorOf::Angle);
            let each = errors.iter().map(|error| error[component]);
            match weights {
                None => {
                    values.clear();
                    values.extend(each);
                    metric.summary.of(&mut values)
                }
                Some(weights) => {
                    let weighted = each.zip(weights);
                    match metric.summary {
                        Summary::Rms => weighted.map(|(e, w)| e * e * w).sum::<f64>().sqrt(),
                        _ => weighted.map(|(e, w)| e * w).sum(),
                    }
                }
            }
        })
    }

    /// The largest part of its bound that a figure is.
    fn worst(&self, mut value: impl FnMut(Metric) -> f64) -> f64 {
        let each = self.required.iter().map(|(metric, bound)| {
            let value = value(*metric);
            // Of what may not be off at all, everything is too much.
            if *bound > 0.0 { value / bound } else { f64::INFINITY * value.signum() }
        });
        each.fold(0.0, |worst, value| if value.is_nan() { value } else { value.max(worst) })
    }

    /// The study of a layout in every room, and what is to be expected of it; `None` where it leaves the
    /// field of one of them at more poses than the start, or has no figures.
    ///
    /// # Errors
    /// [`StudyError::Cancelled`].
    pub fn study(
        &self,
        bodies: &Bodies,
        cancel: &CancelToken,
    ) -> Result<Option<Judged>, StudyError> {
        let mut studies = Vec::with_capacity(self.problem.scenarios.len());
        let mut values: [Vec<f64>; 2] = Default::default();
        for (scenario, most) in self.problem.scenarios.iter().zip(&self.start_outside) {
            let scenario = bodies.in_room(scenario);
            let built = [self.problem.built, Some(BuiltError::rough(self.problem.built))];
            let scatters = built.map(|built| self.built_scatter(&scenario, bodies, built));
            let mut errors: [Vec<[f64; 2]>; 2] = Default::default();
            let mut log = |trial: &Trial| {
                for (errors, scatter) in errors.iter_mut().zip(&scatters) {
                    errors.extend(scatter.as_ref().map(|s| with_scatter(trial, s, None)));
                }
            };
            let study = match study(&scenario, &self.problem.mode, cancel, Some(&mut log)) {
                Ok(study) => study,
                Err(StudyError::AllRejected { .. }) => return Ok(None),
                Err(error) => return Err(error),
            };
            let now = [study.room_field.outside, study.room_field.out_of_volume];
            if study.figures.all.is_empty() || now.iter().zip(most).any(|(now, most)| now > most) {
                return Ok(None);
            }
            for (values, errors) in values.iter_mut().zip(&errors) {
                values.push(self.worst(|metric| {
                    let value = study.figures.get(metric).map_or(f64::NAN, |figure| figure.value);
                    // What scatter adds to the square of the room's own figure it adds to that of any.
                    let own = study.room_field.value(metric);
                    let component = usize::from(metric.of == ErrorOf::Angle);
                    let mut scattered: Vec<f64> = errors.iter().map(|e| e[component]).collect();
                    match scattered.is_empty() {
                        true => value,
                        false => {
                            let with = metric.summary.of(&mut scattered);
                            (value * value + (with * with - own * own).max(0.0)).sqrt()
                        }
                    }
                }));
            }
            studies.push(study);
        }
        let [objective, rough] = values.map(|values| over_rooms(self.problem.rooms, &values));
        let both = objective.zip(rough);
        Ok(both.map(|(objective, roughly_built)| Judged { objective, roughly_built, studies }))
    }

    /// The figure that decides the objective of studies.
    pub fn deciding(&self, studies: &[Study]) -> Option<Metric> {
        let each = self.required.iter().map(|(metric, bound)| {
            let values = studies.iter().filter_map(|study| study.figures.get(*metric));
            (*metric, values.map(|figure| figure.value / bound).fold(0.0, f64::max))
        });
        each.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(metric, _)| metric)
    }

    /// What is added in a room that states its jitter, by how sensors are built where that is stated, and
    /// by what the room leaves open of its field.
    pub fn scatter<'b>(
        &'b self,
        scenario: &Scenario,
        bodies: &'b Bodies,
        room: usize,
    ) -> Option<TipScatter<'b>> {
        let stated = stated(scenario, self.problem.built);
        let sensors = SensorScatter { field: self.fields[room], ..stated };
        let is_any = sensors.jitter.is_some() || sensors.built.is_some() || sensors.field.is_some();
        is_any.then(|| TipScatter::new(sensors, bodies, scenario.orientation_weight_mm))
    }

    /// What jitter and a building error add.
    fn built_scatter<'b>(
        &'b self,
        scenario: &Scenario,
        bodies: &'b Bodies,
        built: Option<BuiltError>,
    ) -> Option<TipScatter<'b>> {
        let sensors = stated(scenario, built);
        let is_any = sensors.jitter.is_some() || sensors.built.is_some();
        is_any.then(|| TipScatter::new(sensors, bodies, scenario.orientation_weight_mm))
    }

    /// What a layout leaves open that the start does not, if anything.
    pub fn determination_fault(&self, bodies: &Bodies) -> Option<Constraint> {
        let open = self.open(bodies);
        let is_worse =
            open.reach_mm > self.start.reach_mm + REACH_MM || (open.is_weak && !self.start.is_weak);
        is_worse.then_some(Constraint::Determination)
    }

    fn open(&self, bodies: &Bodies) -> Open {
        let weight_mm = self.problem.scenarios[0].orientation_weight_mm;
        let tip_in_tool = bodies.tool.judged_tip_in_body();
        let mut open = Open { reach_mm: 0.0, is_weak: false };
        for body in [PlacedBody::Tool, PlacedBody::Crf] {
            let Some(rigid) = bodies.body(body) else { continue };
            let tip = match body {
                PlacedBody::Tool => tip_in_tool,
                PlacedBody::Crf => bodies.crf_from_tool * tip_in_tool,
            };
            let free = LinearFit::new(rigid, weight_mm).free_motion();
            open.reach_mm += free.map_or(0.0, |free| free.reach_mm(&tip));
            let key = crate::outcome::body_key(body);
            open.is_weak |= WeakRotation::of_body(key, rigid, weight_mm).is_some();
        }
        open
    }
}

/// What sensors scatter by, as the room and the problem state it.
fn stated(scenario: &Scenario, built: Option<BuiltError>) -> SensorScatter<'static> {
    let jitter = scenario.environment.jitter.filter(|jitter| jitter.problem().is_none());
    SensorScatter { jitter, built, field: None }
}

/// Tip and angle error of a trial with what scatter adds.
pub(crate) fn with_scatter(
    trial: &Trial,
    scatter: &TipScatter,
    tracker_from_crf: Option<Pose>,
) -> [f64; 2] {
    let own = [trial.tip_error_mm, trial.angle_error_deg];
    scatter.added_to(own, &trial.crf_from_tool, tracker_from_crf)
}

/// The value over all rooms; `None` where one has none.
pub(crate) fn over_rooms(rooms: OverRooms, values: &[f64]) -> Option<f64> {
    let value = match rooms {
        OverRooms::Worst => values.iter().copied().fold(0.0, f64::max),
        OverRooms::Mean => values.iter().sum::<f64>() / values.len().max(1) as f64,
    };
    // The larger of two drops what is no number.
    let is_known = values.iter().all(|value| !value.is_nan()) && !values.is_empty();
    is_known.then_some(value)
}

/// What a room leaves open of its field at the sensors of a layout, at its own pose.
fn field<'a>(scenario: &'a Scenario, start: &Bodies) -> Option<FieldScatter<'a>> {
    let process = scenario.environment.process.as_deref()?;
    let at = start.in_room(scenario);
    let tracker_from_tool = at.tracker_from_crf() * at.crf_from_tool;
    let bodies = [(&at.tool, tracker_from_tool)];
    let crf = at.crf.as_ref().map(|crf| (&crf.body, crf.tracker_from_crf));
    let points: Vec<FieldPoint> = bodies
        .into_iter()
        .chain(crf)
        .flat_map(|(body, pose)| {
            body.sensors.iter().filter_map(move |sensor| {
                Some(FieldPoint::new(
                    pose * sensor.position_in_body,
                    pose.rotation * sensor.axis_in_body()?,
                ))
            })
        })
        .collect();
    let variances = process.unit_variances(&points).ok()?;
    let mean = variances.iter().sum::<f64>() / variances.len().max(1) as f64;
    (mean > 0.0).then(|| FieldScatter::of(process, mean))
}

/// Some of given trials, spread over all.
fn some(trials: &[InputTrial]) -> Vec<InputTrial> {
    if trials.len() <= FEW_PLAIN {
        return trials.to_vec();
    }
    let spread = trackwright_simulation::spread::spread(trials.len(), FEW_PLAIN);
    spread.map(|k| trials[k]).collect()
}

/// Whether trials with a sensor outside the model's box are left out.
pub(crate) fn rejects(scenario: &Scenario) -> bool {
    scenario.outside == OutsidePolicy::Reject
}
