//! The metal of a room, as its environment's file and a recovery file hold it.

use super::error::FormatError;
use super::generator::{self, GeneratorEntry};
use super::ron_text::{self, PoseEntry, RonWriter};
use serde::Deserialize;
use std::sync::Arc;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::{MeshReference, MeshUnit};
use trackwright_geometry::number::shortest;
use trackwright_metal::material::{Material, NAMED_MATERIALS};
use trackwright_metal::setup::{
    DEFAULT_FREQUENCY_HZ, DEFAULT_TRIANGLES, MaterialTolerance, MetalObject, ObjectMaterial,
    ObjectMesh, ObjectShape, RoomMetal,
};

#[derive(Deserialize)]
#[serde(rename = "Metal", deny_unknown_fields)]
pub(super) struct RoomMetalEntry {
    generator: GeneratorEntry,
    frequency: Option<f64>,
    objects: Vec<ObjectEntry>,
}

#[derive(Deserialize)]
#[serde(rename = "Object", deny_unknown_fields)]
struct ObjectEntry {
    name: String,
    shape: ShapeEntry,
    material: MaterialEntry,
    pose: PoseEntry,
    triangles: Option<usize>,
    tolerance: Option<ToleranceEntry>,
}

#[derive(Deserialize)]
#[serde(rename = "Tolerance", deny_unknown_fields)]
struct ToleranceEntry {
    conductivity: Option<f64>,
    permeability: Option<f64>,
}

#[derive(Deserialize)]
#[serde(rename = "Shape", deny_unknown_fields)]
enum ShapeEntry {
    Sphere { radius: f64 },
    Cuboid { size: [f64; 3] },
    Cylinder { radius: f64, length: f64 },
    Mesh { file: String, unit: Option<MeshUnit> },
}

#[derive(Deserialize)]
#[serde(rename = "Material", deny_unknown_fields)]
enum MaterialEntry {
    Named(String),
    Own { conductivity: f64, permeability: f64 },
}

impl RoomMetalEntry {
    /// The metal, its meshes still without a surface.
    pub(super) fn check(self) -> Result<RoomMetal, FormatError> {
        let objects = self.objects.into_iter().enumerate();
        let metal = RoomMetal {
            generator: self.generator.check()?,
            frequency_hz: self.frequency.unwrap_or(DEFAULT_FREQUENCY_HZ),
            objects: objects
                .map(|(index, object)| object.check(index))
                .collect::<Result<_, _>>()?,
        };
        metal.check()?;
        Ok(metal)
    }
}

impl ObjectEntry {
    fn check(self, index: usize) -> Result<MetalObject, FormatError> {
        let place = format!("metal.objects[{index}] {:?}", self.name);
        Ok(MetalObject {
            shape: self.shape.check(&place)?,
            material: self.material.check(&place)?,
            tracker_from_object: self.pose.check(&format!("{place}: pose"))?,
            most_triangles: self.triangles.unwrap_or(DEFAULT_TRIANGLES),
            tolerance: self.tolerance.map_or(MaterialTolerance::default(), |tolerance| {
                let usual = MaterialTolerance::default();
                MaterialTolerance {
                    conductivity: tolerance.conductivity.unwrap_or(usual.conductivity),
                    permeability: tolerance.permeability.unwrap_or(usual.permeability),
                }
            }),
            name: self.name,
        })
    }
}

impl ShapeEntry {
    fn check(self, place: &str) -> Result<ObjectShape, FormatError> {
        Ok(match self {
            Self::Sphere { radius } => ObjectShape::Sphere { radius_mm: radius },
            Self::Cuboid { size } => ObjectShape::Cuboid { size_mm: size.into() },
            Self::Cylinder { radius, length } => {
                ObjectShape::Cylinder { radius_mm: radius, length_mm: length }
            }
            Self::Mesh { file, unit } => {
                let reference = MeshReference {
                    file: ron_text::file_name(format!("{place}: file"), file)?,
                    unit: ron_text::mesh_unit(format!("{place}: unit"), unit)?,
                };
                ObjectShape::Mesh(ObjectMesh {
                    reference,
                    surface: Arc::new(SurfaceMesh::default()),
                })
            }
        })
    }
}

impl MaterialEntry {
    fn check(self, place: &str) -> Result<ObjectMaterial, FormatError> {
        match self {
            Self::Named(key) => ObjectMaterial::named(&key).ok_or_else(|| {
                let names: Vec<_> = NAMED_MATERIALS.iter().map(|named| named.key).collect();
                FormatError::Material {
                    place: place.to_owned(),
                    found: key,
                    names: names.join(", "),
                }
            }),
            Self::Own { conductivity, permeability } => Material::new(conductivity, permeability)
                .map(ObjectMaterial::Own)
                .map_err(|cause| {
                    FormatError::field(format!("{place}: material"), cause, "one that can be")
                }),
        }
    }
}

/// Writes what [`RoomMetalEntry`] reads, an object a line.
pub(super) fn write(out: &mut RonWriter, metal: &RoomMetal) {
    out.fields("generator", |out| generator::write_parts(out, &metal.generator));
    out.field("frequency", shortest(metal.frequency_hz));
    out.lines("objects", metal.objects.iter().map(line));
}

fn line(object: &MetalObject) -> String {
    let shape = match &object.shape {
        ObjectShape::Sphere { radius_mm } => format!("Sphere(radius: {radius_mm:?})"),
        ObjectShape::Cuboid { size_mm } => {
            format!("Cuboid(size: {})", ron_text::tuple(size_mm.as_slice()))
        }
        ObjectShape::Cylinder { radius_mm, length_mm } => {
            format!("Cylinder(radius: {radius_mm:?}, length: {length_mm:?})")
        }
        ObjectShape::Mesh(mesh) => {
            let unit = mesh.reference.unit.map(|unit| format!(", unit: {unit:?}"));
            let file = ron_text::string(&mesh.reference.file);
            format!("Mesh(file: {file}{})", unit.unwrap_or_default())
        }
    };
    let material = match &object.material {
        ObjectMaterial::Named(key) => format!("Named({})", ron_text::string(key)),
        ObjectMaterial::Own(material) => format!(
            "Own(conductivity: {:?}, permeability: {:?})",
            material.conductivity_s_per_m(),
            material.relative_permeability()
        ),
    };
    let MaterialTolerance { conductivity, permeability } = object.tolerance;
    let tolerance = match object.tolerance == MaterialTolerance::default() {
        true => String::new(),
        false => {
            format!("tolerance: (conductivity: {conductivity:?}, permeability: {permeability:?}), ")
        }
    };
    format!(
        "(name: {}, shape: {shape}, material: {material}, {tolerance}triangles: {}, pose: {})",
        ron_text::string(&object.name),
        object.most_triangles,
        ron_text::pose(&object.tracker_from_object)
    )
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::environment::{self, EnvironmentFile};
    use crate::test_cases::assert_refused;
    use nalgebra::Vector3;
    use trackwright_field::generator::Generator;
    use trackwright_geometry::pose::Pose;
    use trackwright_geometry::volume::Volume;

    pub(crate) fn metal() -> RoomMetal {
        let object = |name: &str, shape, material| MetalObject {
            name: name.to_owned(),
            shape,
            material,
            tracker_from_object: Pose::translation(1.0 / 3.0, -1e-9, -600.0),
            most_triangles: 600,
            tolerance: MaterialTolerance::default(),
        };
        let mesh = ObjectMesh {
            reference: MeshReference { file: "c-arm.stl".to_owned(), unit: Some(MeshUnit::Inch) },
            surface: Arc::new(SurfaceMesh::default()),
        };
        let mut metal = RoomMetal {
            frequency_hz: 12_345.6,
            objects: vec![
                object(
                    "plate \"1\"",
                    ObjectShape::Cuboid { size_mm: Vector3::new(200.0, 0.1, 50.0) },
                    ObjectMaterial::Named("aluminium"),
                ),
                object(
                    "ball",
                    ObjectShape::Sphere { radius_mm: 30.0 },
                    ObjectMaterial::Named("copper"),
                ),
                object(
                    "rod",
                    ObjectShape::Cylinder { radius_mm: 10.0, length_mm: 300.0 },
                    ObjectMaterial::Own(Material::new(1e6, 80.0).unwrap()),
                ),
                object("C-arm", ObjectShape::Mesh(mesh), ObjectMaterial::Named("steel-304")),
            ],
            ..RoomMetal::empty(Generator::planar_nine())
        };
        metal.objects[2].tolerance = MaterialTolerance { conductivity: 0.1, permeability: 0.5 };
        metal
    }

    fn text() -> String {
        let bare = environment::tests::ideal(Volume::AuroraCube);
        environment::write(&bare, Some(&metal()))
    }

    fn read(text: &str) -> Result<EnvironmentFile, String> {
        environment::parse(text.as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_written_reads_back_to_the_bit() {
        let text = text();
        // A room of nothing but metal needs no model in its file.
        assert!(!text.contains("model:") && text.contains("volume: AuroraCube"));
        let file = read(&text).unwrap();
        assert_eq!(file.metal, Some(metal()));
        assert_eq!(file.environment, environment::tests::ideal(Volume::AuroraCube));
        assert_eq!(environment::write(&file.environment, file.metal.as_ref()), text);
        // A measured room keeps its model.
        let measured = environment::tests::room();
        let file = read(&environment::write(&measured, Some(&metal()))).unwrap();
        assert_eq!((file.environment, file.metal), (measured, Some(metal())));
    }

    #[test]
    fn frequency_and_triangles_may_be_left_out() {
        let text = text().replace("frequency: 12345.6,", "").replace("triangles: 600, ", "");
        let metal = read(&text).unwrap().metal.unwrap();
        assert_eq!(metal.frequency_hz, DEFAULT_FREQUENCY_HZ);
        assert_eq!(metal.objects[0].most_triangles, DEFAULT_TRIANGLES);
    }

    #[test]
    fn metal_that_cannot_be_is_refused() {
        let cases = r#"
            Named("aluminium") => Named("cheese")
                | metal.objects[0] "plate \"1\"": found the material "cheese", expected aluminium,
                | copper, titanium, steel-303, steel-304, steel-316, steel-416, bronze, ferrite
            conductivity: 1000000.0 => conductivity: -1 | …conductivity is -1 S/m…
            tolerance: (conductivity: 0.1 => tolerance: (conductivity: -0.1
                | …rod: a tolerance of -0.1, expected 0 to 99…
            radius: 30.0 => radius: NaN | …ball: radius is NaN mm…
            name: "ball" => name: "rod" | …the name "rod" is that of two objects…
            frequency: 12345.6 => frequency: -1 | …frequency is -1 Hz…
            triangles: 600 => triangles: 1000000 | …1000000 triangles, expected 48 to…
            file: "c-arm.stl" => file: "" | metal.objects[3] "C-arm": file is empty…
            -600.0) => inf) | metal.objects[0] "plate \"1\"": pose.position…
            volume: AuroraCube,\n => | model is missing, expected a model, or a volume with metal…
        "#;
        assert_refused(&text(), cases, |text| read(text).unwrap_err());
    }
}
