//! The tests of the program and its libraries, in one crate, so that what they need is linked once.
//! Those of the editor are in `editor/`.

mod adversarial;
mod commands;
mod invariants;
mod live;
mod oracle;
mod rooms;
mod simulation;
#[allow(dead_code, reason = "the tests of the editor use the rest")]
mod support;
