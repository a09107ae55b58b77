//! The edits that turn a design into a layout that a search has found.

use trackwright_design::{Anatomy, AnatomyEdit, AnatomyFrame, BodyRole, Design, Edit};
use trackwright_geometry::pose::Pose;
use trackwright_optimization::Layout;
use trackwright_simulation::{RigidBody, Sensor};

/// Round-off of a pose that did not move, mm and rad.
const STILL: f64 = 1e-9;

/// The edits with which a design has the sensors and poses of a layout of its own, in the order in
/// which they are to be applied; none where it has them already. The patient, and what stands in the
/// room, stay where they are: targets and anatomy get the poses that they have in frames that moved.
pub fn layout_edits(design: &Design, layout: &Layout) -> Vec<Edit> {
    let mut edits = sensor_edits(BodyRole::Tool, &design.tool.body.rigid, &layout.tool);
    let crf = design.crf.as_ref().zip(layout.crf.as_ref());
    if let Some((crf, found)) = crf {
        edits.extend(sensor_edits(BodyRole::Crf, &crf.body.rigid, found));
    }
    let before = design.crf.as_ref().map(|crf| crf.tracker_from_crf);
    if let Some(now) = layout.tracker_from_crf
        && Some(now) != before
    {
        edits.push(Edit::SetCrfPose(now));
    }
    if layout.crf_from_tool != design.tool.crf_from_tool {
        edits.push(Edit::SetToolPose(layout.crf_from_tool));
    }
    let tool_moved = layout.crf_from_tool * design.tool.crf_from_tool.inverse();
    match before.zip(layout.tracker_from_crf) {
        // The tool stays on the patient when the CRF is moved there.
        Some((before, now)) if layout.crf_from_tool != design.tool.crf_from_tool => {
            edits.extend(target_edits(design, &tool_moved));
            edits.extend(anatomy_edits(design, AnatomyFrame::Crf, &tool_moved));
            edits.extend(room_edits(design, &(now * tool_moved * before.inverse())));
        }
        Some((before, now)) => edits.extend(room_edits(design, &(now * before.inverse()))),
        // Anatomy is in the tracker's frame then, whatever it is on.
        None if layout.crf_from_tool != design.tool.crf_from_tool => {
            for frame in AnatomyFrame::ALL {
                edits.extend(anatomy_edits(design, frame, &tool_moved));
            }
        }
        None => {}
    }
    edits
}

/// Removed, changed and added sensors of one body.
fn sensor_edits(body: BodyRole, before: &RigidBody, now: &RigidBody) -> Vec<Edit> {
    let kept = kept(&before.sensors, &now.sensors);
    let is_kept = |index: &usize| kept.contains(index);
    let removed: Vec<usize> = (0..before.sensors.len()).filter(|index| !is_kept(index)).collect();
    let changed = kept.iter().enumerate().filter_map(|(index, before_index)| {
        let sensor = &now.sensors[index];
        (before.sensors[*before_index] != *sensor).then(|| (index, sensor.clone()))
    });
    let changed: Vec<(usize, Sensor)> = changed.collect();
    let added = now.sensors[kept.len()..].to_vec();
    let mut edits = Vec::new();
    if !removed.is_empty() {
        edits.push(Edit::RemoveSensors { body, indices: removed });
    }
    if !changed.is_empty() {
        edits.push(Edit::SetSensors { body, sensors: changed });
    }
    if !added.is_empty() {
        edits.push(Edit::AddSensors { body, sensors: added });
    }
    edits
}

/// The numbers of the sensors that the first ones of a layout were, by their names and in order; what
/// follows is new.
fn kept(before: &[Sensor], now: &[Sensor]) -> Vec<usize> {
    if now.len() >= before.len() {
        return (0..before.len()).collect();
    }
    let mut kept = Vec::with_capacity(now.len());
    for (index, sensor) in before.iter().enumerate() {
        if now.get(kept.len()).is_some_and(|next| next.name == sensor.name) {
            kept.push(index);
        }
    }
    kept
}

fn target_edits(design: &Design, now_from_before: &Pose) -> Vec<Edit> {
    let targets = design.crf.iter().flat_map(|crf| &crf.targets).enumerate();
    let each = targets.map(|(index, target)| {
        let mut target = target.clone();
        target.position_in_crf = now_from_before * target.position_in_crf;
        Edit::SetTarget { index, target }
    });
    each.collect()
}

/// Of what stands in the room, where the field generator, and with it the tracker's frame, was moved.
fn room_edits(design: &Design, now_from_before: &Pose) -> Vec<Edit> {
    let is_still = now_from_before.translation.vector.norm() <= STILL
        && now_from_before.rotation.angle() <= STILL;
    match is_still {
        true => Vec::new(),
        false => anatomy_edits(design, AnatomyFrame::Tracker, now_from_before),
    }
}

fn anatomy_edits(design: &Design, on: AnatomyFrame, now_from_before: &Pose) -> Vec<Edit> {
    let own = design.anatomy.iter().enumerate().filter(|(_, anatomy)| anatomy.on == on);
    let each = own.map(|(index, anatomy)| {
        let frame_from_mesh = now_from_before * anatomy.frame_from_mesh;
        let anatomy = Box::new(Anatomy { frame_from_mesh, ..anatomy.clone() });
        Edit::Anatomy(AnatomyEdit::Set { index, anatomy })
    });
    each.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{open_builtin, resolve};
    use nalgebra::Vector3;
    use std::sync::Arc;
    use trackwright_design::Document;
    use trackwright_geometry::mesh_reference::MeshReference;

    /// A document with anatomy on the CRF and in the room.
    fn document() -> (Document, Arc<trackwright_field::Environment>) {
        let mut world = open_builtin("pointer-on-head").unwrap();
        for (name, on) in [("skull", AnatomyFrame::Crf), ("table", AnatomyFrame::Tracker)] {
            let mesh = MeshReference::new(format!("{name}.stl"));
            let frame_from_mesh = Pose::translation(1.0, 2.0, 3.0);
            let anatomy = Anatomy {
                name: name.into(),
                mesh,
                on,
                frame_from_mesh,
                color: None,
                crf_patch: Vec::new(),
            };
            let edit = Edit::Anatomy(AnatomyEdit::Add(Box::new(anatomy)));
            world.document.apply(edit).unwrap();
        }
        (world.document, world.environment)
    }

    fn layout(design: &Design) -> Layout {
        Layout {
            tool: design.tool.body.rigid.clone(),
            crf: design.crf.as_ref().map(|crf| crf.body.rigid.clone()),
            tracker_from_crf: design.crf.as_ref().map(|crf| crf.tracker_from_crf),
            crf_from_tool: design.tool.crf_from_tool,
            objective: 1.0,
            studies: Vec::new(),
            cost: None,
        }
    }

    /// The edits' document has the layout, as one undo step; the edits.
    fn applied(document: &mut Document, layout: &Layout) -> Vec<Edit> {
        let edits = layout_edits(document.design(), layout);
        document.begin("Place sensors");
        for edit in edits.clone() {
            assert!(document.apply(edit.clone()).unwrap(), "{edit:?} changes nothing");
        }
        document.commit();
        let design = document.design();
        assert_eq!(design.tool.body.rigid, layout.tool);
        assert_eq!(design.crf.as_ref().map(|crf| crf.body.rigid.clone()), layout.crf);
        assert_eq!(design.crf.as_ref().map(|crf| crf.tracker_from_crf), layout.tracker_from_crf);
        assert_eq!(design.tool.crf_from_tool, layout.crf_from_tool);
        assert!(layout_edits(design, layout).is_empty());
        edits
    }

    #[test]
    fn the_start_needs_no_edit() {
        let (mut document, _) = document();
        let start = layout(document.design());
        assert!(applied(&mut document, &start).is_empty());
    }

    #[test]
    fn sensors_are_moved_added_and_removed() {
        let (mut document, environment) = document();
        let mut found = layout(document.design());
        found.tool.sensors[1].position_in_body.z += 7.0;
        let added = Sensor { name: "grip 2".to_owned(), ..found.tool.sensors[1].clone() };
        found.tool.sensors.push(added);
        found.crf.as_mut().unwrap().sensors[0].position_in_body.x -= 1.0;
        assert_eq!(applied(&mut document, &found).len(), 3);
        let scenario = resolve(document.design(), &environment);
        assert_eq!(scenario.tool, found.tool);
        // Fewer than before: the first of the tool and the last of the CRF are gone, one has moved.
        found.tool.sensors.remove(0);
        found.tool.sensors[0].position_in_body.y += 2.0;
        found.crf.as_mut().unwrap().sensors.pop();
        assert_eq!(applied(&mut document, &found).len(), 3);
        assert_eq!(document.undo().as_deref(), Some("Place sensors"));
        assert_eq!(document.undo().as_deref(), Some("Place sensors"));
        assert_eq!(document.design().tool.body.rigid.sensors.len(), 3);
    }

    #[test]
    fn what_is_not_moved_stays_where_it_is() {
        let (mut document, _) = document();
        let before = document.design().clone();
        let moved = Pose::new(Vector3::new(5.0, -3.0, 2.0), Vector3::new(0.1, 0.2, -0.1));
        let generator = Pose::new(Vector3::new(40.0, 0.0, -20.0), Vector3::new(0.0, 0.3, 0.0));
        let mut found = layout(&before);
        found.tracker_from_crf =
            found.tracker_from_crf.map(|pose| generator.inverse() * pose * moved);
        found.crf_from_tool = moved.inverse() * found.crf_from_tool;
        applied(&mut document, &found);
        let now = document.design();
        // All of them seen from where the field generator was.
        let in_room = |design: &Design, room_from_tracker: &Pose| {
            let tracker_from_crf = design.crf.as_ref().unwrap().tracker_from_crf;
            let targets = design.crf.iter().flat_map(|crf| &crf.targets);
            let mut points: Vec<_> = targets
                .map(|target| room_from_tracker * tracker_from_crf * target.position_in_crf)
                .collect();
            for anatomy in &design.anatomy {
                let room_from_mesh = room_from_tracker * anatomy.tracker_from_mesh(design);
                points.extend(
                    [[0.0; 3], [90.0, 0.0, 0.0], [0.0, 90.0, 0.0]]
                        .map(|point| room_from_mesh * nalgebra::Point3::from(point)),
                );
            }
            points
        };
        let (was, is) = (in_room(&before, &Pose::identity()), in_room(now, &generator));
        assert_eq!(was.len(), 9);
        for (was, is) in was.iter().zip(&is) {
            assert!((was - is).norm() < 1e-9, "{was} {is}");
        }
        // The field generator alone leaves the patient as it is.
        let mut found = layout(now);
        found.tracker_from_crf = found.tracker_from_crf.map(|pose| generator * pose);
        let edits = applied(&mut document, &found);
        assert_eq!(edits.len(), 2, "{edits:?}");
    }
}
