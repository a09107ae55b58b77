//! What is under the pointer of a tool: a point of a body's surface, or why there is none.

use crate::viewport::surfaces::Surfaces;
use nalgebra::Point3;
use trackwright_design::{BodyRole, Design};
use trackwright_geometry::gizmo::Eye;
use trackwright_geometry::snap::{SnapKind, SnapPoint};
use trackwright_geometry::surface::{Ray, SurfacePoint};
use trackwright_geometry::surface_drag::SurfaceDirections;
use trackwright_project::World;

/// A point of a body under the pointer, body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AimedPoint {
    pub body: BodyRole,
    pub at: SurfacePoint,
    pub directions: SurfaceDirections,
    /// What it snapped to.
    pub snap: Option<SnapKind>,
}

/// Why nothing can be put where the pointer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Miss {
    /// Beside every body; the one that is drawn without a mesh, if there is one.
    Beside {
        without_mesh: Option<BodyRole>,
    },
    Locked(BodyRole),
}

impl std::fmt::Display for Miss {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Beside { without_mesh: None } => f.write_str("no body under the pointer"),
            Self::Beside { without_mesh: Some(role) } => {
                write!(f, "no body under the pointer, and the {role} has no mesh")
            }
            Self::Locked(role) => write!(f, "the {role} is locked"),
        }
    }
}

/// The nearest point on a ray of the tracker frame of a body that is neither hidden nor locked,
/// with the bodies as `design` has them.
///
/// # Errors
/// Why there is none.
pub fn aim_at(
    world: &World,
    design: &Design,
    surfaces: &Surfaces,
    ray: &Ray,
) -> Result<AimedPoint, Miss> {
    let (free, locked) = shown_bodies(world);
    let Some((body, at)) = surfaces.hit(design, ray, &free) else {
        return Err(match surfaces.hit(design, ray, &locked) {
            Some((role, _)) => Miss::Locked(role),
            None => {
                let has_no_mesh =
                    |role: &BodyRole| design.body(*role).is_some() && surfaces.of(*role).is_none();
                let without_mesh = free.into_iter().find(has_no_mesh);
                Miss::Beside { without_mesh }
            }
        });
    };
    aimed(world, surfaces, body, at, None).ok_or(Miss::Beside { without_mesh: Some(body) })
}

/// Where the tip goes: the point of a body that the pointer snaps to, else the one under it.
///
/// # Errors
/// Why there is none.
pub fn aim_tip(
    world: &World,
    design: &Design,
    surfaces: &Surfaces,
    ray: &Ray,
    eye: &Eye,
) -> Result<AimedPoint, Miss> {
    let (free, _) = shown_bodies(world);
    let depth_mm = |role: BodyRole, at_mm: &Point3<f64>| {
        let at_mm = design.tracker_from_body(role)? * at_mm;
        Some((at_mm - ray.origin_mm).dot(&ray.direction))
    };
    let snapped = free.iter().filter_map(|role| {
        let point = snap_on(design, surfaces, ray, eye, *role)?;
        Some((*role, point, depth_mm(*role, &point.at_mm)?))
    });
    let nearest = snapped.min_by(|a, b| a.1.kind.cmp(&b.1.kind).then(a.2.total_cmp(&b.2)));
    let Some((role, point, depth)) = nearest else {
        return aim_at(world, design, surfaces, ray);
    };
    // Another body may stand before it.
    let is_covered = surfaces.hit(design, ray, &free).is_some_and(|(hit, at)| {
        hit != role && depth_mm(hit, &at.position_mm).is_some_and(|before| before < depth)
    });
    let normal = surfaces.of(role).map(|surface| surface.closest(&point.at_mm).normal);
    let snapped = normal.filter(|_| !is_covered).and_then(|normal| {
        let at = SurfacePoint { position_mm: point.at_mm, normal };
        aimed(world, surfaces, role, at, Some(point.kind))
    });
    snapped.map_or_else(|| aim_at(world, design, surfaces, ray), Ok)
}

/// The point of a body that a pointer snaps to, with its ray in the tracker frame.
pub fn snap_on(
    design: &Design,
    surfaces: &Surfaces,
    ray: &Ray,
    eye: &Eye,
    role: BodyRole,
) -> Option<SnapPoint> {
    let in_body = ray.transformed_by(&design.tracker_from_body(role)?.inverse());
    surfaces.snap_points(role)?.under(&in_body, eye, surfaces.of(role)?)
}

/// The bodies that are shown: those that can be changed, and those that are locked.
fn shown_bodies(world: &World) -> (Vec<BodyRole>, Vec<BodyRole>) {
    let view = world.document.view();
    let shown = BodyRole::ALL.into_iter().filter(|role| !view.hidden.has_body(*role));
    shown.partition(|role| !view.locked.has_body(*role))
}

/// A point of a body with the directions of its surface; `None` without a mesh.
fn aimed(
    world: &World,
    surfaces: &Surfaces,
    body: BodyRole,
    at: SurfacePoint,
    snap: Option<SnapKind>,
) -> Option<AimedPoint> {
    let (surface, mesh) = (surfaces.of(body)?, world.mesh(body)?);
    let directions = SurfaceDirections::near(surface, &at.position_mm, mesh.long_axis());
    Some(AimedPoint { body, at, directions, snap })
}
