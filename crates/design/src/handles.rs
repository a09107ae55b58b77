//! Moving things by hand: which edit puts a body, a sensor or a metal object where a movement in the
//! tracker frame takes it.

use super::content::Design;
use super::edit::Edit;
use super::metal_edits::MetalEdit;
use super::things::BodyRole;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use trackwright_geometry::movement::Movement;
use trackwright_geometry::pose::Pose;

/// Which axes handles follow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum HandleAxes {
    /// Those of what is moved.
    #[default]
    Own,
    Tracker,
}

impl HandleAxes {
    pub fn other(self) -> Self {
        match self {
            Self::Own => Self::Tracker,
            Self::Tracker => Self::Own,
        }
    }

    fn rotation(self, own: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        match self {
            Self::Own => own,
            Self::Tracker => UnitQuaternion::identity(),
        }
    }
}

impl Design {
    /// Where a body is taken hold of, `tracker_from_handle`: at its tip, or its origin where it
    /// has none. A tool is turned about its tip by those who hold one; about an origin somewhere
    /// in its grip the tip, whose error is judged, would sweep through the room.
    pub fn tracker_from_body_handle(&self, role: BodyRole, axes: HandleAxes) -> Option<Pose> {
        let tracker_from_body = self.tracker_from_body(role)?;
        let pivot = tracker_from_body * self.body(role)?.rigid.judged_tip_in_body();
        Some(Pose::from_parts(
            Translation3::from(pivot.coords),
            axes.rotation(tracker_from_body.rotation),
        ))
    }

    /// Where a sensor is turned, `tracker_from_handle`.
    pub fn tracker_from_sensor_handle(
        &self,
        role: BodyRole,
        index: usize,
        axes: HandleAxes,
    ) -> Option<Pose> {
        let sensor = self.body(role)?.rigid.sensors.get(index)?;
        let own = self.tracker_from_body(role)? * sensor.body_from_sensor();
        let rotation = axes.rotation(own.rotation);
        Some(Pose::from_parts(own.translation, rotation))
    }

    /// Where a metal object of the room is taken hold of, `tracker_from_handle`: at its origin.
    pub fn tracker_from_metal_handle(&self, index: usize, axes: HandleAxes) -> Option<Pose> {
        let own = self.metal_object(index)?.tracker_from_object;
        Some(Pose::from_parts(own.translation, axes.rotation(own.rotation)))
    }

    /// The edit that moves a metal object in the tracker frame.
    pub fn moved_metal(&self, index: usize, in_tracker: &Movement) -> Option<Edit> {
        let object = self.metal_object(index)?;
        let tracker_from_object = in_tracker.moved(&object.tracker_from_object);
        Some(Edit::Metal(MetalEdit::SetPose { index, tracker_from_object }))
    }

    /// The edit that moves a body in the tracker frame. The CRF takes the tool along, whose pose
    /// in the CRF stays as it is.
    pub fn moved_body(&self, role: BodyRole, in_tracker: &Movement) -> Option<Edit> {
        let crf = self.crf.as_ref();
        match role {
            BodyRole::Crf => Some(Edit::SetCrfPose(in_tracker.moved(&crf?.tracker_from_crf))),
            BodyRole::Tool => {
                // In the frame that the tool's pose is written in, so that what does not change
                // keeps all its bits.
                let movement = crf.map_or(*in_tracker, |crf| {
                    in_tracker.transformed_by(&crf.tracker_from_crf.inverse())
                });
                Some(Edit::SetToolPose(movement.moved(&self.tool.crf_from_tool)))
            }
        }
    }

    /// The edits that move sensors a step along that axis of their body, either way, which points most
    /// in a direction of the tracker frame.
    pub fn nudged_sensors(
        &self,
        role: BodyRole,
        indices: &[usize],
        in_tracker: &Vector3<f64>,
        step_mm: f64,
    ) -> Vec<Edit> {
        let Some(tracker_from_body) = self.tracker_from_body(role) else { return Vec::new() };
        let in_body = tracker_from_body.rotation.inverse() * in_tracker;
        let axis = in_body.iamax();
        let by_mm = step_mm.copysign(in_body[axis]);
        self.moved_sensors(role, indices, &Movement::along_axis_of(&Pose::identity(), axis, by_mm))
    }

    /// The edits that move sensors in the frame of their body, each turned about its own place.
    pub fn moved_sensors(
        &self,
        role: BodyRole,
        indices: &[usize],
        in_body: &Movement,
    ) -> Vec<Edit> {
        let turn = in_body.rotation();
        let moved = indices.iter().filter_map(|&index| {
            let mut sensor = self.body(role)?.rigid.sensors.get(index)?.clone();
            match in_body {
                Movement::Slide { direction, by_mm } => {
                    sensor.position_in_body += direction.into_inner() * *by_mm;
                }
                Movement::Turn { .. } if turn != UnitQuaternion::identity() => {
                    sensor.orientation = sensor.orientation.rotated_by(&turn);
                }
                Movement::Turn { .. } => {}
            }
            Some(Edit::SetSensor { body: role, index, sensor })
        });
        moved.collect()
    }

    /// The edit that turns a sensor about its own place by the turn of a movement in the tracker
    /// frame.
    pub fn turned_sensor(
        &self,
        role: BodyRole,
        index: usize,
        in_tracker: &Movement,
    ) -> Option<Edit> {
        let in_body = in_tracker.transformed_by(&self.tracker_from_body(role)?.inverse());
        self.moved_sensors(role, &[index], &in_body).pop()
    }

    /// The edit that moves a body's tip in the body's frame; `None` of a body that has none of its own.
    pub fn moved_tip(&self, role: BodyRole, in_body: &Movement) -> Option<Edit> {
        let tip_in_body = self.body(role)?.rigid.tip_in_body?;
        let at = in_body.moved(&Pose::from(tip_in_body)).translation.vector;
        Some(Edit::SetTip { body: role, tip_in_body: Some(at.into()) })
    }

    /// A frame at a body's origin with the axes that a movement follows, `body_from_axes`.
    pub fn body_from_axes(&self, role: BodyRole, axes: HandleAxes) -> Option<Pose> {
        let tracker_from_body = self.tracker_from_body(role)?.rotation;
        Some(match axes {
            HandleAxes::Own => Pose::identity(),
            HandleAxes::Tracker => {
                Pose::from_parts(Translation3::identity(), tracker_from_body.inverse())
            }
        })
    }
}
