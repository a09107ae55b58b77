//! What a recording's own registration takes up of the error, taken out of measured and predicted
//! alike.
//!
//! Frames found from the very poses that are judged fit them better than they should. To first
//! order, another place of the reference moves every tip by `t + ω × x`, another place of the tip on
//! the tool by `R s`, whatever the pose: least squares over all poses takes up the part of the error
//! that is of this form. The same projection of the prediction leaves what can be compared at all;
//! the difference of the two is unchanged by any such registration.

use super::Unknowns;
use super::rows::AgreementRow;
use nalgebra::{DMatrix, DVector, Matrix3, Point3, SymmetricEigen, Vector3};
use trackwright_geometry::pose::Pose;
use trackwright_simulation::tool_in_crf::ErrorVectors;

/// Relative eigenvalue at or below which a direction changes nothing; turns of a degree leave 1e-4.
const NOTHING: f64 = 1e-12;

/// Rows of three that a fit runs over, by column.
struct Columns {
    columns: Vec<Vec<Vector3<f64>>>,
}

/// What is unknown of some poses, as it is taken out of their errors.
pub(super) struct Taken {
    of_tips: Columns,
    of_rotations: Columns,
}

impl Taken {
    /// Of the poses of the tool in the CRF and where their tips are; `None` where nothing is unknown.
    pub fn of(poses: &[Pose], tips: &[Vector3<f64>], unknowns: Unknowns) -> Option<Self> {
        let has_reference = match unknowns {
            Unknowns::None => return None,
            Unknowns::Registration => true,
            Unknowns::Pivot => false,
        };
        let rotations: Vec<Matrix3<f64>> =
            poses.iter().map(|pose| *pose.rotation.to_rotation_matrix().matrix()).collect();
        let mut of_tips = Columns::translations(&rotations);
        if has_reference {
            of_tips.add_rotations(tips);
        }
        Some(Self { of_tips, of_rotations: Columns::translations(&rotations) })
    }

    /// Takes it out of errors at the poses.
    pub fn take_out(&self, errors: &mut [ErrorVectors]) {
        let (mut tips, mut turns): (Vec<_>, Vec<_>) =
            errors.iter().map(|error| (error.tip_mm, error.rotation_rad)).unzip();
        self.of_tips.take_out(&mut tips);
        self.of_rotations.take_out(&mut turns);
        for (error, (tip_mm, rotation_rad)) in errors.iter_mut().zip(tips.into_iter().zip(turns)) {
            *error = ErrorVectors { tip_mm, rotation_rad };
        }
    }
}

/// Takes out of the used rows' errors what is unknown, and returns how many numbers that was.
pub(super) fn take_out(
    rows: &mut [AgreementRow],
    tips: &[Point3<f64>],
    unknowns: Unknowns,
) -> usize {
    let used: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].is_used).collect();
    let poses: Vec<Pose> = used.iter().map(|&i| rows[i].crf_from_tool).collect();
    let tips: Vec<Vector3<f64>> = used.iter().map(|&i| tips[i].coords).collect();
    let Some(Taken { of_tips, of_rotations }) = Taken::of(&poses, &tips, unknowns) else {
        return 0;
    };
    let mut measured: Vec<_> = used.iter().map(|&i| rows[i].measured_mm).collect();
    let mut predicted: Vec<_> = used.iter().map(|&i| rows[i].predicted_mm).collect();
    let taken = of_tips.take_out(&mut measured);
    of_tips.take_out(&mut predicted);
    for (k, &i) in used.iter().enumerate() {
        rows[i].measured_mm = measured[k];
        rows[i].predicted_mm = predicted[k];
    }
    let rotation_vectors: Option<Vec<_>> = used.iter().map(|&i| rows[i].measured_rad).collect();
    if let Some(mut measured) = rotation_vectors {
        let mut predicted: Vec<_> = used.iter().map(|&i| rows[i].predicted_rad).collect();
        of_rotations.take_out(&mut measured);
        of_rotations.take_out(&mut predicted);
        for (k, &i) in used.iter().enumerate() {
            rows[i].measured_rad = Some(measured[k]);
            rows[i].predicted_rad = predicted[k];
        }
    }
    taken
}

impl Columns {
    /// The same for all poses, and the same in the tool's axes.
    fn translations(rotations: &[Matrix3<f64>]) -> Self {
        let axis = |k: usize| Vector3::ith(k, 1.0);
        let fixed = (0..3).map(|k| vec![axis(k); rotations.len()]);
        let carried = (0..3).map(|k| rotations.iter().map(|r| r * axis(k)).collect());
        Self { columns: fixed.chain(carried).collect() }
    }

    /// Turns about the middle of the tips.
    fn add_rotations(&mut self, tips: &[Vector3<f64>]) {
        let middle = tips.iter().sum::<Vector3<f64>>() / tips.len().max(1) as f64;
        for k in 0..3 {
            let axis = Vector3::ith(k, 1.0);
            let column = tips.iter().map(|tip| axis.cross(&(tip - middle))).collect();
            self.columns.push(column);
        }
    }

    /// Leaves of the vectors what the columns cannot make, and gives the columns' rank.
    fn take_out(&self, vectors: &mut [Vector3<f64>]) -> usize {
        let dot = |a: &[Vector3<f64>], b: &[Vector3<f64>]| -> f64 {
            a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
        };
        let lengths: Vec<f64> = self.columns.iter().map(|c| dot(c, c).sqrt()).collect();
        let scale = |k: usize| {
            if lengths[k] > 0.0 { 1.0 / lengths[k] } else { 0.0 }
        };
        let count = self.columns.len();
        let gram = DMatrix::from_fn(count, count, |a, b| {
            dot(&self.columns[a], &self.columns[b]) * scale(a) * scale(b)
        });
        let eigen = SymmetricEigen::new(gram);
        let largest = eigen.eigenvalues.max();
        let held: Vec<usize> =
            (0..count).filter(|&k| eigen.eigenvalues[k] > NOTHING * largest).collect();
        // Twice: the second time takes out the round-off of the first.
        for _ in 0..2 {
            let sides = DVector::from_fn(count, |k, _| dot(&self.columns[k], vectors) * scale(k));
            let mut solution = DVector::zeros(count);
            for &k in &held {
                let direction = eigen.eigenvectors.column(k);
                solution += direction * (direction.dot(&sides) / eigen.eigenvalues[k]);
            }
            for (i, vector) in vectors.iter_mut().enumerate() {
                for (k, column) in self.columns.iter().enumerate() {
                    *vector -= column[i] * (solution[k] * scale(k));
                }
            }
        }
        held.len()
    }
}
