//! The designs and rooms of a comparison: each file is read once, whatever refers to it.

use super::error::StoreError;
use super::files::Files;
use super::open::Reader;
use super::place::{Place, absolute};
use super::resolve::resolve;
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;
use trackwright_design::Design;
use trackwright_field::{Environment, OutsidePolicy};
use trackwright_simulation::comparison::{Pair, Plan};

/// A design without its room and meshes.
#[derive(Clone, Debug)]
pub struct ComparedDesign {
    pub file: PathBuf,
    pub design: Design,
    /// The room that it names.
    pub own_room: PathBuf,
}

/// Reads designs with their bodies, for their numbers alone. Their own rooms are not looked at.
///
/// # Errors
/// The first file that cannot be used, in the order given.
pub fn read_compared_designs(
    files: &Files,
    designs: &[PathBuf],
) -> Result<Vec<ComparedDesign>, StoreError> {
    let read = designs.par_iter().map(|file| {
        let mut reader = Reader::new(Place::Disk);
        let (design, _) = reader.design(file)?;
        files.inputs(&reader.stamps)?;
        Ok(ComparedDesign {
            file: file.clone(),
            own_room: Place::Disk.resolve(file, &design.environment),
            design,
        })
    });
    // All of them first: the first error in order, not in time.
    read.collect::<Vec<_>>().into_iter().collect()
}

/// A room by the first file that named it.
#[derive(Clone, Debug)]
pub struct ComparedRoom {
    pub file: PathBuf,
    pub environment: Arc<Environment>,
}

/// Rooms, each once, and the number of the room that each file is.
#[derive(Clone, Debug)]
pub struct ComparedRooms {
    pub rooms: Vec<ComparedRoom>,
    pub of_file: Vec<usize>,
}

/// Reads rooms: two names of one file are one room, which is read once.
///
/// # Errors
/// The first file that cannot be used, in the order given.
pub fn read_compared_rooms(files: &Files, rooms: &[PathBuf]) -> Result<ComparedRooms, StoreError> {
    let mut distinct: Vec<(PathBuf, &PathBuf)> = Vec::new();
    let mut of_file = Vec::with_capacity(rooms.len());
    for file in rooms {
        let real = absolute(file);
        let known = distinct.iter().position(|(known, _)| *known == real);
        of_file.push(known.unwrap_or(distinct.len()));
        if known.is_none() {
            distinct.push((real, file));
        }
    }
    let read = distinct.par_iter().map(|(_, file)| {
        Ok(ComparedRoom {
            file: (*file).clone(),
            environment: Arc::new(files.read_environment(file)?),
        })
    });
    let rooms: Result<Vec<_>, StoreError> = read.collect::<Vec<_>>().into_iter().collect();
    Ok(ComparedRooms { rooms: rooms?, of_file })
}

/// What is compared: every design in the rooms that `rooms_of` names by their numbers.
pub fn comparison_plan(
    designs: &[&Design],
    rooms: Vec<Arc<Environment>>,
    rooms_of: impl Fn(usize) -> Vec<usize>,
    baseline: usize,
    outside: OutsidePolicy,
) -> Plan {
    let mut pairs = Vec::new();
    for (number, design) in designs.iter().enumerate() {
        for room in rooms_of(number) {
            let mut scenario = resolve(design, &rooms[room]);
            scenario.outside = outside;
            pairs.push(Pair { design: number, room, scenario });
        }
    }
    Plan { rooms, pairs, baseline }
}
