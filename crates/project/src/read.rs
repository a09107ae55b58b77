//! Reads files of a kind, from the disk or out of the program; every error names the file.

use super::builtin;
use super::error::StoreError;
use super::paths::{file_name, path_in_built_in, without_dots};
use std::borrow::Cow;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use trackwright_formats::{FormatError, foreign};

/// Largest table, recording or mesh that is read: a hundred times any real one.
pub(super) const MAX_BYTES: u64 = 1 << 30;

const MIB: u64 = 1 << 20;

/// A kind of file: what messages call it, with its article, and the largest that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kind {
    pub expected: &'static str,
    pub most_bytes: u64,
}

impl Kind {
    /// A hundred slides, and decisions on as many rooms as there may be, are less than 1 MiB.
    pub const DESIGN: Self = Self::new("a design", 16 * MIB);
    /// A maker's definition in it is at most 1 MiB, and all else some kilobytes.
    pub const BODY: Self = Self::new("a body", 16 * MIB);
    /// A body or what a maker's program wrote, whichever it is.
    pub const TOOL: Self = Self::new("a body or a tool definition", 16 * MIB);
    /// At the highest order it has 12 MiB of coefficients, and less than that of all else.
    pub const ENVIRONMENT: Self = Self::new("an environment", 64 * MIB);
    /// At most 32 coils, a line each.
    pub const GENERATOR: Self = Self::new("a field generator", MIB);
    /// Names of designs and rooms, and some lists of values.
    pub const SWEEP_PLAN: Self = Self::new("a plan of a sweep", 16 * MIB);
    /// A design and its two bodies, with each of their quotes escaped.
    pub const RECOVERY: Self = Self::new("a recovery file", 64 * MIB);
    /// Likewise.
    pub const BASELINE: Self = Self::new("a baseline", 64 * MIB);
    pub const PREFERENCES: Self = Self::new("preferences", MIB);
    pub const RECENT: Self = Self::new("a list of designs", MIB);

    const fn new(expected: &'static str, most_bytes: u64) -> Self {
        Self { expected, most_bytes }
    }
}

/// Any other kind: one with as many rows or triangles as were measured.
impl From<&'static str> for Kind {
    fn from(expected: &'static str) -> Self {
        Self::new(expected, MAX_BYTES)
    }
}

/// Where files are read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Storage {
    Disk,
    BuiltIn,
}

#[derive(Debug)]
pub(super) enum ReadFailure {
    Io(io::Error),
    TooLarge,
}

impl ReadFailure {
    pub(super) fn into_error(self, file: &Path, kind: impl Into<Kind>) -> StoreError {
        let Kind { expected, most_bytes } = kind.into();
        let file = file.to_owned();
        match self {
            Self::Io(cause) => StoreError::Read { file, expected, cause },
            Self::TooLarge => StoreError::TooLarge { file, limit: most_bytes, expected },
        }
    }
}

impl Storage {
    /// The bytes of a file. The built-in world has no absolute paths; those are the disk's.
    pub(super) fn read(
        self,
        file: &Path,
        kind: impl Into<Kind>,
    ) -> Result<Cow<'static, [u8]>, ReadFailure> {
        let most_bytes = kind.into().most_bytes;
        if self.is_on_disk(file) {
            return read_disk(file, most_bytes).map(Cow::Owned);
        }
        builtin::bytes(&without_dots(path_in_built_in(file).unwrap_or(file)))
            .map(Cow::Borrowed)
            .ok_or_else(|| ReadFailure::Io(io::ErrorKind::NotFound.into()))
    }

    /// The file that `reference`, written in `from`, means.
    pub(super) fn resolve(self, from: &Path, reference: &str) -> PathBuf {
        let joined = match path_in_built_in(Path::new(reference)) {
            Some(path) if self == Self::BuiltIn => path.to_owned(),
            Some(_) => reference.into(),
            None => from.parent().unwrap_or(Path::new("")).join(reference),
        };
        // `a/link/../b` is for the file system to work out, where `link` may lead elsewhere.
        match self.is_on_disk(&joined) {
            true => joined,
            false => without_dots(&joined),
        }
    }

    /// Whether a file can be changed by others: one of the built-in world, which the disk refers to as
    /// `builtin:/…` and which refers to the disk by absolute paths, cannot.
    pub(super) fn is_on_disk(self, file: &Path) -> bool {
        match self {
            Self::Disk => path_in_built_in(file).is_none(),
            Self::BuiltIn => file.is_absolute(),
        }
    }

    /// The built-in file that a path is, in the built-in world's own spelling.
    pub(super) fn built_in(self, file: &Path) -> Option<&'static str> {
        let inner = path_in_built_in(file).unwrap_or(file);
        (!self.is_on_disk(file)).then(|| builtin::path_of(inner)).flatten()
    }
}

fn read_disk(file: &Path, most_bytes: u64) -> Result<Vec<u8>, ReadFailure> {
    let file = open_input(file)?;
    // What is no regular file has no length beforehand.
    let length = file.metadata().map_or(0, |m| m.len());
    if length > most_bytes {
        return Err(ReadFailure::TooLarge);
    }
    // As long as it is, so that it is not copied while it grows; the last byte finds its end.
    let mut bytes = Vec::with_capacity(length as usize + 1);
    (file.take(most_bytes + 1).read_to_end(&mut bytes)).map_err(ReadFailure::Io)?;
    if bytes.len() as u64 > most_bytes {
        return Err(ReadFailure::TooLarge);
    }
    Ok(bytes)
}

/// Opens what is read: a file, or a pipe that somebody writes to already (`/dev/stdin`, or what a shell
/// makes of `<(…)`). Any other pipe would have to be waited for, and a device may never end.
///
/// # Errors
/// [`ReadFailure::Io`], which states what it is instead.
pub(super) fn open_input(file: &Path) -> Result<File, ReadFailure> {
    let metadata = fs::metadata(file).map_err(ReadFailure::Io)?;
    match special_kind(metadata.file_type()) {
        Some(PIPE) if is_own_descriptor(file) => {}
        Some(kind) => return Err(ReadFailure::Io(io::Error::other(kind))),
        None => {}
    }
    File::open(file).map_err(ReadFailure::Io)
}

const PIPE: &str = "a named pipe";

/// What is neither file nor folder, in words.
#[cfg(unix)]
fn special_kind(kind: fs::FileType) -> Option<&'static str> {
    use std::os::unix::fs::FileTypeExt;
    match kind {
        kind if kind.is_fifo() => Some(PIPE),
        kind if kind.is_char_device() || kind.is_block_device() => Some("a device"),
        kind if kind.is_socket() => Some("a socket"),
        _ => None,
    }
}

#[cfg(not(unix))]
fn special_kind(_: fs::FileType) -> Option<&'static str> {
    None
}

/// Whether a name means one of this process's open files.
fn is_own_descriptor(file: &Path) -> bool {
    file == Path::new("/dev/stdin")
        || ["/dev/fd", "/proc/self/fd"]
            .iter()
            .any(|folder| file.parent() == Some(Path::new(folder)))
}

/// Reads a file and parses it.
pub(super) fn read<T>(
    storage: Storage,
    file: &Path,
    kind: impl Into<Kind>,
    parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
) -> Result<T, StoreError> {
    let kind = kind.into();
    let bytes = storage.read(file, kind).map_err(|failure| failure.into_error(file, kind))?;
    parse(&bytes).map_err(|cause| not_of_its_kind(file, &bytes, kind.expected, cause))
}

/// Reads a file where there is one.
pub(super) fn read_if_there<T>(
    file: &Path,
    kind: Kind,
    parse: impl FnOnce(&[u8]) -> Result<T, FormatError>,
) -> Result<Option<T>, StoreError> {
    match read(Storage::Disk, file, kind, parse) {
        Err(StoreError::Read { cause, .. }) if cause.kind() == io::ErrorKind::NotFound => Ok(None),
        found => found.map(Some),
    }
}

/// The error of a file of another content: what it is, where that is known, else what is wrong.
pub(super) fn not_of_its_kind(
    file: &Path,
    head: &[u8],
    expected: &'static str,
    cause: FormatError,
) -> StoreError {
    StoreError::Format {
        file: file.to_owned(),
        cause: foreign::foreign(head, &file_name(file), expected).unwrap_or(cause),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files without content that only state how long they are: nothing of them is read.
    #[test]
    fn files_that_are_too_long_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let kinds = [
            Kind::DESIGN,
            Kind::BODY,
            Kind::TOOL,
            Kind::ENVIRONMENT,
            Kind::GENERATOR,
            Kind::RECOVERY,
            Kind::BASELINE,
            Kind::PREFERENCES,
            Kind::RECENT,
            Kind::from("a poses table"),
        ];
        for kind in kinds {
            let path = folder.path().join("long");
            let file = File::create(&path).unwrap();
            for length in [kind.most_bytes + 1, 2 << 30] {
                file.set_len(length).unwrap();
                let failure = Storage::Disk.read(&path, kind).unwrap_err();
                let expected = format!(
                    "found more than {} bytes, expected {}",
                    kind.most_bytes, kind.expected
                );
                let error = failure.into_error(&path, kind).to_string();
                assert!(error.ends_with(&expected), "{error}");
            }
            if kind.most_bytes <= 1 << 20 {
                file.set_len(kind.most_bytes).unwrap();
                let bytes = Storage::Disk.read(&path, kind).unwrap();
                assert_eq!(bytes.len() as u64, kind.most_bytes);
                assert!(matches!(bytes, Cow::Owned(bytes) if bytes.capacity() <= (1 << 20) + 64));
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn what_may_never_end_is_refused_by_its_kind() {
        let refused = |file: &Path| match read_disk(file, MAX_BYTES) {
            Err(failure) => failure.into_error(file, "a table").to_string(),
            Ok(_) => panic!("{} was read", file.display()),
        };
        for device in ["/dev/zero", "/dev/null"] {
            let expected = format!("{device}: found a device, expected a table");
            assert_eq!(refused(Path::new(device)), expected);
        }
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        assert!(refused(&socket).ends_with("found a socket, expected a table"));
        assert!(refused(folder.path()).ends_with("found a folder, expected a table"));
    }
}
