//! How a person left the window, `preferences.ron`: no part of any design.

use super::error::FormatError;
use super::ron_text::{self, RonWriter, Version};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Widest and highest window that is accepted, logical pixels.
const MOST_PX: u32 = 32_768;

/// Smallest and largest interface.
pub const SCALES: [f64; 2] = [0.5, 3.0];

/// What is remembered from one session to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Preferences {
    /// Width and height, logical pixels; `None` leaves it to the program.
    pub window: Option<[u32; 2]>,
    pub is_maximised: bool,
    pub is_light: bool,
    /// Size of everything that is written, within [`SCALES`].
    pub scale: f64,
    pub panels: ShownPanels,
    /// Its name; what no workspace is called counts as none.
    pub workspace: String,
    /// Widths of panels as a person dragged them, logical pixels, by the panel's name.
    pub widths: BTreeMap<String, f64>,
    /// Whether a person folded the legend or unfolded it; `None` leaves it to the size of the view.
    pub is_legend_folded: Option<bool>,
}

/// The panels that are unfolded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShownPanels {
    pub left: bool,
    pub right: bool,
    pub history: bool,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            window: None,
            is_maximised: false,
            is_light: false,
            scale: 1.0,
            panels: ShownPanels { left: true, right: true, history: false },
            workspace: "Design".to_owned(),
            widths: BTreeMap::new(),
            is_legend_folded: None,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename = "Preferences", deny_unknown_fields)]
struct PreferencesEntry {
    #[serde(rename = "version")]
    _version: Version,
    #[serde(default)]
    window: Option<(u32, u32)>,
    is_maximised: bool,
    is_light: bool,
    scale: f64,
    panels: ShownPanels,
    workspace: String,
    #[serde(default)]
    widths: BTreeMap<String, f64>,
    #[serde(default)]
    is_legend_folded: Option<bool>,
}

/// Reads preferences.
pub fn parse(bytes: &[u8]) -> Result<Preferences, FormatError> {
    let entry: PreferencesEntry = ron_text::parse(bytes)?;
    let [least, most] = SCALES;
    if !(least..=most).contains(&entry.scale) {
        let expected = "a number from 0.5 to 3";
        return Err(FormatError::field("scale", entry.scale, expected));
    }
    if let Some((width, height)) = entry.window
        && !((1..=MOST_PX).contains(&width) && (1..=MOST_PX).contains(&height))
    {
        let found = format!("{width} × {height}");
        let expected = "sides from 1 to 32768 pixels";
        return Err(FormatError::field("window", found, expected));
    }
    if let Some(width) = entry.widths.values().find(|w| !(1.0..=f64::from(MOST_PX)).contains(*w)) {
        return Err(FormatError::field("widths", width, "widths from 1 to 32768 pixels"));
    }
    Ok(Preferences {
        window: entry.window.map(|(width, height)| [width, height]),
        is_maximised: entry.is_maximised,
        is_light: entry.is_light,
        scale: entry.scale,
        panels: entry.panels,
        workspace: entry.workspace,
        widths: entry.widths,
        is_legend_folded: entry.is_legend_folded,
    })
}

/// Writes preferences.
pub fn write(preferences: &Preferences) -> String {
    RonWriter::file(|out| {
        out.optional("window", preferences.window.map(|[width, height]| (width, height)));
        out.field("is_maximised", preferences.is_maximised);
        out.field("is_light", preferences.is_light);
        out.plain("scale", preferences.scale);
        let ShownPanels { left, right, history } = preferences.panels;
        out.field("panels", format_args!("(left: {left}, right: {right}, history: {history})"));
        out.string("workspace", &preferences.workspace);
        if !preferences.widths.is_empty() {
            let widths = preferences.widths.iter();
            let widths: Vec<String> =
                widths.map(|(name, px)| format!("{}: {px:?}", ron_text::string(name))).collect();
            out.field("widths", format_args!("{{{}}}", widths.join(", ")));
        }
        out.optional("is_legend_folded", preferences.is_legend_folded);
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_cases::assert_refused;

    #[test]
    fn what_is_written_reads_back() {
        let other = Preferences {
            window: Some([1280, 720]),
            is_maximised: true,
            is_light: true,
            scale: 1.25,
            panels: ShownPanels { left: false, right: true, history: true },
            workspace: "a \"name\"\n".to_owned(),
            widths: [("Design left", 312.0), ("a \"name\"", 200.5)]
                .map(|(name, width)| (name.to_owned(), width))
                .into(),
            is_legend_folded: Some(true),
        };
        for preferences in [Preferences::default(), other] {
            let text = write(&preferences);
            assert_eq!(parse(text.as_bytes()).unwrap(), preferences, "{text}");
        }
    }

    #[test]
    fn older_preferences_read_as_before() {
        let older = "(version: 1, is_maximised: false, is_light: false, scale: 1.0, \
                     panels: (left: true, right: true, history: false), workspace: \"Design\")";
        assert_eq!(parse(older.as_bytes()), Ok(Preferences::default()));
        // What has its default is not written: older versions read the file.
        assert!(!write(&Preferences::default()).contains("is_legend_folded"));
    }

    #[test]
    fn impossible_window_values_are_refused() {
        let preferences = Preferences { window: Some([1280, 720]), ..Preferences::default() };
        let cases = r#"
            scale: 1.0 => scale: NaN | scale is NaN, expected a number from 0.5 to 3
            scale: 1.0 => scale: 40.0 | scale is 40, expected a number from 0.5 to 3
            (1280, 720) => (0, 720) | window is 0 × 720, expected sides from 1 to 32768 pixels
            workspace: => widths: {"left": -7.0}, workspace:
                | widths is -7, expected widths from 1 to 32768 pixels
        "#;
        assert_refused(&write(&preferences), cases, |text| {
            parse(text.as_bytes()).unwrap_err().to_string()
        });
    }
}
