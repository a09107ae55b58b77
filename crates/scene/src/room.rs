//! The room: volume and model's box, generator, ground, arrows of the field, regions.

use super::coils::coil_lines;
use super::drawing::Drawing;
use super::field_arrows::{Scale, arrow_triangles};
use super::ground::{AXIS_LENGTH_MM, grid};
use super::palette::{AXES, COIL, GRID, MET, MODEL_BOX, SUPPORT, VOLUME};
use super::{SceneError, arrow_style::ArrowStyle};
use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};
use trackwright_formats::gltf::write::{
    Elements, Light, Material, MaterialId, NodeId, NodeTransform, Shape,
};
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::color::linear;
use trackwright_geometry::isosurface::Isosurface;
use trackwright_geometry::outline::Outline;
use trackwright_geometry::solid::{ArrowSize, Solid};
use trackwright_geometry::volume::Volume;

/// How opaque lines are, as the editor draws them.
const EDGE_ALPHA: f64 = 0.30;
const BRACKET_ALPHA: f64 = 0.95;
const BOX_ALPHA: f64 = 0.22;

/// How opaque the surfaces around regions are.
const REGION_ALPHA: f64 = 0.2;
const SUPPORT_ALPHA: f64 = 0.12;

impl Drawing<'_> {
    /// # Errors
    /// Of reading the generator's mesh.
    pub(super) fn room(&mut self) -> Result<Vec<NodeId>, SceneError> {
        let layers = self.stage.view.layers;
        let mut nodes = Vec::new();
        if layers.volume {
            nodes.extend(self.volume());
        }
        if layers.generator {
            nodes.extend(self.generator()?);
            nodes.extend(self.coils());
        }
        if layers.grid {
            nodes.extend(self.ground());
        }
        let sampled = self.sampled;
        if let Some(region) = &sampled.region {
            let look = self.veil("requirement met", MET, REGION_ALPHA);
            let extras = json!({"fraction": region.fraction, "volume_cm3": region.volume_cm3});
            let name = match region.upper_share {
                Some(_) => "region where the requirement is met with 95 %",
                None => "region where the requirement is met",
            };
            nodes.extend(self.shell(name, &region.surface, look, extras));
        }
        if let Some(region) = &sampled.support {
            let look = self.veil("field supported", SUPPORT, SUPPORT_ALPHA);
            let extras = json!({"fraction": region.fraction, "volume_cm3": region.volume_cm3});
            let name = "region where the room's model is valid";
            nodes.extend(self.shell(name, &region.surface, look, extras));
        }
        Ok(nodes)
    }

    /// The tracker's volume, and the model's box where that is another one.
    fn volume(&mut self) -> Vec<NodeId> {
        let environment = &self.stage.world.environment;
        let own = *environment.model.bounds();
        let mut nodes = Vec::new();
        if let Some(volume) = environment.volume {
            let outline = volume.outline();
            for (name, lines, alpha) in [
                ("measurement volume", &outline.lines, EDGE_ALPHA),
                ("brackets of the volume", &outline.brackets, BRACKET_ALPHA),
            ] {
                let look = self.unlit(name, VOLUME, alpha);
                nodes.extend(self.lines(name, lines.iter().map(Vec::as_slice), look));
            }
        }
        if environment.volume.is_none_or(|volume| !is_same_box(&volume, &own)) {
            let name = "box of the room's model";
            let look = self.unlit(name, MODEL_BOX, BOX_ALPHA);
            let lines = Outline::of_box(&own).lines;
            nodes.extend(self.lines(name, lines.iter().map(Vec::as_slice), look));
        }
        nodes
    }

    /// The field generator, in its own colours.
    fn generator(&mut self) -> Result<Option<NodeId>, SceneError> {
        let mesh = trackwright_project::generator_mesh()?;
        let mut children = Vec::new();
        for part in &mesh.parts {
            let [r, g, b, _] = part.base_color.map(f64::from);
            let look = self.writer.material(&Material {
                name: format!("generator, {}", part.name),
                color: [r, g, b, 1.0],
                light: Light::Lit {
                    metallic: f64::from(part.metallic),
                    roughness: f64::from(part.roughness),
                },
                both_faces: false,
                fades: false,
            });
            let shape = self.part(part);
            children.extend(self.shape_node(&part.name, shape, look, Value::Null));
        }
        Ok(self.group("field generator", NodeTransform::default(), children))
    }

    /// The generator's coils, where they are known.
    fn coils(&mut self) -> Option<NodeId> {
        let generator = self.stage.world.generator()?;
        let lines = coil_lines(generator);
        let name = format!("coils of {}", generator.name);
        let look = self.unlit(&name, COIL, 1.0);
        self.lines(&name, lines.iter().map(Vec::as_slice), look)
    }

    /// The grid, and the tracker's axes at its origin.
    fn ground(&mut self) -> Vec<NodeId> {
        let [r, g, b] = linear(GRID.on(self.stage.wish.ground));
        let (mut positions, mut colors, mut lines) = (Vec::new(), Vec::new(), Vec::new());
        for line in grid() {
            let base = positions.len() as u32;
            lines.push([base, base + 1]);
            for (at, alpha) in line {
                positions.push(at);
                colors.push([r, g, b, alpha]);
            }
        }
        let look = self.vertex_colors(true);
        let shape = Shape::unlit(&positions, &colors, Elements::Lines(&lines));
        let shape = self.writer.shape("ground", &shape);
        let mut nodes = Vec::new();
        nodes.extend(self.shape_node("ground", shape, look, Value::Null));
        for (k, name) in ["x", "y", "z"].iter().enumerate() {
            let style = ArrowStyle::OF_SENSOR;
            let mm_per_px = self.eye.mm_per_px(&Point3::origin());
            let mut arrow = Solid::default();
            let size = ArrowSize {
                shaft_mm: style.shaft_px * mm_per_px,
                head_width_mm: style.head_width_px * mm_per_px,
                head_length_mm: style.head_length_px * mm_per_px,
                most_mm: AXIS_LENGTH_MM,
            };
            let axis = Vector3::ith(k, AXIS_LENGTH_MM);
            arrow.push_arrow(&Point3::origin(), &axis, &size);
            let name = format!("{name} of the tracker");
            let look = self.unlit(&name, AXES[k], 1.0);
            nodes.extend(self.solid_node(&name, &arrow, look, Value::Null));
        }
        nodes
    }

    fn shell(
        &mut self,
        name: &str,
        surface: &Isosurface,
        look: MaterialId,
        extras: Value,
    ) -> Option<NodeId> {
        let shape = Shape {
            positions: &surface.positions_mm,
            normals: &surface.normals,
            colors: &[],
            elements: Elements::Triangles(&surface.triangles),
        };
        let shape = self.writer.shape(name, &shape);
        self.shape_node(name, shape, look, extras)
    }

    /// The field's error vectors in the colours of their true lengths.
    pub(super) fn field_arrows(&mut self) -> Option<NodeId> {
        let found = self.sampled.arrows.as_ref()?;
        let view = &self.stage.view;
        // As the slice's, where it shows the same.
        let of_slice = self.sampled.slice.as_ref().filter(|_| view.arrows_share_scale());
        let own_mm = view.arrows.range_mm.unwrap_or(found.p95_mm);
        let max_mm = of_slice.map_or(own_mm, |slice| view.slice_range().unwrap_or(slice.p95));
        let map = view.color_maps().arrows;
        let scale = Scale::of(found);
        let (mut positions, mut colors, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        for (from, error) in found.arrows() {
            let [r, g, b] = linear(map.srgb_of_value(error.norm(), max_mm));
            let first = positions.len();
            // What nothing lights needs no normals, so that triangles share their corners.
            arrow_triangles(&from, &scale.drawn(&error), |corners, _| {
                triangles.push(corners.map(|corner| {
                    let own = &positions[first..];
                    let known = own.iter().position(|own| *own == corner);
                    let number = first + known.unwrap_or(own.len());
                    if number == positions.len() {
                        positions.push(corner);
                        colors.push([r, g, b, 1.0]);
                    }
                    number as u32
                }));
            });
        }
        let name = format!("error of the field, arrows × {}", scale.times);
        let shape = Shape::unlit(&positions, &colors, Elements::Triangles(&triangles));
        let shape = Some(self.writer.shape(&name, &shape)?);
        let look = self.vertex_colors(false);
        self.colors.push(format!(
            "arrows × {}: position error, 0 to {max_mm:.2} mm, {}",
            scale.times,
            map.name()
        ));
        let extras = json!({
            "magnification": scale.times,
            "unit": "mm",
            "color_map": map.name(),
            "from": 0.0,
            "to": max_mm,
            "largest": found.max_mm,
        });
        self.shape_node(&name, shape, look, extras)
    }
}

/// Whether the volume's outline is that of the model's box, which is then not drawn a second time.
pub fn is_same_box(volume: &Volume, model: &Bounds) -> bool {
    volume.excess_mm().is_none() && volume.bounds() == *model
}
