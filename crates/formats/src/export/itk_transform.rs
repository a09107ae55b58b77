//! Rigid transforms as ITK's text files (`*.tfm`), which 3D Slicer reads.
//!
//! ITK keeps transforms as resampling needs them, from the space of the result to that of the
//! moved: the file of a tool's pose holds `tool_from_tracker`, and Slicer inverts it on reading, so
//! that what is under the transform moves by `tracker_from_tool`.

use super::patient_axes::PatientAxes;
use nalgebra::Matrix3;
use std::io::{self, Write};
use trackwright_geometry::number::shortest;
use trackwright_geometry::pose::Pose;

/// Writes the pose of one frame in another so that Slicer moves what is in the first by it.
///
/// Both frames have the same axes: with [`PatientAxes::Ras`] the matrix is `F M⁻¹ F` with
/// `F = diag(-1, -1, 1)`.
pub fn write(out: &mut dyn Write, target_from_source: &Pose, axes: PatientAxes) -> io::Result<()> {
    let source_from_target = target_from_source.inverse();
    let flip = Matrix3::from_diagonal(&axes.signs().into());
    let turn = flip * source_from_target.rotation.to_rotation_matrix().matrix() * flip;
    let shift = axes.lps(&source_from_target.translation.vector);
    // Row by row, then the shift.
    let numbers: Vec<String> =
        turn.transpose().iter().chain(&shift).map(|v| shortest(v + 0.0)).collect();
    write!(
        out,
        "#Insight Transform File V1.0\n\
         #Transform 0\n\
         Transform: AffineTransform_double_3_3\n\
         Parameters: {}\n\
         FixedParameters: 0 0 0\n",
        numbers.join(" ")
    )
}
