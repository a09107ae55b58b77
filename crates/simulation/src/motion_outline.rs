//! A range of motion as lines and handles: where its shifts and turns take the tool.
//!
//! Shifts move the tip through a box along the CRF's axes, drawn with the tool turned as the design
//! has it. Each turn has a fan about the pivot, drawn with the other turns at zero: the path
//! of a point of the tool, which is the tip where turning moves it, else the sensor that turning
//! moves farthest, since tips are often the pivot itself. Box and arcs end at the extreme trials;
//! where a range goes on beyond its last whole step, a stem leads from there to its handle.

use super::motion::{AxisRange, Motion, MotionError, MotionGrid, STEP_TOLERANCE};
use crate::body::RigidBody;
use nalgebra::{Point3, Unit, Vector3};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::surface::Ray;

/// A point nearer to the axis of a turn than this draws no fan that one could take hold of.
const LEAST_ARM_MM: f64 = 10.0;

/// What a turn that moves no point of the tool is drawn with.
const PLACEHOLDER_ARM_MM: f64 = 40.0;

/// Chords of an arc are no longer than this.
const CHORD_DEG: f64 = 3.0;

/// Most trial values of an axis that are marked one by one; more would be a solid band.
const MOST_MARKS: usize = 61;

/// How much of a spoke marks a trial between the extreme ones.
const INNER_SPOKE: f64 = 0.08;

/// Length of a mark across an edge of the box, as a part of its longest side, and its bounds in mm.
const MARK_SHARE: f64 = 0.04;
const MARK_MM: [f64; 2] = [0.5, 6.0];

/// Nearer to edge-on than this sine, a fan's handle follows its tangent: the ray's place in the
/// fan's plane would jump with every pixel.
const EDGE_ON: f64 = 0.2;

/// How long a range can be dragged: beyond any tracker's volume, and a whole turn.
const FARTHEST_MM: f64 = 2000.0;
const FARTHEST_DEG: f64 = 360.0;

/// Where a range of motion takes the tool, tracker frame, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionOutline {
    /// Of the box of the tip's positions, with a mark across them at each trial value.
    pub edges: Vec<[Point3<f64>; 2]>,
    pub marks: Vec<[Point3<f64>; 2]>,
    pub fans: Vec<Fan>,
    /// What turns leave where it is; nothing where none can be dragged.
    pub pivot_mm: Option<Point3<f64>>,
    /// From the extreme trials to handles that are beyond them.
    pub stems: Vec<Vec<Point3<f64>>>,
    pub handles: Vec<MotionHandle>,
}

/// What a turn does to a point of the tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Fan {
    /// 3, 4, 5 for rx, ry, rz.
    pub axis: usize,
    /// The point's path.
    pub arc: Vec<Point3<f64>>,
    /// From the pivot to the point at the first and the last trial angle, and the ends of
    /// those between.
    pub spokes: Vec<[Point3<f64>; 2]>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RangeEnd {
    Min,
    Max,
}

/// Where a person takes hold of one end of an axis's range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionHandle {
    /// 0 to 5 for x, y, z, rx, ry, rz.
    pub axis: usize,
    pub end: RangeEnd,
    /// Tracker frame.
    pub at_mm: Point3<f64>,
    pub path: HandlePath,
}

/// What a handle moves along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HandlePath {
    /// A line through the handle, in the direction in which the value grows.
    Line(Unit<Vector3<f64>>),
    /// A circle through the handle, around an axis about which the value grows.
    Circle { center_mm: Point3<f64>, axis: Unit<Vector3<f64>> },
}

/// A handle that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldEnd {
    handle: MotionHandle,
    start: Motion,
    /// Where along its path the handle was taken hold of, and where the pointer was last: mm or
    /// degrees from the handle's own place.
    grabbed: f64,
    last: f64,
}

/// Lines and handles of a motion of the tool from its pose in the CRF frame.
///
/// # Errors
/// A motion that cannot be visited; see [`MotionError`].
pub fn motion_outline(
    motion: &Motion,
    tool: &RigidBody,
    crf_from_tool: &Pose,
    tracker_from_crf: &Pose,
) -> Result<MotionOutline, MotionError> {
    let grid = motion.grid(crf_from_tool, &tool.judged_tip_in_body())?;
    let mut outline = MotionOutline::default();
    let drawn = Drawn { motion, grid: &grid, tool, crf_from_tool, tracker_from_crf };
    drawn.push_box(&mut outline);
    for axis in 3..6 {
        drawn.push_fan(&mut outline, axis);
    }
    Ok(outline)
}

struct Drawn<'a> {
    motion: &'a Motion,
    grid: &'a MotionGrid,
    tool: &'a RigidBody,
    crf_from_tool: &'a Pose,
    tracker_from_crf: &'a Pose,
}

impl Drawn<'_> {
    /// A range whose ends can be dragged.
    fn range(&self, axis: usize) -> Option<AxisRange> {
        let range = self.motion.axes().get(axis)?.1?;
        (range.step > 0.0 && range.max > range.min).then_some(range)
    }

    /// A point of the tool, tracker frame, where it is moved so far.
    fn point(&self, point_in_tool: &Point3<f64>, offsets: [f64; 6]) -> Point3<f64> {
        self.tracker_from_crf * self.grid.moved(offsets) * point_in_tool
    }

    fn push_box(&self, outline: &mut MotionOutline) {
        let tip = self.tool.judged_tip_in_body();
        let at = |[x, y, z]: [f64; 3]| self.point(&tip, [x, y, z, 0.0, 0.0, 0.0]);
        let values = [0, 1, 2].map(|axis| self.grid.axis_values(axis));
        let ends = values.each_ref().map(|values| [0, values.len() - 1].map(|k| values[k]));
        let longest_mm = ends.iter().map(|[min, max]| max - min).fold(0.0, f64::max);
        let mark_mm = (MARK_SHARE * longest_mm).clamp(MARK_MM[0], MARK_MM[1]);
        for axis in 0..3 {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            // An axis that stays where it is has one end, not two in the same place.
            let of = |k: usize| &ends[k][..if ends[k][0] < ends[k][1] { 2 } else { 1 }];
            if of(axis).len() == 1 {
                continue;
            }
            for &at_u in of(u) {
                for &at_v in of(v) {
                    let place = |value: f64| {
                        let mut place = [0.0; 3];
                        (place[axis], place[u], place[v]) = (value, at_u, at_v);
                        place
                    };
                    outline.edges.push(ends[axis].map(|value| at(place(value))));
                    if values[axis].len() > MOST_MARKS {
                        continue;
                    }
                    for &value in &values[axis] {
                        let mut from = place(value);
                        let mut to = from;
                        from[u] -= mark_mm / 2.0;
                        to[u] += mark_mm / 2.0;
                        outline.marks.push([at(from), at(to)]);
                    }
                }
            }
        }
        let middle = ends.map(|[min, max]| (min + max) / 2.0);
        for axis in 0..3 {
            let Some(range) = self.range(axis) else {
                continue;
            };
            let place = |value: f64| {
                let mut place = middle;
                place[axis] = value;
                at(place)
            };
            let direction = self.tracker_from_crf.rotation * Vector3::ith_axis(axis);
            for (end, value) in [(RangeEnd::Min, range.min), (RangeEnd::Max, range.max)] {
                outline.handles.push(MotionHandle {
                    axis,
                    end,
                    at_mm: place(value),
                    path: HandlePath::Line(direction),
                });
            }
            let last = ends[axis][1];
            if is_short(last, &range) {
                outline.stems.push(vec![place(last), place(range.max)]);
            }
        }
    }

    fn push_fan(&self, outline: &mut MotionOutline, axis: usize) {
        let Some(range) = self.range(axis) else {
            return;
        };
        let about = self.tracker_from_crf.rotation * Vector3::ith_axis(axis - 3);
        let point_in_tool = self.swept_point(axis - 3);
        let at = |angle_deg: f64| {
            let mut offsets = [0.0; 6];
            offsets[axis] = angle_deg;
            self.point(&point_in_tool, offsets)
        };
        let arc = |from: f64, to: f64| -> Vec<Point3<f64>> {
            // A whole turn is enough to see that it is one.
            let to = to.min(from + 360.0);
            let chords = ((to - from) / CHORD_DEG).ceil().max(1.0);
            (0..=chords as usize).map(|i| at(from + (to - from) * i as f64 / chords)).collect()
        };
        let angles = self.grid.axis_values(axis);
        let (first, last) = (angles[0], angles[angles.len() - 1]);
        let pivot = self.point(self.grid.pivot_in_tool(), [0.0; 6]);
        outline.pivot_mm = Some(pivot);
        let are_marked = angles.len() <= MOST_MARKS;
        let spokes = angles.iter().enumerate().filter_map(|(i, angle)| {
            let end = at(*angle);
            let is_extreme = i == 0 || i + 1 == angles.len();
            let from = if is_extreme { pivot } else { end + (pivot - end) * INNER_SPOKE };
            (is_extreme || are_marked).then_some([from, end])
        });
        outline.fans.push(Fan { axis, spokes: spokes.collect(), arc: arc(first, last) });
        if is_short(last, &range) {
            outline.stems.push(arc(last, range.max));
        }
        for (end, value) in [(RangeEnd::Min, range.min), (RangeEnd::Max, range.max)] {
            let at_mm = at(value);
            let center_mm = pivot + about.into_inner() * about.dot(&(at_mm - pivot));
            let path = HandlePath::Circle { center_mm, axis: about };
            outline.handles.push(MotionHandle { axis, end, at_mm, path });
        }
    }

    /// The point of the tool whose path shows a turn about x, y or z of the CRF.
    fn swept_point(&self, axis: usize) -> Point3<f64> {
        let about = Vector3::ith_axis(axis);
        let tool_from_crf = self.crf_from_tool.rotation.inverse();
        let about_in_tool = tool_from_crf * about;
        let pivot = self.grid.pivot_in_tool();
        let arm_mm = |point: &Point3<f64>| (point - pivot).cross(&about_in_tool).norm();
        let tip = self.tool.judged_tip_in_body();
        if arm_mm(&tip) >= LEAST_ARM_MM {
            return tip;
        }
        self.tool
            .sensors
            .iter()
            .map(|sensor| sensor.position_in_body)
            .max_by(|a, b| arm_mm(a).total_cmp(&arm_mm(b)))
            .filter(|point| arm_mm(point) >= LEAST_ARM_MM)
            .unwrap_or_else(|| {
                let across = Vector3::ith_axis((axis + 1) % 3).into_inner();
                pivot + tool_from_crf * across * PLACEHOLDER_ARM_MM
            })
    }
}

/// Whether a range goes on beyond its last trial value.
fn is_short(last: f64, range: &AxisRange) -> bool {
    range.max - last > STEP_TOLERANCE * range.step
}

impl MotionHandle {
    /// Where along its path the pointer's ray has it: mm or degrees from its own place; `None` where
    /// the ray does not determine it.
    fn under(&self, ray: &Ray) -> Option<f64> {
        match self.path {
            HandlePath::Line(direction) => ray.nearest_on_line(&self.at_mm, &direction),
            HandlePath::Circle { center_mm, axis } => {
                let arm = self.at_mm - center_mm;
                let tangent = axis.cross(&arm);
                if ray.direction.dot(&axis).abs() < EDGE_ON {
                    let along = Unit::try_new(tangent, 0.0)?;
                    let moved_mm = ray.nearest_on_line(&self.at_mm, &along)?;
                    return Some((moved_mm / arm.norm()).to_degrees());
                }
                let there = ray.meets_plane(&center_mm, &axis)? - center_mm;
                Some(there.dot(&tangent).atan2(there.dot(&arm)).to_degrees())
            }
        }
    }

    /// Takes hold of it with the pointer's ray there.
    pub fn take(&self, motion: &Motion, ray: &Ray) -> Option<HeldEnd> {
        let grabbed = self.under(ray)?;
        Some(HeldEnd { handle: *self, start: *motion, grabbed, last: grabbed })
    }
}

impl HeldEnd {
    /// What is held of it.
    pub fn handle(&self) -> &MotionHandle {
        &self.handle
    }

    /// The motion with the pointer's ray there: the end at a whole number of steps from the other,
    /// or rounded to a whole multiple of `round_to`, mm or degrees; at least one step or multiple is
    /// left. `None` where the ray determines nothing, and before anything moved.
    pub fn motion_at(&mut self, ray: &Ray, round_to: Option<f64>) -> Option<Motion> {
        let mut now = self.handle.under(ray)?;
        if let HandlePath::Circle { .. } = self.handle.path {
            // Beyond half a turn it goes on, instead of coming from the other side.
            now += 360.0 * ((self.last - now) / 360.0).round();
        }
        self.last = now;
        let range = self.start.axes().get(self.handle.axis)?.1?;
        let value = self.handle.end.of(&range) + now - self.grabbed;
        let farthest = match self.handle.path {
            HandlePath::Line(_) => FARTHEST_MM,
            HandlePath::Circle { .. } => FARTHEST_DEG,
        };
        let range = with_end(range, self.handle.end, value, round_to, farthest);
        Some(self.start.with_axis(self.handle.axis, Some(range)))
    }
}

impl RangeEnd {
    /// The end's value.
    pub fn of(self, range: &AxisRange) -> f64 {
        match self {
            Self::Min => range.min,
            Self::Max => range.max,
        }
    }
}

/// A range with one end moved to about a value; see [`HeldEnd::motion_at`]. The other end stays as
/// it is; the two get no farther apart than `farthest`, or than they are.
fn with_end(
    range: AxisRange,
    end: RangeEnd,
    value: f64,
    round_to: Option<f64>,
    farthest: f64,
) -> AxisRange {
    let AxisRange { min, max, step } = range;
    // Steps are counted from `min`, so the last value may be short of `max`.
    let count = ((max - min) / step + STEP_TOLERANCE).floor();
    let (fixed, away) = match end {
        RangeEnd::Max => (min, 1.0),
        RangeEnd::Min if count >= 1.0 && round_to.is_none() => (min + count * step, -1.0),
        RangeEnd::Min => (max, -1.0),
    };
    let most = farthest.max((max - min).abs());
    let length = ((value - fixed) * away).clamp(0.0, most);
    let moved = match round_to {
        // Whole millimetres or degrees, not whole distances from the other end.
        Some(unit) => {
            let rounded = ((fixed + away * length) / unit).round() * unit;
            match (rounded - fixed) * away > 0.0 {
                true => rounded,
                false => ((fixed / unit * away).floor() + 1.0) * unit * away,
            }
        }
        None => fixed + away * step * (length / step).round().max(1.0),
    };
    // Sums of steps such as 0.1 read as what they are meant to be.
    let moved = (moved * 1e9).round() / 1e9;
    match end {
        RangeEnd::Min => AxisRange { min: moved, ..range },
        RangeEnd::Max => AxisRange { max: moved, ..range },
    }
}

#[cfg(test)]
mod tests;
