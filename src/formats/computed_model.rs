//! The part of an environment that holds a model which is no polynomial.

use super::error::FormatError;
use super::generator::{self, GeneratorEntry};
use super::number::shortest;
use super::ron_text;
use crate::field::DistortionModel;
use crate::field::computed::FieldSource;
use crate::field::gaussian::{ErrorValues, GaussianField, Kriging, Trend};
use crate::field::harmonic::HarmonicModel;
use crate::field::samples::MapKind;
use serde::Deserialize;
use std::fmt::Write;
use std::sync::Arc;

/// Weights of the rows of the environment's process, in their order.
#[derive(Deserialize)]
#[serde(rename = "Kriging")]
pub(super) struct KrigingEntry {
    weights: Vec<ErrorValues>,
}

#[derive(Deserialize)]
#[serde(rename = "Harmonic")]
pub(super) struct HarmonicEntry {
    center_mm: [f64; 3],
    scale_mm: f64,
    degree: usize,
    generator: GeneratorEntry,
    /// One list a coil.
    coefficients: Vec<Vec<f64>>,
}

/// The model of an environment: polynomials, or what stands in their place.
pub(super) fn check(
    model: DistortionModel,
    kriging: Option<KrigingEntry>,
    harmonic: Option<HarmonicEntry>,
    process: Option<&Arc<GaussianField>>,
) -> Result<DistortionModel, FormatError> {
    let source = match (kriging, harmonic) {
        (None, None) => return Ok(model),
        (Some(_), Some(_)) => {
            let found = "a kriging and a harmonic model";
            return Err(FormatError::field("harmonic", found, "one of them"));
        }
        (Some(entry), None) => FieldSource::Kriging(entry.check(process)?),
        (None, Some(entry)) => FieldSource::Harmonic(Arc::new(entry.check(&model)?)),
    };
    if model.order() != 0 {
        let found = format!("order {} beside another model", model.order());
        return Err(FormatError::field("model.order", found, "0"));
    }
    Ok(DistortionModel::of_source(
        source,
        model.map(),
        *model.bounds(),
    ))
}

impl KrigingEntry {
    fn check(self, process: Option<&Arc<GaussianField>>) -> Result<Kriging, FormatError> {
        let process = process
            .filter(|process| process.trend == Trend::None)
            .ok_or_else(|| {
                FormatError::field("kriging", "no process without a trend", "the rows it is of")
            })?;
        if let Some(index) = self
            .weights
            .iter()
            .position(|w| w.iter().any(|v| !v.is_finite()))
        {
            let name = format!("kriging.weights[{index}]");
            return Err(FormatError::field(name, "not finite", "finite numbers"));
        }
        let found = self.weights.len();
        Kriging::of_weights(process.clone(), self.weights)
            .ok_or_else(|| FormatError::field("kriging.weights", found, "as many as process.rows"))
    }
}

impl HarmonicEntry {
    fn check(self, model: &DistortionModel) -> Result<HarmonicModel, FormatError> {
        if model.map() != MapKind::Distortion {
            let expected = "Distortion, of a harmonic model";
            return Err(FormatError::field("model.map", "Correction", expected));
        }
        HarmonicModel::new(
            self.generator.check()?,
            self.center_mm.into(),
            self.scale_mm,
            self.degree,
            self.coefficients.concat(),
        )
        .map_err(|cause| FormatError::field("harmonic", cause, "a model"))
    }
}

// Writing to a string cannot fail.

/// Writes what stands in the place of polynomials, if anything does.
pub(super) fn push(out: &mut String, model: &DistortionModel) {
    match model.computed().map(|computed| computed.source()) {
        Some(FieldSource::Kriging(kriging)) => {
            out.push_str(
                "    kriging: (\n        // One a row of the process.\n        weights: [\n",
            );
            for weights in kriging.weights() {
                let _ = writeln!(out, "            {},", ron_text::tuple(weights));
            }
            out.push_str("        ],\n    ),\n");
        }
        Some(FieldSource::Harmonic(model)) => push_harmonic(out, model),
        Some(FieldSource::Of(_)) | None => {}
    }
}

fn push_harmonic(out: &mut String, model: &HarmonicModel) {
    let _ = writeln!(
        out,
        "    harmonic: (\n        center_mm: {},\n        scale_mm: {},\n        degree: {},\n        generator: (",
        ron_text::tuple(model.center_mm().coords.as_slice()),
        shortest(model.scale_mm()),
        model.degree(),
    );
    generator::push_parts(out, 3, model.generator());
    out.push_str("        ),\n        // One list a coil.\n        coefficients: [\n");
    let coils = model.generator().coils.len();
    let each = model.coefficients().len() / coils;
    for coefficients in model.coefficients().chunks_exact(each) {
        let numbers: Vec<_> = coefficients.iter().map(|v| shortest(*v)).collect();
        let _ = writeln!(out, "            [{}],", numbers.join(", "));
    }
    out.push_str("        ],\n    ),\n");
}
