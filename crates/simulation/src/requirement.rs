//! What a design has to reach, and whether it does.

use super::metric::{ErrorOf, Metric, MetricFields, MetricMap, Statistics};
use serde::ser::SerializeStruct;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::sync::LazyLock;
use trackwright_geometry::limits::{angle_problem, length_problem};

/// Upper bounds on a study's figures; any of them may be left open.
///
/// ```
/// use trackwright_simulation::{Metric, Requirement};
/// let requirement = Requirement::at_most([(Metric::TIP_RMS, 1.0), (Metric::TIP_MAX, 2.0)]);
/// let checks = requirement.checks_of(|metric| Some(if metric == Metric::TIP_MAX { 2.5 } else { 0.5 }));
/// assert_eq!(checks.iter().map(|check| check.met).collect::<Vec<_>>(), [true, false]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Requirement(MetricMap);

/// One bound and the figure that it is held against.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Check {
    #[serde(rename = "name")]
    pub metric: Metric,
    pub value: f64,
    pub limit: f64,
    pub met: bool,
}

/// How trials keep to the bound that holds for each of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Within {
    /// What the bound is about.
    pub metric: Metric,
    pub limit_mm: f64,
    /// Of the trials, from 0 to 1.
    pub part: f64,
}

impl Within {
    /// Of tip errors in millimetres; `None` where no bound holds for each of them.
    pub fn of(tip_errors_mm: &[f64], requirement: &Requirement) -> Option<Self> {
        let (metric, limit_mm) = requirement.single_position_mm()?;
        let count = tip_errors_mm.iter().filter(|e| **e <= limit_mm).count();
        Some(Self { metric, limit_mm, part: count as f64 / tip_errors_mm.len().max(1) as f64 })
    }
}

/// Names in a design file.
static FIELDS: LazyLock<MetricFields> =
    LazyLock::new(|| MetricFields::new(Metric::bounded().map(|m| (m, m.name()))));

impl Requirement {
    /// Bounds on some figures, mm and degrees.
    pub fn at_most<const N: usize>(bounds: [(Metric, f64); N]) -> Self {
        Self(bounds.into())
    }

    /// The bound on a figure.
    pub fn bound(&self, metric: Metric) -> Option<f64> {
        self.0.get(metric)
    }

    /// The same with another bound on a figure, or none.
    #[must_use]
    pub fn with(mut self, metric: Metric, bound: Option<f64>) -> Self {
        self.0.set(metric, bound);
        self
    }

    /// The bounds that there are.
    pub fn bounds(&self) -> impl Iterator<Item = (Metric, f64)> + Clone {
        self.0.iter()
    }

    /// Whether nothing is required.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The bound that the tip error of a single trial is held against: the largest allowed, else
    /// what most or the mean may be.
    pub fn single_position_mm(&self) -> Option<(Metric, f64)> {
        let each = [Metric::TIP_MAX, Metric::TIP_P95, Metric::TIP_RMS];
        each.into_iter().find_map(|metric| Some((metric, self.bound(metric)?)))
    }

    /// Each bound against its figure. A figure that is not a number meets nothing.
    pub fn checks(&self, position_mm: &Statistics, angle_deg: &Statistics) -> Vec<Check> {
        self.checks_of(|metric| Some(metric.of_study(position_mm, angle_deg)))
    }

    /// Each bound against its figure, where it has one.
    pub fn checks_of(&self, value: impl Fn(Metric) -> Option<f64>) -> Vec<Check> {
        let each =
            self.bounds().filter_map(|(metric, limit)| Some((metric, limit, value(metric)?)));
        each.map(|(metric, limit, value)| Check { metric, value, limit, met: value <= limit })
            .collect()
    }

    /// What was expected of a bound on a figure; `None` where it is fine.
    pub fn bound_problem(metric: Metric, bound: f64) -> Option<&'static str> {
        match metric.of {
            ErrorOf::Angle => angle_problem(bound),
            ErrorOf::Position => length_problem(bound),
        }
    }
}

impl Serialize for Requirement {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_struct("Requirement", self.bounds().count())?;
        for (metric, bound) in self.bounds() {
            out.serialize_field(metric.name(), &Some(bound))?;
        }
        out.end()
    }
}

impl<'de> Deserialize<'de> for Requirement {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        MetricMap::deserialize(deserializer, "Requirement", &FIELDS).map(Self)
    }
}
