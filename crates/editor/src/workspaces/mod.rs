//! The workspaces: each a folder with its state, systems and panels, which registers with the shell.

pub mod decide;
pub mod design;
pub mod field;
pub mod layers_panel;
pub mod live;
pub mod present;
pub mod study;
