//! A design in its room as a scenario: plain data, every default decided; and designs and rooms to be
//! compared, each file read once, whatever refers to it.

use super::error::StoreError;
use super::files::Files;
use super::paths::absolute;
use super::read::Storage;
use super::reader::Reader;
use nalgebra::Point3;
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;
use trackwright_design::Design;
use trackwright_field::{Environment, OutsidePolicy};
use trackwright_simulation::comparison::{Pair, Plan};
pub use trackwright_simulation::scenario::CrfScenario;
use trackwright_simulation::{Motion, Pivot, Scenario, ScenarioCrf};

/// The scenario of a design. The orientation weight is the design's, else the environment's.
pub fn resolve(design: &Design, environment: &Arc<Environment>) -> Scenario {
    Scenario {
        environment: Arc::clone(environment),
        tool: design.tool.body.rigid.clone(),
        crf: design.crf.as_ref().map(|crf| ScenarioCrf {
            body: crf.body.rigid.clone(),
            tracker_from_crf: crf.tracker_from_crf,
        }),
        crf_from_tool: design.tool.crf_from_tool,
        motion: design.motion,
        orientation_weight_mm: design
            .orientation_weight_mm
            .unwrap_or_else(|| environment.orientation_weight_mm()),
        requirement: design.requirement,
        outside: OutsidePolicy::default(),
    }
}

/// The CRF of a design alone against the tracker (Fischer & Taylor 2005, section 4.1, step 2): once
/// for each of its targets, or once at its tip or origin where it has none; nothing without a CRF.
pub fn resolve_crf(design: &Design, environment: &Arc<Environment>) -> Vec<CrfScenario> {
    let Some(crf) = &design.crf else {
        return Vec::new();
    };
    let whole = resolve(design, environment);
    let tip_in_crf = crf.body.rigid.judged_tip_in_body();
    // The same range of motion for all targets, each of which is the tip in its turn.
    let motion = crf.motion.map(|motion| match motion.pivot {
        Pivot::Tip => Motion { pivot: Pivot::Body(tip_in_crf.coords.into()), ..motion },
        _ => motion,
    });
    let judged_at = |target: Option<String>, at: Point3<f64>| {
        let mut body = crf.body.rigid.clone();
        body.tip_in_body = Some(at);
        CrfScenario {
            target,
            scenario: Scenario {
                tool: body,
                crf: None,
                crf_from_tool: crf.tracker_from_crf,
                motion,
                requirement: crf.requirement,
                ..whole.clone()
            },
        }
    };
    if crf.targets.is_empty() {
        return vec![judged_at(None, tip_in_crf)];
    }
    let targets = crf.targets.iter();
    targets.map(|target| judged_at(Some(target.name.clone()), target.position_in_crf)).collect()
}

/// A design without its room and meshes.
#[derive(Clone, Debug)]
pub struct ComparedDesign {
    pub file: PathBuf,
    pub design: Design,
    /// The room that it names.
    pub own_room: PathBuf,
}

/// Reads designs with their bodies, without rooms and meshes; the first error in the order given.
pub fn read_compared_designs(
    files: &Files,
    designs: &[PathBuf],
) -> Result<Vec<ComparedDesign>, StoreError> {
    let read = designs.par_iter().map(|file| {
        let mut reader = Reader::new(Storage::Disk);
        let (design, _) = reader.design(file)?;
        files.inputs(&reader.stamps)?;
        Ok(ComparedDesign {
            file: file.clone(),
            own_room: Storage::Disk.resolve(file, &design.environment),
            design,
        })
    });
    // All of them first: the first error in order, not in time.
    read.collect::<Vec<_>>().into_iter().collect()
}

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

/// Reads rooms: two names of one file are one room. The first error in the order given.
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
