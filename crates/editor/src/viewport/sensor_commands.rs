//! What can be done to the selected sensors by name, and the edits that it makes; a metal object that is
//! selected can be removed in the same way.

use crate::document::requests::EditRequest;
use crate::document::selection::{Selected, Selection};
use nalgebra::Vector3;
use trackwright_design::{Arrangement, BodyRole, Edit, MetalEdit, MirrorPlane};
use trackwright_geometry::surface::Surface;
use trackwright_geometry::surface_drag::SurfaceDirections;
use trackwright_project::World;
use trackwright_simulation::Sensor;

/// Something done to every selected sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SensorCommand {
    Duplicate,
    /// Opens the page for how many, how far apart and in which direction.
    Row,
    Remove,
    Mirror(MirrorPlane),
    MirrorCopy(MirrorPlane),
    MakeMarker,
    MakeFiveDof,
    MakeSixDof,
    /// Each axis along the surface's normal at its sensor.
    AlongNormal,
    /// Each axis along the shaft at its sensor.
    AlongShaft,
}

impl SensorCommand {
    /// Whether it would change anything of what is selected.
    pub fn is_available(self, world: &World, selection: &Selection) -> bool {
        let Some(picked) = Picked::of(world, selection) else {
            return self == Self::Remove && selected_metal(world, selection).is_some();
        };
        let is_any_other_than = |dof| {
            let mut sensors = picked.sensors();
            sensors.any(|(_, sensor)| sensor.orientation.degrees_of_freedom() != dof)
        };
        match self {
            // A body keeps one sensor at least.
            Self::Remove => picked.indices.len() < picked.all.len(),
            Self::MakeMarker => is_any_other_than(3),
            Self::MakeFiveDof => is_any_other_than(5),
            Self::MakeSixDof => is_any_other_than(6),
            // A marker has no axis.
            Self::AlongNormal | Self::AlongShaft => {
                world.mesh(picked.body).is_some() && is_any_other_than(3)
            }
            Self::Duplicate | Self::Row | Self::Mirror(_) | Self::MirrorCopy(_) => true,
        }
    }

    /// The requests that carry it out as one undo step; none where it is not available, nor for
    /// a row, which its page makes. `surface` is that of the sensors' body.
    pub fn requests(
        self,
        world: &World,
        selection: &Selection,
        surface: Option<&Surface>,
    ) -> Vec<EditRequest> {
        let Some(picked) = Picked::of(world, selection) else {
            let metal = selected_metal(world, selection).filter(|_| self == Self::Remove);
            let remove = metal.map(|index| Edit::Metal(MetalEdit::Remove { index }));
            return remove.map(EditRequest::Apply).into_iter().collect();
        };
        match self {
            Self::Duplicate => picked.arranged(Arrangement::Duplicate),
            Self::Row => Vec::new(),
            Self::Remove => vec![EditRequest::Apply(Edit::RemoveSensors {
                body: picked.body,
                indices: picked.indices,
            })],
            Self::Mirror(plane) => picked.arranged(Arrangement::Mirror(plane)),
            Self::MirrorCopy(plane) => picked.arranged(Arrangement::MirrorCopy(plane)),
            Self::MakeMarker => picked.arranged(Arrangement::MakeMarker),
            Self::MakeFiveDof => picked.arranged(Arrangement::MakeFiveDof),
            Self::MakeSixDof => picked.arranged(Arrangement::MakeSixDof),
            Self::AlongNormal => picked.aligned(world, surface, |at| at.normal.into_inner()),
            Self::AlongShaft => picked.aligned(world, surface, |at| at.along.into_inner()),
        }
    }
}

/// The metal object that is selected.
pub(crate) fn selected_metal(world: &World, selection: &Selection) -> Option<usize> {
    match selection.primary()? {
        Selected::Metal(index) => world.document.design().metal_object(index).map(|_| index),
        _ => None,
    }
}

/// The selected sensors of a design.
struct Picked<'a> {
    body: BodyRole,
    indices: Vec<usize>,
    /// Every sensor of the body.
    all: &'a [Sensor],
}

impl<'a> Picked<'a> {
    fn of(world: &'a World, selection: &Selection) -> Option<Self> {
        let (body, indices) = selection.sensors()?;
        let all = &world.document.design().body(body)?.rigid.sensors;
        Some(Self { body, indices, all })
    }

    fn sensors(&self) -> impl Iterator<Item = (usize, &'a Sensor)> {
        let indices = self.indices.iter();
        indices.filter_map(|index| Some((*index, self.all.get(*index)?)))
    }

    fn arranged(self, arrangement: Arrangement) -> Vec<EditRequest> {
        vec![EditRequest::Apply(Edit::Arrange {
            body: self.body,
            indices: self.indices,
            arrangement,
        })]
    }

    /// Each sensor has a direction of its own: together they are one step.
    fn aligned(
        self,
        world: &World,
        surface: Option<&Surface>,
        direction: impl Fn(&SurfaceDirections) -> Vector3<f64>,
    ) -> Vec<EditRequest> {
        let (Some(surface), Some(mesh)) = (surface, world.mesh(self.body)) else {
            return Vec::new();
        };
        let long_axis = mesh.long_axis();
        let align = |(index, sensor): (usize, &Sensor)| {
            let at = SurfaceDirections::near(surface, &sensor.position_in_body, long_axis);
            Edit::Arrange {
                body: self.body,
                indices: vec![index],
                arrangement: Arrangement::Align { direction_in_body: direction(&at) },
            }
        };
        let edits: Vec<Edit> = self.sensors().map(align).collect();
        match edits.len() {
            // One has a label of its own.
            0 | 1 => edits.into_iter().map(EditRequest::Apply).collect(),
            count => EditRequest::step(format!("Align {count} sensors"), edits).collect(),
        }
    }
}
