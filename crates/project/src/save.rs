//! Saves a design and its bodies: only what changed, bodies first, each file whole or not at all; and
//! which other designs that would change.

use super::error::StoreError;
use super::other_designs::other_designs;
use super::paths::{absolute, file_name, folder_of, free_name, relative};
use super::read::{Kind, Storage};
use super::reader::home;
use super::save_room::{RoomMove, changed_room, is_room_changed, with_meshes};
use super::stamps::Stamps;
use super::tool::{body_name, body_text, is_definition, parse_body, reach_mesh};
use super::world::World;
use super::write::{KeptFile, keep_former, lock_all, replace, write_bytes};
use std::fs;
use std::path::{Path, PathBuf};
use trackwright_design::{BodyRole, Design, DesignBody, Origin, View};
use trackwright_formats::{DesignFile, body, design_file, environment};

/// Kinds of files that are copied out of the built-in world.
const MESH: &str = "a mesh";
const ENVIRONMENT: &str = "an environment";

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SaveReport {
    /// The files written, in order; none where nothing had changed.
    pub written: Vec<PathBuf>,
    /// Files that held what this program does not write.
    pub kept: Vec<KeptFile>,
}

/// Saves a design where it came from: changed bodies first, then the design itself if it changed.
///
/// A maker's tool definition is never written over: a body from one that changed is saved beside the
/// design, which refers to it from then on. Nor is a file that was there before a body took its name.
///
/// # Errors
/// [`StoreError::ReadOnly`] for a built-in design, [`StoreError::BodiesDiffer`],
/// [`StoreError::ChangedOnDisk`] where somebody else wrote a file meanwhile
/// ([`accept_changes`](super::accept_changes) lets it be written over), or a file that could not
/// be written; the document then still counts as changed.
pub fn save(world: &mut World) -> Result<SaveReport, StoreError> {
    let file = own_file(world)?;
    save_moved(world, &file, moved_bodies(world, &file))
}

/// Saves like [`save`], except that changed bodies which other designs use are saved as copies.
pub fn save_with_copies(world: &mut World) -> Result<SaveReport, StoreError> {
    let file = own_file(world)?;
    let mut moves = moved_bodies(world, &file);
    for shared in shared_bodies(world) {
        let is_free = |path: &PathBuf| !path.exists() && moves.iter().all(|m| m.file != *path);
        let copy = free_name(&shared.file, is_free);
        let body = world.document.design().body(shared.role);
        moves.push(BodyMove {
            role: shared.role,
            old_reference: body.map_or_else(String::new, |body| body.reference.clone()),
            old_file: shared.file,
            file: copy,
        });
    }
    save_moved(world, &file, moves)
}

/// A body that is saved as another file than the one that it came from.
struct BodyMove {
    role: BodyRole,
    /// What the states that move with it refer to.
    old_reference: String,
    old_file: PathBuf,
    file: PathBuf,
}

/// The changed bodies whose files are others', each with a free name beside the design.
fn moved_bodies(world: &World, design_file: &Path) -> Vec<BodyMove> {
    let folder = folder_of(design_file);
    let mut moves: Vec<BodyMove> = Vec::new();
    for (role, body) in world.document.design().bodies() {
        let old_file = Storage::Disk.resolve(design_file, &body.reference);
        if !is_changed(world, role) || !is_left_alone(world, role, &old_file) {
            continue;
        }
        let is_free = |path: &PathBuf| !path.exists() && moves.iter().all(|m| m.file != *path);
        let file = free_name(&folder.join(own_name(&old_file)), is_free);
        moves.push(BodyMove { role, old_reference: body.reference.clone(), old_file, file });
    }
    moves
}

/// Whether Save leaves the file that a body refers to as it is: a maker's, or one that was there
/// before the body, new in the design, took its name.
pub(super) fn is_left_alone(world: &World, role: BodyRole, file: &Path) -> bool {
    let reference = |body: &DesignBody| body.reference.clone();
    let saved = world.document.saved();
    let saved = saved.and_then(|(design, _)| design.body(role).map(reference));
    let is_new = saved != world.document.design().body(role).map(reference);
    is_definition(file) || (is_new && file.exists() && !world.stamps.knows(file))
}

/// What a body's own file is called: the body of a definition has another name than that.
fn own_name(file: &Path) -> String {
    match is_definition(file) {
        true => body_name(file),
        false => file_name(file),
    }
}

/// Saves with some bodies as other files, which every state of the document refers to then.
fn save_moved(
    world: &mut World,
    file: &Path,
    moves: Vec<BodyMove>,
) -> Result<SaveReport, StoreError> {
    let room = RoomMove::of(world, file);
    let has_moves = !moves.is_empty() || room.is_some();
    let before = world.document.clone();
    if has_moves {
        let folder = folder_of(file);
        world.document.relocate(Origin::File(file.to_owned()), |design| {
            for moved in &moves {
                if let Some(body) = design.body_mut(moved.role)
                    && body.reference == moved.old_reference
                {
                    body.reference = relative(&folder, &moved.file);
                    reach_mesh(&mut body.mesh, &moved.old_file, &moved.file);
                }
            }
            if let Some(room) = &room {
                room.rewrite(design, &folder);
            }
        });
    }
    match write_changes(world, file, has_moves, room.as_ref()) {
        Ok(report) => {
            world.document.mark_saved();
            if room.is_some() {
                world.environment_is_current();
            }
            Ok(report)
        }
        Err(error) => {
            world.document = before;
            Err(error)
        }
    }
}

/// Saves a design as another file, which is the document's own from then on.
///
/// What came from the disk stays where it is and is referred to from the new place by a relative
/// path, except for bodies that changed: those are saved beside the new design, so that the old one
/// stays as it is. From the built-in world everything is saved beside the new design.
///
/// # Errors
/// A file that could not be read or written, or [`StoreError::InUse`]; the document is then as
/// it was.
pub fn save_as(world: &mut World, file: &Path) -> Result<SaveReport, StoreError> {
    if let Origin::File(own) = world.document.origin()
        && absolute(own) == absolute(file)
    {
        return save(world);
    }
    let (storage, old_file) = home(world.document.origin())?;
    refuse_own_parts(world, storage, &old_file, file)?;
    let mut mover = Mover {
        storage,
        old_file,
        folder: folder_of(file),
        report: SaveReport::default(),
        stamps: Stamps::default(),
    };
    let design = world.document.design();
    let mut moved = Vec::new();
    for (role, body) in design.bodies() {
        let at = mover.move_body(body, is_changed(world, role))?;
        moved.push((role, body.reference.clone(), at));
    }
    let mut moved_anatomy: Vec<(String, String)> = Vec::new();
    for anatomy in &design.anatomy {
        let old = &anatomy.mesh.file;
        if moved_anatomy.iter().all(|(moved, _)| moved != old) {
            moved_anatomy.push((old.clone(), mover.move_file(old, MESH)?));
        }
    }
    let own_room = mover.move_room(world)?;
    let mut rooms = vec![(design.environment.clone(), own_room.reference.clone())];
    for room in &design.procedure.further_rooms {
        // One that is not there was missed before, and is no reason not to save.
        let moved = mover.move_file(room, ENVIRONMENT);
        rooms.extend(moved.ok().map(|moved| (room.clone(), moved)));
    }
    let anatomy_file = |old: &str| {
        let moved = moved_anatomy.iter().find(|(moved, _)| moved == old);
        moved.map_or_else(|| mover.reference(old), |(_, now)| now.clone())
    };
    let rewrite = |design: &mut Design| {
        for role in BodyRole::ALL {
            let Some(body) = design.body_mut(role) else {
                continue;
            };
            let is_it = |(own, old, _): &&(BodyRole, String, MovedBody)| {
                *own == role && *old == body.reference
            };
            let Some((_, _, moved)) = moved.iter().find(is_it) else {
                mover.move_past_body(body);
                continue;
            };
            body.reference.clone_from(&moved.reference);
            if let Some(mesh) = &mut body.mesh {
                mesh.file = mover.mesh_from(moved, &mesh.file);
            }
        }
        for anatomy in &mut design.anatomy {
            anatomy.mesh.file = anatomy_file(&anatomy.mesh.file);
        }
        own_room.rewrite_metal(design);
        let references = design.procedure.references_mut();
        for reference in references.chain([&mut design.environment]) {
            let moved = rooms.iter().find(|(old, _)| old == reference);
            *reference = match moved {
                Some((_, moved)) => moved.clone(),
                None => mover.reference(reference),
            };
        }
    };
    let mut copy = design.clone();
    rewrite(&mut copy);
    let text = design_text(&copy, world.document.own_view());
    write_bytes(file, text.as_bytes())?;
    world.document.relocate(Origin::File(file.to_owned()), rewrite);
    world.document.mark_saved();
    world.references_are_current(anatomy_file);
    mover.stamps.take(file, text.as_bytes());
    world.stamps.extend(mover.stamps);
    mover.report.written.push(file.to_owned());
    Ok(mover.report)
}

/// Whether Save would write the body of a role.
pub(super) fn is_changed(world: &World, role: BodyRole) -> bool {
    let Some(body) = world.document.design().body(role) else {
        return false;
    };
    let saved = world.document.saved();
    match saved.and_then(|(design, _)| design.body(role)) {
        Some(saved) if saved.reference == body.reference => body_text(saved) != body_text(body),
        // Another body, which may be what its file holds already.
        _ => !is_held(world, body),
    }
}

/// Whether the file that a body refers to has the same content.
fn is_held(world: &World, body: &DesignBody) -> bool {
    let Origin::File(design_file) = world.document.origin() else {
        return false;
    };
    let file = Storage::Disk.resolve(design_file, &body.reference);
    let Ok(bytes) = Storage::Disk.read(&file, Kind::BODY) else {
        return false;
    };
    parse_body(&file, &bytes).is_ok_and(|held| body::write(&held) == body_text(body))
}

fn own_file(world: &World) -> Result<PathBuf, StoreError> {
    match world.document.origin() {
        Origin::BuiltIn(name) => Err(StoreError::ReadOnly(name)),
        Origin::File(file) => Ok(file.clone()),
    }
}

fn design_text(design: &Design, view: &View) -> String {
    design_file::write(&DesignFile::of(design, view))
}

fn write_changes(
    world: &mut World,
    file: &Path,
    is_design_changed: bool,
    room: Option<&RoomMove>,
) -> Result<SaveReport, StoreError> {
    let design = world.document.design();
    let bodies: Vec<_> = design
        .bodies()
        .map(|(role, body)| {
            let body_file = Storage::Disk.resolve(file, &body.reference);
            (body_file, body_text(body), is_changed(world, role))
        })
        .collect();
    if let [(tool_file, tool, _), (crf_file, crf, _)] = &bodies[..]
        && tool != crf
        && absolute(tool_file) == absolute(crf_file)
    {
        return Err(StoreError::BodiesDiffer { file: tool_file.clone() });
    }
    let mut texts: Vec<(PathBuf, String)> = Vec::new();
    for (body_file, text, is_changed) in bodies {
        if is_changed && texts.iter().all(|(file, _)| *file != body_file) {
            texts.push((body_file, text));
        }
    }
    let room_text = || environment::write(&world.bare, design.room_metal.as_deref());
    texts.extend(match room {
        Some(room) => Some((room.file.clone(), room_text())),
        None => changed_room(world, file),
    });
    let text = design_text(design, world.document.own_view());
    let saved = world.document.saved();
    if is_design_changed || saved.is_none_or(|(design, view)| design_text(design, view) != text) {
        texts.push((file.to_owned(), text));
    }
    let replaced = lock_all(&texts)?;
    for (file, _) in &texts {
        world.stamps.check_unchanged(file)?;
    }
    let mut report = SaveReport::default();
    for (file, text) in texts {
        report.kept.extend(keep_former(&file)?);
        replace(&file, text.as_bytes(), replaced.contains_key(&absolute(&file)))?;
        // At once, so that what was written before another file failed counts as known too.
        world.stamps.take(&file, text.as_bytes());
        report.written.push(file);
    }
    Ok(report)
}

/// Refuses to write a design over its own body or environment.
fn refuse_own_parts(
    world: &World,
    storage: Storage,
    old_file: &Path,
    file: &Path,
) -> Result<(), StoreError> {
    let design = world.document.design();
    let mut parts = design
        .bodies()
        .map(|(_, body)| &body.reference)
        .chain([&design.environment])
        .chain(&design.procedure.further_rooms)
        .map(|reference| storage.resolve(old_file, reference));
    let file = absolute(file);
    if storage == Storage::Disk && parts.any(|part| absolute(&part) == file) {
        return Err(StoreError::InUse { file });
    }
    Ok(())
}

/// Where a body is after Save as.
struct MovedBody {
    /// From the new folder.
    reference: String,
    /// Whether it was saved beside the new design.
    is_copied: bool,
    old_file: PathBuf,
    /// The mesh that was copied with it: its reference before and after.
    copied_mesh: Option<(String, String)>,
}

/// Brings what a design refers to within reach of a new folder.
struct Mover {
    storage: Storage,
    old_file: PathBuf,
    folder: PathBuf,
    report: SaveReport,
    stamps: Stamps,
}

/// Where the room is after Save as.
struct MovedRoom {
    old_reference: String,
    /// From the new folder.
    reference: String,
    /// What the metal's meshes were referred to by and are now; `None` where its file stays.
    meshes: Option<Vec<(String, String)>>,
}

impl MovedRoom {
    /// Lets a state's metal refer to its meshes from the new place; before its room does.
    fn rewrite_metal(&self, design: &mut Design) {
        let Some(meshes) = &self.meshes else { return };
        if design.environment != self.old_reference {
            return;
        }
        let moved = design.room_metal.as_ref().map(|metal| {
            with_meshes(metal, |old| {
                let moved = meshes.iter().find(|(known, _)| known == old);
                moved.map_or_else(|| old.to_owned(), |(_, now)| now.clone())
            })
        });
        design.room_metal = moved;
    }
}

impl Mover {
    /// A room with metal of the built-in world, or one whose metal changed, is saved beside the new design.
    fn move_room(&mut self, world: &World) -> Result<MovedRoom, StoreError> {
        let design = world.document.design();
        let old_reference = design.environment.clone();
        let is_changed = is_room_changed(world);
        let is_kept = match self.storage {
            Storage::Disk => !is_changed,
            Storage::BuiltIn => !is_changed && design.room_metal.is_none(),
        };
        if is_kept {
            let reference = self.move_file(&old_reference, ENVIRONMENT)?;
            return Ok(MovedRoom { old_reference, reference, meshes: None });
        }
        let old_file = self.storage.resolve(&self.old_file, &old_reference);
        let mut meshes = Vec::new();
        for mesh in design.room_metal.iter().flat_map(|metal| metal.mesh_files()) {
            let moved = match self.copy_built_in(&old_file, mesh, MESH)? {
                Some(copy) => copy,
                None => relative(&self.folder, &Storage::Disk.resolve(&old_file, mesh)),
            };
            meshes.push((mesh.to_owned(), moved));
        }
        let mut moved = MovedRoom { old_reference, reference: String::new(), meshes: Some(meshes) };
        let mut copy = design.clone();
        moved.rewrite_metal(&mut copy);
        let text = environment::write(&world.bare, copy.room_metal.as_deref());
        moved.reference = self.copy(&moved.old_reference, text.as_bytes())?;
        Ok(moved)
    }

    fn move_body(&mut self, body: &DesignBody, is_changed: bool) -> Result<MovedBody, StoreError> {
        let old_file = self.storage.resolve(&self.old_file, &body.reference);
        let mut moved = MovedBody {
            reference: String::new(),
            is_copied: self.storage == Storage::BuiltIn || is_changed,
            old_file,
            copied_mesh: None,
        };
        if !moved.is_copied {
            moved.reference = relative(&self.folder, &moved.old_file);
            return Ok(moved);
        }
        let mut copy = body.clone();
        if let Some(mesh) = &mut copy.mesh {
            let copy = self.copy_built_in(&moved.old_file, &mesh.file, MESH)?;
            moved.copied_mesh = copy.map(|copy| (mesh.file.clone(), copy));
            mesh.file = self.mesh_from(&moved, &mesh.file);
        }
        // A maker's definition that changed is a body file from now on.
        let name = match self.storage == Storage::Disk && is_definition(&moved.old_file) {
            true => body_name(&moved.old_file),
            false => body.reference.clone(),
        };
        moved.reference = self.copy(&name, body_text(&copy).as_bytes())?;
        Ok(moved)
    }

    /// Refers to a past state's body from the new folder; one without a file will be saved there.
    fn move_past_body(&self, body: &mut DesignBody) {
        let old_file = self.storage.resolve(&self.old_file, &body.reference);
        if self.storage == Storage::Disk && old_file.exists() {
            body.reference = relative(&self.folder, &old_file);
            return;
        }
        body.reference = file_name(&old_file);
        if let Some(mesh) = &mut body.mesh
            && self.is_in_reach(&mesh.file)
        {
            mesh.file = relative(&self.folder, &Storage::Disk.resolve(&old_file, &mesh.file));
        }
    }

    /// What a mesh of a body, a past one too, is referred to by from where the body is now.
    fn mesh_from(&self, body: &MovedBody, mesh: &str) -> String {
        match &body.copied_mesh {
            Some((old, copy)) if old == mesh => copy.clone(),
            // On the disk, and its body's file is written anew.
            _ if body.is_copied && self.is_in_reach(mesh) => {
                relative(&self.folder, &Storage::Disk.resolve(&body.old_file, mesh))
            }
            // It stayed where it is, or it is only ever undone to.
            _ => mesh.to_owned(),
        }
    }

    /// Copies what only a file of the built-in world could refer to; its name, `None` of what is within
    /// reach. A mesh that is not there was missed before, and is no reason not to save.
    fn copy_built_in(
        &mut self,
        from: &Path,
        reference: &str,
        kind: &'static str,
    ) -> Result<Option<String>, StoreError> {
        if self.is_in_reach(reference) {
            return Ok(None);
        }
        let file = self.storage.resolve(from, reference);
        match self.storage.read(&file, kind) {
            Ok(bytes) => self.copy(&file.to_string_lossy(), &bytes).map(Some),
            Err(_) if kind == MESH => Ok(None),
            Err(failure) => Err(failure.into_error(&file, kind)),
        }
    }

    /// A file's reference from the new folder, to where it was copied if it had to be.
    fn move_file(&mut self, reference: &str, kind: &'static str) -> Result<String, StoreError> {
        let old_file = self.old_file.clone();
        let copy = self.copy_built_in(&old_file, reference, kind)?;
        Ok(copy.unwrap_or_else(|| self.reference(reference)))
    }

    /// Writes a copy into the new folder under its old name, or a free one like it; the name.
    fn copy(&mut self, old_reference: &str, bytes: &[u8]) -> Result<String, StoreError> {
        let name = Path::new(old_reference).file_name().unwrap_or_default();
        let is_same = |path: &Path| fs::read(path).is_ok_and(|found| found == bytes);
        let copy = loop {
            let copy = free_name(&self.folder.join(name), |path| !path.exists() || is_same(path));
            if is_same(&copy) {
                break copy;
            }
            match replace(&copy, bytes, false) {
                Ok(()) => {
                    self.report.written.push(copy.clone());
                    break copy;
                }
                // Somebody else was first with that name.
                Err(StoreError::ChangedOnDisk { .. }) => {}
                Err(error) => return Err(error),
            }
        };
        self.stamps.take(&copy, bytes);
        Ok(file_name(&copy))
    }

    /// What a reference of the old design's is from the new folder.
    fn reference(&self, reference: &str) -> String {
        match self.is_in_reach(reference) {
            true => relative(&self.folder, &Storage::Disk.resolve(&self.old_file, reference)),
            // Only ever undone to; nothing else of the built-in world is copied.
            false => reference.to_owned(),
        }
    }

    /// Whether a file of the disk can refer to it as well. The built-in world refers to files of the disk by
    /// the whole path; what it refers to by a relative one is its own.
    fn is_in_reach(&self, reference: &str) -> bool {
        self.storage == Storage::Disk || Path::new(reference).is_absolute()
    }
}

/// A changed body that other designs use too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SharedBody {
    pub role: BodyRole,
    pub file: PathBuf,
    /// The other designs of the folder that use it, in order of their names.
    pub designs: Vec<PathBuf>,
}

/// The bodies that Save would change and that other designs of the folder use.
pub fn shared_bodies(world: &World) -> Vec<SharedBody> {
    let Origin::File(own_file) = world.document.origin() else {
        return Vec::new();
    };
    let design = world.document.design();
    let changed: Vec<_> = design
        .bodies()
        .filter(|(role, _)| is_changed(world, *role))
        .map(|(role, body)| (role, Storage::Disk.resolve(own_file, &body.reference)))
        // Save leaves it as it is, and so the others too.
        .filter(|(role, file)| !is_left_alone(world, *role, file))
        .collect();
    if changed.is_empty() {
        return Vec::new();
    }
    let others = other_designs(own_file);
    changed
        .into_iter()
        .filter_map(|(role, file)| {
            let file_now = absolute(&file);
            let designs: Vec<_> = others
                .iter()
                .filter(|other| other.bodies.contains(&file_now))
                .map(|other| other.file.clone())
                .collect();
            (!designs.is_empty()).then_some(SharedBody { role, file, designs })
        })
        .collect()
}
