//! Sensors that a layout has in a small part of where they may be.

use serde::Serialize;

/// The sensors of a body that are close together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Crowding {
    /// `tool` or `crf`.
    pub body: &'static str,
    /// The largest distance between two of them.
    pub span_mm: f64,
    /// The nearest and the farthest from the tool's tip; `None` of a CRF.
    pub from_tip_mm: Option<[f64; 2]>,
    /// The largest distance between two places that are allowed, or taken by sensors that stay.
    pub allowed_mm: f64,
}

impl Crowding {
    /// For a person.
    pub fn words(&self) -> String {
        let Self { body, span_mm, from_tip_mm, allowed_mm } = self;
        let body = match *body {
            "crf" => "CRF",
            body => body,
        };
        let place = from_tip_mm.map_or_else(String::new, |[nearest, farthest]| {
            format!(", {nearest:.1} to {farthest:.1} mm from the tip")
        });
        format!(
            "the sensors of the {body} are within {span_mm:.1} mm of each other{place}; places up to {allowed_mm:.1} mm \
             apart are allowed"
        )
    }
}
