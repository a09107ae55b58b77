//! A profile made ready to be drawn: what every frame would have to sort or count is done once.

use super::metric::Metric;
use super::profile::{Histogram, Profile};
use super::requirement::Requirement;

/// Points of the cumulative curve: more than a chart in a panel has pixels.
const CURVE_POINTS: usize = 400;

/// A profile with its histogram, its cumulative curve, and how it keeps to the requirement.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartedProfile {
    pub profile: Profile,
    pub histogram: Histogram,
    /// Tip errors in millimetres, and the part of the trials that has at most so much.
    pub cumulative: Vec<(f64, f64)>,
    pub within: Option<Within>,
    /// The trial with the largest tip error.
    pub worst_trial: Option<usize>,
}

/// How trials keep to the bound that holds for each of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Within {
    /// What the bound is about.
    pub metric: Metric,
    pub limit_mm: f64,
    /// Of the trials, from 0 to 1.
    pub part: f64,
}

impl Within {
    /// Of tip errors in millimetres; `None` where no bound holds for each of them.
    pub fn of(tip_errors_mm: &[f64], requirement: &Requirement) -> Option<Self> {
        let (metric, limit_mm) = requirement.single_position_mm()?;
        let count = tip_errors_mm.iter().filter(|e| **e <= limit_mm).count();
        Some(Self { metric, limit_mm, part: count as f64 / tip_errors_mm.len().max(1) as f64 })
    }
}

impl ChartedProfile {
    pub fn new(profile: Profile, requirement: Option<&Requirement>) -> Self {
        let limit = requirement.and_then(Requirement::single_position_mm);
        Self {
            histogram: profile.histogram(),
            cumulative: profile.cumulative(CURVE_POINTS),
            within: limit.map(|(metric, limit_mm)| Within {
                metric,
                limit_mm,
                part: profile.part_within(limit_mm),
            }),
            worst_trial: profile.worst(),
            profile,
        }
    }

    /// The trial with the largest tip error of a bar of the histogram.
    pub fn worst_of_bar(&self, bar: usize) -> Option<usize> {
        let width = self.histogram.width;
        self.profile.worst_between(bar as f64 * width, (bar + 1) as f64 * width)
    }
}
