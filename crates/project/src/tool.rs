//! Tools on the disk: body files and makers' definitions, each of which may stand for the other.

use super::error::StoreError;
use super::paths::{absolute, extension_of, folder_of, relative};
use super::read::{Kind, Storage, open_input, read};
use std::io::Read;
use std::path::Path;
use trackwright_design::DesignBody;
use trackwright_design::definition::DefinitionKind;
use trackwright_formats::tool_definition::{
    BodyFormat, OnMismatch, kind_of, kind_of_extension, read_body as parse_tool,
};
use trackwright_formats::{BodyFile, FormatError, body};
use trackwright_geometry::mesh_reference::MeshReference;

/// Enough of a file to determine what kind of one it is, its first comment included.
const BEGINNING: u64 = 4096;

/// A tool as it was read.
#[derive(Clone, Debug)]
pub struct ReadTool {
    pub body: BodyFile,
    /// `None` where it was a body file; its body may carry a definition all the same.
    pub kind: Option<DefinitionKind>,
}

/// Reads a body file or a maker's definition; refuses a wrong checksum unless it is accepted.
pub(super) fn read_tool(file: &Path, on_mismatch: OnMismatch) -> Result<ReadTool, StoreError> {
    read(Storage::Disk, file, Kind::TOOL, |bytes| {
        let (body, kind) = parse_tool(bytes, &extension_of(file), on_mismatch)?;
        Ok(ReadTool { body, kind })
    })
}

/// The file of a body that was read from `source`, whose meshes it still refers to from `file`.
pub(super) fn moved_body_text(body: &BodyFile, source: &Path, file: &Path) -> String {
    let mut body = body.clone();
    reach_mesh(&mut body.mesh, source, file);
    body::write(&body)
}

/// What a body is written as to a file of this name.
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

/// Whether a file is a maker's by its content, or by its name where it is gone.
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

/// The text of a body's file.
pub(super) fn body_text(body: &DesignBody) -> String {
    body::write(&BodyFile::of(body))
}

/// Makes a body's mesh reachable from a file in perhaps another folder.
pub(super) fn reach_mesh(mesh: &mut Option<MeshReference>, old_file: &Path, file: &Path) {
    let (old_folder, folder) = (folder_of(old_file), folder_of(file));
    if let Some(mesh) = mesh
        && !Path::new(&mesh.file).is_absolute()
        && absolute(&old_folder) != absolute(&folder)
    {
        mesh.file = relative(&folder, &Storage::Disk.resolve(old_file, &mesh.file));
    }
}
