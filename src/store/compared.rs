//! The designs and rooms of a comparison: each file is read once, whatever refers to it.

use super::error::StoreError;
use super::open::Reader;
use super::place::{Place, absolute};
use super::read::read_environment;
use crate::design::Design;
use crate::field::Environment;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

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
pub fn read_compared_designs(files: &[PathBuf]) -> Result<Vec<ComparedDesign>, StoreError> {
    let read = files.par_iter().map(|file| {
        let (design, _) = Reader::new(Place::Disk).design(file)?;
        Ok(ComparedDesign {
            file: file.clone(),
            own_room: Place::Disk.resolve(file, &design.environment),
            design,
        })
    });
    // All of them first: the first error in order, not in time.
    read.collect::<Vec<_>>().into_iter().collect()
}

/// Rooms by the files that were named, and the number of each one's room: two names of one file are
/// one room, which is read once.
///
/// # Errors
/// The first file that cannot be used, in the order given.
pub fn read_compared_rooms(
    files: &[PathBuf],
) -> Result<(Vec<(PathBuf, Arc<Environment>)>, Vec<usize>), StoreError> {
    let mut distinct: Vec<(PathBuf, &Path)> = Vec::new();
    let mut numbers = Vec::with_capacity(files.len());
    for file in files {
        let real = absolute(file);
        let known = distinct.iter().position(|(known, _)| *known == real);
        numbers.push(known.unwrap_or(distinct.len()));
        if known.is_none() {
            distinct.push((real, file));
        }
    }
    let read = distinct
        .par_iter()
        .map(|(_, file)| Ok(((*file).to_owned(), Arc::new(read_environment(file)?))));
    let rooms: Result<Vec<_>, StoreError> = read.collect::<Vec<_>>().into_iter().collect();
    Ok((rooms?, numbers))
}
