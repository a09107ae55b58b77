//! The names under which a design's file turns layers on, which no layer may have.
//!
//! A layer is a plugin, so that a file may name one that this program was built without: such a name
//! is kept and reported. One that is like that of a known layer is mistyped, and an error.

use crate::error::{FormatError, text};
use crate::nearest::nearest;
use crate::ron_text::{from_text, unknown_field};
use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use std::fmt;
use trackwright_design::view::Layers;

/// More names than anybody mistypes; a file may hold any number.
const MOST: usize = 8;

/// What a file names that no layer is called, by the view in which it does.
#[derive(Debug, Default, PartialEq, Deserialize)]
#[serde(rename = "Design", default)]
pub(super) struct UnknownLayers {
    view: Option<ViewFields>,
    slides: Option<Vec<SlideFields>>,
}

#[derive(Debug, Default, PartialEq, Deserialize)]
#[serde(rename = "Slide", default)]
struct SlideFields {
    view: ViewFields,
}

#[derive(Debug, Default, PartialEq, Deserialize)]
#[serde(rename = "View", default)]
struct ViewFields {
    layers: Unknown,
}

#[derive(Debug, Default, PartialEq)]
struct Unknown(Vec<String>);

impl UnknownLayers {
    /// Of what is a design.
    ///
    /// # Errors
    /// The first name that is like a known one.
    pub(super) fn of(bytes: &[u8]) -> Result<Self, FormatError> {
        from_text(text(bytes)?)
    }

    /// The design's own view's, and each slide's.
    pub(super) fn into_names(self) -> (Vec<String>, impl Iterator<Item = Vec<String>>) {
        let slides = self.slides.unwrap_or_default().into_iter();
        let view = self.view.unwrap_or_default();
        (view.layers.0, slides.map(|slide| slide.view.layers.0))
    }
}

impl<'de> Deserialize<'de> for Unknown {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_struct("Layers", &[], FieldNames)
    }
}

struct FieldNames;

impl<'de> Visitor<'de> for FieldNames {
    type Value = Unknown;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("layers")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Unknown, A::Error> {
        let known = Layers::fields();
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        let mut unknown = Vec::new();
        while let Some(Field(name)) = map.next_key()? {
            let is_known = known.contains(&name.as_str());
            if !is_known && !nearest(&name, &known).is_empty() {
                return Err(A::Error::custom(unknown_field(&name, &known)));
            }
            // A layer that is off is not missed.
            let is_off = map.next_value::<ron::Value>()? == ron::Value::Bool(false);
            if !is_off && unknown.len() < MOST && !is_known {
                unknown.push(name);
            }
        }
        Ok(Unknown(unknown))
    }
}

/// A name that stands without quotes.
struct Field(String);

impl<'de> Deserialize<'de> for Field {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Name;
        impl Visitor<'_> for Name {
            type Value = Field;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a name")
            }

            fn visit_str<E>(self, name: &str) -> Result<Field, E> {
                Ok(Field(name.to_owned()))
            }
        }
        deserializer.deserialize_identifier(Name)
    }
}
