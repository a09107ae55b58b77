//! What trackers record over time.

use super::read;
use trackwright_formats::recording::live_table::{HEADER, LiveSample, write_row};
use trackwright_formats::recording::{is_recording, parse};
use trackwright_geometry::pose::pose_to_array;
use trackwright_simulation::recording::Recording;

/// A recording in any format, recognised by its first lines: it has no more samples than twice its
/// bytes, every pose is one, and written as a live recording they are read again to the bit.
pub fn recording(bytes: &[u8]) -> bool {
    let Some(recording) = read(parse(bytes)) else {
        return false;
    };
    assert!(is_recording(bytes));
    let samples: usize = recording.tools.iter().map(|tool| tool.samples.len()).sum();
    assert!(samples <= 2 * bytes.len(), "{samples}");
    let poses = poses(&recording);
    let mut table = format!("{HEADER}\n").into_bytes();
    for pose in recording.tools.iter().flat_map(|tool| tool.good()) {
        let sample = LiveSample { received_s: 0.0, time_s: None, tool: "tool", pose: Ok(*pose) };
        write_row(&mut table, &sample);
    }
    if !poses.is_empty() {
        let again = parse(&table).expect("it was written here");
        assert_eq!(self::poses(&again), poses);
    }
    true
}

fn poses(recording: &Recording) -> Vec<[f64; 7]> {
    let good = recording.tools.iter().flat_map(|tool| tool.good());
    let poses: Vec<[f64; 7]> = good.map(pose_to_array).collect();
    assert!(poses.iter().flatten().all(|v| v.is_finite()));
    poses
}
