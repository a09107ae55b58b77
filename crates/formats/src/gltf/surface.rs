//! glTF meshes (`.glb`, or `.gltf` with all data inside it): bytes to a surface in millimetres.
//!
//! Node transforms are applied and the file's unit, metres unless given otherwise, becomes the body
//! frame's millimetres; no axis is swapped. The crate reads the structure; numbers are read here, because its own readers trust
//! the offsets in a file.

use super::accessor::{triangles, vectors};
use super::buffer::Buffers;
use super::error::GltfError;
use crate::mesh::error::MAX_TRIANGLES;
use gltf::mesh::Mode;
use nalgebra::{Matrix4, Point3, Vector3};
use std::collections::HashMap;
use trackwright_geometry::mesh::{ANATOMY_PREFIX, MeshPart, SurfaceMesh};
use trackwright_geometry::normals::unit_or_z;

/// Most corners of a mesh. An instrument has thousands; this many would fill 500 MB.
const MAX_VERTICES: usize = 10_000_000;

/// Most parts that are kept apart: each is drawn by itself, and a mesh may be placed any number of
/// times. Further ones of one material become one part.
const MAX_PARTS: usize = 1000;

/// Reads a mesh whose unit is `mm_per_unit` long: 1000 by the specification, which states metres.
pub fn parse(bytes: &[u8], mm_per_unit: f64) -> Result<SurfaceMesh, GltfError> {
    check_lengths(bytes)?;
    let not_gltf = |error: gltf::Error| GltfError::NotGltf(error.to_string());
    let gltf::Gltf { document, blob } =
        gltf::Gltf::from_slice_without_validation(bytes).map_err(not_gltf)?;
    let root = document.into_json();
    check_positions(&root)?;
    let file = gltf::Document::from_json(root).map_err(not_gltf)?;
    let scene = file.default_scene().or_else(|| file.scenes().next()).ok_or(GltfError::Empty)?;
    let placed = placed_meshes(&file, &scene)?;
    check_counts(&placed)?;
    let mut reader = Reader {
        buffers: Buffers::of(&file, blob.as_deref().unwrap_or_default()),
        mm_per_unit,
        mesh: SurfaceMesh::default(),
        rest: HashMap::new(),
    };
    for Placed { name, mesh, body_from_node } in &placed {
        let name =
            name.map_or_else(|| format!("part {}", reader.mesh.parts.len() + 1), str::to_owned);
        for primitive in mesh.primitives() {
            reader.push(&name, &primitive, body_from_node)?;
        }
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

/// A mesh at one of its places in the scene.
struct Placed<'a> {
    /// Of the node, else of the mesh.
    name: Option<&'a str>,
    mesh: gltf::Mesh<'a>,
    body_from_node: Matrix4<f64>,
}

/// The meshes of a scene, nodes' transforms multiplied.
fn placed_meshes<'a>(
    file: &'a gltf::Document,
    scene: &gltf::Scene<'a>,
) -> Result<Vec<Placed<'a>>, GltfError> {
    let mut placed = Vec::new();
    let mut is_visited = vec![false; file.nodes().count()];
    // A stack of its own: how deep nodes nest is the file's choice.
    let mut open: Vec<_> = scene.nodes().map(|n| (n, Matrix4::identity())).collect();
    open.reverse();
    while let Some((node, parent)) = open.pop() {
        // Each node may be met once, or a cycle would never end.
        if std::mem::replace(&mut is_visited[node.index()], true) {
            return Err(node_error(&node, "it twice in the scene", "a tree of nodes"));
        }
        let body_from_node = parent * transform(&node)?;
        let children: Vec<_> = node.children().map(|n| (n, body_from_node)).collect();
        open.extend(children.into_iter().rev());
        if let Some(mesh) = node.mesh() {
            placed.push(Placed { name: node.name().or(mesh.name()), mesh, body_from_node });
        }
    }
    Ok(placed)
}

/// Refuses more than memory and drawing can take, before any of it is made: a mesh counts at each of
/// its places.
fn check_counts(placed: &[Placed]) -> Result<(), GltfError> {
    let (mut vertices, mut triangles) = (0_usize, 0_usize);
    for primitive in placed.iter().flat_map(|placed| placed.mesh.primitives()) {
        let positions = primitive.get(&gltf::Semantic::Positions);
        let positions = positions.map_or(0, |positions| positions.count());
        let corners = primitive.indices().map_or(positions, |i| i.count());
        vertices = vertices.saturating_add(positions);
        triangles = triangles.saturating_add(corners / 3);
    }
    for (found, what, most) in
        [(vertices, "vertices", MAX_VERTICES), (triangles, "triangles", MAX_TRIANGLES)]
    {
        if found > most {
            return Err(GltfError::TooLarge { found, what, most });
        }
    }
    Ok(())
}

fn node_error(node: &gltf::Node, found: &'static str, expected: &'static str) -> GltfError {
    GltfError::Node { node: node.name().unwrap_or_default().to_owned(), found, expected }
}

/// The node's own transform.
fn transform(node: &gltf::Node) -> Result<Matrix4<f64>, GltfError> {
    let matrix = Matrix4::from(node.transform().matrix()).cast::<f64>();
    let linear = matrix.fixed_view::<3, 3>(0, 0);
    if matrix.iter().any(|v| !v.is_finite()) || linear.determinant() == 0.0 {
        let found = "a transform without inverse";
        return Err(node_error(node, found, "one that has one"));
    }
    if matrix.row(3) != nalgebra::RowVector4::new(0.0, 0.0, 0.0, 1.0) {
        return Err(node_error(node, "a projection", "an affine transform"));
    }
    Ok(matrix)
}

/// A mesh in the making.
struct Reader<'a> {
    buffers: Buffers<'a>,
    mm_per_unit: f64,
    mesh: SurfaceMesh,
    /// Where further parts go when there are [`MAX_PARTS`]: by whether they are anatomy, and by
    /// material.
    rest: HashMap<(bool, usize), usize>,
}

impl Reader<'_> {
    fn push(
        &mut self,
        name: &str,
        primitive: &gltf::Primitive,
        body_from_node: &Matrix4<f64>,
    ) -> Result<(), GltfError> {
        let error = |found: String, expected| GltfError::mesh(name, found, expected);
        if primitive.mode() != Mode::Triangles {
            return Err(error(format!("{:?}", primitive.mode()), "triangles"));
        }
        let positions = primitive
            .get(&gltf::Semantic::Positions)
            .ok_or_else(|| error("no positions".to_owned(), "some"))?;
        let positions = vectors(&self.buffers, name, &positions)?;
        let mut triangles = match primitive.indices() {
            Some(accessor) => triangles(&self.buffers, name, &accessor, positions.len())?,
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
        let not_finite = |p: &&Point3<f64>| p.iter().any(|v| !v.is_finite());
        if let Some(p) = positions_mm.iter().find(not_finite) {
            let found = format!("a position of ({}, {}, {}) mm", p.x, p.y, p.z);
            return Err(error(found, "finite ones"));
        }
        let own_normals = primitive.get(&gltf::Semantic::Normals);
        let own_normals =
            own_normals.map(|accessor| vectors(&self.buffers, name, &accessor)).transpose()?;
        let normals = match (own_normals, linear.try_inverse()) {
            (Some(normals), _) if normals.len() != positions_mm.len() => {
                let found = format!("{} normals", normals.len());
                return Err(error(found, "one a position"));
            }
            (Some(normals), Some(inverse)) => {
                let body_from_normal = inverse.transpose();
                normals.into_iter().map(|n| unit_or_z(body_from_normal * n)).collect()
            }
            _ => {
                self.mesh.reading.normals_made = true;
                smooth_normals(&positions_mm, &triangles)
            }
        };
        let material = primitive.material();
        let surface = material.pbr_metallic_roughness();
        let part = MeshPart {
            name: name.to_owned(),
            positions_mm,
            normals,
            triangles,
            base_color: surface.base_color_factor(),
            metallic: surface.metallic_factor(),
            roughness: surface.roughness_factor(),
        };
        self.add(part, material.index());
        Ok(())
    }

    /// Adds a part, or its triangles to that of the others of its material where there are too many.
    fn add(&mut self, part: MeshPart, material: Option<usize>) {
        let parts = &mut self.mesh.parts;
        if parts.len() < MAX_PARTS {
            parts.push(part);
            return;
        }
        // A file may have any number of materials too.
        let material = material.map_or(0, |index| 1 + index.min(MAX_PARTS));
        let key = (part.is_anatomy(), material);
        let Some(&rest) = self.rest.get(&key) else {
            self.rest.insert(key, parts.len());
            let name = match part.is_anatomy() {
                true => format!("{ANATOMY_PREFIX}, other parts"),
                false => "other parts".to_owned(),
            };
            parts.push(MeshPart { name, ..part });
            return;
        };
        let rest = &mut parts[rest];
        let first = rest.positions_mm.len() as u32;
        rest.positions_mm.extend(part.positions_mm);
        rest.normals.extend(part.normals);
        let moved = part.triangles.iter().map(|t| t.map(|i| first + i));
        rest.triangles.extend(moved);
    }
}

/// Triangles of vertices that come three by three.
fn implied_triangles(vertices: usize) -> Vec<[u32; 3]> {
    (0..vertices as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect()
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
