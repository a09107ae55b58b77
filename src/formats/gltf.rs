//! glTF meshes (`.glb`, or `.gltf` with nothing outside it): bytes to a surface in millimetres.
//!
//! Node transforms are applied and glTF's metres become the body frame's millimetres; no axis is
//! swapped. The crate reads the structure; numbers are read here, because its own readers trust
//! the offsets in a file.

use crate::geometry::mesh::{MeshPart, SurfaceMesh};
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use nalgebra::{Matrix4, Point3, Vector3};

/// glTF's unit in the body frame's.
const MM_PER_METRE: f64 = 1000.0;

/// Most corners of a mesh. An instrument has thousands; this many would fill 500 MB.
const MAX_VERTICES: usize = 10_000_000;

/// A vertex whose triangles cancel out has no normal of its own, and then gets z.
const MIN_NORMAL: f64 = 1e-30;

/// Why bytes are not a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GltfError {
    #[error("found no glTF ({0}), expected a mesh in glTF 2.0")]
    NotGltf(String),
    #[error("found buffer {0} outside the file, expected all data in one .glb")]
    ExternalBuffer(usize),
    #[error("mesh {mesh:?}: found {found}, expected {expected}")]
    Mesh {
        mesh: String,
        found: String,
        expected: &'static str,
    },
    #[error("node {node:?}: found {found}, expected {expected}")]
    Node {
        node: String,
        found: &'static str,
        expected: &'static str,
    },
    #[error("found no triangles, expected some")]
    Empty,
    #[error("found more than {MAX_VERTICES} vertices, expected fewer")]
    TooLarge,
}

/// Reads a mesh.
///
/// # Errors
/// See [`GltfError`].
pub fn parse(bytes: &[u8]) -> Result<SurfaceMesh, GltfError> {
    check_lengths(bytes)?;
    let not_gltf = |error: gltf::Error| GltfError::NotGltf(error.to_string());
    let gltf::Gltf { document, blob } =
        gltf::Gltf::from_slice_without_validation(bytes).map_err(not_gltf)?;
    let root = document.into_json();
    check_positions(&root)?;
    let file = gltf::Document::from_json(root).map_err(not_gltf)?;
    let scene = file
        .default_scene()
        .or_else(|| file.scenes().next())
        .ok_or(GltfError::Empty)?;
    let mut reader = Reader {
        blob: blob.as_deref().unwrap_or_default(),
        mesh: SurfaceMesh::default(),
        vertices: 0,
        is_visited: vec![false; file.nodes().count()],
    };
    // A stack of its own: how deep nodes nest is the file's choice.
    let mut open: Vec<_> = scene.nodes().map(|n| (n, Matrix4::identity())).collect();
    open.reverse();
    while let Some((node, parent)) = open.pop() {
        let body_from_node = parent * reader.transform(&node)?;
        if let Some(mesh) = node.mesh() {
            let name = node.name().or(mesh.name()).map_or_else(
                || format!("part {}", reader.mesh.parts.len() + 1),
                str::to_owned,
            );
            for primitive in mesh.primitives() {
                reader.push(&name, &primitive, &body_from_node)?;
            }
        }
        let children: Vec<_> = node.children().map(|n| (n, body_from_node)).collect();
        open.extend(children.into_iter().rev());
    }
    if reader.mesh.parts.iter().all(|p| p.triangles.is_empty()) {
        return Err(GltfError::Empty);
    }
    Ok(reader.mesh)
}

/// Refuses a binary file whose own lengths do not fit its bytes; the crate subtracts them.
fn check_lengths(bytes: &[u8]) -> Result<(), GltfError> {
    if !bytes.starts_with(b"glTF") {
        return Ok(());
    }
    let word = |at: usize| {
        bytes
            .get(at..at + 4)
            .and_then(|b| b.try_into().ok())
            .map(|b| u32::from_le_bytes(b) as usize)
    };
    let error = |what: String| Err(GltfError::NotGltf(what));
    match word(8) {
        Some(length) if (12..=bytes.len()).contains(&length) => {}
        Some(length) => {
            return error(format!("{length} bytes announced, {} present", bytes.len()));
        }
        None => return error("the header is cut short".to_owned()),
    }
    let mut at = 12;
    while at < bytes.len() {
        let end = word(at).and_then(|length| at.checked_add(8)?.checked_add(length));
        match end {
            Some(end) if end <= bytes.len() && word(at + 4).is_some() => at = end,
            _ => return error(format!("the chunk at byte {at} is cut short")),
        }
    }
    Ok(())
}

/// Refuses positions that refer to no accessor; the crate's own check takes that for granted.
fn check_positions(root: &gltf::json::Root) -> Result<(), GltfError> {
    let accessors = root.accessors.len();
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    for index in primitives.flat_map(|primitive| primitive.attributes.values()) {
        if index.value() >= accessors {
            let what = format!("accessor {} of {accessors}", index.value());
            return Err(GltfError::NotGltf(what));
        }
    }
    Ok(())
}

/// A mesh in the making.
struct Reader<'a> {
    blob: &'a [u8],
    mesh: SurfaceMesh,
    vertices: usize,
    is_visited: Vec<bool>,
}

impl Reader<'_> {
    /// The node's own transform; each node may be met once, or a cycle would never end.
    fn transform(&mut self, node: &gltf::Node) -> Result<Matrix4<f64>, GltfError> {
        let error = |found, expected| {
            Err(GltfError::Node {
                node: node.name().unwrap_or_default().to_owned(),
                found,
                expected,
            })
        };
        if std::mem::replace(&mut self.is_visited[node.index()], true) {
            return error("it twice in the scene", "a tree of nodes");
        }
        let matrix = Matrix4::from(node.transform().matrix()).cast::<f64>();
        let linear = matrix.fixed_view::<3, 3>(0, 0);
        let determinant = linear.determinant();
        if matrix.iter().any(|v| !v.is_finite()) || determinant == 0.0 {
            return error("a transform without inverse", "one that has one");
        }
        if matrix.row(3) != nalgebra::RowVector4::new(0.0, 0.0, 0.0, 1.0) {
            return error("a projection", "an affine transform");
        }
        Ok(matrix)
    }

    fn push(
        &mut self,
        name: &str,
        primitive: &gltf::Primitive,
        body_from_node: &Matrix4<f64>,
    ) -> Result<(), GltfError> {
        let error = |found: String, expected| GltfError::Mesh {
            mesh: name.to_owned(),
            found,
            expected,
        };
        if primitive.mode() != Mode::Triangles {
            return Err(error(format!("{:?}", primitive.mode()), "triangles"));
        }
        let positions = primitive
            .get(&gltf::Semantic::Positions)
            .ok_or_else(|| error("no positions".to_owned(), "some"))?;
        let positions = self.vectors(name, &positions)?;
        self.vertices = self.vertices.saturating_add(positions.len());
        if self.vertices > MAX_VERTICES {
            return Err(GltfError::TooLarge);
        }
        let mut triangles = match primitive.indices() {
            Some(accessor) => self.triangles(name, &accessor, positions.len())?,
            None => implied_triangles(positions.len()),
        };
        let linear = body_from_node.fixed_view::<3, 3>(0, 0).into_owned();
        // Mirrored, a triangle shows its back: its corners change places.
        if linear.determinant() < 0.0 {
            for triangle in &mut triangles {
                triangle.swap(1, 2);
            }
        }
        let positions_mm: Vec<Point3<f64>> = positions
            .into_iter()
            .map(|p| body_from_node.transform_point(&p.into()) * MM_PER_METRE)
            .collect();
        if positions_mm
            .iter()
            .any(|p| p.iter().any(|v| !v.is_finite()))
        {
            return Err(error(
                "positions that are not finite".to_owned(),
                "finite ones",
            ));
        }
        let own_normals = match primitive.get(&gltf::Semantic::Normals) {
            Some(accessor) => Some(self.vectors(name, &accessor)?),
            None => None,
        };
        let normals = match (own_normals, linear.try_inverse()) {
            (Some(normals), _) if normals.len() != positions_mm.len() => {
                let found = format!("{} normals", normals.len());
                return Err(error(found, "one a position"));
            }
            (Some(normals), Some(inverse)) => {
                let body_from_normal = inverse.transpose();
                normals
                    .into_iter()
                    .map(|n| unit_or_z(body_from_normal * n))
                    .collect()
            }
            _ => smooth_normals(&positions_mm, &triangles),
        };
        let material = primitive.material();
        let surface = material.pbr_metallic_roughness();
        self.mesh.parts.push(MeshPart {
            name: name.to_owned(),
            positions_mm,
            normals,
            triangles,
            base_color: surface.base_color_factor(),
            metallic: surface.metallic_factor(),
            roughness: surface.roughness_factor(),
        });
        Ok(())
    }

    /// Three finite floats an element.
    fn vectors(
        &self,
        name: &str,
        accessor: &gltf::Accessor,
    ) -> Result<Vec<Vector3<f64>>, GltfError> {
        let error = |found: String, expected| GltfError::Mesh {
            mesh: name.to_owned(),
            found,
            expected,
        };
        if accessor.data_type() != DataType::F32 || accessor.dimensions() != Dimensions::Vec3 {
            let found = format!("{:?} {:?}", accessor.dimensions(), accessor.data_type());
            return Err(error(found, "Vec3 F32"));
        }
        self.elements(name, accessor)?
            .map(|bytes| {
                let component = |k: usize| {
                    let four = [
                        bytes[4 * k],
                        bytes[4 * k + 1],
                        bytes[4 * k + 2],
                        bytes[4 * k + 3],
                    ];
                    f64::from(f32::from_le_bytes(four))
                };
                let vector = Vector3::new(component(0), component(1), component(2));
                if vector.iter().all(|v| v.is_finite()) {
                    Ok(vector)
                } else {
                    let found = format!("({}, {}, {})", vector.x, vector.y, vector.z);
                    Err(error(found, "finite numbers"))
                }
            })
            .collect()
    }

    fn triangles(
        &self,
        name: &str,
        accessor: &gltf::Accessor,
        vertices: usize,
    ) -> Result<Vec<[u32; 3]>, GltfError> {
        let error = |found: String, expected| GltfError::Mesh {
            mesh: name.to_owned(),
            found,
            expected,
        };
        let data_type = accessor.data_type();
        let is_index = matches!(data_type, DataType::U8 | DataType::U16 | DataType::U32);
        if !is_index || accessor.dimensions() != Dimensions::Scalar {
            let found = format!("{data_type:?} indices");
            return Err(error(found, "unsigned integers"));
        }
        if !accessor.count().is_multiple_of(3) {
            let found = format!("{} indices", accessor.count());
            return Err(error(found, "a multiple of three"));
        }
        let indices = self
            .elements(name, accessor)?
            .map(|bytes| {
                // Little-endian of one, two or four bytes.
                let index = bytes.iter().rev().fold(0, |n, &b| n << 8 | u32::from(b));
                if (index as usize) < vertices {
                    Ok(index)
                } else {
                    let found = format!("index {index} of {vertices} positions");
                    Err(error(found, "one of them"))
                }
            })
            .collect::<Result<Vec<u32>, _>>()?;
        Ok(indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect())
    }

    /// The bytes of each element of an accessor, all of them in the file.
    fn elements(
        &self,
        name: &str,
        accessor: &gltf::Accessor,
    ) -> Result<impl Iterator<Item = &[u8]>, GltfError> {
        let error = |found: &str, expected| GltfError::Mesh {
            mesh: name.to_owned(),
            found: found.to_owned(),
            expected,
        };
        let view = accessor
            .view()
            .filter(|_| accessor.sparse().is_none())
            .ok_or_else(|| error("sparse data", "plain buffer views"))?;
        if !matches!(view.buffer().source(), gltf::buffer::Source::Bin) {
            return Err(GltfError::ExternalBuffer(view.buffer().index()));
        }
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        let count = accessor.count();
        let cut_short = || error("data beyond the end of its buffer", "all of it in the file");
        let data = view
            .offset()
            .checked_add(view.length())
            .and_then(|end| self.blob.get(view.offset()..end))
            .and_then(|data| data.get(accessor.offset()..))
            .ok_or_else(cut_short)?;
        if stride < size || size == 0 {
            return Err(error(
                "elements that overlap",
                "a stride of at least their size",
            ));
        }
        let needed = match count.checked_sub(1) {
            None => Some(0),
            Some(last) => last.checked_mul(stride).and_then(|n| n.checked_add(size)),
        };
        if needed.is_none_or(|needed| needed > data.len()) {
            return Err(cut_short());
        }
        Ok((0..count).map(move |i| &data[i * stride..i * stride + size]))
    }
}

/// Triangles of vertices that come three by three.
fn implied_triangles(vertices: usize) -> Vec<[u32; 3]> {
    (0..vertices as u32 / 3)
        .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
        .collect()
}

/// Means of the triangles around each vertex, weighted by area.
fn smooth_normals(positions_mm: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<Vector3<f64>> {
    let mut sums = vec![Vector3::zeros(); positions_mm.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| positions_mm[i as usize]);
        let doubled_area = (b - a).cross(&(c - a));
        for &corner in triangle {
            sums[corner as usize] += doubled_area;
        }
    }
    sums.into_iter().map(unit_or_z).collect()
}

fn unit_or_z(vector: Vector3<f64>) -> Vector3<f64> {
    vector
        .try_normalize(MIN_NORMAL)
        .filter(|n| n.iter().all(|v| v.is_finite()))
        .unwrap_or_else(Vector3::z)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    const JSON: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"children":[1],"translation":[0,0,1]},{"mesh":0,"name":"anatomy-face","scale":[2,2,2]}],
"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,1],"metallicFactor":0.5,"roughnessFactor":0.25}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
"buffers":[{"byteLength":44}]}"#;

    fn glb(json: &str, positions: [f32; 9], indices: [u16; 3]) -> Vec<u8> {
        let mut json = json.as_bytes().to_vec();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut data: Vec<u8> = positions.iter().flat_map(|v| v.to_le_bytes()).collect();
        data.extend(indices.iter().flat_map(|v| v.to_le_bytes()));
        data.resize(44, 0);
        let mut out = b"glTF".to_vec();
        let total = 12 + 8 + json.len() + 8 + data.len();
        for word in [2, total as u32, json.len() as u32] {
            out.extend(word.to_le_bytes());
        }
        out.extend(b"JSON");
        out.extend(&json);
        out.extend((data.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(data);
        out
    }

    const CORNERS: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

    pub(in super::super) fn triangle() -> Vec<u8> {
        glb(JSON, CORNERS, [0, 1, 2])
    }

    fn error_with(from: &str, to: &str) -> String {
        assert!(JSON.contains(from), "{from}");
        let file = glb(&JSON.replace(from, to), CORNERS, [0, 1, 2]);
        parse(&file).unwrap_err().to_string()
    }

    #[test]
    fn metres_under_nested_nodes_become_millimetres_of_the_body() {
        let mesh = parse(&triangle()).unwrap();
        let [part] = &mesh.parts[..] else {
            panic!("{mesh:?}")
        };
        assert!(part.is_anatomy());
        assert_eq!(part.triangles, [[0, 1, 2]]);
        assert_eq!(part.positions_mm[1], Point3::new(2000.0, 0.0, 1000.0));
        assert_eq!(part.normals, [Vector3::z(); 3]);
        assert_eq!((part.metallic, part.roughness), (0.5, 0.25));
        assert_eq!(part.base_color, [0.5, 0.25, 1.0, 1.0]);
    }

    #[test]
    fn a_mirrored_node_keeps_its_triangles_facing_outward() {
        let file = glb(&JSON.replace("[2,2,2]", "[2,2,-2]"), CORNERS, [0, 1, 2]);
        let part = parse(&file).unwrap().parts.remove(0);
        assert_eq!(part.triangles, [[0, 2, 1]]);
        assert_eq!(part.normals, [-Vector3::z(); 3]);
    }

    #[test]
    fn meshes_that_cannot_be_are_refused() {
        let index = parse(&glb(JSON, CORNERS, [0, 1, 3])).unwrap_err();
        assert_eq!(
            index.to_string(),
            "mesh \"anatomy-face\": found index 3 of 3 positions, expected one of them"
        );
        let mut corners = CORNERS;
        corners[4] = f32::NAN;
        let not_finite = parse(&glb(JSON, corners, [0, 1, 2])).unwrap_err();
        assert!(
            not_finite
                .to_string()
                .contains("found (1, NaN, 0), expected finite")
        );
        for (from, to, part) in [
            (
                "\"scenes\":[{\"nodes\":[0]}]",
                "\"scenes\":[{\"nodes\":[]}]",
                "found no triangles",
            ),
            (
                "\"children\":[1]",
                "\"children\":[1,1]",
                "found it twice in the scene",
            ),
            (
                "\"scale\":[2,2,2]",
                "\"children\":[0]",
                "found it twice in the scene",
            ),
            (
                "\"scale\":[2,2,2]",
                "\"scale\":[2,0,2]",
                "a transform without inverse",
            ),
            (
                "\"byteLength\":44",
                "\"byteLength\":44,\"uri\":\"x.bin\"",
                "found buffer 0 outside the file",
            ),
            (
                "\"byteLength\":36",
                "\"byteLength\":4000000000",
                "data beyond the end",
            ),
            (
                "\"count\":3,\"type\":\"VEC3\"",
                "\"count\":4000000000,\"type\":\"VEC3\"",
                "data beyond the end",
            ),
            (
                "\"count\":3,\"type\":\"SCALAR\"",
                "\"count\":2,\"type\":\"SCALAR\"",
                "found 2 indices",
            ),
            (
                "\"indices\":1",
                "\"indices\":1,\"mode\":1",
                "found Lines, expected triangles",
            ),
            (
                "5123",
                "5126",
                "found F32 indices, expected unsigned integers",
            ),
        ] {
            let message = error_with(from, to);
            assert!(message.contains(part), "{message}");
        }
        assert_eq!(
            error_with("\"POSITION\":0", "\"POSITION\":7"),
            "found no glTF (accessor 7 of 2), expected a mesh in glTF 2.0"
        );
        assert!(error_with("{\"POSITION\":0}", "{\"NORMAL\":0}").contains("expected"));
    }

    #[test]
    fn lengths_that_do_not_fit_the_bytes_are_refused() {
        for cut in [4, 11, 12, 19, 40, triangle().len() - 1] {
            assert!(parse(&triangle()[..cut]).is_err(), "{cut}");
        }
        let mut file = triangle();
        file[8] = 3;
        file[9] = 0;
        file[10] = 0;
        assert!(
            parse(&file)
                .unwrap_err()
                .to_string()
                .contains("3 bytes announced")
        );
    }
}
