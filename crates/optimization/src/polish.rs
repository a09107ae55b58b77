//! Searches from one position on: CMA-ES where there is far to go, mesh adaptive direct search at the
//! end (both of the crate `basin`). Neither needs a derivative; both depend on their seed alone.

use crate::bodies::{Movable, Position};
use basin::{CmaEs, CostFunction, DenseMatrix, Executor, Mads, PointState, PopulationProgress};
use std::cell::RefCell;

/// Way that is one unit of what is searched in.
const UNIT_MM: f64 = 1.0;

/// Least way that the last search looks at: a hundredth of what a coil can be glued to.
const LEAST_MM: f64 = 0.01;

/// What no allowed layout comes to.
const REFUSED: f64 = 1e12;

/// A position and what it comes to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Found {
    pub position: Position,
    pub value: f64,
}

/// A cost over ways from a start, which remembers the best.
struct Ways<'a, F> {
    movable: &'a Movable<'a>,
    start: &'a Position,
    value: F,
    best: RefCell<Found>,
}

/// The search is to end.
#[derive(Debug)]
struct Ended;

impl<F: Fn(&Position, f64) -> Result<Option<f64>, ()>> CostFunction for &Ways<'_, F> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Ended;

    fn cost(&self, way: &Self::Param) -> Result<f64, Ended> {
        let way_mm: Vec<f64> = way.iter().map(|part| part * UNIT_MM).collect();
        let position = self.movable.moved(self.start, &way_mm);
        let best = self.best.borrow().value;
        let value = (self.value)(&position, best).map_err(|()| Ended)?;
        let Some(value) = value.filter(|value| value.is_finite()) else {
            return Ok(REFUSED);
        };
        if value < best {
            *self.best.borrow_mut() = Found { position, value };
        }
        Ok(value)
    }
}

/// The best position near a start by steps that become ever smaller.
///
/// `value` gets a position and what the best comes to so far: what is better than that has to be
/// allowed, and of the rest it is not looked at. It returns `None` of what is not allowed, and an error
/// where the search is to end; the best so far is then returned.
pub(crate) fn polished(
    movable: &Movable,
    start: &Found,
    step_mm: f64,
    most: u64,
    value: impl Fn(&Position, f64) -> Result<Option<f64>, ()>,
) -> Found {
    let dimensions = movable.dimensions(&start.position);
    if dimensions == 0 {
        return start.clone();
    }
    let best = RefCell::new(start.clone());
    let ways = Ways { movable, start: &start.position, value, best };
    let solver = Mads::new()
        .with_initial_poll_size(step_mm / UNIT_MM)
        .with_minimum_poll_size(LEAST_MM / UNIT_MM);
    let state = PointState::new(vec![0.0; dimensions]);
    let executor = Executor::new(&ways, solver, state).max_cost_evals(most);
    // Ended or converged, what was best is in `ways`.
    let _ = executor.run();
    ways.best.into_inner()
}

/// The best position of a search about a start with steps of a size that adapts; as [`polished`].
pub(crate) fn spread_out(
    movable: &Movable,
    start: &Found,
    step_mm: f64,
    (most, seed): (u64, u64),
    value: impl Fn(&Position, f64) -> Result<Option<f64>, ()>,
) -> Found {
    let dimensions = movable.dimensions(&start.position);
    if dimensions < 2 {
        return start.clone();
    }
    let best = RefCell::new(start.clone());
    let ways = Ways { movable, start: &start.position, value, best };
    let solver = CmaEs::<_, DenseMatrix>::new(seed, step_mm / UNIT_MM);
    let state = PopulationProgress::from_point(vec![0.0; dimensions]);
    let executor = Executor::new(&ways, solver, state).max_cost_evals(most);
    let _ = executor.run();
    ways.best.into_inner()
}
