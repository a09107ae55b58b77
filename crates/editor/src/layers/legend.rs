//! What layers write into the legend: colour bars, swatches and strokes, each with its words.

use crate::palette::Rgb;
use bevy::prelude::Resource;
use std::collections::BTreeMap;
use trackwright_design::view::ColorMap;

/// A colour bar.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorBar {
    pub label: String,
    /// What is assumed, in a line of its own.
    pub note: Option<String>,
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
    /// A line, or something solid.
    Line(Rgb),
    /// A ball.
    Ball(Rgb),
    /// Three axes.
    Axes([Rgb; 3]),
    /// Nothing: the text gives the reason.
    Nothing,
}

impl Swatch {
    /// The colours that are its own, maps and hatchings apart.
    pub fn colors(self) -> Vec<Rgb> {
        match self {
            Self::NoValue | Self::Unsupported(_) | Self::Nothing => Vec::new(),
            Self::Surface(color) | Self::Line(color) | Self::Ball(color) => vec![color],
            Self::Axes(colors) => colors.to_vec(),
        }
    }
}

impl LegendKey {
    pub fn new(swatch: Swatch, text: impl Into<String>) -> Self {
        Self { swatch, text: text.into(), audience: Audience::All }
    }

    /// Not on slides, where names stand beside the things.
    #[must_use]
    pub fn for_designers(self) -> Self {
        Self { audience: Audience::Designers, ..self }
    }

    /// On slides only, in place of a key [for designers](Self::for_designers).
    #[must_use]
    pub fn for_slides(self) -> Self {
        Self { audience: Audience::Slides, ..self }
    }

    /// Whether it is shown, on a slide or elsewhere.
    pub fn is_shown(&self, is_slide: bool) -> bool {
        match self.audience {
            Audience::All => true,
            Audience::Designers => !is_slide,
            Audience::Slides => is_slide,
        }
    }
}

impl ColorBar {
    /// Whether the same colours mean the same values.
    pub(super) fn has_scale_of(&self, other: &Self) -> bool {
        (self.unit, self.map, self.min, self.max) == (other.unit, other.map, other.min, other.max)
    }
}

/// One bar a scale: those of the same unit, map and range are one, with both names.
pub fn merged(bars: impl IntoIterator<Item = ColorBar>) -> Vec<ColorBar> {
    let mut out: Vec<ColorBar> = Vec::new();
    for bar in bars {
        match out.iter_mut().find(|other| other.has_scale_of(&bar)) {
            None => out.push(bar),
            Some(first) => {
                // `position error, arrows × 50` beside `position error` is about the arrows.
                let common = format!("{}, ", first.label);
                let own = bar.label.strip_prefix(&common).unwrap_or(&bar.label);
                first.label = format!("{}; {own}", first.label);
                first.largest = first.largest.max(bar.largest);
                first.limit = first.limit.or(bar.limit);
                first.note = first.note.take().or(bar.note);
            }
        }
    }
    out
}

/// Whom a key is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Audience {
    All,
    /// People who design, not those who see slides.
    Designers,
    /// Those who see slides, where nothing can be dragged.
    Slides,
}

/// A line of the list of magnified things.
#[derive(Clone, Debug, PartialEq)]
pub struct StrokeKey {
    pub words: String,
    /// For people who do not design the tool.
    pub plain_words: String,
    pub color: Rgb,
}

impl StrokeKey {
    pub fn new(color: Rgb, words: &str, plain_words: &str) -> Self {
        Self { words: words.to_owned(), plain_words: plain_words.to_owned(), color }
    }
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

    /// With where each stands, as the others.
    pub fn bars(&self) -> impl Iterator<Item = (u32, &ColorBar)> {
        self.0.iter().filter_map(|(order, legend)| Some((*order, legend.bar.as_ref()?)))
    }

    pub fn keys(&self) -> impl Iterator<Item = (u32, &LegendKey)> {
        self.0.iter().flat_map(|(order, legend)| legend.keys.iter().map(|key| (*order, key)))
    }

    pub fn strokes(&self) -> impl Iterator<Item = (u32, &StrokeKey)> {
        self.0.iter().filter_map(|(order, legend)| Some((*order, legend.stroke.as_ref()?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bar(label: &str, max: f64) -> ColorBar {
        ColorBar {
            label: label.to_owned(),
            note: None,
            unit: "mm",
            map: ColorMap::Viridis,
            min: 0.0,
            max,
            largest: max + 1.0,
            decimals: 2,
            limit: None,
        }
    }

    #[test]
    fn bars_of_one_scale_are_one_bar() {
        let own = [bar("position error", 2.0), bar("position error, arrows × 50", 2.0)];
        let one = merged(own.clone());
        assert_eq!(one.len(), 1);
        assert_eq!(one[0].label, "position error; arrows × 50");
        let other = ColorBar { map: ColorMap::Inferno, ..bar("gradient", 2.0) };
        assert_eq!(merged(own.into_iter().chain([other, bar("tip error", 3.0)])).len(), 3);
    }
}
