//! How well the reference's frame is known, as the command line states it.

use super::numbers::{angle_deg, zero_or_more};
use clap::Args;
use trackwright_calibration::room_fit::RegistrationError;

/// Repeated for each argument: a heading for the group would go on to whatever follows it.
const HEADING: &str = "Registration of the reference";

#[derive(Debug, Args)]
pub struct RegistrationArgs {
    /// Standard deviation of the place of the reference's frame in the tracker's, per axis, mm: what
    /// `characterize` and `register` state. Intervals of figures then include it
    #[arg(
        long,
        help_heading = HEADING,
        value_name = "MM",
        value_parser = zero_or_more,
        allow_negative_numbers = true,
        requires = "registration_deg"
    )]
    registration_mm: Option<f64>,

    /// Standard deviation of its orientation, per axis, degrees
    #[arg(
        long,
        help_heading = HEADING,
        value_name = "DEG",
        value_parser = angle_deg,
        allow_negative_numbers = true,
        requires = "registration_mm"
    )]
    registration_deg: Option<f64>,
}

impl RegistrationArgs {
    /// The error, where it is stated.
    pub fn error(&self) -> Option<RegistrationError> {
        let (position_mm, angle_deg) = self.registration_mm.zip(self.registration_deg)?;
        Some(RegistrationError { position_mm, angle_rad: angle_deg.to_radians() })
    }
}
