//! Tools on the disk: body files and makers' definitions, each of which may stand for the other.

use super::error::StoreError;
use super::place::{Kind, Place, absolute, open_input};
use super::read::read;
use super::save::reach_mesh;
use std::io::Read;
use std::path::Path;
use trackwright_design::definition::DefinitionKind;
use trackwright_formats::tool_definition::{
    BodyFormat, OnMismatch, kind_of, kind_of_extension, read_body as parse_tool,
};
use trackwright_formats::{BodyFile, FormatError, body};

/// Enough of a file to tell what kind of one it is, its first comment included.
const BEGINNING: u64 = 4096;

/// A tool as it was read.
#[derive(Clone, Debug)]
pub struct ReadTool {
    pub body: BodyFile,
    /// `None` where it was a body file; its body may carry a definition all the same.
    pub kind: Option<DefinitionKind>,
}

/// Reads a body file or a maker's definition, whichever it is.
///
/// # Errors
/// See [`StoreError`]; a checksum that does not match only with [`OnMismatch::Refuse`].
pub(super) fn read_tool(file: &Path, on_mismatch: OnMismatch) -> Result<ReadTool, StoreError> {
    read(Place::Disk, file, Kind::TOOL, |bytes| {
        let (body, kind) = parse_tool(bytes, &extension_of(file), on_mismatch)?;
        Ok(ReadTool { body, kind })
    })
}

/// The file of a body that was read from `source`, whose meshes it still refers to from `file`.
pub(super) fn body_text(body: &BodyFile, source: &Path, file: &Path) -> String {
    let mut body = body.clone();
    reach_mesh(&mut body.mesh, source, file);
    body::write(&body)
}

/// What a body is written as to a file of this name.
///
/// # Errors
/// [`StoreError::NoBodyFormat`].
pub fn body_format_of(file: &Path) -> Result<BodyFormat, StoreError> {
    BodyFormat::of_extension(&extension_of(file))
        .ok_or_else(|| StoreError::NoBodyFormat { file: file.to_owned() })
}

/// Whether two names lead to one file.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    absolute(a) == absolute(b)
}

/// Reads what a design refers to as a body.
pub(super) fn parse_body(file: &Path, bytes: &[u8]) -> Result<BodyFile, FormatError> {
    parse_tool(bytes, &extension_of(file), OnMismatch::Refuse).map(|(body, _)| body)
}

/// Whether a file is a maker's by what is in it, or, where it is gone, by its name: nothing of
/// this program's is written over it.
pub(super) fn is_definition(file: &Path) -> bool {
    let mut bytes = Vec::new();
    let beginning = open_input(file).ok().map(|file| {
        let mut beginning = file.take(BEGINNING);
        beginning.read_to_end(&mut bytes)
    });
    match beginning {
        Some(Ok(_)) => kind_of(&bytes, &extension_of(file)).is_some(),
        _ => kind_of_extension(&extension_of(file)).is_some(),
    }
}

/// What the body file of a definition is called.
pub(super) fn body_name(definition: &Path) -> String {
    let stem = definition.file_stem().unwrap_or_default();
    format!("{}.body.ron", stem.to_string_lossy())
}

pub(super) fn extension_of(file: &Path) -> String {
    let extension = file.extension().unwrap_or_default();
    extension.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests;
