//! Coils that do not fit: found once an edit, shown in the scene and the panels.

use crate::document::requests::OpenWorld;
use crate::schedule::EditorSystems;
use crate::viewport::surfaces::Surfaces;
use bevy::prelude::*;
use std::sync::Arc;
use trackwright_design::BodyRole;
use trackwright_geometry::surface::Surface;
use trackwright_simulation::{CoilFinding, Sensor};

/// Keeps [`CoilFindings`].
pub struct CoilFitPlugin;

/// What is wrong with where the open design's coils are, body by body.
#[derive(Resource, Default)]
pub struct CoilFindings([Option<OfBody>; 2]);

/// Of one body, and what it was found from.
struct OfBody {
    sensors: Vec<Sensor>,
    surface: Option<Arc<Surface>>,
    findings: Vec<CoilFinding>,
}

impl OfBody {
    fn is_of(&self, sensors: &[Sensor], surface: Option<&Arc<Surface>>) -> bool {
        let is_same_surface = match (&self.surface, surface) {
            (Some(own), Some(other)) => Arc::ptr_eq(own, other),
            (None, None) => true,
            _ => false,
        };
        is_same_surface && self.sensors == sensors
    }
}

impl CoilFindings {
    /// Of a body.
    pub fn of(&self, role: BodyRole) -> &[CoilFinding] {
        self.0[role as usize].as_ref().map_or(&[], |own| &own.findings)
    }
}

/// The findings of both bodies, for whoever draws them.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShownFindings<'a>([&'a [CoilFinding]; 2]);

impl<'a> ShownFindings<'a> {
    /// None where nothing keeps any.
    pub fn new(findings: Option<&'a CoilFindings>) -> Self {
        Self(findings.map_or([&[], &[]], |own| BodyRole::ALL.map(|role| own.of(role))))
    }

    /// Of one body, whose findings are given.
    pub fn of_body(role: BodyRole, findings: &'a [CoilFinding]) -> Self {
        let mut all = Self::default();
        all.0[role as usize] = findings;
        all
    }

    /// Of a sensor.
    pub fn of(self, role: BodyRole, index: usize) -> impl Iterator<Item = &'a CoilFinding> {
        self.0[role as usize].iter().filter(move |finding| finding.index == index)
    }
}

impl Plugin for CoilFitPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CoilFindings>().add_systems(
            Update,
            find.run_if(
                resource_exists_and_changed::<OpenWorld>
                    .or_else(resource_exists_and_changed::<Surfaces>),
            )
            .run_if(resource_exists::<OpenWorld>)
            .in_set(EditorSystems::Sample),
        );
    }
}

/// A body whose sensors and mesh are as they were is not searched again.
fn find(
    world: Res<OpenWorld>,
    surfaces: Option<Res<Surfaces>>,
    mut findings: ResMut<CoilFindings>,
) {
    let design = world.0.document.design();
    for role in BodyRole::ALL {
        let sensors = design.body(role).map_or(&[][..], |body| &body.rigid.sensors);
        let surface = surfaces.as_ref().and_then(|surfaces| surfaces.of(role));
        let known = findings.0[role as usize].as_ref();
        if known.is_some_and(|known| known.is_of(sensors, surface)) {
            continue;
        }
        let own = surface.map(|surface| &**surface);
        findings.0[role as usize] = Some(OfBody {
            findings: trackwright_project::coil_findings_of(role, sensors, own),
            sensors: sensors.to_vec(),
            surface: surface.cloned(),
        });
    }
}
