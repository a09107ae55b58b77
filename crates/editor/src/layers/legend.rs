//! What layers write into the legend: colour bars, swatches and strokes, each with its words.

use crate::palette::Rgb;
use bevy::prelude::Resource;
use std::collections::BTreeMap;
use trackwright_design::view::ColorMap;

/// A colour bar.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorBar {
    pub label: String,
    pub unit: &'static str,
    pub map: ColorMap,
    /// Where the colours begin and end.
    pub min: f64,
    pub max: f64,
    /// The largest value there is, which may be beyond the end.
    pub largest: f64,
    /// Digits after the point of single values.
    pub decimals: usize,
    /// The requirement's limit for such a value.
    pub limit: Option<f64>,
}

/// A swatch and what it means.
#[derive(Clone, Debug, PartialEq)]
pub struct LegendKey {
    pub swatch: Swatch,
    pub text: String,
    pub audience: Audience,
}

/// What stands before the words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Swatch {
    /// Grey, hatched.
    NoValue,
    /// A map with lines over it.
    Unsupported(ColorMap),
    /// A translucent surface.
    Surface(Rgb),
    /// Nothing: the text gives the reason.
    Nothing,
}

/// Whom a key is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Audience {
    All,
    /// People who design, not those who see slides.
    Designers,
    /// Those who see slides.
    Slides,
}

/// A line of the list of magnified things.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokeKey {
    pub words: &'static str,
    /// For people who do not design the tool.
    pub plain_words: &'static str,
    pub color: Rgb,
}

/// What one layer writes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Legend {
    pub bar: Option<ColorBar>,
    pub keys: Vec<LegendKey>,
    pub stroke: Option<StrokeKey>,
}

/// What is in the legend now, by its order: that of its layer, or of whatever else is explained.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Legends(BTreeMap<u32, Legend>);

impl Legends {
    pub fn set(&mut self, order: u32, legend: Legend) {
        self.0.insert(order, legend);
    }

    pub fn set_bar(&mut self, order: u32, bar: Option<ColorBar>) {
        self.set(order, Legend { bar, ..Legend::default() });
    }

    /// One line about a surface, or about why there is none.
    pub fn set_surface(&mut self, order: u32, color: Rgb, text: Option<Result<String, String>>) {
        let key = text.map(|text| match text {
            Ok(text) => LegendKey { swatch: Swatch::Surface(color), text, audience: Audience::All },
            Err(text) => {
                // On slides it is for whoever makes them: the panel shows it.
                LegendKey { swatch: Swatch::Nothing, text, audience: Audience::Designers }
            }
        });
        self.set(order, Legend { keys: key.into_iter().collect(), ..Legend::default() });
    }

    pub fn bar(&self, order: u32) -> Option<&ColorBar> {
        self.0.get(&order)?.bar.as_ref()
    }

    /// The words of the first key.
    pub fn words(&self, order: u32) -> Option<&str> {
        Some(&self.0.get(&order)?.keys.first()?.text)
    }

    pub fn bars(&self) -> impl Iterator<Item = &ColorBar> {
        self.0.values().filter_map(|legend| legend.bar.as_ref())
    }

    pub fn keys(&self, is_slide: bool) -> impl Iterator<Item = &LegendKey> {
        let is_shown = move |key: &&LegendKey| match key.audience {
            Audience::All => true,
            Audience::Designers => !is_slide,
            Audience::Slides => is_slide,
        };
        self.0.values().flat_map(|legend| &legend.keys).filter(is_shown)
    }

    pub fn strokes(&self) -> impl Iterator<Item = (u32, StrokeKey)> {
        self.0.iter().filter_map(|(order, legend)| Some((*order, legend.stroke?)))
    }
}
