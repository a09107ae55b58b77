//! The checksum of a whole file: SHA-256 of all its bytes, in the last entry of its footer, where zeros stand
//! for the checksum itself.
//!
//! Parquet's own sums are of pages alone. This one is compared before anything of the file is parsed, so that
//! no damaged byte becomes a number.

use super::error::{SweepError, io_error};
use parquet::file::metadata::KeyValue;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

const KEY: &str = "trackwright.sha256";

/// What is before the letters of the checksum: the name of the entry, then in Parquet's compact form "the next
/// field is a text" and its length.
const MARK: &[u8] = b"trackwright.sha256\x18\x40";

/// Of the checksum, in hexadecimal.
const LETTERS: usize = 64;

/// How far from its end a file has the entry: behind it a footer only lists the order of each column.
const TAIL: u64 = 1 << 16;

/// Bytes that are read at once.
const STEP: usize = 1 << 18;

/// The entry of a file whose checksum is not known yet; it has to be the last one.
pub(crate) fn entry() -> KeyValue {
    KeyValue::new(KEY.to_owned(), "0".repeat(LETTERS))
}

/// Replaces the zeros of a file that is whole otherwise.
pub(crate) fn write(file: &mut File) -> io::Result<()> {
    let place = place(file)?.ok_or(io::ErrorKind::InvalidData)?;
    let sum = sum(file, &place)?;
    file.seek(SeekFrom::Start(place.start))?;
    file.write_all(sum.as_bytes())
}

/// Whether a file's bytes are those that were written.
///
/// # Errors
/// [`SweepError::NoSweep`] for a file without checksum, [`SweepError::Damaged`] for another one than that of
/// its bytes, and what the disk reports.
pub(crate) fn verify(path: &Path) -> Result<(), SweepError> {
    let mut file = File::open(path).map_err(io_error(path, "cannot be opened"))?;
    match is_whole(&mut file).map_err(io_error(path, "cannot be read"))? {
        Some(true) => Ok(()),
        Some(false) => Err(SweepError::Damaged { file: path.to_owned() }),
        None => Err(SweepError::NoSweep { file: path.to_owned() }),
    }
}

/// Whether a file has the checksum that it states; `None` where it states none.
fn is_whole(file: &mut (impl Read + Seek)) -> io::Result<Option<bool>> {
    let Some(place) = place(file)? else {
        return Ok(None);
    };
    let mut stated = [0; LETTERS];
    file.seek(SeekFrom::Start(place.start))?;
    file.read_exact(&mut stated)?;
    Ok(Some(stated == *sum(file, &place)?.as_bytes()))
}

/// Where a file has its checksum.
fn place(file: &mut (impl Read + Seek)) -> io::Result<Option<Range<u64>>> {
    let length = file.seek(SeekFrom::End(0))?;
    let from = length.saturating_sub(TAIL);
    file.seek(SeekFrom::Start(from))?;
    let mut tail = Vec::new();
    file.by_ref().take(TAIL).read_to_end(&mut tail)?;
    let mark = tail.windows(MARK.len()).rposition(|bytes| bytes == MARK);
    let place = mark.map(|at| from + (at + MARK.len()) as u64);
    Ok(place.map(|start| start..start + LETTERS as u64).filter(|place| place.end <= length))
}

/// Of all bytes, with zeros at one place.
fn sum(file: &mut (impl Read + Seek), place: &Range<u64>) -> io::Result<String> {
    file.seek(SeekFrom::Start(0))?;
    let mut digest = Sha256::new();
    let mut buffer = vec![0; STEP];
    let mut add = |part: &mut dyn Read| -> io::Result<()> {
        loop {
            match part.read(&mut buffer)? {
                0 => return Ok(()),
                count => digest.update(&buffer[..count]),
            }
        }
    };
    add(&mut file.by_ref().take(place.start))?;
    add(&mut [b'0'; LETTERS].as_slice())?;
    file.seek(SeekFrom::Start(place.end))?;
    add(file)?;
    Ok(hexadecimal(digest))
}

/// The letters of a digest.
pub(crate) fn hexadecimal(digest: Sha256) -> String {
    digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::super::shard::footer;
    use super::super::tests::{compute, merge_to, opened, sweep};
    use super::super::{SweepTable, is_merge_of};
    use super::*;
    use std::fs;
    use std::io::Cursor;

    const PLAN: &str = r#"(
        version: 1,
        designs: ["pointer-on-head"],
        vary: [Grid([(path: "tool.body.sensors[0].position.z", values: List([60, 72]))])],
        motions: [Single],
        figures: ["position_rms"],
    )"#;

    /// All eight bits of every byte, and every length: no reader of a sweep parses what this refuses.
    #[test]
    fn no_flipped_bit_gives_other_rows() {
        let (dir, sweep) = (tempfile::tempdir().unwrap(), sweep(PLAN));
        let folder = opened(&dir, "out", &sweep);
        compute(&sweep, &folder, "1/1");
        let shard = folder.coverage().unwrap().shards.remove(0).1;
        let rows = dir.path().join("rows.parquet");
        merge_to(&sweep, &folder, &rows).unwrap();
        let is_good = |bytes: &[u8]| is_whole(&mut Cursor::new(bytes)).unwrap() == Some(true);
        let whole = fs::read(&shard).unwrap();
        assert!(is_good(&whole));
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            for bit in 0..8 {
                bytes[at] = whole[at] ^ (1 << bit);
                assert!(!is_good(&bytes), "bit {bit} of byte {at}");
            }
            assert!(!is_good(&whole[..at]), "{at} bytes");
        }
        assert!(!is_good(&[whole.as_slice(), b"x"].concat()));
        // What a person calls, of files on the disk.
        for file in [&shard, &rows] {
            let whole = fs::read(file).unwrap();
            for at in (0..whole.len()).step_by(13) {
                let mut bytes = whole.clone();
                bytes[at] ^= 1 << (at % 8);
                fs::write(file, &bytes).unwrap();
                assert!(footer(file).is_err() && SweepTable::open(file).is_err(), "byte {at}");
                assert!(!is_merge_of(&sweep, file));
                if file == &shard {
                    assert!(folder.coverage().unwrap().torn.contains(&shard));
                    assert!(SweepTable::open(folder.path()).is_err());
                    assert!(merge_to(&sweep, &folder, &rows).is_err());
                }
            }
            fs::write(file, &whole).unwrap();
            assert_eq!(SweepTable::open(file).unwrap().numbers("row").unwrap(), [0.0, 1.0]);
        }
    }
}
