//! The editor: without a window, in pictures, and in a real window.

mod anatomy;
mod app;
mod autosave;
mod bad_places;
mod body_files;
mod copied;
mod decide;
mod document;
mod drag;
mod drops;
mod field_layers;
mod field_panels;
mod field_workspace;
mod file_dialogs;
mod gizmo;
mod hand;
mod layer_settings;
mod live;
mod meshes;
mod motion_box;
mod new_design;
mod overlay;
mod panels;
mod picture;
mod pixels;
mod precision_page;
mod preferences;
mod present;
mod probe;
mod procedure;
mod report;
mod sensor_panels;
mod sensors;
mod shortcuts;
mod slice_quantities;
mod solver;
mod study;
mod study_panels;
#[allow(dead_code, reason = "the tests of the program use the rest")]
#[path = "../support/mod.rs"]
mod support;
mod tip_scatter;
mod tools;
mod uploads;
mod wake;
mod window;
