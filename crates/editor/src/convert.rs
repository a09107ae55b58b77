//! The only way from the core's f64 to the renderer's f32.
//!
//! A scene unit is a millimetre, and the scene's axes are the tracker's: whatever the core gives in
//! the tracker frame is drawn at those coordinates. f32 keeps 0.0001 mm at a metre's distance.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use nalgebra::{Matrix3, Point3, UnitQuaternion, Vector3};
use trackwright_geometry::mesh::MeshPart;
use trackwright_geometry::orbit::OrbitCamera;
use trackwright_geometry::pose::{Pose, quaternion_from_matrix};

pub fn vec3(vector: &Vector3<f64>) -> Vec3 {
    Vec3::new(vector.x as f32, vector.y as f32, vector.z as f32)
}

pub fn point(point_mm: &Point3<f64>) -> Vec3 {
    vec3(&point_mm.coords)
}

pub fn length(length_mm: f64) -> f32 {
    length_mm as f32
}

pub fn quat(rotation: &UnitQuaternion<f64>) -> Quat {
    let q = rotation.quaternion();
    Quat::from_xyzw(q.i as f32, q.j as f32, q.k as f32, q.w as f32).normalize()
}

/// Where a body's or sensor's entity goes.
pub fn transform(target_from_source: &Pose) -> Transform {
    Transform {
        translation: vec3(&target_from_source.translation.vector),
        rotation: quat(&target_from_source.rotation),
        scale: Vec3::ONE,
    }
}

/// Where a unit sphere goes to be an ellipsoid: its centre, the rotation whose columns are its
/// axes, and the lengths of the semi-axes.
pub fn ellipsoid(
    center_mm: &Point3<f64>,
    axes: &Matrix3<f64>,
    semi_axes_mm: &Vector3<f64>,
) -> Transform {
    Transform {
        translation: point(center_mm),
        rotation: quat(&quaternion_from_matrix(axes)),
        scale: vec3(semi_axes_mm),
    }
}

/// Where the camera's entity goes.
pub fn camera_transform(camera: &OrbitCamera) -> Transform {
    transform(&camera.tracker_from_camera())
}

/// A pixel position.
pub fn pixel(position: Vec2) -> [f64; 2] {
    [f64::from(position.x), f64::from(position.y)]
}

/// A part of a body for the renderer. Nothing picks on it, so only the renderer keeps it.
pub fn mesh(part: &MeshPart) -> Mesh {
    triangle_mesh(&part.positions_mm, &part.normals, &part.triangles)
}

/// Triangles for the renderer.
pub fn triangle_mesh(
    positions_mm: &[Point3<f64>],
    normals: &[Vector3<f64>],
    triangles: &[[u32; 3]],
) -> Mesh {
    let positions: Vec<[f32; 3]> = positions_mm.iter().map(|p| point(p).to_array()).collect();
    let normals: Vec<[f32; 3]> = normals.iter().map(|n| vec3(n).to_array()).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_indices(Indices::U32(triangles.iter().flatten().copied().collect()))
}

/// An sRGB colour of eight bits a channel as a mesh's corners have it.
pub fn linear([r, g, b]: [u8; 3]) -> [f32; 4] {
    Color::srgb_u8(r, g, b).to_linear().to_f32_array()
}

/// Flat triangles whose corners have colours, collected into one mesh.
#[derive(Clone, Debug, Default)]
pub struct Painted {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    colors: Vec<[f32; 4]>,
    corners: Vec<u32>,
}

impl Painted {
    pub fn triangle(
        &mut self,
        corners_mm: [Point3<f64>; 3],
        normal: &Vector3<f64>,
        color: [f32; 4],
    ) {
        let [a, b, c] = corners_mm.map(|at_mm| self.corner(&at_mm, normal, color));
        self.corners.extend([a, b, c]);
    }

    /// The sides of a pyramid, smooth around it: `foot` has each corner and the normal there.
    pub fn pyramid(
        &mut self,
        foot: &[(Point3<f64>, Vector3<f64>)],
        tip: (Point3<f64>, Vector3<f64>),
        color: [f32; 4],
    ) {
        let tip = self.corner(&tip.0, &tip.1, color);
        let first = tip + 1;
        let count = foot.len() as u32;
        for (k, (at_mm, normal)) in (0..count).zip(foot) {
            self.corner(at_mm, normal, color);
            self.corners.extend([first + k, first + (k + 1) % count, tip]);
        }
    }

    fn corner(&mut self, at_mm: &Point3<f64>, normal: &Vector3<f64>, color: [f32; 4]) -> u32 {
        let number = self.positions.len() as u32;
        self.positions.push(point(at_mm).to_array());
        self.normals.push(vec3(normal).to_array());
        self.colors.push(color);
        number
    }

    /// Corners in turn around it.
    pub fn quad(&mut self, [a, b, c, d]: [Point3<f64>; 4], normal: &Vector3<f64>, color: [f32; 4]) {
        self.triangle([a, b, c], normal, color);
        self.triangle([a, c, d], normal, color);
    }

    pub fn mesh(self) -> Mesh {
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, self.normals)
            .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, self.colors)
            .with_inserted_indices(Indices::U32(self.corners))
    }
}
