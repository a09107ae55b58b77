//! The editor without a window: requests in, resources and messages out.

mod document;
mod drag;
mod overlay;
mod panels;
mod shortcuts;
mod solver;
mod support;
mod wake;
