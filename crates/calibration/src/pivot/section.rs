//! A tip as a result, and what lifts its refusals.

use super::{Pivot, PivotError, Quarters};
use crate::remedies::{FEWER_POSES, LESS_RANGE, LESS_TURN};
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;
use trackwright_result::{Refusal, Remedy, Row, Section, count, data, mm, number, vector};

impl Pivot {
    /// All that is known of the tip.
    pub fn section(&self) -> Section {
        let [tip_half, pivot_half] = match self.half_widths_mm() {
            Some(halves) => halves.map(Some),
            None => [None; 2],
        };
        let size = &self.effective_size;
        let range_deg = self.orientation_range_rad.to_degrees();
        let interval = |at: &Point3<f64>, half: &Vector3<f64>| {
            [0, 1, 2].map(|k| [at[k] - half[k], at[k] + half[k]])
        };
        let intervals = self.half_widths_mm().map(|[tip, pivot]| {
            let (tip, pivot) =
                (interval(&self.tip_in_tool, &tip), interval(&self.pivot_in_tracker, &pivot));
            BTreeMap::from([("tip", tip), ("pivot", pivot)])
        });
        let point = |at: &Point3<f64>| Some(<[f64; 3]>::from(at.coords));
        let around = |half: Option<Vector3<f64>>| {
            vector::<3>("", "95 % interval, ±", half.map(Into::into), 3, "mm").part()
        };
        let std_error = |key, value_mm| mm(key, "standard error, worst direction", value_mm).part();
        Section::of([
            count("poses", "poses", self.poses),
            number("effective", "effective number of poses", size.effective, 1, "").part(),
            number("orientation_range_deg", "largest angle between two", range_deg, 1, "deg"),
            vector("tip", "tip in the tool's frame", point(&self.tip_in_tool), 3, "mm"),
            around(tip_half),
            std_error("tip_std_error_mm", self.tip_std_error_mm),
            vector("pivot", "pivot in the tracker's frame", point(&self.pivot_in_tracker), 3, "mm"),
            around(pivot_half),
            std_error("pivot_std_error_mm", self.pivot_std_error_mm()),
            mm("rms_mm", "distance of the tip from it, RMS", self.rms_mm),
            mm("rms_component_mm", "of a component", self.rms_component_mm()).part(),
            mm("max_mm", "largest", self.worst_mm).part(),
            data("intervals", intervals),
            data("covariance_mm2", <[[f64; 6]; 6]>::from(self.covariance_mm2.transpose())),
            data("degrees_of_freedom", size.freedom),
            data("quarters", ()),
        ])
        .with_all(self.quarters.iter().flat_map(Quarters::rows))
        .noting(self.note())
    }

    /// What the standard errors do not hold for.
    fn note(&self) -> Option<String> {
        match (self.effective_size.freedom, &self.quarters) {
            (None, _) => Some(
                "the recording is too short to determine how far readings depend on their neighbours: standard \
                 errors are lower bounds, and there are no intervals"
                    .to_owned(),
            ),
            (Some(_), None) => Some(
                "a quarter of the recording by itself does not determine the tip: slow drift cannot be \
                 distinguished from the tool's motion, and is not in the standard errors"
                    .to_owned(),
            ),
            (Some(_), Some(quarters)) if quarters.has_drift => Some(format!(
                "the tips of two quarters of the recording differ by {:.3} mm, with a standard error of {:.3} mm by \
                 what happens within them: the tip or a sensor moved, or the field differs; the standard errors of \
                 the whole include it",
                quarters.apart_mm, quarters.expected_mm
            )),
            _ => None,
        }
    }
}

impl Quarters {
    fn rows(&self) -> [Row; 3] {
        let apart = "tips of two quarters differ by up to";
        let expected = "standard error of that, worst direction";
        [
            mm("quarters.apart_mm", apart, self.apart_mm),
            mm("quarters.expected_mm", expected, self.expected_mm).part(),
            data("quarters.drift", self.has_drift),
        ]
    }
}

impl Refusal for PivotError {
    fn remedy(&self) -> Option<Remedy> {
        match self {
            Self::TooFewPoses { needed: 3, .. } => None,
            Self::TooFewPoses { .. } => Some(FEWER_POSES),
            Self::TooSmallRange { .. } => Some(LESS_RANGE),
            Self::OneAxis { .. } => Some(LESS_TURN),
            Self::TooLargeError { .. } => Some(Remedy::new("max_rms_mm", "{} accepts more")),
        }
    }
}
