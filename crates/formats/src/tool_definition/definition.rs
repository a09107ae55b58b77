//! A tool definition of any kind: read, written, as a body.

use super::atracsys_ini::AtracsysIni;
use super::geometry::Geometry;
use super::kind::kind_of;
use super::ndi_em::EmRom;
use super::ndi_image::OnMismatch;
use super::ndi_optical::OpticalRom;
use super::ndi_rom::NdiRom;
use super::saw_json::SawJson;
use super::tool_plist::ToolPlist;
use crate::body::{self, BodyFile};
use crate::error::FormatError;
use crate::ron_text;
use std::borrow::Cow;
use std::sync::Arc;
use trackwright_design::definition::{DefinitionFile, DefinitionKind};
use trackwright_simulation::body::RigidBody;
use trackwright_simulation::mounting::Mounting;

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

/// Reads whatever a body may be given by: a body file or a definition, by its content and then by
/// its name; and which kind of definition it was, if any.
///
/// ```
/// use trackwright_formats::tool_definition::{OnMismatch, read_body};
///
/// let json = br#"{"count": 1, "id": 7, "fiducials": [{"x": 1, "y": 0, "z": 2.5}]}"#;
/// let (body, _) = read_body(json, "json", OnMismatch::Refuse)?;
/// assert_eq!(body.rigid.sensors[0].position_in_body.z, 2.5);
/// # Ok::<(), trackwright_formats::FormatError>(())
/// ```
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
        mounting: Mounting::default(),
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
    /// The tip of a coil tool is the origin; that of markers is where a pivot states it, if one
    /// does.
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
