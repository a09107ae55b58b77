//! What is known of a sensor's places, and what follows from it for the others.

use super::outcome::{
    Basis, Candidates, E_FOLD_MM, Found, NOWHERE, Placement, PlacementOutcome, Study, difference_mm,
};
use crate::work::Work;
use rayon::prelude::*;
use trackwright_geometry::spread::{Position, shares};

/// What is known of the places so far.
pub(super) struct Known<'a> {
    pub candidates: &'a Candidates,
    pub study: &'a Study,
    /// At all poses of the study, or at many.
    pub many: Vec<Option<Found>>,
    pub few: Vec<Option<Found>>,
    /// Whether the sensor is known to leave the model's box.
    pub leaves: Vec<bool>,
    pub work: Work,
}

/// Values at some places, and what each would be off by, relative to it, were it made of the
/// others.
struct Samples {
    places: Vec<Position>,
    values: Vec<f64>,
    off: Vec<f64>,
}

#[derive(Default)]
struct Near {
    near: Vec<(f64, usize)>,
    shares: Vec<(f64, usize)>,
}

impl Samples {
    fn new(places: Vec<Position>, values: Vec<f64>) -> Self {
        let mut samples = Self { places, values, off: Vec::new() };
        samples.off = (0..samples.values.len())
            .into_par_iter()
            .map_init(Near::default, |near, i| {
                let value = samples.values[i];
                match samples.mix(&samples.places[i], Some(i), near) {
                    Some((mixed, _)) if value > 0.0 => (mixed - value).abs() / value,
                    _ => 0.0,
                }
            })
            .collect();
        samples
    }

    /// The value at a place, and the largest of what its neighbours would be off by.
    fn mix(&self, at: &Position, without: Option<usize>, near: &mut Near) -> Option<(f64, f64)> {
        shares(at, &self.places, without, &mut near.near, &mut near.shares);
        let shares = near.shares.iter();
        let value = shares.clone().map(|&(share, i)| share * self.values[i]).sum();
        let off = shares.map(|&(_, i)| self.off.get(i).copied().unwrap_or(0.0));
        (!near.shares.is_empty()).then(|| (value, off.fold(0.0, f64::max)))
    }

    /// How far the neighbours that a value was mixed from are from it, relative to it.
    fn spread(&self, mixed: f64, near: &Near) -> f64 {
        let shares = near.shares.iter();
        let away = shares.map(|&(_, i)| (self.values[i] - mixed).abs());
        away.fold(0.0, f64::max) / mixed
    }
}

impl Known<'_> {
    /// What distinguishes places: where they are, and once that is known of all of them how much
    /// trials vary there.
    pub fn features(&self) -> Vec<Position> {
        let all = self.candidates.places.iter().zip(&self.few);
        let is_finite = |place: &Position| place.iter().all(|v| v.is_finite());
        let are_known = all.clone().all(|(place, few)| few.is_some() || !is_finite(place));
        all.map(|(place, few)| {
            let mut place = *place;
            if let Some(found) =
                few.filter(|f| are_known && f.variation > 0.0 && f.variation.is_finite())
            {
                place[6] = E_FOLD_MM * found.variation.ln();
            }
            place
        })
        .collect()
    }

    pub fn outcome(&self, is_final: bool) -> PlacementOutcome {
        let value = |found: &Option<Found>| found.and_then(|f| f.tip_rms_mm);
        let features = self.features();
        let all = features.iter().enumerate();
        // How far few poses are from all of them.
        let (places, values) = all
            .clone()
            .filter_map(|(i, place)| {
                let (many, few) = (value(&self.many[i])?, value(&self.few[i])?);
                (few > 0.0).then(|| (*place, many / few))
            })
            .unzip();
        let ratios = Samples::new(places, values);
        let (places, values) =
            all.filter_map(|(i, place)| Some((*place, value(&self.few[i])?))).unzip();
        // Needed only while some places have no value of their own.
        let partly = match self.few.iter().any(Option::is_none) {
            true => Samples::new(places, values),
            false => Samples::new(Vec::new(), Vec::new()),
        };
        let of_place: Vec<Placement> = (0..self.candidates.places.len())
            .into_par_iter()
            .map_init(Near::default, |near, i| {
                self.placement(i, &features[i], [&ratios, &partly], near)
            })
            .collect();
        let trials = self.study.trials;
        self.candidates.outcome(&of_place, trials, is_final, self.work)
    }

    fn placement(
        &self,
        i: usize,
        place: &Position,
        [ratios, partly]: [&Samples; 2],
        near: &mut Near,
    ) -> Placement {
        if !self.candidates.is_finite(i) {
            return NOWHERE;
        }
        if let Some(found) = self.many[i] {
            let basis = match (self.study.is_whole, self.few[i]) {
                (true, _) => Basis::Full,
                (false, few) => Basis::Approximate {
                    error_mm: few.map_or(f64::INFINITY, |few| difference_mm(&found, &few)),
                },
            };
            return Placement {
                tip_rms_mm: found.tip_rms_mm,
                basis,
                expected: None,
                is_outside: found.is_outside || self.leaves[i],
            };
        }
        let few = match self.few[i] {
            Some(found) => found.tip_rms_mm.map(|value| (value, 0.0)),
            None => partly.mix(place, None, near),
        };
        let (ratio, ratio_off) = ratios
            .mix(place, None, near)
            .map(|(ratio, off)| (ratio, off.max(ratios.spread(ratio, near))))
            .unwrap_or((1.0, f64::INFINITY));
        let tip_rms_mm = few.map(|(value, _)| value * ratio);
        let off = few.map_or(0.0, |(_, off)| off) + ratio_off;
        Placement {
            tip_rms_mm,
            basis: Basis::Approximate {
                error_mm: tip_rms_mm.map_or(f64::INFINITY, |value| match value > 0.0 {
                    true => value * off,
                    false => 0.0,
                }),
            },
            expected: None,
            is_outside: self.leaves[i] || self.few[i].is_some_and(|f| f.is_outside),
        }
    }
}
