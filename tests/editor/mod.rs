//! The editor: without a window, in pictures, and in a real window.

mod copied;
mod document;
mod drag;
mod overlay;
mod panels;
mod picture;
mod pixels;
mod shortcuts;
mod solver;
mod support;
mod uploads;
mod wake;
mod window;
