//! Grids of places for all sensors that move: as fine as all layouts of them can be judged.

use crate::bodies::{Movable, Slot};
use crate::constraint::{Constraint, pair_fault};
use crate::grid_search::layouts;
use crate::outcome::{OptimizeError, body_key};
use crate::places::{Grid, PlacedSensor};
use trackwright_simulation::Sensor;

/// Fewest places with which all layouts of a grid are judged; below, the grid shows too little.
const FEWEST_PLACES: usize = 14;

/// Most places of one sensor.
const MOST_PLACES: usize = 400;

/// Places of one sensor where layouts are too many to judge all.
const EXCHANGED_PLACES: usize = 96;

/// Of what moves, the grids.
pub(crate) struct SlotGrids<'b, 'a> {
    pub movable: &'b Movable<'a>,
}

impl SlotGrids<'_, '_> {
    /// Allowed places of all slots, as many as so many layouts of them allow; where these are too few
    /// to judge all, more.
    ///
    /// # Errors
    /// A slot without a place.
    pub fn places(&self, affordable: f64) -> Result<Vec<Vec<PlacedSensor>>, OptimizeError> {
        let slots = &self.movable.slots;
        let alike = self.alike();
        let of_count = |count: usize| layouts(&vec![count; slots.len()], &alike);
        let count = (2..=MOST_PLACES).take_while(|count| of_count(*count) <= affordable).last();
        let count = match count {
            Some(count) if count >= FEWEST_PLACES => count,
            _ => EXCHANGED_PLACES,
        };
        let mut grids: Vec<Grid> = Vec::with_capacity(slots.len());
        for (number, slot) in slots.iter().enumerate() {
            // Those that are alike share one grid.
            if let Some(other) = alike[number] {
                grids.push(grids[other].clone());
                continue;
            }
            let body = self.movable.base.body(slot.body);
            let (Some(body), Some(places)) = (body, self.movable.places(slot.body)) else {
                return Err(OptimizeError::NoCrf);
            };
            let sensor = &body.sensors[slot.index];
            let mounted = places.body;
            if mounted.mounting.regions.is_empty() && mounted.surface.is_none() {
                return Err(OptimizeError::NoRegion { body: body_key(slot.body) });
            }
            let mut grid = places.grid(sensor, count);
            let gap_mm = places.body.mounting.least_gap_mm;
            let others = self.still(*slot);
            let mut faults: Vec<Constraint> = Vec::new();
            grid.places.retain(|place| {
                let fault =
                    others.iter().find_map(|other| pair_fault(&place.sensor, other, gap_mm));
                let is_allowed = fault.is_none();
                faults.extend(fault);
                is_allowed
            });
            if grid.places.is_empty() {
                return Err(OptimizeError::NoPlace {
                    body: body_key(slot.body),
                    sensor: sensor.name.clone(),
                    tried: grid.tried,
                    most_common: faults.into_iter().next().or(grid.most_common),
                });
            }
            grids.push(grid);
        }
        Ok(grids.into_iter().map(|grid| grid.places).collect())
    }

    /// The sensors of a slot's body that do not move.
    fn still(&self, slot: Slot) -> Vec<&Sensor> {
        let sensors = self.movable.base.body(slot.body).map_or(&[][..], |body| &body.sensors);
        let is_still =
            |index: usize| !self.movable.slots.contains(&Slot { body: slot.body, index });
        sensors.iter().enumerate().filter(|own| is_still(own.0)).map(|own| own.1).collect()
    }

    /// No allowed place of a slot is farther from one of its places than this.
    pub fn spacing_mm(&self, places: &[Vec<PlacedSensor>]) -> Option<f64> {
        let mut most_mm = 0.0_f64;
        let alike = self.alike();
        for (number, slot) in self.movable.slots.iter().enumerate() {
            if alike[number].is_none() {
                let sensor = &self.movable.base.body(slot.body)?.sensors[slot.index];
                let of_body = self.movable.places(slot.body)?;
                let own = of_body.spacing_mm(sensor, &self.still(*slot), &places[number])?;
                most_mm = most_mm.max(own);
            }
        }
        Some(most_mm)
    }

    /// For each slot the one before it that is as good in any place.
    pub fn alike(&self) -> Vec<Option<usize>> {
        let slots = &self.movable.slots;
        let sensor =
            |slot: &Slot| self.movable.base.body(slot.body).map(|body| &body.sensors[slot.index]);
        let each = slots.iter().enumerate().map(|(number, slot)| {
            let own = sensor(slot)?;
            (0..number).rev().find(|&other| {
                slots[other].body == slot.body
                    && sensor(&slots[other]).is_some_and(|other| {
                        other.coil == own.coil && other.orientation == own.orientation
                    })
            })
        });
        each.collect()
    }
}
