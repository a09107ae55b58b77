//! What kind of tool definition a file is.

use super::{ndi_em, ndi_optical};
use trackwright_design::definition::DefinitionKind;

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
