//! Logs of one line a sample: `SensorID: 1 Position: (x, y, z) Orientation: (…) Time: …`, as small
//! programs around a tracker's library write them.
//!
//! Such a file does not state which of four numbers is a quaternion's scalar. Its sign does where
//! programs keep it from being negative, as nearly all do; else the log is refused.

use super::rows::{Tools, pose};
use crate::error::{FormatError, quoted, text};
use crate::matrices::nearest_rotation;
use nalgebra::{Matrix3, Vector3};
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_simulation::recording::{Recording, TrackSample, Unusable};

/// Samples that determine the order of quaternions by their signs.
const MIN_SIGNED: usize = 20;

/// Beyond this a number stands for a missing reading.
const MISSING: f64 = 1e27;

/// How far a rotation matrix may be from one, as logs of four digits are.
const MAX_OFF: f64 = 1e-2;

/// Times above are nanoseconds.
const MAX_SECONDS: f64 = 1e12;

/// Whether a line is a sample of such a log.
pub fn is_sample(line: &str) -> bool {
    let line = line.to_ascii_lowercase();
    line.contains("position:") && (line.contains("orientation:") || line.contains("quaternion:"))
}

/// The content of a line.
struct Sample {
    line: u64,
    sensor: String,
    time_s: Option<f64>,
    position: Vec<f64>,
    orientation: Vec<f64>,
}

/// Which number of four is the scalar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scalar {
    First,
    Last,
}

/// Reads a log.
///
/// # Errors
/// Lines that are no samples, orientations of three angles, quaternions whose order nothing shows,
/// no rows.
pub fn parse(bytes: &[u8]) -> Result<Recording, FormatError> {
    let text = text(bytes)?;
    let mut samples = Vec::new();
    let mut lines = (1..).zip(text.lines()).peekable();
    while let Some((line, content)) = lines.next() {
        match sample(line, content) {
            Some(sample) => samples.push(sample),
            None if content.trim().is_empty() || content.trim_start().starts_with('#') => {}
            // As a program that crashed leaves it.
            None if lines.peek().is_none() && !text.ends_with('\n') => {}
            None => {
                let expected = "a sample: Position: x y z Orientation: …";
                return Err(FormatError::line(line, quoted(content), expected));
            }
        }
    }
    let scalar = scalar(&samples)?;
    let mut tools = Tools::default();
    for sample in samples {
        let pose = sample.pose(scalar);
        tools.push(&sample.sensor, TrackSample { frame: None, time_s: sample.time_s, pose });
    }
    tools.finish()
}

/// Labels, each with what stands behind it.
fn sample(line: u64, content: &str) -> Option<Sample> {
    let is_between = |c: char| c.is_whitespace() || "(),;[]{}=".contains(c);
    let content = content.replace(':', ": ");
    let mut values: Vec<(String, Vec<&str>)> = Vec::new();
    for word in content.split(is_between).filter(|word| !word.is_empty()) {
        match (word.strip_suffix(':'), values.last_mut()) {
            (Some(label), _) => values.push((label.to_ascii_lowercase(), Vec::new())),
            (None, Some((_, words))) => words.push(word),
            (None, None) => {}
        }
    }
    let find = |labels: &[&str]| {
        let is_it = |(label, _): &&(String, Vec<&str>)| labels.contains(&label.as_str());
        values.iter().find(is_it).map(|(_, words)| words)
    };
    let numbers = |words: &Vec<&str>| -> Vec<f64> {
        words.iter().filter_map(|word| word.parse().ok()).collect()
    };
    let sensor = find(&["sensorid", "sensor", "id", "tool", "port", "handle"]);
    let time =
        find(&["networktime", "time", "timestamp"]).and_then(|w| numbers(w).first().copied());
    Some(Sample {
        line,
        sensor: sensor.map_or_else(|| "1".to_owned(), |words| words.join(" ")),
        time_s: time.map(|t| if t > MAX_SECONDS { t * 1e-9 } else { t }),
        position: numbers(find(&["position"])?),
        orientation: numbers(find(&["orientation", "quaternion"])?),
    })
}

/// The order of all quaternions of a log; any where there are none.
fn scalar(samples: &[Sample]) -> Result<Scalar, FormatError> {
    let four: Vec<[f64; 4]> =
        samples.iter().filter_map(|sample| sample.orientation.as_slice().try_into().ok()).collect();
    let wrong = |found: String| {
        let expected = "quaternions of which the signs show the scalar, rotation matrices \
            (9 numbers), or a poses table with the columns x, y, z, qw, qx, qy, qz";
        let line = samples.first().map_or(1, |sample| sample.line);
        Err(FormatError::line(line, found, expected))
    };
    if let Some(angles) = samples.iter().find(|s| s.orientation.len() == 3) {
        return wrong(format!(
            "orientations of 3 numbers (line {}), angles whose order and unit the log does not state",
            angles.line
        ));
    }
    if four.is_empty() {
        return Ok(Scalar::First);
    }
    let negative = |k: usize| four.iter().filter(|q| q[k] < 0.0).count();
    let is_zero = |k: usize| four.iter().all(|q| q[k] == 0.0);
    let is_signed = |k: usize| four.len() >= MIN_SIGNED && 10 * negative(k) >= four.len();
    match (negative(0), negative(3)) {
        // Sensors without a roll: z is zero throughout.
        _ if is_zero(3) && !is_zero(0) => Ok(Scalar::First),
        (0, _) if is_signed(3) => Ok(Scalar::First),
        (_, 0) if is_signed(0) => Ok(Scalar::Last),
        (first, last) => wrong(format!(
            "{} orientations of 4 numbers, the first negative in {first}, the last in {last}: which is the scalar is not stated",
            four.len()
        )),
    }
}

impl Sample {
    fn pose(&self, scalar: Scalar) -> Result<Pose, Unusable> {
        let &[x, y, z] = self.position.as_slice() else {
            return Err(Unusable::NoPose);
        };
        let is_missing = |value: &f64| value.abs() > MISSING;
        if self.position.iter().chain(&self.orientation).any(is_missing) {
            return Err(Unusable::Missing);
        }
        match (self.orientation.as_slice(), scalar) {
            (&[w, i, j, k], Scalar::First) | (&[i, j, k, w], Scalar::Last) => {
                pose([x, y, z], [w, i, j, k])
            }
            (nine, _) if nine.len() == 9 => {
                let (rotation, off) = nearest_rotation(&Matrix3::from_row_slice(nine));
                match off <= MAX_OFF && [x, y, z].iter().all(|v| v.is_finite()) {
                    true => Ok(pose_from_parts(Vector3::new(x, y, z), rotation)),
                    false => Err(Unusable::NoPose),
                }
            }
            _ => Err(Unusable::NoPose),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines of a sensor that turns, with the scalar where it is requested.
    fn log(is_last: bool) -> String {
        let line = |k: u32| {
            let (sine, cosine) = (0.05 * f64::from(k) - 1.5).sin_cos();
            let (w, x) = (cosine, sine);
            match is_last {
                false => format!(
                    "SensorID: 1 Position: ({k}, 2, -300) Orientation: ({w}, {x}, 0, 0.0001) Time: {k}\n"
                ),
                true => format!(
                    "SensorID: 1 Position: {k} 2 -300 Orientation: 0 {x} 0.0001 {w} Quality: 0.1\n"
                ),
            }
        };
        (0..60).map(line).collect()
    }

    #[test]
    fn the_scalar_is_recognised_by_its_sign() {
        // Turned about x by a log with the scalar first, about y by one with it last.
        let mut first = log(false);
        first = first.replace("0.0001)", "-0.0001)");
        let found = parse(first.as_bytes()).unwrap();
        let pose = found.tools[0].samples[0].pose.clone().unwrap();
        assert!((pose.rotation.angle() - 3.0).abs() < 1e-3);
        assert!(pose.rotation.axis().unwrap().x.abs() > 0.999);
        assert_eq!(found.tools[0].samples[7].time_s, Some(7.0));
        let signed = log(true).replace("Orientation: 0 ", "Orientation: -0.0001 ");
        let found = parse(signed.as_bytes()).unwrap();
        let pose = found.tools[0].samples[0].pose.clone().unwrap();
        assert!(pose.rotation.axis().unwrap().y.abs() > 0.999);
        assert_eq!(pose.translation.vector, Vector3::new(0.0, 2.0, -300.0));
    }

    #[test]
    fn orders_that_nothing_shows_are_refused() {
        let message = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        let one = message("SensorID: 1 Position: (1, 2, 3) Orientation: (0.5, 0.5, 0.5, 0.5)\n");
        assert!(one.contains("which is the scalar is not stated"), "{one}");
        let angles = message("SensorID: 1 Position: (1, 2, 3) Orientation: (10, 20, 30)\n");
        assert!(angles.contains("angles whose order and unit"), "{angles}");
        let prose = message("Position: 1 2 3 Orientation: 1 0 0 0\nno sample\n\n");
        assert!(prose.starts_with("line 2: found \"no sample\""), "{prose}");
    }

    #[test]
    fn matrices_and_missing_readings_are_read() {
        let log = "Sensor: a Position: 1 2 3 Orientation: 1 0 0 0 0 -1 0 1 0\n\
                   Sensor: b Position: -3.7e28 -3.7e28 -3.7e28 Orientation: 1 0 0 0 1 0 0 0 1\n";
        let found = parse(log.as_bytes()).unwrap();
        let pose = found.tools[0].samples[0].pose.clone().unwrap();
        let moved = pose.rotation * Vector3::y();
        assert!((moved - Vector3::z()).norm() < 1e-12);
        assert_eq!(found.tools[1].samples[0].pose, Err(Unusable::Missing));
    }
}
