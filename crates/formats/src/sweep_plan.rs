//! Plans of sweeps, `*.sweep.ron`: which designs are simulated, in which rooms, over which motions.

use super::error::FormatError;
use super::number_path::NumberPath;
use super::ron_text::{self, RonWriter, Version};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use trackwright_field::OutsidePolicy;
use trackwright_simulation::motion::Motion;
use trackwright_simulation::{METRICS, Metric};

/// Most rows of a sweep: with a millisecond each, six days of two cores.
pub const MAX_ROWS: f64 = 1e9;

/// Most numbers that vary.
pub const MAX_PARAMETERS: usize = 64;

/// How long a shard takes where a plan does not state it.
const SHARD_SECONDS: f64 = 60.0;

/// What a sweep computes.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPlan {
    /// What its files are relative to; the plan's own folder where it is left out. No row depends on it.
    pub folder: Option<String>,
    /// Files, or names of built-in designs.
    pub designs: Vec<String>,
    /// Files of rooms, or names of built-in ones; none of them leaves each design in its own.
    pub rooms: Vec<String>,
    /// Numbers of the designs that vary; every point of each group with every point of the others.
    pub vary: Vec<Variation>,
    pub motions: Vec<SweepMotion>,
    pub figures: Vec<Metric>,
    /// Whether each figure is that which is to be expected, with its 95 % interval and the verdict: some
    /// tens of milliseconds a row.
    pub expected: bool,
    /// Whether each figure of the room's model alone, the paper's simulation, is given as well.
    pub room_field: bool,
    pub outside: OutsidePolicy,
    /// Of samples.
    pub seed: u64,
    /// How long it is computed before a shard is written.
    pub shard_seconds: f64,
}

/// Numbers that vary together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Variation {
    /// Every value of each with every value of the others, the last fastest.
    Grid(Vec<GridAxis>),
    /// The first points of a Sobol sequence, shifted by the seed.
    Sobol { count: u64, ranges: Vec<SampledRange> },
    /// One point in each of `count` equal parts of every range.
    LatinHypercube { count: u64, ranges: Vec<SampledRange> },
}

/// A number and its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridAxis {
    pub path: NumberPath,
    pub values: Values,
}

/// A number and the range that its samples are in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampledRange {
    pub path: NumberPath,
    pub from: f64,
    pub to: f64,
}

/// Values of one number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Values {
    List(Vec<f64>),
    /// Evenly spaced, both ends among them.
    Range {
        from: f64,
        to: f64,
        count: u64,
    },
}

/// Poses that each design is simulated at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum SweepMotion {
    /// The design's own pose.
    Single,
    /// The design's own range of motion.
    Motion,
    /// A range of motion for all designs.
    Range(Motion),
    /// Poses of a file.
    Input(String),
}

impl Values {
    pub fn count(&self) -> u64 {
        match self {
            Self::List(values) => values.len() as u64,
            Self::Range { count, .. } => *count,
        }
    }

    /// One of them, from 0.
    pub fn get(&self, index: u64) -> f64 {
        match self {
            Self::List(values) => values[index as usize],
            Self::Range { from, count: 1, .. } => *from,
            // Both ends exactly.
            Self::Range { from, to, count } => {
                let part = index as f64 / (count - 1) as f64;
                from * (1.0 - part) + to * part
            }
        }
    }

    fn are_finite(&self) -> bool {
        match self {
            Self::List(values) => values.iter().all(|value| value.is_finite()),
            Self::Range { from, to, .. } => from.is_finite() && to.is_finite(),
        }
    }
}

impl Variation {
    /// Number of its points, which may be more than a sweep can have.
    pub fn count(&self) -> f64 {
        match self {
            Self::Grid(axes) => axes.iter().map(|axis| axis.values.count() as f64).product(),
            Self::Sobol { count, .. } | Self::LatinHypercube { count, .. } => *count as f64,
        }
    }

    /// The numbers that vary.
    pub fn paths(&self) -> Vec<&NumberPath> {
        match self {
            Self::Grid(axes) => axes.iter().map(|axis| &axis.path).collect(),
            Self::Sobol { ranges, .. } | Self::LatinHypercube { ranges, .. } => {
                ranges.iter().map(|range| &range.path).collect()
            }
        }
    }

    fn check(&self, index: usize) -> Result<(), FormatError> {
        let problem = |found: &str, expected| {
            Err(FormatError::field(format!("vary[{index}]"), found, expected))
        };
        if self.paths().is_empty() {
            return problem("empty", "at least one number");
        }
        if self.count() < 1.0 {
            return problem("without a value", "at least one value of each number");
        }
        let are_finite = match self {
            Self::Grid(axes) => axes.iter().all(|axis| axis.values.are_finite()),
            Self::Sobol { ranges, .. } | Self::LatinHypercube { ranges, .. } => {
                ranges.iter().all(|range| range.from.is_finite() && range.to.is_finite())
            }
        };
        if are_finite { Ok(()) } else { problem("not finite", "finite numbers") }
    }
}

impl SweepPlan {
    /// Number of rows.
    pub fn rows(&self) -> f64 {
        let rooms = self.rooms.len().max(1) as f64;
        let points: f64 = self.vary.iter().map(Variation::count).product();
        self.designs.len() as f64 * points * rooms * self.motions.len() as f64
    }

    /// The numbers that vary, in the order of the plan.
    pub fn paths(&self) -> impl Iterator<Item = &NumberPath> {
        self.vary.iter().flat_map(Variation::paths)
    }

    fn check(&self) -> Result<(), FormatError> {
        let empty = |field: &str| Err(FormatError::field(field, "empty", "at least one"));
        if self.designs.is_empty() {
            return empty("designs");
        }
        if self.motions.is_empty() {
            return empty("motions");
        }
        if self.figures.is_empty() {
            return empty("figures");
        }
        once("designs", &self.designs)?;
        once("rooms", &self.rooms)?;
        once("figures", &self.figures.iter().map(|metric| metric.name()).collect::<Vec<_>>())?;
        for (index, variation) in self.vary.iter().enumerate() {
            variation.check(index)?;
        }
        let paths: Vec<String> = self.paths().map(ToString::to_string).collect();
        once("vary", &paths)?;
        if paths.len() > MAX_PARAMETERS {
            let found = format!("{} numbers", paths.len());
            return Err(FormatError::field("vary", found, "at most 64"));
        }
        for motion in &self.motions {
            if let SweepMotion::Range(motion) = motion {
                motion
                    .trials()
                    .map_err(|cause| FormatError::Motion { prefix: "motions: ", cause })?;
            }
        }
        if !self.expected && !self.room_field {
            let expected = "true where expected is false: one of them at least";
            return Err(FormatError::field("room_field", "false", expected));
        }
        if !(0.1..=86_400.0).contains(&self.shard_seconds) {
            let expected = "from 0.1 to 86400 seconds";
            return Err(FormatError::number("shard_seconds", self.shard_seconds, expected));
        }
        let rows = self.rows();
        if rows > MAX_ROWS {
            let expected = "at most 1e9: fewer values, or samples in place of a grid";
            return Err(FormatError::field("the number of rows", format!("{rows:e}"), expected));
        }
        Ok(())
    }
}

/// Whether no text of a list is empty or in it twice.
fn once(field: &str, all: &[impl AsRef<str>]) -> Result<(), FormatError> {
    for (index, text) in all.iter().map(AsRef::as_ref).enumerate() {
        let is_again = all[..index].iter().any(|other| other.as_ref() == text);
        if text.is_empty() || is_again {
            let found = if is_again { format!("{text:?} again") } else { "empty".to_owned() };
            return Err(FormatError::field(format!("{field}[{index}]"), found, "each once"));
        }
    }
    Ok(())
}

#[derive(Deserialize)]
#[serde(rename = "Sweep", deny_unknown_fields)]
struct PlanEntry {
    #[serde(rename = "version")]
    _version: Version,
    folder: Option<String>,
    designs: Vec<String>,
    #[serde(default)]
    rooms: Vec<String>,
    #[serde(default)]
    vary: Vec<Variation>,
    motions: Option<Vec<SweepMotion>>,
    figures: Option<Vec<FigureEntry>>,
    expected: Option<bool>,
    room_field: Option<bool>,
    #[serde(default)]
    outside: OutsideEntry,
    #[serde(default)]
    seed: u64,
    shard_seconds: Option<f64>,
}

struct FigureEntry(Metric);

impl<'de> Deserialize<'de> for FigureEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        let metric = Metric::named(&name);
        metric.map(Self).ok_or_else(|| {
            let known: Vec<&str> = METRICS.iter().map(|metric| metric.name()).collect();
            D::Error::custom(format!("found {name:?}, expected one of {}", known.join(", ")))
        })
    }
}

#[derive(Clone, Copy, Default, Deserialize)]
enum OutsideEntry {
    #[default]
    Clamp,
    Extrapolate,
    Reject,
}

/// Reads a plan.
///
/// ```
/// use trackwright_formats::sweep_plan;
///
/// let plan = sweep_plan::parse(br#"(
///     version: 1,
///     designs: ["pointer-on-head"],
///     vary: [Grid([(path: "tool.body.sensors[0].position.z", values: Range(from: -60, to: -20, count: 9))])],
///     figures: ["position_rms"],
/// )"#)?;
/// assert_eq!(plan.rows(), 9.0);
/// # Ok::<(), trackwright_formats::FormatError>(())
/// ```
///
/// # Errors
/// Anything that leaves a doubt about what the rows are; see [`FormatError`].
pub fn parse(bytes: &[u8]) -> Result<SweepPlan, FormatError> {
    let entry: PlanEntry = ron_text::parse(bytes)?;
    let figures = match entry.figures {
        Some(figures) => figures.into_iter().map(|FigureEntry(metric)| metric).collect(),
        None => Metric::decided().collect(),
    };
    let plan = SweepPlan {
        folder: entry.folder,
        designs: entry.designs,
        rooms: entry.rooms,
        vary: entry.vary,
        motions: entry.motions.unwrap_or_else(|| vec![SweepMotion::Motion]),
        figures,
        expected: entry.expected.unwrap_or(true),
        room_field: entry.room_field.unwrap_or(entry.expected == Some(false)),
        outside: match entry.outside {
            OutsideEntry::Clamp => OutsidePolicy::Clamp,
            OutsideEntry::Extrapolate => OutsidePolicy::Extrapolate,
            OutsideEntry::Reject => OutsidePolicy::Reject,
        },
        seed: entry.seed,
        shard_seconds: entry.shard_seconds.unwrap_or(SHARD_SECONDS),
    };
    plan.check()?;
    Ok(plan)
}

/// Writes a plan, each field that has a default with its value.
pub fn write(plan: &SweepPlan) -> String {
    RonWriter::file(|out| {
        out.optional_string("folder", plan.folder.as_deref());
        out.value("designs", &plan.designs, 1);
        out.value("rooms", &plan.rooms, 1);
        out.value("vary", &plan.vary, 3);
        out.value("motions", &plan.motions, 1);
        out.value("figures", &plan.figures, 1);
        out.field("expected", plan.expected);
        out.field("room_field", plan.room_field);
        out.plain("outside", plan.outside);
        out.field("seed", plan.seed);
        out.plain("shard_seconds", plan.shard_seconds);
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::test_cases::assert_refused;

    pub const PLAN: &str = r#"(
        version: 1,
        folder: "/data/designs",
        designs: ["a.design.ron", "pointer-on-head"],
        rooms: ["b.env.ron", "c.env.ron"],
        vary: [
            Grid([
                (path: "tool.body.sensors[0].position.z", values: Range(from: -60, to: -20, count: 5)),
                (path: "orientation_weight", values: List([50, 100])),
            ]),
            LatinHypercube(count: 30, ranges: [(path: "tool.pose.position.x", from: -1, to: 1)]),
        ],
        motions: [Single, Motion, 
            Range((
                pivot: Body((0, 0, 50)),
                x: (min: 0, max: 1, step: 0.5),
                y: (min: 0, max: 1, step: 1),
                z: (min: 0, max: 1, step: 1),
                rx: (min: 0, max: 1, step: 1),
                ry: (min: 0, max: 1, step: 1),
                rz: (min: 0, max: 1, step: 1),
            )),
            Input("poses.csv"),
        ],
        figures: ["position_rms", "angle_max"],
        expected: true,
        room_field: true,
        outside: Reject,
        seed: 7,
        shard_seconds: 30,
    )"#;

    #[test]
    fn a_written_plan_reads_back() {
        let plan = parse(PLAN.as_bytes()).unwrap();
        assert_eq!(plan.rows(), 2.0 * 2.0 * 10.0 * 30.0 * 4.0);
        assert_eq!(parse(write(&plan).as_bytes()).unwrap(), plan);
        let short = parse(b"(version: 1, designs: [\"a.design.ron\"])").unwrap();
        assert_eq!(short.motions, [SweepMotion::Motion]);
        assert_eq!(parse(write(&short).as_bytes()).unwrap(), short);
    }

    #[test]
    fn a_range_has_both_its_ends_exactly() {
        let values = Values::Range { from: 0.1, to: 0.7, count: 7 };
        assert_eq!((values.get(0), values.get(6)), (0.1, 0.7));
        assert!((values.get(3) - 0.4).abs() < 1e-15);
        assert_eq!(Values::Range { from: 3.0, to: 9.0, count: 1 }.get(0), 3.0);
    }

    #[test]
    fn a_plan_that_cannot_be_has_one_clear_error() {
        let cases = r#"
            "a.design.ron" => "" | designs[0] is empty, expected each once
            c.env.ron => b.env.ron | rooms[1] is "b.env.ron" again, expected each once
            angle_max => position_rms
                | figures[1] is "position_rms" again, expected each once
            from: -60 => from: NaN | vary[0] is not finite, expected finite numbers
            List([50, 100]) => List([])
                | vary[0] is without a value, expected at least one value of each number
            count: 30 => count: 0
                | vary[1] is without a value, expected at least one value of each number
            orientation_weight => tool.pose.position.x
                | vary[2] is "tool.pose.position.x" again, expected each once
            shard_seconds: 30 => shard_seconds: 0
                | shard_seconds is 0, expected from 0.1 to 86400 seconds
            count: 30 => count: 12500000000
                | the number of rows is 2e12, expected at most 1e9: fewer values, or samples in
                | place of a grid
            step: 0.5 => step: -1 | motions: motion.x: step is -1, expected zero or more
            angle_max => angel_max | …found "angel_max", expected one of position_rms…
            tool.pose.position.x => tool..x | …is no path, expected one such as…
            seed: 7 => sed: 7 | …sed…
        "#;
        assert_refused(PLAN, cases, |text| parse(text.as_bytes()).unwrap_err().to_string());
    }
}
