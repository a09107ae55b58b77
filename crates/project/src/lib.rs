//! The disk: designs with all that they refer to, atomic writes, and the built-in world.

mod anatomy;
mod body_export;
mod built_tool;
mod builtin;
mod compared;
mod doubted;
mod error;
mod file_id;
mod files;
mod import_body;
mod lock;
mod log;
mod mesh_cache;
mod meshes;
mod open;
mod place;
mod preferences;
mod procedure;
mod read;
mod recent;
mod recorder;
mod recovery;
mod replace;
mod report_file;
mod resolve;
mod rooms;
mod samples;
mod save;
mod shared;
mod state;
mod table;
#[cfg(test)]
mod tests;
mod today;
mod tool;
mod video;
mod watch;
mod write;

pub use body_export::{BodyExport, definition_name};
pub use built_tool::{BuiltTool, BuiltToolFailure, BuiltToolNote, BuiltToolTables, built_tool};
pub use builtin::{DEFAULT_BUILTIN, Starter, builtin_names, generator_mesh};
pub use compared::{
    ComparedDesign, ComparedRoom, ComparedRooms, comparison_plan, read_compared_designs,
    read_compared_rooms,
};
pub use doubted::Doubted;
pub use error::StoreError;
pub use files::{Files, Output};
pub use import_body::{BodyImport, ImportedBody};
pub use log::{LogError, write_log};
pub use mesh_cache::{ImportedMesh, MeshImport};
pub use meshes::{
    MeshDoubt, MeshOwner, MeshProblem, mesh_reference_to, refresh_meshes, reload_meshes,
};
pub use open::{
    World, open_builtin, open_builtin_without_meshes, open_design, open_design_without_meshes,
    refresh_environment,
};
pub use preferences::{read_preferences, write_preferences};
pub use procedure::{ProcedureRequest, further_room, procedure, reference_to_file};
pub use recent::{MAX_RECENT, RecentDesign, forget_recent, recent_designs, remember_recent};
pub use recorder::Recorder;
pub use recovery::{Leftover, Recovery, Snapshot, leftovers};
pub use replace::KeptFile;
pub use report_file::report_file;
pub use resolve::{CrfScenario, resolve, resolve_crf};
pub use rooms::{
    ENVIRONMENT_EXTENSION, RoomListing, RoomSource, RoomSummary, builtin_rooms, further_rooms,
    list_rooms, own_room, reference_to_room, room_name, rooms_of_folder, write_room_for,
};
pub use samples::SampleReading;
pub use save::{SaveReport, save, save_as, save_with_copies};
pub use shared::{SharedBody, shared_bodies};
pub use state::{STATE_VARIABLE, recovery_folder, state_folder};
pub use table::{MeasurementTable, TableGroups};
pub use today::{NoToday, today};
pub use tool::{ReadTool, body_format_of, is_same_file};
pub use video::{ENCODER, FrameFolder, VideoError, VideoFile, VideoShape};
pub use watch::{ChangedFile, FileChange, WatchedPart, accept_changes, changes};
