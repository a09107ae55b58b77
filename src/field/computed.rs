//! Models of a room that are no polynomials: what computes the field, and the compiled form that
//! everything else evaluates.

use super::compiled::CompiledField;
use super::gaussian::Kriging;
use super::harmonic::HarmonicModel;
use crate::geometry::bounds::Bounds;
use std::sync::OnceLock;

/// What computes a field.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldSource {
    Kriging(Kriging),
    Harmonic(HarmonicModel),
    /// Nothing but the compiled form is known, as of the field of one axis.
    Compiled(CompiledField),
}

/// A field that is compiled when it is first asked for.
#[derive(Clone, Debug)]
pub struct ComputedField {
    source: FieldSource,
    bounds: Bounds,
    compiled: OnceLock<CompiledField>,
}

impl ComputedField {
    pub fn new(source: FieldSource, bounds: Bounds) -> Self {
        Self {
            source,
            bounds,
            compiled: OnceLock::new(),
        }
    }

    pub fn source(&self) -> &FieldSource {
        &self.source
    }

    /// The compiled form over the box.
    pub fn compiled(&self) -> &CompiledField {
        match &self.source {
            FieldSource::Compiled(field) => field,
            FieldSource::Kriging(kriging) => {
                self.compiled.get_or_init(|| kriging.compiled(&self.bounds))
            }
            FieldSource::Harmonic(model) => {
                self.compiled.get_or_init(|| model.compiled(&self.bounds))
            }
        }
    }
}

impl PartialEq for ComputedField {
    fn eq(&self, other: &Self) -> bool {
        self.source == other.source && self.bounds == other.bounds
    }
}

/// What kind of model a room has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ModelKind {
    /// Bernstein polynomials per basis orientation.
    #[default]
    Bernstein,
    /// The mean of a Gaussian process.
    Kriging,
    /// The fields of a generator's coils, disturbed by harmonic functions.
    Harmonic,
}

impl ModelKind {
    pub const ALL: [Self; 3] = [Self::Bernstein, Self::Kriging, Self::Harmonic];

    /// As it is written in commands and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bernstein => "bernstein",
            Self::Kriging => "kriging",
            Self::Harmonic => "harmonic",
        }
    }
}
