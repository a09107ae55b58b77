//! Measurement tables of any length as samples, row by row, and as a person judges one before anything
//! is fitted to it.

use super::error::StoreError;
use super::files::Files;
use super::kinds::Doubted;
use super::paths::file_name;
use super::read::{MAX_BYTES, ReadFailure, not_of_its_kind, open_input};
use nalgebra::Translation3;
use std::collections::HashSet;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use trackwright_calibration::doubts::{PairedDoubts, PoseFrame, Suspicion};
use trackwright_calibration::fit_quality::{ErrorSummary, measured_errors};
use trackwright_calibration::lag::without_lag;
use trackwright_field::samples::{MapKind, Measurement, MeasurementContent, SampleSet};
use trackwright_formats::groups::GroupColumn;
use trackwright_formats::measurements::MeasurementReader;
use trackwright_formats::{FormatError, foreign};
use trackwright_geometry::bounds::Bounds;
use trackwright_task::Task;

const EXPECTED: &str = "a measurement table";

/// Rows between two looks at whether to go on: some milliseconds.
const ROWS_PER_STEP: usize = 1024;

/// Most rows that a lag is taken out of: more are rows that were shifted.
pub const MOST_LAG_ROWS: f64 = 100.0;

/// Longest distance of a coil from a tip, mm.
pub const MOST_SENSOR_OFFSET_MM: f64 = 1e3;

/// How a table of measurements is meant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleReading {
    /// Whether quaternions are whole rotations, not an axis each with any roll about it.
    pub has_rolls: bool,
    pub map: MapKind,
    /// How many rows the measured side is behind the ideal one; it is taken out.
    pub lag_rows: f64,
    /// How far measured positions are along the sensor's z axis from ideal ones; it is taken out.
    pub sensor_offset_mm: f64,
}

impl SampleReading {
    /// The distortion map of a table without lag.
    pub fn of_distortion(has_rolls: bool) -> Self {
        Self { has_rolls, map: MapKind::Distortion, lag_rows: 0.0, sensor_offset_mm: 0.0 }
    }

    /// A table's measurements as samples, and what is suspected of them.
    ///
    /// # Errors
    /// Those of `next`.
    pub fn samples<E>(
        &self,
        content: MeasurementContent,
        mut next: impl FnMut() -> Result<Option<Measurement>, E>,
    ) -> Result<(SampleSet, Vec<Suspicion>), E> {
        let mut set = SampleSet::new(content);
        let mut doubts = PairedDoubts::new(content, PoseFrame::Tracker);
        let coil_from_tip = Translation3::new(0.0, 0.0, -self.sensor_offset_mm);
        let mut push = |m: &Measurement| {
            let tracker_from_measured = m.tracker_from_measured * coil_from_tip;
            let measurement = match self.sensor_offset_mm == 0.0 {
                true => *m,
                false => Measurement { tracker_from_measured, ..*m },
            };
            doubts.push(&measurement);
            set.push(&measurement, content, self.map);
        };
        if self.lag_rows == 0.0 {
            while let Some(measurement) = next()? {
                push(&measurement);
            }
        } else {
            let mut rows = Vec::new();
            while let Some(measurement) = next()? {
                rows.push(measurement);
            }
            without_lag(&rows, content, self.lag_rows).iter().for_each(push);
        }
        set.samples.shrink_to_fit();
        Ok((set, doubts.suspicions()))
    }
}

impl Files {
    /// Reads a measurement table; memory is that of its samples, whatever else is in the table.
    pub fn read_samples(
        &self,
        file: &Path,
        reading: SampleReading,
        task: &Task,
    ) -> Result<Doubted<SampleSet>, StoreError> {
        self.input(file)?;
        read_samples(file, reading, task)
    }
}

fn read_samples(
    file: &Path,
    reading: SampleReading,
    task: &Task,
) -> Result<Doubted<SampleSet>, StoreError> {
    let unreadable = |cause: io::Error| ReadFailure::Io(cause).into_error(file, EXPECTED);
    let opened = open_input(file).map_err(|failure| failure.into_error(file, EXPECTED))?;
    let len = opened.metadata().map_or(0, |m| m.len());
    if len > MAX_BYTES {
        return Err(ReadFailure::TooLarge.into_error(file, EXPECTED));
    }
    let count = Arc::new(AtomicU64::new(0));
    let counted = Counted { inner: opened.take(MAX_BYTES + 1), count: count.clone() };
    let read = || count.load(Ordering::Relaxed);
    let report = || Ok(task.step(read() as usize, len.max(read()) as usize)?);
    let samples = samples(counted, file, reading, report);
    if read() > MAX_BYTES {
        return Err(ReadFailure::TooLarge.into_error(file, EXPECTED));
    }
    samples.map_err(|error| match error {
        StoreError::Format { cause: FormatError::Unreadable { kind, .. }, .. } => {
            unreadable(kind.into())
        }
        other => other,
    })
}

fn samples(
    reader: impl Read,
    file: &Path,
    reading: SampleReading,
    report: impl Fn() -> Result<(), StoreError>,
) -> Result<Doubted<SampleSet>, StoreError> {
    let in_file = |cause| match cause {
        FormatError::Unreadable { .. } => StoreError::Format { file: file.to_owned(), cause },
        cause => not_of_its_kind(file, &head(file), EXPECTED, cause),
    };
    let mut reader = MeasurementReader::new(reader).map_err(in_file)?;
    let content = match (reader.content(), reading.has_rolls) {
        (MeasurementContent::PositionOnly, true) => {
            return Err(StoreError::NoQuaternions { file: file.to_owned() });
        }
        (MeasurementContent::FiveDof, true) => MeasurementContent::SixDof,
        (content, _) => content,
    };
    let mut rows: usize = 0;
    let (set, suspicions) = reading.samples(content, || {
        if rows.is_multiple_of(ROWS_PER_STEP) {
            report()?;
        }
        rows += 1;
        reader.next_measurement().map_err(in_file)
    })?;
    Ok(Doubted::new(set, file, suspicions))
}

/// The beginning of a file; nothing of one that cannot be read, or not twice.
fn head(file: &Path) -> Vec<u8> {
    let mut head = Vec::new();
    if let Ok(opened) = open_input(file)
        && opened.metadata().is_ok_and(|m| m.is_file())
        && opened.take(foreign::HEAD as u64).read_to_end(&mut head).is_err()
    {
        head.clear();
    }
    head
}

/// Counts the bytes that were read.
struct Counted<R> {
    inner: R,
    count: Arc<AtomicU64>,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(out)?;
        self.count.fetch_add(read as u64, Ordering::Relaxed);
        Ok(read)
    }
}

/// A table that was read, with everything that is reported about it.
#[derive(Debug)]
pub struct MeasurementTable {
    pub file: PathBuf,
    pub reading: SampleReading,
    pub samples: SampleSet,
    /// What the table may be instead of what it is read as.
    pub suspicions: Vec<Suspicion>,
    pub measured: ErrorSummary,
    pub bounds: Option<Bounds>,
    /// The column of groups; one that cannot be used prevents a choice of model, not a fit.
    pub groups: Result<Option<TableGroups>, StoreError>,
    /// The column that states which sensor each row is of.
    pub sensors: Result<Option<GroupColumn>, StoreError>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct TableGroups {
    pub column: GroupColumn,
    pub count: usize,
}

impl MeasurementTable {
    /// The file's name without its folder.
    pub fn name(&self) -> String {
        file_name(&self.file)
    }

    /// Whether no tracker's table is like this; commands take one only with `--as-is`.
    pub fn is_beyond_doubt(&self) -> bool {
        self.suspicions.iter().any(Suspicion::is_beyond_doubt)
    }

    /// Edge of the cube that each sample would have to itself, mm; `None` for samples in a plane.
    pub fn spacing_mm(&self) -> Option<f64> {
        let volume_mm3 = self.bounds?.size_mm().product();
        let spacing_mm = (volume_mm3 / self.samples.samples.len() as f64).cbrt();
        (spacing_mm > 0.0).then_some(spacing_mm)
    }
}

impl Files {
    /// Reads a table with its groups.
    pub fn read_table(
        &self,
        file: &Path,
        reading: SampleReading,
        task: &Task,
    ) -> Result<MeasurementTable, StoreError> {
        let found = self.read_samples(file, reading, task)?;
        let (suspicions, samples) = (found.suspicions.clone(), found.as_it_stands());
        let groups = self.read_groups(file, None).map(|column| {
            column.map(|column| TableGroups {
                count: column.labels.iter().collect::<HashSet<_>>().len(),
                column,
            })
        });
        Ok(MeasurementTable {
            file: file.to_owned(),
            reading,
            bounds: Bounds::around(samples.samples.iter().map(|s| s.position_mm)),
            measured: measured_errors(&samples),
            samples,
            suspicions,
            groups,
            sensors: self.read_sensors(file),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_task::{CancelToken, Cancelled};

    fn in_repository(name: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/environments/data").join(name)
    }

    #[test]
    fn row_by_row_is_to_the_bit_what_the_whole_is() {
        let file = in_repository("cube-fit.csv");
        for (has_rolls, content) in
            [(false, MeasurementContent::FiveDof), (true, MeasurementContent::SixDof)]
        {
            for map in [MapKind::Distortion, MapKind::Correction] {
                let mut whole = Files::default().read_measurements(&file).unwrap();
                whole.content = content;
                let reading = SampleReading { map, ..SampleReading::of_distortion(has_rolls) };
                let found = read_samples(&file, reading, &Task::default()).unwrap();
                assert_eq!(found.suspicions, []);
                assert_eq!(found.as_it_stands(), whole.samples(map));
            }
        }
    }

    #[test]
    fn a_cancelled_reading_stops() {
        let token = CancelToken::default();
        token.cancel();
        let reading = SampleReading::of_distortion(false);
        let stopped =
            read_samples(&in_repository("cube-fit.csv"), reading, &Task::cancelled_by(token));
        assert!(matches!(stopped, Err(StoreError::Cancelled(Cancelled))));
    }

    #[test]
    fn folders_and_missing_files_are_named_as_ever() {
        let reading = SampleReading::of_distortion(false);
        for name in [".", "no-such.csv"] {
            let file = in_repository(name);
            let whole = Files::default().read_measurements(&file).unwrap_err().to_string();
            let found = read_samples(&file, reading, &Task::default()).unwrap_err();
            assert_eq!(found.to_string(), whole);
        }
    }

    fn table(text: &str) -> MeasurementTable {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        let reading = SampleReading::of_distortion(false);
        Files::default().read_table(file.path(), reading, &Task::default()).unwrap()
    }

    const HEAD: &str = "ideal_x,ideal_y,ideal_z,measured_x,measured_y,measured_z,cluster\n";

    #[test]
    fn an_unusable_group_column_leaves_the_rows() {
        let good = table(&format!("{HEAD}0,0,0,0,0,0,a\n8,0,0,8,0,0,b\n0,2,4,0,2,4,a\n"));
        let groups = good.groups.as_ref().unwrap().as_ref().unwrap();
        assert_eq!((groups.count, groups.column.name.as_str()), (2, "cluster"));
        assert!((good.spacing_mm().unwrap() - (64.0_f64 / 3.0).cbrt()).abs() < 1e-12);
        let bad = table(&format!("{HEAD}0,0,0,0,0,0,a\n8,0,0,8,0,0,\n"));
        assert_eq!(bad.samples.samples.len(), 2);
        assert_eq!(bad.spacing_mm(), None);
        let problem = bad.groups.unwrap_err().to_string();
        assert!(problem.contains("cluster is empty"), "{problem}");
    }
}
