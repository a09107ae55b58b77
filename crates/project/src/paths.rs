//! Paths as text and as files: how one refers to another, and which file a name leads to.

use std::fs::{self, File};
use std::io;
use std::path::{Component, Path, PathBuf};

/// How a room's file ends.
pub const ENVIRONMENT_EXTENSION: &str = ".env.ron";

/// What a file of the disk refers to a built-in one by: this and the path in the built-in world, as
/// `builtin:/assets/environments/operating-theatre.env.ron`.
const BUILT_IN: &str = "builtin:";

/// How a file of the disk refers to a built-in one.
pub(super) fn built_in_reference(path: &str) -> String {
    format!("{BUILT_IN}/{path}")
}

/// The path in the built-in world of what a file of the disk refers to there.
pub(super) fn path_in_built_in(path: &Path) -> Option<&Path> {
    path.strip_prefix(BUILT_IN).ok()
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

/// How a file in `folder` refers to `target`: relative with slashes, absolute on another drive and from the
/// built-in world. A link is referred to by its own name, wherever it leads.
pub(super) fn relative(folder: &Path, target: &Path) -> String {
    if path_in_built_in(target).is_some() {
        return target.to_string_lossy().into_owned();
    }
    let is_from_built_in = path_in_built_in(folder).is_some();
    let (folder, target) = (absolute(folder), in_real_folder(target));
    let mut from = folder.components().peekable();
    let mut to = target.components().peekable();
    while from.peek().is_some() && from.peek() == to.peek() {
        from.next();
        to.next();
    }
    if is_from_built_in || from.peek().is_some_and(|c| matches!(c, Component::Prefix(_))) {
        return target.to_string_lossy().into_owned();
    }
    let ups = from.map(|_| "..".to_owned());
    let downs = to.map(|c| c.as_os_str().to_string_lossy().into_owned());
    ups.chain(downs).collect::<Vec<_>>().join("/")
}

/// The path as the file system sees it, links followed, as far as it exists; one of the built-in world as
/// it is.
pub(super) fn absolute(path: &Path) -> PathBuf {
    if path_in_built_in(path).is_some() {
        return path.to_owned();
    }
    if let Ok(path) = path.canonicalize() {
        return path;
    }
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    match (path.parent(), path.file_name()) {
        (Some(parent), Some(name)) => absolute(parent).join(name),
        _ => path,
    }
}

/// The file's name in its folder's real place, which is the same whether or not the file exists.
pub(super) fn in_real_folder(file: &Path) -> PathBuf {
    match (file.parent(), file.file_name()) {
        (Some(folder), Some(name)) if folder == Path::new("") => {
            absolute(Path::new(".")).join(name)
        }
        (Some(folder), Some(name)) => absolute(folder).join(name),
        _ => absolute(file),
    }
}

/// The path, or the first of `name-2.ext`, `name-3.ext`, … that will do.
pub(super) fn free_name(path: &Path, will_do: impl Fn(&PathBuf) -> bool) -> PathBuf {
    let name = file_name(path);
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

/// The folder of a file, never empty.
pub(super) fn folder_of(file: &Path) -> PathBuf {
    match file.parent() {
        Some(folder) if folder != Path::new("") => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// What a person calls a file: its name without its folder; of a path without a name, such as `/`,
/// all of it.
pub fn file_name(file: &Path) -> String {
    file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned()
}

/// The files of a folder whose names end so, in order.
pub(super) fn files_ending(folder: &Path, ending: &str) -> io::Result<Vec<PathBuf>> {
    let mut files: Vec<_> = fs::read_dir(folder)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.to_string_lossy().ends_with(ending))
        .collect();
    files.sort();
    Ok(files)
}

pub(super) fn extension_of(file: &Path) -> String {
    file.extension().unwrap_or_default().to_string_lossy().into_owned()
}

/// A file by what the system knows it by: hard and symbolic links to one file are equal.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum FileId {
    #[cfg(unix)]
    Node(u64, u64),
    Path(PathBuf),
}

impl FileId {
    pub(super) fn of(file: &Path) -> Self {
        #[cfg(unix)]
        if let Ok(metadata) = fs::metadata(file) {
            return Self::of_metadata(&metadata);
        }
        Self::Path(absolute(file))
    }

    #[cfg(unix)]
    fn of_metadata(metadata: &fs::Metadata) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self::Node(metadata.dev(), metadata.ino())
    }
}

/// Whether a name still leads to the file that was opened by it.
#[cfg(unix)]
pub(super) fn is_still(handle: &File, file: &Path) -> io::Result<bool> {
    let opened = FileId::of_metadata(&handle.metadata()?);
    match fs::metadata(file) {
        Ok(there) => Ok(FileId::of_metadata(&there) == opened),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Names do not move there while a file is open.
#[cfg(not(unix))]
pub(super) fn is_still(_: &File, file: &Path) -> io::Result<bool> {
    fs::exists(file)
}

/// `room` of `folder/room.env.ron`.
///
/// ```
/// use std::path::Path;
/// use trackwright_project::room_name;
/// assert_eq!(room_name(Path::new("a/room.env.ron")), "room");
/// assert_eq!(room_name(Path::new("a/room.ron")), "room");
/// assert_eq!(room_name(Path::new("a/cube-fit")), "cube-fit");
/// ```
pub fn room_name(file: &Path) -> String {
    let name = file_name(file);
    let stem = name.strip_suffix(".ron").unwrap_or(&name);
    stem.strip_suffix(".env").unwrap_or(stem).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_are_resolved_by_name() {
        let clean = |s: &str| without_dots(Path::new(s)).display().to_string();
        assert_eq!(clean("designs/../assets/./a.glb"), "assets/a.glb");
        assert_eq!(clean("../x"), "../x");
        assert_eq!(clean("a/../../x"), "../x");
        assert_eq!(clean("/../x"), "/x");
    }

    #[test]
    fn references_go_up_only_as_far_as_needed() {
        let relative = |from: &str, to: &str| relative(Path::new(from), Path::new(to));
        assert_eq!(relative("/nowhere/a/b", "/nowhere/a/b/x.ron"), "x.ron");
        assert_eq!(relative("/nowhere/a/b", "/nowhere/c/x.ron"), "../../c/x.ron");
        assert_eq!(relative("/nowhere", "/nowhere/c/x.ron"), "c/x.ron");
    }

    #[test]
    fn the_built_in_world_is_reached_from_the_disk() {
        let room = built_in_reference("assets/environments/a.env.ron");
        assert_eq!(relative(Path::new("/nowhere"), Path::new(&room)), room);
        let folder = Path::new(&room).parent().unwrap();
        assert_eq!(relative(folder, Path::new("/nowhere/a.stl")), "/nowhere/a.stl");
        assert_eq!(absolute(Path::new(&room)), Path::new(&room));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_referred_to_by_its_own_name() {
        let folder = tempfile::tempdir().unwrap();
        let (here, far) = (folder.path().join("here"), folder.path().join("far"));
        fs::create_dir(&here).unwrap();
        fs::create_dir(&far).unwrap();
        fs::write(far.join("scan-7.obj"), "").unwrap();
        std::os::unix::fs::symlink(far.join("scan-7.obj"), here.join("head.obj")).unwrap();
        assert_eq!(relative(&here, &here.join("head.obj")), "head.obj");
    }
}
