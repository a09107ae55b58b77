//! Recordings of trackers: read in any format, and written as tables of live poses.

use crate::errors::{Done, TrackwrightError};
use crate::long_work;
use crate::records::{Cell, Field, Records};
use crate::tables::{Notes, Table, take, warn_of};
use anyhow::Context;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::path::PathBuf;
use trackwright_formats::recording::{self as format, live_table};
use trackwright_geometry::pose::pose_to_array;
use trackwright_project::Files;
use trackwright_simulation::recording::{self, ToolTrack, TrackSample, Unusable};

const EXPECTED: &str = "the columns of a tool's poses (x, y, z, qw, qx, qy, qz), and time_s";

/// What a tracker recorded of one tool or several.
#[pyclass(frozen, module = "trackwright")]
pub struct Recording(recording::Recording);

#[pymethods]
impl Recording {
    /// Opens a recording of a tracker, in any format that `trackwright` reads.
    #[staticmethod]
    #[pyo3(signature = (path, *, as_is = false))]
    fn load(py: Python<'_>, path: PathBuf, as_is: bool) -> Done<Self> {
        let found = long_work::run(py, |_| Ok(Files::default().read_recording(&path)?))?;
        let mut notes = Notes::new();
        let found = take(found, as_is, &mut notes)?;
        warn_of(py, notes)?;
        Ok(Self(found))
    }

    /// A recording from the bytes of its file.
    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> Done<Self> {
        Ok(Self(format::parse(bytes)?))
    }

    /// A recording from tables in memory by the tools' names: x, y, z (mm, tracker's frame), qw … qz, and
    /// time_s where it is known.
    #[staticmethod]
    fn of_tools(tools: &Bound<'_, PyDict>) -> Done<Self> {
        let each = tools.iter().map(|(name, table)| {
            let Table::Memory(columns) = Table::of(&table)? else {
                let text = "tools: found a file, expected a table in memory";
                return Err(TrackwrightError::new_err(text).into());
            };
            let poses = columns.poses("", EXPECTED)?;
            let times = match columns.has("time_s")? {
                true => Some(columns.number_column("time_s", EXPECTED)?),
                false => None,
            };
            let samples = (0..poses.rows()?).map(|row| {
                let time_s = times.as_ref().map(|times| times.number(0, row)).transpose()?;
                Ok(TrackSample { frame: None, time_s, pose: Ok(poses.pose(row)?) })
            });
            Ok(ToolTrack { name: name.extract()?, samples: samples.collect::<Done<_>>()? })
        });
        Ok(Self(recording::Recording { tools: each.collect::<Done<_>>()? }))
    }

    /// The recording as a table of live poses (CSV).
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, pyo3::types::PyBytes> {
        pyo3::types::PyBytes::new(py, &live_table::write(&self.0))
    }

    /// Writes the recording as a table of live poses (CSV).
    #[pyo3(signature = (path, *, overwrite = false))]
    fn save(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> Done<()> {
        long_work::run(py, |_| {
            let files = Files::overwriting(overwrite);
            Ok(files.output(&path)?.write_bytes(&live_table::write(&self.0))?)
        })
    }

    /// The tools' names.
    #[getter]
    fn tools(&self) -> Vec<&str> {
        self.0.tools.iter().map(|tool| tool.name.as_str()).collect()
    }

    /// The samples of a tool, a record each: frame, time_s, usable, x, y, z (mm) and qw … qz, the pose in the
    /// tracker's frame, or in that of the tool relative_to. Poses that are not usable are not a number.
    #[pyo3(signature = (tool = None, *, relative_to = None))]
    fn track<'py>(
        &self,
        py: Python<'py>,
        tool: Option<&str>,
        relative_to: Option<&str>,
    ) -> Done<Bound<'py, PyAny>> {
        let track = self.0.track(tool, relative_to).context("tool")?;
        let fields = [
            ("frame", Field::Float),
            ("time_s", Field::Float),
            ("usable", Field::Flag),
            ("x", Field::Float),
            ("y", Field::Float),
            ("z", Field::Float),
            ("qw", Field::Float),
            ("qx", Field::Float),
            ("qy", Field::Float),
            ("qz", Field::Float),
        ];
        let mut records = Records::new(fields, track.samples.len());
        for sample in &track.samples {
            let pose = sample.pose.as_ref().map_or([f64::NAN; 7], pose_to_array);
            let [x, y, z, qw, qx, qy, qz] = pose.map(Cell::Float);
            records.push([
                Cell::known(sample.frame.map(|frame| frame as f64)),
                Cell::known(sample.time_s),
                Cell::Flag(sample.pose.is_ok()),
                x,
                y,
                z,
                qw,
                qx,
                qy,
                qz,
            ]);
        }
        records.into_numpy(py)
    }

    /// How many samples of a tool are not used, by reason.
    #[pyo3(signature = (tool = None))]
    fn unusable(&self, tool: Option<&str>) -> Done<BTreeMap<String, usize>> {
        let tool = self.0.tool(tool).context("tool")?;
        let counts = tool.unusable().into_iter();
        Ok(counts.map(|(reason, count): (&Unusable, usize)| (reason.to_string(), count)).collect())
    }

    fn __repr__(&self) -> String {
        format!("<trackwright.Recording of {}>", self.tools().join(", "))
    }
}
