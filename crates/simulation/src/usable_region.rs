//! Where in the tracker's volume a design meets its requirement.
//!
//! At each point of a lattice the tool is put with its tip there and turned as its range of motion
//! turns it (the design's own orientation where it has none), and the study's figures over these
//! turns are held against each bound that the requirement names: its position bounds against RMS,
//! 95th percentile or largest tip error, its angle bounds likewise. The scalar is the largest share
//! of a bound that is used up, so 1 is where the requirement is just met, and one surface serves
//! whatever the requirement names. The motion's translations have no part in it: where the tool is
//! is what the lattice gives.
//!
//! In a room that keeps its measurements the requirement is met where it is met with 95 %: where the
//! upper end of each figure's interval is within its bound (`interval.rs`).
//!
//! The CRF stays where the design has it. The question is how far from a CRF that is fixed to the
//! patient and from the generator this tool may work, so the tool is moved, not the CRF.
//!
//! A volume that is no box lies within its bounding box's lattice, and surface and region are cut
//! where it ends. The part of it where the requirement is met is that of the volume as the lattice
//! has it, so that all of it is exactly all, and the region's size is this part of the volume's own.

use super::figures::reaches_tip;
use super::metric::Statistics;
use super::run::{StudyError, check};
use super::scenario::Scenario;
use super::trial::{Simulator, Trial, TrialBuffers};
use super::work::Work;
use crate::requirement::Requirement;
use interval::OpenPart;
use nalgebra::UnitQuaternion;
use rayon::prelude::*;
use trackwright_field::OutsidePolicy;
use trackwright_geometry::bounds::Bounds;
use trackwright_geometry::isosurface::{Isosurface, ScalarLattice};
use trackwright_geometry::pose::Pose;
use trackwright_geometry::volume::Volume;
use trackwright_task::{Cancelled, Task};

/// Most values of each angle that are visited: the ends of its range and the middle. Beside all
/// values the ends count for more, so that the region is rather too small.
const MOST_ANGLES: usize = 3;

/// Lattice points that one core computes before it looks whether anyone still wants them: with 27
/// turns some 3 ms.
const PIECE: usize = 96;

/// What a bound is held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegionBasis {
    /// The figure of the room's model alone.
    OwnField,
    /// The upper end of the figure's 95 % interval, where the room keeps its measurements; elsewhere as
    /// [`Self::OwnField`].
    Interval,
}

/// Where the requirement is met.
#[derive(Clone, Debug, PartialEq)]
pub struct UsableRegion {
    /// Over the bounding box of the tracker's volume, or the model's box where that is not known:
    /// the largest share of a bound that the figures of the room's model alone use up, infinite where
    /// each trial is left out, and beyond the volume where nothing depends on it.
    pub share: ScalarLattice,
    /// Likewise the upper ends of 95 % intervals, where they were found.
    pub upper_share: Option<ScalarLattice>,
    /// Points at which intervals were computed.
    pub interval_points: usize,
    /// Whether all sensors stay in the model's box at each point.
    pub is_inside: Vec<bool>,
    /// Where the share, the upper one where there is one, is 1, tracker frame; open where the region reaches the volume's end.
    pub surface: Isosurface,
    pub volume_cm3: f64,
    /// Of the tracker's volume itself, not its bounding box; 0 to 1.
    pub fraction: f64,
    /// Orientations visited at each point, and how many the motion has.
    pub orientations: usize,
    pub all_orientations: usize,
    pub work: Work,
}

/// Why there is no region.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RegionError {
    #[error("the design has no requirement")]
    NoRequirement,
    #[error("a lattice of {counts:?} points, expected at least 2 along each axis")]
    Counts { counts: [usize; 3] },
    #[error(transparent)]
    Study(#[from] StudyError),
}

impl From<Cancelled> for RegionError {
    fn from(_: Cancelled) -> Self {
        Self::Study(StudyError::Cancelled)
    }
}

/// The region where the scenario's requirement is met, from a lattice with so many points along x,
/// y and z. The result does not depend on the number of threads.
///
/// # Errors
/// See [`RegionError`].
pub fn usable_region(
    scenario: &Scenario,
    counts: [usize; 3],
    basis: RegionBasis,
    task: &Task,
) -> Result<UsableRegion, RegionError> {
    let requirement = scenario
        .requirement
        .filter(|r| *r != Requirement::default())
        .ok_or(RegionError::NoRequirement)?;
    if counts.iter().any(|n| *n < 2) {
        return Err(RegionError::Counts { counts });
    }
    check(scenario)?;
    task.step(0, 1)?;
    let (orientations, all_orientations) = rotations(scenario)?;
    let environment = &scenario.environment;
    let bounds: Bounds =
        environment.volume.map_or(*environment.model.bounds(), |volume| volume.bounds());
    let mut share = ScalarLattice { bounds, counts, values: Vec::new() };
    let excess = excess_mm(&share, environment.volume.as_ref());
    let places = match &excess {
        Some(excess) => needed(counts, excess),
        None => (0..counts.iter().product()).collect(),
    };
    let simulator = Simulator::new(scenario);
    let pieces: Result<Vec<_>, Cancelled> = places
        .par_chunks(PIECE)
        .map_init(Buffers::default, |buffers, places| {
            if task.cancel.is_cancelled() {
                return Err(Cancelled);
            }
            let piece: Vec<_> =
                places.iter().map(|place| share.point_mm(share.index(*place))).collect();
            buffers.poses.clear();
            for turn in &orientations {
                let poses = piece.iter().map(|tip| simulator.crf_from_tool_with_tip_at(tip, turn));
                buffers.poses.extend(poses);
            }
            let trials = simulator.trials(&mut buffers.trial, &buffers.poses, piece.len());
            let of_piece: Vec<_> = (0..piece.len())
                .map(|i| {
                    let of_point = trials.iter().skip(i).step_by(piece.len());
                    judged(of_point, &requirement, scenario.outside)
                })
                .collect();
            Ok((of_piece, buffers.trial.take_work()))
        })
        .collect();
    let mut work = simulator.own_work();
    let points = counts.iter().product();
    share.values = vec![f64::INFINITY; points];
    let mut is_inside = vec![false; points];
    let mut places = places.into_iter();
    for (of_piece, cost) in pieces? {
        work += cost;
        for ((value, inside), place) in of_piece.into_iter().zip(&mut places) {
            share.values[place] = value;
            is_inside[place] = inside;
        }
    }
    let open = match basis {
        RegionBasis::OwnField => None,
        RegionBasis::Interval => OpenPart::find(scenario, &simulator, &orientations, bounds, task)?,
    };
    let upper_share = open.as_ref().map(|open| {
        let each = share.values.iter().enumerate();
        let each = each.map(|(place, own)| open.upper(&share.point_mm(share.index(place)), *own));
        ScalarLattice { values: each.collect(), ..share }
    });
    let judged = upper_share.as_ref().unwrap_or(&share);
    let clipped = judged.clipped_isosurface(1.0, excess.as_deref());
    let fraction = match clipped.whole_mm3 > 0.0 {
        true => clipped.surface.volume_mm3 / clipped.whole_mm3,
        false => 0.0,
    };
    let whole_mm3 =
        environment.volume.map_or(bounds.size_mm().product(), |volume| volume.volume_mm3());
    task.step(1, 1)?;
    Ok(UsableRegion {
        volume_cm3: fraction * whole_mm3 / 1e3,
        fraction,
        share,
        upper_share,
        interval_points: open.map_or(0, |open| open.points),
        is_inside,
        surface: clipped.surface,
        orientations: orientations.len(),
        all_orientations,
        work: Work { region_evaluations: work.study_evaluations, study_evaluations: 0, ..work },
    })
}

/// How far beyond the volume each lattice point is; `None` where all of the lattice is within.
fn excess_mm(lattice: &ScalarLattice, volume: Option<&Volume>) -> Option<Vec<f64>> {
    let excess = volume?.excess_mm()?;
    let points: usize = lattice.counts.iter().product();
    let at = |place| excess(&lattice.point_mm(lattice.index(place)));
    Some((0..points).map(at).collect())
}

/// Points of the cells that the volume reaches into, which are all that surface and region depend on.
fn needed(counts: [usize; 3], excess: &[f64]) -> Vec<usize> {
    let [nx, ny, nz] = counts;
    let mut is_needed = vec![false; excess.len()];
    for (place, _) in excess.iter().enumerate().filter(|(_, e)| **e <= 0.0) {
        let near = |index: usize, count: usize| index.saturating_sub(1)..(index + 2).min(count);
        for x in near(place / (ny * nz), nx) {
            for y in near(place / nz % ny, ny) {
                for z in near(place % nz, nz) {
                    is_needed[(x * ny + y) * nz + z] = true;
                }
            }
        }
    }
    (0..excess.len()).filter(|place| is_needed[*place]).collect()
}

#[derive(Default)]
struct Buffers {
    trial: TrialBuffers,
    poses: Vec<Pose>,
}

/// Orientations `crf_from_tool` that are visited, and how many the motion has.
pub fn rotations(scenario: &Scenario) -> Result<(Vec<UnitQuaternion<f64>>, usize), StudyError> {
    let Some(grid) = scenario.motion_grid()? else {
        return Ok((vec![scenario.crf_from_tool.rotation], 1));
    };
    let (axes, counts) = (grid.motion().axes(), grid.counts());
    let angles = [3, 4, 5].map(|k| -> Vec<f64> {
        let few = counts[k].min(MOST_ANGLES);
        let index = |i: usize| match few {
            1 => 0,
            few => i * (counts[k] - 1) / (few - 1),
        };
        let value = |i: usize| axes[k].1.map_or(0.0, |r| r.min + index(i) as f64 * r.step);
        (0..few).map(value).collect()
    });
    let [rx, ry, rz] = &angles;
    let mut orientations = Vec::new();
    for &x in rx {
        for &y in ry {
            for &z in rz {
                let values = [0.0, 0.0, 0.0, x, y, z];
                orientations.push(grid.moved(values).rotation);
            }
        }
    }
    Ok((orientations, grid.orientations()))
}

/// The largest share of a bound that the trials at one point use up, and whether all of them are
/// inside the model's box.
fn judged<'a>(
    trials: impl Iterator<Item = &'a Trial>,
    requirement: &Requirement,
    outside: OutsidePolicy,
) -> (f64, bool) {
    let (mut position_mm, mut angle_deg) = (Vec::new(), Vec::new());
    let mut is_inside = true;
    for trial in trials {
        is_inside &= trial.outside == 0;
        if reaches_tip(trial.free_reach_mm) {
            // Whatever its figures are, the requirement is not known to be met.
            return (f64::INFINITY, is_inside);
        }
        if outside != OutsidePolicy::Reject || trial.outside == 0 {
            position_mm.push(trial.tip_error_mm);
            angle_deg.push(trial.angle_error_deg);
        }
    }
    let figures = Statistics::of(&mut position_mm).zip(Statistics::of(&mut angle_deg));
    let share = figures.map_or(f64::INFINITY, |(position_mm, angle_deg)| {
        let checks = requirement.checks(&position_mm, &angle_deg);
        share_of(checks.iter().map(|check| (check.value, check.limit)))
    });
    (share, is_inside)
}

/// The largest share of a bound that its figure uses up, of figures and bounds. A figure that is not a
/// number meets nothing.
pub fn share_of(bounds: impl Iterator<Item = (f64, f64)>) -> f64 {
    let shares = bounds.map(|(value, limit)| match limit > 0.0 {
        true => value / limit,
        false if value <= limit => 0.0,
        false => f64::INFINITY,
    });
    shares.fold(0.0, |most: f64, share| match share.is_nan() {
        true => f64::INFINITY,
        false => most.max(share),
    })
}

mod interval;
