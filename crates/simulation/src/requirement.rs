//! What a design has to reach, and whether it does.

use super::statistics::Statistics;
use serde::{Deserialize, Serialize};
use trackwright_geometry::limits::{angle_problem, length_problem};

/// Upper bounds on a study's figures; any of them may be left open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Requirement {
    #[serde(rename = "position_rms", default, skip_serializing_if = "Option::is_none")]
    pub position_rms_mm: Option<f64>,
    #[serde(rename = "position_p95", default, skip_serializing_if = "Option::is_none")]
    pub position_p95_mm: Option<f64>,
    #[serde(rename = "position_max", default, skip_serializing_if = "Option::is_none")]
    pub position_max_mm: Option<f64>,
    #[serde(rename = "angle_rms", default, skip_serializing_if = "Option::is_none")]
    pub angle_rms_deg: Option<f64>,
    #[serde(rename = "angle_max", default, skip_serializing_if = "Option::is_none")]
    pub angle_max_deg: Option<f64>,
}

/// One bound and the figure that it is held against.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Check {
    /// The bound's name in a design file.
    pub name: &'static str,
    pub value: f64,
    pub limit: f64,
    pub met: bool,
}

impl Requirement {
    /// The bound that the tip error of a single trial is held against, with the name of the figure
    /// that it is about: the largest allowed, else what most or the mean may be.
    pub fn single_position_mm(&self) -> Option<(&'static str, f64)> {
        let max = self.position_max_mm.map(|limit| ("max", limit));
        let p95 = self.position_p95_mm.map(|limit| ("95th percentile", limit));
        let rms = self.position_rms_mm.map(|limit| ("RMS", limit));
        max.or(p95).or(rms)
    }

    /// Each bound against its figure. A figure that is not a number meets nothing.
    pub fn checks(&self, position_mm: &Statistics, angle_deg: &Statistics) -> Vec<Check> {
        let (p, a) = (position_mm, angle_deg);
        self.checks_of([p.rms, p.p95, p.max, a.rms, a.max])
    }

    /// The bounds by their names in a design file: RMS, 95th percentile and largest of the tip error
    /// in mm, RMS and largest of the angle error in degrees.
    pub fn bounds(&self) -> [(&'static str, Option<f64>); 5] {
        [
            ("position_rms", self.position_rms_mm),
            ("position_p95", self.position_p95_mm),
            ("position_max", self.position_max_mm),
            ("angle_rms", self.angle_rms_deg),
            ("angle_max", self.angle_max_deg),
        ]
    }

    /// What was expected of the bound of that name; `None` where it is fine.
    pub fn bound_problem(name: &str, bound: f64) -> Option<&'static str> {
        match name.starts_with("angle") {
            true => angle_problem(bound),
            false => length_problem(bound),
        }
    }

    /// Each bound against its figure, which are in the order of [`Self::bounds`].
    pub fn checks_of(&self, figures: [f64; 5]) -> Vec<Check> {
        let each = self.bounds().into_iter().zip(figures);
        each.filter_map(|((name, limit), value)| {
            limit.map(|limit| Check { name, value, limit, met: value <= limit })
        })
        .collect()
    }
}
