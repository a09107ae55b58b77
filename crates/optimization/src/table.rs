//! Readings of every sensor at every place and pose, made once: a layout of these places costs its
//! frame fits alone.

use crate::bodies::{Bodies, Slot};
use crate::judge::{Few, Judge, over_rooms, rejects};
use crate::places::PlacedSensor;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::frame_fit::{FrameFitter, Reading};
use trackwright_simulation::tool_in_crf::relative_error;
use trackwright_simulation::tracker::{BodyTracker, TrackBuffers};
use trackwright_simulation::{PlacedBody, RigidBody, Scenario, Sensor, StudyError};

/// Readings of all candidates of a problem in all rooms.
pub(crate) struct Table<'a> {
    judge: &'a Judge<'a>,
    base: &'a Bodies,
    slots: &'a [Slot],
    rooms: Vec<RoomTable<'a>>,
}

/// Those of one room.
struct RoomTable<'a> {
    room: usize,
    scenario: &'a Scenario,
    few: Few,
    tracker_from_crf: Vec<Pose>,
    /// Of each trial, which of those poses the CRF is at.
    crf_at: Vec<usize>,
    tracker_from_tool: Vec<Pose>,
    tool: BodyTable,
    crf: Option<BodyTable>,
    /// Trials of the start with a sensor outside the model's box.
    most_outside: usize,
}

/// The readings of one body's sensors.
struct BodyTable {
    poses: usize,
    /// Of the sensors as they are, sensor by sensor, then of each slot's places.
    readings: Vec<(Reading, bool)>,
    /// Where each slot of this body begins among the rows; `None` of another body's.
    first_row: Vec<Option<usize>>,
}

/// What a layout is judged in.
#[derive(Default)]
pub(crate) struct TableBuffers {
    readings: Vec<Reading>,
    crf_poses: Vec<(Pose, bool)>,
    errors: Vec<[f64; 2]>,
}

impl<'a> Table<'a> {
    /// Reads every place of every slot.
    ///
    /// # Errors
    /// See [`Judge::few`].
    pub fn new(
        judge: &'a Judge<'a>,
        base: &'a Bodies,
        slots: &'a [Slot],
        places: &[Vec<PlacedSensor>],
    ) -> Result<Self, StudyError> {
        let rooms = judge.problem.scenarios.iter();
        let rooms = rooms.enumerate().map(|(room, scenario)| {
            let most_outside = judge.most_outside(room);
            RoomTable::new(judge, (room, scenario), base, (slots, places), most_outside)
        });
        Ok(Self { judge, base, slots, rooms: rooms.collect::<Result<_, _>>()? })
    }

    /// What a layout comes to with each slot at one of its places; `None` where it leaves open what
    /// the start does not, or leaves the field.
    pub fn judge(
        &self,
        buffers: &mut TableBuffers,
        places: &[Vec<PlacedSensor>],
        chosen: &[usize],
    ) -> Option<f64> {
        let mut bodies = self.base.clone();
        for (slot, (places, chosen)) in self.slots.iter().zip(places.iter().zip(chosen)) {
            let sensor = &places[*chosen].sensor;
            let own = &mut bodies.body_mut(slot.body)?.sensors[slot.index];
            own.position_in_body = sensor.position_in_body;
            own.orientation = sensor.orientation;
        }
        if self.judge.determination_fault(&bodies).is_some() {
            return None;
        }
        let mut values = Vec::with_capacity(self.rooms.len());
        for room in &self.rooms {
            values.push(room.judge(self.judge, buffers, self.slots, &bodies, chosen)?);
        }
        over_rooms(self.judge.problem.rooms, &values)
    }
}

impl<'a> RoomTable<'a> {
    fn new(
        judge: &Judge,
        (room, scenario): (usize, &'a Scenario),
        base: &Bodies,
        (slots, places): (&[Slot], &[Vec<PlacedSensor>]),
        most_outside: usize,
    ) -> Result<Self, StudyError> {
        let at = base.in_room(scenario);
        let few = judge.few(&at)?;
        let own = at.tracker_from_crf();
        let mut tracker_from_crf: Vec<Pose> = Vec::new();
        let mut crf_at = Vec::with_capacity(few.trials.len());
        for trial in &few.trials {
            let pose = trial.tracker_from_crf.filter(|_| at.crf.is_some()).unwrap_or(own);
            if tracker_from_crf.last() != Some(&pose) {
                tracker_from_crf.push(pose);
            }
            crf_at.push(tracker_from_crf.len() - 1);
        }
        let tracker_from_tool: Vec<Pose> = few
            .trials
            .iter()
            .zip(&crf_at)
            .map(|(trial, crf)| tracker_from_crf[*crf] * trial.crf_from_tool)
            .collect();
        let of_body = |body: PlacedBody, rigid: &RigidBody, poses: &[Pose], run: usize| {
            BodyTable::new(scenario, (body, rigid), slots, places, (poses, run))
        };
        let tool = of_body(PlacedBody::Tool, &base.tool, &tracker_from_tool, few.run);
        let crf =
            base.crf.as_ref().map(|rigid| of_body(PlacedBody::Crf, rigid, &tracker_from_crf, 1));
        Ok(Self {
            room,
            scenario,
            few,
            tracker_from_crf,
            crf_at,
            tracker_from_tool,
            tool,
            crf,
            most_outside,
        })
    }

    fn judge(
        &self,
        judge: &Judge,
        buffers: &mut TableBuffers,
        slots: &[Slot],
        bodies: &Bodies,
        chosen: &[usize],
    ) -> Option<f64> {
        let weight_mm = self.scenario.orientation_weight_mm;
        let TableBuffers { readings, crf_poses, errors } = buffers;
        crf_poses.clear();
        match (&self.crf, &bodies.crf) {
            (Some(table), Some(body)) => {
                let fitter = FrameFitter::new(body, weight_mm);
                let rows = table.rows(PlacedBody::Crf, body.sensors.len(), slots, chosen);
                for (pose, truth) in self.tracker_from_crf.iter().enumerate() {
                    let is_inside = table.gather(readings, &rows, pose);
                    crf_poses.push((fitter.fit(readings, truth).tracker_from_body, is_inside));
                }
            }
            _ => crf_poses.resize(self.tracker_from_crf.len(), (Pose::identity(), true)),
        }
        let scatter = judge.scatter(self.scenario, bodies, self.room);
        let fitter = FrameFitter::new(&bodies.tool, weight_mm);
        let rows = self.tool.rows(PlacedBody::Tool, bodies.tool.sensors.len(), slots, chosen);
        let tip = bodies.tool.judged_tip_in_body();
        let (mut outside, rejects) = (0, rejects(self.scenario));
        errors.clear();
        for (number, trial) in self.few.trials.iter().enumerate() {
            let is_inside = self.tool.gather(readings, &rows, number);
            let (tracker_from_crf, crf_is_inside) = crf_poses[self.crf_at[number]];
            if !(is_inside && crf_is_inside) {
                outside += 1;
                if outside > self.most_outside {
                    return None;
                }
                if rejects {
                    // Its weight must not count; a figure over fewer trials is none to compare.
                    errors.push([0.0; 2]);
                    continue;
                }
            }
            let fit = fitter.fit(readings, &self.tracker_from_tool[number]);
            let simulated = tracker_from_crf.inverse() * fit.tracker_from_body;
            let error = relative_error(&trial.crf_from_tool, &simulated, &tip);
            let own = [error.tip_error_in_crf_mm.norm(), error.angle_rad.to_degrees()];
            errors.push(match &scatter {
                None => own,
                Some(scatter) => {
                    scatter.added_to(own, &trial.crf_from_tool, trial.tracker_from_crf)
                }
            });
        }
        Some(judge.of_few(errors, &self.few))
    }
}

impl BodyTable {
    fn new(
        scenario: &Scenario,
        (body, rigid): (PlacedBody, &RigidBody),
        slots: &[Slot],
        places: &[Vec<PlacedSensor>],
        (poses, run): (&[Pose], usize),
    ) -> Self {
        let mut sensors: Vec<Sensor> = rigid.sensors.clone();
        let mut first_row = Vec::with_capacity(slots.len());
        for (slot, places) in slots.iter().zip(places) {
            first_row.push((slot.body == body).then_some(sensors.len()));
            if slot.body == body {
                sensors.extend(places.iter().map(|place| place.sensor.clone()));
            }
        }
        let fitter = FrameFitter::new(rigid, scenario.orientation_weight_mm);
        let tracker =
            BodyTracker::of_sensors(fitter, &sensors, &scenario.environment, scenario.outside);
        let mut readings = Vec::with_capacity(sensors.len() * poses.len());
        let mut buffers = TrackBuffers::default();
        tracker.read_all(&mut buffers, poses, run.min(poses.len()).max(1), &mut readings);
        Self { poses: poses.len(), readings, first_row }
    }

    fn at(&self, row: usize, pose: usize) -> &(Reading, bool) {
        &self.readings[row * self.poses + pose]
    }

    /// The row of each sensor of a body: its own, or that of its slot's place.
    fn rows(
        &self,
        body: PlacedBody,
        sensors: usize,
        slots: &[Slot],
        chosen: &[usize],
    ) -> Vec<usize> {
        let mut rows: Vec<usize> = (0..sensors).collect();
        for ((slot, chosen), first) in slots.iter().zip(chosen).zip(&self.first_row) {
            if let Some(first) = first
                && slot.body == body
            {
                rows[slot.index] = first + chosen;
            }
        }
        rows
    }

    /// What the sensors of these rows read at a pose, and whether all are in the model's box.
    fn gather(&self, readings: &mut Vec<Reading>, rows: &[usize], pose: usize) -> bool {
        readings.clear();
        let mut is_inside = true;
        for row in rows {
            let (reading, inside) = self.at(*row, pose);
            readings.push(*reading);
            is_inside &= inside;
        }
        is_inside
    }
}
