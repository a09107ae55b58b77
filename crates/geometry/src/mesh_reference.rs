//! Which mesh a body has: the file that holds it, and how long one of that file's units is.

use super::limits::{length_above_zero_problem, short};
use serde::Deserialize;

/// A mesh's file and the unit of its numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshReference {
    /// The file as written in the body's file, relative to that.
    pub file: String,
    /// `None` leaves it to the file's format: metres for glTF, millimetres for STL and OBJ, which
    /// have no unit of their own.
    pub unit: Option<MeshUnit>,
}

/// How long one unit of a mesh file is. It overrides the format's unit, for a glTF file with
/// millimetres in it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub enum MeshUnit {
    Millimetre,
    Centimetre,
    Metre,
    Inch,
    /// Any other length, in millimetres.
    Factor(f64),
}

impl MeshReference {
    /// A mesh in the unit of its format.
    pub fn new(file: impl Into<String>) -> Self {
        Self { file: file.into(), unit: None }
    }
}

impl MeshUnit {
    /// The units that have a name.
    pub const NAMED: [Self; 4] = [Self::Millimetre, Self::Centimetre, Self::Metre, Self::Inch];

    /// Length of one unit of the file.
    pub fn mm_per_unit(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Centimetre => 10.0,
            Self::Metre => 1000.0,
            Self::Inch => 25.4,
            Self::Factor(mm_per_unit) => mm_per_unit,
        }
    }

    /// The unit of that length, by its name if it has one.
    pub fn of_mm(mm_per_unit: f64) -> Self {
        Self::NAMED
            .into_iter()
            .find(|unit| unit.mm_per_unit() == mm_per_unit)
            .unwrap_or(Self::Factor(mm_per_unit))
    }

    /// What was expected of a unit that positions cannot be multiplied by; `None` where they can.
    pub fn problem(self) -> Option<&'static str> {
        length_above_zero_problem(self.mm_per_unit())
    }
}

impl std::fmt::Display for MeshUnit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Millimetre => f.write_str("mm"),
            Self::Centimetre => f.write_str("cm"),
            Self::Metre => f.write_str("m"),
            Self::Inch => f.write_str("inch"),
            Self::Factor(mm_per_unit) => write!(f, "{} mm", short(*mm_per_unit)),
        }
    }
}
