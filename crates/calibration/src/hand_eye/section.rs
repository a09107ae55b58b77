//! Where trackers and sensors are, as a result, and what lifts its refusals.

use super::{HandEye, HandEyeError};
use crate::remedies::LESS_TURN;
use trackwright_result::{Refusal, Remedy, Section, Table, count, data, number};

impl HandEye {
    /// How well the places are known, and how the body turned.
    pub fn section(&self) -> Section {
        let size = &self.effective_size;
        let motion = &self.motion;
        let sensors: Vec<usize> = (0..self.scales.len()).collect();
        let std_errors: Vec<_> = sensors.iter().map(|&k| self.sensor_error(k)).collect();
        let turned = |key, label, rad: f64| number(key, label, rad.to_degrees(), 1, "deg");
        let least = "RMS about the axis turned about least";
        let table = Table::of("", &sensors)
            .text("", "sensor", |k| k.to_string())
            .number("", "standard error, mm", 3, |&k| std_errors[k].position_mm)
            .number("", "deg", 3, |&k| std_errors[k].angle_rad.to_degrees())
            .number("", "scale, mm", 3, |&k| self.scales[k].position_mm)
            .number("", "deg", 3, |&k| self.scales[k].angle_rad.to_degrees())
            .done();
        Section::of([
            count("poses", "poses", self.poses),
            number("effective", "effective number of poses", size.effective, 1, "").part(),
            turned("motion_deg.largest", "largest turn from the first pose", motion.largest_rad),
            turned("motion_deg.least_turn", least, motion.least_turn_rad).part(),
            turned("motion_deg.second_turn", "RMS about the second", motion.second_turn_rad).part(),
            data("degrees_of_freedom", size.freedom),
            data("scales", &self.scales),
            data("sensor_std_errors", &std_errors),
        ])
        .with(table)
    }
}

impl Refusal for HandEyeError {
    fn remedy(&self) -> Option<Remedy> {
        match self {
            Self::TooFewPoses { needed: 3, .. } | Self::SensorTooFew { needed: 3, .. } => None,
            Self::TooFewPoses { .. } | Self::SensorTooFew { .. } => {
                Some(Remedy::new("min_poses", "{} accepts fewer, 3 at least"))
            }
            Self::OneAxis { .. } => Some(LESS_TURN),
            Self::NoRotation { .. } | Self::NoAnswer => None,
        }
    }
}
