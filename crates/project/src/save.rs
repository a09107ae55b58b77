//! Saves a design and its bodies: only what changed, bodies first, each file whole or not at all.

use super::error::StoreError;
use super::open::{World, home};
use super::place::{Kind, Place, absolute, free_name, relative};
use super::replace::{KeptFile, keep_former, lock_all, replace};
use super::shared::shared_bodies;
use super::tool::{body_name, is_definition, parse_body};
use super::watch::Stamps;
use super::write::{folder_of, write_bytes};
use std::fs;
use std::path::{Path, PathBuf};
use trackwright_design::{BodyRole, Design, DesignBody, Origin, View};
use trackwright_formats::{BodyFile, DesignFile, body, design_file};
use trackwright_geometry::mesh_reference::MeshReference;

/// What Save did.
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
///
/// # Errors
/// As [`save`].
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

/// The changed bodies whose files are others' to write, each with a name beside the design that is
/// no other file's.
fn moved_bodies(world: &World, design_file: &Path) -> Vec<BodyMove> {
    let folder = folder_of(design_file);
    let mut moves: Vec<BodyMove> = Vec::new();
    for (role, body) in world.document.design().bodies() {
        let old_file = Place::Disk.resolve(design_file, &body.reference);
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
        false => file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
    }
}

/// Saves with some bodies as other files, which every state of the document refers to then.
fn save_moved(
    world: &mut World,
    file: &Path,
    moves: Vec<BodyMove>,
) -> Result<SaveReport, StoreError> {
    let has_moves = !moves.is_empty();
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
        });
    }
    match write_changes(world, file, has_moves) {
        Ok(report) => {
            world.document.mark_saved();
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
/// What came from the disk stays where it is and is referred to from the new place, except for
/// bodies that changed: those are saved beside the new design, so that the old one stays as it
/// is. From the built-in world everything is saved beside the new design.
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
    let (place, old_file) = home(world.document.origin())?;
    refuse_own_parts(world, place, &old_file, file)?;
    let mut mover = Mover {
        place,
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
            moved_anatomy.push((old.clone(), mover.move_anatomy(old)?));
        }
    }
    let own_room = mover.move_environment(&design.environment)?;
    let mut rooms = vec![(design.environment.clone(), own_room)];
    for room in &design.procedure.further_rooms {
        // One that is not there was missed before, and is no reason not to save.
        let moved = mover.move_environment(room);
        rooms.extend(moved.ok().map(|moved| (room.clone(), moved)));
    }
    let anatomy_file = |old: &str| {
        let moved = moved_anatomy.iter().find(|(moved, _)| moved == old);
        moved.map_or_else(|| mover.reference(old), |(_, now)| now.clone())
    };
    let rewrite = |design: &mut Design| {
        for (role, old_reference, moved) in &moved {
            let Some(body) = design.body_mut(*role) else {
                continue;
            };
            if body.reference != *old_reference {
                mover.move_past_body(body);
            } else {
                body.reference.clone_from(&moved.reference);
                if let Some(mesh) = &mut body.mesh {
                    mesh.file = mover.mesh_from(moved, &mesh.file);
                }
            }
        }
        for anatomy in &mut design.anatomy {
            anatomy.mesh.file = anatomy_file(&anatomy.mesh.file);
        }
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
    world.references_are_current();
    world.anatomy.moved(anatomy_file);
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

/// Whether the file that a body refers to says the same.
fn is_held(world: &World, body: &DesignBody) -> bool {
    let Origin::File(design_file) = world.document.origin() else {
        return false;
    };
    let file = Place::Disk.resolve(design_file, &body.reference);
    let Ok(bytes) = Place::Disk.read(&file, Kind::BODY) else {
        return false;
    };
    parse_body(&file, &bytes).is_ok_and(|held| body::write(&held) == body_text(body))
}

/// What a body refers to its mesh by from a file in perhaps another folder.
pub(super) fn reach_mesh(mesh: &mut Option<MeshReference>, old_file: &Path, file: &Path) {
    let (old_folder, folder) = (folder_of(old_file), folder_of(file));
    if let Some(mesh) = mesh
        && !is_absolute(&mesh.file)
        && absolute(&old_folder) != absolute(&folder)
    {
        mesh.file = relative(&folder, &Place::Disk.resolve(old_file, &mesh.file));
    }
}

fn own_file(world: &World) -> Result<PathBuf, StoreError> {
    match world.document.origin() {
        Origin::BuiltIn(name) => Err(StoreError::ReadOnly(name)),
        Origin::File(file) => Ok(file.clone()),
    }
}

fn body_text(body: &DesignBody) -> String {
    body::write(&BodyFile::of(body))
}

fn design_text(design: &Design, view: &View) -> String {
    design_file::write(&DesignFile::of(design, view))
}

fn write_changes(
    world: &mut World,
    file: &Path,
    is_design_changed: bool,
) -> Result<SaveReport, StoreError> {
    let design = world.document.design();
    let bodies: Vec<_> = design
        .bodies()
        .map(|(role, body)| {
            let body_file = Place::Disk.resolve(file, &body.reference);
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
    place: Place,
    old_file: &Path,
    file: &Path,
) -> Result<(), StoreError> {
    let design = world.document.design();
    let mut parts = design
        .bodies()
        .map(|(_, body)| &body.reference)
        .chain([&design.environment])
        .chain(&design.procedure.further_rooms)
        .map(|reference| place.resolve(old_file, reference));
    let file = absolute(file);
    if place == Place::Disk && parts.any(|part| absolute(&part) == file) {
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
    place: Place,
    old_file: PathBuf,
    folder: PathBuf,
    report: SaveReport,
    stamps: Stamps,
}

impl Mover {
    fn move_body(&mut self, body: &DesignBody, is_changed: bool) -> Result<MovedBody, StoreError> {
        let old_file = self.place.resolve(&self.old_file, &body.reference);
        let mut moved = MovedBody {
            reference: String::new(),
            is_copied: self.place == Place::BuiltIn || is_changed,
            old_file,
            copied_mesh: None,
        };
        if !moved.is_copied {
            moved.reference = relative(&self.folder, &moved.old_file);
            return Ok(moved);
        }
        let mut copy = body.clone();
        if let Some(mesh) = &mut copy.mesh {
            moved.copied_mesh = self.copy_mesh(&moved.old_file, &mesh.file)?;
            mesh.file = self.mesh_from(&moved, &mesh.file);
        }
        // A maker's definition that changed is a body file from now on.
        let name = match self.place == Place::Disk && is_definition(&moved.old_file) {
            true => body_name(&moved.old_file),
            false => body.reference.clone(),
        };
        moved.reference = self.copy(&name, body_text(&copy).as_bytes())?;
        Ok(moved)
    }

    /// Leads a body of a past state, which is another one than the present, to where it is from the
    /// new folder; one that no file holds will be saved there.
    fn move_past_body(&self, body: &mut DesignBody) {
        let old_file = self.place.resolve(&self.old_file, &body.reference);
        if self.place == Place::Disk && old_file.exists() {
            body.reference = relative(&self.folder, &old_file);
            return;
        }
        let name = old_file.file_name().unwrap_or_default().to_string_lossy();
        if self.place == Place::Disk {
            reach_mesh(&mut body.mesh, &old_file, &self.folder.join(&*name));
        }
        body.reference = name.into_owned();
    }

    /// Copies a mesh of the built-in world, which nothing else on the disk could refer to.
    fn copy_mesh(
        &mut self,
        old_body_file: &Path,
        mesh: &str,
    ) -> Result<Option<(String, String)>, StoreError> {
        let old_file = self.place.resolve(old_body_file, mesh);
        // One that is not there was missed before, and is no reason not to save.
        if self.place == Place::Disk
            || is_absolute(mesh)
            || self.place.read(&old_file, "a file").is_err()
        {
            return Ok(None);
        }
        let copy = self.copy_built_in(&old_file, "a mesh")?;
        Ok(Some((mesh.to_owned(), copy)))
    }

    /// The reference to a mesh of the anatomy from the new folder, to where it was copied if it had
    /// to be.
    fn move_anatomy(&mut self, reference: &str) -> Result<String, StoreError> {
        let old_file = self.place.resolve(&self.old_file, reference);
        let is_within_reach = self.place == Place::Disk || is_absolute(reference);
        // One that is not there was missed before, and is no reason not to save.
        if is_within_reach || self.place.read(&old_file, "a file").is_err() {
            return Ok(self.reference(reference));
        }
        self.copy_built_in(&old_file, "a mesh")
    }

    /// What a mesh of a body, a past one too, is referred to by from where the body is now.
    fn mesh_from(&self, body: &MovedBody, mesh: &str) -> String {
        match (&body.copied_mesh, self.place) {
            (Some((old, copy)), _) if old == mesh => copy.clone(),
            (_, Place::Disk) if body.is_copied && !is_absolute(mesh) => {
                relative(&self.folder, &self.place.resolve(&body.old_file, mesh))
            }
            // It stayed where it is, or it is only ever undone to.
            _ => mesh.to_owned(),
        }
    }

    fn copy_built_in(&mut self, file: &Path, kind: &'static str) -> Result<String, StoreError> {
        let bytes =
            self.place.read(file, kind).map_err(|failure| failure.into_error(file, kind))?;
        self.copy(&file.to_string_lossy(), &bytes)
    }

    /// Writes a copy into the new folder under its old name, or under one like it where that
    /// name is another file's; the name.
    fn copy(&mut self, old_reference: &str, bytes: &[u8]) -> Result<String, StoreError> {
        let name = Path::new(old_reference).file_name().unwrap_or_default();
        let is_same = |path: &Path| fs::read(path).is_ok_and(|found| found == bytes);
        let copy = free_name(&self.folder.join(name), |path| !path.exists() || is_same(path));
        if !is_same(&copy) {
            write_bytes(&copy, bytes)?;
            self.report.written.push(copy.clone());
        }
        self.stamps.take(&copy, bytes);
        let name = copy.file_name().unwrap_or_default();
        Ok(name.to_string_lossy().into_owned())
    }

    /// The environment's reference from the new folder, to where it was copied if it had to be.
    fn move_environment(&mut self, reference: &str) -> Result<String, StoreError> {
        if self.place == Place::Disk || is_absolute(reference) {
            return Ok(self.reference(reference));
        }
        self.copy_built_in(&self.place.resolve(&self.old_file, reference), "an environment")
    }

    /// What a reference of the old design's is from the new folder.
    fn reference(&self, reference: &str) -> String {
        match self.place {
            _ if is_absolute(reference) => reference.to_owned(),
            Place::Disk => relative(&self.folder, &self.place.resolve(&self.old_file, reference)),
            // Only ever undone to; nothing else of the built-in world is copied.
            Place::BuiltIn => reference.to_owned(),
        }
    }
}

fn is_absolute(reference: &str) -> bool {
    Path::new(reference).is_absolute()
}
