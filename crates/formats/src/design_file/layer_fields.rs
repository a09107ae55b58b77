//! The names under which a design's file turns layers on, which no layer may have.
//!
//! A layer is a plugin, so that a file may name one that this program was built without: such a name
//! is kept and reported. One that is like that of a known layer is mistyped, and an error.

use crate::error::{FormatError, text};
use crate::nearest::nearest;
use crate::ron_text::unknown_field;
use crate::ron_tokens::place;
use crate::ron_tree::Node;
use trackwright_design::view::Layer;

/// More names than anybody mistypes; a file may hold any number.
const MOST: usize = 8;

/// What a file names that no layer is called, by the view in which it does.
pub(super) struct UnknownLayers {
    pub of_view: Vec<String>,
    /// One list a slide, as far as slides have views.
    pub of_slides: Vec<Vec<String>>,
}

impl UnknownLayers {
    /// Of what is a design.
    ///
    /// # Errors
    /// The first name that is like a known one.
    pub(super) fn of(bytes: &[u8]) -> Result<Self, FormatError> {
        let text = text(bytes)?;
        let design = Node::of(text);
        let slides = match design.field("slides").map(Node::inner) {
            Some(Node::Items(slides)) => slides.as_slice(),
            Some(slide) => std::slice::from_ref(slide),
            None => &[],
        };
        Ok(Self {
            of_view: unknown_names(text, design.field("view"))?,
            of_slides: slides
                .iter()
                .map(|slide| unknown_names(text, slide.field("view")))
                .collect::<Result<_, _>>()?,
        })
    }
}

fn unknown_names(text: &str, view: Option<&Node>) -> Result<Vec<String>, FormatError> {
    let known: Vec<&str> = Layer::ALL.iter().map(|layer| layer.field).collect();
    let mut unknown = Vec::new();
    for layer in view.and_then(|view| view.field("layers")).map_or(&[][..], Node::fields) {
        let name = layer.name.as_str();
        if known.contains(&name) {
            continue;
        }
        if !nearest(name, &known).is_empty() {
            let (line, column) = place(text, layer.at);
            return Err(FormatError::Syntax { line, column, problem: unknown_field(name, &known) });
        }
        // A layer that is off is not missed.
        let is_off = matches!(&layer.value, Node::Word(word) if word == "false");
        if !is_off && unknown.len() < MOST {
            unknown.push(name.to_owned());
        }
    }
    Ok(unknown)
}
