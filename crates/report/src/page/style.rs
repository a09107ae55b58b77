//! The page's style: its rules, and the colours that they name.

use crate::palette;

const RULES: &str = include_str!("style.css");

/// Colours by role, then the rules.
pub fn css() -> String {
    let colours: String = [
        ("paper", palette::PAPER),
        ("ink", palette::INK),
        ("quiet", palette::INK_QUIET),
        ("line", palette::LINE),
        ("hair", palette::GRID),
        ("wash", palette::GRID_MINOR),
        ("accent", palette::ACCENT),
        ("met", palette::MET),
        ("missed", palette::MISSED),
        ("metal", palette::METAL),
        ("reference", palette::REFERENCE),
        ("coil", palette::COIL),
    ]
    .into_iter()
    .map(|(name, color)| format!("--{name}:{color};").to_lowercase())
    .collect();
    format!(":root{{{colours}}}\n{RULES}")
}
