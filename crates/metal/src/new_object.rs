//! New objects of a room: their shapes, and where they are put at first.

use crate::material::NAMED_MATERIALS;
use crate::setup::{
    DEFAULT_TRIANGLES, MaterialTolerance, MetalObject, ObjectMaterial, ObjectShape, RoomMetal,
};
use nalgebra::{Point3, Vector3};
use trackwright_field::generator::Coil;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::pose::Pose;

/// How far outside the measurement volume a new object is put.
pub const CLEARANCE_MM: f64 = 100.0;

/// Between a new object and others, and coils.
const GAP_MM: f64 = 10.0;

/// A shape that needs no file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NewShape {
    Plate,
    Box,
    Sphere,
    Cylinder,
}

impl NewShape {
    pub const ALL: [Self; 4] = [Self::Plate, Self::Box, Self::Sphere, Self::Cylinder];

    /// The sizes that a person changes from there: a plate as in published tests of trackers, others
    /// as large as what is held in a hand.
    pub fn shape(self) -> ObjectShape {
        match self {
            Self::Plate => ObjectShape::Cuboid { size_mm: Vector3::new(200.0, 200.0, 10.0) },
            Self::Box => ObjectShape::Cuboid { size_mm: Vector3::repeat(100.0) },
            Self::Sphere => ObjectShape::Sphere { radius_mm: 50.0 },
            Self::Cylinder => ObjectShape::Cylinder { radius_mm: 25.0, length_mm: 150.0 },
        }
    }
}

impl RoomMetal {
    /// An object of aluminium, beside a measurement volume and clear of coils and other objects; it is
    /// not yet among the room's.
    pub fn new_object(&self, shape: ObjectShape, what: &str, volume_mm: &Bounds) -> MetalObject {
        MetalObject {
            name: self.free_name(what),
            tracker_from_object: self.free_pose(shape.reach_mm(), volume_mm),
            shape,
            material: ObjectMaterial::Named(NAMED_MATERIALS[0].key),
            most_triangles: DEFAULT_TRIANGLES,
            tolerance: MaterialTolerance::default(),
        }
    }

    /// Beside the volume's face of largest x, and farther along x where something else is.
    fn free_pose(&self, reach_mm: f64, volume_mm: &Bounds) -> Pose {
        let coils = self.generator.coils.iter().map(|coil| match coil {
            Coil::Dipole { at_mm, .. } => (*at_mm, 0.0),
            Coil::SquareLoop { center_mm, side_mm, .. } => (*center_mm, *side_mm),
        });
        let objects = self.objects.iter().map(|object| {
            let at_mm = Point3::from(object.tracker_from_object.translation.vector);
            (at_mm, object.shape.reach_mm())
        });
        let taken: Vec<(Point3<f64>, f64)> = coils.chain(objects).collect();
        let mut at_mm = volume_mm.center_mm();
        at_mm.x = volume_mm.max_mm.x + CLEARANCE_MM + reach_mm;
        let is_in = |at: &Point3<f64>, (other, other_reach_mm): &(Point3<f64>, f64)| {
            (at - other).norm() < reach_mm + other_reach_mm + GAP_MM
        };
        // Each step passes one of them for good.
        while let Some((other, other_reach_mm)) = taken.iter().find(|taken| is_in(&at_mm, taken)) {
            at_mm.x = other.x + reach_mm + other_reach_mm + 2.0 * GAP_MM;
        }
        Pose::translation(at_mm.x, at_mm.y, at_mm.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::furnished::Furnisher;
    use std::sync::Arc;
    use trackwright_field::generator::Generator;
    use trackwright_field::samples::MapKind;
    use trackwright_field::{DistortionModel, Environment};
    use trackwright_geometry::volume::Volume;
    use trackwright_task::Task;

    #[test]
    fn new_objects_are_clear_of_all_others() {
        let volume = Volume::AuroraCube.bounds();
        let mut room = RoomMetal::empty(Generator::planar_nine());
        for shape in NewShape::ALL.into_iter().chain(NewShape::ALL) {
            let shape = shape.shape();
            let object = room.new_object(shape.clone(), shape.label(), &volume);
            room.objects.push(object);
        }
        assert_eq!(room.check(), Ok(()));
        let names: Vec<_> = room.objects.iter().map(|object| object.name.as_str()).collect();
        let labels = ["plate", "box", "sphere", "cylinder"];
        assert_eq!(names[..4], labels);
        assert_eq!(names[4..], labels.map(|label| format!("{label} 2")));
        for (index, object) in room.objects.iter().enumerate() {
            let at = object.tracker_from_object.translation.vector;
            let reach_mm = object.shape.reach_mm();
            assert!(at.x - reach_mm >= volume.max_mm.x + CLEARANCE_MM - 1e-9, "{at}");
            for other in &room.objects[..index] {
                let apart_mm = (other.tracker_from_object.translation.vector - at).norm();
                assert!(apart_mm > reach_mm + other.shape.reach_mm(), "{index} {apart_mm}");
            }
        }
    }

    #[test]
    fn a_new_plate_can_be_solved_for() {
        let volume = Volume::AuroraCube;
        let mut room = RoomMetal::empty(Generator::planar_nine());
        let plate = room.new_object(NewShape::Plate.shape(), "plate", &volume.bounds());
        // Fewer triangles: whether it is solved for does not depend on them.
        room.objects.push(MetalObject { most_triangles: 200, ..plate });
        let model = DistortionModel::zero(volume.bounds(), MapKind::Distortion);
        let bare = Environment { volume: Some(volume), ..Environment::of_model("bare", model) };
        let task = Task::default();
        let furnished = Furnisher::default().furnish(&Arc::new(bare), &room, &task).unwrap();
        assert!(!furnished.environment.model.is_zero());
    }
}
