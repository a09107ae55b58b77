//! A new tool from nothing but its mesh: tip and shaft are taken from the surface.

use super::builtin::Starter;
use super::error::StoreError;
use super::meshes::ImportedMesh;
use super::open::open_builtin_without_meshes;
use super::world::World;
use nalgebra::{Unit, UnitQuaternion, Vector3};
use trackwright_design::{BodyRole, Design, DesignBody, Edit};
use trackwright_geometry::long_body::LongBody;
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_simulation::{Coil, Pivot, RigidBody, Sensor, SensorOrientation};

/// Where the two sensors of a new tool are, as parts of its length from the tip.
const PLACES: [(&str, f64); 2] = [("distal", 0.2), ("proximal", 0.5)];

/// The edits that make the plain tool of a new design the one whose mesh was read, with two sensors along it.
///
/// The tip is the middle of the thinner end, and lies in the tracker's frame where the plain tool's tip was, the
/// shaft along the plain tool's. The second sensor is across the shaft where its coil fits, so that turns
/// about the shaft are measured.
///
/// # Errors
/// As the plain tool's, which is built in.
pub fn new_tool_of_mesh(mesh: &ImportedMesh, name: &str) -> Result<Vec<Edit>, StoreError> {
    let world = open_builtin_without_meshes(Starter::Tool.name())?;
    let design = world.document.design();
    let plain = &design.tool.body;
    let found = LongBody::of(&mesh.surface);
    let rigid = RigidBody {
        name: name.to_owned(),
        tip_in_body: Some(found.map_or(plain.rigid.judged_tip_in_body(), |body| body.tip_mm)),
        sensors: match &found {
            Some(body) => sensors(&plain.rigid, body, &mesh.surface),
            None => plain.rigid.sensors.clone(),
        },
    };
    let pose = found.map_or(design.tool.crf_from_tool, |body| pose_of(&body, design));
    let content = DesignBody {
        reference: format!("{name}.body.ron"),
        mesh: Some(mesh.request.reference.clone()),
        rigid,
        ..plain.clone()
    };
    let mut motion = design.motion;
    if let Some(motion) = &mut motion {
        motion.pivot = Pivot::Tip;
    }
    Ok(vec![
        Edit::SetName(name.to_owned()),
        Edit::SetBody { body: BodyRole::Tool, content: Box::new(content) },
        Edit::SetToolPose(pose),
        Edit::SetMotion(motion),
    ])
}

/// The edits after which the tool's mesh lies the other way around, and its tip is at the mesh's other end; tip
/// and sensors stay where they are in the tracker's frame. `None` without a mesh that is long.
pub fn flipped_tool(world: &World) -> Option<Vec<Edit>> {
    let design = world.document.design();
    let tool = &design.tool.body.rigid;
    let long = LongBody::of(world.mesh(BodyRole::Tool)?)?;
    let middle = long.tip_mm.coords + *long.back * (long.length_mm / 2.0);
    let turn = UnitQuaternion::from_axis_angle(&across(&long.back), std::f64::consts::PI);
    let flip = pose_from_parts(middle - turn * middle, turn);
    let sensors = tool.sensors.iter().enumerate().map(|(index, sensor)| {
        let mut sensor = sensor.clone();
        sensor.position_in_body = flip * sensor.position_in_body;
        sensor.orientation = sensor.orientation.rotated_by(&turn);
        (index, sensor)
    });
    Some(vec![
        Edit::SetSensors { body: BodyRole::Tool, sensors: sensors.collect() },
        Edit::SetTip { body: BodyRole::Tool, tip_in_body: Some(flip * tool.judged_tip_in_body()) },
        Edit::SetToolPose(design.tool.crf_from_tool * flip.inverse()),
    ])
}

fn sensors(plain: &RigidBody, body: &LongBody, mesh: &SurfaceMesh) -> Vec<Sensor> {
    let coil = plain.sensors.first().and_then(|sensor| sensor.coil);
    let place = |(index, (name, part)): (usize, (&str, f64))| {
        let from_tip_mm = part * body.length_mm;
        let cut = body.cut(mesh, from_tip_mm);
        let on_line = body.tip_mm + *body.back * from_tip_mm;
        let is_across = index > 0
            && cut.zip(coil).is_some_and(|(cut, coil)| cut.least_radius_mm > half_across_mm(&coil));
        let axis = if is_across { across(&body.back) } else { body.back };
        Sensor {
            name: name.to_owned(),
            position_in_body: cut.map_or(on_line, |cut| cut.center_mm),
            orientation: SensorOrientation::FiveDof(axis),
            coil,
        }
    };
    PLACES.into_iter().enumerate().map(place).collect()
}

/// From the middle of a coil to its farthest corner.
fn half_across_mm(coil: &Coil) -> f64 {
    coil.diameter_mm.hypot(coil.length_mm) / 2.0
}

/// A direction across another, along an axis of the frame where that is possible.
fn across(direction: &Unit<Vector3<f64>>) -> Unit<Vector3<f64>> {
    let mut least = Vector3::zeros();
    least[direction.iamin()] = 1.0;
    Unit::new_normalize(least - **direction * direction.dot(&least))
}

/// With the tip where the plain tool has it, and the shaft along that of the plain tool, which is +z.
fn pose_of(body: &LongBody, design: &Design) -> Pose {
    let plain = design.tool.crf_from_tool;
    let tip = plain * design.tool.body.rigid.judged_tip_in_body();
    let turn = UnitQuaternion::rotation_between_axis(&body.back, &Vector3::z_axis());
    let to_z = turn.unwrap_or_else(|| {
        UnitQuaternion::from_axis_angle(&across(&body.back), std::f64::consts::PI)
    });
    let rotation = plain.rotation * to_z;
    pose_from_parts(tip.coords - rotation * body.tip_mm.coords, rotation)
}
