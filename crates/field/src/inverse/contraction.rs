//! The inverse by stepping `p = p_m - e_pos`, `n = exp(-e_ori) n_m`, many readings at a time: the
//! cheapest way where the map is known to contract, and it evaluates in batches.

use super::equations::{AxisPose, Tolerance, turned_back};
use crate::batch::Batch;
use crate::evaluation::Evaluation;
use crate::samples::PoseError;
use crate::{DistortionModel, OutsidePolicy};
use nalgebra::{Point3, Unit, Vector3};

/// Steps before Newton takes over. A field that changes by 5 % of a step, as real ones do, needs
/// nine; from 30 % on Newton is cheaper.
const MAX_STEPS: usize = 16;

/// Where stepping ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stepped {
    pub place: AxisPose,
    /// The error that the last step took off.
    pub error: PoseError,
    pub is_inside: bool,
    /// What was left of the equations before the last step, which makes it smaller still.
    pub residual_mm: f64,
    pub residual_rad: f64,
    pub evaluations: usize,
    pub has_settled: bool,
}

/// Buffers for one thread.
#[derive(Default)]
pub(super) struct Contraction {
    batch: Batch,
    /// Readings that have not settled, and where each is.
    active: Vec<usize>,
    positions_mm: Vec<Point3<f64>>,
    axes: Vec<Unit<Vector3<f64>>>,
    evaluations: Vec<Evaluation>,
}

impl Contraction {
    /// Steps the readings that `is_wanted` names, from the readings themselves, and reports where
    /// each ends.
    pub fn run(
        &mut self,
        model: &DistortionModel,
        outside: OutsidePolicy,
        readings: &[AxisPose],
        tolerances: &[Tolerance],
        is_wanted: impl Fn(usize) -> bool,
        mut ends: impl FnMut(usize, Stepped),
    ) {
        self.active.clear();
        self.active.extend((0..readings.len()).filter(|&i| is_wanted(i)));
        self.positions_mm.clear();
        self.positions_mm.extend(self.active.iter().map(|&i| readings[i].position_mm));
        self.axes.clear();
        self.axes.extend(self.active.iter().map(|&i| readings[i].axis));
        for step in 1..=MAX_STEPS {
            if self.active.is_empty() {
                break;
            }
            self.batch.evaluate(
                model,
                &self.positions_mm,
                &self.axes,
                outside,
                &mut self.evaluations,
            );
            let mut kept = 0;
            for slot in 0..self.active.len() {
                let index = self.active[slot];
                let at = &self.evaluations[slot];
                let next = stepped(&readings[index], &at.error);
                let moved_mm2 = (next.position_mm - self.positions_mm[slot]).norm_squared();
                let turned_rad2 = (next.axis.as_ref() - self.axes[slot].as_ref()).norm_squared();
                let has_settled = tolerances[index].is_reached_squared(moved_mm2, turned_rad2);
                if has_settled || step == MAX_STEPS {
                    ends(
                        index,
                        Stepped {
                            place: next,
                            error: at.error,
                            is_inside: at.is_inside,
                            residual_mm: moved_mm2.sqrt(),
                            residual_rad: turned_rad2.sqrt(),
                            evaluations: step,
                            has_settled,
                        },
                    );
                } else {
                    self.active[kept] = index;
                    self.positions_mm[kept] = next.position_mm;
                    self.axes[kept] = next.axis;
                    kept += 1;
                }
            }
            self.active.truncate(kept);
            self.positions_mm.truncate(kept);
            self.axes.truncate(kept);
        }
    }
}

/// The reading with an error taken off.
#[inline]
pub(super) fn stepped(reading: &AxisPose, error: &PoseError) -> AxisPose {
    AxisPose {
        position_mm: reading.position_mm - error.position_mm,
        // A rotation keeps the length to some epsilons, and each step starts from the reading.
        axis: Unit::new_unchecked(turned_back(&error.rotation_rad, &reading.axis)),
    }
}
