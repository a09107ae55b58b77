//! Rows of a measured and a predicted error, from recorded poses of the tool.

use super::AgreementError;
use crate::pivot::Pivot;
use nalgebra::{Point3, Translation3, Vector3};
use trackwright_field::OutsidePolicy;
use trackwright_field::compensation::Method;
use trackwright_field::samples::Measurement;
use trackwright_geometry::pose::{Pose, is_finite};
use trackwright_geometry::rotation::{exp_vector, log_quaternion};
use trackwright_simulation::body_compensation::BodyCompensator;
use trackwright_simulation::run::run;
use trackwright_simulation::scenario::{InputTrial, Mode, Scenario};
use trackwright_simulation::trial::{Simulator, Trial};
use trackwright_task::Task;

/// One recorded pose of the built tool. Without a CRF, the tracker frame stands for the CRF's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedPose {
    /// The true pose of the CRF; the design's where `None`.
    pub tracker_from_crf: Option<Pose>,
    /// The true pose of the tool.
    pub crf_from_tool: Pose,
    pub crf_from_tool_measured: Pose,
    /// Poses that belong together share it.
    pub group: usize,
}

impl RecordedPose {
    /// From poses in the tracker's frame, of the tool and perhaps of the CRF.
    pub fn in_tracker(tool: &Measurement, crf: Option<&Measurement>, group: usize) -> Self {
        match crf {
            None => Self {
                tracker_from_crf: None,
                crf_from_tool: tool.tracker_from_ideal,
                crf_from_tool_measured: tool.tracker_from_measured,
                group,
            },
            Some(crf) => Self {
                tracker_from_crf: Some(crf.tracker_from_ideal),
                crf_from_tool: crf.tracker_from_ideal.inverse() * tool.tracker_from_ideal,
                crf_from_tool_measured: crf.tracker_from_measured.inverse()
                    * tool.tracker_from_measured,
                group,
            },
        }
    }
}

/// Measured and predicted at one pose; CRF axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgreementRow {
    /// The true pose of the tool, of a pivoted one the most likely.
    pub crf_from_tool: Pose,
    pub tracker_from_crf: Option<Pose>,
    pub measured_mm: Vector3<f64>,
    pub predicted_mm: Vector3<f64>,
    /// Rotation vectors; `None` of a pivoted tool.
    pub measured_rad: Option<Vector3<f64>>,
    pub predicted_rad: Vector3<f64>,
    pub group: usize,
    /// Sensors of tool and CRF outside the model's box.
    pub outside: usize,
    /// Depends on field that the samples do not support; `None` where the room does not state it.
    pub is_unsupported: Option<bool>,
    pub is_used: bool,
}

impl AgreementRow {
    /// Where the CRF is: as it was recorded, else as the design has it; the tracker frame without one.
    pub fn tracker_from_crf_in(&self, scenario: &Scenario) -> Pose {
        let given = self.tracker_from_crf.filter(|_| scenario.crf.is_some());
        given.unwrap_or_else(|| scenario.tracker_from_crf())
    }

    /// The pose that was measured, so that a tip there is off by the measured error; `None` of a pivoted
    /// tool.
    pub fn crf_from_tool_measured(&self, tip_in_tool: &Point3<f64>) -> Option<Pose> {
        let rotation = exp_vector(&self.measured_rad?) * self.crf_from_tool.rotation;
        let tip_in_crf = self.crf_from_tool * tip_in_tool + self.measured_mm;
        let translation = Translation3::from(tip_in_crf - rotation * tip_in_tool);
        Some(Pose::from_parts(translation, rotation))
    }

    /// Measured minus predicted.
    pub fn residual_mm(&self) -> Vector3<f64> {
        self.measured_mm - self.predicted_mm
    }
}

/// Simulates the design at the true poses, and sets what it predicts beside what was measured.
pub fn paired_rows(
    scenario: &Scenario,
    recorded: &[RecordedPose],
    task: &Task,
) -> Result<Vec<AgreementRow>, AgreementError> {
    for (index, pose) in recorded.iter().enumerate() {
        let poses = [
            Some(&pose.crf_from_tool),
            Some(&pose.crf_from_tool_measured),
            pose.tracker_from_crf.as_ref(),
        ];
        if !poses.into_iter().flatten().all(is_finite) {
            return Err(AgreementError::NotFinite(index));
        }
    }
    let tip = scenario.tool.judged_tip_in_body();
    let given: Vec<InputTrial> = recorded
        .iter()
        .map(|pose| InputTrial {
            tracker_from_crf: pose.tracker_from_crf,
            crf_from_tool: pose.crf_from_tool,
        })
        .collect();
    let trials = simulated(scenario, given, task)?;
    let rows = recorded.iter().zip(&trials).map(|(pose, trial)| {
        let turn =
            |now: &Pose| log_quaternion(&(now.rotation * pose.crf_from_tool.rotation.inverse()));
        AgreementRow {
            measured_mm: pose.crf_from_tool_measured * tip - pose.crf_from_tool * tip,
            measured_rad: Some(turn(&pose.crf_from_tool_measured)),
            ..predicted(trial, pose.tracker_from_crf, pose.group)
        }
    });
    Ok(rows.collect())
}

/// Of a tool that pivoted around its tip, from poses as the tracker reported them: the tip's
/// distance from the point that it rested in, beside what is predicted.
///
/// The true pose is not known; the one that would be read as it was recorded stands for it, and
/// the tip is where the recording has it, not where the design does. What is compared has its mean
/// and a tip's shift taken out of both, so that measured minus predicted is what the same
/// calibration would leave of corrected poses.
pub fn pivot_rows(
    scenario: &Scenario,
    measured: &[Pose],
    found: &Pivot,
    task: &Task,
) -> Result<(Scenario, Vec<AgreementRow>), AgreementError> {
    if let Some(index) = measured.iter().position(|pose| !is_finite(pose)) {
        return Err(AgreementError::NotFinite(index));
    }
    let mut scenario = scenario.clone();
    scenario.tool.tip_in_body = Some(found.tip_in_tool);
    // Poses outside the box are simulated too, as below.
    let compensator = BodyCompensator::new(
        scenario.tool.clone(),
        scenario.orientation_weight_mm,
        &scenario.environment,
        OutsidePolicy::Clamp,
        Method::Inverse,
    );
    let mut given = Vec::with_capacity(measured.len());
    for (index, pose) in measured.iter().enumerate() {
        task.step(index, 2 * measured.len())?;
        given.push(InputTrial::at(compensator.nearest(pose)));
    }
    let trials = simulated(&scenario, given, &task.subtask(0.5, 1.0))?;
    let rows = measured.iter().zip(&trials).enumerate();
    let rows = rows.map(|(index, (read, trial))| AgreementRow {
        measured_mm: read * found.tip_in_tool - found.pivot_in_tracker,
        ..predicted(trial, None, index)
    });
    let rows = rows.collect();
    Ok((scenario, rows))
}

fn predicted(trial: &Trial, tracker_from_crf: Option<Pose>, group: usize) -> AgreementRow {
    let turn = trial.crf_from_tool_simulated.rotation * trial.crf_from_tool.rotation.inverse();
    AgreementRow {
        crf_from_tool: trial.crf_from_tool,
        tracker_from_crf,
        measured_mm: Vector3::zeros(),
        predicted_mm: trial.tip_error_in_crf_mm,
        measured_rad: None,
        predicted_rad: log_quaternion(&turn),
        group,
        outside: trial.outside,
        is_unsupported: None,
        is_used: true,
    }
}

/// The study's own trials, in order, poses outside the box included.
fn simulated(
    scenario: &Scenario,
    given: Vec<InputTrial>,
    task: &Task,
) -> Result<Vec<Trial>, AgreementError> {
    let mut scenario = scenario.clone();
    if scenario.outside == OutsidePolicy::Reject {
        scenario.outside = OutsidePolicy::Clamp;
    }
    let all = given.len();
    let mut trials = Vec::with_capacity(all);
    let mut log = |trial: &Trial| {
        // Progress only: whoever cancels has the token, and the result is dropped.
        let _ = task.step(trials.len(), all);
        trials.push(*trial);
    };
    trackwright_simulation::run::check(&scenario)?;
    if let Some((body, _)) = Simulator::new(&scenario).free_motion() {
        let crf = scenario.crf.as_ref().filter(|_| body == "crf");
        let free = crf.map_or(&scenario.tool, |crf| &crf.body);
        return Err(AgreementError::FreeRotation { body: free.name.clone() });
    }
    run(&scenario, &Mode::Input(given.into()), &task.cancel, Some(&mut log))?;
    Ok(trials)
}

/// Where the tip is at a row.
pub fn tip_in_crf(row: &AgreementRow, scenario: &Scenario) -> Point3<f64> {
    row.crf_from_tool * scenario.tool.judged_tip_in_body()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_gives_back_its_measured_pose() {
        let tip = Point3::new(3.0, -4.0, 80.0);
        let pose = |at: [f64; 3], turn: [f64; 3]| {
            Pose::from_parts(Translation3::from(at), exp_vector(&turn.into()))
        };
        let truth = pose([10.0, -20.0, 30.0], [0.4, -1.0, 0.7]);
        let measured = pose([10.5, -20.3, 29.0], [0.41, -1.02, 0.69]);
        let turn = measured.rotation * truth.rotation.inverse();
        let row = AgreementRow {
            crf_from_tool: truth,
            tracker_from_crf: None,
            measured_mm: measured * tip - truth * tip,
            predicted_mm: Vector3::zeros(),
            measured_rad: Some(log_quaternion(&turn)),
            predicted_rad: Vector3::zeros(),
            group: 0,
            outside: 0,
            is_unsupported: None,
            is_used: true,
        };
        let found = row.crf_from_tool_measured(&tip).unwrap();
        assert!((found * tip - measured * tip).norm() < 1e-12);
        assert!(found.rotation.angle_to(&measured.rotation) < 1e-7);
        let pivoted = AgreementRow { measured_rad: None, ..row };
        assert_eq!(pivoted.crf_from_tool_measured(&tip), None);
    }
}
