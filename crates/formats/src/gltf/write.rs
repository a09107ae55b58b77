//! Writes a scene as binary glTF 2.0 (`.glb`): shapes, materials, nodes, and their metadata.
//!
//! Lengths are whatever unit the nodes around a shape make of them; glTF counts in metres. Colours
//! are linear, as the format demands of factors and of `COLOR_0`; vertex colours are kept with 16
//! bits a channel, which is finer than any step of 8-bit sRGB, and so read back exactly.

use super::error::GltfWriteError;
use gltf::binary::{Glb, Header};
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::buffer::{Target, View};
use gltf::json::camera;
use gltf::json::extensions::material::{Material as MaterialExtensions, Unlit};
use gltf::json::material::{
    AlphaMode, EmissiveFactor, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor,
};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::scene::UnitQuaternion as NodeRotation;
use gltf::json::validation::{Checked, USize64};
use gltf::json::{self, Index, Root};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// What a material needs that nothing lights.
const UNLIT: &str = "KHR_materials_unlit";

/// Largest file that the header can state, less room for it.
const MOST_BYTES: usize = u32::MAX as usize - 64;

/// Least part of a unit normal: one that is shorter has no direction.
const MIN_NORMAL: f64 = 1e-12;

/// Corners and what connects them.
#[derive(Clone, Copy, Debug)]
pub struct Shape<'a> {
    pub positions: &'a [Point3<f64>],
    /// One a position, or none at all. Their length does not matter.
    pub normals: &'a [Vector3<f64>],
    /// Linear RGBA, 0 to 1, one a position, or none at all.
    pub colors: &'a [[f64; 4]],
    pub elements: Elements<'a>,
}

impl<'a> Shape<'a> {
    /// What nothing lights, and so needs no normals.
    pub fn unlit(
        positions: &'a [Point3<f64>],
        colors: &'a [[f64; 4]],
        elements: Elements<'a>,
    ) -> Self {
        Self { positions, normals: &[], colors, elements }
    }
}

/// What corners are connected to.
#[derive(Clone, Copy, Debug)]
pub enum Elements<'a> {
    /// Counter-clockwise seen from the front.
    Triangles(&'a [[u32; 3]]),
    Lines(&'a [[u32; 2]]),
}

/// How a surface looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    pub name: String,
    /// Linear RGBA; an opacity below 1 makes it translucent. Vertex colours multiply it.
    pub color: [f64; 4],
    pub light: Light,
    /// Whether it is seen from behind too.
    pub both_faces: bool,
    /// Whether vertex colours have opacities.
    pub fades: bool,
}

/// What light does to a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// As a surface of a metal or of none, rough or smooth.
    Lit { metallic: f64, roughness: f64 },
    /// Its colour as it is.
    Unlit,
}

/// Where a node is in its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeTransform {
    pub translation: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
    pub scale: Vector3<f64>,
}

impl Default for NodeTransform {
    fn default() -> Self {
        Self {
            translation: Vector3::zeros(),
            rotation: UnitQuaternion::identity(),
            scale: Vector3::repeat(1.0),
        }
    }
}

/// A shape that was written, for any number of meshes.
#[derive(Clone, Debug)]
pub struct ShapeId {
    attributes: Vec<(Semantic, Index<json::Accessor>)>,
    indices: Index<json::Accessor>,
    mode: Mode,
    corners: usize,
}

/// A material that was written.
#[derive(Clone, Copy, Debug)]
pub struct MaterialId(Index<json::Material>);

/// A mesh that was written, for any number of nodes.
#[derive(Clone, Copy, Debug)]
pub struct MeshId(Index<json::Mesh>);

/// A node that was written.
#[derive(Clone, Copy, Debug)]
pub struct NodeId(Index<json::Node>);

/// A node to be written.
#[derive(Clone, Debug, Default)]
pub struct Node {
    pub name: String,
    pub transform: NodeTransform,
    pub mesh: Option<MeshId>,
    /// Vertical angle of view, radians: the node is a camera that looks along its -z.
    pub camera_fov_rad: Option<f64>,
    pub children: Vec<NodeId>,
    /// Its further metadata; null for none.
    pub extras: Value,
}

/// A file in the making.
#[derive(Debug, Default)]
pub struct GlbWriter {
    root: Root,
    bytes: Vec<u8>,
    materials: Vec<Material>,
    /// The first thing that cannot be written.
    error: Option<GltfWriteError>,
}

impl GlbWriter {
    /// A file that states which program made it.
    pub fn new(generator: &str) -> Self {
        let mut writer = Self::default();
        writer.root.asset.generator = Some(generator.to_owned());
        writer
    }

    /// Adds corners and what connects them; `None` where there is nothing to be seen. What cannot
    /// be written is reported by [`finish`](Self::finish), `name` being what it is called.
    pub fn shape(&mut self, name: &str, shape: &Shape) -> Option<ShapeId> {
        let corners = shape.positions.len();
        let (mode, indices) = match shape.elements {
            Elements::Triangles(triangles) => {
                (Mode::Triangles, self.indices(triangles.as_flattened(), corners))
            }
            Elements::Lines(lines) => (Mode::Lines, self.indices(lines.as_flattened(), corners)),
        };
        let indices = indices?;
        let mut attributes = vec![(Semantic::Positions, self.positions(name, shape.positions)?)];
        if !shape.normals.is_empty() {
            let normals = self.normals(name, shape.normals, corners)?;
            attributes.push((Semantic::Normals, normals));
        }
        let id = ShapeId { attributes, indices, mode, corners };
        match shape.colors.is_empty() {
            true => Some(id),
            false => self.painted(name, &id, shape.colors),
        }
    }

    /// The same shape with other vertex colours, linear RGBA.
    pub fn painted(&mut self, name: &str, of: &ShapeId, colors: &[[f64; 4]]) -> Option<ShapeId> {
        self.check_count(name, "colours", colors.len(), of.corners)?;
        let bytes = colors.iter().flatten().flat_map(|part| {
            let part = part.clamp(0.0, 1.0) * f64::from(u16::MAX);
            (part.round() as u16).to_le_bytes()
        });
        let view = self.view(bytes, Target::ArrayBuffer)?;
        let accessor = json::Accessor {
            normalized: true,
            ..accessor(view, colors.len(), ComponentType::U16, Type::Vec4)
        };
        let colors = Index::push(&mut self.root.accessors, accessor);
        let mut id = of.clone();
        id.attributes.retain(|(what, _)| *what != Semantic::Colors(0));
        id.attributes.push((Semantic::Colors(0), colors));
        Some(id)
    }

    /// Adds a material, or finds the one that is the same.
    pub fn material(&mut self, material: &Material) -> MaterialId {
        let known = self.materials.iter().position(|own| own == material);
        MaterialId(match known {
            Some(index) => Index::new(index as u32),
            None => {
                self.materials.push(material.clone());
                Index::push(&mut self.root.materials, written(material))
            }
        })
    }

    /// Adds a mesh of shapes, each with its material; `None` of none.
    pub fn mesh(
        &mut self,
        name: &str,
        parts: impl IntoIterator<Item = (ShapeId, MaterialId)>,
    ) -> Option<MeshId> {
        let primitives: Vec<Primitive> = parts
            .into_iter()
            .map(|(shape, material)| Primitive {
                attributes: shape
                    .attributes
                    .into_iter()
                    .map(|(what, accessor)| (Checked::Valid(what), accessor))
                    .collect::<BTreeMap<_, _>>(),
                extensions: None,
                extras: None,
                indices: Some(shape.indices),
                material: Some(material.0),
                mode: Checked::Valid(shape.mode),
                targets: None,
            })
            .collect();
        if primitives.is_empty() {
            return None;
        }
        let mesh = json::Mesh {
            extensions: None,
            extras: None,
            name: Some(name.to_owned()),
            primitives,
            weights: None,
        };
        Some(MeshId(Index::push(&mut self.root.meshes, mesh)))
    }

    /// Adds a node; its children must not have another parent.
    pub fn node(&mut self, node: Node) -> NodeId {
        let transform = &node.transform;
        let camera = node.camera_fov_rad.map(|fov| self.camera(&node.name, fov));
        let q = transform.rotation.quaternion();
        let numbers =
            [transform.translation.as_slice(), transform.scale.as_slice(), q.coords.as_slice()];
        if numbers.concat().iter().any(|v| !(*v as f32).is_finite()) {
            let name = node.name.clone();
            self.fail::<()>(GltfWriteError::NotFinite { name, what: "place" });
        }
        let f32s = |v: &Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
        let identity = NodeTransform::default();
        let written = json::Node {
            camera,
            children: (!node.children.is_empty())
                .then(|| node.children.iter().map(|child| child.0).collect()),
            extras: self.extras(&node.extras),
            mesh: node.mesh.map(|mesh| mesh.0),
            name: Some(node.name),
            rotation: (transform.rotation != identity.rotation)
                .then(|| NodeRotation([q.i as f32, q.j as f32, q.k as f32, q.w as f32])),
            scale: (transform.scale != identity.scale).then(|| f32s(&transform.scale)),
            translation: (transform.translation != identity.translation)
                .then(|| f32s(&transform.translation)),
            ..json::Node::default()
        };
        NodeId(Index::push(&mut self.root.nodes, written))
    }

    /// The file's bytes: one scene of these nodes.
    ///
    /// # Errors
    /// The first thing that the format cannot hold.
    pub fn finish(
        mut self,
        name: &str,
        nodes: &[NodeId],
        extras: &Value,
    ) -> Result<Vec<u8>, GltfWriteError> {
        let extras = self.extras(extras);
        if let Some(error) = self.error {
            return Err(error);
        }
        let scene = json::Scene {
            extensions: None,
            extras: extras.clone(),
            name: Some(name.to_owned()),
            nodes: nodes.iter().map(|node| node.0).collect(),
        };
        let mut root = self.root;
        root.asset.extras = extras;
        root.scene = Some(Index::push(&mut root.scenes, scene));
        if self.materials.iter().any(|m| m.light == Light::Unlit) {
            root.extensions_used.push(UNLIT.to_owned());
        }
        if !self.bytes.is_empty() {
            root.buffers.push(json::Buffer {
                byte_length: USize64::from(self.bytes.len()),
                extensions: None,
                extras: None,
                name: None,
                uri: None,
            });
        }
        let not_written = |error: String| GltfWriteError::NotWritten(error);
        let text = json::serialize::to_vec(&root).map_err(|e| not_written(e.to_string()))?;
        let bytes = text.len() + self.bytes.len();
        if bytes > MOST_BYTES {
            return Err(GltfWriteError::TooLarge { bytes });
        }
        let glb = Glb {
            header: Header { magic: *b"glTF", version: 2, length: 0 },
            json: Cow::Owned(text),
            bin: (!self.bytes.is_empty()).then_some(Cow::Owned(self.bytes)),
        };
        glb.to_vec().map_err(|e| not_written(e.to_string()))
    }

    fn camera(&mut self, name: &str, fov_rad: f64) -> Index<json::Camera> {
        let camera = json::Camera {
            name: Some(name.to_owned()),
            orthographic: None,
            perspective: Some(camera::Perspective {
                // Whoever shows it knows the shape of its window.
                aspect_ratio: None,
                yfov: fov_rad as f32,
                zfar: None,
                znear: 0.01,
                extensions: None,
                extras: None,
            }),
            type_: Checked::Valid(camera::Type::Perspective),
            extensions: None,
            extras: None,
        };
        Index::push(&mut self.root.cameras, camera)
    }

    fn positions(&mut self, name: &str, points: &[Point3<f64>]) -> Option<Index<json::Accessor>> {
        let rounded = |p: &Point3<f64>| [p.x as f32, p.y as f32, p.z as f32];
        let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for point in points.iter().map(rounded) {
            for k in 0..3 {
                if !point[k].is_finite() {
                    let name = name.to_owned();
                    return self.fail(GltfWriteError::NotFinite { name, what: "position" });
                }
                (min[k], max[k]) = (min[k].min(point[k]), max[k].max(point[k]));
            }
        }
        let bytes = points.iter().flat_map(rounded).flat_map(f32::to_le_bytes);
        let view = self.view(bytes, Target::ArrayBuffer)?;
        let accessor = json::Accessor {
            min: Some(json!(min)),
            max: Some(json!(max)),
            ..accessor(view, points.len(), ComponentType::F32, Type::Vec3)
        };
        Some(Index::push(&mut self.root.accessors, accessor))
    }

    fn normals(
        &mut self,
        name: &str,
        normals: &[Vector3<f64>],
        corners: usize,
    ) -> Option<Index<json::Accessor>> {
        self.check_count(name, "normals", normals.len(), corners)?;
        let unit = |n: &Vector3<f64>| {
            let unit = n.try_normalize(MIN_NORMAL).unwrap_or_else(Vector3::z);
            [unit.x as f32, unit.y as f32, unit.z as f32]
        };
        let bytes = normals.iter().flat_map(unit).flat_map(f32::to_le_bytes);
        let view = self.view(bytes, Target::ArrayBuffer)?;
        let accessor = accessor(view, normals.len(), ComponentType::F32, Type::Vec3);
        Some(Index::push(&mut self.root.accessors, accessor))
    }

    /// Sixteen bits each where that is enough: the largest number of a width means no vertex.
    fn indices(&mut self, indices: &[u32], corners: usize) -> Option<Index<json::Accessor>> {
        if indices.is_empty() {
            return None;
        }
        let (width, component) = match corners <= usize::from(u16::MAX) {
            true => (2, ComponentType::U16),
            false => (4, ComponentType::U32),
        };
        let bytes = indices.iter().flat_map(|index| index.to_le_bytes().into_iter().take(width));
        let view = self.view(bytes, Target::ElementArrayBuffer)?;
        let accessor = accessor(view, indices.len(), component, Type::Scalar);
        Some(Index::push(&mut self.root.accessors, accessor))
    }

    /// Appends bytes, beginning at a multiple of four.
    fn view(&mut self, bytes: impl Iterator<Item = u8>, target: Target) -> Option<Index<View>> {
        if self.error.is_some() {
            return None;
        }
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let from = self.bytes.len();
        self.bytes.extend(bytes);
        let length = self.bytes.len() - from;
        if self.bytes.len() > MOST_BYTES {
            let bytes = std::mem::take(&mut self.bytes).len();
            return self.fail(GltfWriteError::TooLarge { bytes });
        }
        let view = View {
            buffer: Index::new(0),
            byte_length: USize64::from(length),
            byte_offset: Some(USize64::from(from)),
            byte_stride: None,
            name: None,
            target: Some(Checked::Valid(target)),
            extensions: None,
            extras: None,
        };
        Some(Index::push(&mut self.root.buffer_views, view))
    }

    fn extras(&mut self, value: &Value) -> json::Extras {
        if value.is_null() {
            return None;
        }
        match serde_json::value::to_raw_value(value) {
            Ok(raw) => Some(raw),
            Err(error) => self.fail(GltfWriteError::NotWritten(error.to_string())),
        }
    }

    fn check_count(
        &mut self,
        name: &str,
        what: &'static str,
        found: usize,
        expected: usize,
    ) -> Option<()> {
        if found == expected {
            return Some(());
        }
        let name = name.to_owned();
        self.fail(GltfWriteError::Counts { name, what, found, expected })
    }

    /// Keeps the first error, and nothing else.
    fn fail<T>(&mut self, error: GltfWriteError) -> Option<T> {
        self.error.get_or_insert(error);
        None
    }
}

fn accessor(
    view: Index<View>,
    count: usize,
    component: ComponentType,
    kind: Type,
) -> json::Accessor {
    json::Accessor {
        buffer_view: Some(view),
        byte_offset: None,
        count: USize64::from(count),
        component_type: Checked::Valid(GenericComponentType(component)),
        extensions: None,
        extras: None,
        type_: Checked::Valid(kind),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    }
}

fn written(material: &Material) -> json::Material {
    // What knows nothing of unlit materials had better paint them rough and matt.
    let (metallic, roughness) = match material.light {
        Light::Lit { metallic, roughness } => (metallic, roughness),
        Light::Unlit => (0.0, 0.9),
    };
    let is_opaque = material.color[3] >= 1.0 && !material.fades;
    json::Material {
        name: Some(material.name.clone()),
        alpha_mode: Checked::Valid(match is_opaque {
            true => AlphaMode::Opaque,
            false => AlphaMode::Blend,
        }),
        double_sided: material.both_faces,
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor(
                material.color.map(|part| part.clamp(0.0, 1.0) as f32),
            ),
            metallic_factor: StrengthFactor(metallic.clamp(0.0, 1.0) as f32),
            roughness_factor: StrengthFactor(roughness.clamp(0.0, 1.0) as f32),
            ..PbrMetallicRoughness::default()
        },
        emissive_factor: EmissiveFactor::default(),
        extensions: (material.light == Light::Unlit)
            .then_some(MaterialExtensions { unlit: Some(Unlit {}) }),
        ..json::Material::default()
    }
}
