//! The names under which a design's file turns layers on, which no layer may have.

use crate::design::view::Layers;
use crate::formats::error::text;
use ron::extensions::Extensions;
use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use std::fmt;

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
    pub(super) fn of(bytes: &[u8]) -> Self {
        let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
        let text = text(bytes).unwrap_or_default();
        options.from_str(text).unwrap_or_default()
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
        let mut unknown = Vec::new();
        while let Some(Field(name)) = map.next_key()? {
            // A layer that is off is not missed.
            let is_off = map.next_value::<ron::Value>()? == ron::Value::Bool(false);
            if !is_off && unknown.len() < MOST && !Layers::is_field(&name) {
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
