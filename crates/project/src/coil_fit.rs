//! Whether the coils of an open design fit into its bodies' meshes.

use super::world::World;
use trackwright_design::BodyRole;
use trackwright_geometry::surface::Surface;
use trackwright_simulation::{CoilFinding, Sensor};

/// What is wrong with where coils are, tool before CRF; see
/// [`coil_findings`](trackwright_simulation::coil_findings). A body without its mesh is only searched
/// for coils in one place.
pub fn coil_findings(world: &World) -> Vec<CoilFinding> {
    let design = world.document.design();
    let of_body = |role: BodyRole| {
        let sensors = &design.body(role)?.rigid.sensors;
        let surface = world.mesh(role).and_then(|mesh| Surface::new(mesh));
        Some(coil_findings_of(role, sensors, surface.as_ref()))
    };
    BodyRole::ALL.into_iter().filter_map(of_body).flatten().collect()
}

/// The same of one body with its surface.
pub fn coil_findings_of(
    role: BodyRole,
    sensors: &[Sensor],
    surface: Option<&Surface>,
) -> Vec<CoilFinding> {
    let key = match role {
        BodyRole::Tool => "tool",
        BodyRole::Crf => "crf",
    };
    trackwright_simulation::coil_findings(key, sensors, surface)
}
