//! The disk: designs with all that they refer to, atomic writes, and the built-in world.
//!
//! ```
//! use trackwright_project::{open_builtin, open_design, resolve, save_as};
//!
//! let folder = tempfile::tempdir()?;
//! let file = folder.path().join("mine.design.ron");
//! let mut world = open_builtin("pointer-on-head")?;
//! // The design, its bodies, their meshes and its room.
//! let report = save_as(&mut world, &file)?;
//! assert_eq!(report.written.len(), 6);
//! let again = open_design(&file)?;
//! assert_eq!(again.document.design(), world.document.design());
//! let scenario = resolve(again.document.design(), &again.environment);
//! assert_eq!(scenario.orientation_weight_mm, 100.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod baseline;
mod body_export;
mod built_tool;
mod builtin;
mod coil_fit;
mod error;
mod files;
mod import_body;
mod kinds;
mod layout_edits;
mod meshes;
mod new_tool;
mod open;
mod other_designs;
mod paths;
mod placement_problem;
mod procedure;
mod read;
mod reader;
mod recovery;
mod resolve;
mod results;
mod room_metal;
mod rooms;
mod samples;
mod save;
mod save_room;
mod stamps;
mod state;
#[cfg(test)]
mod tests;
mod tool;
mod tool_section;
mod video;
mod watch;
mod world;
mod write;
mod written;

pub use baseline::{
    KeptBaseline, baseline_file_of, read_baseline, remove_baseline, write_baseline,
};
pub use body_export::{BodyExport, definition_name};
pub use built_tool::{BuiltTool, BuiltToolFailure, BuiltToolNote, BuiltToolTables, built_tool};
pub use builtin::{DEFAULT_BUILTIN, Starter, builtin_named, builtin_names};
pub use coil_fit::{coil_findings, coil_findings_of};
pub use error::StoreError;
pub use files::{Files, Output};
pub use import_body::{BodyImport, ImportedBody};
pub use kinds::Doubted;
pub use layout_edits::layout_edits;
pub use meshes::{
    ImportedMesh, MeshDoubt, MeshImport, MeshOwner, MeshProblem, mesh_reference_to, refresh_meshes,
    reload_meshes,
};
pub use new_tool::{flipped_tool, new_tool_of_mesh};
pub use open::{
    generator_mesh, open_builtin, open_builtin_without_meshes, open_design, open_design_to_show,
    open_design_without_meshes, open_variant, refresh_environment,
};
pub use paths::{ENVIRONMENT_EXTENSION, file_name, room_name};
pub use placement_problem::{
    MOST_SENSORS, MOST_SETS, MoveBounds, MoveError, design_rooms, named_moves, placement_problem,
    sets_of_sensors,
};
pub use procedure::{
    MeasuredError, ProcedureRequest, RecordedPoses, RecordedPosesError, further_room, procedure,
    recorded_poses,
};
pub use recovery::{Leftover, Recovery, Snapshot, leftovers};
pub use resolve::{
    ComparedDesign, ComparedRoom, ComparedRooms, CrfScenario, comparison_plan,
    read_compared_designs, read_compared_rooms, resolve, resolve_crf,
};
pub use results::{LogError, NoToday, Recorder, report_file, today, write_log};
pub use room_metal::{MetalAnswer, MetalRequest, RoomContent, refresh_metal};
pub use rooms::{
    RoomListing, RoomSource, RoomSummary, builtin_rooms, further_rooms, list_rooms, own_room,
    reference_to_file, reference_to_room, rooms_of_folder, write_room_for,
};
pub use samples::{
    MOST_LAG_ROWS, MOST_SENSOR_OFFSET_MM, MeasurementTable, SampleReading, TableGroups,
};
pub use save::{SaveReport, SharedBody, save, save_as, save_with_copies, shared_bodies};
pub use stamps::FileChange;
pub use state::{
    MAX_RECENT, RecentDesign, STATE_VARIABLE, forget_recent, read_preferences, recent_designs,
    recovery_folder, remember_recent, state_folder, write_preferences,
};
pub use tool::{ReadTool, body_format_of, is_same_file};
pub use video::{ENCODER, FrameFolder, VideoError, VideoFile, VideoShape};
pub use watch::{ChangedFile, WatchedPart, accept_changes, changes};
pub use world::World;
pub use write::{KeptFile, check_place, remove_interrupted};
