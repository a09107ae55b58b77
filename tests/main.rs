//! All integration tests in one crate, so that what they need is linked once.

mod adversarial;
mod commands;
#[cfg(feature = "editor")]
mod editor;
mod invariants;
mod live;
mod oracle;
mod rooms;
mod simulation;
mod support;
