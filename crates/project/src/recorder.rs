//! A file that grows by what a live session measures, by whole lines at any time.

use super::error::StoreError;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use trackwright_formats::recording::live_table::{self, LiveSample};

/// A recording that is being written. Lines go to the system one by one as whole lines, so that
/// they are there when this program ends in whatever way.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    file: File,
    line: Vec<u8>,
    /// Length of the file up to the end of its last whole line.
    whole_bytes: u64,
    samples: u64,
}

impl Recorder {
    /// Begins a new file with its header.
    ///
    /// # Errors
    /// [`StoreError::Write`]; a file that is there already is never written to, and one without a
    /// header is not left behind.
    pub fn create(path: &Path) -> Result<Self, StoreError> {
        let header = format!("{}\n", live_table::HEADER);
        let create = || {
            let mut file = File::options().append(true).create_new(true).open(path)?;
            file.write_all(header.as_bytes()).inspect_err(|_| {
                // Where that fails too, the error is that of the write.
                let _ = std::fs::remove_file(path);
            })?;
            Ok(file)
        };
        let file = create()
            .map_err(|cause: io::Error| StoreError::Write { file: path.to_owned(), cause })?;
        Ok(Self {
            path: path.to_owned(),
            file,
            line: Vec::new(),
            whole_bytes: header.len() as u64,
            samples: 0,
        })
    }

    /// Adds a sample. Where the line cannot be written whole, what was written of it is cut off again.
    ///
    /// # Errors
    /// [`StoreError::Write`].
    pub fn add(&mut self, sample: &LiveSample) -> Result<(), StoreError> {
        self.line.clear();
        live_table::write_row(&mut self.line, sample);
        if let Err(cause) = self.file.write_all(&self.line) {
            let cause = match self.file.set_len(self.whole_bytes) {
                Ok(()) => cause,
                Err(uncut) => io::Error::new(
                    cause.kind(),
                    format!("{cause}; the last line is cut, which cannot be mended: {uncut}"),
                ),
            };
            return Err(StoreError::Write { file: self.path.clone(), cause });
        }
        self.whole_bytes += self.line.len() as u64;
        self.samples += 1;
        Ok(())
    }

    pub fn samples(&self) -> u64 {
        self.samples
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_geometry::pose::Pose;

    #[test]
    fn a_recording_is_readable_while_it_grows_and_no_file_is_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("live.csv");
        let mut recorder = Recorder::create(&path).unwrap();
        for n in 1..4 {
            let sample = LiveSample {
                received_s: 1.0,
                time_s: Some(f64::from(n)),
                tool: "Stylus",
                pose: Ok(Pose::translation(f64::from(n), 0.0, 0.0)),
            };
            recorder.add(&sample).unwrap();
            // Without being told that it ends.
            let found = live_table::parse(&std::fs::read(&path).unwrap()).unwrap();
            assert_eq!(found.tools[0].good().count() as u64, recorder.samples());
        }
        let again = Recorder::create(&path).unwrap_err().to_string();
        assert!(again.contains("live.csv"), "{again}");
        assert_eq!(recorder.path(), path);
    }
}
