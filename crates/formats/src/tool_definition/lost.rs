//! What a body has and the file it is written to cannot hold.

use super::DefinitionKind;
use nalgebra::Point3;

/// One thing that is not in the file that was written.
#[derive(Clone, Debug, PartialEq)]
pub enum Lost {
    /// A ROM has no tip: it stands for the origin, or is found by a pivot calibration.
    Tip {
        tip_in_body: Point3<f64>,
    },
    Mesh {
        file: String,
    },
    /// Longer than the part number, or not ASCII; or no number where only one is kept.
    BodyName {
        name: String,
        kept: String,
    },
    /// Markers and coils have numbers.
    SensorNames {
        count: usize,
        first: String,
    },
    /// Diameters and lengths.
    CoilSizes {
        count: usize,
    },
    /// Of 5-DOF sensors, in a format of markers.
    Axes {
        count: usize,
    },
    /// Of 6-DOF sensors, in a format of markers.
    Rotations {
        count: usize,
    },
    /// Numbers of seven digits are that far off.
    Digits {
        greatest_mm: f64,
    },
    /// What else a definition says that the body carries, item by item.
    Definition {
        kind: DefinitionKind,
        what: Vec<String>,
    },
    /// Of a text that is written anew.
    Comments,
}

impl Lost {
    /// Its name for a program.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Tip { .. } => "tip",
            Self::Mesh { .. } => "mesh",
            Self::BodyName { .. } => "body_name",
            Self::SensorNames { .. } => "sensor_names",
            Self::CoilSizes { .. } => "coil_sizes",
            Self::Axes { .. } => "axes",
            Self::Rotations { .. } => "rotations",
            Self::Digits { .. } => "digits",
            Self::Definition { .. } => "definition",
            Self::Comments => "comments",
        }
    }
}

impl std::fmt::Display for Lost {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Tip { tip_in_body: tip } => {
                write!(f, "the tip ({} {} {} mm): a ROM's own is its origin", tip.x, tip.y, tip.z)
            }
            Self::Mesh { file } => write!(f, "the mesh {file}"),
            Self::BodyName { name, kept } => write!(f, "the name {name:?}: the file says {kept:?}"),
            Self::SensorNames { count: 1, first } => {
                write!(f, "the name of a sensor, {first:?}: it has a number")
            }
            Self::SensorNames { count, first } => {
                write!(f, "the names of {count} sensors, {first:?} the first: they have numbers")
            }
            Self::CoilSizes { count } => write!(f, "the coil sizes of {}", sensors(*count)),
            Self::Axes { count } => {
                write!(f, "the axes of {}: they are markers there", sensors(*count))
            }
            Self::Rotations { count } => {
                write!(f, "the rotations of {}: they are markers there", sensors(*count))
            }
            Self::Digits { greatest_mm } => write!(
                f,
                "digits: positions are up to {greatest_mm:.1e} mm off, as the file keeps seven"
            ),
            Self::Definition { kind, what } => {
                write!(f, "what else {} says: {}", kind.name(), what.join(", "))
            }
            Self::Comments => write!(f, "comments: the text is written anew"),
        }
    }
}

fn sensors(count: usize) -> String {
    match count {
        1 => "one sensor".to_owned(),
        _ => format!("{count} sensors"),
    }
}
