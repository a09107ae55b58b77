//! A scene in the making: the writer, the colours, what all parts of the scene are drawn with.

use super::palette::Rgb;
use super::tool_errors::ToolErrors;
use super::{Sampled, Scene, SceneError, Stage};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use serde_json::{Value, json};
use trackwright_design::view::Magnification;
use trackwright_formats::gltf::write::{
    Elements, GlbWriter, Light, Material, MaterialId, MeshId, Node, NodeId, NodeTransform, Shape,
    ShapeId,
};
use trackwright_geometry::color::linear;
use trackwright_geometry::gizmo::Eye;
use trackwright_geometry::magnification::automatic_magnification;
use trackwright_geometry::mesh::MeshPart;
use trackwright_geometry::orbit::{OrbitCamera, Projection, VERTICAL_FOV_RAD};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::solid::Solid;

/// glTF counts in metres.
const METRES_PER_MM: f64 = 0.001;

/// A scene in the making.
pub struct Drawing<'a> {
    pub stage: &'a Stage<'a>,
    pub sampled: &'a Sampled,
    pub writer: GlbWriter,
    pub eye: Eye,
    pub tool: ToolErrors,
    /// How many times larger than life errors are.
    pub times: f64,
    pub colors: Vec<String>,
}

impl<'a> Stage<'a> {
    /// The scene as a file.
    ///
    /// # Errors
    /// See [`SceneError`].
    pub fn draw(&'a self, sampled: &'a Sampled) -> Result<Scene, SceneError> {
        let design = self.design();
        let tool = ToolErrors::of(design, &sampled.pose);
        let eye = self.eye();
        let times = match self.view.magnification {
            Magnification::Times(times) => times,
            Magnification::Auto => {
                let height_mm = eye.mm_per_px(&tool.tip_mm()) * eye.view_px[1];
                automatic_magnification(tool.error_mm().norm(), height_mm)
            }
        };
        let generator = concat!("trackwright ", env!("CARGO_PKG_VERSION"));
        let mut drawing = Drawing {
            stage: self,
            sampled,
            writer: GlbWriter::new(generator),
            eye,
            tool,
            times,
            colors: Vec::new(),
        };
        let mut nodes = drawing.bodies();
        nodes.extend(drawing.anatomy());
        nodes.extend(drawing.metal());
        nodes.extend(drawing.shape_nodes());
        nodes.extend(drawing.slice());
        nodes.extend(drawing.field_arrows());
        nodes.extend(drawing.room()?);
        drawing.finish(nodes)
    }
}

impl Drawing<'_> {
    /// An sRGB colour of a role as linear light, with an opacity.
    pub fn linear(&self, color: Rgb, alpha: f64) -> [f64; 4] {
        let [r, g, b] = linear(color.on(self.stage.wish.ground));
        [r, g, b, alpha]
    }

    /// A colour that no lamp changes, as the editor draws glyphs.
    pub fn unlit(&mut self, name: &str, color: Rgb, alpha: f64) -> MaterialId {
        let material = Material {
            name: name.to_owned(),
            color: self.linear(color, alpha),
            light: Light::Unlit,
            both_faces: false,
            fades: false,
        };
        self.writer.material(&material)
    }

    /// A translucent surface whose form is shown by light. The editor shows it by a rim, which glTF
    /// does not have.
    pub fn veil(&mut self, name: &str, color: Rgb, alpha: f64) -> MaterialId {
        let material = Material {
            name: name.to_owned(),
            color: self.linear(color, alpha),
            light: Light::Lit { metallic: 0.0, roughness: 0.8 },
            both_faces: true,
            fades: false,
        };
        self.writer.material(&material)
    }

    /// Vertex colours that no lamp changes.
    pub fn vertex_colors(&mut self, fades: bool) -> MaterialId {
        self.writer.material(&Material {
            name: match fades {
                true => "fading colours of the corners".to_owned(),
                false => "colours of the corners".to_owned(),
            },
            color: [1.0; 4],
            light: Light::Unlit,
            both_faces: true,
            fades,
        })
    }

    /// The shape of a solid.
    pub fn solid(&mut self, name: &str, solid: &Solid) -> Option<ShapeId> {
        let elements = Elements::Triangles(&solid.triangles);
        let (positions, normals) = (&solid.positions_mm, &solid.normals);
        self.writer.shape(name, &Shape { positions, normals, colors: &[], elements })
    }

    /// The shape of a mesh's part; of an empty part nothing.
    pub fn part(&mut self, part: &MeshPart) -> Option<ShapeId> {
        let elements = Elements::Triangles(&part.triangles);
        let (positions, normals) = (&part.positions_mm, &part.normals);
        self.writer.shape(&part.name, &Shape { positions, normals, colors: &[], elements })
    }

    /// A node of a shape that is there once.
    pub fn shape_node(
        &mut self,
        name: &str,
        shape: Option<ShapeId>,
        material: MaterialId,
        extras: Value,
    ) -> Option<NodeId> {
        let mesh = self.writer.mesh(name, [(shape?, material)])?;
        Some(self.node(name, NodeTransform::default(), mesh, extras))
    }

    /// A node of a solid, where it is.
    pub fn solid_node(
        &mut self,
        name: &str,
        solid: &Solid,
        material: MaterialId,
        extras: Value,
    ) -> Option<NodeId> {
        let shape = self.solid(name, solid);
        self.shape_node(name, shape, material, extras)
    }

    /// A node of a mesh.
    pub fn node(
        &mut self,
        name: &str,
        transform: NodeTransform,
        mesh: MeshId,
        extras: Value,
    ) -> NodeId {
        self.writer.node(Node {
            name: name.to_owned(),
            transform,
            mesh: Some(mesh),
            extras,
            ..Node::default()
        })
    }

    /// A node that holds others; `None` around none.
    pub fn group(
        &mut self,
        name: &str,
        transform: NodeTransform,
        children: Vec<NodeId>,
    ) -> Option<NodeId> {
        (!children.is_empty()).then(|| {
            self.writer.node(Node { name: name.to_owned(), transform, children, ..Node::default() })
        })
    }

    /// A node of lines through points.
    pub fn lines<'l>(
        &mut self,
        name: &str,
        lines: impl IntoIterator<Item = &'l [Point3<f64>]>,
        material: MaterialId,
    ) -> Option<NodeId> {
        let (mut positions, mut pairs) = (Vec::new(), Vec::new());
        for line in lines {
            let base = positions.len() as u32;
            positions.extend_from_slice(line);
            pairs.extend((base + 1..positions.len() as u32).map(|end| [end - 1, end]));
        }
        let shape = Shape::unlit(&positions, &[], Elements::Lines(&pairs));
        let shape = self.writer.shape(name, &shape);
        self.shape_node(name, shape, material, Value::Null)
    }

    /// `× 50`.
    pub fn times_in_words(&self) -> String {
        format!("× {}", self.times)
    }

    /// Everything under the node that turns the tracker's millimetres into glTF's metres.
    fn finish(mut self, children: Vec<NodeId>) -> Result<Scene, SceneError> {
        let gltf_from_tracker = gltf_from_tracker();
        let root = self.writer.node(Node {
            name: "tracker frame, mm".to_owned(),
            transform: NodeTransform {
                rotation: gltf_from_tracker,
                scale: Vector3::repeat(METRES_PER_MM),
                ..NodeTransform::default()
            },
            children,
            ..Node::default()
        });
        // Beside it: programs differ in what a scaled camera sees.
        // In perspective, which shows as much at the focus: viewers turn about such a camera.
        let perspective = OrbitCamera { projection: Projection::Perspective, ..self.eye.camera };
        let seen = perspective.tracker_from_camera();
        let focus = gltf_from_tracker * self.eye.camera.focus_mm * METRES_PER_MM;
        let camera = self.writer.node(Node {
            name: "opening view".to_owned(),
            transform: NodeTransform {
                translation: gltf_from_tracker * seen.translation.vector * METRES_PER_MM,
                rotation: gltf_from_tracker * seen.rotation,
                ..NodeTransform::default()
            },
            camera_fov_rad: Some(VERTICAL_FOV_RAD),
            extras: json!({"turns_about": [focus.x, focus.y, focus.z]}),
            ..Node::default()
        });
        let design = self.stage.design();
        let extras = json!({
            "design": design.name,
            "environment": self.stage.world.environment.name,
            "units": "metres; the node \"tracker frame, mm\" holds the tracker's frame in millimetres",
            "layers": self.stage.view.layers.names(),
            "magnification": self.times,
            "tip_error_mm": self.sampled.pose.trial.tip_error_mm,
        });
        let (magnification, legend) = (self.times, self.legend());
        let glb = self.writer.finish(&design.name, &[root, camera], &extras)?;
        let mut notes = self.stage.notes.clone();
        notes.extend(self.sampled.missing.iter().cloned());
        Ok(Scene { glb, magnification, legend, colors: self.colors, notes })
    }
}

/// The tracker's -z, which the editor has up on the screen, becomes glTF's +y, its y the front.
pub fn gltf_from_tracker() -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2)
}

/// Where a body is, as a node's transform.
pub fn transform_of(target_from_source: &Pose) -> NodeTransform {
    NodeTransform {
        translation: target_from_source.translation.vector,
        rotation: target_from_source.rotation,
        ..NodeTransform::default()
    }
}
