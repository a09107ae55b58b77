//! How the CRF is moved over a patch of the patient's surface.
//!
//! The foot is the point of the anatomy's surface that is nearest to the middle of the CRF's body. When
//! the foot is moved over the surface, the CRF goes with it as if fixed to its normal: it keeps its
//! offset, turns by the smallest turn from the old normal to the new one, and by a turn about that.

use crate::crf_patch::CrfPatch;
use crate::outcome::OptimizeError;
use crate::problem::PoseBounds;
use nalgebra::{Point3, Translation3, Vector3};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::rotation::{axis_rotation, exp_vector};
use trackwright_geometry::spread::{Position, farthest_first};
use trackwright_geometry::surface::{Surface, SurfacePoint};

/// A foot may be so far beside the patch: where a CRF was put by a search, the nearest point of a
/// curved surface is some tenths of a millimetre beside the foot that it was put at.
const BESIDE_MM: f64 = 2.0;

/// Feet that are tried before the search begins, and turns of each.
const FEET: usize = 64;
const TURNS: [f64; 3] = [0.0, -1.0, 1.0];

/// Where the CRF stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FootPose {
    /// Mesh frame.
    pub foot: SurfacePoint,
    /// About the normal at the foot.
    pub turn_deg: f64,
}

/// A CRF that may be moved over a patch.
pub(crate) struct Footing<'a> {
    patch: &'a CrfPatch,
    surface: &'a Surface,
    bounds: PoseBounds,
    /// Of the start.
    pub start: FootPose,
}

impl<'a> Footing<'a> {
    /// # Errors
    /// An anatomy without a surface, a patch without a point of it, and a CRF that does not stand on it.
    pub fn new(
        patch: &'a CrfPatch,
        middle_in_crf: &Point3<f64>,
        bounds: PoseBounds,
    ) -> Result<Self, OptimizeError> {
        let anatomy = || patch.anatomy.clone();
        let Some(surface) = patch.surface.as_deref() else {
            return Err(OptimizeError::NoPatchSurface { anatomy: anatomy() });
        };
        if patch.points_mm.is_empty() {
            return Err(OptimizeError::EmptyPatch {
                anatomy: anatomy(),
                off_mm: patch.off_mm(surface),
            });
        }
        let middle = patch.crf_from_mesh.inverse() * middle_in_crf;
        let nearest = surface.closest(&middle);
        let at = nearest.position_mm;
        let away_mm = |point: &Point3<f64>| (point - at).norm();
        let of_patch = patch.points_mm.iter().min_by(|a, b| away_mm(a).total_cmp(&away_mm(b)));
        // What is nearest on the surface to a point of the boxes may be a hair beside them.
        let others = patch.clamped(&at).into_iter().chain(of_patch.copied());
        let mut feet = std::iter::once(nearest).chain(others.map(|at| surface.closest(&at)));
        let foot = feet.find(|foot| {
            patch.contains(&foot.position_mm) && away_mm(&foot.position_mm) <= BESIDE_MM
        });
        let Some(foot) = foot else {
            return Err(OptimizeError::BesidePatch {
                anatomy: anatomy(),
                foot_mm: at.coords.into(),
                off_mm: of_patch.map_or(f64::INFINITY, away_mm),
            });
        };
        Ok(Self { patch, surface, bounds, start: FootPose { foot, turn_deg: 0.0 } })
    }

    /// Numbers that move a pose of the foot: a way of the foot, and a turn.
    pub const DIMENSIONS: usize = 4;

    /// After a way of the foot in mm and a turn in degrees, allowed or not: to the point of the surface
    /// that is nearest to the displaced foot. The turn is kept within its bound.
    pub fn moved(&self, from: &FootPose, way_mm: &Vector3<f64>, turn_deg: f64) -> FootPose {
        let most_deg = self.bounds.turn_deg;
        FootPose {
            foot: self.surface.closest(&(from.foot.position_mm + way_mm)),
            turn_deg: (from.turn_deg + turn_deg).clamp(-most_deg, most_deg),
        }
    }

    /// Whether the foot is in the patch, and no farther from its start than the bounds allow along the
    /// CRF's own axes.
    pub fn is_allowed(&self, foot_pose: &FootPose) -> bool {
        let at = &foot_pose.foot.position_mm;
        let way_mm = self.patch.crf_from_mesh.rotation * (at - self.start.foot.position_mm);
        self.patch.contains(at) && (0..3).all(|k| way_mm[k].abs() <= self.bounds.shift_mm[k])
    }

    /// How the CRF was moved from its start, in its own axes.
    pub fn crf_moved(&self, foot_pose: &FootPose) -> Pose {
        let [from, to] = [&self.start.foot, &foot_pose.foot];
        let tilt = exp_vector(&axis_rotation(&from.normal, &to.normal).vector_rad);
        let turn = exp_vector(&(to.normal.into_inner() * foot_pose.turn_deg.to_radians()));
        let [back, forth] =
            [-from.position_mm.coords, to.position_mm.coords].map(Translation3::from);
        let moved_in_mesh = forth * (turn * tilt) * back;
        let crf_from_mesh = self.patch.crf_from_mesh;
        crf_from_mesh * moved_in_mesh * crf_from_mesh.inverse()
    }

    /// FootPoses that are spread over what is allowed.
    pub fn spread_out(&self) -> Vec<FootPose> {
        let foot = |at: &Point3<f64>| FootPose { foot: self.surface.closest(at), turn_deg: 0.0 };
        let all: Vec<FootPose> = self.patch.points_mm.iter().map(foot).collect();
        let allowed: Vec<FootPose> = all.into_iter().filter(|own| self.is_allowed(own)).collect();
        let position = |own: &FootPose| {
            let [x, y, z] = own.foot.position_mm.coords.into();
            [x, y, z, 0.0, 0.0, 0.0, 0.0]
        };
        let positions: Vec<Position> = allowed.iter().map(position).collect();
        let chosen = farthest_first(&positions, FEET.min(allowed.len()));
        let turned = chosen.into_iter().flat_map(|k| {
            let foot = allowed[k].foot;
            TURNS.map(|part| FootPose { foot, turn_deg: part * self.bounds.turn_deg })
        });
        turned.collect()
    }
}
