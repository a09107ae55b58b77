//! The battery, family by family.

mod evaluation;
mod least_squares;
mod rotations;
mod weights;

use super::Extent;
use super::row::Family;

/// All families, in the order of the page.
pub fn all(extent: Extent) -> Vec<Family> {
    vec![
        evaluation::family(extent),
        weights::family(extent),
        rotations::family(extent),
        least_squares::family(extent),
    ]
}
