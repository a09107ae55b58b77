//! The editor: without a window, in pictures, and in a real window.

mod copied;
mod document;
mod overlay;
mod panels;
mod picture;
mod pixels;
mod solver;
mod support;
mod wake;
mod window;
