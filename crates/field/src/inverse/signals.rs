//! Poses behind a reading among metal, by what its coils measure.
//!
//! A tracker reports the pose `p, n` whose signals `n·B⁰(p)` in the empty room are nearest to those of the true pose
//! `x, m`. With the Jacobian `J` of the signals there, `W = (JᵀJ)⁻¹ Jᵀ`, each true pose satisfies
//! `W (m·B(x) − n·B⁰(p)) = 0`. These equations are linear in `m`: they are solved for it at places all over the
//! box, which are the nearer to each other the more the metal's field varies, and from the places where the least
//! is left Broyden's method goes on. So poses a few millimetres from metal are found as well.
//! Beyond a fold there is another pose, which is looked for by the curvature of the readings.
//!
//! The constants here, of cells and of equations were chosen in the built-in theatre, where three poses in 340,000 are
//! missed.

use super::equations::AxisPose;
use super::signal_cells::Cell;
use super::signal_equations::{FARTHEST, SignalEquations, Start};
use crate::computed::DisturbedCoils;
use trackwright_geometry::bounds::Bounds;

/// Places from which solutions are looked for, at most.
const MOST_STARTS: usize = 16;

/// Starts nearer to each other than this part of their cells are one.
const SAME_START: f64 = 0.5;

/// Starts that lead nearer to a known answer than this part of a cell are no other ones.
const KNOWN: f64 = 0.25;

/// The fields of a room all over its box.
#[derive(Clone, Debug)]
pub(super) struct Signals {
    cells: Vec<Cell>,
}

impl Signals {
    pub fn of(coils: &dyn DisturbedCoils, bounds: &Bounds) -> Self {
        Self { cells: Cell::all(coils, bounds) }
    }

    /// Poses that the equations of a reading hold for; what is read there is to be looked at, as signals may have
    /// several nearest poses.
    pub fn solutions(
        &self,
        coils: &dyn DisturbedCoils,
        reading: &AxisPose,
        known: Option<&AxisPose>,
    ) -> Vec<AxisPose> {
        let Some(equations) = SignalEquations::new(coils.generator(), reading) else {
            return Vec::new();
        };
        let mut near: Vec<(f64, &Cell, Start)> = Vec::new();
        for cell in &self.cells {
            if !cell.readings.contains(&reading.position_mm) {
                continue;
            }
            let Some(start) = equations.start(cell) else { continue };
            let cells = start.step.fixed_rows::<3>(0).norm() / cell.size_mm;
            let is_known = |known: &AxisPose| {
                (start.place_mm() - known.position_mm).norm() <= KNOWN * cell.size_mm
            };
            if cells <= FARTHEST && !known.is_some_and(is_known) {
                near.push((cells, cell, start));
            }
        }
        near.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
        let mut tried: Vec<(&Cell, Start)> = Vec::new();
        let mut found: Vec<AxisPose> = Vec::new();
        for (_, cell, start) in near {
            let place_mm = start.place_mm();
            let is_new = |(other, known): &(&Cell, Start)| {
                let apart_mm = (place_mm - known.place_mm()).norm();
                apart_mm > SAME_START * cell.size_mm.min(other.size_mm)
            };
            let is_other = |known: &AxisPose| {
                (place_mm - known.position_mm).norm() > SAME_START * cell.size_mm
            };
            if tried.len() == MOST_STARTS {
                break;
            }
            if tried.iter().all(is_new) && found.iter().all(is_other) {
                tried.push((cell, start));
                found.extend(equations.solve(coils, start, cell.size_mm, known));
            }
        }
        let twins = known.into_iter().chain(&found).filter_map(|pose| equations.twin(coils, pose));
        let twins: Vec<_> = twins.collect();
        found.extend(twins);
        found
    }
}
