//! What a slice may show of the room besides the position error: how far its model may be believed.

use super::run::StudyError;
use super::slice::{SliceOutcome, SlicePlan, sample_slice};
use super::statistics::Statistics;
use super::work::Work;
use crate::field::{Environment, OutsidePolicy};
use crate::task::CancelToken;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A quantity in millimetres at each point of a slice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Quantity {
    /// Length of the position error (6).
    #[default]
    PositionErrorMm,
    /// Predicted standard error of the field's position; NaN where it is not determined.
    StdErrorMm,
    /// Distance to the nearest sample; NaN where an orientation has none.
    SupportDistanceMm,
}

impl Quantity {
    pub const ALL: [Self; 3] = [
        Self::PositionErrorMm,
        Self::StdErrorMm,
        Self::SupportDistanceMm,
    ];

    /// For a legend.
    pub fn label(self) -> &'static str {
        match self {
            Self::PositionErrorMm => "position error",
            Self::StdErrorMm => "standard error of the field",
            Self::SupportDistanceMm => "distance to the nearest sample",
        }
    }
}

/// A quantity at each point of the plan, in the outcome's `position_error_mm` whatever it is; `None`
/// where the environment does not say where its model may be believed. Points without a finite
/// value count as outside the box, so that they are drawn as what has no value.
///
/// # Errors
/// [`StudyError::Cancelled`].
pub fn sample_slice_of(
    quantity: Quantity,
    environment: &Environment,
    plan: &SlicePlan,
    cancel: &CancelToken,
) -> Result<Option<SliceOutcome>, StudyError> {
    if quantity == Quantity::PositionErrorMm {
        return sample_slice(environment, plan, cancel).map(Some);
    }
    let Some(support) = &environment.support else {
        return Ok(None);
    };
    let model = &environment.model;
    let [nu, nv] = plan.counts;
    let rows: Option<Vec<Vec<(f64, bool)>>> = (0..nv)
        .into_par_iter()
        .map(|v| {
            let value = |u| {
                let point = plan.point_mm(u, v);
                let at = support.at(&point, &plan.sensor_axis, OutsidePolicy::Clamp);
                let value = match quantity {
                    Quantity::StdErrorMm => at.position_std_error_mm,
                    Quantity::PositionErrorMm | Quantity::SupportDistanceMm => at.distance_mm,
                };
                match value.is_finite() {
                    true => (value, model.bounds().contains(&point)),
                    false => (f64::NAN, false),
                }
            };
            (!cancel.is_cancelled()).then(|| (0..nu).map(value).collect())
        })
        .collect();
    let values = rows.ok_or(StudyError::Cancelled)?.concat();
    let mut inside: Vec<f64> = values
        .iter()
        .filter_map(|&(value, is_inside)| is_inside.then_some(value))
        .collect();
    let statistics = Statistics::of(&mut inside);
    let (position_error_mm, is_inside) = values.into_iter().unzip();
    Ok(Some(SliceOutcome {
        plan: *plan,
        position_error_mm,
        is_inside,
        max_mm: statistics.map_or(0.0, |s| s.max),
        p95_mm: statistics.map_or(0.0, |s| s.p95),
        work: Work {
            slice_evaluations: (nu * nv) as u64,
            ..Work::default()
        },
    }))
}
