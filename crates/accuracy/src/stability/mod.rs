//! The battery of stiff and extreme cases: each computation beside a reference of 192 bits, and
//! the bound that its error has to keep.
//!
//! A bound is `C · condition · epsilon · scale`: what an algorithm that is backward stable can
//! promise. `C` is at most 100 and stated with each quantity; what the condition is of and what
//! the scale is, too. Methods that lose digits without need break these bounds, which the tests of
//! this room show family by family.

pub mod case;
mod families;
mod high_frames;
#[cfg(test)]
mod naive;
pub mod page;
mod systems;
#[cfg(test)]
mod tests;

use case::{Extent, Family, Methods, Row};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use trackwright_task::{Cancelled, Task};

/// The families of the battery.
pub fn families(extent: Extent) -> Vec<Family> {
    families::all(extent)
}

/// Runs all cases on all cores; rows come in the order of the families.
///
/// # Errors
/// [`Cancelled`].
pub fn run(families: &[Family], methods: &Methods, task: &Task) -> Result<Vec<Row>, Cancelled> {
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
