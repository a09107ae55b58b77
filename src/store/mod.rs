//! The disk: designs with all that they refer to, atomic writes, and the built-in world.

mod builtin;
mod error;
mod open;
mod place;
mod read;
mod resolve;
mod rooms;
mod samples;
mod save;
mod shared;
mod table;
#[cfg(test)]
mod tests;
mod write;

pub use builtin::{DEFAULT_BUILTIN, builtin_names, generator_mesh};
pub use error::StoreError;
pub use open::{World, open_builtin, open_design, refresh_environment};
pub use read::{
    read_calbody, read_calreadings, read_environment, read_groups, read_input, read_measurements,
    read_mesh, read_poses,
};
pub use resolve::resolve;
pub use rooms::{
    ENVIRONMENT_EXTENSION, RoomListing, RoomPlace, RoomSummary, builtin_rooms, list_rooms,
    own_room, reference_to_room, room_name, rooms_of_folder, write_room_for,
};
pub use samples::{SampleReading, read_samples};
pub use save::{SaveReport, save, save_as, save_with_copies};
pub use shared::{SharedBody, shared_bodies};
pub use table::{MeasurementTable, TableGroups, read_table};
pub use write::{write_atomic, write_environment};
