//! A room's fit in words: the same for the command line and the editor.

use super::selection::ridge_text;
use trackwright_calibration::room_model::HarmonicReport;
use trackwright_field::Environment;
use trackwright_field::computed::ModelKind;
use trackwright_field::fit::{Fit, FitMethod};
use trackwright_field::harmonic::{DEFAULT_RIDGE, HarmonicFitSettings};
use trackwright_field::samples::MapKind;
use trackwright_field::validity::FitValidityError;
use trackwright_result::with_separators;

/// How orientations share the samples, in words.
pub fn method_name(method: FitMethod) -> &'static str {
    match method {
        FitMethod::PerDirection => "per-direction",
        FitMethod::Joint => "joint",
    }
}

/// Which pose the error is a function of, in words.
pub fn map_name(map: MapKind) -> &'static str {
    match map {
        MapKind::Distortion => "distortion",
        MapKind::Correction => "correction",
    }
}

/// How far a room's model is off where it was not fitted, for a person: its held-out error.
pub const MODEL_ERROR: &str = "Model error on unseen data";

/// `Model error on unseen data: 1.34 mm RMS`.
pub fn model_error(held_out_rms_mm: Option<f64>) -> String {
    match held_out_rms_mm {
        Some(rms_mm) => format!("{MODEL_ERROR}: {rms_mm:.2}\u{2009}mm RMS"),
        None => format!("{MODEL_ERROR}: not known"),
    }
}

/// Whether a room was never measured and metal in it is simulated.
pub fn is_simulated(environment: &Environment) -> bool {
    let kind = environment.model.kind();
    environment.provenance.is_none() && matches!(kind, ModelKind::Simulated | ModelKind::Harmonic)
}

/// What a room is of which no measurements are known: `ideal` or `simulated`.
pub fn unmeasured(environment: &Environment) -> &'static str {
    if is_simulated(environment) { "simulated" } else { "ideal" }
}

/// Where what is predicted in a room comes from, to stand under it.
pub fn caption(environment: &Environment) -> String {
    let from = match &environment.provenance {
        None if is_simulated(environment) => "simulated, never measured".to_owned(),
        None => "an ideal room".to_owned(),
        Some(from) if environment.model.kind() == ModelKind::Simulated => {
            format!("{} samples, metal added", with_separators(from.samples))
        }
        Some(from) => {
            let samples = with_separators(from.samples);
            let held_out = from.holdout.as_ref().map(|holdout| holdout.after.position_rms_mm);
            format!("{samples} samples. {}", model_error(held_out))
        }
    };
    let name = &environment.name;
    format!("Predicted in room {name}, {from}; not for clinical use")
}

/// The note of a room that keeps no model validity.
pub fn support_note(why: &FitValidityError) -> String {
    format!("{why}; the environment is written without it")
}

/// `harmonic, generator planar-nine, degree 6, ridge 1e-2`; the usual ridge is left out.
pub fn harmonic_model_text(generator: &str, settings: &HarmonicFitSettings) -> String {
    let HarmonicFitSettings { degree, ridge, .. } = settings;
    let text = format!("harmonic, generator {generator}, degree {degree}");
    match ridge.to_bits() == DEFAULT_RIDGE.to_bits() {
        true => text,
        false => format!("{text}, ridge {}", ridge_text(*ridge)),
    }
}

/// `harmonic, generator planar-nine, degree 6, 12 samples down-weighted`.
pub fn harmonic_text(harmonic: &HarmonicReport) -> String {
    let mut text = harmonic_model_text(&harmonic.generator.name, &harmonic.settings);
    if harmonic.down_weighted > 0 {
        let count = with_separators(harmonic.down_weighted);
        text.push_str(&format!(", {count} samples down-weighted"));
    }
    text
}

/// What is not as it should be about a fit.
pub fn fit_warnings(fitted: &Fit) -> Vec<String> {
    let mut warnings = Vec::new();
    let few: Vec<_> = fitted.systems.iter().filter(|s| s.is_underdetermined()).collect();
    if let Some(least) = few.iter().min_by_key(|s| s.samples) {
        warnings.push(format!(
            "{} of {} orientations have fewer samples than the {} coefficients, the least {}; \
             the solution of least norm was taken",
            few.len(),
            fitted.systems.len(),
            least.unknowns,
            with_separators(least.samples),
        ));
    }
    let deficient =
        fitted.systems.iter().filter(|s| !s.is_underdetermined() && s.rank < s.unknowns).count();
    if deficient > 0 {
        warnings.push(format!(
            "{deficient} of {} orientations do not determine all their coefficients; the solution \
             of least norm was taken",
            fitted.systems.len()
        ));
    }
    if fitted.ambiguous > 0 {
        warnings.push(format!(
            "{} samples have opposite axes, so that their orientation error is ambiguous",
            with_separators(fitted.ambiguous)
        ));
    }
    warnings
}
