//! All integration tests in one crate, so that what they need is linked once.

mod commands;
#[cfg(feature = "editor")]
mod editor;
mod oracle;
mod support;
