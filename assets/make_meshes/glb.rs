//! Writes a model as a binary glTF 2.0 file.

use serde_json::{Value, json};

use crate::model::{Material, Model, Part};
use crate::shape::bounds_mm;
use crate::vector::{Vec3, VecExt};

/// glTF counts in metres; the bodies here are made in millimetres.
const METRES_PER_MM: f64 = 0.001;

// Names as in the glTF 2.0 specification, sections 3.6 and 4.4.
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const CHUNK_JSON: &[u8; 4] = b"JSON";
const CHUNK_BIN: &[u8; 4] = b"BIN\0";

/// The file's bytes: one node, mesh and material a part, the axes as they are in the body frame.
pub fn to_bytes(model: &Model) -> Vec<u8> {
    let mut buffer = Buffer::default();
    let meshes: Vec<Value> =
        model.parts.iter().enumerate().map(|(i, part)| mesh_of(part, i, &mut buffer)).collect();
    let nodes: Vec<Value> = (model.parts.iter().enumerate())
        .map(|(i, part)| json!({ "name": part.name, "mesh": i }))
        .collect();
    let materials: Vec<Value> =
        model.parts.iter().map(|part| material_of(&part.material)).collect();
    let root = json!({
        "asset": { "version": "2.0", "generator": "trackwright make-meshes" },
        "scene": 0,
        "scenes": [{ "name": model.name, "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{ "byteLength": buffer.bytes.len() }],
    });
    container(root.to_string().into_bytes(), buffer.bytes)
}

/// The binary chunk and the JSON that describes its pieces.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Appends vectors, scaled; returns the accessor's index.
    fn push_vectors(&mut self, vectors: &[Vec3], scale: f64, with_bounds: bool) -> usize {
        let rounded = |v: &Vec3| v.to_array().map(|component| (component * scale) as f32);
        let bytes = vectors.iter().flat_map(rounded).flat_map(f32::to_le_bytes).collect();
        let mut accessor = json!({
            "componentType": FLOAT, "type": "VEC3", "count": vectors.len(),
        });
        if with_bounds {
            let (low, high) = bounds_mm(vectors);
            // Through f32 first, so that the bounds hold exactly for the numbers in the file.
            accessor["min"] = json!(rounded(&low).map(f64::from));
            accessor["max"] = json!(rounded(&high).map(f64::from));
        }
        self.push(bytes, ARRAY_BUFFER, accessor)
    }

    fn push_indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let bytes = triangles.iter().flatten().flat_map(|index| index.to_le_bytes()).collect();
        let accessor = json!({
            "componentType": UNSIGNED_INT, "type": "SCALAR", "count": triangles.len() * 3,
        });
        self.push(bytes, ELEMENT_ARRAY_BUFFER, accessor)
    }

    /// Every element here is four bytes wide, so every piece starts aligned.
    fn push(&mut self, bytes: Vec<u8>, target: u32, mut accessor: Value) -> usize {
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target,
        }));
        self.bytes.extend(bytes);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

fn mesh_of(part: &Part, material: usize, buffer: &mut Buffer) -> Value {
    let shaded = part.shape.shaded();
    let position = buffer.push_vectors(&shaded.positions, METRES_PER_MM, true);
    let normal = buffer.push_vectors(&shaded.normals, 1.0, false);
    let indices = buffer.push_indices(&shaded.triangles);
    json!({
        "name": part.name,
        "primitives": [{
            "attributes": { "POSITION": position, "NORMAL": normal },
            "indices": indices,
            "material": material,
        }],
    })
}

fn material_of(material: &Material) -> Value {
    let mut value = json!({
        "name": material.name,
        "pbrMetallicRoughness": {
            "baseColorFactor": material.base_color,
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        },
    });
    if material.base_color[3] < 1.0 {
        value["alphaMode"] = json!("BLEND");
    }
    value
}

/// Header and two chunks, each padded to four bytes as the format demands.
fn container(mut json: Vec<u8>, mut binary: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut file = Vec::with_capacity(total);
    file.extend(b"glTF");
    file.extend(2_u32.to_le_bytes());
    file.extend((total as u32).to_le_bytes());
    for (kind, chunk) in [(CHUNK_JSON, json), (CHUNK_BIN, binary)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::materials;
    use crate::profile::{at, turned};

    #[test]
    fn the_container_states_its_own_lengths() {
        let shape = turned(&[at(0.0, 3.0, 0.0), at(5.0, 3.0, 0.0)], 12);
        let model = Model { name: "pin", parts: vec![Part::new("pin", materials::STEEL, shape)] };
        let bytes = to_bytes(&model);
        let word =
            |at: usize| bytes[at..at + 4].iter().rev().fold(0, |n, &b| n << 8 | usize::from(b));
        assert_eq!(word(8), bytes.len());
        let json_length = word(12);
        assert_eq!(json_length % 4, 0);
        assert_eq!(12 + 8 + json_length + 8 + word(20 + json_length), bytes.len());
        let root: Value = serde_json::from_slice(&bytes[20..20 + json_length]).unwrap();
        assert_eq!(root["accessors"][0]["max"][2], json!(f64::from(0.005_f32)));
        assert_eq!(root["nodes"][0]["name"], "pin");
    }
}
