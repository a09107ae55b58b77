//! Which sensors a layout has: how many, and of which kinds.

use crate::bodies::{Bodies, Slot};
use crate::outcome::{MAX_MOVING, OptimizeError, body_key};
use crate::problem::{Problem, SensorChoice};
use trackwright_simulation::{PlacedBody, Sensor, SensorOrientation};

/// Bodies with a number of sensors of certain kinds, and which of them move.
pub(crate) struct Choice {
    pub bodies: Bodies,
    pub slots: Vec<Slot>,
    /// Of all sensors that move, where kinds were given.
    pub cost: Option<f64>,
    /// Whether these are the design's own sensors.
    pub is_own: bool,
}

/// Every number and every set of kinds that is requested, fewest sensors first.
///
/// # Errors
/// Sensors that are not there, numbers that do not go with those that do not move, and a problem in
/// which nothing moves.
pub(crate) fn choices(problem: &Problem) -> Result<Vec<Choice>, OptimizeError> {
    let scenario = problem.scenarios.first().ok_or(OptimizeError::NoRoom)?;
    let own = Bodies::of(scenario);
    let moves = &problem.moves;
    if !moves.crf.is_empty() && own.crf.is_none() {
        return Err(OptimizeError::NoCrf);
    }
    let mut slots = Vec::new();
    for (body, numbers) in [(PlacedBody::Tool, &moves.tool), (PlacedBody::Crf, &moves.crf)] {
        let sensors = own.body(body).map_or(0, |body| body.sensors.len());
        let mut numbers = numbers.clone();
        numbers.sort_unstable();
        numbers.dedup();
        for index in numbers {
            if index >= sensors {
                return Err(OptimizeError::NoSensor {
                    body: body_key(body),
                    sensor: index,
                    sensors,
                });
            }
            slots.push(Slot { body, index });
        }
    }
    let counts = moves.sensors.as_ref().map_or(0, |counts| *counts.end());
    let found = slots.len().max(counts);
    if found > MAX_MOVING {
        return Err(OptimizeError::TooManyMove { found });
    }
    let poses_move = moves.generator.is_some() || (moves.crf_pose.is_some() && own.crf.is_some());
    if slots.is_empty() && !poses_move {
        return Err(OptimizeError::NothingMoves);
    }
    // Added and taken away is on the tool, or on the CRF where nothing of the tool's moves.
    let counted = slots.first().map(|slot| slot.body);
    let (Some(counted), true) = (counted, moves.sensors.is_some() || !moves.kinds.is_empty())
    else {
        return Ok(vec![Choice { bodies: own, slots, cost: None, is_own: true }]);
    };
    let have = own.body(counted).map_or(0, |body| body.sensors.len());
    let movable = slots.iter().filter(|slot| slot.body == counted).count();
    let fixed = have - movable;
    let counts = moves.sensors.clone().unwrap_or(have..=have);
    if *counts.start() < (fixed + 1) || counts.is_empty() {
        let (least, most) = (*counts.start(), *counts.end());
        return Err(OptimizeError::Count { body: body_key(counted), least, most, fixed });
    }
    let mut out = Vec::new();
    for count in counts {
        let kinds = kind_sets(&moves.kinds, count - fixed);
        for kinds in kinds {
            out.push(with_sensors(&own, &slots, counted, count - fixed, &kinds));
        }
    }
    Ok(out)
}

/// Every set of so many kinds; one empty set where no kinds are given.
fn kind_sets(kinds: &[SensorChoice], count: usize) -> Vec<Vec<SensorChoice>> {
    if kinds.is_empty() {
        return vec![Vec::new()];
    }
    let mut sets: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..count {
        let longer = sets.iter().flat_map(|set| {
            let from = set.last().copied().unwrap_or(0);
            (from..kinds.len()).map(move |kind| set.iter().copied().chain([kind]).collect())
        });
        sets = longer.collect();
    }
    sets.into_iter().map(|set| set.into_iter().map(|kind| kinds[kind]).collect()).collect()
}

/// The bodies with so many moved sensors on one of them.
fn with_sensors(
    own: &Bodies,
    slots: &[Slot],
    counted: PlacedBody,
    count: usize,
    kinds: &[SensorChoice],
) -> Choice {
    let mut bodies = own.clone();
    let numbers: Vec<usize> =
        slots.iter().filter(|slot| slot.body == counted).map(|slot| slot.index).collect();
    let mut moved = Vec::new();
    if let Some(body) = bodies.body_mut(counted) {
        // Those that stay keep their numbers: the first that move are kept, the rest is removed.
        let removed = &numbers[count.min(numbers.len())..];
        let first = body.sensors[numbers[0]].clone();
        let mut kept = 0;
        let mut index = 0;
        body.sensors.retain(|_| {
            let is_kept = !removed.contains(&index);
            if is_kept && numbers.contains(&index) {
                moved.push(kept);
            }
            kept += usize::from(is_kept);
            index += 1;
            is_kept
        });
        while moved.len() < count {
            let name = free_name(&first.name, &body.sensors);
            moved.push(body.sensors.len());
            body.sensors.push(Sensor { name, ..first.clone() });
        }
        for (number, kind) in moved.iter().zip(kinds) {
            let sensor = &mut body.sensors[*number];
            *sensor = of_kind(sensor, kind);
        }
    }
    let others = slots.iter().filter(|slot| slot.body != counted).copied();
    let slots = moved.into_iter().map(|index| Slot { body: counted, index }).chain(others);
    let is_own = bodies == *own;
    let cost = (!kinds.is_empty()).then(|| kinds.iter().map(|kind| kind.cost).sum());
    Choice { bodies, slots: slots.collect(), cost, is_own }
}

fn of_kind(sensor: &Sensor, kind: &SensorChoice) -> Sensor {
    let orientation = match (kind.degrees_of_freedom, sensor.orientation) {
        (5, own) => own.axis().map_or(own, SensorOrientation::FiveDof),
        (_, SensorOrientation::FiveDof(_)) => {
            SensorOrientation::SixDof(sensor.orientation.any_rotation())
        }
        (_, own) => own,
    };
    Sensor { orientation, coil: kind.coil.or(sensor.coil), ..sensor.clone() }
}

/// A name that no sensor has: the first one's with the next number.
fn free_name(first: &str, sensors: &[Sensor]) -> String {
    let stem = first.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end();
    let stem = if stem.is_empty() { "sensor" } else { stem };
    let names = (2..).map(|number| format!("{stem} {number}"));
    let mut free = names.filter(|name| sensors.iter().all(|sensor| sensor.name != *name));
    free.next().unwrap_or_default()
}
