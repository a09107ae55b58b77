//! The offset between the clocks of two trackers that saw the same body move.
//!
//! How fast a rigid body turns is the same for every sensor on it and in every frame, and how fast a
//! point of it moves is nearly the same for points that are near each other. So these two speeds of
//! each sensor are laid over those of the reference, before anything is known of where anything is.
//!
//! For signals that differ by noise of unknown strength the likelihood of a shift is
//! `−n/2 Σ ln(1 − c²)` with `c` the correlation of each signal: one that was not moved, or drowns
//! in noise, has no weight. The best shift is looked for on a grid, then on a finer one around it,
//! then by a parabola through the three best.

use super::pose_stream::PoseStream;
use trackwright_geometry::pose::{Pose, distances};

/// What a shift has to have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlignmentSettings {
    /// Longest time between two samples that poses are interpolated across.
    pub max_gap_s: f64,
}

impl AlignmentSettings {
    pub const MAX_GAP_S: f64 = 0.2;
}

impl Default for AlignmentSettings {
    fn default() -> Self {
        Self { max_gap_s: Self::MAX_GAP_S }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeAlignment {
    /// The reference's time is the EM tracker's plus this.
    pub offset_s: f64,
    pub correlation: f64,
    /// Offset of the second half less that of the first: clocks that differ; `None` where unknown.
    pub drift_s: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AlignmentError {
    #[error(
        "too short to be aligned in time: {found_s:.2} s, expected at least {needed_s:.1} s of both trackers"
    )]
    TooShort { found_s: f64, needed_s: f64 },
    #[error(
        "the two trackers' speeds do not agree at any offset: correlation {found:.2} at best, expected at least \
         {needed:.2}; do the files belong together, did the body move, do the clocks tick as stated?"
    )]
    NothingInCommon { found: f64, needed: f64 },
    #[error(
        "the motion repeats itself: offsets of {first_s:.2} s and {second_s:.2} s fit about as well; move the body \
         less evenly"
    )]
    Ambiguous { first_s: f64, second_s: f64 },
}

/// Shortest stream, and shortest overlap.
const MIN_S: f64 = 1.0;

/// Part of the shorter stream that has to overlap: beyond it chance correlates.
const MIN_OVERLAP: f64 = 0.5;

/// Time over which speeds are taken. Trackers' jitter over shorter times drowns slow turns (0.1° over
/// 0.1 s is 1° a second); a hand changes its speed no faster. Of four recorded paths all are aligned
/// with anything from 0.15 to 0.6 s.
const WINDOW_S: f64 = 0.3;

/// Least correlation: four recorded paths have 0.97 to 1.00, and at wrong shifts 0.5.
const MIN_CORRELATION: f64 = 0.7;

/// Part of the likelihood that makes a second peak as good; four recorded paths have 0.07.
const RIVAL: f64 = 0.5;

/// Points of a coarse signal: shifts take time with its square.
const COARSE_POINTS: f64 = 2048.0;

/// Finest grid: below it, speeds over a window do not change.
const FINE_STEP_S: f64 = 0.01;

/// Points of a fine signal.
const FINE_POINTS: f64 = 16_384.0;

/// Correlation is held below this, so that exact copies have a likelihood.
const FULL: f64 = 1.0 - 1e-12;

/// Lays the streams of all sensors together over that of the reference.
pub fn align(
    sensors: &[PoseStream],
    reference: &PoseStream,
    settings: &AlignmentSettings,
) -> Result<TimeAlignment, AlignmentError> {
    let found_s = sensors.iter().map(length_s).fold(0.0, f64::max).min(length_s(reference));
    if found_s < MIN_S {
        return Err(AlignmentError::TooShort { found_s, needed_s: MIN_S });
    }
    let longest_s = sensors.iter().map(length_s).fold(length_s(reference), f64::max);
    let coarse = Speeds::new(
        sensors,
        reference,
        (longest_s / COARSE_POINTS).max(2.0 * FINE_STEP_S),
        settings,
    );
    let all = coarse.likelihoods(coarse.every_shift());
    let best = peak(&all)
        .ok_or(AlignmentError::NothingInCommon { found: 0.0, needed: MIN_CORRELATION })?;
    if best.correlation < MIN_CORRELATION {
        return Err(AlignmentError::NothingInCommon {
            found: best.correlation,
            needed: MIN_CORRELATION,
        });
    }
    if let Some(second) = rival(&all, &best, coarse.step_s) {
        return Err(AlignmentError::Ambiguous {
            first_s: best.shift as f64 * coarse.step_s,
            second_s: second as f64 * coarse.step_s,
        });
    }
    let fine =
        Speeds::new(sensors, reference, (longest_s / FINE_POINTS).max(FINE_STEP_S), settings);
    let near_s = best.shift as f64 * coarse.step_s;
    let (offset_s, correlation) =
        fine.refined(near_s, 2.0 * coarse.step_s, None).unwrap_or((near_s, best.correlation));
    let half = |second: bool| fine.refined(offset_s, WINDOW_S, Some(second));
    let drift_s = match (half(false), half(true)) {
        (Some((first_s, a)), Some((second_s, b))) if a.min(b) >= MIN_CORRELATION => {
            Some(second_s - first_s)
        }
        _ => None,
    };
    Ok(TimeAlignment { offset_s, correlation, drift_s })
}

fn length_s(stream: &PoseStream) -> f64 {
    stream.span_s().map_or(0.0, |(first, last)| last - first)
}

#[derive(Clone, Copy, Debug)]
struct Shift {
    shift: i64,
    likelihood: f64,
    correlation: f64,
}

fn peak(all: &[Shift]) -> Option<Shift> {
    let top = all.iter().max_by(|a, b| a.likelihood.total_cmp(&b.likelihood));
    top.copied().filter(|top| top.likelihood > 0.0)
}

/// The shift of another peak that is nearly as good, if there is one.
fn rival(all: &[Shift], best: &Shift, step_s: f64) -> Option<i64> {
    let apart = (2.0 * WINDOW_S / step_s).ceil() as i64;
    let is_peak =
        |w: &[Shift]| w[1].likelihood >= w[0].likelihood && w[1].likelihood > w[2].likelihood;
    all.windows(3)
        .filter(|w| is_peak(w) && (w[1].shift - best.shift).abs() > apart)
        .filter(|w| w[1].likelihood > RIVAL * best.likelihood)
        .max_by(|a, b| a[1].likelihood.total_cmp(&b[1].likelihood))
        .map(|w| w[1].shift)
}

/// The speed of something at the points of a grid; `NaN` where it is not known.
struct Signal {
    first: i64,
    values: Vec<f64>,
}

/// Speeds of all sensors and of the reference: turning, then moving.
struct Speeds {
    step_s: f64,
    sensors: Vec<[Signal; 2]>,
    reference: [Signal; 2],
}

impl Speeds {
    fn new(
        sensors: &[PoseStream],
        reference: &PoseStream,
        step_s: f64,
        settings: &AlignmentSettings,
    ) -> Self {
        let window_s = WINDOW_S.max(2.0 * step_s);
        let of = |stream: &PoseStream| speeds(stream, step_s, window_s, settings.max_gap_s);
        Self { step_s, sensors: sensors.iter().map(of).collect(), reference: of(reference) }
    }

    fn every_shift(&self) -> std::ops::RangeInclusive<i64> {
        let ends = |s: &Signal| (s.first, s.first + s.values.len() as i64);
        let (from, to) = ends(&self.reference[0]);
        let (mut low, mut high) = (0, 0);
        for (first, last) in self.sensors.iter().map(|s| ends(&s[0])) {
            low = low.min(from - last);
            high = high.max(to - first);
        }
        low..=high
    }

    fn likelihoods(&self, shifts: std::ops::RangeInclusive<i64>) -> Vec<Shift> {
        shifts.map(|shift| self.shifted(shift, None)).collect()
    }

    /// What speaks for a shift, by all of the reference or one half of it.
    fn shifted(&self, shift: i64, second_half: Option<bool>) -> Shift {
        let count = self.reference[0].values.len();
        let part = match second_half {
            None => 0..count,
            Some(false) => 0..count / 2,
            Some(true) => count / 2..count,
        };
        let longest = self.sensors.iter().map(|s| s[0].values.len()).max();
        let whole = longest.unwrap_or(0).min(part.len()) as f64;
        let (mut likelihood, mut correlation) = (0.0, 0.0_f64);
        for sensor in &self.sensors {
            for (a, b) in sensor.iter().zip(&self.reference) {
                let (c, overlap) = correlate(a, b, shift, part.clone());
                if (overlap as f64) < MIN_OVERLAP * whole || c <= 0.0 {
                    continue;
                }
                let c = c.min(FULL);
                likelihood -= overlap as f64 / whole * (1.0 - c * c).ln();
                correlation = correlation.max(c);
            }
        }
        Shift { shift, likelihood, correlation }
    }

    /// The best offset within `around_s` of another, and the correlation there.
    fn refined(&self, near_s: f64, around_s: f64, second_half: Option<bool>) -> Option<(f64, f64)> {
        let steps = |s: f64| (s / self.step_s).round() as i64;
        let reach = steps(around_s).max(2);
        let near = steps(near_s);
        let all: Vec<Shift> =
            (near - reach..=near + reach).map(|shift| self.shifted(shift, second_half)).collect();
        let best = peak(&all)?;
        let of = |shift: i64| self.shifted(shift, second_half).likelihood;
        let (before, after) = (of(best.shift - 1), of(best.shift + 1));
        let bend = before - 2.0 * best.likelihood + after;
        let part = if bend < 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
        Some(((best.shift as f64 + part) * self.step_s, best.correlation))
    }
}

/// Speeds at the points of a grid through time 0, from poses half a window before and after.
fn speeds(stream: &PoseStream, step_s: f64, window_s: f64, max_gap_s: f64) -> [Signal; 2] {
    let half_s = 0.5 * window_s;
    let (start_s, end_s) = stream.span_s().unwrap_or((0.0, -1.0));
    let first = ((start_s + half_s) / step_s).ceil() as i64;
    let last = ((end_s - half_s) / step_s).floor() as i64;
    let [mut turning, mut moving] = [Vec::new(), Vec::new()];
    for point in first..=last {
        let time_s = point as f64 * step_s;
        let ends: Option<(Pose, Pose)> =
            stream.at(time_s - half_s, max_gap_s).zip(stream.at(time_s + half_s, max_gap_s));
        let (way, turn) = ends.map_or((f64::NAN, f64::NAN), |(a, b)| distances(&a, &b));
        turning.push(turn / window_s);
        moving.push(way / window_s);
    }
    [turning, moving].map(|values| Signal { first, values })
}

/// Pearson's correlation over the points that both have, and their number; `part` of the second
/// signal counts, which is shifted against the first by so many points.
fn correlate(a: &Signal, b: &Signal, shift: i64, part: std::ops::Range<usize>) -> (f64, usize) {
    // Point k of `b` lies over point k + by of `a`.
    let by = b.first - shift - a.first;
    let from = (part.start as i64).max(-by).max(0);
    let to = (part.end as i64).min(a.values.len() as i64 - by);
    let pairs = || {
        (from..to).filter_map(move |k| {
            let (x, y) = (*a.values.get((k + by) as usize)?, *b.values.get(k as usize)?);
            (x.is_finite() && y.is_finite()).then_some((x, y))
        })
    };
    let (mut count, mut sum_x, mut sum_y) = (0_usize, 0.0, 0.0);
    for (x, y) in pairs() {
        count += 1;
        sum_x += x;
        sum_y += y;
    }
    if count < 3 {
        return (0.0, count);
    }
    let (mean_x, mean_y) = (sum_x / count as f64, sum_y / count as f64);
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for (x, y) in pairs() {
        let (x, y) = (x - mean_x, y - mean_y);
        xx += x * x;
        yy += y * y;
        xy += x * y;
    }
    let c = xy / (xx * yy).sqrt();
    (if c.is_finite() { c } else { 0.0 }, count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose_stream::Clock;
    use nalgebra::Vector3;
    use trackwright_field::random_models::Seeded;
    use trackwright_geometry::pose::pose_from_parts;
    use trackwright_geometry::rotation::exp_vector;
    use trackwright_simulation::recording::{ToolTrack, TrackSample};

    /// A hand's path: sums of slow waves that do not repeat themselves.
    fn body(time_s: f64) -> Pose {
        let wave = |hz: f64, phase: f64| (std::f64::consts::TAU * hz * time_s + phase).sin();
        let at = Vector3::new(
            60.0 * wave(0.21, 0.0) + 20.0 * wave(0.53, 1.0),
            50.0 * wave(0.17, 2.0),
            -1000.0 + 40.0 * wave(0.37, 0.5),
        );
        let turn = Vector3::new(
            0.5 * wave(0.13, 1.0),
            0.4 * wave(0.31, 0.3) + 0.1 * wave(0.71, 0.0),
            0.3 * wave(0.19, 2.0),
        );
        pose_from_parts(at, exp_vector(&turn))
    }

    /// Samples of a path at so many a second, from a start, each seen through `read`.
    fn stream(
        (start_s, length_s, hz): (f64, f64, f64),
        of: impl Fn(f64) -> Pose,
        mut read: impl FnMut(Pose) -> Pose,
    ) -> PoseStream {
        let samples: Vec<TrackSample> = (0..(length_s * hz) as u32)
            .map(|k| f64::from(k) / hz)
            .map(|time_s| TrackSample {
                frame: None,
                time_s: Some(time_s),
                pose: Ok(read(of(start_s + time_s))),
            })
            .collect();
        let track = ToolTrack { name: "t".to_owned(), samples };
        Clock::Times.stream(&track, &track.samples[0]).0
    }

    const SETTINGS: AlignmentSettings = AlignmentSettings { max_gap_s: 0.2 };

    #[test]
    fn an_offset_is_found_without_registration() {
        for seed in 0..6 {
            let mut noise = Seeded::new(seed);
            let (tracker, sensor) = (noise.pose_within(700.0), noise.pose_within(20.0));
            // The EM tracker began this much later, so its clock is behind.
            let offset_s = [-3.217, -0.4, 0.0, 0.0313, 1.9, 4.4][seed as usize];
            let em = stream((5.0 + offset_s, 20.0, 40.0), body, |pose| {
                noise.around(&(tracker * pose * sensor), 0.05, 0.001)
            });
            let mut noise = Seeded::new(50 + seed);
            let reference = stream((5.0, 22.0, 20.0), body, |p| noise.around(&p, 0.02, 0.0005));
            let found = align(&[em], &reference, &SETTINGS).unwrap();
            // A speed over 0.3 s has noise √2 σ / 0.3, of 0.005 and 0.26 rad/s² and mm/s; speeds here
            // change by 0.3 rad/s² and 60 mm/s². 20 s have some 60 independent windows, so the speed of
            // turning alone determines the offset to 0.005 / 0.3 / √60 = 2 ms.
            assert!((found.offset_s - offset_s).abs() < 0.008, "{offset_s}: {found:?}");
            assert!(found.correlation > 0.99);
            // Halves have a few independent windows less, and two of them are compared.
            assert!(found.drift_s.unwrap().abs() < 0.016, "{found:?}");
        }
    }

    #[test]
    fn a_clock_that_jumps_ahead_shows_as_a_drift() {
        let jump = |time_s: f64| body(if time_s > 12.0 { time_s + 0.1 } else { time_s });
        let em = stream((2.0, 20.0, 40.0), jump, |pose| pose);
        let reference = stream((2.0, 20.0, 20.0), body, |pose| pose);
        let found = align(&[em], &reference, &SETTINGS).unwrap();
        assert!((found.drift_s.unwrap() - 0.1).abs() < 0.02, "{found:?}");
    }

    #[test]
    fn what_cannot_be_aligned_states_why() {
        let span = (0.0, 20.0, 20.0);
        let reference = stream(span, body, |pose| pose);
        let short = stream((0.0, 0.8, 40.0), body, |pose| pose);
        assert!(matches!(
            align(&[short], &reference, &SETTINGS),
            Err(AlignmentError::TooShort { found_s, .. }) if found_s < 0.8
        ));
        let mut noise = Seeded::new(1);
        let still = stream(span, |_| Pose::identity(), |p| noise.around(&p, 0.05, 0.001));
        assert!(matches!(
            align(&[still], &reference, &SETTINGS),
            Err(AlignmentError::NothingInCommon { found, .. }) if found < 0.7
        ));
        let shaken = |time_s: f64| {
            let turn = Vector3::x() * (std::f64::consts::TAU * 0.25 * time_s).sin();
            pose_from_parts(turn * 50.0, exp_vector(&turn))
        };
        let [a, b] = [0.0, 0.3].map(|start_s| stream((start_s, 20.0, 40.0), shaken, |p| p));
        let error = align(&[a], &b, &SETTINGS).unwrap_err();
        assert!(matches!(error, AlignmentError::Ambiguous { .. }), "{error}");
    }
}
