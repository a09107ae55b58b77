//! A body that is known by its markers alone: a frame of its own, and its pose in each recording of
//! them (the probes of the Johns Hopkins course on computer-integrated surgery).

use super::registration::{RegistrationError, register};
use nalgebra::{Point3, Vector3};
use trackwright_geometry::pose::Pose;

/// Markers in a frame of their own.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerBody {
    /// Around their mean, with the axes of the recording that they are from, mm.
    pub markers_in_body: Vec<Point3<f64>>,
}

/// A recording that does not determine the body's pose.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("frame {frame}: {source}")]
pub struct MarkerPoseError {
    pub frame: usize,
    pub source: RegistrationError,
}

impl MarkerBody {
    /// From where a tracker sees the markers once.
    pub fn seen_at(markers: &[Point3<f64>]) -> Self {
        let sum: Vector3<f64> = markers.iter().map(|marker| marker.coords).sum();
        let mean = sum / markers.len().max(1) as f64;
        Self { markers_in_body: markers.iter().map(|marker| marker - mean).collect() }
    }

    /// `tracker_from_body` in each frame, or the first frame whose markers determine no pose.
    pub fn poses(&self, frames: &[Vec<Point3<f64>>]) -> Result<Vec<Pose>, MarkerPoseError> {
        frames
            .iter()
            .enumerate()
            .map(|(frame, markers)| {
                register(&self.markers_in_body, markers)
                    .map(|found| found.target_from_source)
                    .map_err(|source| MarkerPoseError { frame, source })
            })
            .collect()
    }
}

/// What an optical tracker sees at once, mm, optical frame: markers of a base and of a tool.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseAndTool {
    pub on_base: Vec<Point3<f64>>,
    pub on_tool: Vec<Point3<f64>>,
}

/// The tool's markers in the base's frame, or the first frame whose base determines no pose.
pub fn in_base(
    markers_in_base: &[Point3<f64>],
    frames: &[BaseAndTool],
) -> Result<Vec<Vec<Point3<f64>>>, MarkerPoseError> {
    frames
        .iter()
        .enumerate()
        .map(|(frame, seen)| {
            let optical_from_base = register(markers_in_base, &seen.on_base)
                .map_err(|source| MarkerPoseError { frame, source })?
                .target_from_source;
            let base_from_optical = optical_from_base.inverse();
            Ok(seen.on_tool.iter().map(|at| base_from_optical * at).collect())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_geometry::pose::pose_from_array;

    #[test]
    fn moved_markers_move_the_pose() {
        let markers = [[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [0.0, 30.0, 6.0]].map(Point3::from);
        let moved = pose_from_array([1.0, -2.0, 300.0, 0.8, 0.0, 0.6, 0.0]).unwrap();
        let frames = [markers.to_vec(), markers.iter().map(|marker| moved * marker).collect()];
        let poses = MarkerBody::seen_at(&markers).poses(&frames).unwrap();
        let mean = Vector3::new(10.0, 10.0, 2.0);
        assert!((poses[0].translation.vector - mean).norm() < 1e-12);
        assert!(poses[0].rotation.angle() < 1e-12);
        assert!(((poses[1] * poses[0].inverse()) * markers[2] - moved * markers[2]).norm() < 1e-10);
    }

    #[test]
    fn a_frame_whose_markers_are_on_a_line_is_named() {
        let markers = [[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [0.0, 30.0, 6.0]].map(Point3::from);
        let line = [0.0, 1.0, 2.0].map(|x| Point3::new(x, 0.0, 0.0));
        let frames = [markers.to_vec(), line.to_vec()];
        let error = MarkerBody::seen_at(&markers).poses(&frames).unwrap_err();
        assert_eq!(error.frame, 1);
        assert!(matches!(error.source, RegistrationError::Collinear { .. }));
    }
}
