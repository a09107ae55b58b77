//! Errors, magnified: a vector at each sensor and at the tip, the sphere that the tip's should end in,
//! and where jitter scatters it.

use super::arrow_style::ArrowStyle;
use super::drawing::{Drawing, transform_of};
use super::palette::{ERROR_VECTOR, REQUIREMENT, SCATTER};
use nalgebra::{Matrix3, Point3, Vector3};
use serde_json::json;
use std::f64::consts::TAU;
use trackwright_design::BodyRole;
use trackwright_formats::gltf::write::{NodeId, NodeTransform};
use trackwright_geometry::pose::{Pose, quaternion_from_matrix};
use trackwright_geometry::solid::Solid;
use trackwright_simulation::body::Sensor;
use trackwright_simulation::uncertainty::Ellipsoid;

/// A sphere with a larger radius than this share of the view's height would be a frame around
/// everything: the vector ends so deep inside it that it shows nothing.
const LARGEST_SHARE: f64 = 0.6;

/// Chords of a great circle.
const CHORDS: usize = 96;

/// How opaque the ellipsoid is.
const SCATTER_ALPHA: f64 = 0.3;

impl Drawing<'_> {
    pub(super) fn errors(&mut self) -> Vec<NodeId> {
        let mut nodes = Vec::new();
        let layers = self.stage.view.layers;
        if layers.sensor_errors {
            for role in BodyRole::ALL {
                nodes.extend(self.sensor_errors(role));
            }
        }
        if layers.tip_error {
            nodes.extend(self.tip_error());
        }
        if layers.requirement {
            nodes.extend(self.requirement());
        }
        nodes.extend(self.scatter());
        nodes
    }

    /// From where each sensor is to where the tracker reports it.
    fn sensor_errors(&mut self, role: BodyRole) -> Vec<NodeId> {
        let (stage, sampled) = (self.stage, self.sampled);
        let detail = match role {
            BodyRole::Tool => Some(&sampled.pose.tool),
            BodyRole::Crf => sampled.pose.crf.as_ref(),
        };
        let (Some(detail), Some(body)) = (detail, stage.design().body(role)) else {
            return Vec::new();
        };
        let sensors: Vec<&Sensor> = body.rigid.sensors.iter().collect();
        let found = sensors.into_iter().zip(&detail.sensors);
        let nodes = found.filter_map(|(sensor, found)| {
            if stage.view.hidden.has_sensor(role, &sensor.name) {
                return None;
            }
            let from = found.tracker_from_sensor.translation.vector;
            let error = found.tracker_from_measured.translation.vector - from;
            let name = format!("error of the {role}'s sensor {}", sensor.name);
            self.arrow(&name, &from.into(), &error, ArrowStyle::OF_SENSOR)
        });
        nodes.collect()
    }

    /// From the tip to the ghost's.
    fn tip_error(&mut self) -> Option<NodeId> {
        let (tip, error) = (self.tool.tip_mm(), self.tool.error_mm());
        self.arrow("error of the tip", &tip, &error, ArrowStyle::OF_TIP)
    }

    /// A vector as it is drawn, and what it is.
    fn arrow(
        &mut self,
        name: &str,
        from_mm: &Point3<f64>,
        error_mm: &Vector3<f64>,
        style: ArrowStyle,
    ) -> Option<NodeId> {
        let drawn = error_mm * self.times;
        let size = style.size(&drawn, self.eye.mm_per_px(from_mm), self.eye.view_px[1])?;
        let mut solid = Solid::default();
        solid.push_arrow(from_mm, &drawn, &size);
        let material = self.unlit("error vector", ERROR_VECTOR, 1.0);
        let extras = json!({
            "error_mm": [error_mm.x, error_mm.y, error_mm.z],
            "magnification": self.times,
            "is_cut": drawn.norm() > size.most_mm,
        });
        let name = format!("{name}, {}", self.times_in_words());
        self.solid_node(&name, &solid, material, extras)
    }

    /// Three great circles of the sphere that the tip's error should end in.
    fn requirement(&mut self) -> Option<NodeId> {
        let requirement = self.stage.design().requirement?;
        let (_, limit_mm) = requirement.single_position_mm()?;
        let tip = self.tool.tip_mm();
        let radius_mm = limit_mm * self.times;
        let radius_px = radius_mm / self.eye.mm_per_px(&tip);
        if radius_px >= LARGEST_SHARE * self.eye.view_px[1] {
            return None;
        }
        let material = self.unlit("requirement", REQUIREMENT, 0.8);
        let circles = [0, 1, 2].map(|axis| {
            let point = |k: usize| {
                let (sine, cosine) = (k as f64 / CHORDS as f64 * TAU).sin_cos();
                let mut at = tip;
                at[(axis + 1) % 3] += radius_mm * cosine;
                at[(axis + 2) % 3] += radius_mm * sine;
                at
            };
            (0..=CHORDS).map(point).collect::<Vec<_>>()
        });
        let name = format!("requirement of {limit_mm} mm at the tip, {}", self.times_in_words());
        self.lines(&name, circles.iter().map(Vec::as_slice), material)
    }

    /// The ellipsoid that holds 95 % of where jitter puts the tip, around the ghost's.
    fn scatter(&mut self) -> Option<NodeId> {
        let scatter = self.sampled.scatter.as_ref()?;
        let tracker_from_crf =
            self.stage.design().tracker_from_body(BodyRole::Crf).unwrap_or_else(Pose::identity);
        let tip = self.tool.ghost(self.times).world_from_body * self.tool.tip_in_tool;
        let (turn, lengths_mm) = axes_of(&scatter.ellipsoid, &tracker_from_crf);
        let sphere = Solid::sphere(1.0);
        let shape = self.solid("tip scatter", &sphere)?;
        let material = self.veil("tip scatter", SCATTER, SCATTER_ALPHA);
        let mesh = self.writer.mesh("tip scatter", [(shape, material)])?;
        let transform = NodeTransform {
            rotation: quaternion_from_matrix(&turn),
            scale: lengths_mm * self.times,
            ..transform_of(&Pose::translation(tip.x, tip.y, tip.z))
        };
        let name = format!("95 % of where jitter puts the tip, {}", self.times_in_words());
        let extras = json!({"rms_mm": scatter.rms_mm, "magnification": self.times});
        Some(self.node(&name, transform, mesh, extras))
    }
}

/// An ellipsoid's axes as the columns of a rotation, tracker frame, and their half lengths, mm; one
/// of no size has no axes.
fn axes_of(ellipsoid: &Ellipsoid, tracker_from_crf: &Pose) -> (Matrix3<f64>, Vector3<f64>) {
    let axes_mm = ellipsoid.semi_axes_in_crf_mm.map(|axis| tracker_from_crf * axis);
    let unit = |k: usize| axes_mm[k].try_normalize(0.0);
    let turn = match (unit(0), unit(1)) {
        (Some(a), Some(b)) => Matrix3::from_columns(&[a, b, a.cross(&b)]),
        _ => Matrix3::identity(),
    };
    (turn, Vector3::from(axes_mm.map(|axis| axis.norm())))
}
