//! The battery, family by family.

mod derivatives;
mod evaluation;
mod fits;
mod frames;
mod high_orders;
mod inverse;
mod least_squares;
mod metal;
mod prelude;
mod readings;
mod refusals;
mod rotations;
mod singular_values;
mod spheres;
mod statistics;
mod uncertainty;
mod weights;

use super::case::{Extent, Family};

/// All families, in the order of the page.
pub fn all(extent: Extent) -> Vec<Family> {
    vec![
        evaluation::family(extent),
        derivatives::family(extent),
        inverse::family(extent),
        weights::family(extent),
        rotations::family(extent),
        least_squares::family(extent),
        fits::family(extent),
        high_orders::family(extent),
        singular_values::family(extent),
        frames::family(extent),
        uncertainty::family(extent),
        statistics::family(extent),
        spheres::family(extent),
        readings::family(extent),
        metal::family(extent),
        refusals::family(extent),
    ]
}
