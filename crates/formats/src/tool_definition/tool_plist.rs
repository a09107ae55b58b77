//! `.tool` files: a property list in XML with an NDI image in base64 under `ROMData`.
//!
//! Only that one datum is looked at. The rest of the text stays as it is, and entities are not
//! expanded, so that no text is longer than its file.

use super::super::error::{FormatError, from_base64, text};
use super::kind::kind_of;
use super::ndi_em::EmRom;
use super::ndi_image::OnMismatch;
use super::ndi_optical::OpticalRom;
use super::ndi_rom::NdiRom;
use data_encoding::BASE64;
use quick_xml::Reader;
use quick_xml::events::Event;
use std::ops::Range;
use trackwright_design::definition::DefinitionKind;

const KEY: &[u8] = b"ROMData";

/// Letters of base64 in a line of a new file, as Apple's own tools have it.
const LINE: usize = 68;

const BEFORE: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>
<!DOCTYPE plist PUBLIC \"-//Apple//DTD PLIST 1.0//EN\" \"http://www.apple.com/DTDs/PropertyList-1.0.dtd\">
<plist version=\"1.0\">
<dict>
\t<key>ROMData</key>
\t<data>";
const AFTER: &str = "</data>\n</dict>\n</plist>\n";

/// A property list, and the image in it.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolPlist {
    text: String,
    /// Where in the text the base64 is.
    data: Range<usize>,
    rom: NdiRom,
}

impl ToolPlist {
    /// Reads a property list with an image.
    ///
    /// # Errors
    /// XML that is none or cut short, no image or two, base64 that is none, and all that the image
    /// can have wrong.
    pub fn parse(bytes: &[u8], on_mismatch: OnMismatch) -> Result<Self, FormatError> {
        let list = text(bytes)?;
        let mark = bytes.len() - list.len();
        let data = find_data(list)?;
        let data = data.start + mark..data.end + mark;
        let image = decode(&bytes[data.clone()])?;
        let rom = match kind_of(&image, "") {
            Some(DefinitionKind::NdiEm) => NdiRom::Em(EmRom::parse(&image, on_mismatch)?),
            _ => NdiRom::Optical(OpticalRom::parse(&image, on_mismatch)?),
        };
        Ok(Self {
            // It was text, mark and all.
            text: String::from_utf8_lossy(bytes).into_owned(),
            data,
            rom,
        })
    }

    /// The whole file.
    pub fn write(&self) -> &str {
        &self.text
    }

    pub fn rom(&self) -> &NdiRom {
        &self.rom
    }

    /// What the list has beside the image: its other keys.
    pub(super) fn other_keys(&self) -> Vec<String> {
        let keys = self.text.split("<key>").skip(1);
        let names = keys.filter_map(|rest| Some(rest.split_once("</key>")?.0.trim()));
        let others = names.filter(|name| name.as_bytes() != KEY);
        others.map(|name| format!("key {name}")).collect()
    }

    /// A new property list with an image.
    pub(super) fn of(rom: NdiRom) -> Self {
        let data = encode(&rom);
        Self {
            data: BEFORE.len()..BEFORE.len() + data.len(),
            text: [BEFORE, &data, AFTER].concat(),
            rom,
        }
    }

    /// The same property list with another image.
    pub(super) fn with_rom(&self, rom: NdiRom) -> Self {
        if rom == self.rom {
            return self.clone();
        }
        let data = encode(&rom);
        let mut text = self.text.clone();
        text.replace_range(self.data.clone(), &data);
        Self { text, data: self.data.start..self.data.start + data.len(), rom }
    }
}

/// The base64 of an image, lines within tags that are indented by one.
fn encode(rom: &NdiRom) -> String {
    let letters = BASE64.encode(&rom.write());
    let mut out = String::with_capacity(letters.len() + letters.len() / LINE * 2 + 8);
    for (i, letter) in letters.chars().enumerate() {
        if i.is_multiple_of(LINE) {
            out.push_str("\n\t");
        }
        out.push(letter);
    }
    out.push_str("\n\t");
    out
}

fn decode(data: &[u8]) -> Result<Vec<u8>, FormatError> {
    let letters: Vec<u8> = data.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect();
    from_base64("ROMData", &letters)
}

/// Where the datum under the key is.
fn find_data(list: &str) -> Result<Range<usize>, FormatError> {
    let wrong = |at: u64, problem: String| {
        let at = usize::try_from(at).unwrap_or(usize::MAX).min(list.len());
        syntax(list, at, problem)
    };
    let mut reader = Reader::from_str(list);
    let mut depth = 0_usize;
    let mut found: Option<Range<usize>> = None;
    // Whether the key that was read last is the one.
    let mut is_next = false;
    loop {
        let at = reader.buffer_position();
        let event = reader
            .read_event()
            .map_err(|error| wrong(reader.error_position(), format!("found no XML ({error})")))?;
        match event {
            Event::Start(tag) if depth == 0 && tag.name().as_ref() != b"plist" => {
                let name = String::from_utf8_lossy(tag.name().as_ref()).into_owned();
                return Err(wrong(at, format!("found <{name}>, expected <plist>")));
            }
            Event::Start(tag) => {
                depth += 1;
                let inside = reader.buffer_position();
                match tag.name().as_ref() {
                    b"key" => {
                        let key = content(list, &mut reader, inside).map_err(|e| wrong(at, e))?;
                        is_next = list.as_bytes()[key].trim_ascii() == KEY;
                        depth -= 1;
                    }
                    b"data" if is_next => {
                        if found.is_some() {
                            let twice = "found ROMData twice, expected it once";
                            return Err(wrong(at, twice.to_owned()));
                        }
                        found = Some(content(list, &mut reader, inside).map_err(|e| wrong(at, e))?);
                        is_next = false;
                        depth -= 1;
                    }
                    _ => is_next = false,
                }
            }
            Event::End(_) => depth = depth.saturating_sub(1),
            Event::Eof if depth > 0 => {
                let cut = "found the end of the file, expected more: it is cut short";
                return Err(wrong(at, cut.to_owned()));
            }
            Event::Eof => break,
            _ => {}
        }
    }
    found.ok_or_else(|| FormatError::field("ROMData", "missing", "an NDI image in base64"))
}

/// The text up to the end of the element that has just begun, which has nothing else in it.
fn content(list: &str, reader: &mut Reader<&[u8]>, inside: u64) -> Result<Range<usize>, String> {
    loop {
        let at = reader.buffer_position();
        match reader.read_event().map_err(|error| format!("found no XML ({error})"))? {
            Event::Text(_) => {}
            Event::End(_) => {
                let place = |at: u64| usize::try_from(at).unwrap_or(usize::MAX).min(list.len());
                return Ok(place(inside)..place(at));
            }
            _ => return Err("found more than text in it, expected its end tag".to_owned()),
        }
    }
}

fn syntax(list: &str, at: usize, problem: String) -> FormatError {
    let before = list.as_bytes().get(..at).unwrap_or_default();
    let line_start = before.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
    FormatError::Syntax {
        line: 1 + before.iter().filter(|b| **b == b'\n').count(),
        column: 1 + before.len() - line_start,
        problem,
    }
}
