//! How a tracker's jitter is stated on the command line.

use super::numbers::{length_above_zero, zero_or_more};
use clap::Args;
use trackwright_field::environment::Jitter;

/// Repeated for each argument: a heading for the group would go on to whatever follows it.
const HEADING: &str = "Jitter of the tracker";

#[derive(Debug, Args)]
pub struct JitterArgs {
    /// Standard deviation of a still sensor's position, per axis, mm
    #[arg(
        long,
        help_heading = HEADING,
        value_name = "MM",
        value_parser = zero_or_more,
        allow_negative_numbers = true,
        requires = "jitter_angle_deg"
    )]
    jitter_position_mm: Option<f64>,

    /// Standard deviation of a still sensor's orientation, per component of its rotation vector, degrees
    #[arg(
        long,
        help_heading = HEADING,
        value_name = "DEG",
        value_parser = zero_or_more,
        allow_negative_numbers = true,
        requires = "jitter_position_mm"
    )]
    jitter_angle_deg: Option<f64>,

    /// Distance from the generator, mm, where the jitter has grown by √2; beyond it, positions
    /// scatter with the fourth and orientations with the third power of the distance, as a dipole's
    /// field fades. The same jitter everywhere where left out
    #[arg(
        long,
        help_heading = HEADING,
        value_name = "MM",
        value_parser = length_above_zero,
        allow_negative_numbers = true,
        requires = "jitter_position_mm"
    )]
    jitter_growth_mm: Option<f64>,
}

impl JitterArgs {
    /// The jitter, where it is stated.
    pub fn jitter(&self) -> Option<Jitter> {
        let (position_mm, angle_deg) = self.jitter_position_mm.zip(self.jitter_angle_deg)?;
        let growth_mm = self.jitter_growth_mm;
        Some(Jitter::stated(position_mm, angle_deg.to_radians(), growth_mm))
    }
}
