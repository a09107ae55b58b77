//! The part of an environment that holds a model which is no polynomial.

use super::error::FormatError;
use super::generator::{self, GeneratorEntry};
use super::ron_text::{self, RonWriter};
use serde::Deserialize;
use std::sync::Arc;
use trackwright_field::DistortionModel;
use trackwright_field::computed::FieldSource;
use trackwright_field::gaussian::{ErrorValues, GaussianField, Kriging, Trend};
use trackwright_field::harmonic::HarmonicModel;
use trackwright_field::samples::MapKind;
use trackwright_geometry::number::shortest;

/// Comments that are written with a model.
pub(super) const WEIGHTS_COMMENT: &str = "// One a row of the process.";
pub(super) const COILS_COMMENT: &str = "// One list a coil.";

/// Weights of the rows of the environment's process, in their order.
#[derive(Deserialize)]
#[serde(rename = "Kriging", deny_unknown_fields)]
pub(super) struct KrigingEntry {
    weights: Vec<ErrorValues>,
}

#[derive(Deserialize)]
#[serde(rename = "Harmonic", deny_unknown_fields)]
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
        (Some(entry), None) => FieldSource::Kriging(Arc::new(entry.check(process)?)),
        (None, Some(entry)) => FieldSource::Harmonic(Arc::new(entry.check(&model)?)),
    };
    if model.order() != 0 {
        let found = format!("order {} beside another model", model.order());
        return Err(FormatError::field("model.order", found, "0"));
    }
    Ok(DistortionModel::of_source(source, model.map(), *model.bounds()))
}

impl KrigingEntry {
    fn check(self, process: Option<&Arc<GaussianField>>) -> Result<Kriging, FormatError> {
        let process = process.filter(|process| process.trend == Trend::None).ok_or_else(|| {
            FormatError::field("kriging", "no process without a trend", "the rows it is of")
        })?;
        if let Some(index) = self.weights.iter().position(|w| w.iter().any(|v| !v.is_finite())) {
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
        self.model("harmonic")
    }

    /// `name` is the field that it stands in.
    pub(super) fn model(self, name: &str) -> Result<HarmonicModel, FormatError> {
        HarmonicModel::new(
            self.generator.check()?,
            self.center_mm.into(),
            self.scale_mm,
            self.degree,
            self.coefficients.concat(),
        )
        .map_err(|cause| FormatError::field(name, cause, "a model"))
    }
}

/// Writes what stands in the place of polynomials, if anything does.
pub(super) fn write(out: &mut RonWriter, model: &DistortionModel) {
    match model.computed().map(|computed| computed.source()) {
        Some(FieldSource::Kriging(kriging)) => out.fields("kriging", |out| {
            out.line(WEIGHTS_COMMENT);
            out.lines("weights", kriging.weights().iter().map(|weights| ron_text::tuple(weights)));
        }),
        Some(FieldSource::Harmonic(model)) => {
            out.fields("harmonic", |out| write_harmonic(out, model));
        }
        Some(FieldSource::Simulated(_) | FieldSource::Of(_)) | None => {}
    }
}

pub(super) fn write_harmonic(out: &mut RonWriter, model: &HarmonicModel) {
    out.field("center_mm", ron_text::tuple(model.center_mm().coords.as_slice()));
    out.field("scale_mm", shortest(model.scale_mm()));
    out.field("degree", model.degree());
    out.fields("generator", |out| generator::write_parts(out, model.generator()));
    out.line(COILS_COMMENT);
    let each = model.coefficients().len() / model.generator().coils.len();
    let of_coil = |coefficients: &[f64]| {
        let numbers: Vec<_> = coefficients.iter().map(|v| shortest(*v)).collect();
        format!("[{}]", numbers.join(", "))
    };
    out.lines("coefficients", model.coefficients().chunks_exact(each).map(of_coil));
}

#[cfg(test)]
pub(super) mod tests {
    use crate::environment::tests::{parse, write};
    use crate::test_cases::assert_refused;
    use nalgebra::{Point3, Vector3};
    use std::sync::Arc;
    use trackwright_field::computed::FieldSource;
    use trackwright_field::gaussian::{GaussianField, Kriging};
    use trackwright_field::generator::Generator;
    use trackwright_field::harmonic::HarmonicModel;
    use trackwright_field::random_models::{Seeded, room};
    use trackwright_field::samples::{MapKind, PoseError, Sample, SampleSet};
    use trackwright_field::{DistortionModel, Environment};
    use trackwright_task::Task;

    pub(crate) fn environments() -> [Environment; 2] {
        let mut seeded = Seeded::new(3);
        let samples = (0..12).map(|_| {
            let pose = seeded.pose(&room(), 0.0);
            Sample::new(
                pose.translation.vector.into(),
                pose.rotation * Vector3::z_axis(),
                PoseError {
                    position_mm: Vector3::from_fn(|_, _| seeded.normal()),
                    rotation_rad: Vector3::zeros(),
                },
            )
        });
        let samples = SampleSet { samples: samples.collect(), has_rotations: true, ambiguous: 0 };
        let process = GaussianField::fit(&samples, None, &Task::default()).unwrap();
        let process = Arc::new(process);
        let kriging = Kriging::new(process.clone(), &Task::default()).unwrap();
        let center_mm = Point3::new(0.0, 0.0, -300.0);
        let numbers = (0..9 * 3).map(|i| f64::from(i) / 7e12).collect();
        let harmonic = HarmonicModel::new(Generator::planar_nine(), center_mm, 433.0, 1, numbers);
        let environment = |source, process| Environment {
            process,
            ..Environment::of_model(
                "room",
                DistortionModel::of_source(source, MapKind::Distortion, room()),
            )
        };
        [
            environment(FieldSource::Kriging(Arc::new(kriging)), Some(process)),
            environment(FieldSource::Harmonic(Arc::new(harmonic.unwrap())), None),
        ]
    }

    #[test]
    fn computed_models_are_read_back_exactly() {
        for environment in environments() {
            let text = write(&environment);
            assert_eq!(parse(text.as_bytes()).unwrap(), environment, "{text}");
        }
    }

    #[test]
    fn impossible_models_are_refused_by_field() {
        let [kriging, harmonic] = environments().map(|e| write(&e));
        let refusal = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        let cases = r#"
            degree: 1, => degree: 2, | …27 coefficients, expected 72…
            degree: 1, => degree: 99, | …degree is 99, expected 1 to 10…
            scale_mm: 433 => scale_mm: 0 | …scale is 0 mm…
            map: Distortion => map: Correction | …model.map is Correction…
        "#;
        assert_refused(&harmonic, cases, refusal);
        let cases = r#"
            trend: None => trend: Model | …no process without a trend…
            weights: [ => weights: [(0, 0, 0, 0, 0, 0), | …kriging.weights is 13…
            weights: [ => weights: [(NaN, 0, 0, 0, 0, 0), | …kriging.weights[0]…
        "#;
        assert_refused(&kriging, cases, refusal);
    }
}
