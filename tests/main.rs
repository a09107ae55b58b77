//! All integration tests in one crate, so that what they need is linked once.

mod commands;
mod oracle;
mod support;
