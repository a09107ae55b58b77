//! The kinds of models that the workspace offers.

use trackwright_calibration::kind_choice::{TriedKind, Wanted};
use trackwright_calibration::room_model::{GeneratorChoice, HarmonicOrder, RoomModel};
use trackwright_field::generator::{BUILT_IN, Generator};
use trackwright_field::harmonic::Loss;
use trackwright_field::samples::{MapKind, SampleSet};

/// A kind of model, and what only that kind has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FieldKind {
    /// The best of all on rows held out.
    #[default]
    Best,
    /// Bernstein polynomials per basis orientation.
    Polynomials,
    /// The same with an axis and the one turned round having the same error.
    SymmetricPolynomials,
    Kriging,
    Harmonic(GeneratorName),
}

/// Where a harmonic model's generator comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GeneratorName {
    /// One of [`BUILT_IN`].
    BuiltIn(&'static str),
    /// Learned from the measurements.
    Learned,
}

impl FieldKind {
    /// All of them, as the panel lists them.
    pub fn all() -> Vec<Self> {
        let known = BUILT_IN.map(GeneratorName::BuiltIn).into_iter();
        let generators = known.chain([GeneratorName::Learned]);
        [Self::Best, Self::Polynomials, Self::SymmetricPolynomials, Self::Kriging]
            .into_iter()
            .chain(generators.map(Self::Harmonic))
            .collect()
    }

    pub fn label(self) -> String {
        match self {
            Self::Best => "best of all kinds".to_owned(),
            Self::Polynomials => "polynomials".to_owned(),
            Self::SymmetricPolynomials => "polynomials, symmetric".to_owned(),
            Self::Kriging => "kriging".to_owned(),
            Self::Harmonic(GeneratorName::BuiltIn(name)) => format!("harmonic, {name}"),
            Self::Harmonic(GeneratorName::Learned) => "harmonic, learned".to_owned(),
        }
    }

    /// Whether it has an order, orientations and a ridge.
    pub fn is_polynomial(self) -> bool {
        matches!(self, Self::Polynomials | Self::SymmetricPolynomials)
    }

    /// What is fitted to some samples; the degree of a harmonic model follows from the number of measurements
    /// where there is none. `None` for a generator that is not built in.
    pub fn wanted(
        self,
        samples: &SampleSet,
        map: MapKind,
        degree: Option<usize>,
    ) -> Option<Wanted> {
        Some(Wanted::One(match self {
            Self::Best => return Some(Wanted::Best(TriedKind::all(samples, map))),
            Self::Polynomials => RoomModel::PAPER,
            Self::SymmetricPolynomials => RoomModel::Bernstein { is_symmetric: true },
            Self::Kriging => RoomModel::Kriging,
            Self::Harmonic(generator) => RoomModel::Harmonic(HarmonicOrder {
                generator: match generator {
                    GeneratorName::Learned => GeneratorChoice::Learned(None),
                    GeneratorName::BuiltIn(name) => {
                        GeneratorChoice::Known(Generator::built_in(name)?)
                    }
                },
                degree,
                ridge: None,
                loss: Loss::Huber,
            }),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_a_model_and_a_label_of_its_own() {
        let all = FieldKind::all();
        assert_eq!(all.len(), 5 + BUILT_IN.len());
        let mut labels: Vec<_> = all.iter().map(|kind| kind.label()).collect();
        labels.sort_unstable();
        labels.dedup();
        assert_eq!(labels.len(), all.len());
        let samples = SampleSet { samples: Vec::new(), has_rotations: true, ambiguous: 0 };
        for kind in all {
            let wanted = kind.wanted(&samples, MapKind::Distortion, Some(4)).unwrap();
            let is_one = matches!(wanted, Wanted::One(RoomModel::Bernstein { .. }));
            assert_eq!(kind.is_polynomial(), is_one);
        }
    }
}
