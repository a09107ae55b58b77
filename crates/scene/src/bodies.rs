//! Tool and CRF at their poses with their sensors, the anatomy, and what placements paint them with.

use super::drawing::{Drawing, transform_of};
use super::painted::placement_range;
use super::palette::{BONE, of_part};
use serde_json::{Value, json};
use trackwright_design::BodyRole;
use trackwright_formats::gltf::write::{Light, Material, MaterialId, NodeId, ShapeId};
use trackwright_geometry::color::{linear, linear_from_srgb};
use trackwright_geometry::colormap::NO_VALUE_SRGB;
use trackwright_geometry::mesh::MeshPart;
use trackwright_simulation::Metric;

/// No part is smoother than this, as in the editor.
const LEAST_ROUGHNESS: f64 = 0.15;

impl Drawing<'_> {
    /// Both bodies, and the ghost, whose shape is the tool's.
    pub(super) fn bodies(&mut self) -> Vec<NodeId> {
        let mut nodes = Vec::new();
        for role in BodyRole::ALL {
            let shapes = self.shapes(role);
            nodes.extend(self.body(role, &shapes));
            if role == BodyRole::Tool {
                nodes.extend(self.ghost(&shapes));
            }
        }
        nodes
    }

    /// The parts of a body's mesh; of an empty part nothing.
    fn shapes(&mut self, role: BodyRole) -> Vec<Option<ShapeId>> {
        let parts = self.stage.mesh(role).into_iter().flat_map(|mesh| &mesh.parts);
        parts.map(|part| self.part(part)).collect()
    }

    fn body(&mut self, role: BodyRole, shapes: &[Option<ShapeId>]) -> Option<NodeId> {
        let stage = self.stage;
        let (design, view) = (stage.design(), &stage.view);
        let (body, pose) = (design.body(role)?, design.tracker_from_body(role)?);
        let mut children = Vec::new();
        let is_hidden = view.hidden.has_body(role);
        if let Some(mesh) = stage.mesh(role).filter(|_| !is_hidden) {
            let paint = self.paint(role);
            let mut paint = paint.iter().flatten().copied();
            for (part, shape) in mesh.parts.iter().zip(shapes) {
                let own: Vec<[f64; 4]> = match part.is_anatomy() {
                    true => Vec::new(),
                    false => paint.by_ref().take(part.positions_mm.len()).collect(),
                };
                if part.is_anatomy() && !view.layers.anatomy {
                    continue;
                }
                let Some(shape) = shape else { continue };
                let (shape, look) = match own.is_empty() {
                    true => (Some(shape.clone()), self.material(role, part)),
                    false => {
                        let painted = self.writer.painted(&part.name, shape, &own);
                        (painted, self.vertex_colors(false))
                    }
                };
                children.extend(self.shape_node(&part.name, shape, look, Value::Null));
            }
        }
        if view.layers.mounting && !is_hidden {
            children.extend(self.mounting(role));
        }
        children.extend(self.sensors(role));
        self.group(&format!("{role} {}", body.rigid.name), transform_of(&pose), children)
    }

    /// Parts keep their file's metal, roughness and lightness; the hue is the role's.
    fn material(&mut self, role: BodyRole, part: &MeshPart) -> MaterialId {
        if part.is_anatomy() {
            return self.anatomy_look("anatomy", BONE);
        }
        let [r, g, b, _] = part.base_color.map(f64::from);
        let [r, g, b] = of_part(role, [r, g, b], self.stage.wish.ground).map(linear_from_srgb);
        let material = Material {
            name: format!("{role}, {}", part.name),
            color: [r, g, b, 1.0],
            light: Light::Lit {
                metallic: f64::from(part.metallic),
                roughness: f64::from(part.roughness).max(LEAST_ROUGHNESS),
            },
            both_faces: false,
            fades: false,
        };
        self.writer.material(&material)
    }

    /// The colours of a body's vertices, anatomy apart, where placements paint it.
    fn paint(&mut self, role: BodyRole) -> Option<Vec<[f64; 4]>> {
        let painted = self.sampled.placement.as_ref()?;
        if painted.body != role {
            return None;
        }
        let [min, max] = placement_range(&painted.outcome, self.stage.view.placement_range_mm)?;
        let map = self.stage.view.color_maps().placement;
        let body = self.stage.design().body(role)?;
        let sensor = body.rigid.sensors.get(painted.sensor)?;
        self.colors.push(format!(
            "{role}: {} with the sensor {} there ({}, axis {}), {min:.2} to {max:.2} mm, {}",
            Metric::TIP_RMS.label(),
            sensor.name,
            self.stage.view.placement_depth.name(),
            self.stage.view.placement_rule.name(),
            map.name()
        ));
        let places = painted.outcome.places.iter();
        let colors = places.map(|place| {
            let srgb = place
                .shown_mm()
                .map_or(NO_VALUE_SRGB, |value| map.srgb_of_value(value - min, max - min));
            let [r, g, b] = linear(srgb);
            [r, g, b, 1.0]
        });
        Some(colors.collect())
    }

    /// The tool where the tracker reports it, magnified.
    fn ghost(&mut self, shapes: &[Option<ShapeId>]) -> Option<NodeId> {
        let stage = self.stage;
        if !stage.view.layers.ghost {
            return None;
        }
        let mesh = stage.mesh(BodyRole::Tool)?;
        let look = self.veil("ghost", super::palette::GHOST, GHOST_ALPHA);
        let parts = mesh.parts.iter().zip(shapes);
        let parts: Vec<_> = parts
            .filter(|(part, _)| !part.is_anatomy())
            .filter_map(|(_, shape)| Some((shape.clone()?, look)))
            .collect();
        let name = format!(
            "ghost: the tool where the tracker reports it, errors {}",
            self.times_in_words()
        );
        let mesh = self.writer.mesh("ghost", parts)?;
        let ghost = self.tool.ghost(self.times);
        let extras = json!({
            "magnification": self.times,
            "turn_is_cut_at_20_degrees": ghost.is_capped,
        });
        Some(self.node(&name, transform_of(&ghost.world_from_body), mesh, extras))
    }
}

/// How opaque the ghost is: clear enough beside the tool, and the tool is seen through it.
const GHOST_ALPHA: f64 = 0.35;
