//! Which recording of the built tool is meant, and how it is to be taken: what is kept to look at it
//! again.

use super::{AgreementSettings, Unknowns};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Tables of true and measured poses, and what they do not state about themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct BuiltRecording {
    /// The tool's table; a file as written in a design, relative to it.
    pub table: String,
    /// The CRF's, with a row for every row of the tool's.
    pub crf_table: Option<String>,
    pub frame: RecordedFrame,
    /// The true poses were registered to this very recording.
    pub is_registered: bool,
    /// Readings that each pose is the mean of.
    pub averaged: u32,
    /// Standard deviation of the true tip, an axis.
    pub truth_std_mm: f64,
    /// A part of the name of what the tracker takes for the whole tool, where a table has several.
    pub whole: Option<String>,
}

/// The frame of a table's poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum RecordedFrame {
    #[default]
    Tracker,
    /// The CRF's, which is at rest where the design has it.
    Crf,
}

impl BuiltRecording {
    /// A table in the tracker's frame whose truth was known beforehand.
    pub fn of(table: String) -> Self {
        Self {
            table,
            crf_table: None,
            frame: RecordedFrame::Tracker,
            is_registered: false,
            averaged: 1,
            truth_std_mm: 0.0,
            whole: None,
        }
    }

    /// Its tables' files.
    pub fn references_mut(&mut self) -> impl Iterator<Item = &mut String> {
        [&mut self.table].into_iter().chain(&mut self.crf_table)
    }

    /// How its rows are judged; what is not kept is as `verify` has it by default.
    pub fn settings(&self) -> AgreementSettings {
        AgreementSettings {
            unknowns: match self.is_registered {
                true => Unknowns::Registration,
                false => Unknowns::None,
            },
            averaged: f64::from(self.averaged),
            truth_std_mm: self.truth_std_mm,
            ..AgreementSettings::default()
        }
    }
}

impl fmt::Display for BuiltRecording {
    /// The files, and what differs from the default.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.table)?;
        if let Some(whole) = &self.whole {
            write!(f, " ({whole})")?;
        }
        if let Some(crf) = &self.crf_table {
            write!(f, " with {crf}")?;
        }
        if self.frame == RecordedFrame::Crf {
            f.write_str(", in the CRF's frame")?;
        }
        if self.is_registered {
            f.write_str(", registered to these poses")?;
        }
        if self.averaged != 1 {
            write!(f, ", means of {} readings", self.averaged)?;
        }
        if self.truth_std_mm > 0.0 {
            write!(f, ", true to {} mm", self.truth_std_mm)?;
        }
        Ok(())
    }
}
