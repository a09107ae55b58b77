//! The range of motion: the grid of tool poses that a study visits.

use super::pivot::Pivot;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use trackwright_geometry::limits::{MAX_ANGLE_DEG, MAX_LENGTH_MM, short};
use trackwright_geometry::pose::{Pose, pose_from_parts};

/// Most poses a study visits. At 16 bytes a pose the figures of so many take 1.6 GB.
pub const MAX_TRIALS: f64 = 1e8;

/// How close to a whole step the last value of an axis may be and still count.
pub(super) const STEP_TOLERANCE: f64 = 1e-9;

/// The values of one axis: `min + k step` up to `max`, which is not below `min`; mm for x, y, z and degrees for rx, ry, rz.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisRange {
    pub min: f64,
    pub max: f64,
    pub step: f64,
}

/// How the tool moves about its pose: translations along the CRF's axes, and
/// `R = Rz(rz) Ry(ry) Rx(rx) R0` about the CRF's axes at the [pivot](Pivot).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    #[serde(default, skip_serializing_if = "Pivot::is_origin")]
    pub pivot: Pivot,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<AxisRange>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<AxisRange>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<AxisRange>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rx: Option<AxisRange>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ry: Option<AxisRange>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rz: Option<AxisRange>,
}

/// Why a range of motion cannot be visited.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MotionError {
    #[error("motion.{axis}: step is {}, expected zero or more", short(*step))]
    NegativeStep { axis: &'static str, step: f64 },
    #[error("motion.{axis}: min is {}, max is {}, expected min at most max", short(*min), short(*max))]
    Reversed { axis: &'static str, min: f64, max: f64 },
    #[error("motion.{axis}: {part} is {}, expected {expected}", short(*found))]
    TooFar { axis: &'static str, part: &'static str, found: f64, expected: &'static str },
    #[error("motion.{axis}: min, max and step are {min}, {max}, {step}, expected finite numbers")]
    NotFinite { axis: &'static str, min: f64, max: f64, step: f64 },
    #[error("motion.pivot: the point is {point:?}, expected {expected}")]
    Pivot { point: [f64; 3], expected: &'static str },
    #[error(
        "the range of motion has {trials:.4e} poses, expected at most {MAX_TRIALS:e}; widen the steps"
    )]
    TooManyTrials { trials: f64 },
}

impl Motion {
    /// The axes by name, in the order in which the grid runs, slowest first.
    pub fn axes(&self) -> [(&'static str, Option<AxisRange>); 6] {
        [
            ("x", self.x),
            ("y", self.y),
            ("z", self.z),
            ("rx", self.rx),
            ("ry", self.ry),
            ("rz", self.rz),
        ]
    }

    /// The same with another range of an axis, counted in the order of [`Self::axes`].
    pub fn with_axis(mut self, axis: usize, range: Option<AxisRange>) -> Self {
        let axes =
            [&mut self.x, &mut self.y, &mut self.z, &mut self.rx, &mut self.ry, &mut self.rz];
        if let Some(of_axis) = axes.into_iter().nth(axis) {
            *of_axis = range;
        }
        self
    }

    /// The same with the pivot at the same place on the body where the reference was moved under
    /// it, from one `reference_from_body` to another.
    pub fn with_reference_moved(self, from: &Pose, to: &Pose) -> Self {
        Self { pivot: self.pivot.with_reference_moved(from, to), ..self }
    }

    /// Whether no axis moves.
    pub fn is_still(&self) -> bool {
        self.axes().iter().all(|(_, range)| range.is_none())
    }

    /// Whether it turns the body, be it to one angle only.
    pub fn has_turns(&self) -> bool {
        self.axes()[3..].iter().any(|(_, range)| range.is_some())
    }

    /// How many values each axis has, in the order of [`Self::axes`].
    ///
    /// # Errors
    /// A negative step, `min` above `max`, a number that is not finite or beyond what
    /// [`limits`](trackwright_geometry::limits) allows, or more than [`MAX_TRIALS`] poses.
    pub fn counts(&self) -> Result<[usize; 6], MotionError> {
        if let Some((point, expected)) = self.pivot.problem() {
            return Err(MotionError::Pivot { point, expected });
        }
        let mut counts = [1_usize; 6];
        let mut trials = 1.0;
        let mut lengths = [1.0; 6];
        for (k, (axis, range)) in self.axes().into_iter().enumerate() {
            lengths[k] = axis_length(axis, range)?;
            trials *= lengths[k];
        }
        if trials > MAX_TRIALS {
            return Err(MotionError::TooManyTrials { trials });
        }
        for (count, length) in counts.iter_mut().zip(lengths) {
            *count = length as usize;
        }
        Ok(counts)
    }

    /// How many poses it has.
    ///
    /// # Errors
    /// Those of [`Self::counts`].
    pub fn trials(&self) -> Result<usize, MotionError> {
        self.counts().map(|counts| counts.iter().product())
    }

    /// The grid of poses about `crf_from_tool`.
    ///
    /// # Errors
    /// Those of [`Self::counts`].
    pub fn grid(
        &self,
        crf_from_tool: &Pose,
        tip_in_tool: &Point3<f64>,
    ) -> Result<MotionGrid, MotionError> {
        let counts = self.counts()?;
        let pivot_in_tool = self.pivot.in_body(tip_in_tool, crf_from_tool);
        Ok(MotionGrid { motion: *self, counts, crf_from_tool: *crf_from_tool, pivot_in_tool })
    }
}

/// Number of values of an axis, as a float so that absurd ranges do not overflow.
fn axis_length(axis: &'static str, range: Option<AxisRange>) -> Result<f64, MotionError> {
    let Some(AxisRange { min, max, step }) = range else {
        return Ok(1.0);
    };
    if !(min.is_finite() && max.is_finite() && step.is_finite()) {
        return Err(MotionError::NotFinite { axis, min, max, step });
    }
    if step < 0.0 {
        return Err(MotionError::NegativeStep { axis, step });
    }
    if min > max {
        return Err(MotionError::Reversed { axis, min, max });
    }
    let (most, expected) = match axis.starts_with('r') {
        true => (MAX_ANGLE_DEG, "at most 3600 degrees either way"),
        false => (MAX_LENGTH_MM, "at most 1e6 mm either way"),
    };
    let parts = [("min", min), ("max", max), ("step", step)];
    if let Some(&(part, found)) = parts.iter().find(|(_, value)| value.abs() > most) {
        return Err(MotionError::TooFar { axis, part, found, expected });
    }
    if step == 0.0 || min == max {
        return Ok(1.0);
    }
    Ok(((max - min) / step + STEP_TOLERANCE).floor() + 1.0)
}

/// The poses of a range of motion, each made when requested.
#[derive(Clone, Debug)]
pub struct MotionGrid {
    motion: Motion,
    counts: [usize; 6],
    crf_from_tool: Pose,
    pivot_in_tool: Point3<f64>,
}

impl MotionGrid {
    pub fn trials(&self) -> usize {
        self.counts.iter().product()
    }

    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// What turns leave where it is.
    pub fn pivot_in_tool(&self) -> &Point3<f64> {
        &self.pivot_in_tool
    }

    /// Number of values along x, y, z, rx, ry, rz.
    pub fn counts(&self) -> [usize; 6] {
        self.counts
    }

    /// The values along one axis, mm or degrees; 0 alone for an axis that does not move.
    pub fn axis_values(&self, axis: usize) -> Vec<f64> {
        let range = self.motion.axes()[axis].1;
        let value = |index: usize| range.map_or(0.0, |r| r.min + index as f64 * r.step);
        (0..self.counts[axis]).map(value).collect()
    }

    /// Number of different orientations: after so many trials the pivot's position changes and
    /// they begin anew.
    pub fn orientations(&self) -> usize {
        self.counts[3..].iter().product()
    }

    /// `crf_from_tool` of a trial; x runs slowest, rz fastest.
    pub fn pose(&self, trial: usize) -> Pose {
        self.moved(self.offsets(trial))
    }

    /// `crf_from_tool` moved by x, y, z in mm and turned about the pivot by rx, ry, rz in degrees.
    pub fn moved(&self, [x, y, z, rx, ry, rz]: [f64; 6]) -> Pose {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), rz.to_radians())
            * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), ry.to_radians())
            * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), rx.to_radians());
        let Pose { translation, rotation } = self.crf_from_tool;
        // Of the pivot from the tool's origin: zero, and not nearly, where it is the origin.
        let arm = rotation * self.pivot_in_tool.coords;
        let position = translation.vector + Vector3::new(x, y, z) + (arm - turn * arm);
        pose_from_parts(position, turn * rotation)
    }

    /// How far a trial is from the design's own pose along x, y, z in mm and about rx, ry, rz in
    /// degrees.
    pub fn offsets(&self, trial: usize) -> [f64; 6] {
        let (indices, axes) = (self.indices(trial), self.motion.axes());
        std::array::from_fn(|k| axes[k].1.map_or(0.0, |r| r.min + indices[k] as f64 * r.step))
    }

    /// Which of the values of each axis a trial has.
    pub fn indices(&self, trial: usize) -> [usize; 6] {
        let mut indices = [0; 6];
        let mut rest = trial;
        for (index, count) in indices.iter_mut().zip(self.counts).rev() {
            *index = rest % count;
            rest /= count;
        }
        indices
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(min: f64, max: f64, step: f64) -> Option<AxisRange> {
        Some(AxisRange { min, max, step })
    }

    fn count(axis: Option<AxisRange>) -> usize {
        let motion = Motion { x: axis, ..Motion::default() };
        motion.trials().unwrap()
    }

    #[test]
    fn an_axis_includes_its_max_up_to_rounding() {
        assert_eq!(count(range(0.0, 0.3, 0.1)), 4);
        assert_eq!(count(range(0.0, 0.3 - 1e-8, 0.1)), 3);
        assert_eq!(count(range(-50.0, 50.0, 30.0)), 4);
    }

    #[test]
    fn no_step_or_no_length_gives_min_alone() {
        assert_eq!(count(range(5.0, 9.0, 0.0)), 1);
        assert_eq!(count(range(5.0, 5.0, 1.0)), 1);
        assert_eq!(count(None), 1);
    }

    #[test]
    fn x_runs_slowest_and_rz_fastest() {
        let motion =
            Motion { x: range(-1.0, 1.0, 1.0), rz: range(0.0, 90.0, 45.0), ..Motion::default() };
        let grid = motion.grid(&Pose::translation(10.0, 0.0, 0.0), &Point3::origin()).unwrap();
        assert_eq!(grid.trials(), 9);
        assert_eq!(grid.pose(2).translation.x, 9.0);
        assert_eq!(grid.pose(3).translation.x, 10.0);
        assert!((grid.pose(5).rotation.angle().to_degrees() - 90.0).abs() < 1e-12);
    }

    #[test]
    fn turns_are_about_the_crf_axes_x_first() {
        let motion =
            Motion { rx: range(90.0, 90.0, 0.0), rz: range(90.0, 90.0, 0.0), ..Motion::default() };
        let pose = motion.grid(&Pose::identity(), &Point3::origin()).unwrap().pose(0);
        // Rx takes y to z, Rz leaves z alone.
        assert!((pose.rotation * Vector3::y() - Vector3::z()).norm() < 1e-15);
    }

    #[test]
    fn turns_leave_the_pivot_where_it_is() {
        let turned = Vector3::new(0.3, -1.2, 0.4);
        let crf_from_tool = Pose::new(Vector3::new(20.0, -5.0, 8.0), turned);
        let tip = Point3::new(3.0, 1.0, 97.0);
        let entry = [1.0, 0.5, 40.0];
        let joint = Point3::new(-60.0, 10.0, 4.0);
        for (pivot, point_in_tool) in [
            (Pivot::Origin, Point3::origin()),
            (Pivot::Tip, tip),
            (Pivot::Body(entry), entry.into()),
            (Pivot::Reference(joint.coords.into()), crf_from_tool.inverse() * joint),
        ] {
            let grid = Motion { pivot, ..Motion::default() }.grid(&crf_from_tool, &tip).unwrap();
            let moved = grid.moved([1.0, 2.0, 3.0, 30.0, -50.0, 170.0]);
            let shift = moved * point_in_tool - crf_from_tool * point_in_tool;
            assert!((shift - Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-13, "{pivot:?}: {shift:?}");
            let about_origin = Motion::default().grid(&crf_from_tool, &tip).unwrap();
            let rotation = about_origin.moved([0.0, 0.0, 0.0, 30.0, -50.0, 170.0]).rotation;
            assert_eq!(moved.rotation, rotation);
        }
    }

    #[test]
    fn a_moved_reference_leaves_its_pivot_in_the_room() {
        let crf_from_tool = Pose::new(Vector3::new(20.0, -5.0, 8.0), Vector3::new(0.3, -1.2, 0.4));
        let moved = Pose::new(Vector3::new(3.0, 40.0, -7.0), Vector3::new(-0.5, 0.1, 0.9));
        let tip = Point3::new(0.0, 1.0, 97.0);
        for pivot in
            [Pivot::Origin, Pivot::Tip, Pivot::Body([1.0; 3]), Pivot::Reference([-60.0, 10.0, 4.0])]
        {
            let motion = Motion { pivot, ..Motion::default() };
            let there = moved.inverse() * crf_from_tool;
            let carried = motion.with_reference_moved(&crf_from_tool, &there);
            let before = motion.grid(&crf_from_tool, &tip).unwrap();
            let after = carried.grid(&there, &tip).unwrap();
            assert!((before.pivot_in_tool() - after.pivot_in_tool()).norm() < 1e-12, "{pivot:?}");
        }
    }

    #[test]
    fn ranges_that_cannot_be_visited_state_why() {
        let none = Motion::default();
        let axis = range(0.0, 99.0, 1.0);
        let all = Motion { x: axis, y: axis, z: axis, rx: axis, ry: axis, rz: axis, ..none };
        let absurd = Pivot::Body([0.0, f64::NAN, 0.0]);
        for (motion, reason) in [
            (
                Motion { rz: range(5.0, -4.5, 0.0), ..none },
                "motion.rz: min is 5, max is -4.5, expected min at most max",
            ),
            (
                Motion { x: range(-1e308, 1e308, 1e308), ..none },
                "motion.x: min is -1e308, expected at most 1e6 mm either way",
            ),
            (
                Motion { rx: range(0.0, 3601.0, 10.0), ..none },
                "motion.rx: max is 3601, expected at most 3600 degrees either way",
            ),
            (Motion { ry: range(0.0, 1.0, -1.0), ..none }, "motion.ry: step is -1"),
            (
                Motion { pivot: absurd, ..none },
                "motion.pivot: the point is [0.0, NaN, 0.0], expected finite numbers",
            ),
            (all, "the range of motion has 1.0000e12 poses"),
        ] {
            let error = motion.trials().unwrap_err().to_string();
            assert!(error.starts_with(reason), "{error}");
        }
    }
}
