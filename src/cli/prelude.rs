//! What nearly every command names.

pub(super) use super::as_is::{AsIsArgs, TableArgs};
pub(super) use super::choice::Choice;
pub(super) use super::output::{self, Ending, Format, OUTSIDE, Shown};
pub(super) use anyhow::{Context, anyhow, bail};
pub(super) use clap::Args;
pub(super) use serde_json::{Value, json};
pub(super) use std::path::{Path, PathBuf};
pub(super) use trackwright_field::OutsidePolicy;
pub(super) use trackwright_project::{Files, file_name};
pub(super) use trackwright_result::with_separators;
