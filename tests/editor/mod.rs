//! The editor: without a window, in pictures, and in a real window.

mod copied;
mod document;
mod drag;
mod field_layers;
mod field_panels;
mod field_workspace;
mod gizmo;
mod hand;
mod overlay;
mod panels;
mod picture;
mod pixels;
mod precision_page;
mod sensor_panels;
mod sensors;
mod shortcuts;
mod slice_quantities;
mod solver;
mod study;
mod study_panels;
mod support;
mod tip_scatter;
mod tools;
mod uploads;
mod wake;
mod window;
