//! What is under the pointer of a tool: a point of a body's surface, or why there is none.

use crate::viewport::surfaces::Surfaces;
use trackwright_design::{BodyRole, Design};
use trackwright_geometry::surface::{Ray, SurfacePoint};
use trackwright_geometry::surface_drag::SurfaceDirections;
use trackwright_project::World;

/// A point of a body under the pointer, body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AimedPoint {
    pub body: BodyRole,
    pub at: SurfacePoint,
    pub directions: SurfaceDirections,
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
    let view = world.document.view();
    let shown = BodyRole::ALL.map(|role| (!view.hidden.has_body(role)).then_some(role));
    let shown: Vec<BodyRole> = shown.into_iter().flatten().collect();
    let is_locked = |role: &BodyRole| view.locked.has_body(*role);
    let (locked, free): (Vec<BodyRole>, Vec<BodyRole>) = shown.iter().copied().partition(is_locked);
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
    let (Some(surface), Some(mesh)) = (surfaces.of(body), world.mesh(body)) else {
        let without_mesh = Some(body);
        return Err(Miss::Beside { without_mesh });
    };
    let directions = SurfaceDirections::near(surface, &at.position_mm, mesh.long_axis());
    Ok(AimedPoint { body, at, directions })
}
