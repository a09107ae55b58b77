//! Arrows that keep their thickness on the screen, all of one kind in one mesh.

use crate::editor::camera::OrbitRig;
use crate::editor::materials::GlowMaterial;
use crate::editor::{convert, palette};
use crate::geometry::rotation::perpendicular;
use bevy::camera::visibility::NoFrustumCulling;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use nalgebra::{Point3, Unit, Vector3};
use std::f64::consts::TAU;

const SIDES: u32 = 16;

/// Vectors shorter than this on the screen are no arrows any more and are left out.
const LEAST_PX: f64 = 1.5;

/// Vectors longer than this share of the view's height are cut there and end in two heads.
const MOST_SHARE: f64 = 0.22;

/// From a point by a vector, tracker frame, millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrow {
    pub start_mm: Point3<f64>,
    pub vector_mm: Vector3<f64>,
}

/// How thick arrows are on the screen, in pixels.
#[derive(Clone, Copy, Debug)]
pub struct ArrowStyle {
    pub shaft_px: f64,
    pub head_width_px: f64,
    pub head_length_px: f64,
}

/// The entities of one kind of error arrows, marked with `M`: one mesh, solid where it is seen and
/// shining through where it is hidden. None while there is nothing to show.
#[derive(SystemParam)]
pub struct DrawnArrows<'w, 's, M: Component> {
    commands: Commands<'w, 's>,
    drawn: Query<'w, 's, (Entity, &'static Mesh3d), With<M>>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<GlowMaterial>>,
}

/// How arrows that are hidden by something look.
#[derive(Clone, Copy, Debug)]
pub struct ShineThrough {
    pub alpha: f32,
    /// Before what other things that shine through they are drawn, in millimetres of depth.
    pub order_mm: f32,
}

impl<M: Component + Default> DrawnArrows<'_, '_, M> {
    /// Shows the mesh, or nothing.
    pub fn show(&mut self, name: &'static str, mesh: Option<Mesh>, hidden: ShineThrough) {
        let Some(mesh) = mesh else {
            for (entity, _) in &self.drawn {
                self.commands.entity(entity).despawn();
            }
            return;
        };
        if let Some((_, handle)) = self.drawn.iter().next() {
            if let Some(mut old) = self.meshes.get_mut(&handle.0) {
                *old = mesh;
            }
            return;
        }
        let handle = self.meshes.add(mesh);
        let color = palette::ERROR_VECTOR;
        for material in [
            GlowMaterial::solid(color),
            GlowMaterial::shining_through(color, hidden.alpha).order(hidden.order_mm),
        ] {
            self.commands.spawn((
                Name::new(name),
                M::default(),
                NoFrustumCulling,
                Mesh3d(handle.clone()),
                MeshMaterial3d(self.materials.add(material)),
            ));
        }
    }
}

/// One mesh with all the arrows as they look from where the camera is; `None` where none of them
/// is long enough to be seen.
pub fn arrows_mesh(arrows: &[Arrow], style: ArrowStyle, rig: &OrbitRig) -> Option<Mesh> {
    let mut builder = Builder::default();
    for arrow in arrows {
        let mm_per_px = rig.mm_per_px(&arrow.start_mm);
        let whole = arrow.vector_mm.norm();
        if whole.is_nan() || whole <= LEAST_PX * mm_per_px {
            continue;
        }
        let axis = Unit::new_normalize(arrow.vector_mm);
        let length = whole.min(MOST_SHARE * rig.view_px[1] * mm_per_px);
        let end = arrow.start_mm + axis.into_inner() * length;
        // A short arrow is all head, in proportion.
        let head = (style.head_length_px * mm_per_px).min(length);
        let shrink = head / (style.head_length_px * mm_per_px);
        let head_radius = style.head_width_px / 2.0 * mm_per_px * shrink;
        let shaft_radius = style.shaft_px / 2.0 * mm_per_px * shrink;
        let neck = arrow.start_mm + axis.into_inner() * (length - head);
        if length < whole {
            let second = axis.into_inner() * (0.8 * head);
            builder.cone(
                neck - second,
                neck - second,
                &axis,
                [shaft_radius, head_radius],
            );
            builder.cone(neck - second, end - second, &axis, [head_radius, 0.0]);
        }
        builder.cone(arrow.start_mm, neck, &axis, [0.0, shaft_radius]);
        builder.cone(arrow.start_mm, neck, &axis, [shaft_radius, shaft_radius]);
        builder.cone(neck, neck, &axis, [shaft_radius, head_radius]);
        builder.cone(neck, end, &axis, [head_radius, 0.0]);
    }
    (!builder.triangles.is_empty()).then(|| builder.mesh())
}

#[derive(Default)]
struct Builder {
    positions: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
}

impl Builder {
    /// A piece of a cone between two radii; between equal points a disc that faces backwards,
    /// and from radius 0 the disc that closes the start.
    fn cone(
        &mut self,
        from: Point3<f64>,
        to: Point3<f64>,
        axis: &Unit<Vector3<f64>>,
        [r0, r1]: [f64; 2],
    ) {
        let is_disc = r0 < r1;
        let to = if is_disc { from } else { to };
        let length = (to - from).norm();
        let x = perpendicular(axis);
        let y = axis.cross(&x);
        let base = self.positions.len() as u32;
        for i in 0..=SIDES {
            let (sine, cosine) = (f64::from(i) / f64::from(SIDES) * TAU).sin_cos();
            let out = x.into_inner() * cosine + y * sine;
            let normal = if is_disc {
                -axis.into_inner()
            } else {
                (out * length + axis.into_inner() * (r0 - r1)).normalize()
            };
            self.positions.extend([from + out * r0, to + out * r1]);
            self.normals.extend([normal, normal]);
        }
        for i in 0..SIDES {
            let a = base + 2 * i;
            self.triangles
                .extend([[a, a + 2, a + 1], [a + 1, a + 2, a + 3]]);
        }
    }

    fn mesh(self) -> Mesh {
        convert::triangle_mesh(&self.positions, &self.normals, &self.triangles)
    }
}
