//! The workspaces: each a folder with its state, systems and panels.

pub mod decide;
pub mod design;
pub mod field;
pub mod live;
pub mod present;
pub mod study;
