//! Tool definitions: the files by which trackers' makers say where a tool's markers or coils are.
//!
//! Each is kept as it was read, to the byte: what this program does not know of one is not lost,
//! and what it changes is written over the original. [`to_body`](ToolDefinition::to_body) and
//! [`from_body()`] lead to bodies and back.

mod atracsys_ini;
mod facts;
mod from_body;
mod geometry;
mod matching;
mod ndi_em;
mod ndi_optical;
mod ndi_rom;
mod saw_json;
#[cfg(test)]
mod tests;
mod tool_plist;

pub use atracsys_ini::AtracsysIni;
pub use facts::{Fact, Lost};
pub use from_body::{BodyFormat, Conversion, ConversionError, DefinitionFormat, from_body};
pub use geometry::Geometry;
pub use ndi_em::{EmCoil, EmRom};
pub use ndi_optical::{OpticalMarker, OpticalRom};
pub use ndi_rom::{Checksum, NdiRom, SerialWord};
pub use saw_json::SawJson;
pub use tool_plist::ToolPlist;

use super::body::{self, BodyFile};
use super::error::FormatError;
use super::ron_text;
use std::borrow::Cow;
use std::sync::Arc;
use trackwright_design::definition::{DefinitionFile, DefinitionKind};
use trackwright_simulation::body::RigidBody;

/// Longest definition that is read, bytes: a thousand times any real one.
pub const MAX_BYTES: usize = 1 << 20;

/// A maker's file for one tool.
#[derive(Clone, Debug, PartialEq)]
pub enum ToolDefinition {
    Rom(NdiRom),
    ToolPlist(ToolPlist),
    AtracsysIni(AtracsysIni),
    SawJson(SawJson),
}

/// What becomes of an image whose checksum does not match.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnMismatch {
    Refuse,
    /// It is read as it is; [`NdiRom::checksum`] still tells.
    Accept,
}

/// The kind of a file by how it begins, then by its name; `None` for what is no definition, as
/// a body file is none.
pub fn kind_of(bytes: &[u8], extension: &str) -> Option<DefinitionKind> {
    if bytes.starts_with(ndi_optical::MAGIC) {
        return Some(DefinitionKind::NdiOptical);
    }
    if bytes.starts_with(ndi_em::MAGIC) {
        return Some(DefinitionKind::NdiEm);
    }
    match first_letter(bytes) {
        Some(b'<') => Some(DefinitionKind::ToolPlist),
        Some(b'{') => Some(DefinitionKind::SawJson),
        Some(b'[' | b';') => Some(DefinitionKind::AtracsysIni),
        // A body file, whatever it is called.
        Some(b'(') => None,
        _ => kind_of_extension(extension),
    }
}

/// What a file of this name is, if any.
pub fn kind_of_extension(extension: &str) -> Option<DefinitionKind> {
    match extension.to_ascii_lowercase().as_str() {
        "rom" => Some(DefinitionKind::NdiOptical),
        "tool" => Some(DefinitionKind::ToolPlist),
        "ini" => Some(DefinitionKind::AtracsysIni),
        "json" => Some(DefinitionKind::SawJson),
        _ => None,
    }
}

/// The first letter that is neither space nor part of a comment as in C.
fn first_letter(bytes: &[u8]) -> Option<u8> {
    let mut rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    loop {
        rest = rest.trim_ascii_start();
        let end: &[u8] = match rest {
            [b'/', b'/', ..] => b"\n",
            [b'/', b'*', ..] => b"*/",
            _ => return rest.first().copied(),
        };
        let at = rest.windows(end.len()).skip(2).position(|w| w == end)?;
        rest = &rest[2 + at + end.len()..];
    }
}

/// Reads whatever a body may be given by: a body file or a definition, by its content and then by
/// its name; and which kind of definition it was, if any.
///
/// # Errors
/// See [`FormatError`].
pub fn read_body(
    bytes: &[u8],
    extension: &str,
    on_mismatch: OnMismatch,
) -> Result<(BodyFile, Option<DefinitionKind>), FormatError> {
    let Some(kind) = kind_of(bytes, extension) else {
        return Ok((body::parse(bytes)?, None));
    };
    let definition = ToolDefinition::parse(kind, bytes, on_mismatch)?;
    let file = BodyFile {
        rigid: definition.to_body(),
        mesh: None,
        definition: Some(Arc::new(definition.file())),
    };
    Ok((file, Some(kind)))
}

impl ToolDefinition {
    /// Reads a definition of a kind.
    ///
    /// # Errors
    /// See [`FormatError`]; [`FormatError::Checksum`] only with [`OnMismatch::Refuse`].
    pub fn parse(
        kind: DefinitionKind,
        bytes: &[u8],
        on_mismatch: OnMismatch,
    ) -> Result<Self, FormatError> {
        if bytes.len() > MAX_BYTES {
            return Err(FormatError::field(
                "length",
                format!("{} bytes", bytes.len()),
                "at most 1 MiB for a tool definition",
            ));
        }
        let definition = match kind {
            DefinitionKind::NdiOptical => {
                Self::Rom(NdiRom::Optical(OpticalRom::parse(bytes, on_mismatch)?))
            }
            DefinitionKind::NdiEm => Self::Rom(NdiRom::Em(EmRom::parse(bytes, on_mismatch)?)),
            DefinitionKind::ToolPlist => Self::ToolPlist(ToolPlist::parse(bytes, on_mismatch)?),
            DefinitionKind::AtracsysIni => Self::AtracsysIni(AtracsysIni::parse(bytes)?),
            DefinitionKind::SawJson => Self::SawJson(SawJson::parse(bytes)?),
        };
        check_positions(&definition.to_body())?;
        Ok(definition)
    }

    /// Reads what a body carries; a checksum that does not match was accepted when it was read first.
    ///
    /// `None` where it carries nothing, or what is no definition: [`file`](Self::file) makes none
    /// of those.
    pub fn carried(file: Option<&DefinitionFile>) -> Option<Self> {
        file.and_then(|it| Self::parse(it.kind, &it.bytes, OnMismatch::Accept).ok())
    }

    /// It as a body carries it.
    pub fn file(&self) -> DefinitionFile {
        DefinitionFile { kind: self.kind(), bytes: self.write().into_owned() }
    }

    /// The whole file.
    pub fn write(&self) -> Cow<'_, [u8]> {
        match self {
            Self::Rom(rom) => Cow::Owned(rom.write()),
            Self::ToolPlist(plist) => Cow::Borrowed(plist.write().as_bytes()),
            Self::AtracsysIni(ini) => Cow::Borrowed(ini.write().as_bytes()),
            Self::SawJson(json) => Cow::Borrowed(json.write().as_bytes()),
        }
    }

    pub fn kind(&self) -> DefinitionKind {
        match self {
            Self::Rom(NdiRom::Optical(_)) => DefinitionKind::NdiOptical,
            Self::Rom(NdiRom::Em(_)) => DefinitionKind::NdiEm,
            Self::ToolPlist(_) => DefinitionKind::ToolPlist,
            Self::AtracsysIni(_) => DefinitionKind::AtracsysIni,
            Self::SawJson(_) => DefinitionKind::SawJson,
        }
    }

    /// The image that it is or wraps.
    pub fn rom(&self) -> Option<&NdiRom> {
        match self {
            Self::Rom(rom) => Some(rom),
            Self::ToolPlist(plist) => Some(plist.rom()),
            Self::AtracsysIni(_) | Self::SawJson(_) => None,
        }
    }

    /// The geometry that it spells out.
    pub fn geometry(&self) -> Option<&Geometry> {
        match self {
            Self::AtracsysIni(ini) => Some(ini.geometry()),
            Self::SawJson(json) => Some(json.geometry()),
            Self::Rom(_) | Self::ToolPlist(_) => None,
        }
    }

    /// The body that it describes: `marker 1`, … by their positions alone, or `coil 1`, … as 5-DOF
    /// sensors, in the definition's own frame.
    ///
    /// The tip of a coil tool is the origin; that of markers is where a pivot says, if one does.
    pub fn to_body(&self) -> RigidBody {
        match (self.rom(), self.geometry()) {
            (Some(rom), _) => rom.to_body(),
            (None, Some(geometry)) => geometry.to_body(),
            // Each kind is one or the other.
            (None, None) => {
                RigidBody { name: String::new(), tip_in_body: None, sensors: Vec::new() }
            }
        }
    }
}

/// As in a body file, so that the body can be saved as one.
fn check_positions(body: &RigidBody) -> Result<(), FormatError> {
    let sensors = body.sensors.iter();
    let sensors = sensors.map(|sensor| (sensor.name.as_str(), sensor.position_in_body));
    for (name, position) in sensors.chain(body.tip_in_body.map(|tip| ("tip", tip))) {
        ron_text::point(&format!("{name}: position"), position.coords.into())?;
    }
    Ok(())
}
