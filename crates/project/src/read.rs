//! Reads one file of a kind; every error names the file.

use super::doubted::{Doubted, read_doubted};
use super::error::StoreError;
use super::files::Files;
use super::place::{Kind, Place};
use nalgebra::Point3;
use std::path::Path;
use trackwright_calibration::built_tool::RecordedTable;
use trackwright_calibration::calibration_object::{CalibrationBody, CalibrationFrame};
use trackwright_calibration::doubts::{self, PairedDoubts, PoseFrame, Suspicion};
use trackwright_field::Environment;
use trackwright_field::generator::Generator;
use trackwright_field::samples::{MeasurementContent, MeasurementSet};
use trackwright_formats::groups::{self, GroupColumn};
use trackwright_formats::pivot_recording::{self, PivotRecording};
use trackwright_formats::poses::WhosePoses;
use trackwright_formats::{
    FormatError, environment, foreign, generator, input, jhu_cis, measurements, mesh, points,
    poses, recorded_tool, recording,
};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::MeshUnit;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::InputTrial;
use trackwright_simulation::recording::Recording;

/// Files by their kinds.
impl Files {
    /// # Errors
    /// See [`StoreError`], here and below.
    pub fn read_environment(&self, file: &Path) -> Result<Environment, StoreError> {
        self.read(file, Kind::ENVIRONMENT, environment::parse)
    }

    pub fn read_generator(&self, file: &Path) -> Result<Generator, StoreError> {
        self.read(file, Kind::GENERATOR, generator::parse)
    }

    /// A whole measurement table as it stands; commands use [`Self::read_samples`].
    pub fn read_measurements(&self, file: &Path) -> Result<MeasurementSet, StoreError> {
        self.read(file, "a measurement table", measurements::parse)
    }

    /// The column of a measurement table that groups its rows: the named one, or one that is known to.
    pub fn read_groups(
        &self,
        file: &Path,
        column: Option<&str>,
    ) -> Result<Option<GroupColumn>, StoreError> {
        self.read(file, "a measurement table", |bytes| groups::parse(bytes, column))
    }

    /// The column of a measurement table that says which sensor each row is of, where there is one.
    pub fn read_sensors(&self, file: &Path) -> Result<Option<GroupColumn>, StoreError> {
        self.read(file, "a measurement table", groups::parse_sensors)
    }

    /// Poses of sensors in the tracker frame.
    pub fn read_poses(&self, file: &Path) -> Result<Doubted<Vec<Pose>>, StoreError> {
        self.read_doubted(file, "a poses table", poses::parse, |poses| {
            doubts::with_written_quaternions(poses, PoseFrame::Tracker)
        })
    }

    /// Some poses of a table that has several.
    pub fn read_poses_of(
        &self,
        file: &Path,
        whose: WhosePoses,
    ) -> Result<Doubted<Vec<Pose>>, StoreError> {
        self.read_doubted(
            file,
            "a table of poses",
            |bytes| poses::parse_of(bytes, whose),
            |poses| doubts::with_written_quaternions(poses, PoseFrame::Any),
        )
    }

    /// Input data; the CRF's columns count only for a design that has one.
    pub fn read_input(
        &self,
        file: &Path,
        design_has_crf: bool,
    ) -> Result<Doubted<Vec<InputTrial>>, StoreError> {
        self.read_doubted(
            file,
            "an input table",
            |bytes| input::parse(bytes, design_has_crf),
            |trials| {
                let tools: Vec<Pose> = trials.iter().map(|trial| trial.crf_from_tool).collect();
                doubts::with_written_quaternions(&tools, PoseFrame::Any)
            },
        )
    }

    pub fn read_calbody(&self, file: &Path) -> Result<CalibrationBody, StoreError> {
        self.read(file, "a calbody file", jhu_cis::parse_calbody)
    }

    pub fn read_calreadings(&self, file: &Path) -> Result<Vec<CalibrationFrame>, StoreError> {
        self.read(file, "a calreadings file", jhu_cis::parse_calreadings)
    }

    /// A tool's poses or markers around one point, in any format of theirs.
    pub fn read_pivot_recording(&self, file: &Path) -> Result<Doubted<PivotRecording>, StoreError> {
        self.read_doubted(file, "a recording", pivot_recording::parse, |found| match found {
            PivotRecording::Poses(poses) => {
                doubts::with_written_quaternions(poses, PoseFrame::Recorded)
            }
            PivotRecording::Markers(frames) => doubts::of_points(frames.iter().flatten()),
            PivotRecording::MarkersAndBase(frames) => {
                doubts::of_points(frames.iter().flat_map(|frame| &frame.on_tool))
            }
            PivotRecording::Tools(recording) => of_recording(recording),
        })
    }

    /// The true and measured poses of a built tool or of its sensors. Whether they are in one frame is
    /// for `verify` to judge, which knows what the tool should read.
    pub fn read_recorded_tool(&self, file: &Path) -> Result<Doubted<RecordedTable>, StoreError> {
        self.read_doubted(file, "a measurement table", recorded_tool::parse, |table| {
            let mut found =
                PairedDoubts::of(&table.rows, MeasurementContent::SixDof, PoseFrame::Any);
            found.retain(|suspicion| !suspicion.is_of_frames());
            found
        })
    }

    /// Points in any of their formats.
    pub fn read_points(&self, file: &Path) -> Result<Doubted<Vec<Point3<f64>>>, StoreError> {
        self.read_doubted(file, "points", points::parse, |points| doubts::of_points(points))
    }

    /// What a tracker recorded: an NDI table, an Aurora log, a PLUS sequence or a live recording.
    pub fn read_recording(&self, file: &Path) -> Result<Doubted<Recording>, StoreError> {
        self.read_doubted(file, "a recording", recording::parse, of_recording)
    }

    /// A mesh in any format; `unit` overrides that of the format.
    pub fn read_mesh(
        &self,
        file: &Path,
        unit: Option<MeshUnit>,
    ) -> Result<SurfaceMesh, StoreError> {
        self.input(file)?;
        read_mesh_at(Place::Disk, file, unit)
    }

    fn read<T>(
        &self,
        file: &Path,
        kind: impl Into<Kind>,
        parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
    ) -> Result<T, StoreError> {
        self.input(file)?;
        read(Place::Disk, file, kind, parse)
    }

    fn read_doubted<T>(
        &self,
        file: &Path,
        expected: &'static str,
        parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
        doubts: impl FnOnce(&T) -> Vec<Suspicion>,
    ) -> Result<Doubted<T>, StoreError> {
        self.input(file)?;
        read_doubted(file, expected, parse, doubts)
    }
}

/// All tools of a recording have one unit.
fn of_recording(recording: &Recording) -> Vec<Suspicion> {
    let poses = recording.tools.iter().flat_map(|tool| tool.good());
    doubts::of_poses(poses, PoseFrame::Recorded)
}

pub(super) fn read_mesh_at(
    place: Place,
    file: &Path,
    unit: Option<MeshUnit>,
) -> Result<SurfaceMesh, StoreError> {
    let extension = file.extension().unwrap_or_default().to_string_lossy();
    read(place, file, "a mesh", |bytes| Ok(mesh::read(bytes, &extension, unit)?))
}

/// Reads a file and parses it.
pub(super) fn read<T>(
    place: Place,
    file: &Path,
    kind: impl Into<Kind>,
    parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
) -> Result<T, StoreError> {
    let kind = kind.into();
    let bytes = place.read(file, kind).map_err(|failure| failure.into_error(file, kind))?;
    parse(&bytes).map_err(|cause| not_of_its_kind(file, &bytes, kind.expected, cause))
}

/// The error of a file whose content is not what is expected: what it is instead, where that is known,
/// and else what is wrong in it.
pub(super) fn not_of_its_kind(
    file: &Path,
    head: &[u8],
    expected: &'static str,
    cause: FormatError,
) -> StoreError {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    StoreError::Format {
        file: file.to_owned(),
        cause: foreign::foreign(head, &name, expected).unwrap_or(cause),
    }
}
