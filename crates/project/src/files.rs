//! The files that one command reads and writes, so that it writes over none that it reads and over none
//! that a person made or changed.

use super::builtin::builtin_named;
use super::error::StoreError;
use super::open;
use super::paths::{FileId, extension_of, folder_of};
use super::stamps::Stamps;
use super::tool::{ReadTool, moved_body_text, read_tool};
use super::world::World;
use super::write::{Draft, is_own_stream, remove_leftovers, write_error};
use super::written;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use trackwright_field::Environment;
use trackwright_field::generator::Generator;
use trackwright_formats::signature::{self, Signature};
use trackwright_formats::tool_definition::{OnMismatch, ToolDefinition};
use trackwright_formats::{BodyFile, environment, generator};
use trackwright_metal::setup::RoomMetal;

/// The files of one command. Everything that a command reads is read through this, and written through
/// [`output`](Self::output).
///
/// ```
/// use trackwright_project::{Files, StoreError};
///
/// let folder = tempfile::tempdir()?;
/// let table = folder.path().join("points.csv");
/// std::fs::write(&table, "x,y,z\n1,2,3\n4,5,6\n7,8,10\n")?;
/// let files = Files::default();
/// assert_eq!(files.read_points(&table)?.as_it_stands().len(), 3);
/// // What is read is never written over.
/// assert!(matches!(files.output(&table), Err(StoreError::IsInput { .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct Files {
    /// Whether other documents may be written over, which the user requested.
    is_overwriting: bool,
    known: Mutex<Known>,
}

#[derive(Debug, Default)]
struct Known {
    read: BTreeSet<FileId>,
    written: BTreeMap<FileId, PathBuf>,
}

#[derive(Debug)]
pub struct Output<'a> {
    files: &'a Files,
    file: PathBuf,
}

impl Files {
    /// Files of which others' may be written over; one that is read is never written.
    pub fn overwriting(is_overwriting: bool) -> Self {
        Self { is_overwriting, known: Mutex::default() }
    }

    /// Files beside an open design, none of whose own files is to be written; others may be written
    /// over, which whoever names one has agreed to.
    pub fn except_design(world: &World) -> Self {
        Self {
            is_overwriting: true,
            known: Mutex::new(Known {
                read: world.files().map(FileId::of).collect(),
                written: BTreeMap::new(),
            }),
        }
    }

    /// A file that is going to be written. What interrupted writes left in its folder is removed.
    ///
    /// # Errors
    /// [`StoreError::IsInput`] where the command reads that file, by whatever name.
    pub fn output(&self, file: &Path) -> Result<Output<'_>, StoreError> {
        let id = FileId::of(file);
        let mut known = self.known();
        if known.read.contains(&id) {
            return Err(is_input(file));
        }
        if let Some(other) = known.written.get(&id)
            && is_plain(file)
        {
            return Err(StoreError::TwoOutputs { file: file.to_owned(), other: other.clone() });
        }
        known.written.insert(id, file.to_owned());
        drop(known);
        remove_leftovers(&folder_of(file));
        Ok(Output { files: self, file: file.to_owned() })
    }

    /// An [`output`](Self::output) where one is requested.
    pub fn optional_output(&self, file: Option<&Path>) -> Result<Option<Output<'_>>, StoreError> {
        file.map(|file| self.output(file)).transpose()
    }

    /// States that a file is read, which must be no [`output`](Self::output); for what is not read through this.
    ///
    /// # Errors
    /// [`StoreError::IsInput`].
    pub fn input(&self, file: &Path) -> Result<(), StoreError> {
        let id = FileId::of(file);
        let mut known = self.known();
        if known.written.contains_key(&id) && is_plain(file) {
            return Err(is_input(file));
        }
        known.read.insert(id);
        Ok(())
    }

    /// Opens a design with all that it refers to: a file, or the built-in design of that name where there is
    /// no such file; see [`open_design`](super::open_design).
    pub fn open_design(&self, design: &Path) -> Result<World, StoreError> {
        self.opened(match builtin_named(&design.to_string_lossy(), design) {
            Some(name) => open::open_builtin(name)?,
            None => open::open_design(design)?,
        })
    }

    /// The same for its numbers alone.
    pub fn open_design_without_meshes(&self, design: &Path) -> Result<World, StoreError> {
        self.opened(match builtin_named(&design.to_string_lossy(), design) {
            Some(name) => open::open_builtin_without_meshes(name)?,
            None => open::open_design_without_meshes(design)?,
        })
    }

    /// Reads a body file or a maker's definition; refuses a wrong checksum unless it is accepted.
    pub fn read_tool(&self, file: &Path, on_mismatch: OnMismatch) -> Result<ReadTool, StoreError> {
        self.input(file)?;
        read_tool(file, on_mismatch)
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_written(&self, file: &Path) {
        self.known().written.insert(FileId::of(file), file.to_owned());
    }

    fn opened(&self, world: World) -> Result<World, StoreError> {
        world.files().try_for_each(|file| self.input(file))?;
        Ok(world)
    }

    pub(super) fn inputs(&self, read: &Stamps) -> Result<(), StoreError> {
        read.iter().try_for_each(|(file, _)| self.input(file))
    }
}

impl Output<'_> {
    /// The file that is written.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Writes the file through a temporary one beside it, which takes its place once it is whole and
    /// on the disk. What is no plain file (`/dev/stdout`, a pipe) is written to as it is.
    ///
    /// # Errors
    /// [`StoreError::Write`], or [`StoreError::NotOwn`] for a file that no command wrote or that somebody
    /// has changed since; what was there before is then untouched.
    pub fn write(
        &self,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), StoreError> {
        let fails = |cause| write_error(&self.file, cause);
        let draft = Draft::write(&self.file, write).map_err(fails)?;
        if !draft.is_there_already().map_err(fails)? {
            self.expect_own()?;
        }
        // Before it is at its place: whoever looks there then finds what is known.
        draft.temporary().into_iter().for_each(written::remember);
        draft.place().map_err(fails)?;
        // It is another one now than it was, or was not there.
        self.files.is_written(&self.file);
        Ok(())
    }

    /// Refuses what is there before any work is done, where [`write`](Self::write) would: for work that
    /// takes long, and for a file that another program writes.
    ///
    /// # Errors
    /// [`StoreError::NotOwn`].
    pub fn expect_own(&self) -> Result<(), StoreError> {
        match self.refused() {
            Some(found) => Err(StoreError::NotOwn { file: self.file.clone(), found }),
            None => Ok(()),
        }
    }

    /// States that the file is what this command made of it: another program wrote it.
    pub fn is_written(&self) {
        self.files.is_written(&self.file);
        written::remember(&self.file);
    }

    /// What is there and must not be replaced: a person made or changed it. An empty file holds nothing
    /// that could be lost.
    fn refused(&self) -> Option<Signature> {
        let length = std::fs::metadata(&self.file).ok().filter(|m| m.is_file())?.len();
        if is_own_stream(&self.file)
            || self.files.is_overwriting
            || length == 0
            || written::is_as_written(&self.file)
        {
            return None;
        }
        let mut beginning = Vec::new();
        let there = File::open(&self.file);
        let read =
            there.and_then(|f| f.take(signature::BEGINNING as u64).read_to_end(&mut beginning));
        // What cannot be read is reported by whoever writes there.
        read.ok().map(|_| Signature::of(&beginning, &extension_of(&self.file)))
    }

    /// Writes bytes, as [`write`](Self::write) does.
    pub fn write_bytes(&self, bytes: &[u8]) -> Result<(), StoreError> {
        self.write(|out| out.write_all(bytes))
    }

    /// Writes an environment.
    pub fn write_environment(&self, written: &Environment) -> Result<(), StoreError> {
        self.write_bytes(environment::write(written, None).as_bytes())
    }

    /// Writes an environment and the metal that is added to it.
    pub fn write_room(&self, bare: &Environment, metal: &RoomMetal) -> Result<(), StoreError> {
        self.write_bytes(environment::write(bare, Some(metal)).as_bytes())
    }

    /// Writes a field generator.
    pub fn write_generator(&self, written: &Generator) -> Result<(), StoreError> {
        self.write_bytes(generator::write(written).as_bytes())
    }

    /// Writes a body that was read from `source`, whose meshes it still refers to.
    pub fn write_body(&self, body: &BodyFile, source: &Path) -> Result<(), StoreError> {
        self.write_bytes(moved_body_text(body, source, &self.file).as_bytes())
    }

    /// Writes a maker's definition.
    pub fn write_definition(&self, definition: &ToolDefinition) -> Result<(), StoreError> {
        self.write_bytes(&definition.write())
    }
}

fn is_input(file: &Path) -> StoreError {
    StoreError::IsInput { file: file.to_owned() }
}

/// Devices and pipes hold nothing that could be lost.
fn is_plain(file: &Path) -> bool {
    std::fs::metadata(file).is_ok_and(|m| m.is_file()) || !file.exists()
}
