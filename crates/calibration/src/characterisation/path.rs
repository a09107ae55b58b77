//! A path that both trackers saw: its readings at an offset of the clocks, and the offset that the
//! frames found agree with best.

use super::settings::CharacterisationSettings;
use crate::hand_eye::{self, HandEye, PairedReading, ReadingNoise};
use crate::long_run::{EffectiveSize, long_run};
use crate::pose_stream::{Clock, ClockFaults, PoseStream};
use crate::robust::Loss;
use crate::still_pose::Spread;
use crate::time_alignment::TimeAlignment;
use nalgebra::DMatrix;
use std::collections::BTreeMap;

/// How much of a path counts as one pose: readings within it share their errors.
pub(super) const SEGMENT_S: f64 = 1.0;

/// How far from the speeds' offset a better one is looked for.
const REACH_S: f64 = 0.15;

/// An offset that moves by less is settled: a sensor at 100 mm/s moves by 0.01 mm.
const SETTLED_S: f64 = 1e-4;

/// Steps of the golden section: 0.3 s to 0.01 ms.
const STEPS: usize = 22;

/// Step of the finite differences for the offset's error, below the time between two samples.
const SLOPE_STEP_S: f64 = 0.01;

/// How a path was laid over the reference's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathReport {
    /// Of the EM tracker, then of the reference.
    pub clocks: [Clock; 2],
    pub faults: ClockFaults,
    /// By speeds alone.
    pub alignment: TimeAlignment,
    /// By the poses: the reference's time less the EM tracker's, each from its first good sample.
    pub offset_s: f64,
    /// Standard error, the frames held.
    pub offset_std_error_s: f64,
    /// How many independent seconds the path has for it: neighbours are not independent.
    pub offset_effective_size: EffectiveSize,
    /// RMS errors if both recordings had begun in the same moment, and at the offset.
    pub before: Spread,
    pub after: Spread,
}

pub(super) struct PathPair {
    /// By sensor.
    pub streams: Vec<(usize, PoseStream)>,
    pub reference: PoseStream,
    pub clocks: [Clock; 2],
    pub faults: ClockFaults,
    pub alignment: TimeAlignment,
    pub offset_s: f64,
    pub first_pose: usize,
    pub max_gap_s: f64,
}

impl PathPair {
    fn start_s(&self) -> f64 {
        let spans = self.streams.iter().filter_map(|(_, s)| s.span_s());
        spans.map(|span| span.0).fold(f64::INFINITY, f64::min)
    }

    /// How many poses it counts as.
    pub fn segments(&self) -> usize {
        let spans = self.streams.iter().filter_map(|(_, s)| s.span_s());
        let end_s = spans.map(|span| span.1).fold(f64::NEG_INFINITY, f64::max);
        let last = ((end_s - self.start_s()) / SEGMENT_S).floor();
        if last >= 0.0 { last as usize + 1 } else { 0 }
    }

    /// Every sample of a sensor with the reference's pose at its time, where that has one.
    fn matched(&self, offset_s: f64) -> impl Iterator<Item = Option<PairedReading>> {
        let start_s = self.start_s();
        let samples = self.streams.iter().flat_map(|(sensor, stream)| {
            let samples = stream.samples().iter();
            samples.map(move |sample| (*sensor, sample))
        });
        samples.map(move |(sensor, (time_s, read))| {
            Some(PairedReading {
                pose: self.first_pose + ((time_s - start_s) / SEGMENT_S) as usize,
                sensor,
                reference_from_body: self.reference.at(time_s + offset_s, self.max_gap_s)?,
                tracker_from_sensor: *read,
                noise: ReadingNoise::default(),
            })
        })
    }

    /// Those samples of all sensors that the reference has a pose for.
    pub fn readings(&self, offset_s: f64) -> Vec<PairedReading> {
        self.matched(offset_s).flatten().collect()
    }

    /// Takes the offset at which the poses agree best; whether that is another one.
    pub fn refine(&mut self, found: &HandEye, settings: &CharacterisationSettings) -> bool {
        let cost = |offset_s: f64| self.mean_cost(found, settings.hand_eye.loss, offset_s);
        let near_s = self.alignment.offset_s;
        let best_s = golden(near_s - REACH_S, near_s + REACH_S, cost);
        let has_moved = (best_s - self.offset_s).abs() > SETTLED_S;
        self.offset_s = best_s;
        has_moved
    }

    fn mean_cost(&self, found: &HandEye, loss: Loss, offset_s: f64) -> f64 {
        let readings = self.readings(offset_s);
        let costs = readings.iter().map(|r| loss.cost(whitened(found, r).norm()));
        // Fewer samples have a partner at the ends of the reach.
        costs.sum::<f64>() / readings.len().max(1) as f64
    }

    pub fn report(&self, found: &HandEye, settings: &CharacterisationSettings) -> PathReport {
        let rms = |offset_s| {
            let readings = self.readings(offset_s);
            let (mut mm2, mut rad2) = (0.0, 0.0);
            for (mm, rad) in readings.iter().map(|r| found.error(r)) {
                mm2 += mm * mm;
                rad2 += rad * rad;
            }
            let count = readings.len() as f64;
            Spread { position_mm: (mm2 / count).sqrt(), angle_rad: (rad2 / count).sqrt() }
        };
        let (offset_std_error_s, offset_effective_size) =
            self.offset_error(found, settings.hand_eye.loss);
        PathReport {
            clocks: self.clocks,
            faults: self.faults,
            alignment: self.alignment,
            offset_s: self.offset_s,
            offset_std_error_s,
            offset_effective_size,
            before: rms(0.0),
            after: rms(self.offset_s),
        }
    }

    /// The sandwich of `hand_eye` for one unknown, the frames held.
    fn offset_error(&self, found: &HandEye, loss: Loss) -> (f64, EffectiveSize) {
        let [before, at, after] =
            [-SLOPE_STEP_S, 0.0, SLOPE_STEP_S].map(|step_s| self.matched(self.offset_s + step_s));
        let (mut curvature, mut gradients) = (0.0, BTreeMap::<usize, f64>::new());
        for ((before, reading), after) in before.zip(at).zip(after) {
            let (Some(before), Some(reading), Some(after)) = (before, reading, after) else {
                continue;
            };
            let slope = (whitened(found, &after) - whitened(found, &before)) / (2.0 * SLOPE_STEP_S);
            let r = whitened(found, &reading);
            let weight = loss.weight(r.norm());
            curvature += weight * slope.norm_squared();
            *gradients.entry(reading.pose).or_default() += weight * slope.dot(&r);
        }
        let scores = DMatrix::from_row_iterator(1, gradients.len(), gradients.into_values());
        let independent = &scores * scores.transpose();
        let of_sum = long_run(&scores, &independent);
        (of_sum.covariance[(0, 0)].sqrt() / curvature, of_sum.effective_size)
    }
}

/// Six components of an error in the scales of the sensor.
fn whitened(found: &HandEye, reading: &PairedReading) -> nalgebra::SVector<f64, 6> {
    hand_eye::whitened(&found.pose_error(reading), &found.scales[reading.sensor])
}

/// Where a function of one valley is least (golden section).
fn golden(mut low: f64, mut high: f64, of: impl Fn(f64) -> f64) -> f64 {
    const PART: f64 = 0.618_033_988_749_894_8;
    let mut inner = [high - PART * (high - low), low + PART * (high - low)];
    let mut values = inner.map(&of);
    for _ in 0..STEPS {
        if values[0] < values[1] {
            high = inner[1];
            inner = [high - PART * (high - low), inner[0]];
            values = [of(inner[0]), values[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + PART * (high - low)];
            values = [values[1], of(inner[1])];
        }
    }
    0.5 * (low + high)
}
