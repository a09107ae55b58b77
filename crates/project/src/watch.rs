//! Which files of an open design were changed by somebody else since they were read or written.

use super::read::Storage;
use super::reader::home;
use super::stamps::FileChange;
use super::world::World;
use std::path::PathBuf;
use trackwright_design::{BodyRole, Origin};

/// A file of the design that is not what it was when this program last read or wrote it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChangedFile {
    pub file: PathBuf,
    pub part: WatchedPart,
    pub change: FileChange,
}

/// What a file is to the design.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WatchedPart {
    Design,
    Environment,
    /// Another room that the design is judged in.
    FurtherRoom,
    Body(BodyRole),
    Mesh(BodyRole),
    /// A mesh of it.
    Anatomy,
    /// A mesh of the room's metal.
    Metal,
}

impl std::fmt::Display for WatchedPart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Design => f.write_str("design"),
            Self::Environment => f.write_str("environment"),
            Self::FurtherRoom => f.write_str("further room"),
            Self::Body(role) => write!(f, "{role}"),
            Self::Mesh(role) => write!(f, "{role} mesh"),
            Self::Anatomy => f.write_str("anatomy"),
            Self::Metal => f.write_str("metal"),
        }
    }
}

/// The files of the design that differ from what was read or written. A file whose time was
/// touched but not its content is none of them.
///
/// Looks at length and time of each file, and at its content only where those leave a doubt.
pub fn changes(world: &World) -> Vec<ChangedFile> {
    watched_files(world)
        .into_iter()
        .filter_map(|(part, file)| {
            let change = world.stamps.change_of(&file)?;
            Some(ChangedFile { file, part, change })
        })
        .collect()
}

/// States that what the files hold now was seen, and may be written over by the next Save.
pub fn accept_changes(world: &mut World) {
    for changed in changes(world) {
        match Storage::Disk.read(&changed.file, "a file") {
            Ok(bytes) => world.stamps.take(&changed.file, &bytes),
            Err(_) => world.stamps.forget(&changed.file),
        }
    }
}

/// The disk's files that the design is made of now.
pub(super) fn watched_files(world: &World) -> Vec<(WatchedPart, PathBuf)> {
    let document = &world.document;
    let design = document.design();
    let Ok((storage, own_file)) = home(document.origin()) else {
        return Vec::new();
    };
    let mut files = Vec::new();
    if let Origin::File(file) = document.origin() {
        files.push((WatchedPart::Design, file.clone()));
    }
    let environment = storage.resolve(&own_file, &design.environment);
    let metal = design.room_metal.as_deref();
    for mesh in metal.iter().flat_map(|metal| metal.mesh_files()) {
        push_new(&mut files, WatchedPart::Metal, storage.resolve(&environment, mesh));
    }
    files.push((WatchedPart::Environment, environment));
    for room in &design.procedure.further_rooms {
        // It may be the design's own room by another name.
        push_new(&mut files, WatchedPart::FurtherRoom, storage.resolve(&own_file, room));
    }
    for (role, body) in design.bodies() {
        let file = storage.resolve(&own_file, &body.reference);
        if let Some(mesh) = &body.mesh {
            files.push((WatchedPart::Mesh(role), storage.resolve(&file, &mesh.file)));
        }
        files.push((WatchedPart::Body(role), file));
    }
    for anatomy in &design.anatomy {
        // Several may show one file.
        push_new(&mut files, WatchedPart::Anatomy, storage.resolve(&own_file, &anatomy.mesh.file));
    }
    files.retain(|(_, file)| storage.is_on_disk(file));
    files
}

/// Adds a file that is not yet there as another part.
fn push_new(files: &mut Vec<(WatchedPart, PathBuf)>, part: WatchedPart, file: PathBuf) {
    if files.iter().all(|(_, other)| *other != file) {
        files.push((part, file));
    }
}

#[cfg(test)]
mod tests {
    use super::super::stamps::tests::change_secretly;
    use super::super::{
        StoreError, open_design, refresh_environment, save, save_as, save_with_copies,
    };
    use super::*;
    use crate::tests::saved_world;
    use std::fs::{self, File};
    use std::time::UNIX_EPOCH;
    use trackwright_design::{Edit, ProcedureEdit};

    fn found(world: &World) -> Vec<(WatchedPart, FileChange)> {
        changes(world).into_iter().map(|c| (c.part, c.change)).collect()
    }

    #[test]
    fn changed_files_are_named_and_touched_ones_not() {
        let (folder, world) = saved_world();
        let opened = open_design(&folder.path().join("a.design.ron")).unwrap();
        assert_eq!((found(&world), found(&opened)), (vec![], vec![]));
        let body = folder.path().join("pointer.body.ron");
        let touched = File::options().write(true).open(&body).unwrap();
        touched.set_modified(UNIX_EPOCH).unwrap();
        assert_eq!(found(&world), []);
        // Just written: equal length and time are no proof yet.
        change_secretly(&folder.path().join("operating-table.env.ron"));
        fs::write(folder.path().join("pointer.glb"), "").unwrap();
        fs::remove_file(folder.path().join("head-crf.body.ron")).unwrap();
        for world in [world, opened] {
            assert_eq!(
                found(&world),
                [
                    (WatchedPart::Environment, FileChange::Content),
                    (WatchedPart::Mesh(BodyRole::Tool), FileChange::Content),
                    (WatchedPart::Body(BodyRole::Crf), FileChange::Gone),
                ]
            );
        }
    }

    #[test]
    fn others_changes_are_not_written_over() {
        let (folder, mut world) = saved_world();
        let file = folder.path().join("a.design.ron");
        let theirs = fs::read_to_string(&file).unwrap() + "// theirs\n";
        world.document.apply(Edit::SetName("Mine".into())).unwrap();
        fs::write(&file, &theirs).unwrap();
        for save in [save, save_with_copies] {
            let error = save(&mut world).unwrap_err();
            assert!(matches!(error, StoreError::ChangedOnDisk { .. }), "{error}");
            assert!(world.document.is_dirty());
            assert_eq!(fs::read_to_string(&file).unwrap(), theirs);
        }
        accept_changes(&mut world);
        assert_eq!(found(&world), []);
        assert_eq!(save(&mut world).unwrap().written, std::slice::from_ref(&file));
        assert_eq!(found(&world), []);
        // A file that is gone stands in nobody's way.
        fs::remove_file(&file).unwrap();
        world.document.apply(Edit::SetName("Again".into())).unwrap();
        assert_eq!(found(&world), [(WatchedPart::Design, FileChange::Gone)]);
        save(&mut world).unwrap();
        assert_eq!(found(&world), []);
    }

    #[test]
    fn further_rooms_are_watched_like_the_first() {
        let (folder, mut world) = saved_world();
        let at = |name: &str| folder.path().join(name);
        fs::copy(at("operating-table.env.ron"), at("ward.env.ron")).unwrap();
        let add = Edit::Procedure(ProcedureEdit::AddRoom("ward.env.ron".into()));
        world.document.apply(add).unwrap();
        refresh_environment(&mut world).unwrap();
        save(&mut world).unwrap();
        let mut opened = open_design(&at("a.design.ron")).unwrap();
        change_secretly(&at("ward.env.ron"));
        let is_changed = [(WatchedPart::FurtherRoom, FileChange::Content)];
        assert_eq!((found(&world), found(&opened)), (is_changed.to_vec(), is_changed.to_vec()));
        accept_changes(&mut opened);
        assert_eq!(found(&opened), []);
        // One that no state of the design names any more is nobody's.
        world.document.undo();
        refresh_environment(&mut world).unwrap();
        assert_eq!(found(&world), []);
        // Missing from the start, it is missed where the design is judged.
        fs::remove_file(at("ward.env.ron")).unwrap();
        assert_eq!(found(&open_design(&at("a.design.ron")).unwrap()), []);
    }

    #[test]
    fn a_moved_design_watches_the_files_left_behind() {
        let (folder, mut world) = saved_world();
        let elsewhere = folder.path().join("deep");
        fs::create_dir(&elsewhere).unwrap();
        save_as(&mut world, &elsewhere.join("b.design.ron")).unwrap();
        assert_eq!(found(&world), []);
        fs::write(folder.path().join("head-crf.glb"), "").unwrap();
        let mesh = WatchedPart::Mesh(BodyRole::Crf);
        assert_eq!(found(&world), [(mesh, FileChange::Content)]);
    }
}
