//! The assessment protocol of Hummel et al. for trackers: a plate with a grid of holes and a disc, in a
//! simulated room or recorded, and what repeated runs of it show.
//!
//! J. Hummel et al., *Design and application of an assessment protocol for electromagnetic tracking
//! systems*, Medical Physics 32(7), 2005. Lengths are in mm, angles in degrees, as on the plate.

pub mod control_chart;
pub mod evaluation;
pub mod plate;
pub mod readings;
pub mod rods;
pub mod table;

#[cfg(test)]
mod tests;
