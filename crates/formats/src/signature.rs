//! What kind of document a file is by how it begins, for messages about it.

use super::ron_tokens::{Token, Tokens};
use super::tool_definition::{kind_of, kind_of_extension};
use super::{computed_model, process};
use std::fmt;
use trackwright_design::definition::DefinitionKind;

/// Enough of a file to determine its kind, bytes: an environment names its model behind what it was
/// fitted to.
pub const BEGINNING: usize = 1 << 16;

/// Longest name of a table's columns that a message quotes.
const MAX_QUOTE: usize = 60;

/// Formats by the bytes that they begin with.
const MAGIC: [(&[u8], &str); 8] = [
    (b"\x89PNG\r\n", "a PNG picture"),
    (b"glTF", "a GLB file"),
    (b"NRRD", "an NRRD volume"),
    (b"ObjectType", "a MetaImage"),
    (b"#Insight Transform File", "an ITK transform"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"%PDF", "a PDF document"),
    (b"\x7fELF", "a program"),
];

const ENVIRONMENT: &str = "an environment";

/// The program's own documents by a field that only they have.
const DOCUMENTS: [(&str, &str); 5] = [
    ("environment", "a design"),
    ("sensors", "a body"),
    ("coils", "a field generator"),
    ("model", ENVIRONMENT),
    ("metal", ENVIRONMENT),
];

/// Comments that the program writes itself into an environment; its polynomials have one each, that
/// states its number, their count and its axis.
const OWN_COMMENTS: [&str; 4] = [
    process::ROWS_COMMENT,
    process::REFITS_COMMENT,
    computed_model::WEIGHTS_COMMENT,
    computed_model::COILS_COMMENT,
];

/// The kind of a document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Signature {
    Empty,
    /// A format that is recognised by its first bytes, or a document in RON.
    Kind(&'static str),
    /// HTML, SVG or XML by its outermost element.
    Markup(String),
    /// JSON by its first key.
    Json(String),
    /// A maker's tool definition.
    Definition(DefinitionKind),
    /// A table or any other text by its first line.
    Text(String),
    Binary,
}

impl Signature {
    /// The kind of a file; `extension` distinguishes formats whose beginnings do not.
    ///
    /// ```
    /// use trackwright_formats::signature::Signature;
    ///
    /// let body = b"(version: 1, name: \"a\", sensors: [";
    /// assert_eq!(Signature::of(body, "ron").to_string(), "a body");
    /// ```
    pub fn of(beginning: &[u8], extension: &str) -> Self {
        if beginning.is_empty() {
            return Self::Empty;
        }
        if let Some(kind) = definition_kind(beginning, extension) {
            return Self::Definition(kind);
        }
        if beginning.get(4..8) == Some(b"ftyp") {
            return Self::Kind("an MP4 video");
        }
        if let Some((_, kind)) = MAGIC.iter().find(|(magic, _)| beginning.starts_with(magic)) {
            return Self::Kind(kind);
        }
        let text = match std::str::from_utf8(beginning) {
            Ok(text) => text,
            // Cut within a character.
            Err(error) if error.error_len().is_none() => {
                std::str::from_utf8(&beginning[..error.valid_up_to()]).unwrap_or_default()
            }
            Err(_) => return Self::Binary,
        };
        let text = text.trim_start_matches('\u{feff}').trim_start();
        if text.starts_with('<') {
            return Self::Markup(root_element(text));
        }
        if let Some(inside) = text.strip_prefix(['{', '[']) {
            let key = inside.trim_start().trim_start_matches(['[', '{', '\n', ' ']);
            let key = key.split([':', ',']).next().unwrap_or_default();
            return Self::Json(key.trim().trim_matches('"').to_owned());
        }
        let (fields, _) = fields_and_comments(text);
        if let Some(kind) = document_kind(&fields) {
            return Self::Kind(kind);
        }
        Self::Text(text.lines().next().unwrap_or_default().trim_end().to_owned())
    }
}

/// Whether a document in RON has comments that the program did not write.
pub fn holds_more_than_written(document: &[u8]) -> bool {
    let text = String::from_utf8_lossy(document);
    let (fields, comments) = fields_and_comments(&text);
    let is_by_hand = comments.iter().any(|comment| !is_own_comment(comment));
    is_by_hand && document_kind(&fields).is_some()
}

fn is_own_comment(comment: &str) -> bool {
    let comment = comment.trim_end();
    let is_count = |text: &str| text.parse::<usize>().is_ok();
    let is_axis = |text: &str| {
        let (number, rest) = text.split_once(" of ")?;
        let (count, _) = rest.split_once(": axis (")?;
        Some(is_count(number) && is_count(count))
    };
    let axis = comment.strip_prefix("// ").and_then(is_axis);
    OWN_COMMENTS.contains(&comment) || axis == Some(true)
}

/// Only names distinguish `.tool` and `.ini` from other XML and text; JSON has keys.
fn definition_kind(beginning: &[u8], extension: &str) -> Option<DefinitionKind> {
    use DefinitionKind::{AtracsysIni, NdiEm, NdiOptical, SawJson, ToolPlist};
    match kind_of(beginning, extension)? {
        SawJson => None,
        kind @ (NdiOptical | NdiEm) => Some(kind),
        kind @ (ToolPlist | AtracsysIni) => {
            (kind_of_extension(extension) == Some(kind)).then_some(kind)
        }
    }
}

fn document_kind(fields: &[&str]) -> Option<&'static str> {
    let known = DOCUMENTS.iter().find(|(field, _)| fields.contains(field));
    known.map(|(_, kind)| *kind)
}

/// The fields of a RON text's outermost struct, and its comments.
fn fields_and_comments(text: &str) -> (Vec<&str>, Vec<&str>) {
    let (mut fields, mut comments) = (Vec::new(), Vec::new());
    let mut depth = 0_usize;
    let mut tokens = Tokens::with_comments(text).peekable();
    while let Some((token, range)) = tokens.next() {
        match token {
            Token::Comment => comments.push(&text[range]),
            Token::Sign('(' | '[' | '{') => depth += 1,
            Token::Sign(')' | ']' | '}') => depth = depth.saturating_sub(1),
            Token::Word
                if depth == 1
                    && tokens.peek().is_some_and(|(next, _)| *next == Token::Sign(':')) =>
            {
                fields.push(&text[range]);
            }
            _ => {}
        }
    }
    (fields, comments)
}

/// The name of the first element that is no declaration or comment.
fn root_element(text: &str) -> String {
    let mut rest = text;
    while let Some(at) = rest.find('<') {
        let inside = &rest[at + 1..];
        if !inside.starts_with(['?', '!']) {
            let end = inside.find(|c: char| c.is_whitespace() || c == '>' || c == '/');
            let name = &inside[..end.unwrap_or(inside.len())];
            return name.to_ascii_lowercase();
        }
        let behind = match inside.starts_with("!--") {
            true => inside.find("-->"),
            false => inside.find('>'),
        };
        rest = &inside[behind.unwrap_or(inside.len())..];
    }
    String::new()
}

impl fmt::Display for Signature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("an empty file"),
            Self::Kind(kind) => f.write_str(kind),
            Self::Markup(element) => write!(f, "a <{element}> document"),
            Self::Json(key) => write!(f, "JSON that begins with {:?}", shortened(key)),
            Self::Definition(kind) => f.write_str(kind.name()),
            Self::Text(line) => write!(f, "text that begins with {:?}", shortened(line)),
            Self::Binary => f.write_str("a file of an unknown kind"),
        }
    }
}

fn shortened(text: &str) -> String {
    match text.char_indices().nth(MAX_QUOTE) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment;
    use std::sync::Arc;
    use trackwright_field::Environment;

    fn name(text: &str) -> String {
        Signature::of(text.as_bytes(), "").to_string()
    }

    #[test]
    fn documents_are_known_by_their_own_fields() {
        let design = "(version: 1, name: \"sensors: (\", environment: \"a\", tool: (sensors: []))";
        assert_eq!(name(design), "a design");
        assert_eq!(name("(version: 1, sensors: [])"), "a body");
        assert_eq!(name("// (sensors: 1)\n(model: ())"), "an environment");
        assert_eq!(name("(coils: [])"), "a field generator");
        assert_eq!(name("(x: 1)"), "text that begins with \"(x: 1)\"");
        assert_eq!(name("<?xml?><!-- <a> --><svg x=\"1\"/>"), "a <svg> document");
        assert_eq!(name("<!DOCTYPE html><html>"), "a <html> document");
        assert_eq!(name("{\n  \"@schema\": 1}"), "JSON that begins with \"@schema\"");
        assert_eq!(Signature::of(b"\xff\xfe\x00", ""), Signature::Binary);
        assert_eq!(name(""), "an empty file");
    }

    #[test]
    fn comments_are_found_outside_of_strings_only() {
        assert!(holds_more_than_written(b"(sensors: [], // mine\n)"));
        assert!(holds_more_than_written(b"(sensors: [] /* mine */)"));
        assert!(!holds_more_than_written(b"(sensors: [], keep_out: [])"));
        assert!(!holds_more_than_written(br#"(name: "a \" // b", sensors: [])"#));
    }

    #[test]
    fn comments_of_a_written_environment_are_its_own() {
        let built_in = include_bytes!("../../../assets/environments/operating-table.env.ron");
        assert!(built_in.windows(2).any(|two| two == b"//"));
        assert!(!holds_more_than_written(built_in));
        let [kriging, harmonic] = computed_model::tests::environments();
        let process = Some(Arc::new(environment::tests::process(true)));
        for room in [kriging, Environment { process, ..harmonic }] {
            let text = environment::tests::write(&room);
            assert!(text.contains("//") && !holds_more_than_written(text.as_bytes()), "{text}");
        }
        assert!(OWN_COMMENTS.iter().all(|comment| is_own_comment(comment)));
        assert!(is_own_comment("// 3 of 14: axis (0.5774, 0.5774, 0.5774)"));
        assert!(!is_own_comment("// 3 of 14 were wrong: axis (x)"));
    }
}
