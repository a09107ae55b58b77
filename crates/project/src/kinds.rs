//! Reads files by their kinds: what a command requests of a table or a recording.

use super::error::StoreError;
use super::files::Files;
use super::paths::extension_of;
use super::read::{Kind, Storage, read};
use nalgebra::Point3;
use std::path::{Path, PathBuf};
use trackwright_calibration::built_tool::RecordedTable;
use trackwright_calibration::calibration_object::{CalibrationBody, CalibrationFrame};
use trackwright_calibration::doubts::{self, PairedDoubts, PoseFrame, Suspicion};
use trackwright_calibration::protocol::table::ProtocolTable;
use trackwright_field::generator::Generator;
use trackwright_field::samples::{MeasurementContent, MeasurementSet};
use trackwright_formats::groups::{self, GroupColumn};
use trackwright_formats::pivot_recording::{self, PivotRecording};
use trackwright_formats::plate_recording::{self, PlateContent, PlateRow};
use trackwright_formats::poses::WhosePoses;
use trackwright_formats::sweep_plan::SweepPlan;
use trackwright_formats::{
    FormatError, generator, input, jhu_cis, measurements, mesh, points, poses, protocol_table,
    recorded_tool, recording, sweep_plan,
};
use trackwright_geometry::mesh::SurfaceMesh;
use trackwright_geometry::mesh_reference::MeshUnit;
use trackwright_geometry::pose::Pose;
use trackwright_simulation::InputTrial;
use trackwright_simulation::recording::Recording;

/// The content of a table. It is taken by stating what is to happen with suspicions.
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct Doubted<T> {
    content: T,
    pub file: PathBuf,
    pub suspicions: Vec<Suspicion>,
}

impl<T> Doubted<T> {
    /// Content with its suspicions, sorted.
    pub fn new(content: T, file: &Path, mut suspicions: Vec<Suspicion>) -> Self {
        suspicions.sort_by_key(|suspicion| !suspicion.is_beyond_doubt());
        Self { content, file: file.to_owned(), suspicions }
    }

    /// The content, each suspicion passed to `suspected`; an error where one is certain, not meant.
    pub fn take(
        self,
        is_meant: bool,
        mut suspected: impl FnMut(&Path, &Suspicion),
    ) -> Result<T, StoreError> {
        let certain = self.suspicions.first().filter(|s| s.is_beyond_doubt());
        if let Some(suspicion) = certain.filter(|_| !is_meant) {
            return Err(StoreError::Doubted {
                file: self.file,
                suspicion: Box::new(suspicion.clone()),
            });
        }
        for suspicion in &self.suspicions {
            suspected(&self.file, suspicion);
        }
        Ok(self.content)
    }

    /// With what the content shows beside something else.
    pub fn and(mut self, more: impl FnOnce(&T) -> Option<Suspicion>) -> Self {
        self.suspicions.extend(more(&self.content));
        self.suspicions.sort_by_key(|suspicion| !suspicion.is_beyond_doubt());
        self
    }

    /// The content, whatever is suspected.
    pub fn as_it_stands(self) -> T {
        self.content
    }
}

impl Files {
    /// Reads a field generator.
    pub fn read_generator(&self, file: &Path) -> Result<Generator, StoreError> {
        self.read(file, Kind::GENERATOR, generator::parse)
    }

    /// Reads a plan of a sweep.
    pub fn read_sweep_plan(&self, file: &Path) -> Result<SweepPlan, StoreError> {
        self.read(file, Kind::SWEEP_PLAN, sweep_plan::parse)
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

    /// The column of a measurement table that states which sensor each row is of, where there is
    /// one.
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

    /// Reads the geometry of a calibration object.
    pub fn read_calbody(&self, file: &Path) -> Result<CalibrationBody, StoreError> {
        self.read(file, "a calbody file", jhu_cis::parse_calbody)
    }

    /// Reads what both trackers read of a calibration object.
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
    /// for `verify` to judge, which knows what the tool should read; and a CRF may lie still, row by row.
    pub fn read_recorded_tool(&self, file: &Path) -> Result<Doubted<RecordedTable>, StoreError> {
        self.read_doubted(file, "a measurement table", recorded_tool::parse, |table| {
            let mut found =
                PairedDoubts::of(&table.rows, MeasurementContent::SixDof, PoseFrame::Any);
            let is_meant =
                |own: &Suspicion| own.is_of_frames() || matches!(own, Suspicion::Repeated { .. });
            found.retain(|suspicion| !is_meant(suspicion));
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
        read(Storage::Disk, file, "a mesh", |bytes| {
            Ok(mesh::read(bytes, &extension_of(file), unit)?)
        })
    }

    /// Readings of a sensor on a plate.
    pub fn read_plate_recording(&self, file: &Path) -> Result<Doubted<Vec<PlateRow>>, StoreError> {
        self.read_doubted(file, "a plate recording", plate_recording::parse, |rows| {
            let poses = rows.iter().filter_map(|row| match &row.content {
                PlateContent::Pose(pose) => Some(pose),
                PlateContent::Recording(_) => None,
            });
            doubts::of_poses(poses, PoseFrame::Recorded)
        })
    }

    /// A table of an assessment protocol.
    pub fn read_protocol_table(&self, file: &Path) -> Result<ProtocolTable, StoreError> {
        self.read(file, "a protocol table", protocol_table::parse)
    }

    fn read<T>(
        &self,
        file: &Path,
        kind: impl Into<Kind>,
        parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
    ) -> Result<T, StoreError> {
        self.input(file)?;
        read(Storage::Disk, file, kind, parse)
    }

    fn read_doubted<T>(
        &self,
        file: &Path,
        expected: &'static str,
        parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
        doubts: impl FnOnce(&T) -> Vec<Suspicion>,
    ) -> Result<Doubted<T>, StoreError> {
        let content = self.read(file, expected, parse)?;
        let suspicions = doubts(&content);
        Ok(Doubted::new(content, file, suspicions))
    }
}

/// All tools of a recording have one unit.
fn of_recording(recording: &Recording) -> Vec<Suspicion> {
    let poses = recording.tools.iter().flat_map(|tool| tool.good());
    doubts::of_poses(poses, PoseFrame::Recorded)
}
