//! Charts as SVG: a few series over labelled, perhaps logarithmic axes.

mod draw;
pub(crate) mod label;
pub(crate) mod svg;
mod ticks;

pub use ticks::nice_step;

/// One set of points with a name in the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    pub name: String,
    /// In the axes' units; points that an axis cannot hold are left out, and counted in a note.
    pub points: Vec<(f64, f64)>,
    pub style: SeriesStyle,
}

impl Series {
    /// A series of points.
    pub fn new(name: impl Into<String>, style: SeriesStyle, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points, style }
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeriesStyle {
    /// Points joined in order.
    Line,
    /// Points alone.
    Points,
    /// A few points that stand out, a choice or a default: ringed, with the series' name beside
    /// each and none in the legend.
    Marked,
    /// The border of what can be had: steps that keep a point's y until the next one's x, behind
    /// everything else.
    Front,
    /// Bars upwards: each pair of points is the ends of one.
    Intervals,
    /// A level that is not to be passed: a line across the whole chart at the y of its first point.
    Bound,
}

/// Whether equal distances on an axis are equal differences or equal ratios.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    Linear,
    Logarithmic,
    /// Logarithmic, with a lane of its own at the beginning for what is exactly zero.
    LogarithmicAndZero,
}

impl Scale {
    /// Whether an axis of this scale has a place for a value.
    fn holds(self, value: f64) -> bool {
        // Beyond 1e300 differences overflow, and nothing in millimetres or seconds is so large.
        match self {
            Self::Linear => value.abs() <= 1e300,
            Self::Logarithmic => value.is_finite() && value > 0.0,
            Self::LogarithmicAndZero => value.is_finite() && value >= 0.0,
        }
    }
}

/// One axis: what it shows, with its unit, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    pub label: String,
    pub scale: Scale,
}

impl Axis {
    /// An axis on which equal distances are equal differences.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear }
    }
}

/// A chart, ready to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
}

impl Chart {
    /// The chart as an SVG document of a size in pixels, on white.
    pub fn to_svg(&self, size: (u32, u32)) -> String {
        draw::svg(self, size)
    }

    fn holds(&self, (x, y): (f64, f64)) -> bool {
        self.x.scale.holds(x) && self.y.scale.holds(y)
    }

    /// What a reader has to know about points that are not there.
    fn notes(&self) -> Vec<String> {
        let all: usize = self.series.iter().map(|s| s.points.len()).sum();
        let missing =
            self.series.iter().flat_map(|s| &s.points).filter(|&&p| !self.holds(p)).count();
        match (all, missing) {
            (0, _) => vec!["No points to show.".to_owned()],
            (_, 0) => Vec::new(),
            (all, missing) => {
                let (noun, verb) = if missing == 1 { ("point", "is") } else { ("points", "are") };
                let scales = [self.x.scale, self.y.scale];
                let why = if scales.contains(&Scale::Logarithmic) {
                    "zero, negative or not finite on a logarithmic axis"
                } else if scales.contains(&Scale::LogarithmicAndZero) {
                    "negative or not finite on a logarithmic axis"
                } else {
                    "not finite"
                };
                vec![format!("{missing} {noun} of {all} {verb} not shown: {why}.")]
            }
        }
    }
}

#[cfg(test)]
mod tests;
