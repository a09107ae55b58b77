//! glTF meshes (`.glb`, or `.gltf` with nothing outside it): bytes to a surface in millimetres.
//!
//! Node transforms are applied and the file's unit, metres unless told otherwise, becomes the body
//! frame's millimetres; no axis is swapped. The crate reads the structure; numbers are read here, because its own readers trust
//! the offsets in a file.

use super::super::mesh::MAX_TRIANGLES;
use super::GltfError;
use super::accessor::{triangles, vectors};
use crate::geometry::mesh::{MeshPart, SurfaceMesh};
use crate::geometry::normals::unit_or_z;
use gltf::mesh::Mode;
use nalgebra::{Matrix4, Point3, Vector3};

/// Most corners of a mesh. An instrument has thousands; this many would fill 500 MB.
const MAX_VERTICES: usize = 10_000_000;

/// Reads a mesh whose unit is `mm_per_unit` long: 1000 by the specification, which says metres.
///
/// # Errors
/// See [`GltfError`].
pub fn parse(bytes: &[u8], mm_per_unit: f64) -> Result<SurfaceMesh, GltfError> {
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
        mm_per_unit,
        mesh: SurfaceMesh::default(),
        vertices: 0,
        triangles: 0,
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
    mm_per_unit: f64,
    mesh: SurfaceMesh,
    vertices: usize,
    triangles: usize,
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
        let corners = primitive.indices().map_or(positions.count(), |i| i.count());
        self.vertices = self.vertices.saturating_add(positions.count());
        self.triangles = self.triangles.saturating_add(corners / 3);
        for (found, what, most) in [
            (self.vertices, "vertices", MAX_VERTICES),
            (self.triangles, "triangles", MAX_TRIANGLES),
        ] {
            if found > most {
                return Err(GltfError::TooLarge { found, what, most });
            }
        }
        let positions = vectors(self.blob, name, &positions)?;
        let mut triangles = match primitive.indices() {
            Some(accessor) => triangles(self.blob, name, &accessor, positions.len())?,
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
            .map(|p| body_from_node.transform_point(&p.into()) * self.mm_per_unit)
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
            Some(accessor) => Some(vectors(self.blob, name, &accessor)?),
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
            _ => {
                self.mesh.reading.normals_made = true;
                smooth_normals(&positions_mm, &triangles)
            }
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
