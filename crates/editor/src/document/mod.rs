//! The open document: requests, edits, files, recovery.

pub mod apply;
pub mod autosave;
pub mod awaited_meshes;
pub mod body_dialogs;
pub mod body_files;
pub mod commands;
pub mod dialog;
pub mod drops;
pub mod exports;
pub mod file_names;
pub mod meshes;
pub mod open_outside;
pub mod own_program;
pub mod recent;
pub mod report;
pub mod requests;
pub mod selection;
pub mod shown;
pub mod state;
pub mod trials;
