//! Which marker or coil of a definition each sensor of a body is, after the body was edited.

use nalgebra::Point3;
use trackwright_simulation::body::Sensor;

/// For each sensor the slot that is its own: the one at its very place, else the one that bore its
/// name, else, where none was added or removed, the one at its index. No slot is two sensors'.
///
/// `slots` are the sensors as the definition gives them; `is_same_place` compares as exactly as
/// the definition can distinguish places.
pub(super) fn slots_of(
    sensors: &[Sensor],
    slots: &[Sensor],
    is_same_place: impl Fn(&Point3<f64>, &Point3<f64>) -> bool,
) -> Vec<Option<usize>> {
    let mut found = vec![None; sensors.len()];
    let mut is_taken = vec![false; slots.len()];
    let mut pass = |is_own: &dyn Fn(usize, usize) -> bool| {
        for (sensor, found) in found.iter_mut().enumerate() {
            if found.is_none() {
                *found = (0..slots.len()).find(|slot| !is_taken[*slot] && is_own(sensor, *slot));
                if let Some(slot) = *found {
                    is_taken[slot] = true;
                }
            }
        }
    };
    let is_there = |sensor: usize, slot: usize| {
        is_same_place(&sensors[sensor].position_in_body, &slots[slot].position_in_body)
    };
    let is_named = |sensor: usize, slot: usize| sensors[sensor].name == slots[slot].name;
    // Two may be in one place.
    pass(&|sensor, slot| is_there(sensor, slot) && is_named(sensor, slot));
    pass(&|sensor, slot| is_there(sensor, slot) && sensor == slot);
    pass(&is_there);
    pass(&is_named);
    if sensors.len() == slots.len() {
        pass(&|sensor, slot| sensor == slot);
    }
    found
}

/// The slot that is nearest to a place, whose ways a new marker there takes on.
pub(super) fn nearest_slot(place: &Point3<f64>, slots: &[Sensor]) -> Option<usize> {
    let distance = |slot: &Sensor| (slot.position_in_body - place).norm_squared();
    (0..slots.len()).min_by(|a, b| distance(&slots[*a]).total_cmp(&distance(&slots[*b])))
}

#[cfg(test)]
mod tests {
    use super::super::geometry::marker;
    use super::*;

    #[test]
    fn sensors_match_by_position_name_then_index() {
        let slots: Vec<_> = [0.0, 1.0, 2.0, 2.0]
            .into_iter()
            .enumerate()
            .map(|(i, x)| marker(i, Point3::new(x, 0.0, 0.0)))
            .collect();
        let own = |sensors: &[Sensor]| slots_of(sensors, &slots, |a, b| a == b);
        assert_eq!(own(&slots), [Some(0), Some(1), Some(2), Some(3)]);
        // Marker 2 is gone, 1 has moved, 4 is called otherwise, and two are new.
        let mut sensors = vec![slots[3].clone(), slots[2].clone(), slots[0].clone()];
        sensors[0].name = "knob".to_owned();
        sensors[2].position_in_body.y = 7.0;
        let mut new = slots[1].clone();
        new.name = "new".to_owned();
        new.position_in_body.x = 1.1;
        sensors.push(new);
        // Two slots are where the knob is; the one of them is marker 3 by its name.
        assert_eq!(own(&sensors), [Some(3), Some(2), Some(0), None]);
        sensors.swap(1, 3);
        assert_eq!(own(&sensors), [Some(3), Some(1), Some(0), Some(2)]);
        assert_eq!(nearest_slot(&Point3::new(1.4, 0.0, 0.0), &slots), Some(1));
    }
}
