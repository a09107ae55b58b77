//! Sensors: coils with their axes, balls for markers, discs through what is outside.

use super::drawing::{Drawing, transform_of};
use super::palette::{AXES, OUTSIDE, SENSOR, SENSOR_AXIS};
use super::sensor_look::{SensorLook, axis_solid, hatch_solid};
use nalgebra::{UnitQuaternion, Vector3};
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_2;
use trackwright_design::BodyRole;
use trackwright_formats::gltf::write::{MeshId, Node, NodeId, NodeTransform};
use trackwright_geometry::solid::Solid;
use trackwright_simulation::SensorDetail;
use trackwright_simulation::body::Sensor;

/// Shapes of unit size, each written once.
struct Glyphs {
    coil: Option<MeshId>,
    ball: Option<MeshId>,
    hatch: Option<MeshId>,
    axis: Option<MeshId>,
    triad: [Option<MeshId>; 3],
}

impl Drawing<'_> {
    /// The sensors of a body, in its frame.
    pub(super) fn sensors(&mut self, role: BodyRole) -> Vec<NodeId> {
        let (design, hidden) = (self.stage.design(), &self.stage.view.hidden);
        let Some(body) = design.body(role) else {
            return Vec::new();
        };
        let detail = match role {
            BodyRole::Tool => Some(&self.sampled.pose.tool),
            BodyRole::Crf => self.sampled.pose.crf.as_ref(),
        };
        let shown: Vec<(&Sensor, Option<&SensorDetail>)> = (body.rigid.sensors.iter().enumerate())
            .filter(|(_, sensor)| !hidden.has_sensor(role, &sensor.name))
            .map(|(index, sensor)| (sensor, detail.and_then(|d| d.sensors.get(index))))
            .collect();
        let is_any_outside = shown.iter().any(|(_, found)| is_outside(*found));
        let looks = shown.iter().map(|(sensor, _)| SensorLook::of(sensor));
        let glyphs = self.glyphs(looks, is_any_outside);
        let nodes = shown
            .into_iter()
            .filter_map(|(sensor, found)| self.sensor(role, sensor, found, &glyphs));
        nodes.collect()
    }

    /// The shapes that these sensors need, and no others.
    fn glyphs(
        &mut self,
        looks: impl Iterator<Item = SensorLook> + Clone,
        is_any_outside: bool,
    ) -> Glyphs {
        let any = |freedom: u8| looks.clone().any(|look| look.degrees_of_freedom == freedom);
        let (has_markers, has_axes, has_triads) = (any(3), any(5), any(6));
        let mut mesh = |name: &str, solid: Solid, color, is_needed: bool| {
            let shape = is_needed.then(|| self.solid(name, &solid)).flatten()?;
            let material = self.unlit(name, color, 1.0);
            self.writer.mesh(name, [(shape, material)])
        };
        let has_coils = has_axes || has_triads;
        let coil = mesh("coil", Solid::coil(), SENSOR, has_coils);
        let ball = mesh("marker", Solid::sphere(0.5), SENSOR, has_markers);
        let hatch = mesh("outside", hatch_solid(), OUTSIDE, is_any_outside);
        let axis = has_coils.then(|| self.solid("axis", &axis_solid())).flatten();
        let mut colored = |name: &str, color, is_needed: bool| {
            let shape = axis.clone().filter(|_| is_needed)?;
            let material = self.unlit(name, color, 1.0);
            self.writer.mesh(name, [(shape, material)])
        };
        Glyphs {
            coil,
            ball,
            hatch,
            axis: colored("sensor axis", SENSOR_AXIS, has_axes),
            triad: [0, 1, 2].map(|k| colored(["x", "y", "z"][k], AXES[k], has_triads)),
        }
    }

    fn sensor(
        &mut self,
        role: BodyRole,
        sensor: &Sensor,
        found: Option<&SensorDetail>,
        glyphs: &Glyphs,
    ) -> Option<NodeId> {
        let look = SensorLook::of(sensor);
        let pose = self.stage.design().tracker_from_body(role)?;
        let mm_per_px = self.eye.mm_per_px(&(pose * sensor.position_in_body));
        let (across, along) = look.drawn_size();
        let [across, along] = [across.mm(mm_per_px), along.mm(mm_per_px)];
        let sized = |scale: Vector3<f64>, rotation| NodeTransform {
            scale,
            rotation,
            ..NodeTransform::default()
        };
        let still = UnitQuaternion::identity();
        let coil = sized(Vector3::new(across, across, along), still);
        let mut children = Vec::new();
        let mut add = |name: &str, mesh: Option<MeshId>, transform| {
            children.extend(mesh.map(|mesh| self.node(name, transform, mesh, Value::Null)));
        };
        match look.is_marker() {
            true => add("marker", glyphs.ball, coil),
            false => add("coil", glyphs.coil, coil),
        }
        let is_outside = is_outside(found);
        if is_outside {
            add("outside the room's model or the volume", glyphs.hatch, coil);
        }
        let length = Vector3::repeat(look.axis_size().mm(mm_per_px));
        match look.degrees_of_freedom {
            6 => {
                let turn = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
                let to_x = turn(Vector3::y_axis(), FRAC_PI_2);
                let to_y = turn(Vector3::x_axis(), -FRAC_PI_2);
                for (k, rotation) in [to_x, to_y, still].into_iter().enumerate() {
                    add(["x", "y", "z"][k], glyphs.triad[k], sized(length, rotation));
                }
            }
            5 => add("axis", glyphs.axis, sized(length, still)),
            _ => {}
        }
        let mut extras = json!({"kind": sensor.orientation.kind_name()});
        if let Some(found) = found {
            let error = found.error.position_mm;
            extras["error_mm"] = json!([error.x, error.y, error.z]);
            extras["error_deg"] = json!(found.error.rotation_rad.norm().to_degrees());
            extras["outside"] = json!(is_outside);
        }
        let node = Node {
            name: format!("sensor {}", sensor.name),
            transform: transform_of(&sensor.body_from_sensor()),
            children,
            extras,
            ..Node::default()
        };
        Some(self.writer.node(node))
    }
}

/// Outside the model's box or the measurement volume.
fn is_outside(found: Option<&SensorDetail>) -> bool {
    found.is_some_and(|found| !(found.is_inside && found.is_in_volume))
}
