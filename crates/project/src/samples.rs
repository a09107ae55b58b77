//! Reads measurement tables of any length as samples, row by row.

use super::doubted::Doubted;
use super::error::StoreError;
use super::files::Files;
use super::place::{MAX_BYTES, ReadFailure, open_input};
use super::read::not_of_its_kind;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use trackwright_calibration::doubts::{PairedDoubts, PoseFrame};
use trackwright_field::samples::{MapKind, MeasurementContent, SampleSet};
use trackwright_formats::measurements::MeasurementReader;
use trackwright_formats::{FormatError, foreign};
use trackwright_task::Task;

const EXPECTED: &str = "a measurement table";

/// Rows between two looks at whether to go on: some milliseconds.
const ROWS_PER_STEP: usize = 1024;

/// How a table of measurements is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleReading {
    /// Whether quaternions are whole rotations, not an axis each with any roll about it.
    pub has_rolls: bool,
    pub map: MapKind,
}

impl Files {
    /// Reads a measurement table; memory is that of its samples, whatever else is in the table.
    ///
    /// # Errors
    /// A file that cannot be read or is no measurement table; one without quaternions where they were
    /// said to be whole; [`StoreError::Cancelled`].
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
    let told = || Ok(task.step(read() as usize, len.max(read()) as usize)?);
    let samples = samples(counted, file, reading, told);
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
    told: impl Fn() -> Result<(), StoreError>,
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
    let mut set = SampleSet::new(content);
    let mut doubts = PairedDoubts::new(content, PoseFrame::Tracker);
    while let Some(measurement) = reader.next_measurement().map_err(in_file)? {
        if set.samples.len().is_multiple_of(ROWS_PER_STEP) {
            told()?;
        }
        doubts.push(&measurement);
        set.push(&measurement, content, reading.map);
    }
    set.samples.shrink_to_fit();
    Ok(Doubted::new(set, file, doubts.suspicions()))
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;
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
                let reading = SampleReading { has_rolls, map };
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
        let reading = SampleReading { has_rolls: false, map: MapKind::Distortion };
        let stopped =
            read_samples(&in_repository("cube-fit.csv"), reading, &Task::cancelled_by(token));
        assert!(matches!(stopped, Err(StoreError::Cancelled(Cancelled))));
    }

    #[test]
    fn folders_and_missing_files_are_named_as_ever() {
        let reading = SampleReading { has_rolls: false, map: MapKind::Distortion };
        for name in [".", "no-such.csv"] {
            let file = in_repository(name);
            let whole = Files::default().read_measurements(&file).unwrap_err().to_string();
            let found = read_samples(&file, reading, &Task::default()).unwrap_err();
            assert_eq!(found.to_string(), whole);
        }
    }
}
