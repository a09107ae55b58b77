//! Search over places of a grid: all layouts where they are few enough, exchanges of one place at a
//! time from many starts where not.

use crate::bodies::{Movable, Slot};
use crate::constraint::pair_fault;
use crate::places::PlacedSensor;
use crate::table::{Table, TableBuffers};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use trackwright_simulation::CancelToken;

/// Layouts that are kept of a search.
const KEPT: usize = 256;

/// Starts of a search by exchanges.
const EXCHANGE_STARTS: usize = 24;

/// Rounds of exchanges from one start; they end where one changes nothing.
const MOST_ROUNDS: usize = 12;

/// Layouts that are tried at random for one that is allowed.
const MOST_TRIES: usize = 2_000;

/// A layout of the grid and what it comes to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GridLayout {
    pub value: f64,
    pub chosen: Vec<usize>,
}

/// What a search over a grid comes to.
#[derive(Default)]
pub(crate) struct GridFound {
    /// The best first.
    pub layouts: Vec<GridLayout>,
    pub evaluations: u64,
    /// Whether every layout was judged.
    pub is_exhaustive: bool,
}

/// The grid that is searched.
pub(crate) struct GridSearch<'a> {
    pub table: &'a Table<'a>,
    pub slots: &'a [Slot],
    pub places: &'a [Vec<PlacedSensor>],
    /// For each slot the slot before it that it may change places with, if any.
    pub alike: &'a [Option<usize>],
    /// Of each pair of slots of one body, the places that are too near to each other.
    too_near: Vec<Vec<Option<Near>>>,
    pub enough: &'a CancelToken,
}

/// Which places of one slot are too near to which of another.
struct Near {
    columns: usize,
    is_near: Vec<bool>,
}

impl<'a> GridSearch<'a> {
    pub fn new(
        movable: &Movable,
        table: &'a Table<'a>,
        slots: &'a [Slot],
        places: &'a [Vec<PlacedSensor>],
        alike: &'a [Option<usize>],
        enough: &'a CancelToken,
    ) -> Self {
        let near = |a: usize, b: usize| {
            let of_body =
                movable.places(slots[a].body).filter(|_| slots[a].body == slots[b].body)?;
            let least_gap_mm = of_body.body.mounting.least_gap_mm;
            let rows = places[a].par_iter().flat_map_iter(|one| {
                places[b].iter().map(move |other| {
                    pair_fault(&one.sensor, &other.sensor, least_gap_mm).is_some()
                })
            });
            Some(Near { columns: places[b].len(), is_near: rows.collect() })
        };
        let too_near = (0..slots.len()).map(|a| (0..a).map(|b| near(a, b)).collect()).collect();
        Self { table, slots, places, alike, too_near, enough }
    }

    /// Judges every layout.
    pub fn all(&self) -> GridFound {
        let Some(first) = self.places.first() else {
            return GridFound::default();
        };
        let parts: Vec<GridFound> = (0..first.len())
            .into_par_iter()
            .map_init(TableBuffers::default, |buffers, first| {
                let mut found = GridFound { is_exhaustive: true, ..GridFound::default() };
                let mut chosen = vec![first];
                self.extend(buffers, &mut chosen, &mut found);
                found.keep();
                found
            })
            .collect();
        let mut all = GridFound { is_exhaustive: true, ..GridFound::default() };
        for part in parts {
            all.evaluations += part.evaluations;
            all.is_exhaustive &= part.is_exhaustive;
            all.layouts.extend(part.layouts);
        }
        all.keep();
        all
    }

    fn extend(&self, buffers: &mut TableBuffers, chosen: &mut Vec<usize>, found: &mut GridFound) {
        if self.enough.is_cancelled() {
            found.is_exhaustive = false;
            return;
        }
        let slot = chosen.len();
        if slot == self.slots.len() {
            found.evaluations += 1;
            if let Some(value) = self.table.judge(buffers, self.places, chosen) {
                found.layouts.push(GridLayout { value, chosen: chosen.clone() });
                if found.layouts.len() >= 4 * KEPT {
                    found.keep();
                }
            }
            return;
        }
        let from = self.alike[slot].map_or(0, |other| chosen[other] + 1);
        for place in from..self.places[slot].len() {
            if self.is_near_any(chosen, slot, place, None) {
                continue;
            }
            chosen.push(place);
            self.extend(buffers, chosen, found);
            chosen.pop();
        }
    }

    /// Changes one place at a time for the best of all others, from random starts, until none is
    /// better.
    pub fn by_exchanges(&self, seed: u64, most_evaluations: u64) -> GridFound {
        let each = most_evaluations / EXCHANGE_STARTS as u64;
        let parts: Vec<GridFound> = (0..EXCHANGE_STARTS)
            .into_par_iter()
            .map_init(TableBuffers::default, |buffers, start| {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                rng.set_stream(start as u64);
                let mut found = GridFound::default();
                let Some(mut best) = self.random(buffers, &mut rng, &mut found) else {
                    return found;
                };
                for _ in 0..MOST_ROUNDS {
                    let before = best.value;
                    for slot in 0..self.slots.len() {
                        self.exchange(buffers, &mut best, slot, &mut found);
                        if found.evaluations >= each || self.enough.is_cancelled() {
                            break;
                        }
                    }
                    if best.value >= before || found.evaluations >= each {
                        break;
                    }
                }
                found.layouts.push(best);
                found
            })
            .collect();
        let mut all = GridFound::default();
        for part in parts {
            all.evaluations += part.evaluations;
            all.layouts.extend(part.layouts);
        }
        all.keep();
        all
    }

    /// The layout with another place of one slot, where one is better.
    fn exchange(
        &self,
        buffers: &mut TableBuffers,
        best: &mut GridLayout,
        slot: usize,
        found: &mut GridFound,
    ) {
        let mut chosen = best.chosen.clone();
        for place in 0..self.places[slot].len() {
            if self.enough.is_cancelled() {
                return;
            }
            if place == best.chosen[slot] || self.is_near_any(&best.chosen, slot, place, Some(slot))
            {
                continue;
            }
            chosen[slot] = place;
            found.evaluations += 1;
            if let Some(value) = self.table.judge(buffers, self.places, &chosen)
                && value < best.value
            {
                *best = GridLayout { value, chosen: chosen.clone() };
            }
        }
    }

    fn random(
        &self,
        buffers: &mut TableBuffers,
        rng: &mut ChaCha8Rng,
        found: &mut GridFound,
    ) -> Option<GridLayout> {
        for _ in 0..MOST_TRIES {
            let mut chosen = Vec::with_capacity(self.slots.len());
            for slot in 0..self.slots.len() {
                let count = self.places[slot].len() as u64;
                let place = (rng.next_u64() % count.max(1)) as usize;
                if count == 0 || self.is_near_any(&chosen, slot, place, None) {
                    break;
                }
                chosen.push(place);
            }
            if chosen.len() < self.slots.len() {
                continue;
            }
            found.evaluations += 1;
            if let Some(value) = self.table.judge(buffers, self.places, &chosen) {
                return Some(GridLayout { value, chosen });
            }
            if self.enough.is_cancelled() {
                return None;
            }
        }
        None
    }

    /// Whether a place of a slot is too near to the places of the other slots.
    fn is_near_any(&self, chosen: &[usize], slot: usize, place: usize, but: Option<usize>) -> bool {
        chosen.iter().enumerate().any(|(other, at)| {
            if Some(other) == but || other == slot {
                return false;
            }
            let (a, b) = if slot > other {
                ((slot, place), (other, *at))
            } else {
                ((other, *at), (slot, place))
            };
            let near = self.too_near[a.0][b.0].as_ref();
            near.is_some_and(|near| near.is_near[a.1 * near.columns + b.1])
        })
    }
}

impl GridFound {
    /// Keeps the best, in an order that does not depend on how they were found.
    fn keep(&mut self) {
        self.layouts
            .sort_by(|a, b| a.value.total_cmp(&b.value).then_with(|| a.chosen.cmp(&b.chosen)));
        self.layouts.truncate(KEPT);
    }
}

/// How many layouts slots have with so many places each, near ones included.
pub(crate) fn layouts(places: &[usize], alike: &[Option<usize>]) -> f64 {
    let mut all = 1.0;
    for (slot, places) in places.iter().enumerate() {
        // The k-th of those that are alike has one place fewer, and k orders are one layout.
        let (mut order, mut other) = (0.0, alike[slot]);
        while let Some(before) = other {
            order += 1.0;
            other = alike[before];
        }
        all *= (*places as f64 - order).max(0.0) / (order + 1.0);
    }
    all
}
