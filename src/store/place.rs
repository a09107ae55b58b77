//! Where files are: on the disk, or embedded in the program.

use super::builtin;
use super::error::StoreError;
use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

/// Largest file that is read: a hundred times any real one, and no more than memory holds.
pub(super) const MAX_BYTES: u64 = 1 << 30;

/// Something to read files from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Disk,
    BuiltIn,
}

/// A file that cannot be read.
pub(super) enum ReadFailure {
    Io(io::Error),
    TooLarge,
}

impl ReadFailure {
    /// The failure with the file's name; `expected` is the kind of file, with its article.
    pub(super) fn into_error(self, file: &Path, expected: &'static str) -> StoreError {
        let file = file.to_owned();
        match self {
            Self::Io(cause) => StoreError::Read {
                file,
                expected,
                cause,
            },
            Self::TooLarge => StoreError::TooLarge {
                file,
                limit: MAX_BYTES,
                expected,
            },
        }
    }
}

impl Place {
    /// The bytes of a file. The built-in world has no absolute paths; those are the disk's.
    pub(super) fn read(self, file: &Path) -> Result<Cow<'static, [u8]>, ReadFailure> {
        match self {
            Self::Disk => read_disk(file).map(Cow::Owned),
            Self::BuiltIn if file.is_absolute() => read_disk(file).map(Cow::Owned),
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

fn read_disk(file: &Path) -> Result<Vec<u8>, ReadFailure> {
    let mut bytes = Vec::new();
    File::open(file)
        .and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes))
        .map_err(ReadFailure::Io)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(ReadFailure::TooLarge);
    }
    Ok(bytes)
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
    if from
        .peek()
        .is_some_and(|c| matches!(c, Component::Prefix(_)))
    {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_are_worked_out_by_name() {
        let clean = |s: &str| without_dots(Path::new(s)).display().to_string();
        assert_eq!(clean("designs/../assets/./a.glb"), "assets/a.glb");
        assert_eq!(clean("../x"), "../x");
        assert_eq!(clean("a/../../x"), "../x");
        assert_eq!(clean("/../x"), "/x");
    }

    #[test]
    fn references_go_up_as_far_as_needed_and_down_again() {
        let relative = |from: &str, to: &str| relative(Path::new(from), Path::new(to));
        assert_eq!(relative("/nowhere/a/b", "/nowhere/a/b/x.ron"), "x.ron");
        assert_eq!(
            relative("/nowhere/a/b", "/nowhere/c/x.ron"),
            "../../c/x.ron"
        );
        assert_eq!(relative("/nowhere", "/nowhere/c/x.ron"), "c/x.ron");
    }
}
