//! Takes a known lag out of a table: readings that are of a moment before, or after, the row that they stand in.

use crate::robust::median;
use nalgebra::Vector3;
use trackwright_field::samples::{Measurement, MeasurementContent};
use trackwright_geometry::pose::{Pose, interpolated, pose_from_parts};
use trackwright_geometry::rotation::{axis_rotation, exp_vector};

/// A step of so many times the median is over a gap, where the path is not known.
pub(crate) const LONGEST_STEP: f64 = 4.0;

/// Puts each reading beside the ideal pose of so many rows before (after, where negative): between the two rows
/// around that moment, or as far beyond the last row without a gap as its path goes on. Rows on both sides of
/// which are gaps stay as they are.
pub fn without_lag(
    rows: &[Measurement],
    content: MeasurementContent,
    lag_rows: f64,
) -> Vec<Measurement> {
    let ideal = |k: usize| &rows[k].tracker_from_ideal;
    let step_mm = |k: usize| {
        let [a, b] = [ideal(k), ideal(k + 1)].map(|pose| pose.translation.vector);
        (b - a).norm()
    };
    let steps = rows.len().saturating_sub(1);
    let mut steps_mm: Vec<f64> = (0..steps).map(step_mm).collect();
    let Some(typical_mm) = median(&mut steps_mm) else {
        return rows.to_vec();
    };
    let goes_on = |k: usize| k < steps && step_mm(k) <= LONGEST_STEP * typical_mm;
    let at_moment = |row: usize| -> Pose {
        let moment = row as f64 - lag_rows;
        let (before, after) = (row.checked_sub(1), Some(row));
        let sides = if lag_rows > 0.0 { [before, after] } else { [after, before] };
        let Some(mut step) = sides.into_iter().flatten().find(|step| goes_on(*step)) else {
            return *ideal(row);
        };
        // From the row towards the moment.
        while moment < step as f64 && step > 0 && goes_on(step - 1) {
            step -= 1;
        }
        while moment > (step + 1) as f64 && goes_on(step + 1) {
            step += 1;
        }
        let [from, to] = [ideal(step), ideal(step + 1)];
        let part = moment - step as f64;
        match content {
            MeasurementContent::SixDof => interpolated(from, to, part),
            _ => interpolated(from, &with_roll_of(to, from), part),
        }
    };
    let each = rows.iter().enumerate();
    each.map(|(row, m)| Measurement { tracker_from_ideal: at_moment(row), ..*m }).collect()
}

/// A pose with the same axis, turned from another's by the smallest rotation: the roll of a 5-DOF sensor is
/// anything.
fn with_roll_of(pose: &Pose, other: &Pose) -> Pose {
    let [to, from] = [pose, other].map(|pose| pose.rotation * Vector3::z_axis());
    let turn = exp_vector(&axis_rotation(&from, &to).vector_rad);
    pose_from_parts(pose.translation.vector, turn * other.rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONTENT: MeasurementContent = MeasurementContent::SixDof;

    /// Most that the hand's speed changes by from row to row: the three sines' `80 mm · ω²` together.
    const CHANGE_MM: f64 = 80.0 * (0.05 * 0.05 + 0.031 * 0.031 + 0.043 * 0.043);

    /// A step's chord is off by an eighth of that.
    const CHORD_MM: f64 = CHANGE_MM / 8.0;

    /// A straight line beyond the last step of a table, at so many rows.
    fn beyond_mm(rows: f64) -> f64 {
        CHANGE_MM * rows.abs() * (rows.abs() + 1.0) / 2.0
    }

    fn hand(t: f64) -> Pose {
        let place = Vector3::new((0.05 * t).sin(), (0.031 * t).cos(), (0.043 * t).sin()) * 80.0;
        pose_from_parts(place, exp_vector(&Vector3::new(0.01 * t, 0.5 * (0.03 * t).sin(), 0.2)))
    }

    fn rows(moments: impl Iterator<Item = f64>, lag_rows: f64) -> Vec<Measurement> {
        let row = |t| Measurement {
            tracker_from_ideal: hand(t),
            tracker_from_measured: hand(t - lag_rows),
        };
        moments.map(row).collect()
    }

    /// Distance in mm and angle in rad between the two sides.
    fn apart(m: &Measurement) -> [f64; 2] {
        let turn = m.tracker_from_ideal.rotation.angle_to(&m.tracker_from_measured.rotation);
        let [a, b] = [m.tracker_from_ideal, m.tracker_from_measured];
        [(a.translation.vector - b.translation.vector).norm(), turn]
    }

    #[test]
    fn the_sides_meet_again() {
        for lag_rows in [0.4, 1.0, 2.7, -0.6, -3.2] {
            let late = rows((0..200).map(f64::from), lag_rows);
            assert!(late.iter().map(|m| apart(m)[0]).fold(0.0, f64::max) > 1.0);
            for (k, m) in without_lag(&late, CONTENT, lag_rows).iter().enumerate() {
                let is_end = !(4..196).contains(&k);
                let [mm, rad] = apart(m);
                let most_mm = if is_end { beyond_mm(lag_rows) } else { CHORD_MM };
                assert!(mm < most_mm && rad < most_mm / 50.0, "{lag_rows}, {k}: {mm} mm, {rad}");
            }
        }
    }

    #[test]
    fn a_path_is_followed_up_to_its_gaps() {
        let moments = (0..60).map(f64::from).chain((300..360).map(f64::from));
        let late = rows(moments, 1.5);
        for (k, m) in without_lag(&late, CONTENT, 1.5).iter().enumerate() {
            let most_mm = if k < 2 || (60..62).contains(&k) { beyond_mm(1.5) } else { CHORD_MM };
            assert!(apart(m)[0] < most_mm, "{k}: {:?}", apart(m));
        }
    }

    #[test]
    fn the_axis_is_followed_whatever_the_roll() {
        let lag_rows = 1.4;
        let mut late = rows((0..100).map(f64::from), lag_rows);
        for (k, m) in late.iter_mut().enumerate() {
            let roll = exp_vector(&(Vector3::z() * 2.4 * k as f64));
            m.tracker_from_ideal.rotation *= roll;
        }
        for m in &without_lag(&late, MeasurementContent::FiveDof, lag_rows)[4..96] {
            let axis = |pose: &Pose| pose.rotation * Vector3::z();
            let apart = axis(&m.tracker_from_ideal) - axis(&m.tracker_from_measured);
            assert!(apart.norm() < 1e-3, "{apart}");
        }
    }

    #[test]
    fn too_few_rows_stay_as_they_are() {
        for count in [0, 1] {
            let few = rows((0..count).map(f64::from), 1.0);
            assert_eq!(without_lag(&few, CONTENT, 1.0), few);
        }
    }
}
