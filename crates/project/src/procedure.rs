//! Where a design stands in the paper's procedure: it in its rooms, each file read, and the tables of
//! what was built.

use super::built_tool::{BuiltTool, BuiltToolNote, BuiltToolTables, built_tool};
use super::error::StoreError;
use super::files::Files;
use super::paths::absolute;
use super::read::Storage;
use super::reader::{Reader, home};
use super::resolve::{resolve, resolve_crf};
use super::world::World;
use nalgebra::Vector3;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackwright_calibration::agreement::BuiltRecording;
use trackwright_design::Design;
use trackwright_field::Environment;
use trackwright_geometry::pose::Pose;
use trackwright_procedure::{
    DecidedRecording, DecidedStudies, DecisionBasis, Plan, Recording, Room, RoomName, RoomStudies,
    Step, StepStatus, step_status,
};
use trackwright_simulation::InputTrial;
use trackwright_task::Task;

/// What is looked at beside what the design holds.
#[derive(Clone, Debug, Default)]
pub struct ProcedureRequest {
    pub rooms_for_now: Vec<PathBuf>,
    /// In the place of the recording that the built tool was decided on.
    pub recording: Option<BuiltRecording>,
}

/// Computes where a design stands. A further room or a recording that cannot be read is a row that
/// states so; `note` receives what there is to know of tables beside their figures.
///
/// # Errors
/// [`StoreError::NoSuchBuiltIn`], [`StoreError::Cancelled`].
pub fn procedure(
    files: &Files,
    world: &World,
    wish: &ProcedureRequest,
    task: &Task,
    note: &dyn Fn(BuiltToolNote),
) -> Result<StepStatus, StoreError> {
    let (storage, file) = home(world.document.origin())?;
    let design = world.document.design();
    let decided = |step| design.procedure.decision(step).map(|d| &d.basis);
    let own = || world.environment.name.clone();
    let wanted = wish.recording.as_ref().or(match decided(Step::Built) {
        Some(DecisionBasis::Recording(decided)) => Some(&decided.recording),
        _ => None,
    });
    let recording = match wanted {
        None => None,
        Some(wanted) => {
            let found =
                recorded(files, world, (storage, &file), wanted, &task.subtask(0.0, 0.4), note);
            task.step(4, 10)?;
            let room = RoomName { name: own(), file: design.environment.clone() };
            Some(found.map(|found| decided_on(found, wanted, room)))
        }
    };
    let start = if recording.is_some() { 0.4 } else { 0.0 };
    let plan = Plan {
        crf_targets: resolve_crf(design, &world.environment)
            .into_iter()
            .map(|judged| judged.target)
            .collect(),
        crf_requirement: design.crf.as_ref().and_then(|crf| crf.requirement),
        requirement: design.requirement,
        rooms: rooms(files, world, (storage, &file), &wish.rooms_for_now),
        recording,
        decided_crf: studies_of(decided(Step::Crf)),
        decided_tool: studies_of(decided(Step::Tool)),
        decided_built: match decided(Step::Built) {
            Some(DecisionBasis::Recording(decided)) => Some(DecidedRecording::clone(decided)),
            _ => None,
        },
    };
    Ok(step_status(plan, &task.subtask(start, 1.0))?)
}

/// The further room of a design that a person means by a file, as the design refers to it; also where
/// the file is gone.
pub fn further_room<'a>(world: &'a World, file: &Path) -> Result<Option<&'a str>, StoreError> {
    let (storage, design_file) = home(world.document.origin())?;
    let meant = absolute(file);
    let rooms = &world.document.design().procedure.further_rooms;
    let is_it = |room: &&String| {
        Path::new(room) == file || absolute(&storage.resolve(&design_file, room)) == meant
    };
    Ok(rooms.iter().find(is_it).map(String::as_str))
}

fn studies_of(basis: Option<&DecisionBasis>) -> Option<DecidedStudies> {
    match basis {
        Some(DecisionBasis::Studies(studies)) => Some(studies.clone()),
        _ => None,
    }
}

struct Wanted {
    file: String,
    path: PathBuf,
    is_for_now: bool,
}

/// The design's own room, which is open already, then the others; each once.
fn rooms(
    files: &Files,
    world: &World,
    (storage, file): (Storage, &Path),
    for_now: &[PathBuf],
) -> Vec<Room> {
    let design = world.document.design();
    let real = |path: &Path| match storage.is_on_disk(path) {
        true => absolute(path),
        false => path.to_owned(),
    };
    let mut known = vec![real(&storage.resolve(file, &design.environment))];
    let further = design.procedure.further_rooms.iter().map(|room| Wanted {
        file: room.clone(),
        path: storage.resolve(file, room),
        is_for_now: false,
    });
    let for_now = for_now.iter().map(|room| Wanted {
        file: room.display().to_string(),
        // From where the person is, not the design; the built-in world has no such place.
        path: absolute(room),
        is_for_now: true,
    });
    let mut wanted = Vec::new();
    for room in further.chain(for_now) {
        let path = real(&room.path);
        if !known.contains(&path) {
            known.push(path);
            wanted.push(room);
        }
    }
    let own = Room {
        name: RoomName { name: world.environment.name.clone(), file: design.environment.clone() },
        is_for_now: false,
        studies: Ok(studies_in(design, &world.environment)),
    };
    let read: Vec<Room> = wanted
        .into_par_iter()
        .map(|wanted| {
            let path = wanted.path.to_string_lossy();
            // What is resolved already is resolved to itself.
            let mut reader = Reader::new(storage);
            let found = reader.environment(Path::new(""), &path);
            let found = files.inputs(&reader.stamps).and(found);
            Room {
                name: RoomName {
                    name: found.as_ref().map_or_else(|_| String::new(), |e| e.name.clone()),
                    file: wanted.file,
                },
                is_for_now: wanted.is_for_now,
                studies: match found {
                    Ok(environment) => Ok(studies_in(design, &environment)),
                    Err(error) => Err(error.to_string()),
                },
            }
        })
        .collect();
    std::iter::once(own).chain(read).collect()
}

fn studies_in(design: &Design, environment: &Arc<Environment>) -> RoomStudies {
    RoomStudies { crf: resolve_crf(design, environment), tool: resolve(design, environment) }
}

fn recorded(
    files: &Files,
    world: &World,
    (storage, file): (Storage, &Path),
    wanted: &BuiltRecording,
    task: &Task,
    note: &dyn Fn(BuiltToolNote),
) -> Result<BuiltTool, String> {
    let scenario = resolve(world.document.design(), &world.environment);
    let at = |reference: &String| storage.resolve(file, reference);
    let crf = wanted.crf_table.as_ref().map(at);
    let tables = BuiltToolTables {
        tool: &at(&wanted.table),
        crf: crf.as_deref(),
        frame: wanted.frame,
        whole: wanted.whole.as_deref(),
        is_one_frame: false,
        // What is suspected is noted: the design names the tables, and there is no user to confirm.
        is_as_meant: true,
        settings: wanted.settings(),
    };
    built_tool(files, scenario, &tables, task, note).map_err(|error| error.to_string())
}

/// A recording pose by pose: where the tool was, and what was measured of it there.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedPoses {
    pub trials: Vec<InputTrial>,
    /// Of each of them.
    pub measured: Vec<MeasuredError>,
}

/// What was measured of the built tool at one pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredError {
    /// Of the tip, in the CRF's axes; in the tracker's without a CRF.
    pub tip_error_in_crf_mm: Vector3<f64>,
    pub angle_error_deg: Option<f64>,
    /// The pose that was measured, in the tracker's frame without a CRF; `None` of a pivoted tool.
    pub crf_from_tool: Option<Pose>,
}

/// Why a recording has no poses to be looked at beside the design's trials.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecordedPosesError {
    /// In the words of the procedure.
    #[error("{0}")]
    Unusable(String),
    #[error(
        "the CRF was not recorded, so that measured errors are in the tracker's frame and the design's in the CRF's"
    )]
    WithoutCrf,
    #[error(
        "the true poses were registered to this recording, which took up a part of every measured error"
    )]
    Registered,
}

/// Reads a recording of the built tool pose by pose, with errors that those of the design's trials can be
/// held against.
pub fn recorded_poses(
    files: &Files,
    world: &World,
    wanted: &BuiltRecording,
    task: &Task,
) -> Result<RecordedPoses, RecordedPosesError> {
    if wanted.is_registered {
        return Err(RecordedPosesError::Registered);
    }
    let (storage, file) = home(world.document.origin())
        .map_err(|error| RecordedPosesError::Unusable(error.to_string()))?;
    let found = recorded(files, world, (storage, &file), wanted, task, &|_| {})
        .map_err(RecordedPosesError::Unusable)?;
    if found.has_crf != world.document.design().crf.is_some() {
        return Err(RecordedPosesError::WithoutCrf);
    }
    let tip_in_tool = world.document.design().tool.body.rigid.judged_tip_in_body();
    let rows = &found.agreement.rows;
    Ok(RecordedPoses {
        trials: rows
            .iter()
            .map(|row| InputTrial {
                tracker_from_crf: row.tracker_from_crf,
                crf_from_tool: row.crf_from_tool,
            })
            .collect(),
        measured: rows
            .iter()
            .map(|row| MeasuredError {
                tip_error_in_crf_mm: row.measured_mm,
                angle_error_deg: row.measured_rad.map(|turn| turn.norm().to_degrees()),
                crf_from_tool: row.crf_from_tool_measured(&tip_in_tool),
            })
            .collect(),
    })
}

fn decided_on(found: BuiltTool, recording: &BuiltRecording, room: RoomName) -> Recording {
    let summary = found.agreement.summary;
    let position = &summary.position_mm;
    Recording {
        found: DecidedRecording {
            room,
            recording: recording.clone(),
            poses: summary.poses,
            used: summary.used,
            measured_rms_mm: position.measured.rms(),
            predicted_rms_mm: position.predicted.rms(),
            residual_rms_mm: position.residual.rms(),
            explained: position.explained.map(|part| part.value),
            slope: position.slope.map(|slope| slope.value),
            statement: summary.statement.clone(),
        },
        summary,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        RoomSource, open_builtin_without_meshes, open_design, own_room, reference_to_file, save,
        save_as,
    };
    use std::fs;
    use trackwright_design::{Decision, Edit, ProcedureEdit};
    use trackwright_procedure::State;

    fn judged(world: &World) -> StepStatus {
        let wish = ProcedureRequest::default();
        procedure(&Files::default(), world, &wish, &Task::default(), &|_| {}).unwrap()
    }

    fn edit(world: &mut World, edit: ProcedureEdit) {
        world.document.apply(Edit::Procedure(edit)).unwrap();
    }

    fn decide(world: &mut World, step: Step, basis: DecisionBasis) {
        let decision = Decision { date: "2005-10-26".parse().unwrap(), note: String::new(), basis };
        let decision = Box::new(decision);
        edit(world, ProcedureEdit::Decide { step, decision });
    }

    #[test]
    fn a_moved_design_keeps_rooms_and_decisions() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["a", "b", "rooms"] {
            fs::create_dir(at(name)).unwrap();
        }
        let mut world = open_builtin_without_meshes("pointer-on-head").unwrap();
        save_as(&mut world, &at("a/x.design.ron")).unwrap();
        let RoomSource::File(own) = own_room(&world).unwrap() else {
            panic!("a saved design is on the disk");
        };
        fs::copy(own, at("rooms/ward.env.ron")).unwrap();
        let ward = reference_to_file(&world, &at("rooms/ward.env.ron")).unwrap();
        assert_eq!(ward, "../rooms/ward.env.ron");
        edit(&mut world, ProcedureEdit::AddRoom(ward.clone()));
        let found = judged(&world);
        // Twice the same field, and so the same figures.
        let [own, other] = &found.tool.rows[..] else {
            panic!("{:?}", found.tool.rows);
        };
        assert_eq!(own.studied, other.studied);
        for step in [Step::Crf, Step::Tool] {
            decide(&mut world, step, found.basis(step).unwrap());
        }
        let states = |world: &World| {
            let found = judged(world);
            Step::ALL.map(|step| found.state(step))
        };
        let decided = [State::Decided, State::Decided, State::NotRecorded];
        assert_eq!(states(&world), decided);
        save(&mut world).unwrap();

        save_as(&mut world, &at("b/y.design.ron")).unwrap();
        assert_eq!(states(&world), decided);
        let moved = open_design(&at("b/y.design.ron")).unwrap();
        assert_eq!(moved.document.design(), world.document.design());
        assert_eq!(states(&moved), decided);
        // By any of its names, and one that is none of them.
        let room = |file: &Path| further_room(&moved, file).unwrap().map(str::to_owned);
        assert_eq!(room(&at("b/../rooms/ward.env.ron")), Some(ward.clone()));
        assert_eq!(room(Path::new(&ward)), Some(ward));
        assert_eq!(room(&at("rooms/attic.env.ron")), None);
        // The past of the document leads there too.
        while world.document.undo().is_some() {}
        assert!(world.document.design().procedure.is_empty());
        world.document.redo();
        let rooms = &world.document.design().procedure.further_rooms;
        assert_eq!(rooms[..], ["../rooms/ward.env.ron"]);
    }

    #[test]
    fn a_room_that_is_named_twice_is_judged_once() {
        let mut world = open_builtin_without_meshes("endoscope").unwrap();
        let own = world.document.design().environment.clone();
        let again = format!("../designs/{own}");
        edit(&mut world, ProcedureEdit::AddRoom(again));
        assert_eq!(judged(&world).tool.rows.len(), 1);
    }

    #[test]
    fn work_that_nobody_wants_any_more_ends() {
        let world = open_builtin_without_meshes("endoscope").unwrap();
        let task = Task::default();
        task.cancel.cancel();
        let wish = ProcedureRequest::default();
        let ended = procedure(&Files::default(), &world, &wish, &task, &|_| {});
        assert!(matches!(ended, Err(StoreError::Cancelled(_))), "{ended:?}");
    }
}
