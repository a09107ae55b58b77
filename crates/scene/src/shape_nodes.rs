//! The layers of shapes as nodes of the file.

use super::drawing::{Drawing, transform_of};
use super::palette::Rgb;
use super::shapes::{Form, LAYERS, Look, Shape, ShapeLayer, Shown};
use nalgebra::{Point3, Vector3};
use serde_json::{Map, Value, json};
use std::f64::consts::TAU;
use trackwright_formats::gltf::write::{NodeId, NodeTransform};
use trackwright_geometry::pose::{Pose, quaternion_from_matrix};
use trackwright_geometry::solid::Solid;

/// Chords of a great circle.
const CHORDS: usize = 96;

/// How opaque the great circles of an outline and the surface of a veil are.
const OUTLINE_ALPHA: f64 = 0.8;
const VEIL_ALPHA: f64 = 0.3;

impl Drawing<'_> {
    /// What shapes are made from.
    pub(super) fn shown(&self) -> Shown<'_> {
        Shown {
            design: self.stage.design(),
            shown: self.stage.design(),
            hidden: &self.stage.view.hidden,
            pose: Some(&self.sampled.pose),
            scatter: self.sampled.scatter.as_ref(),
            times: self.times,
            eye: self.eye,
            is_live: false,
        }
    }

    /// Those that are on.
    pub(super) fn shape_layers(&self) -> impl Iterator<Item = &'static ShapeLayer> {
        let on = self.stage.view.layers;
        LAYERS.iter().filter(move |layer| layer.row.is_on(on))
    }

    pub(super) fn shape_nodes(&mut self) -> Vec<NodeId> {
        let shown = self.shown();
        let of_layer = |layer: &ShapeLayer| {
            let shapes = (layer.shapes)(&shown).into_iter();
            shapes.map(|shape| (layer.color, shape)).collect::<Vec<_>>()
        };
        let shapes: Vec<_> = self.shape_layers().flat_map(of_layer).collect();
        shapes.into_iter().filter_map(|(color, shape)| self.node_of_shape(color, &shape)).collect()
    }

    fn node_of_shape(&mut self, color: Rgb, shape: &Shape) -> Option<NodeId> {
        let magnified = format!("{}, {}", shape.name, self.times_in_words());
        let figures = shape.figures.iter().map(|(name, value)| ((*name).to_owned(), json!(value)));
        let mut extras: Map<String, Value> = figures.collect();
        match &shape.form {
            Form::Arrow(arrow) => {
                let mut solid = Solid::default();
                arrow.push_to(&mut solid, &self.eye);
                let material = self.unlit("error vector", color, 1.0);
                extras.insert("error_mm".to_owned(), json!(arrow.error_mm.as_slice()));
                extras.insert("magnification".to_owned(), json!(self.times));
                extras.insert("is_cut".to_owned(), json!(arrow.is_cut(&self.eye)));
                self.solid_node(&magnified, &solid, material, extras.into())
            }
            Form::Ellipsoid { center_mm, turn, half_lengths_mm, look: Look::Outline } => {
                let material = self.unlit(&shape.name, color, OUTLINE_ALPHA);
                let circles = [0, 1, 2].map(|axis| {
                    let point = |k: usize| {
                        let (sine, cosine) = (k as f64 / CHORDS as f64 * TAU).sin_cos();
                        let mut at = Vector3::zeros();
                        at[(axis + 1) % 3] = cosine;
                        at[(axis + 2) % 3] = sine;
                        center_mm + turn * at.component_mul(half_lengths_mm)
                    };
                    (0..=CHORDS).map(point).collect::<Vec<Point3<f64>>>()
                });
                self.lines(&magnified, circles.iter().map(Vec::as_slice), material)
            }
            Form::Ellipsoid { center_mm, turn, half_lengths_mm, look: Look::Veil } => {
                let sphere = self.solid(&shape.name, &Solid::sphere(1.0))?;
                let material = self.veil(&shape.name, color, VEIL_ALPHA);
                let mesh = self.writer.mesh(&shape.name, [(sphere, material)])?;
                let transform = NodeTransform {
                    rotation: quaternion_from_matrix(turn),
                    scale: *half_lengths_mm,
                    ..transform_of(&Pose::translation(center_mm.x, center_mm.y, center_mm.z))
                };
                extras.insert("magnification".to_owned(), json!(self.times));
                Some(self.node(&magnified, transform, mesh, extras.into()))
            }
            Form::Lines { strips, alpha } => {
                let material = self.unlit(&shape.name, color, *alpha);
                self.lines(&shape.name, strips.iter().map(Vec::as_slice), material)
            }
        }
    }
}
