//! Rows of delimited text as programs around a tracker write them: cells by their place, numbers that
//! may be missing, a last row that the file may end within.

use crate::error::{FormatError, quoted};
use nalgebra::Vector3;
use std::collections::HashMap;
use trackwright_geometry::number;
use trackwright_geometry::pose::{Pose, pose_from_parts};
use trackwright_simulation::recording::{Recording, ToolTrack, TrackSample, Unusable};

/// How far the length of a recorded quaternion may be from 1: trackers write seven digits, logs four.
const MAX_QUATERNION_OFF: f64 = 1e-2;

/// NDI writes −3.697314e28 where there is no number.
const MISSING_BELOW: f64 = -1e27;

/// States of a sample that the tracker stands by: the combined API's word, and that of ToolBox.
const GOOD: [&str; 2] = ["Enabled", "OK"];

const MISSING: &str = "Missing";

/// Names of a pose's columns in the order of their numbers: scalar first, then mm.
pub(super) const POSE: [&str; 7] = ["Q0", "Qx", "Qy", "Qz", "Tx", "Ty", "Tz"];

/// What may stand between cells.
pub(super) const SEPARATORS: [char; 3] = ['\t', ';', ','];

/// Places of a tool's cells.
pub(super) struct ToolColumns {
    pub frame: Option<usize>,
    pub time: Option<usize>,
    pub state: usize,
    pub pose: [usize; 7],
}

/// One row and where it stands.
pub(super) struct Row<'a> {
    pub line: u64,
    pub cells: Vec<&'a str>,
    pub has_decimal_commas: bool,
    /// The file may end within it, so that its last cell may lack digits.
    pub is_cut: bool,
}

/// The rows behind a header; blank lines are none.
pub(super) fn rows<'a>(
    lines: impl Iterator<Item = (u64, &'a str)>,
    separator: char,
    is_ended: bool,
) -> impl Iterator<Item = Row<'a>> {
    let mut lines = lines.peekable();
    std::iter::from_fn(move || {
        loop {
            let (line, content) = lines.next()?;
            if !content.trim().is_empty() {
                return Some(Row {
                    line,
                    cells: content.split(separator).map(str::trim).collect(),
                    has_decimal_commas: separator != ',',
                    is_cut: !is_ended && lines.peek().is_none(),
                });
            }
        }
    })
}

impl Row<'_> {
    pub(super) fn cell(&self, column: usize) -> Result<&str, FormatError> {
        self.cells.get(column).copied().ok_or_else(|| {
            let found = format!("{} cells", self.cells.len());
            FormatError::line(self.line, found, format!("{} at least", column + 1))
        })
    }

    /// The number of a cell; `None` where nothing was measured.
    pub(super) fn number(&self, column: usize, name: &str) -> Result<Option<f64>, FormatError> {
        let cell = self.cell(column)?;
        if cell.is_empty() {
            return Ok(None);
        }
        let value = match self.has_decimal_commas {
            true => cell.replace(',', ".").parse(),
            false => cell.parse(),
        };
        let value: f64 =
            value.map_err(|_| FormatError::cell(self.line, name, quoted(cell), "a number"))?;
        Ok((value > MISSING_BELOW || value.is_nan()).then_some(value))
    }

    /// The sample of a tool whose cells begin at `first`.
    pub(super) fn sample(
        &self,
        first: usize,
        columns: &ToolColumns,
    ) -> Result<TrackSample, FormatError> {
        let last = columns.pose.iter().copied().fold(columns.state, usize::max);
        if self.is_cut && self.cells.len() <= first + last + 1 {
            return Ok(TrackSample { frame: None, time_s: None, pose: Err(Unusable::Cut) });
        }
        let state = self.cell(first + columns.state)?;
        let mut numbers = [None; 7];
        for ((number, column), name) in numbers.iter_mut().zip(columns.pose).zip(POSE) {
            *number = self.number(first + column, name)?;
        }
        let pose = match numbers {
            _ if state == MISSING => Err(Unusable::Missing),
            // What is missing has a state too, and that is more specific.
            _ if !state.is_empty() && !GOOD.contains(&state) => {
                Err(Unusable::State(state.to_owned()))
            }
            [Some(w), Some(qx), Some(qy), Some(qz), Some(x), Some(y), Some(z)] => {
                pose([x, y, z], [w, qx, qy, qz])
            }
            _ => Err(Unusable::Missing),
        };
        let counted = |column: Option<usize>, name| {
            column.map_or(Ok(None), |column| self.number(first + column, name))
        };
        let frame = counted(columns.frame, "Frame")?;
        Ok(TrackSample {
            // A counter of 32 bits, exact in a double.
            frame: frame.filter(|frame| *frame >= 0.0).map(|frame| frame as u64),
            time_s: counted(columns.time, "Time")?,
            pose,
        })
    }
}

/// Tracks of tools, in the order in which they turn up.
#[derive(Default)]
pub(super) struct Tools {
    tracks: Vec<ToolTrack>,
    by_name: HashMap<String, usize>,
}

impl Tools {
    pub(super) fn push(&mut self, name: &str, sample: TrackSample) {
        let place = *self.by_name.entry(name.to_owned()).or_insert_with(|| {
            self.tracks.push(ToolTrack { name: name.to_owned(), samples: Vec::new() });
            self.tracks.len() - 1
        });
        self.tracks[place].samples.push(sample);
    }

    /// What they are a recording of.
    ///
    /// # Errors
    /// [`FormatError::NoRows`].
    pub(super) fn finish(self) -> Result<Recording, FormatError> {
        match self.tracks.is_empty() {
            true => Err(FormatError::NoRows),
            false => Ok(Recording { tools: self.tracks }),
        }
    }
}

/// The pose of recorded numbers, scalar first.
pub(super) fn pose(at_mm: [f64; 3], quaternion: [f64; 4]) -> Result<Pose, Unusable> {
    let length = quaternion.iter().map(|q| q * q).sum::<f64>().sqrt();
    let is_unit = (length - 1.0).abs() <= MAX_QUATERNION_OFF;
    if !(is_unit && at_mm.iter().all(|v| v.is_finite())) {
        return Err(Unusable::NoPose);
    }
    let rotation = number::rotation(quaternion).ok_or(Unusable::NoPose)?;
    Ok(pose_from_parts(Vector3::from(at_mm), rotation))
}
