//! What the table's thread does: reads designs and rooms, and holds each design against the baseline.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use trackwright_design::{Design, Origin};
use trackwright_field::{Environment, OutsidePolicy};
use trackwright_formats::comparison_table::Names;
use trackwright_project::{Files, RoomSource, StoreError};
use trackwright_simulation::comparison::{Comparison, Settings, compare};
use trackwright_task::{Cancelled, Task};

/// What is to be compared.
pub struct Wanted {
    /// The open design, as it is.
    pub open: Arc<Design>,
    /// What the others are held against; without one, the open design.
    pub pinned: Option<Arc<Design>>,
    pub added: Vec<AddedDesign>,
    /// The open design's room.
    pub environment: Arc<Environment>,
    pub rooms: Vec<RoomSource>,
    pub generation: u64,
}

/// A design of the table, beside the open one and the baseline.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AddedDesign {
    File(PathBuf),
    BuiltIn(&'static str),
}

impl AddedDesign {
    fn read(&self) -> Result<Design, StoreError> {
        match self {
            Self::File(file) => {
                let files = Files::default();
                let file = std::slice::from_ref(file);
                let mut read = trackwright_project::read_compared_designs(&files, file)?;
                Ok(read.remove(0).design)
            }
            Self::BuiltIn(name) => {
                let world = trackwright_project::open_builtin_without_meshes(name)?;
                Ok(world.document.design().clone())
            }
        }
    }

    /// Whether it is what is open.
    pub fn is_open(&self, origin: &Origin) -> bool {
        match (self, origin) {
            (Self::File(file), Origin::File(open)) => trackwright_project::is_same_file(file, open),
            (Self::BuiltIn(name), Origin::BuiltIn(open)) => name == open,
            _ => false,
        }
    }
}

/// Where it is, for people.
impl fmt::Display for AddedDesign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(file) => file.display().fmt(f),
            Self::BuiltIn(name) => write!(f, "{name}, built in"),
        }
    }
}

/// What a design of the table is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Compare {
    Open,
    Pinned,
    Added(AddedDesign),
}

/// A table, and what its rows are of.
#[derive(Debug)]
pub struct Compared {
    pub comparison: Comparison,
    pub names: Names,
    pub designs: Vec<Compare>,
    /// `None` for the open design's own.
    pub rooms: Vec<Option<RoomSource>>,
    /// Designs and rooms that could not be read, with the reason.
    pub missing: Vec<String>,
    /// What the open design was.
    pub generation: u64,
    pub open: Arc<Design>,
}

/// How work ended without a table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Reads and compares. A design or room that cannot be read is named beside the table of the others.
///
/// # Errors
/// See [`Failure`].
pub fn compared(wanted: Wanted, task: &Task) -> Result<Compared, Failure> {
    let mut missing = Vec::new();
    let mut designs = Vec::new();
    if let Some(pinned) = wanted.pinned {
        designs.push((Compare::Pinned, pinned));
    }
    let open = Arc::clone(&wanted.open);
    designs.push((Compare::Open, wanted.open));
    for added in wanted.added {
        match added.read() {
            Ok(design) => designs.push((Compare::Added(added), Arc::new(design))),
            Err(error) => missing.push(error.to_string()),
        }
    }
    let mut rooms = vec![(None, wanted.environment)];
    for place in wanted.rooms {
        task.step(0, 1)?;
        match place.read_solved() {
            Ok(room) => rooms.push((Some(place), room)),
            Err(error) => missing.push(error.to_string()),
        }
    }
    let all: Vec<&Design> = designs.iter().map(|(_, design)| &**design).collect();
    let plan = trackwright_project::comparison_plan(
        &all,
        rooms.iter().map(|(_, room)| Arc::clone(room)).collect(),
        |_| (0..rooms.len()).collect(),
        0,
        OutsidePolicy::default(),
    );
    let comparison = compare(&plan, &Settings::default(), task)?;
    let named_designs = designs.iter().map(|(what, design)| {
        let place = match what {
            Compare::Open => "open".to_owned(),
            Compare::Pinned => "baseline".to_owned(),
            Compare::Added(added) => added.to_string(),
        };
        (place, design.name.as_str())
    });
    let named_rooms = rooms.iter().map(|(place, room)| {
        let place = match place {
            None => "its own".to_owned(),
            Some(RoomSource::BuiltIn(name)) => format!("{name}, built in"),
            Some(RoomSource::File(file)) => file.display().to_string(),
        };
        (place, room.name.as_str())
    });
    Ok(Compared {
        names: Names::new(named_designs, named_rooms),
        comparison,
        designs: designs.into_iter().map(|(what, _)| what).collect(),
        rooms: rooms.into_iter().map(|(place, _)| place).collect(),
        missing,
        generation: wanted.generation,
        open,
    })
}
