//! The metal of a room as a person puts it there: objects with a name, a shape, a material and a pose,
//! beside a generator of one frequency.

use crate::material::{Material, MaterialError, NAMED_MATERIALS, NamedMaterial, check_frequency};
use crate::shapes::{self, ShapeError};
use crate::surface::MAX_TRIANGLES;
use nalgebra::{Point3, Vector3};
use std::sync::Arc;
use trackwright_field::generator::{Generator, GeneratorError};
use trackwright_geometry::limits::position_problem;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::MeshReference;
use trackwright_geometry::pose::{Pose, is_finite};

/// Frequency of a generator that states none: within the band of trackers for surgery.
pub const DEFAULT_FREQUENCY_HZ: f64 = 10e3;

/// Triangles of an object that states none: a plate of them follows the hand.
pub const DEFAULT_TRIANGLES: usize = 400;

/// Fewest triangles that an object is cut into.
pub const MIN_TRIANGLES: usize = shapes::MIN_TRIANGLES;

/// Of a normal distribution, 95 % are within so many standard deviations.
pub(crate) const WITHIN_95: f64 = 1.959_964;

/// Most objects of a room.
pub const MAX_OBJECTS: usize = 32;

/// Metal around a generator.
#[derive(Clone, Debug, PartialEq)]
pub struct RoomMetal {
    pub generator: Generator,
    /// Of the generator's coils.
    pub frequency_hz: f64,
    pub objects: Vec<MetalObject>,
}

/// A metal object and where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct MetalObject {
    pub name: String,
    pub shape: ObjectShape,
    pub material: ObjectMaterial,
    pub tracker_from_object: Pose,
    /// Triangles that its surface is cut into at most; none of a sphere.
    pub most_triangles: usize,
    pub tolerance: MaterialTolerance,
}

/// A form and how many triangles stand for it.
pub(crate) type ShapeKey = (ObjectShape, usize);

/// How well a material is known: so far from what is stated, as parts of it, are 95 % of such parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialTolerance {
    pub conductivity: f64,
    /// Of what the permeability exceeds 1 by.
    pub permeability: f64,
}

impl Default for MaterialTolerance {
    /// Alloys of aluminium have 50 to 95 % of the conductivity of the pure metal, other alloys vary by some 5 %,
    /// and few people know theirs. Permeabilities of ferromagnetic steels vary by a factor of several with heat
    /// treatment and field strength.
    fn default() -> Self {
        Self { conductivity: 0.34, permeability: 3.0 }
    }
}

impl MaterialTolerance {
    /// Largest that can be stated: a factor of a hundred.
    pub const MAX: f64 = 99.0;

    /// Standard deviations of the logarithms.
    pub fn conductivity_log_std(&self) -> f64 {
        self.conductivity.ln_1p() / WITHIN_95
    }

    /// Likewise of what the permeability exceeds 1 by.
    pub fn permeability_log_std(&self) -> f64 {
        self.permeability.ln_1p() / WITHIN_95
    }

    fn problem(&self) -> Option<f64> {
        let both = [self.conductivity, self.permeability];
        both.into_iter().find(|part| !(0.0..=Self::MAX).contains(part))
    }
}

/// The form of an object in its own frame, about the origin; lengths in mm.
#[derive(Clone, Debug, PartialEq)]
pub enum ObjectShape {
    Sphere {
        radius_mm: f64,
    },
    /// A box or, where it is flat, a plate; along the axes.
    Cuboid {
        size_mm: Vector3<f64>,
    },
    /// Along z.
    Cylinder {
        radius_mm: f64,
        length_mm: f64,
    },
    Mesh(ObjectMesh),
}

/// A closed mesh, and the file that it is from.
#[derive(Clone, Debug)]
pub struct ObjectMesh {
    /// Relative to the file of the room.
    pub reference: MeshReference,
    pub surface: Arc<SurfaceMesh>,
}

impl PartialEq for ObjectMesh {
    fn eq(&self, other: &Self) -> bool {
        let is_same = Arc::ptr_eq(&self.surface, &other.surface) || self.surface == other.surface;
        self.reference == other.reference && is_same
    }
}

/// What an object is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectMaterial {
    /// One of [`NAMED_MATERIALS`], by its key.
    Named(&'static str),
    Own(Material),
}

/// Why metal cannot be that of a room. Objects are counted from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SetupError {
    #[error("generator: {0}")]
    Generator(#[from] GeneratorError),
    #[error(transparent)]
    Frequency(#[from] MaterialError),
    #[error("{0} objects, expected at most {MAX_OBJECTS}")]
    TooManyObjects(usize),
    #[error("object {0}: the name is empty, expected one")]
    NoName(usize),
    #[error("the name {0:?} is that of two objects")]
    NameTwice(String),
    #[error("{name}: {cause}")]
    Shape { name: String, cause: ShapeError },
    #[error("{name}: {found} triangles, expected {MIN_TRIANGLES} to {MAX_TRIANGLES}")]
    Triangles { name: String, found: usize },
    #[error(
        "{name}: a tolerance of {found}, expected 0 to {max}: a part of the conductivity, or of what the permeability exceeds 1 by",
        max = MaterialTolerance::MAX
    )]
    Tolerance { name: String, found: f64 },
    #[error("{name}: the pose is not finite, or farther than 1e6 mm")]
    Pose { name: String },
}

impl RoomMetal {
    /// A generator without metal.
    pub fn empty(generator: Generator) -> Self {
        Self { generator, frequency_hz: DEFAULT_FREQUENCY_HZ, objects: Vec::new() }
    }

    /// The first reason why this is no metal of a room.
    ///
    /// # Errors
    /// See [`SetupError`].
    pub fn check(&self) -> Result<(), SetupError> {
        if let Some(problem) = self.generator.problem() {
            return Err(problem.into());
        }
        check_frequency(self.frequency_hz)?;
        if self.objects.len() > MAX_OBJECTS {
            return Err(SetupError::TooManyObjects(self.objects.len()));
        }
        for (index, object) in self.objects.iter().enumerate() {
            object.check(index)?;
            if self.objects[..index].iter().any(|other| other.name == object.name) {
                return Err(SetupError::NameTwice(object.name.clone()));
            }
        }
        Ok(())
    }

    /// The metal with the surfaces that `mesh` has for the references of its meshes.
    ///
    /// # Errors
    /// Those of `mesh`.
    pub fn with_surfaces<E>(
        mut self,
        mut mesh: impl FnMut(&MeshReference) -> Result<Arc<SurfaceMesh>, E>,
    ) -> Result<Self, E> {
        for object in &mut self.objects {
            if let ObjectShape::Mesh(own) = &mut object.shape {
                own.surface = mesh(&own.reference)?;
            }
        }
        Ok(self)
    }

    /// The files of its meshes, relative to the file of the room.
    pub fn mesh_files(&self) -> impl Iterator<Item = &str> {
        self.objects.iter().filter_map(|object| match &object.shape {
            ObjectShape::Mesh(mesh) => Some(mesh.reference.file.as_str()),
            _ => None,
        })
    }

    /// A name for a new object, from what it is: `plate`, then `plate 2`.
    pub fn free_name(&self, what: &str) -> String {
        let is_free = |name: &String| self.objects.iter().all(|object| object.name != *name);
        let numbered = (2..).map(|number| format!("{what} {number}"));
        std::iter::once(what.to_owned()).chain(numbered).find(is_free).unwrap_or_default()
    }
}

impl MetalObject {
    /// What its surface depends on.
    pub(crate) fn key(&self) -> ShapeKey {
        (self.shape.clone(), self.most_triangles)
    }

    fn check(&self, index: usize) -> Result<(), SetupError> {
        let name = || self.name.clone();
        if self.name.trim().is_empty() {
            return Err(SetupError::NoName(index));
        }
        self.shape.check().map_err(|cause| SetupError::Shape { name: name(), cause })?;
        if !(MIN_TRIANGLES..=MAX_TRIANGLES).contains(&self.most_triangles) {
            return Err(SetupError::Triangles { name: name(), found: self.most_triangles });
        }
        if let Some(found) = self.tolerance.problem() {
            return Err(SetupError::Tolerance { name: name(), found });
        }
        let at_mm = &self.tracker_from_object.translation.vector;
        if !is_finite(&self.tracker_from_object) || position_problem(at_mm).is_some() {
            return Err(SetupError::Pose { name: name() });
        }
        Ok(())
    }
}

impl ObjectShape {
    /// # Errors
    /// A length that no shape has.
    pub fn check(&self) -> Result<(), ShapeError> {
        let of = |lengths: &[(&'static str, f64)]| {
            lengths.iter().try_for_each(|(name, length_mm)| shapes::check_length(name, *length_mm))
        };
        match self {
            Self::Sphere { radius_mm } => of(&[("radius", *radius_mm)]),
            Self::Cuboid { size_mm } => {
                of(&[("width", size_mm.x), ("depth", size_mm.y), ("height", size_mm.z)])
            }
            Self::Cylinder { radius_mm, length_mm } => {
                of(&[("radius", *radius_mm), ("length", *length_mm)])
            }
            Self::Mesh(_) => Ok(()),
        }
    }

    /// What a person calls it.
    pub fn label(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Cuboid { size_mm } if size_mm.min() <= PLATE_PART * size_mm.max() => "plate",
            Self::Cuboid { .. } => "box",
            Self::Cylinder { .. } => "cylinder",
            Self::Mesh(_) => "mesh",
        }
    }

    /// What is drawn of it; at most as many triangles where it is round.
    ///
    /// # Errors
    /// As [`ObjectShape::check`].
    pub fn drawn(&self) -> Result<Arc<SurfaceMesh>, ShapeError> {
        Ok(match self {
            Self::Sphere { radius_mm } => Arc::new(shapes::sphere(*radius_mm, 3)?),
            Self::Cuboid { size_mm } => Arc::new(shapes::cuboid(size_mm, MIN_TRIANGLES)?),
            Self::Cylinder { radius_mm, length_mm } => {
                Arc::new(shapes::cylinder(*radius_mm, *length_mm, DRAWN_TRIANGLES)?)
            }
            Self::Mesh(mesh) => Arc::clone(&mesh.surface),
        })
    }

    /// The farthest that it reaches from its origin, in mm.
    pub fn reach_mm(&self) -> f64 {
        match self {
            Self::Sphere { radius_mm } => *radius_mm,
            Self::Cuboid { size_mm } => size_mm.norm() / 2.0,
            Self::Cylinder { radius_mm, length_mm } => radius_mm.hypot(length_mm / 2.0),
            Self::Mesh(mesh) => {
                let bounds = mesh.surface.body_bounds();
                bounds.map_or(0.0, |bounds| {
                    let corner = |k: usize| bounds.min_mm[k].abs().max(bounds.max_mm[k].abs());
                    Point3::new(corner(0), corner(1), corner(2)).coords.norm()
                })
            }
        }
    }
}

/// A box whose least side is at most this part of its largest is called a plate.
const PLATE_PART: f64 = 0.2;

/// Triangles of a drawn cylinder: its ring is smooth at the size of a hand.
const DRAWN_TRIANGLES: usize = 400;

impl ObjectMaterial {
    /// One that has a name, by its key; `None` where none has it.
    pub fn named(key: &str) -> Option<Self> {
        NAMED_MATERIALS.iter().find(|named| named.key == key).map(|named| Self::Named(named.key))
    }

    pub fn material(&self) -> Material {
        match self {
            Self::Named(key) => Self::listed(key).material,
            Self::Own(material) => *material,
        }
    }

    /// What a person calls it; conductivity and permeability of one without a name.
    pub fn label(&self) -> String {
        match self {
            Self::Named(key) => Self::listed(key).label.to_owned(),
            Self::Own(material) => format!(
                "{} MS/m, µ {}",
                material.conductivity_s_per_m() / 1e6,
                material.relative_permeability()
            ),
        }
    }

    fn listed(key: &str) -> &'static NamedMaterial {
        // [`Self::named`] takes keys from the list.
        NAMED_MATERIALS.iter().find(|named| named.key == key).unwrap_or(&NAMED_MATERIALS[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plate(name: &str) -> MetalObject {
        MetalObject {
            name: name.to_owned(),
            shape: ObjectShape::Cuboid { size_mm: Vector3::new(200.0, 200.0, 10.0) },
            material: ObjectMaterial::Named("aluminium"),
            tracker_from_object: Pose::translation(0.0, 0.0, -600.0),
            most_triangles: DEFAULT_TRIANGLES,
            tolerance: MaterialTolerance::default(),
        }
    }

    #[test]
    fn metal_that_cannot_be_is_named() {
        let room = RoomMetal {
            objects: vec![plate("a"), plate("b")],
            ..RoomMetal::empty(Generator::planar_nine())
        };
        assert_eq!(room.check(), Ok(()));
        type Change = fn(&mut RoomMetal);
        let cases: [(Change, &str); 8] = [
            (|room| room.generator.coils.truncate(4), "generator: 4 coils"),
            (|room| room.frequency_hz = f64::NAN, "frequency is NaN Hz"),
            (|room| room.objects[1].name = "a".to_owned(), "the name \"a\" is that of two"),
            (|room| room.objects[1].name = " ".to_owned(), "object 1: the name is empty"),
            (|room| room.objects[0].most_triangles = 1_000_000, "a: 1000000 triangles, expected"),
            (
                |room| room.objects[0].shape = ObjectShape::Sphere { radius_mm: -1.0 },
                "a: radius is -1 mm",
            ),
            (
                |room| room.objects[0].tracker_from_object.translation.x = f64::INFINITY,
                "a: the pose is not finite",
            ),
            (|room| room.objects = vec![plate("a"); 33], "33 objects, expected at most 32"),
        ];
        for (change, message) in cases {
            let mut changed = room.clone();
            change(&mut changed);
            let error = changed.check().unwrap_err().to_string();
            assert!(error.starts_with(message), "{error}");
        }
    }

    #[test]
    fn names_of_new_objects_are_free() {
        let mut room = RoomMetal::empty(Generator::planar_nine());
        assert_eq!(room.free_name("plate"), "plate");
        room.objects.push(plate("plate"));
        assert_eq!(room.free_name("plate"), "plate 2");
    }

    #[test]
    fn a_flat_box_is_a_plate() {
        assert_eq!(plate("a").shape.label(), "plate");
        let cube = ObjectShape::Cuboid { size_mm: Vector3::repeat(50.0) };
        assert_eq!(cube.label(), "box");
    }
}
