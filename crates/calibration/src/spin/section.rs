//! A shaft as a result, and what lifts its refusals.

use super::{ShaftDirection, Spin, SpinError};
use crate::remedies::{FEWER_POSES, LESS_RANGE, LESS_TURN};
use trackwright_result::{Refusal, Remedy, Section, count, data, deg, number, vector};

impl Spin {
    /// All that is known of the shaft.
    pub fn section(&self) -> Section {
        let is_towards_tip = self.direction == ShaftDirection::TowardsTip;
        let shaft = match is_towards_tip {
            true => "shaft towards the tip, tool's frame",
            false => "shaft, tool's frame, or its opposite",
        };
        let size = &self.effective_size;
        let (range_deg, in_tool) =
            (self.orientation_range_rad.to_degrees(), self.shaft_in_tool.into_inner().into());
        let in_tracker = self.shaft_in_tracker.into_inner().into();
        Section::of([
            count("poses", "turned poses", self.poses),
            number("effective", "effective number of poses", size.effective, 1, "").part(),
            number("orientation_range_deg", "largest angle between two", range_deg, 1, "deg"),
            vector::<3>("shaft", shaft, Some(in_tool), 5, ""),
            deg("std_error_deg", "standard error, worst direction", self.std_error_rad).part(),
            deg("half_width_95_deg", "95 % interval, ±, likewise", self.half_width_rad()).part(),
            vector::<3>(
                "shaft_in_tracker",
                "shaft in the tracker's frame",
                Some(in_tracker),
                5,
                "",
            ),
            deg("rms_deg", "angle from it, RMS", self.rms_rad),
            deg("max_deg", "largest", self.worst_rad).part(),
            data("towards_tip", is_towards_tip),
            data("covariance", <[[f64; 3]; 3]>::from(self.covariance.transpose())),
            data("degrees_of_freedom", size.freedom),
        ])
        .noting(self.notes().map(str::to_owned))
    }

    fn notes(&self) -> impl Iterator<Item = &'static str> {
        let short = self.effective_size.freedom.is_none().then_some(
            "the recording of turns is too short to determine how far readings depend on their neighbours: the \
             shaft's standard error is a lower bound",
        );
        let open = match self.direction {
            ShaftDirection::TowardsTip => None,
            ShaftDirection::WithoutTip => Some(
                "no tip is known: which of the two directions along the shaft leads to it is open",
            ),
            ShaftDirection::Open => Some(
                "the tip is not clearly before or behind the tool's origin: which of the two directions along the \
                 shaft leads to it is open",
            ),
        };
        short.into_iter().chain(open)
    }
}

impl Refusal for SpinError {
    fn remedy(&self) -> Option<Remedy> {
        match self {
            Self::TooFewPoses { needed: 3, .. } => None,
            Self::TooFewPoses { .. } => Some(FEWER_POSES),
            Self::TooSmallRange { .. } => Some(LESS_RANGE),
            Self::TooLittleTurn { .. } => Some(LESS_TURN),
            Self::TooLargeError { .. } => Some(Remedy::new("max_shaft_deg", "{} accepts more")),
        }
    }
}
