//! The battery of stiff and extreme cases: each computation beside a reference of 192 bits, and
//! the bound that its error has to keep.
//!
//! A bound is `C · condition · epsilon · scale`: what an algorithm that is backward stable can
//! promise. `C` is at most 100 and stated with each quantity; what the condition is of and what
//! the scale is, too. Methods that lose digits without need break these bounds, which the tests of
//! this room show family by family.

mod families;
mod high_frames;
pub mod inputs;
pub mod methods;
#[cfg(test)]
mod naive;
pub mod page;
pub mod references;
pub mod row;
mod systems;
#[cfg(test)]
mod tests;

use methods::Methods;
use rayon::prelude::*;
use row::{Family, Row};
use std::sync::atomic::{AtomicUsize, Ordering};
use trackwright_task::{Cancelled, Task};

/// How much of the battery runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// All of it: minutes.
    Full,
    /// Every family with its smaller cases: seconds, even without optimisation.
    Reduced,
}

impl Extent {
    /// One of two lists.
    pub fn of<T: Clone>(self, full: &[T], reduced: &[T]) -> Vec<T> {
        match self {
            Self::Full => full.to_vec(),
            Self::Reduced => reduced.to_vec(),
        }
    }

    pub fn is_full(self) -> bool {
        self == Self::Full
    }
}

/// The families of the battery.
pub fn families(extent: Extent) -> Vec<Family> {
    families::all(extent)
}

/// Runs all cases on all cores; rows come in the order of the families.
///
/// # Errors
/// [`Cancelled`].
pub fn run(families: &[Family], methods: &dyn Methods, task: &Task) -> Result<Vec<Row>, Cancelled> {
    let cases: Vec<_> =
        families.iter().flat_map(|f| f.cases.iter().map(move |c| (f.name, c))).collect();
    let done = AtomicUsize::new(0);
    let rows: Vec<Vec<Row>> = cases
        .par_iter()
        .with_max_len(1)
        .map(|(family, case)| {
            let mut rows = case.rows(methods);
            for row in &mut rows {
                row.family = family;
            }
            task.step(done.fetch_add(1, Ordering::Relaxed) + 1, cases.len())?;
            Ok(rows)
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(rows.concat())
}
