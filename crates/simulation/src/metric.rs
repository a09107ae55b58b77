//! Every figure of a study in one table: how it is computed, what it is called, where it is shown.
//!
//! A new figure is a variant of [`Summary`] with its row in `SUMMARIES`, and its row in `TABLE`.
//! Requirements, panels, reports, comparisons, decisions and the command line iterate over these.

use super::statistics::Sample;
use serde::de::{self, DeserializeSeed, MapAccess, Visitor};
use serde::ser::SerializeStruct;
use serde::{Deserializer, Serialize, Serializer};
use std::fmt;
use std::ops::RangeInclusive;

/// What an error is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorOf {
    /// The tip, mm.
    Position,
    /// The tool's rotation, degrees.
    Angle,
}

impl ErrorOf {
    pub const ALL: [Self; 2] = [Self::Position, Self::Angle];

    /// Its name in files.
    pub fn key(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Angle => "angle",
        }
    }

    /// The object of its figures in JSON.
    pub fn json_key(self) -> &'static str {
        match self {
            Self::Position => "position_mm",
            Self::Angle => "angle_deg",
        }
    }

    /// What it is, in a sentence without its full stop.
    pub fn about(self) -> &'static str {
        match self {
            Self::Position => "Distance of the tip from where the tracker measures it",
            Self::Angle => "Angle between the tool and the tool as the tracker measures it",
        }
    }

    /// For a person.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Position => "mm",
            Self::Angle => "°",
        }
    }

    /// In column names.
    pub fn unit_key(self) -> &'static str {
        match self {
            Self::Position => "mm",
            Self::Angle => "deg",
        }
    }
}

/// One number that sums up a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Summary {
    Rms,
    Mean,
    /// Population standard deviation.
    Std,
    Min,
    Median,
    P95,
    Max,
}

/// How a summary is named and computed.
struct SummaryRow {
    summary: Summary,
    /// In JSON, CSV and RON.
    key: &'static str,
    /// Within sentences, and in the heads of tables.
    label: &'static str,
    short: &'static str,
    /// What it is, after a colon.
    about: &'static str,
    value: fn(&mut Sample) -> f64,
    /// Parts of the sample, in order of size, whose values it grows with.
    ranks: [f64; 2],
}

const fn summary(
    summary: Summary,
    [key, label, short, about]: [&'static str; 4],
    ranks: [f64; 2],
    value: fn(&mut Sample) -> f64,
) -> SummaryRow {
    SummaryRow { summary, key, label, short, about, value, ranks }
}

/// In the order of files; sums before what reorders the sample.
const SUMMARIES: &[SummaryRow] = &[
    summary(
        Summary::Rms,
        [
            "rms",
            "RMS",
            "RMS",
            "root of the mean square over all trials, in which large errors count more",
        ],
        [0.0, 1.0],
        |s| s.rms(),
    ),
    summary(Summary::Mean, ["mean", "mean", "mean", "mean over all trials"], [0.0, 1.0], |s| {
        s.mean()
    }),
    summary(
        Summary::Std,
        ["std", "std", "std", "standard deviation over all trials"],
        [0.0, 1.0],
        |s| s.std(),
    ),
    summary(Summary::Min, ["min", "min", "min", "the least of all trials"], [0.0, 0.0], |s| {
        s.min()
    }),
    summary(
        Summary::Median,
        ["median", "median", "median", "half of all trials are below"],
        [0.47, 0.53],
        |s| s.percentile(0.5),
    ),
    summary(
        Summary::P95,
        ["p95", "95th percentile", "95 %", "95 % of all trials are below"],
        [0.92, 0.98],
        |s| s.percentile(0.95),
    ),
    summary(Summary::Max, ["max", "max", "max", "the largest of all trials"], [1.0, 1.0], |s| {
        s.max()
    }),
];

impl Summary {
    fn index(self) -> usize {
        SUMMARIES.iter().position(|row| row.summary == self).unwrap_or_default()
    }

    /// Its name in JSON, CSV and RON.
    pub fn key(self) -> &'static str {
        SUMMARIES[self.index()].key
    }

    /// Within a sentence.
    pub fn label(self) -> &'static str {
        SUMMARIES[self.index()].label
    }

    /// In the heads of tables.
    pub fn short(self) -> &'static str {
        SUMMARIES[self.index()].short
    }

    /// What it is, after a colon.
    pub fn about(self) -> &'static str {
        SUMMARIES[self.index()].about
    }

    /// Of at least one value; reorders them.
    pub fn of(self, values: &mut [f64]) -> f64 {
        (SUMMARIES[self.index()].value)(&mut Sample::new(values))
    }

    /// Parts of a sample, in order of size, whose values it grows with.
    pub fn ranks(self) -> RangeInclusive<f64> {
        let [first, last] = SUMMARIES[self.index()].ranks;
        first..=last
    }
}

/// Every summary of one sample, in its own unit.
///
/// ```
/// use trackwright_simulation::{Statistics, Summary};
/// let statistics = Statistics::of(&mut [4.0, 1.0, 3.0, 2.0]).unwrap();
/// assert_eq!(statistics.mean(), 2.5);
/// assert_eq!(statistics.get(Summary::Max), 4.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics([f64; SUMMARIES.len()]);

impl Statistics {
    /// The figures of the values, which are reordered; `None` without any.
    ///
    /// Sums run in the order given, so the same values in the same order give the same bits.
    /// Percentiles interpolate linearly between order statistics, at `(n - 1) p`. One value that
    /// is not a number makes all figures that.
    pub fn of(values: &mut [f64]) -> Option<Self> {
        if values.is_empty() {
            return None;
        }
        if values.iter().any(|v| v.is_nan()) {
            return Some(Self([f64::NAN; SUMMARIES.len()]));
        }
        let mut sample = Sample::new(values);
        Some(Self(std::array::from_fn(|k| (SUMMARIES[k].value)(&mut sample))))
    }

    /// One of them.
    pub fn get(&self, summary: Summary) -> f64 {
        self.0[summary.index()]
    }

    /// The same with another value of one of them.
    #[must_use]
    pub fn with(mut self, summary: Summary, value: f64) -> Self {
        self.0[summary.index()] = value;
        self
    }

    /// All of them, in the order of files.
    pub fn values(&self) -> impl Iterator<Item = (Summary, f64)> {
        SUMMARIES.iter().map(|row| row.summary).zip(self.0)
    }

    /// Root of the mean square.
    pub fn rms(&self) -> f64 {
        self.get(Summary::Rms)
    }

    /// Arithmetic mean.
    pub fn mean(&self) -> f64 {
        self.get(Summary::Mean)
    }

    /// Median.
    pub fn median(&self) -> f64 {
        self.get(Summary::Median)
    }

    /// 95th percentile.
    pub fn p95(&self) -> f64 {
        self.get(Summary::P95)
    }

    /// Smallest value.
    pub fn min(&self) -> f64 {
        self.get(Summary::Min)
    }

    /// Largest value.
    pub fn max(&self) -> f64 {
        self.get(Summary::Max)
    }
}

impl Serialize for Statistics {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_struct("Statistics", self.0.len())?;
        for (row, value) in SUMMARIES.iter().zip(&self.0) {
            out.serialize_field(row.key, value)?;
        }
        out.end()
    }
}

/// A figure of a study: tip error RMS, angle error max, ….
///
/// ```
/// use trackwright_simulation::Metric;
/// assert_eq!(Metric::TIP_RMS.label(), "tip error RMS");
/// assert_eq!(Metric::TIP_RMS.name(), "position_rms");
/// assert_eq!(Metric::ANGLE_MAX.unit(), "°");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Metric {
    pub of: ErrorOf,
    pub summary: Summary,
}

/// Where a result panel shows a figure.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Panel {
    Hidden,
    Full,
    /// Even where there is little room.
    Brief,
}

/// What a figure is called and where it is shown.
#[derive(Clone, Copy)]
struct Row {
    metric: Metric,
    /// In requirements and column names.
    name: &'static str,
    label: &'static str,
    /// Its place among the printed figures of its error.
    printed: u8,
    panel: Panel,
    /// Shown large at the head of a report.
    is_large: bool,
    /// Whether a decision keeps it.
    is_decided: bool,
    /// Where a requirement can bound it: what the window sets the bound to first.
    bound: Option<f64>,
}

const fn row(metric: Metric, [name, label]: [&'static str; 2], printed: u8) -> Row {
    let (panel, bound) = (Panel::Hidden, None);
    Row { metric, name, label, printed, panel, is_large: false, is_decided: false, bound }
}

impl Row {
    const fn panel(self, panel: Panel) -> Self {
        Self { panel, ..self }
    }

    const fn large(self) -> Self {
        Self { is_large: true, ..self }
    }

    const fn decided(self) -> Self {
        Self { is_decided: true, ..self }
    }

    const fn bound(self, first: f64) -> Self {
        Self { bound: Some(first), ..self }
    }
}

/// In the order of files: tip before angle.
const TABLE: &[Row] = {
    use Panel::{Brief, Full};
    &[
        row(Metric::TIP_RMS, ["position_rms", "tip error RMS"], 0)
            .panel(Brief)
            .large()
            .decided()
            .bound(1.0),
        row(Metric::tip(Summary::Mean), ["position_mean", "tip error mean"], 1)
            .panel(Full)
            .decided(),
        row(Metric::tip(Summary::Std), ["position_std", "tip error std"], 6),
        row(Metric::tip(Summary::Min), ["position_min", "tip error min"], 5),
        row(Metric::tip(Summary::Median), ["position_median", "tip error median"], 2),
        row(Metric::TIP_P95, ["position_p95", "tip error 95th percentile"], 3)
            .panel(Full)
            .large()
            .decided()
            .bound(1.5),
        row(Metric::TIP_MAX, ["position_max", "tip error max"], 4)
            .panel(Brief)
            .large()
            .decided()
            .bound(2.0),
        row(Metric::ANGLE_RMS, ["angle_rms", "angle error RMS"], 0)
            .panel(Brief)
            .large()
            .decided()
            .bound(0.5),
        row(Metric::angle(Summary::Mean), ["angle_mean", "angle error mean"], 1).panel(Full),
        row(Metric::angle(Summary::Std), ["angle_std", "angle error std"], 6),
        row(Metric::angle(Summary::Min), ["angle_min", "angle error min"], 5),
        row(Metric::angle(Summary::Median), ["angle_median", "angle error median"], 2),
        row(Metric::angle(Summary::P95), ["angle_p95", "angle error 95th percentile"], 3)
            .panel(Full)
            .decided(),
        row(Metric::ANGLE_MAX, ["angle_max", "angle error max"], 4)
            .panel(Brief)
            .decided()
            .bound(1.0),
    ]
};

/// Number of figures.
pub const COUNT: usize = TABLE.len();

/// Every figure, in the order of files: tip before angle.
pub const METRICS: [Metric; COUNT] = {
    let mut metrics = [Metric::TIP_RMS; COUNT];
    let mut k = 0;
    while k < COUNT {
        metrics[k] = TABLE[k].metric;
        k += 1;
    }
    metrics
};

/// A value of each of [`METRICS`], mm and degrees.
pub type MetricValues = [f64; COUNT];

impl Metric {
    pub const TIP_RMS: Self = Self::tip(Summary::Rms);
    pub const TIP_MEDIAN: Self = Self::tip(Summary::Median);
    pub const TIP_P95: Self = Self::tip(Summary::P95);
    pub const TIP_MAX: Self = Self::tip(Summary::Max);
    pub const ANGLE_RMS: Self = Self::angle(Summary::Rms);
    pub const ANGLE_MEDIAN: Self = Self::angle(Summary::Median);
    pub const ANGLE_MAX: Self = Self::angle(Summary::Max);

    const fn tip(summary: Summary) -> Self {
        Self { of: ErrorOf::Position, summary }
    }

    const fn angle(summary: Summary) -> Self {
        Self { of: ErrorOf::Angle, summary }
    }

    /// Its place in [`METRICS`].
    pub fn index(self) -> usize {
        METRICS.iter().position(|metric| *metric == self).unwrap_or_default()
    }

    fn row(self) -> Row {
        TABLE[self.index()]
    }

    /// Those that a requirement can bound, which are shown where there is no room for all.
    pub fn bounded() -> impl Iterator<Item = Self> + Clone {
        TABLE.iter().filter(|row| row.bound.is_some()).map(|row| row.metric)
    }

    /// Those that a decision keeps.
    pub fn decided() -> impl Iterator<Item = Self> + Clone {
        TABLE.iter().filter(|row| row.is_decided).map(|row| row.metric)
    }

    /// All, in the order in which they are printed.
    pub fn printed() -> impl Iterator<Item = Self> {
        let mut rows = TABLE.to_vec();
        rows.sort_by_key(|row| (row.metric.of == ErrorOf::Angle, row.printed));
        rows.into_iter().map(|row| row.metric)
    }

    /// The one of this name.
    pub fn named(name: &str) -> Option<Self> {
        TABLE.iter().find(|row| row.name == name).map(|row| row.metric)
    }

    /// Its name in requirements and column names.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// For a person.
    pub fn label(self) -> &'static str {
        self.row().label
    }

    /// What it is, in a sentence: for whoever rests the pointer on it.
    pub fn about(self) -> String {
        format!("{}: {}", self.of.about(), self.summary.about())
    }

    /// For the head of a column: `tip RMS`, `angle 95 %`.
    pub fn short_label(self) -> String {
        let of = match self.of {
            ErrorOf::Position => "tip",
            ErrorOf::Angle => "angle",
        };
        format!("{of} {}", self.summary.short())
    }

    /// `mm` or `°`.
    pub fn unit(self) -> &'static str {
        self.of.unit()
    }

    /// Whether it depends on one pose alone, so that further poses can only push it further.
    pub fn is_extreme(self) -> bool {
        matches!(self.summary, Summary::Min | Summary::Max)
    }

    /// Whether a result panel shows it.
    pub fn is_shown(self) -> bool {
        self.row().panel >= Panel::Full
    }

    /// Whether a result panel shows it even where there is little room.
    pub fn is_brief(self) -> bool {
        self.row().panel == Panel::Brief
    }

    /// Whether a report shows it large.
    pub fn is_large(self) -> bool {
        self.row().is_large
    }

    /// The bound that is set first where none is; `None` where a requirement cannot bound it.
    pub fn first_bound(self) -> Option<f64> {
        self.row().bound
    }

    /// Its value in a study, mm or degrees.
    pub fn of_study(self, position_mm: &Statistics, angle_deg: &Statistics) -> f64 {
        match self.of {
            ErrorOf::Position => position_mm.get(self.summary),
            ErrorOf::Angle => angle_deg.get(self.summary),
        }
    }
}

impl Serialize for Metric {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// All figures of one study.
pub fn values(position_mm: &Statistics, angle_deg: &Statistics) -> MetricValues {
    METRICS.map(|metric| metric.of_study(position_mm, angle_deg))
}

/// The figures of pairs of tip error in mm and angle error in degrees; `None` without any.
pub fn values_of_errors(errors: impl Iterator<Item = [f64; 2]>) -> Option<MetricValues> {
    let (mut tip_mm, mut angle_deg): (Vec<f64>, Vec<f64>) =
        errors.map(|[tip, angle]| (tip, angle)).unzip();
    Some(values(&Statistics::of(&mut tip_mm)?, &Statistics::of(&mut angle_deg)?))
}

/// The figures of trials of which some are spread over all: extremes are of all, the others of those.
pub fn values_of_spread(
    spread: impl Iterator<Item = [f64; 2]>,
    all: impl Iterator<Item = [f64; 2]>,
) -> Option<MetricValues> {
    let (of_spread, of_all) = (values_of_errors(spread)?, values_of_errors(all)?);
    let value = |k: usize| if METRICS[k].is_extreme() { of_all[k] } else { of_spread[k] };
    Some(std::array::from_fn(value))
}

/// Values of some figures, mm and degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MetricMap([Option<f64>; COUNT]);

impl MetricMap {
    /// The value of a figure, where it has one.
    pub fn get(&self, metric: Metric) -> Option<f64> {
        self.0[metric.index()]
    }

    /// Sets or removes a value.
    pub fn set(&mut self, metric: Metric, value: Option<f64>) {
        self.0[metric.index()] = value;
    }

    /// What has a value, in the order of [`METRICS`].
    pub fn iter(&self) -> impl Iterator<Item = (Metric, f64)> + Clone {
        METRICS.into_iter().zip(self.0).filter_map(|(metric, value)| Some((metric, value?)))
    }

    /// Reads a struct whose fields are figures, by these names; a field may be absent or `None`.
    ///
    /// # Errors
    /// A field of another name, one that is there twice, and those of the deserialiser.
    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
        name: &'static str,
        fields: &'static MetricFields,
    ) -> Result<Self, D::Error> {
        deserializer.deserialize_struct(name, &fields.keys, FieldsVisitor(fields))
    }
}

impl<const N: usize> From<[(Metric, f64); N]> for MetricMap {
    fn from(values: [(Metric, f64); N]) -> Self {
        values.into_iter().collect()
    }
}

impl FromIterator<(Metric, f64)> for MetricMap {
    fn from_iter<T: IntoIterator<Item = (Metric, f64)>>(values: T) -> Self {
        let mut map = Self::default();
        for (metric, value) in values {
            map.set(metric, Some(value));
        }
        map
    }
}

/// The fields of a struct in a file that are figures.
pub struct MetricFields {
    metrics: Vec<Metric>,
    keys: Vec<&'static str>,
}

impl MetricFields {
    /// Figures and their names in the file.
    pub fn new(fields: impl Iterator<Item = (Metric, &'static str)>) -> Self {
        let (metrics, keys) = fields.unzip();
        Self { metrics, keys }
    }

    /// The figures.
    pub fn metrics(&self) -> &[Metric] {
        &self.metrics
    }
}

struct FieldsVisitor(&'static MetricFields);

impl<'de> Visitor<'de> for FieldsVisitor {
    type Value = MetricMap;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("figures by their names")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<MetricMap, A::Error> {
        let mut seen = MetricMap::default();
        let mut found = MetricMap::default();
        while let Some(field) = map.next_key_seed(FieldSeed(self.0))? {
            let metric = self.0.metrics[field];
            if seen.get(metric).is_some() {
                return Err(de::Error::duplicate_field(self.0.keys[field]));
            }
            seen.set(metric, Some(0.0));
            found.set(metric, map.next_value()?);
        }
        Ok(found)
    }
}

struct FieldSeed(&'static MetricFields);

impl<'de> DeserializeSeed<'de> for FieldSeed {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl Visitor<'_> for FieldSeed {
    type Value = usize;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a figure")
    }

    fn visit_str<E: de::Error>(self, key: &str) -> Result<usize, E> {
        let found = self.0.keys.iter().position(|known| *known == key);
        found.ok_or_else(|| de::Error::unknown_field(key, &self.0.keys))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_is_explained_in_a_sentence() {
        for metric in METRICS {
            let about = metric.about();
            assert!(about.split_whitespace().count() >= 8, "{about}");
            let others = METRICS.into_iter().filter(|other| other.about() == about);
            assert_eq!(others.count(), 1, "{about}");
        }
    }

    #[test]
    fn every_figure_has_its_own_names() {
        for (k, metric) in METRICS.into_iter().enumerate() {
            assert_eq!(metric.index(), k);
            assert_eq!(Metric::named(metric.name()), Some(metric));
            assert_eq!(metric.name(), format!("{}_{}", metric.of.key(), metric.summary.key()));
            assert!(!metric.is_brief() || metric.is_shown());
            assert!(metric.first_bound().is_none() || Metric::decided().any(|m| m == metric));
        }
        let printed: Vec<Metric> = Metric::printed().collect();
        assert!(METRICS.iter().all(|metric| printed.contains(metric)));
        let labels: std::collections::HashSet<_> = METRICS.iter().map(|m| m.label()).collect();
        assert_eq!((labels.len(), printed.len()), (COUNT, COUNT));
    }

    #[test]
    fn figures_of_one_to_four_are_the_textbook_ones() {
        let s = Statistics::of(&mut [4.0, 1.0, 3.0, 2.0]).unwrap();
        assert_eq!((s.mean(), s.get(Summary::Min), s.max(), s.median()), (2.5, 1.0, 4.0, 2.5));
        assert!((s.rms() - 7.5_f64.sqrt()).abs() < 1e-15);
        assert!((s.get(Summary::Std) - 1.25_f64.sqrt()).abs() < 1e-15);
        assert!((s.p95() - 3.85).abs() < 1e-15);
    }

    #[test]
    fn one_value_equal_values_and_none() {
        let s = Statistics::of(&mut [2.0]).unwrap();
        assert_eq!((s.rms(), s.get(Summary::Std), s.median(), s.p95()), (2.0, 0.0, 2.0, 2.0));
        let s = Statistics::of(&mut [1.0, f64::NAN, 2.0]).unwrap();
        assert!(s.values().all(|(_, value)| value.is_nan()));
        let s = Statistics::of(&mut [0.1; 1000]).unwrap();
        assert_eq!((s.mean(), s.get(Summary::Std)), (0.1, 0.0));
        assert!(Statistics::of(&mut []).is_none());
    }
}
