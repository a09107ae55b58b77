//! Where files are: on the disk, or embedded in the program.

use super::builtin;
use super::error::StoreError;
use std::borrow::Cow;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

/// Largest table, recording or mesh that is read: a hundred times any real one, and no more than
/// memory holds.
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
    /// Of the highest order with the most orientations it has 12 MiB of coefficients, and less than
    /// that of all else.
    pub const ENVIRONMENT: Self = Self::new("an environment", 64 * MIB);
    /// At most 32 coils, a line each.
    pub const GENERATOR: Self = Self::new("a field generator", MIB);
    /// A design and its two bodies, with each of their quotes escaped.
    pub const RECOVERY: Self = Self::new("a recovery file", 64 * MIB);
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

/// Something to read files from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Disk,
    BuiltIn,
}

/// A file that cannot be read.
#[derive(Debug)]
pub(super) enum ReadFailure {
    Io(io::Error),
    TooLarge,
}

impl ReadFailure {
    /// The failure with the file's name.
    pub(super) fn into_error(self, file: &Path, kind: impl Into<Kind>) -> StoreError {
        let Kind { expected, most_bytes } = kind.into();
        let file = file.to_owned();
        match self {
            Self::Io(cause) => StoreError::Read { file, expected, cause },
            Self::TooLarge => StoreError::TooLarge { file, limit: most_bytes, expected },
        }
    }
}

impl Place {
    /// The bytes of a file. The built-in world has no absolute paths; those are the disk's.
    pub(super) fn read(
        self,
        file: &Path,
        kind: impl Into<Kind>,
    ) -> Result<Cow<'static, [u8]>, ReadFailure> {
        let most_bytes = kind.into().most_bytes;
        match self {
            Self::Disk => read_disk(file, most_bytes).map(Cow::Owned),
            Self::BuiltIn if file.is_absolute() => read_disk(file, most_bytes).map(Cow::Owned),
            Self::BuiltIn => builtin::bytes(&without_dots(file))
                .map(Cow::Borrowed)
                .ok_or_else(|| ReadFailure::Io(io::ErrorKind::NotFound.into())),
        }
    }

    /// The file that `reference`, written in `from`, means.
    pub(super) fn resolve(self, from: &Path, reference: &str) -> PathBuf {
        let joined = from.parent().unwrap_or(Path::new("")).join(reference);
        match self {
            // `a/link/../b` is for the file system to work out, where `link` may lead elsewhere.
            Self::Disk => joined,
            Self::BuiltIn => without_dots(&joined),
        }
    }
}

fn read_disk(file: &Path, most_bytes: u64) -> Result<Vec<u8>, ReadFailure> {
    let file = open_input(file)?;
    // Of what is no regular file the length is nothing that it tells beforehand.
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
/// [`ReadFailure::Io`], which says what it is instead.
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

/// The path with `.` and `..` worked out by name alone.
pub(super) fn without_dots(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => match out.components().next_back() {
                Some(Component::Normal(_)) => {
                    out.pop();
                }
                Some(Component::RootDir | Component::Prefix(_)) => {}
                _ => out.push(component),
            },
            _ => out.push(component),
        }
    }
    out
}

/// How a file in `folder` refers to `target`: relative with forward slashes, or absolute where
/// nothing is shared (another drive) or a name is not UTF-8.
pub(super) fn relative(folder: &Path, target: &Path) -> String {
    let (folder, target) = (absolute(folder), absolute(target));
    let mut from = folder.components().peekable();
    let mut to = target.components().peekable();
    while from.peek().is_some() && from.peek() == to.peek() {
        from.next();
        to.next();
    }
    if from.peek().is_some_and(|c| matches!(c, Component::Prefix(_))) {
        return target.to_string_lossy().into_owned();
    }
    let ups = from.map(|_| "..".to_owned());
    let downs = to.map(|c| c.as_os_str().to_string_lossy().into_owned());
    ups.chain(downs).collect::<Vec<_>>().join("/")
}

/// The path as the file system sees it, links followed, as far as it exists.
pub(super) fn absolute(path: &Path) -> PathBuf {
    if let Ok(path) = path.canonicalize() {
        return path;
    }
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    match (path.parent(), path.file_name()) {
        (Some(parent), Some(name)) => absolute(parent).join(name),
        _ => path,
    }
}

/// The path, or the first of `name-2.ext`, `name-3.ext`, … that will do.
pub(super) fn free_name(path: &Path, will_do: impl Fn(&PathBuf) -> bool) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    // "pointer.body.ron" is "pointer" and ".body.ron".
    let (stem, extension) = name.split_at(name.find('.').unwrap_or(name.len()));
    let mut candidate = path.to_owned();
    let mut number = 2;
    while !will_do(&candidate) {
        candidate = path.with_file_name(format!("{stem}-{number}{extension}"));
        number += 1;
    }
    candidate
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files without content that only say how long they are: nothing of them is read.
    #[test]
    fn files_that_are_too_long_are_refused_by_their_length() {
        let folder = tempfile::tempdir().unwrap();
        let kinds = [
            Kind::DESIGN,
            Kind::BODY,
            Kind::TOOL,
            Kind::ENVIRONMENT,
            Kind::GENERATOR,
            Kind::RECOVERY,
            Kind::PREFERENCES,
            Kind::RECENT,
            Kind::from("a poses table"),
        ];
        for kind in kinds {
            let path = folder.path().join("long");
            let file = File::create(&path).unwrap();
            for length in [kind.most_bytes + 1, 2 << 30] {
                file.set_len(length).unwrap();
                let failure = Place::Disk.read(&path, kind).unwrap_err();
                let expected = format!(
                    "found more than {} bytes, expected {}",
                    kind.most_bytes, kind.expected
                );
                let error = failure.into_error(&path, kind).to_string();
                assert!(error.ends_with(&expected), "{error}");
            }
            if kind.most_bytes <= 1 << 20 {
                file.set_len(kind.most_bytes).unwrap();
                let bytes = Place::Disk.read(&path, kind).unwrap();
                assert_eq!(bytes.len() as u64, kind.most_bytes);
                assert!(matches!(bytes, Cow::Owned(bytes) if bytes.capacity() <= (1 << 20) + 64));
            }
        }
    }

    #[test]
    fn dots_are_worked_out_by_name() {
        let clean = |s: &str| without_dots(Path::new(s)).display().to_string();
        assert_eq!(clean("designs/../assets/./a.glb"), "assets/a.glb");
        assert_eq!(clean("../x"), "../x");
        assert_eq!(clean("a/../../x"), "../x");
        assert_eq!(clean("/../x"), "/x");
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

    #[test]
    fn references_go_up_as_far_as_needed_and_down_again() {
        let relative = |from: &str, to: &str| relative(Path::new(from), Path::new(to));
        assert_eq!(relative("/nowhere/a/b", "/nowhere/a/b/x.ron"), "x.ron");
        assert_eq!(relative("/nowhere/a/b", "/nowhere/c/x.ron"), "../../c/x.ron");
        assert_eq!(relative("/nowhere", "/nowhere/c/x.ron"), "c/x.ron");
    }
}
