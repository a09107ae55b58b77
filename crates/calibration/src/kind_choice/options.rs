//! The kinds to try as a person names them.

use super::kinds::{NO_CORRECTION, SYMMETRIC, TriedKind};
use crate::room_model::GeneratorChoice;
use trackwright_field::generator::{BUILT_IN, Generator};
use trackwright_field::harmonic::Loss;
use trackwright_field::samples::{MapKind, SampleSet};

/// Degrees of harmonic models that are tried where none is named.
const TRIED_DEGREES: std::ops::RangeInclusive<usize> = 2..=8;

/// Which kinds of models to try, and of which generators and degrees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriedOptions<'a> {
    /// Of [`TriedKind::NAMES`]; all that the samples can be fitted with where there are none.
    pub names: Option<&'a [String]>,
    /// Of harmonic models; the built-in ones and a learned one where there are none.
    pub generators: Option<&'a [GeneratorChoice]>,
    /// Of harmonic models.
    pub degree: Option<usize>,
    pub loss: Loss,
}

/// Options that name nothing to try.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OptionsError {
    #[error("found {0:?}, expected {names}", names = TriedKind::NAMES.join(", "))]
    Name(String),
    #[error("found no harmonic models, to which generator, degree and loss belong")]
    NotHarmonic,
}

impl TriedOptions<'_> {
    /// The kinds, each once.
    ///
    /// # Errors
    /// A name that is none, options of harmonic models without them.
    pub fn kinds(&self, samples: &SampleSet, map: MapKind) -> Result<Vec<TriedKind>, OptionsError> {
        let names: Vec<&str> = match self.names {
            Some(names) => names.iter().map(String::as_str).collect(),
            None => possible(samples, map),
        };
        let mut kinds: Vec<TriedKind> = Vec::new();
        for name in names {
            for kind in self.named(name)? {
                if !kinds.contains(&kind) {
                    kinds.push(kind);
                }
            }
        }
        let is_of_harmonic = *self != Self { names: self.names, ..Self::default() };
        let has_harmonic = kinds.iter().any(|kind| matches!(kind, TriedKind::Harmonic { .. }));
        match is_of_harmonic && !has_harmonic {
            true => Err(OptionsError::NotHarmonic),
            false => Ok(kinds),
        }
    }

    fn named(&self, name: &str) -> Result<Vec<TriedKind>, OptionsError> {
        Ok(match name {
            NO_CORRECTION => vec![TriedKind::NoCorrection],
            "bernstein" => vec![TriedKind::Bernstein],
            SYMMETRIC => vec![TriedKind::Symmetric],
            "kriging" => vec![TriedKind::Kriging],
            "harmonic" => {
                let known = BUILT_IN.iter().filter_map(|name| Generator::built_in(name));
                let all =
                    || known.map(GeneratorChoice::Known).chain([GeneratorChoice::Learned(None)]);
                let generators = self.generators.map_or_else(|| all().collect(), <[_]>::to_vec);
                let of = |generator| TriedKind::Harmonic {
                    generator,
                    degrees: self.degree.map_or_else(|| TRIED_DEGREES.collect(), |d| vec![d]),
                    loss: self.loss,
                };
                generators.into_iter().map(of).collect()
            }
            _ => return Err(OptionsError::Name(name.to_owned())),
        })
    }
}

/// Names of the kinds that such samples can be fitted with: those that others are held against come first.
fn possible(samples: &SampleSet, map: MapKind) -> Vec<&'static str> {
    let has_fields = samples.has_rotations && map == MapKind::Distortion;
    let is_possible = |name: &&str| match *name {
        "harmonic" => has_fields,
        SYMMETRIC => samples.has_rotations,
        _ => true,
    };
    TriedKind::NAMES.into_iter().filter(is_possible).collect()
}

impl TriedKind {
    /// How a person names kinds.
    pub const NAMES: [&str; 5] = [NO_CORRECTION, "bernstein", "harmonic", "kriging", SYMMETRIC];

    /// All kinds that such samples can be fitted with.
    pub fn all(samples: &SampleSet, map: MapKind) -> Vec<Self> {
        // Every name of the list is one.
        TriedOptions::default().kinds(samples, map).unwrap_or_default()
    }
}
