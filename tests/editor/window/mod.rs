//! The real window on a display of its own, used with pointer and keys only.

mod at_rest;
mod broken_file;
mod decide;
mod display;
mod drag;
mod first_day;
mod harness;
mod keyboard;
mod killed;
mod layer;
mod metal;
mod places;
mod present;
mod room_e;
mod screen;
mod session;
mod typed;
