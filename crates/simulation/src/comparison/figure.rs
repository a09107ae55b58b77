//! The figures that designs are compared by, under the names that files and tables give them.

use crate::statistics::Statistics;

/// What an error is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorOf {
    /// The tip, mm.
    Position,
    /// The tool's rotation, degrees.
    Angle,
}

/// One number of [`Statistics`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Summary {
    Rms,
    Mean,
    Std,
    Min,
    Median,
    P95,
    Max,
}

/// One figure of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Figure {
    pub of: ErrorOf,
    pub summary: Summary,
}

/// All that are compared, tip before angle.
pub const FIGURES: [Figure; 14] = {
    use ErrorOf::{Angle, Position};
    use Summary::{Max, Mean, Median, Min, P95, Rms, Std};
    [
        Figure::new(Position, Rms),
        Figure::new(Position, Mean),
        Figure::new(Position, Std),
        Figure::new(Position, Min),
        Figure::new(Position, Median),
        Figure::new(Position, P95),
        Figure::new(Position, Max),
        Figure::new(Angle, Rms),
        Figure::new(Angle, Mean),
        Figure::new(Angle, Std),
        Figure::new(Angle, Min),
        Figure::new(Angle, Median),
        Figure::new(Angle, P95),
        Figure::new(Angle, Max),
    ]
};

/// Those that a requirement can be about, which are told where there is no room for all.
pub const REQUIRED: [Figure; 5] = {
    use ErrorOf::{Angle, Position};
    use Summary::{Max, P95, Rms};
    [
        Figure::new(Position, Rms),
        Figure::new(Position, P95),
        Figure::new(Position, Max),
        Figure::new(Angle, Rms),
        Figure::new(Angle, Max),
    ]
};

/// A value of each of [`FIGURES`], mm and degrees.
pub type FigureValues = [f64; FIGURES.len()];

impl Figure {
    const fn new(of: ErrorOf, summary: Summary) -> Self {
        Self { of, summary }
    }

    /// Its name in JSON and CSV, under `position_mm` or `angle_deg`.
    pub fn name(self) -> &'static str {
        match self.summary {
            Summary::Rms => "rms",
            Summary::Mean => "mean",
            Summary::Std => "std",
            Summary::Min => "min",
            Summary::Median => "median",
            Summary::P95 => "p95",
            Summary::Max => "max",
        }
    }

    /// For a person.
    pub fn label(self) -> &'static str {
        match (self.of, self.summary) {
            (ErrorOf::Position, Summary::Rms) => "tip error RMS",
            (ErrorOf::Position, Summary::Mean) => "tip error mean",
            (ErrorOf::Position, Summary::Std) => "tip error std",
            (ErrorOf::Position, Summary::Min) => "tip error min",
            (ErrorOf::Position, Summary::Median) => "tip error median",
            (ErrorOf::Position, Summary::P95) => "tip error 95th percentile",
            (ErrorOf::Position, Summary::Max) => "tip error max",
            (ErrorOf::Angle, Summary::Rms) => "angle error RMS",
            (ErrorOf::Angle, Summary::Mean) => "angle error mean",
            (ErrorOf::Angle, Summary::Std) => "angle error std",
            (ErrorOf::Angle, Summary::Min) => "angle error min",
            (ErrorOf::Angle, Summary::Median) => "angle error median",
            (ErrorOf::Angle, Summary::P95) => "angle error 95th percentile",
            (ErrorOf::Angle, Summary::Max) => "angle error max",
        }
    }

    pub fn unit(self) -> &'static str {
        match self.of {
            ErrorOf::Position => "mm",
            ErrorOf::Angle => "°",
        }
    }

    /// Whether it depends on one pose alone, so that a finer look can only push it further.
    pub fn is_extreme(self) -> bool {
        matches!(self.summary, Summary::Min | Summary::Max)
    }

    pub fn is_max(self) -> bool {
        self.summary == Summary::Max
    }

    /// Its value in a study, mm or degrees.
    pub fn of_study(self, position_mm: &Statistics, angle_deg: &Statistics) -> f64 {
        let of = match self.of {
            ErrorOf::Position => position_mm,
            ErrorOf::Angle => angle_deg,
        };
        match self.summary {
            Summary::Rms => of.rms,
            Summary::Mean => of.mean,
            Summary::Std => of.std,
            Summary::Min => of.min,
            Summary::Median => of.median,
            Summary::P95 => of.p95,
            Summary::Max => of.max,
        }
    }
}

/// All figures of one study.
pub fn values(position_mm: &Statistics, angle_deg: &Statistics) -> FigureValues {
    FIGURES.map(|figure| figure.of_study(position_mm, angle_deg))
}
