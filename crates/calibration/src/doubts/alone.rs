//! What positions and quaternions by themselves show.

use super::{MAX_POSITION_MM, MIN_ROWS, SignedAxes, Suspicion, on_axes, signed_axes};
use nalgebra::{Point3, Vector3};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::Pose;

/// Largest distance from the origin, and extent, of positions that are metres beyond doubt: every
/// volume that a tracker measures is within 5 m, and none reaches less than 5 mm of a generator.
const METRES_REACH: f64 = 5.0;
const METRES_SPAN: f64 = 2.0;

/// Distance from the origin that no tracker reads, mm: optical ones end at 3 to 8 m.
const LARGE_REACH: f64 = 2e4;

/// Largest distance from the origin of positions that may be inches or centimetres. The volumes of EM
/// trackers begin at 10 to 80 mm and are 150 mm deep at least; 60 inches are 1.5 m.
pub(super) const SMALL_REACH: f64 = 70.0;

/// Rows with a negative scalar that determine the order of quaternions by their signs, by chance once in a million tables.
const MIN_SIGNED: usize = 20;

/// Smallest last component at or below which it counts as one that changes sign where it is no scalar.
const SMALL_COMPONENT: f64 = 0.35;

/// Part of the positions that may be in a room's box where they are suspected to be elsewhere.
const MAX_INSIDE_PART: f64 = 0.1;

/// Frame of positions, which determines how near its origin they can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoseFrame {
    /// An EM tracker's: nothing is measured within its generator.
    Tracker,
    /// Some tracker's or a reference tool's, of which a recording is.
    Recorded,
    /// A body's, an image's, or not known: positions may be anywhere.
    Any,
}

/// Suspicions about poses by themselves.
pub fn of_poses<'a>(poses: impl IntoIterator<Item = &'a Pose>, frame: PoseFrame) -> Vec<Suspicion> {
    let positions = poses.into_iter().map(|pose| pose.translation.vector);
    extent(positions).suspicions(frame)
}

/// Suspicions about points by themselves, in any frame.
pub fn of_points<'a>(points: impl IntoIterator<Item = &'a Point3<f64>>) -> Vec<Suspicion> {
    extent(points.into_iter().map(|point| point.coords)).suspicions(PoseFrame::Any)
}

/// As [`of_poses`], where quaternions are as a file's columns have them: a sign shows which of them
/// was taken for the scalar.
pub fn with_written_quaternions(poses: &[Pose], frame: PoseFrame) -> Vec<Suspicion> {
    let mut found = of_poses(poses, frame);
    let mut signs = Signs::default();
    poses.iter().for_each(|pose| signs.push(pose));
    found.extend(signs.suspicion());
    found
}

/// Suspicions about poses of sensors that a room with this box is applied to.
pub fn in_room(poses: &[Pose], room: &Bounds) -> Option<Suspicion> {
    let inside = |axes: Option<SignedAxes>| {
        let each = poses.iter().map(|pose| match &axes {
            Some(axes) => on_axes(axes, &pose.translation.vector),
            None => pose.translation.vector,
        });
        each.filter(|at| room.contains(&Point3::from(*at))).count()
    };
    let rows = poses.len();
    let as_read = inside(None);
    if rows < MIN_ROWS || as_read as f64 > MAX_INSIDE_PART * rows as f64 {
        return None;
    }
    let tried = signed_axes().map(|axes| (axes, inside(Some(axes))));
    // The first of equals has the fewest changes.
    let (axes, inside_with_axes) = tried.rev().max_by_key(|(_, inside)| *inside)?;
    (inside_with_axes as f64 > (1.0 - MAX_INSIDE_PART) * rows as f64)
        .then_some(Suspicion::NotInRoom { rows, inside: as_read, axes, inside_with_axes })
}

/// Where positions are, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Extent {
    rows: usize,
    bounds: Option<(Vector3<f64>, Vector3<f64>)>,
    /// Largest distance from the origin.
    reach: f64,
    far: Far,
}

/// Rows with coordinates out of all bounds.
#[derive(Clone, Copy, Debug, Default)]
struct Far {
    count: usize,
    first_row: usize,
    largest: f64,
}

fn extent(positions: impl Iterator<Item = Vector3<f64>>) -> Extent {
    let mut extent = Extent::default();
    positions.for_each(|position| extent.push(&[position]));
    extent
}

/// Whether no tracker reads such a position.
pub(super) fn is_too_far(position: &Vector3<f64>) -> bool {
    // Also where it is not a number.
    !position.amax().lt(&MAX_POSITION_MM)
}

impl Extent {
    /// Adds the positions of a row.
    pub(super) fn push(&mut self, positions: &[Vector3<f64>]) {
        self.rows += 1;
        if positions.iter().any(is_too_far) {
            let largest = positions.iter().map(|p| p.amax()).fold(0.0, f64::max);
            if self.far.count == 0 {
                self.far.first_row = self.rows;
            }
            self.far.count += 1;
            self.far.largest = self.far.largest.max(largest);
            return;
        }
        for position in positions {
            self.reach = self.reach.max(position.norm());
            let (low, high) = self.bounds.get_or_insert((*position, *position));
            (*low, *high) = (low.inf(position), high.sup(position));
        }
    }

    pub(super) fn suspicions(&self, frame: PoseFrame) -> Vec<Suspicion> {
        let mut found = Vec::new();
        if self.far.count > 0 {
            found.push(Suspicion::TooFar {
                count: self.far.count,
                first_row: self.far.first_row,
                largest: self.far.largest,
            });
        }
        let Some((low, high)) = self.bounds else {
            return found;
        };
        let (span, reach) = ((high - low).amax(), self.reach);
        // Zeros are no places, and a row or two are any numbers.
        if self.rows < MIN_ROWS || reach == 0.0 {
            return found;
        }
        match frame {
            _ if reach < METRES_REACH && span < METRES_SPAN => {
                found.push(Suspicion::Metres { span, reach, is_certain: frame != PoseFrame::Any });
            }
            _ if reach > LARGE_REACH => {
                found.push(Suspicion::TooLarge {
                    span,
                    reach,
                    is_certain: frame != PoseFrame::Any,
                });
            }
            PoseFrame::Tracker if reach < SMALL_REACH => {
                found.push(Suspicion::InchesOrCentimetres { span, reach });
            }
            _ => {}
        }
        found
    }
}

/// Signs of the first and the last number of quaternions, as they are written. Programs write the one
/// of two quaternions whose scalar is not negative; where that is the last number, it is taken for z.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Signs {
    rows: usize,
    negative_first: usize,
    /// Of those rows.
    smallest_last: Option<f64>,
}

impl Signs {
    pub(super) fn push(&mut self, pose: &Pose) {
        let q = pose.rotation.quaternion();
        self.rows += 1;
        if q.w < 0.0 {
            self.negative_first += 1;
            self.smallest_last = Some(self.smallest_last.unwrap_or(f64::INFINITY).min(q.k));
        }
    }

    pub(super) fn suspicion(&self) -> Option<Suspicion> {
        // An axis that stays upright has zeros there, and a scalar is not zero throughout.
        let is_scalar_like = self.smallest_last.is_some_and(|k| k > 0.0 && k < SMALL_COMPONENT);
        (self.negative_first >= MIN_SIGNED && is_scalar_like).then_some(Suspicion::ScalarLast {
            rows: self.rows,
            negative_first: self.negative_first,
        })
    }
}
