//! Tools: bodies and makers' definitions (NDI ROMs and others), read and written.

use crate::design::Sensor;
use crate::errors::{Done, TrackwrightError};
use crate::found::Found;
use crate::long_work;
use crate::tables::{Notes, warn_of};
use anyhow::Context;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::{Path, PathBuf};
use trackwright_formats::tool_definition::{
    BodyFormat, DefinitionFormat, OnMismatch, ToolDefinition, from_body, read_body,
};
use trackwright_project::{Files, ReadTool, StoreError, body_format_of};

/// A tool that was read: its sensors, its tip, and the maker's file that it came from.
#[pyclass(frozen, extends = Found, module = "trackwright")]
pub struct Tool {
    read: ReadTool,
    /// Where its meshes are referred to from.
    source: PathBuf,
}

fn on_mismatch(accept_checksum: bool) -> OnMismatch {
    if accept_checksum { OnMismatch::Accept } else { OnMismatch::Refuse }
}

#[pymethods]
impl Tool {
    /// Opens a body (`*.body.ron`) or a maker's definition: an NDI ROM, a .tool file, and others.
    #[staticmethod]
    #[pyo3(signature = (path, *, accept_checksum = false))]
    fn load(py: Python<'_>, path: PathBuf, accept_checksum: bool) -> Done<Py<Self>> {
        let read = long_work::run(py, |_| {
            let read = Files::default().read_tool(&path, on_mismatch(accept_checksum));
            read.map_err(|error: StoreError| match error.is_checksum() {
                true => {
                    let text = format!("{error} (accept_checksum=True reads it all the same)");
                    TrackwrightError::new_err(text).into()
                }
                false => error.into(),
            })
        })?;
        let definition = ToolDefinition::carried(read.body.definition.as_deref());
        let doubt = definition.as_ref().and_then(ToolDefinition::doubt);
        let size = read.body.rigid.size_doubt();
        let size = size.map(|doubt| format!("tip and sensors: {doubt}"));
        let notes = doubt.into_iter().chain(size).collect();
        let base = Found::new(py, read.section(), notes)?;
        Ok(Py::new(py, (Self { read, source: path }, base))?)
    }

    /// A tool from the bytes of its file; extension is that of its name.
    #[staticmethod]
    #[pyo3(signature = (bytes, extension = "rom", *, accept_checksum = false))]
    fn from_bytes(
        py: Python<'_>,
        bytes: &[u8],
        extension: &str,
        accept_checksum: bool,
    ) -> Done<Py<Self>> {
        let (body, kind) = read_body(bytes, extension, on_mismatch(accept_checksum))?;
        let read = ReadTool { body, kind };
        let base = Found::new(py, read.section(), Notes::new())?;
        Ok(Py::new(py, (Self { read, source: PathBuf::new() }, base))?)
    }

    /// The tool as a maker's definition: "rom", "tool", "ini" or "json".
    #[pyo3(signature = (extension = "rom"))]
    fn to_bytes<'py>(&self, py: Python<'py>, extension: &str) -> Done<Bound<'py, PyBytes>> {
        let Some(format) = DefinitionFormat::of_extension(extension) else {
            let text = format!("extension: found {extension:?}, expected rom, tool, ini or json");
            return Err(TrackwrightError::new_err(text).into());
        };
        let conversion =
            from_body(&self.read.body, format).with_context(|| format!("no {}", format.name()))?;
        warn_of(py, conversion.notes())?;
        Ok(PyBytes::new(py, &conversion.definition.write()))
    }

    /// Writes the tool as its new file's name has it: .body.ron, .rom, .tool, .ini or .json.
    #[pyo3(signature = (path, *, overwrite = false))]
    fn save(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> Done<()> {
        let files = Files::overwriting(overwrite);
        let notes = match body_format_of(&path)? {
            BodyFormat::Body => {
                files.output(&path)?.write_body(&self.read.body, &self.source)?;
                Vec::new()
            }
            BodyFormat::Definition(format) => {
                let conversion = from_body(&self.read.body, format)
                    .with_context(|| format!("{}: no {}", self.source.display(), format.name()))?;
                files.output(&path)?.write_definition(&conversion.definition)?;
                conversion.notes()
            }
        };
        let named = |note: String| format!("{}: {note}", Path::new(&path).display());
        Ok(warn_of(py, notes.into_iter().map(named).collect())?)
    }

    /// The tool's name.
    #[getter]
    fn name(&self) -> &str {
        &self.read.body.rigid.name
    }

    /// The kind of the maker's file; None of a body.
    #[getter]
    fn kind(&self) -> Option<&'static str> {
        self.read.kind.map(|kind| kind.code())
    }

    /// The tool's sensors or markers.
    #[getter]
    fn sensors(&self) -> Vec<Sensor> {
        self.read.body.rigid.sensors.iter().cloned().map(Sensor::of).collect()
    }

    /// The tip, shape (3,), mm, tool's frame; None where none is known.
    #[getter]
    fn tip<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let tip = self.read.body.rigid.tip_in_body?;
        Some(crate::arrays::vector_array(py, tip.coords.into()))
    }

    fn __repr__(&self) -> String {
        format!("<trackwright.Tool {:?}>", self.name())
    }
}
