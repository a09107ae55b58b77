//! The error along a tool's long axis: how far off a point of interest is that lies on the shaft,
//! from the tip to the rearmost sensor.
//!
//! A trial displaces a point `p` of the tool by `F̂ p − F p`. Along the line `p = tip + s u` that is
//! `a + s b` with `a` the error of the tip and `b = (R̂ − R) u`, so that the mean square over a study
//! is `mean |a|² + 2 s mean(a·b) + s² mean |b|²`: three sums a study, and no further frame fit. It
//! has one minimum and grows away from it, as a target registration error does.

use super::body::RigidBody;
use super::shaft::shaft_in_body;
use super::trial::Trial;
use nalgebra::{Unit, Vector3};

/// RMS error of a study at every point of the shaft.
#[derive(Clone, Debug, PartialEq)]
pub struct AlongShaft {
    /// From the tip.
    pub axis_in_tool: Unit<Vector3<f64>>,
    /// From the tip to the rearmost sensor, along the axis.
    pub length_mm: f64,
    /// How far from the tip each sensor lies along the axis, in the body's order.
    pub sensors_mm: Vec<f64>,
    /// `mean |a|²`, `mean(a·b)` and `mean |b|²`.
    moments: [f64; 3],
}

impl AlongShaft {
    /// RMS error of the point so far from the tip, mm.
    pub fn rms_mm(&self, from_tip_mm: f64) -> f64 {
        let [tip, mixed, slope] = self.moments;
        // Round-off can leave less than nothing where there is no error.
        (tip + from_tip_mm * (2.0 * mixed + from_tip_mm * slope)).max(0.0).sqrt()
    }

    /// Distances from the tip and the RMS error there, at so many points from tip to rearmost
    /// sensor; mm.
    pub fn curve(&self, points: usize) -> Vec<(f64, f64)> {
        let steps = points.max(2) - 1;
        let at = |k: usize| self.length_mm * k as f64 / steps as f64;
        (0..=steps).map(|k| (at(k), self.rms_mm(at(k)))).collect()
    }
}

/// What a curve is summed up from, trial by trial.
#[derive(Clone, Debug)]
pub(super) struct AlongShaftSums {
    axis_in_tool: Unit<Vector3<f64>>,
    sensors_mm: Vec<f64>,
    sums: [f64; 3],
    trials: usize,
}

impl AlongShaftSums {
    /// `None` of a body without a shaft.
    pub fn new(tool: &RigidBody) -> Option<Self> {
        let axis_in_tool = shaft_in_body(tool)?;
        let tip = tool.judged_tip_in_body();
        let along = |at: &nalgebra::Point3<f64>| axis_in_tool.dot(&(at - tip));
        Some(Self {
            axis_in_tool,
            sensors_mm: tool.sensors.iter().map(|s| along(&s.position_in_body)).collect(),
            sums: [0.0; 3],
            trials: 0,
        })
    }

    /// Adds a trial that enters the figures.
    pub fn add(&mut self, trial: &Trial) {
        let (tip, axis) = (trial.tip_error_in_crf_mm, &self.axis_in_tool);
        let slope = trial.crf_from_tool_simulated.rotation * axis.as_ref()
            - trial.crf_from_tool.rotation * axis.as_ref();
        let of_trial = [tip.norm_squared(), tip.dot(&slope), slope.norm_squared()];
        self.sums = std::array::from_fn(|k| self.sums[k] + of_trial[k]);
        self.trials += 1;
    }

    /// The curve; `None` without a trial, and where no sensor is behind the tip.
    pub fn finish(self) -> Option<AlongShaft> {
        let length_mm = self.sensors_mm.iter().copied().fold(0.0, f64::max);
        (self.trials > 0 && length_mm > 0.0).then(|| AlongShaft {
            axis_in_tool: self.axis_in_tool,
            length_mm,
            sensors_mm: self.sensors_mm,
            moments: self.sums.map(|sum| sum / self.trials as f64),
        })
    }
}
