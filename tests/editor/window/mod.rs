//! The real window on a display of its own, used with pointer and keys only.

mod at_rest;
mod broken_file;
mod display;
mod drag;
mod harness;
mod layer;
mod places;
mod screen;
mod typed;
