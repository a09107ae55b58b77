//! Parts of the page that are there only where somebody gives them: slides, and tables made
//! elsewhere.

use super::table_of;
use data_encoding::BASE64;
use maud::{Markup, html};

/// What every PNG file begins with.
const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// A saved view as a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slide {
    title: String,
    caption: String,
    png: Vec<u8>,
}

/// Bytes that are no picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("slide {title:?}: found {length} bytes that are no PNG, expected a PNG")]
pub struct SlideError {
    pub title: String,
    pub length: usize,
}

impl Slide {
    /// A slide of a PNG's bytes.
    ///
    /// # Errors
    /// [`SlideError`] where they are not that.
    pub fn new(title: String, caption: String, png: Vec<u8>) -> Result<Self, SlideError> {
        match png.starts_with(PNG_SIGNATURE) {
            true => Ok(Self { title, caption, png }),
            false => Err(SlideError { title, length: png.len() }),
        }
    }
}

/// What the scene that turns shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneLegend {
    /// How many times larger than life errors are drawn.
    pub magnification: f64,
    /// sRGB colours, and what has them.
    pub keys: Vec<([u8; 3], String)>,
    /// What the colours of maps mean, each a line.
    pub maps: Vec<String>,
}

/// A legend as a list of swatches.
pub fn legend(legend: &SceneLegend) -> Markup {
    html! {
        p class="legend" {
            strong { "Errors drawn " (legend.magnification) "× larger" }
            @for ([red, green, blue], text) in &legend.keys {
                span class="key" {
                    svg viewBox="0 0 10 10" aria-hidden="true" {
                        rect width="10" height="10" rx="2" fill=(format!("#{red:02x}{green:02x}{blue:02x}")) {}
                    }
                    (text)
                }
            }
        }
        @for map in &legend.maps { p class="note" { (map) } }
    }
}

/// A section that is a table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TableSection {
    pub title: String,
    /// Paragraphs before the table.
    pub lead: Vec<String>,
    pub head: Vec<String>,
    /// A cell a column.
    pub rows: Vec<Vec<String>>,
    /// Paragraphs after it.
    pub notes: Vec<String>,
}

/// Saved views, as pictures.
pub fn slides(slides: &[Slide]) -> Markup {
    html! {
        @if !slides.is_empty() {
            section id="slides" {
                h2 { "Views" }
                @for slide in slides {
                    figure class="slide" {
                        figcaption {
                            strong { (slide.title) }
                            @if !slide.caption.is_empty() { span { (slide.caption) } }
                        }
                        img alt=(slide.title) src=(format!("data:image/png;base64,{}", BASE64.encode(&slide.png)));
                    }
                }
            }
        }
    }
}

/// A table made elsewhere, where there is one.
pub fn table(table: Option<&TableSection>) -> Markup {
    html! {
        @if let Some(table) = table {
            section id="manufacturing" {
                h2 { (table.title) }
                @for paragraph in &table.lead { p { (paragraph) } }
                (table_of(&table.head, &table.rows, "data"))
                @for paragraph in &table.notes { p class="note" { (paragraph) } }
            }
        }
    }
}
