//! A sensor of the CRF: the CRF stands still, so a place costs one reading and one fit, whatever
//! the motion.
//!
//! With the CRF fitted as the design has it a trial finds the tip at `s` where it is at `q`, in the
//! CRF. Another fit of the CRF moves all these alike: `s' = R s + p`, so with the mean `s̄`,
//! `M = R - I` and `a = M s̄ + p`, the error is `s' - q = e + M (s - s̄) + a` with `e = s - q`, and
//!
//! `Σ w |s' - q|² = Σ w |e|² + 2 <M, C> + <M S, M> + 2 a·Σ w e + |a|² Σ w`,
//!
//! `C = Σ w e (s - s̄)ᵀ`, `S = Σ w (s - s̄)(s - s̄)ᵀ`. All terms are of the size of errors, so no
//! digits go; the sums are made once.

use super::outcome::Found;
use super::tool::nameless;
use crate::body::Sensor;
use crate::frame_fit::FrameFitter;
use crate::pose_rule::PoseRule;
use crate::refit::{BodyReadings, RefitBuffers};
use crate::scenario::{Scenario, ScenarioCrf};
use crate::tracker::{BodyTracker, TrackBuffers};
use crate::trial::{Simulator, TrialBuffers};
use crate::work::Work;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use trackwright_field::OutsidePolicy;
use trackwright_geometry::pose::Pose;
use trackwright_task::{CancelToken, Cancelled};

/// The sums over all trials, with the CRF fitted as the design has it.
pub(super) struct CrfAt<'a> {
    scenario: &'a Scenario,
    crf: &'a ScenarioCrf,
    sensor: usize,
    /// Of all sensors where they are now.
    readings: BodyReadings<'a>,
    tracker_from_crf_fitted: Pose,
    weights: f64,
    squares_mm2: f64,
    mean_mm: Vector3<f64>,
    error_sum_mm: Vector3<f64>,
    error_by_place: Matrix3<f64>,
    place_by_place: Matrix3<f64>,
    work: Work,
}

impl<'a> CrfAt<'a> {
    pub fn new(
        scenario: &'a Scenario,
        crf: &'a ScenarioCrf,
        sensor: usize,
        rule: &PoseRule,
        cancel: &CancelToken,
    ) -> Result<Self, Cancelled> {
        let simulator = Simulator::new(scenario);
        let parts: Result<Vec<_>, Cancelled> = rule
            .pieces()
            .into_par_iter()
            .map_init(TrialBuffers::default, |buffers, piece| {
                if cancel.is_cancelled() {
                    return Err(Cancelled);
                }
                let poses = &rule.poses[piece];
                let trials = simulator.trials(buffers, poses, rule.run.min(poses.len()));
                Ok((trials, buffers.take_work()))
            })
            .collect();
        let mut work = simulator.own_work();
        let tip_in_tool = scenario.tool.judged_tip_in_body();
        let mut trials = Vec::with_capacity(rule.poses.len());
        for (part, cost) in parts? {
            work += cost;
            trials.extend(part);
        }
        let mut buffers = TrackBuffers::default();
        let tracker = BodyTracker::new(&crf.body, scenario);
        let reference = tracker.track(&mut buffers, &crf.tracker_from_crf);
        let here = (vec![crf.tracker_from_crf], 1);
        let one_piece = std::iter::once(0..1).collect();
        let (readings, cost) =
            BodyReadings::read(scenario, &crf.body, None, here, one_piece, cancel)?;
        work += buffers.work + cost;
        // By the tool alone: what the CRF's sensors do is each place's own.
        let is_kept = |outside: usize| {
            scenario.outside != OutsidePolicy::Reject || outside == reference.outside
        };
        let kept: Vec<_> = trials
            .iter()
            .zip(&rule.weights)
            .filter(|(trial, _)| is_kept(trial.outside))
            .map(|(trial, weight)| {
                let place = trial.crf_from_tool_simulated * tip_in_tool;
                (place.coords, trial.tip_error_in_crf_mm, *weight)
            })
            .collect();
        let weights: f64 = kept.iter().map(|k| k.2).sum();
        let mean_mm = kept.iter().map(|k| k.0 * k.2).sum::<Vector3<f64>>() / weights;
        let mut at = Self {
            scenario,
            crf,
            sensor,
            readings,
            tracker_from_crf_fitted: reference.fit.tracker_from_body,
            weights,
            squares_mm2: 0.0,
            mean_mm,
            error_sum_mm: Vector3::zeros(),
            error_by_place: Matrix3::zeros(),
            place_by_place: Matrix3::zeros(),
            work,
        };
        for (place, error, weight) in kept {
            let arm = place - mean_mm;
            at.squares_mm2 += weight * error.norm_squared();
            at.error_sum_mm += error * weight;
            at.error_by_place += error * arm.transpose() * weight;
            at.place_by_place += arm * arm.transpose() * weight;
        }
        Ok(at)
    }

    /// What making this cost.
    pub fn own_work(&self) -> Work {
        self.work
    }

    /// The study's tip RMS over the rule's poses with the sensor like this.
    pub fn found(
        &self,
        buffers: &mut RefitBuffers,
        moved: &Sensor,
        cancel: &CancelToken,
    ) -> Result<Found, Cancelled> {
        let mut body = nameless(&self.crf.body);
        body.sensors[self.sensor] = moved.clone();
        let fitter = FrameFitter::new(&body, self.scenario.orientation_weight_mm);
        let number = [self.sensor];
        let replaced = self.readings.replaced(&body, &fitter, &number, std::slice::from_ref(moved));
        let (mut is_inside, mut tracker_from_crf) = (true, Pose::identity());
        self.readings.refit(
            &replaced,
            std::iter::once(0..1),
            buffers,
            cancel,
            |_, found| {
                is_inside = found;
                true
            },
            |_, fitted| tracker_from_crf = fitted,
        )?;
        let others_are_inside = self.readings.are_inside(0, Some(self.sensor));
        let is_rejected =
            self.scenario.outside == OutsidePolicy::Reject && !(is_inside && others_are_inside);
        // From the tip as found with the design's CRF to the tip as found with this one.
        let change = tracker_from_crf.inverse() * self.tracker_from_crf_fitted;
        let turn = change.rotation.to_rotation_matrix().into_inner() - Matrix3::identity();
        let shift = turn * self.mean_mm + change.translation.vector;
        let squares_mm2 = self.squares_mm2
            + 2.0 * turn.dot(&self.error_by_place)
            + (turn * self.place_by_place).dot(&turn)
            + 2.0 * shift.dot(&self.error_sum_mm)
            + shift.norm_squared() * self.weights;
        // Below zero by rounding where all errors vanish.
        let rms_mm = (squares_mm2.max(0.0) / self.weights).sqrt();
        let is_known = self.weights > 0.0 && !is_rejected && rms_mm.is_finite();
        let tip_rms_mm = is_known.then_some(rms_mm);
        Ok(Found { tip_rms_mm, is_outside: !is_inside, variation: 0.0 })
    }
}
