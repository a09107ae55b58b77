//! What nearly every command names.

pub use super::as_is::AsIsArgs;
pub use super::choice::Choice;
pub use super::output::{self, Ending, Format, OUTSIDE, Row, Shown, count, mm, number, row};
pub use anyhow::{Context, anyhow, bail};
pub use clap::Args;
pub use serde_json::{Value, json};
pub use std::path::{Path, PathBuf};
pub use trackwright_field::OutsidePolicy;
pub use trackwright_project::Files;
pub use trackwright_simulation::figures::with_separators;
