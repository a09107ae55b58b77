//! What a run leaves: the log of a study, the file of a report, a recording that grows, and the day
//! that a result is dated by.

use super::error::StoreError;
use super::files::Output;
use super::paths::folder_of;
use super::write::write_error;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use trackwright_design::Day;
use trackwright_formats::log;
use trackwright_formats::recording::live_table::{self, LiveSample};
use trackwright_simulation::{CancelToken, Mode, Scenario, Study, StudyError, Trial, study};

#[derive(Debug, thiserror::Error)]
pub enum LogError {
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// Runs a study while its trials are written, one row each; `visit` gets them too.
///
/// # Errors
/// Those of the study and of the file; no file appears then, and one that was there stays.
pub fn write_log(
    output: &Output,
    scenario: &Scenario,
    mode: &Mode,
    cancel: &CancelToken,
    visit: &mut dyn FnMut(&Trial),
) -> Result<Study, LogError> {
    let mut result: Option<Result<Study, StudyError>> = None;
    let written = output.write(|out| {
        log::write_header(out)?;
        let mut failure = None;
        let mut write = |trial: &Trial| {
            visit(trial);
            if failure.is_none()
                && let Err(error) = log::write_trial(out, trial)
            {
                failure = Some(error);
                cancel.cancel();
            }
        };
        let outcome = study(scenario, mode, cancel, Some(&mut write));
        if let Some(error) = failure {
            return Err(error);
        }
        let is_ok = outcome.is_ok();
        result = Some(outcome);
        match is_ok {
            true => Ok(()),
            false => Err(io::Error::other("no outcome")),
        }
    });
    match (result, written) {
        (Some(Err(study)), _) => Err(study.into()),
        (_, Err(store)) => Err(store.into()),
        (Some(Ok(outcome)), Ok(())) => Ok(outcome),
        // Whatever was written came with a result.
        (None, Ok(())) => Err(StudyError::NoTrials.into()),
    }
}

/// The file that a report is written to: `output` itself where its name ends in `.html`, or
/// `NAME.html` in the folder `output`, which is made where it isn't there.
///
/// # Errors
/// [`StoreError::Write`] where nothing can be written there.
pub fn report_file(output: &Path, name: &OsStr) -> Result<PathBuf, StoreError> {
    let fails = |cause: io::Error| write_error(output, cause);
    let file = match fs::metadata(output) {
        // A file of another kind is hardly meant, and no folder.
        Ok(there) if there.is_file() && !is_page(output) => {
            return Err(fails(io::ErrorKind::NotADirectory.into()));
        }
        Ok(there) if there.is_file() => output.to_owned(),
        // A pipe, a terminal.
        Ok(there) if !there.is_dir() => return Ok(output.to_owned()),
        Err(_) if is_page(output) => output.to_owned(),
        _ => {
            fs::create_dir_all(output).map_err(fails)?;
            let mut page = name.to_owned();
            page.push(".html");
            output.join(page)
        }
    };
    tempfile::tempfile_in(folder_of(&file)).map_err(fails)?;
    Ok(file)
}

fn is_page(file: &Path) -> bool {
    let extension = file.extension().and_then(OsStr::to_str);
    extension.is_some_and(|e| e.eq_ignore_ascii_case("html") || e.eq_ignore_ascii_case("htm"))
}

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
    /// Begins a new file with its header; one that is there already is never written to.
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
        let file = create().map_err(|cause| write_error(path, cause))?;
        Ok(Self {
            path: path.to_owned(),
            file,
            line: Vec::new(),
            whole_bytes: header.len() as u64,
            samples: 0,
        })
    }

    /// Adds a sample. Where the line cannot be written whole, what was written of it is cut off again.
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
            return Err(write_error(&self.path, cause));
        }
        self.whole_bytes += self.line.len() as u64;
        self.samples += 1;
        Ok(())
    }

    /// Samples that were added.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Set by whoever wants the same bytes again: seconds since 1970 that stand for today.
const DATE_VARIABLE: &str = "SOURCE_DATE_EPOCH";

/// A variable that holds no day.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{DATE_VARIABLE}: found {found:?}, expected seconds since 1970, within the years 0 to 9999"
)]
pub struct NoToday {
    pub found: String,
}

/// Today in Greenwich, or the day that stands for it.
pub fn today() -> Result<Day, NoToday> {
    let text = match std::env::var(DATE_VARIABLE) {
        Ok(text) => text,
        Err(_) => SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .map_or(0, |since| since.as_secs())
            .to_string(),
    };
    let seconds = text.trim().parse().ok();
    seconds.and_then(Day::of_unix_seconds).ok_or(NoToday { found: text })
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackwright_geometry::pose::Pose;

    #[test]
    fn a_recording_is_readable_while_it_grows() {
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
            // Without a call that ends it.
            let found = live_table::parse(&std::fs::read(&path).unwrap()).unwrap();
            assert_eq!(found.tools[0].good().count() as u64, recorder.samples());
        }
        let again = Recorder::create(&path).unwrap_err().to_string();
        assert!(again.contains("live.csv"), "{again}");
        assert_eq!(recorder.path(), path);
    }
}
