//! Which of a patient's directions the tracker's axes stand for.
//!
//! Files for 3D Slicer are in LPS (x to the left, y to the back, z to the head), and Slicer itself is
//! in RAS. Its OpenIGTLink module takes the numbers of a live pose as RAS as they are.

use nalgebra::{Matrix3, Point3, Vector3};
use trackwright_geometry::pose::Pose;

/// What the tracker's x, y and z become.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PatientAxes {
    /// Slicer's own right, anterior, superior, as live poses do: x and y change their sign in files.
    #[default]
    Ras,
    /// Left, posterior, superior, as in files: every number stays.
    Lps,
}

impl PatientAxes {
    /// What x, y and z of the tracker are multiplied by in a file.
    pub fn signs(self) -> [f64; 3] {
        match self {
            Self::Ras => [-1.0, -1.0, 1.0],
            Self::Lps => [1.0; 3],
        }
    }

    /// A vector of the tracker frame, in a file; zero stays without a sign.
    pub fn lps(self, in_tracker: &Vector3<f64>) -> [f64; 3] {
        let signs = self.signs();
        [0, 1, 2].map(|k| signs[k] * in_tracker[k] + 0.0)
    }

    pub fn lps_point(self, in_tracker: &Point3<f64>) -> [f64; 3] {
        self.lps(&in_tracker.coords)
    }

    /// A body's axes as the columns of a matrix, in a file.
    pub fn lps_axes(self, tracker_from_body: &Pose) -> Matrix3<f64> {
        let turn = tracker_from_body.rotation.to_rotation_matrix();
        Matrix3::from_diagonal(&self.signs().into()) * turn.matrix()
    }
}
