//! A tracker maker's own file for a tool, as a body carries it: its kind and its bytes.

use serde::Deserialize;

/// What kind of file a definition is; body files name it so.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum DefinitionKind {
    NdiOptical,
    NdiEm,
    ToolPlist,
    AtracsysIni,
    SawJson,
}

impl DefinitionKind {
    /// Its name within a sentence, with its article.
    pub fn name(self) -> &'static str {
        match self {
            Self::NdiOptical => "an NDI optical ROM",
            Self::NdiEm => "an NDI Aurora ROM",
            Self::ToolPlist => "an NDI .tool file",
            Self::AtracsysIni => "an Atracsys geometry",
            Self::SawJson => "a SAW geometry",
        }
    }

    /// Its name for a program.
    pub fn code(self) -> &'static str {
        match self {
            Self::NdiOptical => "ndi_optical",
            Self::NdiEm => "ndi_em",
            Self::ToolPlist => "tool_plist",
            Self::AtracsysIni => "atracsys_ini",
            Self::SawJson => "saw_json",
        }
    }
}

/// A maker's whole file, to the byte. Who knows its format reads it.
#[derive(Clone, Debug, PartialEq)]
pub struct DefinitionFile {
    pub kind: DefinitionKind,
    pub bytes: Vec<u8>,
}
