//! Designs held against each other, in their own rooms or in given ones.

use crate::choices::outside_policy;
use crate::design::{Design, notes_of};
use crate::environment::Environment;
use crate::errors::{Done, TrackwrightError};
use crate::long_work;
use crate::tables::warn_of;
use crate::values::to_python;
use pyo3::prelude::*;
use std::path::Path;
use std::sync::Arc;
use trackwright_field as field;
use trackwright_formats::comparison_table::Names;
use trackwright_project::{comparison_plan, is_same_file};
use trackwright_report::comparison::comparison_section;
use trackwright_simulation::comparison::{
    LEAST_DEG, LEAST_MM, Least, Settings, compare as compared,
};

/// Holds designs against each other: which differences are more than the rooms' uncertainty.
///
/// Each design is simulated in its own room, or in each of environments. baseline is the number of the
/// design that the others are held against. least_mm and least_deg are differences that do not matter. The
/// result is what `trackwright compare --format json` prints.
#[pyfunction]
#[pyo3(signature = (
    *designs, environments = None, baseline = 0, outside = "clamp", least_mm = LEAST_MM,
    least_deg = LEAST_DEG, seed = 0
))]
#[expect(clippy::too_many_arguments, reason = "keywords in Python")]
pub fn compare<'py>(
    py: Python<'py>,
    designs: Vec<Bound<'py, Design>>,
    environments: Option<Vec<Bound<'py, Environment>>>,
    baseline: usize,
    outside: &str,
    least_mm: f64,
    least_deg: f64,
    seed: u64,
) -> Done<Bound<'py, PyAny>> {
    let outside = outside_policy(outside)?;
    let refused = |text: String| Err(TrackwrightError::new_err(text).into());
    if baseline >= designs.len() {
        return refused(format!(
            "baseline: found {baseline}, expected the number of one of {} designs, from 0",
            designs.len()
        ));
    }
    for (option, least) in [("least_mm", least_mm), ("least_deg", least_deg)] {
        if !(least.is_finite() && least >= 0.0) {
            return refused(format!("{option}: found {least}, expected zero or more"));
        }
    }
    let worlds: Vec<_> = designs.iter().map(|design| design.get().world()).collect();
    let mut rooms: Vec<(String, Arc<field::Environment>)> = Vec::new();
    let mut of_design: Vec<Vec<usize>> = Vec::with_capacity(worlds.len());
    match &environments {
        Some(environments) => {
            rooms.extend(
                environments
                    .iter()
                    .map(|room| (room.get().label().to_owned(), Arc::clone(&room.get().solved))),
            );
            of_design.resize(worlds.len(), (0..rooms.len()).collect());
        }
        None => {
            for design in &designs {
                let (label, room) = design.get().own_room();
                let is_it = |(known, other): &(String, Arc<field::Environment>)| {
                    Arc::ptr_eq(other, room)
                        || is_same_file(Path::new(known), Path::new(&label)) && **other == **room
                };
                let known = rooms.iter().position(is_it);
                of_design.push(vec![known.unwrap_or(rooms.len())]);
                if known.is_none() {
                    rooms.push((label, Arc::clone(room)));
                }
            }
        }
    }
    let mut notes = Vec::new();
    for (design, rooms_of) in worlds.iter().zip(&of_design) {
        notes.extend(rooms_of.iter().flat_map(|room| notes_of(design, &rooms[*room].1)));
    }
    notes.sort_unstable();
    notes.dedup();
    let all: Vec<_> = worlds.iter().map(|world| world.document.design()).collect();
    let environments = rooms.iter().map(|(_, room)| Arc::clone(room)).collect();
    let plan =
        comparison_plan(&all, environments, |number| of_design[number].clone(), baseline, outside);
    let settings =
        Settings { least: Least { mm: least_mm, deg: least_deg }, seed, ..Settings::default() };
    let found = long_work::run(py, |task| Ok(compared(&plan, &settings, task)?))?;
    let names = Names::new(
        designs.iter().map(|design| (design.get().label(), design.get().name())),
        rooms.iter().map(|(label, room)| (label.clone(), room.name.as_str())),
    );
    warn_of(py, notes)?;
    Ok(to_python(py, &comparison_section(&found, &names).to_json())?)
}
