//! How far a layout has what has a pose of its own from where it was.

use crate::outcome::Layout;
use trackwright_geometry::pose::Pose;

/// Round-off of a pose that did not move, mm and rad.
const STILL: f64 = 1e-9;

/// How far something was moved and turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseChange {
    pub way_mm: f64,
    pub turn_deg: f64,
}

impl PoseChange {
    /// `None` where nothing moved.
    fn of(before_from_now: &Pose) -> Option<Self> {
        let way_mm = before_from_now.translation.vector.norm();
        let turn_rad = before_from_now.rotation.angle();
        let is_still = way_mm <= STILL && turn_rad <= STILL;
        (!is_still).then(|| Self { way_mm, turn_deg: turn_rad.to_degrees() })
    }
}

impl Layout {
    /// How far the CRF is from where it was on the patient, on which the tool stays.
    pub fn crf_change(&self, start: &Self) -> Option<PoseChange> {
        start.tracker_from_crf?;
        PoseChange::of(&self.now_from_before(start).inverse())
    }

    /// How far the field generator is from where it was in the room.
    pub fn generator_change(&self, start: &Self) -> Option<PoseChange> {
        let now_from_before = self.now_from_before(start);
        match start.tracker_from_crf.zip(self.tracker_from_crf) {
            Some((before, now)) => {
                PoseChange::of(&(now * now_from_before * before.inverse()).inverse())
            }
            None => PoseChange::of(&now_from_before.inverse()),
        }
    }

    /// Of the frame that the tool's pose is given in, the patient standing still.
    fn now_from_before(&self, start: &Self) -> Pose {
        self.crf_from_tool * start.crf_from_tool.inverse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use trackwright_simulation::RigidBody;

    fn layout(tracker_from_crf: Option<Pose>, crf_from_tool: Pose) -> Layout {
        Layout {
            tool: RigidBody { name: "tool".into(), tip_in_body: None, sensors: Vec::new() },
            crf: None,
            tracker_from_crf,
            crf_from_tool,
            objective: 1.0,
            studies: Vec::new(),
            cost: None,
        }
    }

    fn assert_change(found: Option<PoseChange>, way_mm: f64, turn_deg: f64) {
        let found = found.unwrap();
        assert!((found.way_mm - way_mm).abs() < 1e-9, "{found:?}");
        assert!((found.turn_deg - turn_deg).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn crf_and_generator_are_kept_apart() {
        let tracker_from_crf =
            Pose::new(Vector3::new(1.0, 2.0, -300.0), Vector3::new(0.1, 0.2, 0.3));
        let crf_from_tool = Pose::new(Vector3::new(50.0, 0.0, 30.0), Vector3::new(0.0, 0.5, 0.0));
        let start = layout(Some(tracker_from_crf), crf_from_tool);
        assert_eq!((start.crf_change(&start), start.generator_change(&start)), (None, None));
        // The CRF is moved on the patient: tool and field generator stay where they are.
        let turn = 10.0_f64.to_radians();
        let moved = Pose::new(Vector3::new(3.0, 4.0, 0.0), Vector3::z() * turn);
        let crf = layout(Some(tracker_from_crf * moved), moved.inverse() * crf_from_tool);
        assert_change(crf.crf_change(&start), 5.0, 10.0);
        assert_eq!(crf.generator_change(&start), None);
        // And the other way round.
        let generator = layout(Some(moved.inverse() * tracker_from_crf), crf_from_tool);
        assert_change(generator.generator_change(&start), 5.0, 10.0);
        assert_eq!(generator.crf_change(&start), None);
        let without = layout(None, crf_from_tool);
        let found = layout(None, moved.inverse() * crf_from_tool);
        assert_change(found.generator_change(&without), 5.0, 10.0);
        assert_eq!(found.crf_change(&without), None);
    }
}
