//! Recordings of trackers, in the formats that labs have them in.

pub mod aurora_log;
pub mod igs_mha;
pub mod live_table;
pub mod ndi_combined;
pub mod ndi_table;
mod rows;
pub mod sensor_log;

use super::error::{FormatError, quoted, text};
use trackwright_simulation::recording::Recording;

/// Whether the first lines are those of a recording that [`parse`] reads.
pub fn is_recording(bytes: &[u8]) -> bool {
    reader_of(bytes).is_some()
}

#[cfg(test)]
mod test_cuts;

type Reader = fn(&[u8]) -> Result<Recording, FormatError>;

fn reader_of(bytes: &[u8]) -> Option<Reader> {
    // A header is at the beginning; the rest may be anything, also the bytes of images.
    let head = bytes.get(..4096).unwrap_or(bytes);
    let head = String::from_utf8_lossy(head);
    let head = head.trim_start_matches('\u{feff}');
    if ndi_table::is_header(head.lines().next().unwrap_or("")) {
        Some(ndi_table::parse)
    } else if live_table::is_header(head.lines().next().unwrap_or("")) {
        Some(live_table::parse)
    } else if head.trim_start().starts_with("ObjectType") {
        Some(igs_mha::parse)
    } else if head.lines().take(10).any(aurora_log::is_header) {
        Some(aurora_log::parse)
    } else if head.lines().any(ndi_combined::is_header) {
        Some(ndi_combined::parse)
    } else if head.lines().take(10).any(sensor_log::is_sample) {
        Some(sensor_log::parse)
    } else {
        None
    }
}

/// Reads a recording: an NDI Track or ToolBox table, what NDI's combined API is read by, an Aurora
/// log, a PLUS sequence, a log of labelled lines, or a table of live poses.
///
/// ```
/// use trackwright_formats::recording;
///
/// let log = b"Sensor: a Position: 1 2 3 Orientation: 1 0 0 0 1 0 0 0 1\n";
/// let found = recording::parse(log)?;
/// assert_eq!(found.tools[0].good().count(), 1);
/// # Ok::<(), trackwright_formats::FormatError>(())
/// ```
///
/// # Errors
/// Those of the format that the first lines belong to, or that there is none.
pub fn parse(bytes: &[u8]) -> Result<Recording, FormatError> {
    let Some(reader) = reader_of(bytes) else {
        let expected = "the first lines of an NDI table, an Aurora log, a PLUS sequence, a log of \
            lines with Position: and Orientation:, or a live recording";
        let first = text(bytes)?.lines().next().unwrap_or("");
        return Err(FormatError::line(1, quoted(first), expected));
    };
    reader(bytes)
}
