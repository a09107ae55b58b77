//! Recordings that end within a row.

use super::Reader;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::recording::ToolTrack;

/// Reads a text that is cut anywhere. Behind `from` it is a recording with so many good poses at
/// least, all of them at these places along x: no number that lacks digits is taken for one.
pub(super) fn assert_cut_keeps_places(
    text: &str,
    (from, least): (usize, usize),
    x_mm: [f64; 2],
    parse: Reader,
) {
    for end in 0..text.len() {
        let found = parse(&text.as_bytes()[..end]);
        if end > from {
            let tools = found.unwrap().tools;
            let good: Vec<&Pose> = tools.iter().flat_map(ToolTrack::good).collect();
            let are_known = good.iter().all(|pose| x_mm.contains(&pose.translation.x));
            assert!(good.len() >= least && are_known, "{end}");
        }
    }
}
